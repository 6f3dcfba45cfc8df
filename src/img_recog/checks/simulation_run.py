"""A world and a robot simulated as fast as it goes: lines of JSON of where everything is."""
import json
import math
import os
import re
import zlib
from typing import Any, Dict, Iterator, Tuple

import cv2

from img_recog.conversions.robot_cameras import DrawnCamera, Drawing
from img_recog.errors import UserError
from img_recog.loading import assemble
from img_recog.report import NOT_DRAWN
from img_recog.simulation.models import Figures, Models
from img_recog.simulation.simulated_model import MountedSensors
from img_recog.simulation.simulation_settings import PhysicsSettings, SpawnSettings

_PRINTED = ('imu', 'range', 'scan')         # kinds of sensors


class SimulationRun:
    """A simulation of a world, built as in the node.

    Attributes:
        report: What is not done as the files ask; more comes while it is simulated, as of what
            flies away.
    """

    def __init__(self, given: Any):
        """Build it and start the motors; raise a UserError if it cannot be built.

        given: what check_jobs.simulate_parser parses.
        """
        self._given = given
        robots = [assemble.robot(given.urdf, '--urdf').changed(
            spawn=SpawnSettings(x_pos=0.0, y_pos=0.0))] if given.urdf else []
        # without a command they stand as in a Gazebo without ROS: nothing holds their wheels
        self._simulator = assemble.simulator(
            PhysicsSettings(world=given.world, allow_partial_world=True), robots,
            with_sensors=True, with_bare=True, with_drives=bool(given.twist and not given.urdf))
        self.report = self._simulator.world.report
        self._figures = Figures(self._simulator)
        self._readings: Dict[Tuple[str, str], Any] = {}
        models = Models(self._simulator)
        for name, numbers in given.velocity:
            models.set_state(name, models.state(name)._replace(
                linear=numbers[:3], angular=numbers[3:] or [0.0] * 3))
        if given.twist:
            if not self._simulator.robots:
                raise UserError('--twist: there is no robot', 'set --urdf, or give a model of the '
                                'world the plugin of a drive')
            self._simulator.robots[0].command(*given.twist)
        for joint, numbers in given.drive:
            self._figures.set_motor(joint, *numbers)

    def lines(self) -> Iterator[Dict[str, Any]]:
        """Simulate; yield a line for each time, and at the end those of sensors and masses."""
        step_s = self._simulator.world.step_s
        every = max(1, round(self._given.every / step_s))
        end = round(self._given.until / step_s)
        yield self._line()
        while self._simulator.steps < end:
            steps = min(every, end - self._simulator.steps)
            for reading in self._simulator.advance(steps):
                self._readings[reading.robot, reading.sensor] = reading.value
            if steps == every:
                yield self._line()
        for mounted in self._simulator.sensors:
            yield from self._of_sensors(mounted)
        if self._given.pictures:
            self._draw(self._given.pictures)
        yield {'end': True, 'mass': self._figures.masses()}

    def _line(self) -> Dict[str, Any]:
        return {'t': round(self._simulator.time_s, 9), 'links': self._figures.links(),
                'joints': self._figures.joints()}

    def _of_sensors(self, mounted: MountedSensors) -> Iterator[Dict[str, Any]]:
        """Yield lines with the names that Gazebo has for sensors."""
        rays = mounted.measure()        # now: Gazebo's recorder casts them at the end, too
        for each in mounted.spec.sensors:
            value = rays.get(each.name, self._readings.get((mounted.body.name, each.name)))
            if each.kind.name not in _PRINTED or value is None:
                continue
            name = each.label or each.name
            if each.kind.name == 'imu':
                yield {'imu': name, 'acc': list(value.linear_acceleration),
                       'gyro': list(value.angular_velocity)}
            else:
                yield {'gpuray' if each.type == 'gpu_ray' else 'ray': name,
                       'ranges': value.tolist() if each.kind.name == 'scan' else [value]}

    def _draw(self, folder: str) -> None:
        """Write a PNG of each camera."""
        drawing = Drawing(self._simulator)
        for line in drawing.missing:
            self.report.add(NOT_DRAWN, line)
        os.makedirs(folder, exist_ok=True)
        for mounted in self._simulator.sensors:
            names = {each.name: each.label for each in mounted.spec.sensors}
            for sensor, camera in mounted.cameras.items():
                camera.poses, name = drawing.poses, names[sensor]
                image = drawing.image(DrawnCamera(camera.settings), camera.read(),
                                      zlib.crc32(name.encode()))
                path = os.path.join(folder, re.sub('[^A-Za-z0-9_.-]+', '_', name) + '.png')
                if not cv2.imwrite(path, cv2.cvtColor(image, cv2.COLOR_RGB2BGR)):
                    raise UserError('cannot write ' + path, 'give --pictures another folder')


def text_of(line: Dict[str, Any]) -> str:
    """Return a line of JSON; numbers that JSON has not are 'inf', '-inf' and 'nan'.

    >>> text_of({'ranges': [1.25, math.inf]})
    '{"ranges":[1.25,"inf"]}'
    """
    return json.dumps(_plain(line), separators=(',', ':'), allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        return float('{:.9g}'.format(value)) if math.isfinite(value) else repr(value)
    return value
