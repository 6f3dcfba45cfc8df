"""The noise of sensors, as SDF's <noise> gives it."""
import xml.etree.ElementTree as ElementTree
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from img_recog.formats.reader import text_of, value

_GROUPS = {'rate': 'angular_velocity', 'accel': 'linear_acceleration'}
_QUANTIZED = 'gaussian_quantized'


class Noise(NamedTuple):
    """What is added to a value, in its unit.

    mean, deviation: of what is new in each reading; bias, bias_deviation: of what is drawn once,
    and gets a random sign; precision: to whose multiples the sum is rounded, 0 for none.
    """

    mean: float = 0.0
    deviation: float = 0.0
    bias: float = 0.0
    bias_deviation: float = 0.0
    precision: float = 0.0

    def offset(self, random: np.random.RandomState) -> float:
        """Return what is added to all readings."""
        if not (self.bias or self.bias_deviation):
            return self.mean
        return self.mean + random.choice((-1, 1)) * random.normal(self.bias, self.bias_deviation)

    def rounded(self, values: Any) -> Any:
        """Return values with their noise as they are read."""
        return np.round(values / self.precision) * self.precision if self.precision else values


def read(noise: Optional[ElementTree.Element], name: str) -> Noise:
    """Return what a <noise> says; name: what it is called in messages.

    Raises SimulationError when a number cannot be read.
    """
    kind = '' if noise is None else noise.get('type') or text_of(noise, 'type') or 'gaussian'
    if noise is None or kind not in ('gaussian', _QUANTIZED):
        return Noise()
    tags = ('mean', 'stddev', 'bias_mean', 'bias_stddev') + ('precision',) * (kind == _QUANTIZED)
    return Noise(*(value(noise, tag, name) for tag in tags))


def of_imu(imu: ElementTree.Element, name: str) -> Optional[Tuple[Noise, ...]]:
    """Return the noises of the angular velocities and of the accelerations, x, y, z each.

    None if it has no noise; name: of the <imu>, for messages. Errors as for `read`.
    """
    paths = ['{}/{}/noise'.format(group, axis) for group in _GROUPS.values() for axis in 'xyz']
    found = tuple(read(imu.find(path), '{} of {}'.format(path, name)) for path in paths)
    return found if any(map(any, found)) else None


def use_axes(imu: ElementTree.Element) -> None:
    """Give each axis of an <imu> of SDF 1.5 or before the noise that it has for all of them."""
    old = imu.find('noise')
    if old is None:
        return
    imu.remove(old)
    for tag, group in _GROUPS.items():
        if old.find(tag) is None or imu.find(group) is not None:
            continue
        parent = ElementTree.SubElement(imu, group)
        for axis in 'xyz':
            noise = ElementTree.SubElement(ElementTree.SubElement(parent, axis), 'noise', {
                'type': text_of(old, 'type') or 'gaussian'})
            noise.extend(old.findall(tag + '/*'))
