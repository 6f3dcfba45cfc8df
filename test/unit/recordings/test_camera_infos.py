"""The camera info of each frame of a replay."""
import genpy
import numpy as np
import pytest
import rosbag
from sensor_msgs.msg import CameraInfo, Image

from img_recog.camera.calibration import Calibration
from img_recog.errors import UserError
from img_recog.recordings.bags import BagFrames
from img_recog.recordings.camera_infos import of_calibration
from img_recog_helpers.replaying import frame

CALIBRATION = Calibration('', 400, 80, 'plumb_bob', (0.1,) * 5,
                          (300.0, 0.0, 200.0, 0.0, 300.0, 40.0, 0.0, 0.0, 1.0), (0.0,) * 9,
                          (0.0,) * 12)


def test_a_calibration_is_scaled_to_the_frame():
    info = of_calibration(CALIBRATION)(frame(0, 5))
    assert (info.width, info.height, info.K[0], info.distortion_model) == (
        200, 40, 150.0, 'plumb_bob')
    square = frame(0, 0)._replace(image=np.zeros((9, 9, 3), np.uint8))
    with pytest.raises(UserError, match='another aspect ratio'):
        of_calibration(CALIBRATION)(square)


def test_without_a_calibration_only_the_size_is_known():
    info = of_calibration(None)(frame(0, 5))
    assert (info.width, info.height, set(info.K), info.D) == (200, 40, {0.0}, [])


def written(path, image_topic, infos, info_topic='/robot1/eye/camera_info'):
    """Write three images at 1, 2 and 3 s, and camera infos (time in s, focal length)."""
    with rosbag.Bag(str(path), 'w') as bag:
        for number in (1, 2, 3):
            msg = Image(height=2, width=2, encoding='bgr8', step=6, data=bytes(12))
            msg.header.stamp.secs = number
            bag.write(image_topic, msg, genpy.Time(10 + number))
        for time_s, focal_length in infos:
            msg = CameraInfo(width=2, height=2, binning_x=2)
            msg.header.stamp = genpy.Time.from_sec(time_s)
            msg.K[0] = focal_length
            bag.write(info_topic, msg, genpy.Time(20))
    return BagFrames(str(path))


@pytest.mark.parametrize('topic', ['/robot1/eye/image_raw', '/robot1/eye/image_raw/compressed'])
@pytest.mark.parametrize('infos, lengths', [
    ([(1, 7.0), (2, 7.0), (2.5, 8.0)], [7.0, 7.0, 8.0]),
    ([(2.5, 8.0), (1, 7.0)], [7.0, 7.0, 8.0]),      # recorded in another order
    ([(2, 9.0)], [9.0, 9.0, 9.0]),
    ([], [0.0, 0.0, 0.0])])
def test_those_of_a_bag_are_the_last_ones_before_the_image(tmp_path, infos, lengths, topic):
    frames = written(tmp_path / 'a.bag', topic, infos)
    camera_info = frames.camera_infos()
    found = [camera_info(each) for each in frames]
    assert [info.K[0] for info in found] == lengths
    assert all(type(info) is CameraInfo and (info.width, info.height) == (2, 2)
               for info in found)
    assert {info.binning_x for info in found} == {2 if infos else 0}


@pytest.mark.parametrize('topic', ['/other/camera_info', '/robot1/eye/image_raw/camera_info'])
def test_those_of_another_camera_are_not_used(tmp_path, topic):
    frames = written(tmp_path / 'a.bag', '/robot1/eye/image_raw', [(1, 7.0)], topic)
    assert frames.camera_infos()(frame(0, 0)).K[0] == 0.0


@pytest.mark.parametrize('name, value', [('_type', 'a/CameraInfo'), ('_md5sum', '0')])
def test_what_is_no_camera_info_is_left_out(tmp_path, monkeypatch, name, value):
    frames = written(tmp_path / 'a.bag', '/robot1/eye/image_raw', [(1, 7.0)])
    monkeypatch.setattr(CameraInfo, name, value)
    assert frames.camera_infos()(frame(0, 5)).width == 200
