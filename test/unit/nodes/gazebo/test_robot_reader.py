"""Which value counts: of a parameter, of the tags of a robot, or the default."""
import pytest

from img_recog.formats import model_file
from img_recog.nodes.gazebo.robot_reader import RobotReader
from img_recog.report import Report
from img_recog.simulation.simulation_settings import SpawnSettings
from img_recog_helpers.robots import burger
from img_recog_helpers.sdf import model

SCANNER = ('<{parent}><sensor name="{name}" type="ray"><update_rate>{rate}</update_rate><ray>'
           '<scan><horizontal><samples>4</samples></horizontal></scan></ray><plugin name="{name}" '
           'filename="libgazebo_ros_laser.so"><topicName>{name}</topicName></plugin></sensor>'
           '</{parent_end}>')
DRIVE = ('<plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>wheel_left_joint'
         '</leftJoint><rightJoint>wheel_right_joint</rightJoint><wheelSeparation>0.3'
         '</wheelSeparation></plugin>')


def scanners(parent):
    return ''.join(SCANNER.format(parent=parent, parent_end=parent.split()[0], name=name,
                                  rate=rate) for name, rate in (('first', 10), ('second', 20)))


URDF = burger('').replace('</robot>', '<gazebo>{}</gazebo>{}</robot>'.format(
    DRIVE, scanners('gazebo reference="base_scan"')))
WHEEL = ('<link name="{0}"><pose>0 {1} 0.05 -1.5708 0 0</pose><collision name="c"><geometry>'
         '<cylinder><radius>0.05</radius><length>0.02</length></cylinder></geometry></collision>'
         '</link><joint name="wheel_{0}_joint" type="revolute"><parent>base</parent>'
         '<child>{0}</child><axis><xyz>0 0 1</xyz></axis></joint>')
SDF = '<sdf version="1.6">{}</sdf>'.format(model(
    'cart', scanners('link name="base"').replace('</link><link name="base">', ''),
    WHEEL.format('left', 0.1), WHEEL.format('right', -0.1), DRIVE))


class Server(dict):
    """Parameters by their global names, as rospy returns them."""

    def get_param(self, name, default=None):
        name = self.resolve(name)
        if name in self:
            return self[name]
        start = name.rstrip('/') + '/'
        inside = {key[len(start):]: value for key, value in self.items() if key.startswith(start)}
        return {key: value for key, value in inside.items() if '/' not in key} or default

    @staticmethod
    def resolve(name):
        if name.startswith('~'):
            return '/gazebo/' + name[1:]
        return name if name.startswith('/') else '/' + name


@pytest.fixture
def server(monkeypatch):
    found = Server({'/robot_description': URDF})
    monkeypatch.setattr('rospy.get_param', found.get_param)
    monkeypatch.setattr('rospy.resolve_name', found.resolve)
    monkeypatch.setattr('rospy.get_namespace', lambda: '/')
    monkeypatch.setattr('rospy.search_param', lambda name: '/' + name)
    return found


def spawned_sdf(reader):
    tree, = model_file.read(SDF, 'cart', lambda uri: None, Report())
    return reader.spawned_sdf(tree, '')


ROBOTS = {
    'single': RobotReader.single,
    'of ~robots': lambda reader: reader.named('tb3_0'),
    'spawned URDF': lambda reader: reader.spawned('s', URDF, '', SpawnSettings()),
    'spawned SDF': spawned_sdf}
GLOBAL, OWN = '/gazebo/{}', '/gazebo/robots/tb3_0/{}'
# name of the setting, its value in the tags, and where the value is that counts
SETTINGS = {
    'first scanner': ('scan_period_s', 0.1,
                      lambda spec: spec.settings.sensors['scan'].scan_period_s),
    'second scanner': ('scan_period_s', 0.05,
                       lambda spec: spec.settings.sensors['scan_2'].scan_period_s),
    'drive': ('wheel_separation', 0.3, lambda spec: spec.settings.drive.wheel_separation)}


@pytest.mark.parametrize('setting, robot, of_all, own', [
    # of_all: whether a parameter for all robots counts; own: whether one for this robot does
    ('first scanner', 'single', True, False), ('first scanner', 'of ~robots', True, True),
    ('first scanner', 'spawned URDF', True, False), ('first scanner', 'spawned SDF', False, False),
    *(('second scanner', robot, False, False) for robot in ROBOTS),
    ('drive', 'single', True, False), ('drive', 'of ~robots', True, True),
    ('drive', 'spawned URDF', True, False), ('drive', 'spawned SDF', False, False)])
def test_which_parameter_overrides_a_tag(server, setting, robot, of_all, own):
    name, in_tags, value_in = SETTINGS[setting]

    def value():
        return value_in(ROBOTS[robot](RobotReader(0.001)))
    assert value() == pytest.approx(in_tags)
    server[GLOBAL.format(name)] = 0.4
    assert value() == pytest.approx(0.4 if of_all else in_tags)
    server[OWN.format(name)] = 0.2
    assert value() == pytest.approx(0.2 if own else 0.4 if of_all else in_tags)


@pytest.mark.parametrize('robot, of_all, own', [
    ('single', 1, 1), ('of ~robots', 1, 1), ('spawned URDF', 1, 1), ('spawned SDF', 0, 0)])
def test_a_camera_of_parameters_is_one_more(server, robot, of_all, own):
    def frames():
        return [camera.camera_frame for camera in ROBOTS[robot](RobotReader(0.001)).cameras]
    assert frames() == []
    server[GLOBAL.format('camera_frame')] = 'base_link'
    assert frames() == ['base_link'] * of_all
    server[OWN.format('camera_frame')] = 'base_scan'
    assert frames() == [('base_scan' if robot == 'of ~robots' else 'base_link')] * own


def test_without_a_tag_parameters_add_a_sensor_and_count_more_than_the_default(server):
    def sensors():
        return RobotReader(0.001).single().settings.sensors
    server['/robot_description'] = burger('')
    assert 'imu' not in sensors()
    server['/gazebo/imu_frame'] = 'imu_link'
    assert sensors()['imu'].imu_period_s == 0.001
    server['/gazebo/imu_period_s'] = 0.02
    assert sensors()['imu'].imu_period_s == 0.02
