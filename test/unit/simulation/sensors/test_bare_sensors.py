"""What a sensor is whose tags say little or nothing: that of SDF, and of the plugin."""
import numpy as np
import pytest

from img_recog.loading import assemble
from img_recog.simulation.sensors.imu import ImuSettings
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers import sdf
from img_recog_helpers.robots import burger, read

BOX = sdf.body('box', '2 0 0.5', sdf.box(1, 8, 1), static=True)
RANGE = '<range><min>0.1</min><max>5</max></range>'
NOTHING = [np.inf] * 640
ANGLES = '<min_angle>-.5</min_angle><max_angle>.5</max_angle>'


def scanner(inside):
    return '<sensor name="s" type="ray">{}</sensor>'.format(inside)


def horizontal(inside, rest=RANGE):
    return scanner('<ray><scan><horizontal>{}</horizontal></scan>{}</ray>'.format(inside, rest))


# what Gazebo 11 measures in the same world
@pytest.mark.parametrize('sensor, ranges', [
    (scanner(''), NOTHING), (scanner('<ray/>'), NOTHING),
    (scanner('<ray><scan/><range/></ray>'), NOTHING),
    (horizontal('<samples>5</samples>' + ANGLES, ''), [np.inf] * 5),
    (horizontal('<samples>5</samples>' + ANGLES, '<range><min>0.1</min></range>'), [np.inf] * 5),
    (horizontal('<samples>5</samples>' + ANGLES, '<range><max>5</max></range>'),
     [1.70924, 1.54813, 1.5, 1.54813, 1.70924]),
    (horizontal('<samples>5</samples>'), [1.5] * 5),
    (horizontal('<samples>3</samples><min_angle>-.5</min_angle>'), [1.70924, 1.54813, 1.5]),
    (horizontal(ANGLES), 1.5 / np.cos(np.linspace(-0.5, 0.5, 640))),
    (horizontal('<samples/>' + ANGLES), 1.5 / np.cos(np.linspace(-0.5, 0.5, 640))),
    (scanner('<update_rate>10 Hz</update_rate><ray><scan><horizontal><samples>2</samples>'
             '</horizontal></scan><range><max>5</max></range></ray>'), [1.5, 1.5])])
def test_rays_without_some_of_their_tags(tmp_path, sensor, ranges):
    path = tmp_path / 'w.sdf'
    path.write_text(sdf.sdf(sdf.BUILT_IN, BOX, sdf.model('r', '<link name="l">', sensor, '</link>',
                                                         pose='0 0 0.3', static=True)))
    simulator = assemble.simulator(PhysicsSettings(world=str(path)), with_sensors=True,
                                   with_bare=True)
    mounted, = simulator.sensors
    assert mounted.measure()['scan'] == pytest.approx(ranges, abs=1e-5)


def test_sensors_of_plugins_without_their_tags():
    robot = read(burger(
        '<gazebo reference="base_scan"><sensor name="s" type="ray"><plugin name="p" '
        'filename="libgazebo_ros_laser.so"/></sensor></gazebo><gazebo><plugin name="i" '
        'filename="libgazebo_ros_imu.so"><bodyName>imu_link</bodyName></plugin></gazebo>'))
    scan, imu = robot.settings.sensors['scan'], robot.settings.sensors['imu']
    assert (scan.scan_samples, scan.scan_angle_min, scan.scan_angle_max, scan.scan_range_min,
            scan.scan_range_max, scan.scan_noise, scan.scan_frame, scan.scan_period_s) == (
        640, 0.0, 0.0, 0.0, 0.0, 0.0, 'base_scan', 0.001)
    # imu_link is lumped into the root link, as in Gazebo
    assert imu == ImuSettings('base_footprint', 0.001, 0.0, 0.0, False, 'default_imu')


def test_a_robot_without_tags_measures_nothing():
    assert read(burger('')).sensors == []
    assert {each.name for each in read(burger()).sensors} == {
        'odometry', 'joint_states', 'imu', 'scan'}
    publisher = ('<gazebo><plugin name="j" filename="libgazebo_ros_joint_state_publisher.so"/>'
                 '</gazebo>')
    assert [each.name for each in read(burger(publisher)).sensors] == ['joint_states']


def test_without_a_tag_a_parameter_that_names_the_link_is_a_sensor():
    given = {'scan_frame': 'base_scan', 'scan_range_max': 2.0}
    robot = assemble.robot_of(burger(''), 'robot', read=lambda kind, values: kind(**{
        name: value for name, value in given.items() if hasattr(kind, name)}))
    assert [each.name for each in robot.sensors] == ['scan']
