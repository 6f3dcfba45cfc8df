"""Color recognition: images to areas to commands. Independent of ROS."""
