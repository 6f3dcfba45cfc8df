"""Frame sources, their pacing and their calibration; knows no ROS."""
