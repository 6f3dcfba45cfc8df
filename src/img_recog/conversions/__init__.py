"""ROS messages to plain values and back; needs the message packages, but not rospy."""
