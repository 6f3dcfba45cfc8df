"""Which camera of a robot replay.py uses."""
import pytest

from img_recog.errors import UserError
from img_recog.replay import cli
from img_recog.simulation.settings import CameraSettings
from img_recog_testing.robots import assemble, burger

TAG = ('<gazebo reference="{}"><sensor type="camera" name="c"><camera><image><width>{}</width>'
       '<height>48</height></image></camera><plugin name="p" filename="libgazebo_ros_camera.so">'
       '<updateRate>10</updateRate></plugin></sensor></gazebo>')


def robot(*tags):
    return burger().replace('</robot>', ''.join(tags) + '</robot>')


def test_the_burger_has_a_camera_at_its_mount():
    assert cli.camera_settings(assemble()) == CameraSettings(
        camera_frame='camera_link', camera_optical_frame='head_camera', camera_width=640,
        camera_height=480, camera_rate=30.0)


def test_the_first_camera_of_the_tags_is_used():
    built = assemble(urdf=robot(TAG.format('base_scan', 64), TAG.format('camera_link', 80)))
    settings = cli.camera_settings(built)
    assert (settings.camera_frame, settings.camera_width, settings.camera_rate) == (
        'base_scan', 64, 10.0)


def test_a_robot_without_a_camera_is_refused():
    with pytest.raises(UserError) as refused:
        cli.camera_settings(assemble(urdf=burger().replace('camera_link', 'mount')))
    assert refused.value.problem == (
        '--camera robot: the robot has no camera: neither a <sensor type="camera"> in its URDF '
        'nor a link camera_link')
    assert '--urdf' in refused.value.advice
