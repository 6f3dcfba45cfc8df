#!/usr/bin/env python3
"""color_extract on a machine that needs 200 ms more for a frame."""
import sys
import time

from img_recog.nodes.color_extract.node import ColorExtract
from img_recog.ros import lifecycle

EXTRA_S = 0.2


class SlowColorExtract(ColorExtract):
    """Handles each frame late."""

    def handle(self, msg):
        time.sleep(EXTRA_S)
        super().handle(msg)


if __name__ == '__main__':
    sys.exit(lifecycle.run('color_extract', lambda: SlowColorExtract().spin()))
