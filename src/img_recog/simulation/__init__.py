"""World, robot, drive and sensors on PyBullet; knows no ROS."""
