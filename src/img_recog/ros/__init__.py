"""rospy as it is documented: starting and ending a node, parameters, queues between threads."""
