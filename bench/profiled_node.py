"""Run color_extract, and measure the CPU time of the parts of a frame.

The first argument is a file, to which one line of JSON is appended for each frame when the node
ends: the CPU time of each part and of the process so far, and when the image was complete, s.
"""
import json
import sys
import threading
import time
from collections import defaultdict
from typing import Any, DefaultDict, List

import cv2

from img_recog.nodes.color_extract import node
from img_recog.nodes.color_extract.node import ColorExtract
from img_recog.recognition.masks import Masks
from img_recog.ros.transport import image_publisher, image_subscriber
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog.ros.transport.rosout import RecurringLine

# where the parts are: name of the part, owner and name of the function
PARTS = (
    ('receive', image_subscriber, '_fill'), ('message', image_subscriber, '_image'),
    ('convert', cv2, 'cvtColor'), ('masks', Masks, 'compute'), ('log', RecurringLine, 'write'),
    ('commands', ColorExtract, '_publish_commands'), ('images', ImagePublisher, 'publish_drawn'),
    ('send', image_publisher.Outboxes, 'put'))


class Profile:
    """Accumulates CPU time; what a part calls in another part is only counted there."""

    def __init__(self):
        self.frames: List[dict] = []
        self._seconds: DefaultDict[str, float] = defaultdict(float)
        self._lock = threading.Lock()
        self._local = threading.local()
        self._complete_s = 0.0

    def measure(self, part: str, owner: Any, name: str) -> None:
        """Replace a function by one that measures itself."""
        function = getattr(owner, name)

        def measured(*args, **kwargs):
            inner = self._local.__dict__.setdefault('inner', [0.0])
            inner.append(0.0)
            begin_s = time.thread_time()
            try:
                return function(*args, **kwargs)
            finally:
                total_s = time.thread_time() - begin_s
                with self._lock:
                    self._seconds[part] += total_s - inner.pop()
                inner[-1] += total_s
        setattr(owner, name, measured)

    def follow_frames(self) -> None:
        """Record each frame from now on."""
        deliver, handle = ImageSubscriber._deliver, ColorExtract.handle

        def delivered(*args):
            self._complete_s = time.perf_counter()
            deliver(*args)

        def handled(*args):
            handle(*args)
            with self._lock:
                self.frames.append(dict(self._seconds, process=time.process_time(),
                                        complete=self._complete_s))
        ImageSubscriber._deliver, ColorExtract.handle = delivered, handled


def main() -> int:
    """Run the node; return its exit code."""
    path, profile = sys.argv.pop(1), Profile()
    for part in PARTS:
        profile.measure(*part)
    profile.follow_frames()
    try:
        return node.main()
    finally:
        with open(path, 'w') as file:
            for frame in profile.frames:
                file.write(json.dumps(frame) + '\n')


if __name__ == '__main__':
    sys.exit(main())
