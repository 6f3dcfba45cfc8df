"""The patterns in place of Gazebo's textures."""
import os

import cv2
import numpy as np

from img_recog.rendering import patterns
from img_recog_testing.figures import assert_unchanged

NAMES = ('bricks', 'clouds', 'frame', 'gradient', 'grass', 'lane', 'lanes 2', 'lanes 4', 'lanes 6',
         'planks', 'plaster', 'quarters', 'steps', 'tiles', 'wood')


def test_patterns_are_as_they_were(tmp_path):
    images = [cv2.resize(patterns.image(name, (0.6, 0.5, 0.4, 1.0)), (96, 96),
                         interpolation=cv2.INTER_AREA) for name in NAMES]
    sheet = np.vstack([np.hstack(images[row:row + 5]) for row in range(0, len(images), 5)])
    assert_unchanged(sheet[:, :, ::-1], os.path.join(os.path.dirname(__file__), 'patterns.png'),
                     tmp_path)
