#!/usr/bin/env python3
"""color_extract with an additional delay of 200 ms for each frame."""
import sys
import time

from img_recog.nodes.color_extract.color_extract_node import ColorExtract
from img_recog.ros import lifecycle

DELAY_S = 0.2


class SlowColorExtract(ColorExtract):
    """Delays each frame."""

    def handle(self, msg):
        time.sleep(DELAY_S)
        super().handle(msg)


if __name__ == '__main__':
    sys.exit(lifecycle.run('color_extract', lambda: SlowColorExtract().spin()))
