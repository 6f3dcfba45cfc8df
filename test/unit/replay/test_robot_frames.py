"""Frames of a camera on the simulated robot."""
import math

import numpy as np
import pytest

from img_recog.errors import SimulationError
from img_recog.rendering.light import LightSettings
from img_recog.replay.robot_frames import RobotFrames
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog_helpers.robots import assemble
from img_recog_helpers.sdf import BUILT_IN, sdf

SETTINGS = CameraSettings(camera_frame='base_link', camera_z=0.15, camera_x=0.05, camera_width=64,
                          camera_height=48, camera_rate=30.0, camera_optical_frame='lens')
POST = ('<model name="post"><static>1</static><pose>2 0 0.25 0 0 0</pose><link name="l">'
        '<visual name="v"><geometry><cylinder><radius>0.15</radius><length>0.5</length></cylinder>'
        '</geometry><material><script><name>Gazebo/Blue</name></script></material></visual>'
        '</link></model>')


@pytest.fixture
def field(tmp_path):
    """The path of a world with a blue post ahead of the origin."""
    path = tmp_path / 'field.world'
    path.write_text(sdf(BUILT_IN, POST))
    return str(path)


def blue_px(image):
    return int(np.count_nonzero((image[:, :, 2] > 100) & (image[:, :, 0] < 60)))


def test_frames_at_the_period_of_the_camera_with_their_time(field):
    frames = RobotFrames(assemble(field), SETTINGS, 0.2)
    assert frames.period_ns == 33000000 and frames.expected == 6 and frames.warnings == []
    simulated = []
    frames.follow(simulated.append)
    taken = list(frames)
    assert simulated == [number * 33000000 for number in range(6)]
    assert [(frame.number, frame.stamp_ns) for frame in taken] == list(enumerate(simulated))
    assert taken[2].header.stamp.to_nsec() == 66000000 and taken[2].header.frame_id == 'lens'
    assert taken[0].image.shape == (48, 64, 3) and taken[0].encoding == 'rgb8'
    assert frames.camera_infos()(taken[0]).K[2] == pytest.approx(32, abs=0.5)


def test_a_frame_shows_where_the_robot_is_at_its_time(field):
    built = assemble(field)
    frames = RobotFrames(built, SETTINGS, 1.0)
    frames.follow(lambda time_ns: built.advance(
        round(time_ns / 1e6) - round(built.time_s * 1000)))
    built.robots[0].command(0.5, 0.0)
    areas = [blue_px(frame.image) for frame in frames]
    assert areas[0] > 50 and areas[-1] > 1.2 * areas[0]
    turned = RobotFrames(assemble(field, yaw=math.pi), SETTINGS, 0.01)
    assert [blue_px(frame.image) for frame in turned] == [0]


def test_equal_runs_give_equal_images(field):
    def images():
        frames = RobotFrames(assemble(field), SETTINGS, 0.1)
        return [frame.image.tobytes() for frame in frames]
    assert images() == images()


def test_noise_differs_from_frame_to_frame_and_not_from_run_to_run(field):
    noisy = CameraSettings(**{**vars(SETTINGS), 'camera_noise': 0.05})
    runs = [[frame.image for frame in RobotFrames(assemble(field), noisy, 0.07)]
            for _ in range(2)]
    assert len(runs[0]) == 2 and not np.array_equal(*runs[0])
    assert all(np.array_equal(*pair) for pair in zip(*runs))


def test_seed_of_the_noise_and_light(field):
    noisy = CameraSettings(**{**vars(SETTINGS), 'camera_noise': 0.05})

    def first(settings, *options):
        return next(iter(RobotFrames(assemble(field), settings, 0.03, *options))).image
    plain = first(SETTINGS)
    lamp = first(SETTINGS, LightSettings(light_temperature=2700.0))
    assert plain[:, :, 2].sum() > 1.5 * lamp[:, :, 2].sum()
    seeds = [first(noisy, LightSettings(), seed) for seed in (1, 1, 2)]
    assert np.array_equal(seeds[0], seeds[1]) and not np.array_equal(seeds[0], seeds[2])


def test_a_link_that_the_robot_does_not_have_is_refused(field):
    with pytest.raises(SimulationError, match='camera_frame: the robot has no link eye'):
        RobotFrames(assemble(field), CameraSettings(camera_frame='eye'), 1.0)
