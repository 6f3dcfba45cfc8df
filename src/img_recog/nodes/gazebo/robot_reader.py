"""Reads what robots are made from: their URDF and their parameters."""
from dataclasses import dataclass
from functools import partial
from typing import Any, Collection, Dict, List, Mapping, Sequence, Tuple

import rosgraph
import rospy

from img_recog.conversions.sensor_table import CAMERA, SENSORS
from img_recog.errors import SimulationError, shortened
from img_recog.formats import drive_controllers, model_file
from img_recog.formats.drive_controllers import Controllers
from img_recog.formats.reader import text_of
from img_recog.loading import assemble
from img_recog.model import Tree
from img_recog.ros import parameters
from img_recog.settings import ParameterError, Settings, setting, setting_fields, unknown
from img_recog.simulation import configured_model
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.simulation_settings import (CameraSettings, DriveSettings, Names,
                                                      NoiseSettings, SpawnSettings, topic_fields)

ROBOTS = '~robots'
_MAX_NAME = 100         # characters
_NO_NAMESPACE = ''


@dataclass(frozen=True)
class RobotsSettings(Settings):
    """Which robots there are.

    several_robots: the robots of ~robots, each in a namespace of its name, in place of the one of
    robot_description. world_tf: whether the frame `world` is the parent of their odometry frames,
    to show them together; not beside a localization, which is that parent too.
    """

    several_robots: bool = setting(False)
    world_tf: bool = setting(False)


class RobotReader:
    """Reads robots from parameters and services."""

    def __init__(self, step_s: float):
        """step_s: of the physics."""
        self._step_s = step_s

    def single(self) -> ConfiguredModel:
        """Return the robot in robot_description and the private parameters."""
        return self._read('', parameters.robot_description(), 'robot_description', Names(),
                          _NO_NAMESPACE)

    def names(self) -> List[str]:
        """Return the names of the robots in ~robots, tb3_2 before tb3_10.

        Those that have a place come first: the others search one that is free.
        Raises ParameterError when that is no mapping.
        """
        robots = parameters.value(ROBOTS)
        if robots is not None and not isinstance(robots, dict):
            raise ParameterError(
                'parameter {}: got {}, wants a mapping of robots, like {{tb3_0: {{x_pos: 1.0}}}}'
                .format(rospy.resolve_name(ROBOTS), shortened(repr(robots))))
        places = {name for name, values in (robots or {}).items() if _has_place(values)}
        return sorted(robots or {}, key=lambda name: (name not in places, *_natural(name)))

    def snapshot(self, name: str) -> Tuple[Any, ...]:
        """Return what differs when the robot is to be read again."""
        return (parameters.value('{}/{}'.format(ROBOTS, name)),
                parameters.value(name + '/robot_description'),
                parameters.value(name + '/tf_prefix'))

    def named(self, name: str) -> ConfiguredModel:
        """Return a robot of ~robots.

        Its URDF is NAME/robot_description, or robot_description; the private parameters hold
        where it has none.
        Raises a UserError naming what is wrong.
        """
        if not rosgraph.names.is_legal_base_name(name) or len(name) > _MAX_NAME:
            raise ParameterError('its name is not allowed: letters, digits and _, the first a '
                                 'letter, at most {}'.format(_MAX_NAME))
        for value, where in ((parameters.value('{}/{}'.format(ROBOTS, name)), ROBOTS + '/' + name),
                             (parameters.value(name), name)):
            if not isinstance(value, (dict, type(None))):
                raise ParameterError('parameter {}: got {}, wants a mapping'.format(
                    rospy.resolve_name(where), shortened(repr(value))))
        namespace = '{}/{}'.format(ROBOTS, name)
        own = parameters.names_in(namespace)
        known = [field.name for each in robot_settings_classes() for field in setting_fields(each)]
        for wrong in sorted(set(own) - set(known)):
            raise ParameterError(unknown(wrong, known, rospy.resolve_name(
                '{}/{}'.format(namespace, wrong))))
        described = name + '/robot_description'
        has_urdf = parameters.value(described) is not None
        spec = self._read(
            name, parameters.robot_description(described if has_urdf else ''),
            rospy.resolve_name(described) if has_urdf else 'robot_description',
            names_of(name, name), namespace)
        return (spec if 'seed' in own else spec.with_own_noise())._replace(
            has_place=_has_place(own))

    def is_robot(self, text: str, namespace: str) -> bool:
        """Return whether a model is a URDF of a robot that drives.

        namespace: of the robot.
        """
        try:
            return model_file.is_robot(text, partial(read_controllers, Names(namespace)))
        except SimulationError:
            return False        # a model that is read otherwise, or refused

    def spawned(self, name: str, urdf: str, namespace: str,
                spawn: SpawnSettings) -> ConfiguredModel:
        """Return a robot that a service adds at a place.

        Raises a UserError naming what is wrong.
        """
        _check_namespace(namespace)
        spec = self._read(name, urdf, 'the model ' + name,
                          names_of(namespace, namespace) if namespace else Names(), _NO_NAMESPACE)
        return spec.with_own_noise().changed(spawn=spawn)

    def spawned_sdf(self, tree: Tree, namespace: str) -> ConfiguredModel:
        """Return a robot of an SDF that a service adds; errors as for `spawned`."""
        _check_namespace(namespace)
        return in_namespace(configured_model.from_sdf(tree, self._step_s, SENSORS), namespace)

    def _read(self, name: str, urdf: str, source: str, names: Names,
              namespace: str) -> ConfiguredModel:
        """name: '' for that in the URDF; namespace: of its own parameters, '' for none."""
        spaces = namespace or '~', '~'
        spec = assemble.robot_of(
            urdf, source, self._step_s, partial(read_controllers, names),
            lambda settings_class, values: parameters.read(settings_class, values, *spaces))
        for each in (spec.settings.drive, *spec.settings.sensors.values()):
            for field in topic_fields(each):
                if not rosgraph.names.is_legal_name(getattr(each, field)):
                    raise ParameterError('parameter {}: got {}, allowed is a valid topic name'
                                         .format(field, shortened(repr(getattr(each, field)))))
        camera = parameters.read(CameraSettings, {}, *spaces)
        if camera.camera_frame:
            spec = spec.with_sensor(CAMERA, camera)
        spec = spec._replace(names=names)
        return spec.renamed(name) if name else spec


def read_controllers(names: Names, namespace: str) -> Controllers:
    """Return the parameters of controllers, by the names that these have in the robot's namespace.

    They are on the parameter server in a namespace, that of the plugin in the URDF, below that of
    the robot, or for all robots below that of this node. Which of them a controller manager would
    start is not known.
    """
    inner = '' if namespace == names.namespace else namespace
    of_robot = '/'.join(filter(None, (names.namespace, inner)))
    found: Dict[str, Mapping[str, Any]] = {}
    for each in (of_robot, inner):
        values = parameters.value(rospy.get_namespace() + each)
        for name, value in drive_controllers.among(values, inner).items():
            found.setdefault(name, value)
    return found


def in_namespace(spec: ConfiguredModel, namespace: str = '') -> ConfiguredModel:
    """Return a model of an SDF that drives, or has sensors, with the names that others see.

    namespace: of its topics, by default that of its first plugin.
    """
    plugins = [tag.element.find('plugin') for tag in spec.model.tags if not tag.link]
    space = namespace or next((text_of(plugin, 'robotNamespace').strip('/')
                               for plugin in plugins), '')
    return spec._replace(names=names_of(space, '')) if space else spec


def _check_namespace(namespace: str) -> None:
    if namespace and not (rosgraph.names.is_legal_name(namespace) and namespace[0].isalpha()):
        raise ParameterError('robot_namespace: got {}, wants names of letters, digits and _, '
                             'with / between them'.format(shortened(repr(namespace))))


def names_of(namespace: str, default_prefix: str) -> Names:
    """Return the names in a namespace; its parameter tf_prefix gives the prefix of frames."""
    prefix = parameters.value(namespace + '/tf_prefix')
    return Names(namespace.strip('/'),
                 (prefix if isinstance(prefix, str) else default_prefix).strip('/'))


def robot_settings_classes() -> Sequence[type]:
    """Return the classes of all parameters that a robot reads."""
    return [SpawnSettings, DriveSettings, NoiseSettings, CameraSettings,
            *(kind.settings for kind in SENSORS if not kind.only_in_tags)]


def _has_place(values: Any) -> bool:
    return isinstance(values, Collection) and ('x_pos' in values or 'y_pos' in values)


def _natural(name: str) -> Tuple[str, int, str]:
    """Return a key by which names are in the order of their last numbers."""
    text = name.rstrip('0123456789')
    return text, len(name) - len(text), name
