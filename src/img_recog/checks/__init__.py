"""The programs check_robot.py and check_world.py: whether a file can be simulated, and how."""
