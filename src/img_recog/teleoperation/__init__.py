"""Keyboard teleoperation: keys of a terminal to velocity commands. Independent of ROS."""
