"""A sonar or an infrared range finder: the nearest of what its rays hit."""
from dataclasses import dataclass

import numpy as np

from img_recog.formats.gazebo_tags import EACH_STEP, NAME, NUMBER, RATE, TOPIC, Row, Tags, choice
from img_recog.settings import (Settings, above, any_value, at_least, between, not_empty, one_of,
                                setting)
from img_recog.simulation.sensors import ray_sensor
from img_recog.simulation.sensors.ray_sensor import FanSensor
from img_recog.simulation.sensors.sensor import Mount

INFRARED, ULTRASOUND = 'infrared', 'ultrasound'

# of libgazebo_ros_range of gazebo_plugins and libhector_gazebo_ros_sonar, with their defaults
TAGS = Tags(('gazebo_ros_range', 'hector_gazebo_ros_sonar'), (
    *ray_sensor.fan_rows('range', 'range'),
    Row('range_period_s', RATE, 'plugin', 'updateRate'),
    Row('range_noise', NUMBER, 'plugin', 'gaussianNoise'),
    Row('range_field_of_view', NUMBER, 'plugin', 'fov'),
    Row('range_radiation', choice('ultrasound or infrared', {
        INFRARED: INFRARED, ULTRASOUND: ULTRASOUND}), 'plugin', 'radiation'),
    Row('range_frame', NAME, 'plugin', 'frameName', 'frameId'),
    Row('range_topic', TOPIC, 'plugin', 'topicName')),
    sensors=('ray',), frame='range_frame', needs_sensor=True,
    not_simulated=ray_sensor.sees_nothing, defaults={
        'range': {'range_period_s': EACH_STEP},
        'hector': {'range_period_s': EACH_STEP, 'range_radiation': ULTRASOUND,
                   'range_field_of_view': 0.0, 'range_topic': 'sonar'}})


@dataclass(frozen=True)
class RangeSettings(Settings):
    """A range finder with rows of rays.

    Angles in rad about z from the x axis of its place, and upward from the plane of x and y.
    range_min, range_max, and the standard deviation of the noise: m. range_field_of_view: rad, 0
    for that of the rays; only told in the messages, like range_radiation. range_period_s: a
    multiple of the physics step, in simulated s.
    """

    range_frame: str = setting('', any_value())
    range_period_s: float = setting(0.001, above(0))
    range_samples: int = setting(640, between(1, 100000))
    range_angle_min: float = setting(0.0, any_value())
    range_angle_max: float = setting(0.0, any_value())
    range_rows: int = setting(1, between(1, 100000))
    range_pitch_min: float = setting(0.0, any_value())
    range_pitch_max: float = setting(0.0, any_value())
    range_min: float = setting(0.0, at_least(0))
    range_max: float = setting(0.0, at_least(0))
    range_noise: float = setting(0.0, at_least(0))
    range_field_of_view: float = setting(0.05, at_least(0))
    range_radiation: str = setting(INFRARED, one_of(INFRARED, ULTRASOUND))
    range_topic: str = setting('range', not_empty())

    def field_of_view(self) -> float:
        """Return the field of view in rad; that of rays is the smaller of their two spans."""
        return self.range_field_of_view or min(abs(self.range_angle_max - self.range_angle_min),
                                               abs(self.range_pitch_max - self.range_pitch_min))


class RangeSensor(FanSensor):
    """Measures one distance in m; range_max where nothing is hit (GazeboRosRange)."""

    def __init__(self, mount: Mount, settings: RangeSettings):
        """Mount the sensor; errors as for FanSensor."""
        super().__init__(mount, settings, 'range', 'range')

    def measure(self, distances: np.ndarray) -> float:
        """Return the range of the nearest hit, with noise, within the allowed ranges."""
        settings = self._settings
        noise = self._noise.normal(0.0, settings.range_noise)
        nearest = float(distances.min())
        if nearest >= settings.range_max:
            return settings.range_max
        return min(max(nearest + noise, settings.range_min), settings.range_max)
