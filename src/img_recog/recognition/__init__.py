"""Color ranges to areas and masked images, areas to commands; knows no ROS."""
