"""The settings in <gazebo> tags and of controllers, whole: texts are in test/expected/models."""
import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import drive_controllers, drive_tags, urdf
from img_recog.formats.yaml_text import load_yaml
from img_recog.model import Tag
from img_recog.report import Report
from img_recog.settings import setting_fields
from img_recog.simulation.configured_model import settings_in_tag
from img_recog.simulation.sensors import in_files
from img_recog_helpers import expected, printed


def lines_of(tags, step_s):
    root = urdf.root_of('<robot name="r">{}</robot>'.format(tags))
    report = Report()
    drive = drive_tags.find(root, step_s, report)
    values, in_tags = in_files.read(
        [Tag(tag.get('reference', ''), tag) for tag in root.findall('gazebo')], step_s, SENSORS,
        report, drive and drive.tags)
    if drive:
        yield 'drive: ' + printed.text(drive.values)
    of_sensors = {name for sensor in in_tags for name in sensor.values}
    yield from ('{}: {}'.format(name, printed.text(value)) for name, value in values.items()
                if name not in of_sensors)
    for sensor in in_tags:
        if sensor.place or sensor.values:
            lens = getattr(settings_in_tag(sensor), 'lens', None)
            yield '{}: {}{}'.format(
                sensor.name, ', '.join(printed.fields(sensor._replace(kind=None), 'number')[1:]),
                ', lens ({})'.format(printed.text(lens)) if lens else '')
    yield from printed.findings(report)


@pytest.mark.parametrize('name, step_s', [
    ('tags', 0.001), ('cameras', 0.001), ('refused_tags', 0.001), ('tags_at_4_ms', 0.004)])
def test_of_tags(name, step_s):
    expected.check_cases('models/{}.txt'.format(name),
                         lambda tags: '\n'.join(lines_of(tags, step_s)))


def test_of_controllers():
    robot = urdf.root_of(
        '<robot><gazebo><plugin filename="libgazebo_ros_control.so"/></gazebo>{}</robot>'.format(
            ''.join('<joint name="{}"/>'.format(name)
                    for name in ('a', 'b', 'c', 'd', 'l_wheel_joint', 'r_wheel_joint'))))

    def lines(controllers):
        def find(namespace):
            return controllers
        report = Report()
        found = drive_controllers.find(robot, find, 0.001, report)
        if found:
            yield 'drive: ' + printed.text(found.values)
        yield 'joint states: ' + printed.text(drive_controllers.joint_states(robot, find, 0.001))
        yield from printed.findings(report)
    expected.check_cases('models/controllers.txt', lambda text: '\n'.join(
        lines(drive_controllers.among(load_yaml(text.encode()), ''))))


@pytest.mark.parametrize('kind', SENSORS, ids=lambda kind: kind.name)
def test_tags_and_defaults_of_plugins_are_of_settings_that_there_are(kind):
    named = {row.setting for row in kind.tags.rows if not row.reader.of_element}.union(
        [kind.tags.frame] * bool(kind.tags.frame), *kind.tags.defaults.values())
    assert named <= {field.name for field in setting_fields(kind.settings)}
