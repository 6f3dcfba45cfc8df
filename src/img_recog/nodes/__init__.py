"""The ROS nodes, one folder each; the only module that two of them share is compressed_images."""
