"""Models of a world that have sensors, with a plugin that publishes or without."""
import math

import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import world_file
from img_recog.formats.world_file import WorldFile
from img_recog.report import lines_of
from img_recog.simulation import assembly
from img_recog.simulation.models import Models
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.robots import assemble
from img_recog_helpers.sdf import BUILT_IN, box, convert, link, model, sdf

WALL = link('wall', '2', box(0.2, 9, 9))
SENSOR = '<sensor name="{0}" type="{1}"><pose>0.1 0 0 0 0 0</pose>{2}</sensor>'
RAY = ('<update_rate>50</update_rate><ray><scan><horizontal><samples>3</samples><min_angle>-1'
       '</min_angle><max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>5</max>'
       '</range></ray>')
PLUGIN = '<plugin name="p" filename="lib{}.so"/>'
# a static model whose link `eye` is at x 0.5
EYE = '<static>1</static><link name="eye"><pose>0.5 0 1 0 0 0</pose>{}</link>'


def build(*inside):
    world = WorldFile('w', tuple(convert(*inside)))
    return assembly.build(PhysicsSettings(), world, [], kinds=SENSORS, with_bare=True,
                          with_drives=True)


def mounted(*inside):
    found, = build(*inside).sensors
    return found


@pytest.mark.parametrize('kind', ['ray', 'gpu_ray'])
def test_rays_of_a_static_model_begin_at_the_pose_of_the_sensor_in_its_link(kind):
    eye = mounted(WALL, EYE.format(SENSOR.format('s', kind, RAY)))
    sensor, = eye.spec.sensors
    assert (sensor.label, sensor.type, sensor.is_bare) == ('s', kind, True)
    # from x 0.6 to the wall at 1.9, without noise
    assert eye.measure()['scan'][1] == pytest.approx(1.3, abs=1e-6)


@pytest.mark.parametrize('near, pitch, expected', [(0.05, 0, [0.1, 0.1]), (0.12, 1, [
    0.925407859, math.inf])])
def test_a_scanner_sees_its_own_model_from_inside_as_in_gazebo(near, pitch, expected):
    rays = ('<ray><scan><horizontal><samples>2</samples><min_angle>0</min_angle><max_angle>1.57'
            '</max_angle></horizontal></scan><range><min>{}</min><max>3.5</max></range></ray>')
    sensor = '<sensor name="s" type="ray"><pose>0 0 0 0 {} 0</pose>{}</sensor>'.format(
        pitch, rays.format(near))
    head = mounted(
        '<pose>0 5 0.5 0 0 0</pose>', link('base', '', box(1, 1, 1)), link(
            'head', '0 0 0.6', '<cylinder><radius>0.1</radius><length>0.1</length></cylinder>',
            inside=sensor),
        '<joint name="j" type="fixed"><parent>base</parent><child>head</child></joint>')
    # the figures are those of Gazebo 11.1
    assert head.measure()['scan'].tolist() == pytest.approx(expected, abs=1e-5)


def test_the_readings_of_a_model_are_those_of_its_rate_and_end_with_it():
    simulator = build(WALL, EYE.format(SENSOR.format('s', 'ray', RAY)))
    assert [round(each.time_s, 3) for each in simulator.advance(60)] == [0.02, 0.04, 0.06]
    Models(simulator).remove('m')
    assert simulator.advance(60) == [] and not simulator.sensors


def test_an_imu_that_falls_feels_nothing():
    simulator = build('<pose>0 0 9 0 0 0</pose>', link(inside=SENSOR.format(
        'tilt', 'imu', '<update_rate>100</update_rate>')))
    *_, last = simulator.advance(100)
    assert last.value.linear_acceleration == pytest.approx((0, 0, 0), abs=1e-6)


def test_cameras_are_named_by_their_sensors():
    spec = mounted(EYE.format(SENSOR.format('cam', 'camera', '<camera/>'))).spec
    assert [each.label for each in spec.sensors] == ['cam']
    camera, = spec.cameras
    assert (camera.camera_frame, camera.camera_x, camera.camera_width) == ('eye', 0.1, 320)


@pytest.mark.parametrize('inside, words', [
    (SENSOR.format('s', 'gps', ''), 'model m: not simulated: sensor gps'),
    (SENSOR.format('s', 'ray', RAY + PLUGIN.format('other')),
     'model m: not simulated: plugin libother.so'),
    (SENSOR.format('s', 'ray', RAY.replace('>3<', '>x<')),
     'model m: not simulated: its sensors; cannot use the robot in model m: '
     "<ray/scan/horizontal/samples> of sensor s: got 'x', expected a whole number")])
def test_what_of_sensors_is_not_simulated_is_said(inside, words):
    assert build(EYE.format(inside)).world.report.lines() == [words]


def test_a_sensor_with_a_plugin_that_publishes_is_not_bare():
    eye = mounted(EYE.format(SENSOR.format('s', 'ray', RAY + PLUGIN.format('gazebo_ros_laser'))))
    assert [each.is_bare for each in eye.spec.sensors] == [False]


DOOR = model('door', '<link name="l"/><joint name="j" type="revolute"><parent>world</parent>'
             '<child>l</child><axis><xyz>0 0 1</xyz></axis></joint>')


@pytest.mark.parametrize('world', ['turtlebot3_world', sdf(DOOR)], ids=['urdf', 'door'])
def test_the_state_of_models_whose_root_link_is_not_in_their_file(world):
    models = Models(assemble(world))
    for name in models.names:
        assert models.state(name).linear.tolist() == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_bumper_and_a_depth_camera_of_a_model_of_a_world():
    touch = SENSOR.format(
        'touch', 'contact', '<update_rate>50</update_rate><contact><collision>c</collision>'
        '</contact>' + PLUGIN.format('gazebo_ros_bumper'))
    eye = SENSOR.format('eye', 'depth', '<camera><image><width>32</width></image></camera>'
                        + PLUGIN.format('gazebo_ros_openni_kinect'))
    file = world_file.read('w.sdf', {}, read_file=lambda path: sdf(BUILT_IN, model(
        'm', link('l', '0 0 0.1', box(0.2, 0.2, 0.2), mass=2, inside=touch + eye),
        PLUGIN.format('gazebo_ros_p3d'))))
    # also where gazebo_msgs is not installed
    kinds = [kind._replace(missing='') for kind in SENSORS]
    built = assembly.build(PhysicsSettings(), file, [], kinds=kinds)
    touches = [each.value for each in built.advance(500)]
    assert len(touches) == 25
    touch, = touches[-1]
    assert (touch.own, touch.other) == ('m::l', 'ground_plane::link')
    assert touch.forces.sum(axis=0) == pytest.approx([0, 0, 2 * 9.8], abs=0.5)
    camera, = built.sensors[0].spec.cameras
    assert (camera.camera_width, camera.camera_x, camera.camera_depth_topic) == (
        32, 0.1, 'depth/image_raw')
    assert lines_of(file.findings) == [
        'world w.sdf: not simulated: plugin libgazebo_ros_p3d.so of world default model m']
