"""The processes that a program starts, and its own signals; without ROS."""
