"""The ROS nodes: parameters, message conversions and one module a node."""
