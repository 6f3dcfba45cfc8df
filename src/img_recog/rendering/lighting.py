"""The lights and the fog of a scene, as the programs get them."""
import math
from typing import Sequence, Tuple

import moderngl
import numpy as np

from img_recog.model import DIRECTIONAL, EXP, EXP2, LINEAR, SPOT, Fog, Light, Surroundings
from img_recog.rendering import matrices
from img_recog.rendering.shaders import MAX_LIGHTS

_STEEP = 1e6            # the slope of the edge of a cone that is sharp
_EVERYWHERE = -2.0, 1.0, 0.0        # a cone of a light without one
_EXPONENTS = {LINEAR: 0.0, EXP: 1.0, EXP2: 2.0}


class Lighting:
    """Writes lights and fog to programs.

    are_directions: whether all lights are directional; have_highlights: whether some are seen in
    what shines; problem: a line if there are more than can be drawn, else ''.
    """

    def __init__(self, lights: Sequence[Tuple[int, Light]], surroundings: Surroundings):
        """lights: each with the number of its part, -1 for the world."""
        self.problem = '' if len(lights) <= MAX_LIGHTS else (
            '{} of {} lights'.format(len(lights) - MAX_LIGHTS, len(lights)))
        lights = lights[:MAX_LIGHTS]
        self._parts = np.array([part for part, _ in lights], int)
        self._lights = [light for _, light in lights]
        self._surroundings = surroundings
        self.are_directions = all(light.kind == DIRECTIONAL for light in self._lights)
        self.have_highlights = any(max(light.specular) > 0 for light in self._lights)
        self._poses = np.array([light.pose.matrix() for light in self._lights]).reshape(-1, 4, 4)
        directions = np.array([light.direction for light in self._lights]).reshape(-1, 3)
        self._directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self._constant = {
            'lamp': [light.diffuse for light in self._lights],
            'lamp_specular': [light.specular for light in self._lights],
            'fading': [(*light.attenuation, light.reach) for light in self._lights],
            'cone': [_cone(light) for light in self._lights]}

    def write(self, programs: Sequence[moderngl.Program], models: np.ndarray) -> None:
        """Write all; models (n, 4, 4): the transforms of the parts to the world."""
        poses = matrices.of_parts(models, self._parts) @ self._poses
        axes = (poses[:, :3, :3] @ self._directions[..., np.newaxis])[..., 0]
        is_direction = np.array([light.kind == DIRECTIONAL for light in self._lights], bool)
        places = np.where(is_direction[:, np.newaxis], -axes, poses[:, :3, 3])
        values = {**self._constant, 'axis': axes,
                  'place': np.column_stack([places, ~is_direction])}
        for program in programs:
            if 'light_count' in program:
                program['light_count'].value = len(self._lights)
            for name, rows in values.items():
                if name in program and len(rows):
                    array = np.zeros((MAX_LIGHTS, np.shape(rows)[1]), 'f4')
                    array[:len(rows)] = rows
                    program[name].write(array.tobytes())
            if self._surroundings.fog is not None:
                program['fog'].value = _numbers(self._surroundings.fog)
                program['fog_color'].value = self._surroundings.fog.color


def _cone(light: Light) -> Tuple[float, float, float]:
    """Return the cosine at the edge, the slope from there inward, and the exponent."""
    if light.kind != SPOT:
        return _EVERYWHERE
    bright, dark = (math.cos(angle / 2) for angle in light.cone[:2])
    return dark, 1 / (bright - dark) if bright - dark > 1 / _STEEP else _STEEP, light.cone[2]


def _numbers(fog: Fog) -> Tuple[float, float, float, float]:
    length = fog.end - fog.start
    return (fog.end, 1 / length if length else _STEEP, fog.density, _EXPONENTS[fog.kind])
