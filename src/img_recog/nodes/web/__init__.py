"""The node web: a page that shows the running system and drives the robot."""
