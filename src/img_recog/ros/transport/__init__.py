"""Faster ways through the internals of rospy, which no other folder touches."""
