#!/usr/bin/env python3
"""Writes a list of four robots, their images and their colors to a folder.

Usage: robots_list.py FOLDER, from a launch file: before it starts the nodes.
"""
import os
import sys

import cv2
import numpy as np

LIST = '''\
- {name: tb3_0, x_pos: -1.0, y_pos: -2.0, camera: FOLDER/blue.png, colors: slow.yaml}
# it stands, and looks at the one before
- {name: tb3_1, x_pos: 0.0, y_pos: -2.0, yaw: 3.14159, camera: FOLDER/black.png}
- {name: tb3_2, x_pos: -1.0, y_pos: 1.5, camera: FOLDER/red.png, colors: to_red.yaml}
# a blue post stands ahead of it
- {name: tb3_3, x_pos: -0.75, y_pos: -0.15, camera: robot, colors: slow.yaml}
'''
FILES = {'robots.yaml': LIST,
         'slow.yaml': 'blue_linear_x: 0.2\nred_linear_x: -0.2\n',
         'to_red.yaml': 'blue_linear_x: -0.1\nred_linear_x: 0.1\n'}
IMAGES = {'blue': (255, 0, 0), 'red': (80, 0, 255), 'black': (0, 0, 0)}      # BGR


def main(folder):
    """Write the files."""
    os.makedirs(folder, exist_ok=True)
    for name, text in FILES.items():
        with open(os.path.join(folder, name), 'w') as file:
            file.write(text.replace('FOLDER', folder))
    for name, color in IMAGES.items():
        image = np.full((48, 64, 3), color, np.uint8)
        assert cv2.imwrite(os.path.join(folder, name + '.png'), image)


if __name__ == '__main__':
    main(sys.argv[1])
