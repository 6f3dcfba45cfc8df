"""The graph of a running system, like that of rqt_graph. Uses rosgraph, never rospy."""
