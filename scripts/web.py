#!/usr/bin/env python3
"""Start the node web: a page that shows the system and drives the robot."""
import os
import sys

from img_recog.processes.script import start

NICENESS = 5

if __name__ == '__main__':
    # the nodes that the robot needs come first, also while this one loads its modules for 2 s
    os.nice(NICENESS)
    try:
        start('img_recog.nodes.web.web_node')
    except ImportError as error:
        sys.exit('[FATAL] web: {}; ./run setup installs what requirements.txt lists, or set '
                 'web:=false'.format(error))
