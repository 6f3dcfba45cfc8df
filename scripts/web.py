#!/usr/bin/env python3
"""Start the node web: a page that shows the system and drives the robot."""
import gc
import os
import signal
import sys

NICENESS = 5


def main():
    """Run the node; return its exit code."""
    gc.disable()        # a tenth of the start: modules that load leave no garbage
    try:
        from img_recog.nodes.web.web_node import main as run
    except ImportError as error:
        sys.stderr.write('[FATAL] web: {}; ./run setup installs what requirements.txt lists, or '
                         'set web:=false\n'.format(error))
        return 1
    gc.enable()
    return run()


if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)    # no traceback of a Ctrl-C while modules load
    # the nodes that the robot needs come first, also while this one loads its modules for 2 s
    os.nice(NICENESS)
    sys.exit(main())
