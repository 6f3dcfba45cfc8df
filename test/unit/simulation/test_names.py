"""The names of the topics and frames of one of several robots."""
from img_recog.simulation.names import Names
from img_recog.simulation.simulation_settings import CameraSettings

CAMERA = CameraSettings(camera_frame='camera_link', camera_image_topic='eye/image',
                        camera_info_topic='/eye/info')


def test_a_single_robot_has_plain_names():
    names = Names()
    assert (names.topic('odom'), names.frame('odom'), names.words) == ('odom', 'odom', 'the robot')
    assert names.seen(CAMERA) == CAMERA


def test_one_of_several_has_a_namespace_and_a_prefix():
    names = Names('tb3_1', 'one')
    assert (names.topic('odom'), names.topic('/odom')) == ('tb3_1/odom', '/odom')
    assert (names.frame('odom'), names.words) == ('one/odom', 'robot tb3_1')
    camera = names.seen(CAMERA)
    assert (camera.camera_image_topic, camera.camera_info_topic, camera.camera_depth_topic) == (
        'tb3_1/eye/image', '/eye/info', '')
    assert (camera.camera_frame, camera.camera_optical_frame) == (
        'one/camera_link', 'one/camera_rgb_optical_frame')
