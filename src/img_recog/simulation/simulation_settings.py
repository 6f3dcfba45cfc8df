"""The settings of the simulator, and what the topics and frames in them are called."""
import math
import zlib
from dataclasses import dataclass, field, replace
from typing import Any, List, Mapping, NamedTuple, Optional, Tuple, TypeVar

from img_recog.camera_arguments import DRAWN_PIXELS, RATES
from img_recog.errors import SimulationError
from img_recog.formats import lenses
from img_recog.model import DIFFERENTIAL, PLANAR
from img_recog.settings import (Allowed, SettingError, Settings, above, any_value, at_least,
                                between, not_empty, one_of, setting)

REAL_TIME_FACTORS = Allowed('from 0.001 to 1000, or 0',
                            lambda value: value == 0 or 0.001 <= value <= 1000)
VIEWS = ('above', 'follow')
DEPTH_ENCODINGS = ('32FC1', '16UC1')
_PINHOLE = 'pinhole'
_MAX_SEED = 2 ** 31 - 1
_MAX_PINHOLE_FOV = 3.0      # rad
_Settings = TypeVar('_Settings')


@dataclass(frozen=True)
class PhysicsSettings(Settings):
    """Time and world.

    step_s: of the physics; clock_period_s: between two /clock messages, a multiple of step_s.
    real_time_factor: simulated seconds per second of wall time; 0 is as fast as possible.
    world: turtlebot3_world, color_posts, empty, the name of a world of turtlebot3_gazebo if that
    is found, or the path of a URDF or SDF file. allow_partial_world: whether a world of which
    something is not found is loaded without that.
    """

    step_s: float = setting(0.001, between(1e-5, 0.1))
    clock_period_s: float = setting(0.01, between(1e-5, 1))
    real_time_factor: float = setting(1.0, REAL_TIME_FACTORS)
    world: str = setting('turtlebot3_world', not_empty())
    allow_partial_world: bool = setting(False)


@dataclass(frozen=True)
class SpawnSettings(Settings):
    """Pose of the robot's root link at the start and after a reset: m, rad, in the world.

    A robot that would be in the floor is lifted onto it.
    """

    x_pos: float = setting(-2.0, between(-1000, 1000))
    y_pos: float = setting(-0.5, between(-1000, 1000))
    z_pos: float = setting(0.0, between(-1000, 1000))
    yaw: float = setting(0.0, between(-2 * math.pi, 2 * math.pi))


@dataclass(frozen=True)
class DriveSettings(Settings):
    """A drive (parameters and units of libgazebo_ros_diff_drive and diff_drive_controller).

    Numbers that nothing gives are those of libgazebo_ros_diff_drive.
    drive: differential has wheels on both sides, planar moves the base itself. left_joint,
    right_joint: of the wheels, with a comma between several on a side; a robot without any has no
    drive, unless that is planar. wheel_separation,
    wheel_diameter: m; the commands and the encoder count with multiples of them, by the
    multipliers. wheel_torque: N m per wheel. wheel_acceleration: m/s2 at the rim.
    drive_period_s: between two updates of the wheel speeds.
    max_linear_velocity to min_angular_acceleration: limits of commands in m/s, rad/s, m/s2 and
    rad/s2; 0 is no maximum (the real burger has 0.22 m/s and 2.84 rad/s), or as minimum the
    opposite of the maximum. cmd_vel_timeout: simulated s after which the robot stops unless
    another command arrives; 0 is never. command_topic: where they arrive; stamped_commands:
    whether as TwistStamped.
    """

    drive: str = setting(DIFFERENTIAL, one_of(DIFFERENTIAL, PLANAR))
    left_joint: str = setting('', any_value())
    right_joint: str = setting('', any_value())
    wheel_separation: float = setting(0.34, above(0))
    wheel_diameter: float = setting(0.15, above(0))
    wheel_separation_multiplier: float = setting(1.0, above(0))
    left_wheel_radius_multiplier: float = setting(1.0, above(0))
    right_wheel_radius_multiplier: float = setting(1.0, above(0))
    wheel_torque: float = setting(5.0, above(0))
    wheel_acceleration: float = setting(0.0, at_least(0))
    drive_period_s: float = setting(0.01, above(0))
    max_linear_velocity: float = setting(0.0, at_least(0))
    min_linear_velocity: float = setting(0.0, between(-1000, 0))
    max_angular_velocity: float = setting(0.0, at_least(0))
    min_angular_velocity: float = setting(0.0, between(-1000, 0))
    max_linear_acceleration: float = setting(0.0, at_least(0))
    min_linear_acceleration: float = setting(0.0, between(-1000, 0))
    max_angular_acceleration: float = setting(0.0, at_least(0))
    min_angular_acceleration: float = setting(0.0, between(-1000, 0))
    cmd_vel_timeout: float = setting(0.0, at_least(0))
    command_topic: str = setting('cmd_vel', not_empty())
    stamped_commands: bool = setting(False)

    @property
    def is_there(self) -> bool:
        """Whether anything is driven: the base itself, or joints of wheels."""
        return self.drive == PLANAR or bool(self.left_joint or self.right_joint)

    @property
    def left_joints(self) -> Tuple[str, ...]:
        """The names of the joints of the left wheels; none if the base itself is moved.

        >>> DriveSettings(left_joint='front, rear').left_joints
        ('front', 'rear')
        """
        return names_in(self.left_joint) if self.drive == DIFFERENTIAL else ()

    @property
    def right_joints(self) -> Tuple[str, ...]:
        """The names of the joints of the right wheels, as for the left ones."""
        return names_in(self.right_joint) if self.drive == DIFFERENTIAL else ()


def names_in(text: str) -> Tuple[str, ...]:
    """Return names that are given with commas between them."""
    return tuple(name.strip() for name in text.split(',') if name.strip())


@dataclass(frozen=True)
class NoiseSettings(Settings):
    """seed: of the random generators of all noise."""

    seed: int = setting(0, between(0, _MAX_SEED))

    def of(self, name: str) -> 'NoiseSettings':
        """Return settings whose noise is not that of other robots and models."""
        return NoiseSettings((self.seed + zlib.crc32(name.encode())) % _MAX_SEED)


@dataclass(frozen=True)
class CameraSettings(Settings):
    """A camera on a robot.

    camera_frame: the link that carries it, '' for no camera; camera_x to camera_yaw: its pose in
    that link, in m and rad; it looks along its x axis, with z upward in the image.
    camera_optical_frame: frame of the images (x to the right, z forward: REP 103). camera_width,
    camera_height: pixels. camera_horizontal_fov: rad, from edge to edge; that of the Raspberry Pi
    camera v2 is 62.2 degrees. camera_near, camera_far: m, what else is not seen. camera_rate: Hz.
    camera_noise, camera_noise_mean: the standard deviation and the mean of what is added to all
    colors of a pixel, which are from 0 to 1. camera_encoding: of the images.
    The topics of depth images may be empty: there are none then, and no point clouds.
    camera_points_min, camera_points_max: m, of what has a depth and a point.

    camera_lens: one of SDF's <lens><type>, or a pinhole, whose distortion is camera_k1 to
    camera_p2. camera_c1 to camera_fun: the function of a custom lens, radius = c1 f
    fun(angle / c2 + c3), in halves of the width. camera_scale_to_hfov: whether f is that of the
    field of view instead. camera_cutoff_angle: rad; what is at a larger angle is black.
    camera_env_texture_size: limits the sharpness, px in 90 degrees.
    camera_baseline: m, of the right one of a stereo pair, which P in the camera info says.
    """

    camera_frame: str = setting('', any_value())
    camera_x: float = setting(0.0, between(-100, 100))
    camera_y: float = setting(0.0, between(-100, 100))
    camera_z: float = setting(0.0, between(-100, 100))
    camera_roll: float = setting(0.0, any_value())
    camera_pitch: float = setting(0.0, any_value())
    camera_yaw: float = setting(0.0, any_value())
    camera_optical_frame: str = setting('camera_rgb_optical_frame', not_empty())
    camera_width: int = setting(640, DRAWN_PIXELS)
    camera_height: int = setting(480, DRAWN_PIXELS)
    camera_horizontal_fov: float = setting(1.085595, between(0.01, 6.2832))
    camera_near: float = setting(0.03, between(0.001, 100))
    camera_far: float = setting(100.0, between(0.01, 10000))
    camera_rate: float = setting(30.0, RATES)
    camera_noise: float = setting(0.0, between(0, 1))
    camera_noise_mean: float = setting(0.0, between(-1, 1))
    camera_encoding: str = setting('rgb8', one_of('rgb8', 'bgr8', 'mono8'))
    camera_image_topic: str = setting('camera/rgb/image_raw', not_empty())
    camera_info_topic: str = setting('camera/rgb/camera_info', not_empty())
    camera_depth_topic: str = setting('', any_value())
    camera_depth_info_topic: str = setting('', any_value())
    camera_depth_encoding: str = setting('32FC1', one_of(*DEPTH_ENCODINGS))
    camera_points_topic: str = setting('', any_value())
    camera_points_min: float = setting(0.0, at_least(0))
    camera_points_max: float = setting(10000.0, above(0))
    camera_baseline: float = setting(0.0, between(-100, 100))
    camera_lens: str = setting(_PINHOLE, one_of(_PINHOLE, *lenses.TYPES))
    camera_c1: float = setting(1.0, between(0.001, 1000))
    camera_c2: float = setting(1.0, between(0.001, 1000))
    camera_c3: float = setting(0.0, between(-10, 10))
    camera_f: float = setting(1.0, between(0.001, 1000))
    camera_fun: str = setting(lenses.TAN, one_of(*lenses.FUNCTIONS))
    camera_scale_to_hfov: bool = setting(True)
    camera_cutoff_angle: float = setting(math.pi / 2, above(0))
    camera_env_texture_size: int = setting(256, between(16, 4096))
    camera_k1: float = setting(0.0, between(-100, 100))
    camera_k2: float = setting(0.0, between(-100, 100))
    camera_k3: float = setting(0.0, between(-100, 100))
    camera_p1: float = setting(0.0, between(-100, 100))
    camera_p2: float = setting(0.0, between(-100, 100))

    def __post_init__(self):
        super().__post_init__()
        if self.camera_near >= self.camera_far:
            raise SettingError('camera_near', self.camera_near,
                               'less than camera_far, which is {}'.format(self.camera_far))
        for name in ('camera_depth_topic', 'camera_points_topic'):
            if getattr(self, name) and not self.camera_depth_info_topic:
                raise SettingError('camera_depth_info_topic', '', 'a topic, as {} is given'.format(
                    name))
        if self.camera_horizontal_fov > _MAX_PINHOLE_FOV and self.camera_lens == _PINHOLE:
            raise SettingError('camera_horizontal_fov', self.camera_horizontal_fov,
                               'at most {:g} without a lens'.format(_MAX_PINHOLE_FOV))
        try:
            self.lens
        except ValueError:
            raise SettingError('camera_horizontal_fov', self.camera_horizontal_fov,
                               'less, for the function of the lens')

    @property
    def lens(self) -> Optional[lenses.AnyLens]:
        """The lens, None for none."""
        if self.camera_lens == _PINHOLE:
            distortion = lenses.Distortion(self.camera_k1, self.camera_k2, self.camera_p1,
                                           self.camera_p2, self.camera_k3)
            return distortion if any(distortion) else None
        lens = (lenses.Lens(self.camera_c1 * self.camera_f, self.camera_c2, self.camera_c3,
                            self.camera_fun) if self.camera_lens == lenses.CUSTOM
                else lenses.of_type(self.camera_lens))
        if self.camera_scale_to_hfov:
            lens = lenses.scaled_to(lens, self.camera_horizontal_fov)
        return lens._replace(cutoff_angle=self.camera_cutoff_angle,
                             texture_size=self.camera_env_texture_size)


@dataclass(frozen=True)
class ViewSettings(Settings):
    """The window and the images of the simulation.

    gui: whether to show the simulation in a window. view: the camera of ~view/image_raw;
    view_rate: maximum images per second of wall time; view_width, view_height: pixels.
    skip_images: of cameras, those for which time would wait; in lockstep, none.
    """

    gui: bool = setting(False)
    view: str = setting('above', one_of(*VIEWS))
    view_rate: float = setting(10.0, between(0.1, 60))
    view_width: int = setting(640, DRAWN_PIXELS)
    view_height: int = setting(480, DRAWN_PIXELS)
    skip_images: bool = setting(False)


@dataclass(frozen=True)
class RobotSettings:
    """All settings of one robot.

    sensors: those of its sensors, by the names of their kinds; of the others, the defaults hold.
    """

    spawn: SpawnSettings = SpawnSettings()
    drive: DriveSettings = DriveSettings()
    noise: NoiseSettings = NoiseSettings()
    sensors: Mapping[str, Settings] = field(default_factory=dict)


class Names(NamedTuple):
    """The namespace of the topics of a robot, and the prefix of its frames, both without slashes
    at the ends; '' for none.
    """

    namespace: str = ''
    frame_prefix: str = ''

    @property
    def words(self) -> str:
        """The robot in a sentence."""
        return 'robot ' + self.namespace if self.namespace else 'the robot'

    def topic(self, name: str) -> str:
        """Return the topic in the namespace, unless its name is global or there already.

        >>> Names('tb3_0').topic('scan'), Names('tb3_0').topic('/scan'), Names().topic('scan')
        ('tb3_0/scan', '/scan', 'scan')
        >>> Names('tb3_0').topic('tb3_0/scan')      # of a plugin with this <robotNamespace>
        'tb3_0/scan'
        """
        is_relative = self.namespace and not name.startswith(('/', self.namespace + '/'))
        return '/'.join((self.namespace, name)) if is_relative else name

    def frame(self, name: str) -> str:
        """Return the frame with the prefix, like tf::resolve.

        >>> Names('tb3_0', 'tb3_0').frame('odom')
        'tb3_0/odom'
        """
        return '/'.join((self.frame_prefix, name)) if self.frame_prefix else name

    def seen(self, settings: _Settings) -> _Settings:
        """Return settings with the names of topics and frames that others see.

        Those are the fields with names that end in _topic or _frame; an empty one stays so.
        """
        values = vars(settings)
        return replace(settings, **{  # type: ignore
            **{name: self.topic(values[name]) for name in topic_fields(settings)},
            **{name: self.frame(value) for name, value in values.items()
               if name.endswith('_frame') and value}})


def topic_fields(settings: Any) -> List[str]:
    """Return the names of the settings that are topics, without the empty ones."""
    return [name for name, value in vars(settings).items() if name.endswith('_topic') and value]


def whole_steps(name: str, period_s: float, step_s: float) -> int:
    """Return the number of physics steps in a period.

    name: of the setting. Raises SimulationError, with the nearest valid periods, when the number
    is not whole.

    >>> whole_steps('scan_period_s', 0.2, 0.001), whole_steps('odometry_period_s', 0.033, 0.001)
    (200, 33)
    """
    steps = period_s / step_s
    whole = round(steps)
    if whole >= 1 and math.isclose(steps, whole, rel_tol=1e-9):
        return whole
    below, up = math.floor(steps) * step_s, math.ceil(steps) * step_s
    nearest = ' or '.join('{:g}'.format(value) for value in (below, up) if value > 0)
    raise SimulationError('{}: got {:g} s, which does not divide into physics steps of {:g} s'
                          .format(name, period_s, step_s), 'set {}'.format(nearest))
