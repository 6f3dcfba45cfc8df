"""The visuals of a simulation, and the poses of the parts that carry them."""
import math

import numpy as np
import pytest

from img_recog.model import MESH, PLANE, SPHERE, WHITE, Material, Shape
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors import robot_camera
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog_helpers.robots import assemble, burger
from img_recog_helpers.sdf import BUILT_IN, CRATE, SHELF, model, sdf


def shelf_with(*visual):
    return SHELF.replace('</link>', '<visual name="v">' + ''.join(visual) + '</visual></link>')


BALL = '<pose>0 0 0.5 0 0 0</pose><geometry><sphere><radius>0.1</radius></sphere></geometry>'
HALL = sdf(BUILT_IN, shelf_with(BALL), CRATE.format('-1 0 0.1 0 0 0'))


def read(built):
    parts = Parts(built)
    return parts.scene(), parts


def with_visual(inside):
    """Return the burger with another visual in its root link, before the others."""
    link = '<link name="base_footprint"/>'
    assert link in burger()
    return burger().replace(link, '<link name="base_footprint"><visual>{}</visual></link>'.format(
        inside))


def test_parts_are_the_links_of_robots_and_world():
    scene, parts = read(assemble(HALL, x=0.5, y=0.25, yaw=1.0))
    numbers = parts.numbers()
    assert [sorted(each.values()) for each in numbers] == [
        [0], [1], list(range(2, 2 + len(numbers[2])))]
    assert {'base_footprint', 'wheel_left_link'} <= set(numbers[2]) and list(numbers[0]) == ['l']
    assert scene.moving == (False, True) + (True,) * len(numbers[2])
    poses = parts.poses()
    assert poses.shape == (len(scene.moving), 7)
    assert poses[2] == pytest.approx([0.5, 0.25, 0, 0, 0, math.sin(0.5), math.cos(0.5)], abs=1e-6)
    assert poses[0, :3] == pytest.approx([1, 2, 1]) and poses[1, :3] == pytest.approx(
        [-1, 0, 0.1])


def test_poses_are_those_of_now():
    built = assemble(HALL)
    _, parts = read(built)
    before = parts.poses()
    built.robots[0].command(0.2, 0.0)
    built.advance(2000)
    after = parts.poses()
    assert after[2, 0] == pytest.approx(built.robots[0].body.pose().position[0])
    assert after[2, 0] > before[2, 0] + 0.2
    wheel = parts.numbers()[2]['wheel_left_link']
    assert after[wheel, :3] - after[2, :3] == pytest.approx(before[wheel, :3] - before[2, :3],
                                                            abs=2e-3)
    assert abs(after[wheel, 3:] - before[wheel, 3:]).max() > 0.1      # it has turned
    assert np.array_equal(after[0], before[0])


def test_a_simulation_without_bodies_has_no_poses():
    sim = assemble()
    sim.world.remove(sim.robots[0])
    assert Parts(sim).poses().shape == (0, 7)


def test_visuals_of_the_world():
    scene, parts = read(assemble(HALL))
    shelf = parts.numbers()[0]['l']
    visual, = [each for each in scene.visuals if each.part == shelf]
    assert visual.shape == Shape(SPHERE, (0.1,)) and visual.pose[:3, 3].tolist() == [0, 0, 0.5]
    assert visual.material == WHITE


@pytest.mark.parametrize('world, has_floor', [
    ('empty', True), (sdf(BUILT_IN), True), (sdf(), False)])
def test_the_floor_is_seen_where_the_world_has_it(world, has_floor):
    assert read(assemble(world))[0].floor is has_floor


PLATE = Material((0.25, 0.25, 0.26, 1.0))


@pytest.mark.parametrize('inside, shape, material, prefers_file', [
    ('<geometry><mesh filename="/a.dae" scale="1 2 3"/></geometry><material name="plate"/>',
     Shape(MESH, (1.0, 2.0, 3.0), '/a.dae'), PLATE, True),
    ('<geometry><sphere radius="2"/></geometry><material name="unknown"/>', Shape(SPHERE, (2.0,)),
     None, False)])
def test_shapes_and_materials(inside, shape, material, prefers_file):
    visual, *_ = read(assemble(urdf=with_visual(inside), find_mesh=str))[0].visuals
    assert (visual.part, visual.shape, visual.material, visual.prefers_file) == (
        0, shape, material, prefers_file)


def test_a_plane_is_the_upper_side_of_its_box():
    plane = ('<pose>0 0 0.5 0 0 1</pose><geometry><plane><normal>1 0 0</normal><size>4 2</size>'
             '</plane></geometry>')
    visual, = [each for each in read(assemble(sdf(shelf_with(plane))))[0].visuals
               if each.shape.kind == PLANE]
    assert visual.shape.size == (4.0, 2.0)
    assert visual.pose[:3, 3] == pytest.approx([0, 0, 0.5], abs=1e-9)
    assert visual.pose[:3, 2] == pytest.approx([math.cos(1), math.sin(1), 0])


def test_a_camera_on_the_robot_reads_its_pose_and_all_others():
    built = assemble(x=1.0, y=2.0, yaw=math.pi / 2)
    parts = Parts(built)
    camera = RobotCamera(built.robots[0].body, CameraSettings(
        camera_frame='base_link', camera_x=0.1, camera_z=0.2, camera_pitch=math.pi / 2),
        parts.poses)
    exposure = camera.read()
    # base_link is 0.01 m above base_footprint; the camera looks down
    assert exposure.camera_pose[:3, 3] == pytest.approx([1.0, 2.1, 0.21], abs=1e-6)
    assert exposure.camera_pose[:3, 0] == pytest.approx([0, 0, -1], abs=1e-6)
    assert exposure.camera_pose[:3, 2] == pytest.approx([0, 1, 0], abs=1e-6)
    assert np.array_equal(exposure.poses, parts.poses())


def test_both_links_of_a_body_have_poses():
    door = ('<link name="a"><pose>3 0 1 0 0 0</pose></link><link name="b"><pose>3 0 2 0 0 0</pose>'
            '</link><joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>'
            '0 0 1</xyz></axis></joint>')
    poses = Parts(assemble(sdf(model('m', door)))).poses()
    assert poses[:2, :3] == pytest.approx(np.array([[3.0, 0, 1], [3, 0, 2]]))


def test_the_frame_of_the_images_is_where_the_camera_is():
    frame = robot_camera.optical_frame(CameraSettings(
        camera_x=1.0, camera_y=2.0, camera_z=3.0, camera_yaw=math.pi / 2))
    assert frame.translation.tolist() == [1.0, 2.0, 3.0]
    # x to the right is along the link's x, z forward along its y
    assert frame.rotation == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))


@pytest.mark.parametrize('turn, is_warned', [
    ('-1.57 0 -1.57', False), ('-1.57 0 -1.59', True), ('0 0 0', True), ('-1.57 0 1.57', True),
    (None, False)])
def test_a_link_that_is_not_turned_like_an_image_is_warned_of(turn, is_warned):
    link = '' if turn is None else (
        '<link name="lens"/><joint name="j" type="fixed"><parent link="base_scan"/><child '
        'link="lens"/><origin rpy="{}"/></joint>'.format(turn))
    robot = assemble(yaw=1.0, urdf=burger().replace(
        '</robot>', link + '</robot>')).robots[0].body
    line = robot_camera.warning_about_frame(robot, CameraSettings(
        camera_frame='base_scan', camera_optical_frame='lens'))
    assert line.startswith('the images of the camera on base_scan have the frame lens, a link '
                           'that is not turned like an image') is is_warned
    same = CameraSettings(camera_frame='base_scan', camera_optical_frame='base_scan')
    assert 'have the frame base_scan' in robot_camera.warning_about_frame(robot, same)


def test_a_mounted_camera_is_read_at_its_rate_while_it_is_enabled():
    built = assemble(cameras=[CameraSettings(camera_frame='base_link', camera_rate=rate)
                              for rate in (30.0, 10.0)])
    robot = built.robots[0]
    name, second = robot.mounted.cameras

    def times(sensor, steps):
        return [round(each.time_s, 6) for each in built.advance(steps)
                if each.sensor == sensor]
    assert (name, second) == ('camera', 'camera_2') and times(name, 100) == []
    robot.mounted.set_enabled(name, True)
    assert times(name, 100) == [0.132, 0.165, 0.198]
    robot.mounted.set_enabled(name, False)
    robot.mounted.set_enabled(second, True)
    assert times(name, 1) == [] and times(second, 299) == [0.3, 0.4, 0.5]
