"""What draws in place of OpenGL; a process that draws imports it from here."""
import os
import time

import numpy as np

from img_recog.errors import UserError

DIE, HANG, REFUSE = -1.0, -2.0, -3.0    # x of a camera, of which no image is drawn


class FakeRenderer:
    """Draws numbers, and counts.

    Red is x of the first part, green x of the camera, blue that of the background; a depth is the
    number of images before.
    """

    def load(self, scene, poses):
        self.images, self._blue = 0, round(255 * scene.surroundings.background[2])
        return ['no mesh of {}'.format(part) for part in range(1, len(scene.moving))]

    def draw(self, camera, pose, poses, ceiling):
        x = pose[0, 3]
        if x == DIE:
            os._exit(1)
        if x == HANG:
            time.sleep(1000)
        if x == REFUSE:
            raise UserError('no memory', 'buy some')
        self.images += 1
        color = round(poses[0, 0]), round(x), self._blue
        return np.full((camera.height, camera.width, 3), color, np.uint8)

    def depth(self, camera, pose, poses):
        return np.full((camera.height, camera.width), self.images - 1, np.float32)


def make():
    return FakeRenderer()


def refuse():
    raise UserError('no mesh a.stl', 'give one')


def hang():
    time.sleep(1000)
