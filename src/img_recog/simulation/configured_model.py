"""What a robot, or a model with sensors, is made from: its file and its settings."""
import contextlib
import dataclasses
import functools
import xml.etree.ElementTree as ElementTree
from typing import (Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple,
                    Union, cast)

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.files import FindFile
from img_recog.formats import audit, drive_controllers, drive_tags, lumping, urdf as urdf_file
from img_recog.formats.drive_controllers import FindControllers
from img_recog.model import DIFFERENTIAL, PLANAR, Model, Tree
from img_recog.report import NOT_SIMULATED, NOT_USED, Finding, Report
from img_recog.settings import SettingError, from_mapping
from img_recog.simulation import wheels
from img_recog.simulation.physics.drive import DifferentialDrive, Drive, PlanarDrive
from img_recog.simulation.sensors import in_files
from img_recog.simulation.sensors.sensor import ConfiguredSensor, SensorKind
from img_recog.simulation.simulation_settings import (CameraSettings, DriveSettings, Names,
                                                      NoiseSettings, RobotSettings, SpawnSettings,
                                                      names_in)

# read(settings class, values) returns the settings that the user gives, else those in `values`,
# by name: those of tags, and as the URDF has them, the separation and the diameter of the wheels
ReadSettings = Callable[[type, Mapping[str, Any]], Any]
# by the names that the setting `drive` has for them
_DRIVES: Dict[str, Callable[[DriveSettings], Drive]] = {
    DIFFERENTIAL: DifferentialDrive, PLANAR: PlanarDrive}


class ConfiguredModel(NamedTuple):
    """A robot, or a model with sensors.

    source: what messages call its text, like robot_description or the path of a file;
    tag_values: the settings in its <gazebo> tags of what is there once and of the first sensor of
    each kind, by name; findings: what is not done as its file asks. names: of its topics
    and frames. has_place: whether it starts where its settings say; else that is where the nearest
    free place is searched.
    """

    source: str
    model: Model
    settings: RobotSettings = RobotSettings()
    sensors: Sequence[ConfiguredSensor] = ()
    tag_values: Mapping[str, Any] = {}
    findings: Tuple[Finding, ...] = ()
    names: Names = Names()
    has_place: bool = True

    @property
    def name(self) -> str:
        """The name of the robot."""
        return self.model.name

    @property
    def cameras(self) -> List[CameraSettings]:
        """The settings of its cameras."""
        return [cast(CameraSettings, self.settings.sensors[each.name])
                for each in self.sensors if each.kind.is_drawn]

    def new_drive(self) -> Drive:
        """Return a drive with its settings; SimulationError when those cannot be used."""
        drive = self.settings.drive
        return _DRIVES[drive.drive](drive) if drive.is_there else Drive(drive)

    def with_sensor(self, kind: SensorKind, settings: Any) -> 'ConfiguredModel':
        """Return the robot with one more sensor of a kind, which is in no file."""
        sensor = ConfiguredSensor(kind, sum(each.kind == kind for each in self.sensors))
        return self._replace(sensors=[*self.sensors, sensor]).changed(
            sensors={**self.settings.sensors, sensor.name: settings})

    def renamed(self, name: str) -> 'ConfiguredModel':
        """Return the robot with another name."""
        return self._replace(model=dataclasses.replace(self.model, name=name))

    def changed(self, **settings: Any) -> 'ConfiguredModel':
        """Return the robot with other settings, by the names of the fields of RobotSettings."""
        return self._replace(settings=dataclasses.replace(self.settings, **settings))

    def with_own_noise(self) -> 'ConfiguredModel':
        """Return the robot with noise that is not that of robots with other names."""
        return self.changed(noise=self.settings.noise.of(self.name))


def from_urdf(urdf: Union[str, ElementTree.Element], step_s: float, find: FindFile, source: str,
              kinds: Sequence[SensorKind] = (),
              controllers: FindControllers = drive_controllers.none,
              read: ReadSettings = from_mapping) -> ConfiguredModel:
    """Read a URDF.

    urdf: its text, or what was parsed of it. step_s: of the physics. find: returns the path of the
    URI of a mesh or a texture. source: see ConfiguredModel. kinds: of the sensors that it can
    have. controllers: returns those of ros_control that it can have.
    Raises SimulationError naming the source when it is not a URDF that can be simulated, or the
    value of a tag is not allowed.
    """
    # several look for them, and each answer is one of the master
    controllers = functools.lru_cache(maxsize=None)(controllers)
    report = Report(source)
    with refusals(source):
        root = urdf_file.root_of(urdf)
        model = lumping.lumped(urdf_file.read(root, find, report, controllers), report)
        drive = drive_tags.find(root, step_s, report, controllers)
        tags, unused = urdf_file.used_tags(root, model)
        in_tags, sensors = in_files.read(tags, step_s, kinds, report, drive and drive.tags)
        report.extend(audit.audit(root))
        for name in unused:
            report.add(NOT_USED, 'the <gazebo> tag, as there is no such link,', name)
        moving = [joint.name for joint in model.joints]
        for name in names_in(in_tags.get('joint_states_joints', '')):
            if name not in moving:
                report.add(NOT_SIMULATED, 'joint {} of a joint state publisher'.format(name))
        values = {**(drive.values if drive else {}),
                  **drive_controllers.joint_states(root, controllers, step_s), **in_tags}
        settings = _settings(model, sensors, values, read)
        return ConfiguredModel(
            source, model, settings, [each for each in sensors if each.name in settings.sensors],
            values, report.findings)


def from_sdf(tree: Tree, step_s: float, kinds: Sequence[SensorKind],
             with_bare: bool = False) -> ConfiguredModel:
    """Return what an SDF says of a robot, which starts where the tree is, or of a model with
    sensors.

    with_bare: whether sensors without a plugin are simulated, too.
    Raises SimulationError when a value cannot be used.
    """
    model, source = tree.model, 'model ' + tree.model.name
    with refusals(source):
        drive = drive_tags.of_model(model, step_s)
        tags = drive and drive.tags
        report = Report(source)
        in_tags, sensors = in_files.read(model.tags, step_s, kinds, report, tags, with_bare)
        if not with_bare:       # in Gazebo, too, a sensor without a plugin has no topics in ROS
            report = Report(source)
            in_files.read(model.tags, step_s, kinds, report, tags, with_bare=True)
        of_model = ['plugin ' + plugin.get('filename', '') for tag in model.tags if not tag.link
                    for plugin in tag.element.findall('plugin')]    # the audit names them
        # what has a place is in a tag; the rest belongs to a drive
        sensors = [each for each in sensors
                   if each.place is not None or drive and not each.kind.tags.frame]
        values = {**(drive.values if drive else {}), **in_tags}
        if drive:
            x, y, z = tree.pose.translation.tolist()
            yaw = rotations.to_rpy(tree.pose.rotation).tolist()[2]
            settings = dataclasses.replace(_settings(model, sensors, values, from_mapping),
                                           spawn=SpawnSettings(x_pos=x, y_pos=y, z_pos=z, yaw=yaw))
        else:
            settings = RobotSettings(sensors={each.name: settings_in_tag(each)
                                              for each in sensors})
        return ConfiguredModel(
            source, model, dataclasses.replace(settings, noise=settings.noise.of(tree.name)),
            sensors, values, tuple(each for each in report.findings if each.what not in of_model))


def _settings(model: Model, sensors: Sequence[ConfiguredSensor], tag_values: Mapping[str, Any],
              read: ReadSettings) -> RobotSettings:
    measured = wheels.measure(model, read(DriveSettings, tag_values))
    values: Mapping[str, Any] = {**measured.values(), **tag_values}
    drive = read(DriveSettings, values)
    if measured.swapped:
        # libgazebo_ros_diff_drive has <legacyMode>, in which they are
        drive = dataclasses.replace(drive, left_joint=drive.right_joint,
                                    right_joint=drive.left_joint)
    of_sensors = {each.name: read(each.kind.settings, values) if each.reads_parameters
                  else settings_in_tag(each) for each in sensors}
    return RobotSettings(read(SpawnSettings, values), drive, read(NoiseSettings, values), {
        each.name: of_sensors[each.name] for each in sensors
        if _is_there(each, of_sensors[each.name], drive, values)})


def _is_there(sensor: ConfiguredSensor, settings: Any, drive: DriveSettings,
              values: Mapping[str, Any]) -> bool:
    """Return whether a robot has a sensor: in its tags, or on a link that the settings name; one
    that is on no link belongs to a drive, or to what gives its settings in `values`.
    """
    if sensor.kind.tags.frame or sensor.kind.only_in_tags:
        return bool(sensor.values or sensor.kind.frame(settings))
    return drive.is_there or any(name.startswith(sensor.kind.name) for name in values)


def settings_in_tag(sensor: ConfiguredSensor) -> Any:
    """Return the settings of a sensor in a file; SimulationError when one is not allowed."""
    try:
        return from_mapping(sensor.kind.settings, sensor.values)
    except SettingError as error:
        raise SimulationError('its sensor {}: {}'.format(
            sensor.label if sensor.kind.is_drawn else sensor.name, error.problem), error.advice)


@contextlib.contextmanager
def refusals(source: str) -> Iterator[None]:
    """Turn errors in the `with` block into those that the robot in `source` cannot be used."""
    try:
        yield
    except (SimulationError, SettingError) as error:
        raise SimulationError('cannot use the robot in {}: {}'.format(source, error.problem),
                              error.advice)
