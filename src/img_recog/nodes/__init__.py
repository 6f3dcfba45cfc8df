"""The ROS nodes, a folder each; nothing here is shared by two of them but color_parameters."""
