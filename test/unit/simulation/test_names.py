"""The names of the topics and frames of one of several robots."""
from img_recog.simulation.simulation_settings import CameraSettings, Names

CAMERA = CameraSettings(camera_frame='camera_link', camera_image_topic='eye/image',
                        camera_info_topic='/eye/info')


def test_the_names_of_a_camera():
    assert Names().seen(CAMERA) == CAMERA
    camera = Names('tb3_1', 'one').seen(CAMERA)
    assert (camera.camera_image_topic, camera.camera_info_topic, camera.camera_depth_topic) == (
        'tb3_1/eye/image', '/eye/info', '')
    assert (camera.camera_frame, camera.camera_optical_frame) == (
        'one/camera_link', 'one/camera_rgb_optical_frame')
    assert Names('tb3_1', 'one').seen(CameraSettings()).camera_frame == ''
