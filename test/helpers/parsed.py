"""What is read of the text of a URDF."""
from typing import Any, Dict, NamedTuple, Sequence

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import drive_tags, lumping, urdf
from img_recog.model import Tag
from img_recog.simulation.robot_spec import settings_in_tag
from img_recog.simulation.sensors import in_files
from img_recog.simulation.sensors.sensor import RobotSensor, sensors_of
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog_helpers.robots import CAMERA


def given(text, find=lambda uri: None):
    """Return the links and joints of a URDF as it has them."""
    return urdf.read(urdf.root_of(text), find)


def lumped(text, find=lambda uri: None):
    """Return the robot in a URDF."""
    return lumping.lumped(given(text, find))


def part(parts, name):
    """Return the link or the joint of a name."""
    found, = (each for each in parts if each.name == name)
    return found


class Cameras(NamedTuple):
    """The settings of cameras, and what of them is not simulated."""

    cameras: Sequence[CameraSettings]
    not_simulated: Sequence[str]


def cameras(text):
    """Return the cameras of a URDF."""
    found, problems = in_files.read(_tags(urdf.root_of(text)), 0.001, [CAMERA])[1:]
    return Cameras(tuple(map(settings_in_tag, sensors_of([CAMERA], found))), tuple(problems))


class InTags(NamedTuple):
    """What is in <gazebo> tags: settings by name, sensors, and what is not simulated."""

    values: Dict[str, Any]
    sensors: Sequence[RobotSensor]
    not_simulated: Sequence[str]


def tags(text, step_s=0.001, drive=None, kinds=SENSORS):
    """Return what is in the <gazebo> tags of a URDF."""
    root = urdf.root_of(text)
    values, *rest = in_files.read(_tags(root), step_s, kinds, drive)
    found = drive_tags.find(root, step_s) if drive else None
    return InTags({**(found.values if found else {}), **values}, *rest)


def _tags(root):
    return [Tag(tag.get('reference', ''), tag) for tag in root.findall('gazebo')]
