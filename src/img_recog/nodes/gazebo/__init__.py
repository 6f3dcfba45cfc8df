"""The node gazebo."""
