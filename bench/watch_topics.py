"""Subscribe to topics and drop the messages, with as little work as possible."""
import os
import sys

import raw_topics


def main() -> int:
    """Read the TOPICS given as arguments, until they end."""
    with raw_topics.Readers(sys.argv[1:], os.environ['ROS_MASTER_URI']) as readers:
        readers.wait()
    return 0


if __name__ == '__main__':
    sys.exit(main())
