"""The graph of nodes and topics of a running system, like rqt_graph; with rosgraph, never rospy."""
