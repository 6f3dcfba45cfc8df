"""Subscribe to topics and drop the messages, with as little work as possible."""
import os
import selectors
import sys

import raw_topics

_BUFFER_BYTES = 1 << 20


def main() -> int:
    """Read the TOPICS given as arguments, until they end."""
    scratch = memoryview(bytearray(_BUFFER_BYTES))
    with selectors.DefaultSelector() as selector:
        for topic in sys.argv[1:]:
            selector.register(raw_topics.connect(topic, os.environ['ROS_MASTER_URI']),
                              selectors.EVENT_READ)
        while selector.get_map():
            for key, _ in selector.select():
                if not key.fileobj.recv_into(scratch):
                    selector.unregister(key.fileobj)
    return 0


if __name__ == '__main__':
    sys.exit(main())
