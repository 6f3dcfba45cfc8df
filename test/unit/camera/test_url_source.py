"""Streams and videos at URLs, with a fake of the decoder."""
import numpy as np
import pytest
from av.error import FFmpegError

from img_recog.camera.selection import open_source
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError, redacted
from img_recog.camera.url_source import RemoteVideoSource, StreamSource
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers.fake_decoder import FakeDecoder


def stream(clock, *steps, **options):
    return StreamSource('rtsp://camera/live', FakeDecoder(clock, steps, rate_hz=25.0), now=clock,
                        **options)


def results(source):
    """Return the result of each read until the source ends, and the final error."""
    found = []
    while True:
        try:
            source.read()
            found.append('frame')
        except FrameSkipped as skipped:
            assert str(skipped) == 'rtsp://camera/live gave an empty or damaged frame'
            found.append('skipped')
        except SourceError as error:
            return found, str(error)


def test_segments_play_at_their_times_and_may_be_late(clock):
    """Whole seconds of frames are there at once, then none; segments that are skipped do not."""
    times_s = [7.0, 7.04, 7.08, 7.12, 67.0, 67.04, 8.0]
    decoder = FakeDecoder(clock, [True, True, True, 9.0, True, True, True, *END], rate_hz=25.0,
                          times_s=times_s, is_segmented=True)
    source = StreamSource('http://camera/live.m3u8', decoder, now=clock)
    assert (source.rate_hz, source.stall_timeout_s) == (25.0, 15.0)
    found = []
    for _ in times_s:
        source.read()
        found.append(source.time_s)
    assert found == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16, 0.20, 0.24])
    assert source.reconnects
    with pytest.raises(SourceError, match='gives no more frames'):
        source.read()


@pytest.mark.parametrize('url, read_s', [
    ('http://h/live.m3u8', 30.0), ('https://h/a/LIVE.M3U8?tok=1', 30.0), ('http://h/x.mpd', 30.0),
    ('http://h/?f=x.m3u', 30.0), ('http://h/m3u8', 2.0), ('rtsp://h/live', 2.0)])
def test_a_playlist_is_waited_for(clock, monkeypatch, url, read_s):
    decoder, seen = FakeDecoder(clock, [True] * 4), []
    monkeypatch.setattr('img_recog.camera.decoder.Decoder',
                        lambda *given: seen.append(given) or decoder)
    open_source(UsbCamSettings(video_device=url))
    assert seen == [(url, (5.0, read_s))]


def test_a_login_may_be_in_an_environment_variable(clock, monkeypatch):
    decoder, seen = FakeDecoder(clock, [True] * 4), []
    monkeypatch.setattr('img_recog.camera.decoder.Decoder',
                        lambda url, _: seen.append(url) or decoder)
    monkeypatch.setenv('CAMERA_LOGIN', 'me:s$1{x}')
    monkeypatch.setenv('K1', 'a')
    source = open_source(UsbCamSettings(video_device='rtsp://${CAMERA_LOGIN}@h/$1/live?k=${K1}'))
    assert seen == ['rtsp://me:s$1{x}@h/$1/live?k=a']
    assert source.name == 'rtsp://h/$1/live?...'
    with pytest.raises(SourceError) as refused:
        open_source(UsbCamSettings(video_device='rtsp://${CAMERA_LOGN}@h/live'))
    assert str(refused.value) == (
        'cannot open rtsp://h/live: the environment variable CAMERA_LOGN is not set; export it '
        'in the terminal of roslaunch')


END = [False]
GOOD, SKIPPED = ['frame'], ['skipped']


@pytest.mark.parametrize('steps, found', [
    # damaged frames are skipped one by one
    ([True, 0.1, -0.1, 0.1, -0.1, -0.1, 0.1, *END],
     ['frame', 'frame', 'skipped', 'frame', 'skipped', 'skipped', 'frame']),
    # those before the first frame are not counted
    ([-0.1, True, *END], GOOD),
    # and do not end it if they come in time
    ([True, *[-0.1] * 12, 0.1, *[-0.001] * 9, True, *END],
     GOOD + SKIPPED * 12 + GOOD + SKIPPED * 9 + GOOD),
    # a read that times out does, also if it returns an incomplete frame
    ([True, True, -2.0], GOOD * 2), ([True, True, 2.0], GOOD * 2),
    # a stall of 1.8 s
    ([True, *[-0.45] * 4, True, *END], GOOD + SKIPPED * 3),
    ([True, *[-0.4375] * 4, True, *END], GOOD + SKIPPED * 4 + GOOD)])
def test_failures_that_are_the_end_of_a_stream(clock, steps, found):
    clock.now_s = 0.0       # so that the sums are exact
    results_found, error = results(stream(clock, *steps))
    assert results_found == found
    assert error.startswith('rtsp://camera/live gives no more frames: ended or silent')


def test_stream_that_ends_after_its_first_frame_may_be_an_image(clock):
    assert results(stream(clock, True, *END))[1] == (
        'rtsp://camera/live gives no more frames: ended or silent after the first; give a stream '
        'or a video; an image has to be a file')


TOO_LARGE = 'cannot play {}: 64x48 are 3072 pixels, more than max_image_pixels = 3071; set'
URLS = ('rtsp://camera/live', 'http://camera/live', 'http://camera/still.jpg',
        'http://camera/video.mp4')


# what the decoder gives, and the size that it states
@pytest.mark.parametrize('url, steps, size, line', [
    ('rtsp://x', [False], {}, 'cannot open rtsp://x: no frame arrives'),
    ('http://x/f.mp4', [False], {}, 'cannot play http://x/f.mp4: FFmpeg decodes no frame of it '
     '(codec h264): it has no decoder for that, or the server has no range requests and the '
     'index'),
    *((url, [], {'width': 64, 'height': 48}, TOO_LARGE.format(url)) for url in URLS),
    *((url, [True], {}, TOO_LARGE.format(url)) for url in URLS)])
def test_what_is_not_playable_is_refused_and_closed(clock, monkeypatch, url, steps, size, line):
    decoder = FakeDecoder(clock, steps, rate_hz=25.0, **size)
    with pytest.raises(SourceError) as refused:
        at_url(monkeypatch, decoder, url, max_image_pixels=3071)
    assert str(refused.value).startswith(line) and decoder.released


def test_stream_that_grows_midway_ends(clock):
    decoder = FakeDecoder(clock, [True, np.zeros((49, 64, 3), np.uint8)], rate_hz=25.0)
    source = StreamSource('rtsp://camera/live', decoder, now=clock, max_pixels=3072)
    source.read()
    with pytest.raises(SourceError, match='64x49 are 3136 pixels, more than max_image_pixels'):
        source.read()


def at_url(monkeypatch, decoder, url, **settings):
    monkeypatch.setattr('img_recog.camera.decoder.Decoder', lambda *given: decoder)
    return open_source(UsbCamSettings(video_device=url, **settings))


UNKNOWN = 0     # the frame count of a stream


@pytest.mark.parametrize('url, count, source_class', [
    ('http://h/f.avi?tok=1', 60, RemoteVideoSource), ('http://h/video', 60, RemoteVideoSource),
    ('https://h/recorded.webm?a=b.c', UNKNOWN, RemoteVideoSource),
    *(('http://h/a.' + extension, UNKNOWN, RemoteVideoSource) for extension in (
        '3gp', 'avi', 'm2ts', 'm4v', 'mkv', 'mov', 'mp4', 'mpeg', 'mpg', 'mts', 'mxf', 'ogv',
        'vob', 'wmv', 'y4m', 'MP4')),
    ('http://h/a', 2, RemoteVideoSource),
    *(('http://h/' + name, UNKNOWN, StreamSource) for name in (
        'live', 'a.asf', 'a.flv', 'a.h264', 'a.mjpg', 'a.ts')),
    ('http://h/live?file=video.mp4', UNKNOWN, StreamSource),
    ('http://h/stream.jpg', UNKNOWN, StreamSource), ('rtsp://h/video.mp4', 60, StreamSource),
    ('rtmp://h/live', UNKNOWN, StreamSource)])
def test_video_and_stream_are_distinguished(clock, monkeypatch, url, count, source_class):
    decoder = FakeDecoder(clock, [True] * 4, rate_hz=25.0, frame_count=count)
    source = at_url(monkeypatch, decoder, url)
    assert type(source) is source_class
    assert source.rate_hz == (25.0 if source_class is RemoteVideoSource else None)
    is_announced = source_class is RemoteVideoSource or url[0] == 'r'
    assert source.expected_hz == (25.0 if is_announced else None)


def remote_video(clock, *steps, loop=True, warnings=None, count=4):
    decoder = FakeDecoder(clock, steps, rate_hz=25.0, frame_count=count)
    return RemoteVideoSource('http://me:secret@h/f.mp4?key=secret', decoder, loop,
                             (warnings if warnings is not None else []).append, clock)


@pytest.mark.parametrize('step', [(-2.0, False), (2.0,)])   # the latter: an incomplete frame
@pytest.mark.parametrize('loop', [True, False])
def test_video_that_stalls_is_an_error_and_reconnects_if_it_loops(clock, loop, step):
    source = remote_video(clock, True, True, *step, loop=loop)
    source.read()
    with pytest.raises(SourceError) as stalled:
        source.read()
    assert str(stalled.value) == (
        'the video http://h/f.mp4?... stalls: its server has sent nothing for 2.0 s')
    assert (source.reconnects, source.stall_timeout_s) == (loop, 1.8 if loop else None)


def test_video_that_is_truncated_by_its_server_is_one_warning(clock):
    warnings = []
    source = remote_video(clock, True, False, loop=False, warnings=warnings)
    source.read()
    with pytest.raises(SourceEnded):
        source.read()
    assert warnings == ['the video http://h/f.mp4?... breaks off after 1 of 4 frames: truncated '
                        'or damaged, or its server closed the connection']


@pytest.mark.parametrize('url, shown', [
    ('rtsp://user:pass@host:554/live', 'rtsp://host:554/live'),
    ('rtsp://user:p@ss@host/live', 'rtsp://host/live'),
    ('http://host/live?user=admin&password=secret', 'http://host/live?...'),
    ('http://u:p@host/a?k=s#t=s', 'http://host/a?...'), ('http://host/a#t=s', 'http://host/a#...'),
    ('http://host/@user/live', 'http://host/@user/live'),
    ('http://host:80/@user/live', 'http://host:80/@user/live'),
    ('http://u:pa/ss@host/live', 'http://host/live'),
    ('http://u:p?s@host/live', 'http://host/live'), ('http://u:p#s@host/live', 'http://host/live'),
    ('rtsp://[::1]:554/live', 'rtsp://[::1]:554/live'),
    ('/a/video?.mp4', '/a/video?.mp4'), ('synthetic', 'synthetic')])
def test_log_shows_no_password(url, shown):
    assert redacted(url) == shown


@pytest.mark.parametrize('rate_hz, expected_hz', [
    (-0.5, None), (0.0, None), (0.5, 0.5), (1000.0, 1000.0), (1000.5, None)])
def test_rate_that_cannot_be_right_is_not_known(clock, rate_hz, expected_hz):
    source = StreamSource('x', FakeDecoder(clock, [True], rate_hz=rate_hz), True, clock)
    assert source.expected_hz == expected_hz
    assert (source.name, source.description) == ('x', 'stream x, 64x48')
    assert source.reconnects is True and source.stall_timeout_s == 1.8


def test_ffmpeg_opens_for_five_seconds_and_reads_for_two(monkeypatch, clock):
    given, decoder = [], FakeDecoder(clock, [True], rate_hz=25.0)
    monkeypatch.setattr('img_recog.camera.decoder.Decoder',
                        lambda *args: given.append(args) or decoder)
    open_source(UsbCamSettings(video_device='rtsp://h'))
    assert given == [('rtsp://h', (5.0, 2.0))]


def test_stream_that_cannot_be_opened_is_refused(monkeypatch):
    def fail(*_):
        raise FFmpegError(1, 'not permitted')

    monkeypatch.setattr('img_recog.camera.decoder.Decoder', fail)
    with pytest.raises(SourceError) as refused:
        open_source(UsbCamSettings(video_device='rtsp://me:secret@h'))
    assert str(refused.value) == ('cannot open rtsp://h: no stream that FFmpeg plays, or not '
                                  'within 5 s; is its server running?')
