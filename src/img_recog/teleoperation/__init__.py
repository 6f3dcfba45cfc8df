"""Keys to target velocities, and the terminal that they come from; knows no ROS."""
