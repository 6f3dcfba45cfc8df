#!/usr/bin/env python3
"""Draw the nodes and topics of the running system to a file."""
from img_recog.processes.script import start

if __name__ == '__main__':
    start('img_recog.graph.graph_job')
