"""Streams and videos that a server sends."""
import os

import numpy as np
import pytest

from img_recog.camera.selection import open_source
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.url_source import RemoteVideoSource, StreamSource
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers.videos import smooth_image


def opened(url, **settings):
    return open_source(UsbCamSettings(video_device=url, **settings))


@pytest.mark.parametrize('scheme, name', [
    ('http', 'video.avi'), ('HTTP', 'video.avi'), ('http', 'video.avi?tok=1'), ('http', 'video')])
def test_video_at_a_url_plays_at_its_own_rate_and_ends(make_video, served, scheme, name):
    path = make_video()
    os.rename(path, os.path.join(os.path.dirname(path), name.split('?')[0]))
    source = opened('{}://{}{}'.format(scheme, served, name), loop=False)
    assert isinstance(source, RemoteVideoSource) and source.rate_hz == 12.5
    for number in range(6):
        wanted = smooth_image(number)[..., ::-1].astype(int)
        assert np.abs(source.read() - wanted).mean() < 3.0, number
    with pytest.raises(SourceEnded):
        source.read()
    source.close()


def test_stream_ends_after_its_frames_and_reconnects(served):
    source = opened('http://{}live'.format(served))
    assert isinstance(source, StreamSource)
    assert (source.rate_hz, source.reconnects, source.width, source.height) == (None, True, 96, 64)
    for _ in range(12):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceError, match='live gives no more frames: ended or silent$'):
        source.read()
    source.close()


def test_stream_whose_size_changes_goes_on_with_the_new_size(served):
    source = opened('http://{}live-turned'.format(served))
    for number in range(12):
        wanted = smooth_image(number, *((64, 96) if number >= 6 else ()))[..., ::-1].astype(int)
        assert np.abs(source.read() - wanted).mean() < 3.0, number      # no old one is repeated
        assert (source.height, source.width) == wanted.shape[:2]
    source.close()


def test_stream_with_a_damaged_frame_continues(served):
    source, good, skipped = opened('http://{}live-damaged'.format(served)), 0, 0
    while good < 11:
        try:
            source.read()
            good += 1
        except FrameSkipped:
            skipped += 1
    assert skipped == 1
    source.close()


def test_video_with_its_index_at_the_end_is_refused(make_video, served):
    make_video('video.mp4', 'mp4v', frames=60, size=(640, 480))
    with pytest.raises(SourceError) as refused:
        opened('http://{}video.mp4'.format(served))
    assert str(refused.value) == (
        'cannot play http://{}video.mp4: FFmpeg decodes no frame of it (codec mpeg4): it has no '
        'decoder for that, or the server has no range requests and the index of the .mp4 is at '
        'its end'.format(served))
