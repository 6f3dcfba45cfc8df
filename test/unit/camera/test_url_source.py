"""Streams, videos and pictures at URLs: what is told apart, and what ends them."""
import functools
import http.server
import os
import socket
import threading

import cv2
import numpy as np
import pytest

from img_recog.camera import url_source, urls
from img_recog.camera.image_source import ImageSource
from img_recog.camera.selection import open_source
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.url_source import RemoteVideoSource, StreamSource
from img_recog_testing.videos import smooth_image

IMAGE = np.zeros((48, 64, 3), np.uint8)


class FakeCapture:
    """Does the steps it is given: True is a frame, False none; numbers are seconds before one.

    properties: what it says of itself, by the name in OpenCV without CAP_PROP_.
    """

    def __init__(self, clock, steps, **properties):
        self._clock, self._steps, self.released = clock, list(steps), False
        self._properties = {getattr(cv2, 'CAP_PROP_' + name): value
                            for name, value in properties.items()}

    def isOpened(self):
        return True

    def get(self, number):
        return self._properties.get(number, 0.0)

    def read(self):
        step = self._steps.pop(0)
        if not isinstance(step, bool):
            self._clock.advance(abs(step))
            step = step > 0
        return (True, IMAGE) if step else (False, None)

    def release(self):
        self.released = True


def stream(clock, *steps, **options):
    return StreamSource('rtsp://camera/live', FakeCapture(clock, steps, FPS=25.0), now=clock,
                        **options)


def results(source):
    """What each read gives until the source ends: frame or skipped, and the error at last."""
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


def test_damaged_frames_of_a_stream_are_skipped_one_by_one(clock):
    end = [False] * 4
    found, error = results(stream(clock, True, 0.1, -0.1, 0.1, -0.1, -0.1, 0.1, *end))
    assert found == ['frame', 'frame', 'skipped', 'frame', 'skipped', 'skipped', 'frame']
    assert error == 'rtsp://camera/live gives no more frames: ended or silent'


def test_stream_that_begins_with_a_damaged_frame_is_opened(clock):
    found, _ = results(stream(clock, False, True, *[False] * 4))
    assert found == ['skipped', 'frame']


@pytest.mark.parametrize('step', [-2.0, 2.0])       # with half a frame at last
def test_time_without_a_frame_ends_a_stream_at_once(clock, step):
    found, error = results(stream(clock, True, True, step))
    assert found == ['frame'] * 2 and error.endswith('gives no more frames: ended or silent')


def test_damaged_frames_that_come_in_time_do_not_end_it(clock):
    steps = [True, *[-0.1] * 12, 0.1, *[False] * 3, True, *[False] * 4]
    found, _ = results(stream(clock, *steps))
    assert found == ['frame'] + ['skipped'] * 12 + ['frame'] + ['skipped'] * 3 + ['frame']


def test_stream_that_ends_after_its_first_frame_is_told_to_be_a_picture_perhaps(clock):
    assert results(stream(clock, True, *[False] * 4))[1] == (
        'rtsp://camera/live gives no more frames: ended or silent after the first; give a '
        'stream, not an image')


def test_damaged_frames_for_as_long_end_it_too(clock):
    assert results(stream(clock, True, -0.5, -0.5, -0.5, -0.5))[0] == ['frame']


def test_stream_without_a_first_frame_is_refused_and_closed(clock):
    capture = FakeCapture(clock, [False] * 4)
    with pytest.raises(SourceError, match='^cannot open x: no frame arrives'):
        StreamSource('x', capture, now=clock)
    assert capture.released


def test_rate_of_a_stream_is_known_where_it_is_announced(clock):
    assert stream(clock, True, announces_rate=True).expected_hz == 25.0
    assert stream(clock, True).expected_hz is None


def at_url(monkeypatch, capture, url, **settings):
    monkeypatch.setattr(url_source, '_open_capture', lambda given: capture)
    return open_source(CameraSettings(video_device=url, **settings))


# frame counts as OpenCV gives them
UNKNOWN = -9.223372036854776e+18


@pytest.mark.parametrize('url, count, kind', [
    ('http://h/f.avi?tok=1', 60, RemoteVideoSource), ('http://h/video', 60, RemoteVideoSource),
    ('https://h/recorded.webm?a=b.c', UNKNOWN, RemoteVideoSource),
    ('http://h/live', UNKNOWN, StreamSource), ('http://h/live', 0, StreamSource),
    ('http://h/live?file=video.mp4', UNKNOWN, StreamSource),
    ('http://h/stream.jpg', UNKNOWN, StreamSource), ('rtsp://h/video.mp4', 60, StreamSource),
    ('rtmp://h/live', UNKNOWN, StreamSource)])
def test_what_ffmpeg_says_tells_a_video_from_a_stream(clock, monkeypatch, url, count, kind):
    capture = FakeCapture(clock, [True] * 4, FPS=25.0, FRAME_COUNT=count)
    source = at_url(monkeypatch, capture, url)
    assert type(source) is kind
    assert source.rate_hz == (25.0 if kind is RemoteVideoSource else None)
    assert source.expected_hz == (25.0 if kind is RemoteVideoSource or url[0] == 'r' else None)


@pytest.mark.parametrize('url, count', [
    ('http://h/snapshot', 1), ('http://h/p.png?size=2', UNKNOWN), ('http://h/p.jpg', 1)])
def test_picture_at_a_url_is_a_still_image(clock, monkeypatch, url, count):
    capture = FakeCapture(clock, [True] + [False] * 4, FPS=25.0, FRAME_COUNT=count)
    source = at_url(monkeypatch, capture, url, framerate=5)
    assert isinstance(source, ImageSource) and capture.released
    assert (source.rate_hz, source.width, source.height) == (5.0, 64, 48)
    assert source.read().shape == source.read().shape == (48, 64, 3)


@pytest.mark.parametrize('steps, kind', [
    ([False, True] + [False] * 4, ImageSource), ([False, True, False, True], StreamSource)])
def test_damaged_frames_do_not_hide_what_is_called_a_picture(clock, monkeypatch, steps, kind):
    capture = FakeCapture(clock, steps, FPS=25.0, FRAME_COUNT=UNKNOWN)
    assert type(at_url(monkeypatch, capture, 'http://h/p.jpg')) is kind


def remote_video(clock, *steps, loop=True, warnings=None, count=4):
    capture = FakeCapture(clock, steps, FPS=25.0, FRAME_COUNT=count)
    return RemoteVideoSource('http://me:secret@h/f.mp4?key=secret', capture, loop,
                             (warnings if warnings is not None else []).append, clock)


@pytest.mark.parametrize('step', [-2.0, 2.0])       # with half a frame at last
@pytest.mark.parametrize('loop', [True, False])
def test_video_that_stalls_says_so_and_is_waited_for_if_it_loops(clock, loop, step):
    source = remote_video(clock, True, True, step, loop=loop)
    source.read()
    with pytest.raises(SourceError) as stalled:
        source.read()
    assert str(stalled.value) == (
        'the video http://h/f.mp4?... stalls: its server has sent nothing for 2.0 s')
    assert source.reconnects == loop and (source.stall_timeout_s is not None) == loop


def test_video_that_is_cut_short_by_its_server_says_so(clock):
    warnings = []
    source = remote_video(clock, True, False, loop=False, warnings=warnings)
    source.read()
    with pytest.raises(SourceEnded):
        source.read()
    assert warnings == ['the video http://h/f.mp4?... breaks off after 1 of 4 frames: truncated '
                        'or damaged, or its server closed the connection']


def test_video_whose_server_is_gone_at_the_seam_is_not_called_replaced(clock, monkeypatch):
    source = remote_video(clock, True, False, count=1)
    monkeypatch.setattr(url_source, '_open_capture', lambda _: FakeCapture(clock, [False]))
    with pytest.raises(SourceError, match='its server is gone, or has another video now$'):
        source.read()


def test_video_that_gives_no_frame_at_all_hints_at_range_requests(clock):
    with pytest.raises(SourceError, match='a server without range requests cannot serve an .mp4'):
        remote_video(clock, False)


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
    assert urls.redacted(url) == shown


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves files, and at /live... a stream of pictures, of which some may be damaged."""

    def log_message(self, *_):
        pass

    def do_GET(self):
        try:
            if self.path.startswith('/live'):
                self._stream()
            else:
                super().do_GET()
        except OSError:         # closed by the other side, which has seen enough
            pass

    def _stream(self):
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=next')
        self.end_headers()
        for number in range(12):
            picture = cv2.imencode('.jpg', smooth_image(number % 6))[1].tobytes()
            if 'damaged' in self.path and number == 6:
                picture = picture[:200]
            self.wfile.write(b'--next\r\nContent-Type: image/jpeg\r\nContent-Length: '
                             + str(len(picture)).encode() + b'\r\n\r\n' + picture + b'\r\n')


@pytest.fixture
def serve(tmp_path):
    """The address of a server of the files in tmp_path, without http://."""
    server = http.server.ThreadingHTTPServer(
        ('127.0.0.1', 0), functools.partial(Handler, directory=str(tmp_path)))
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    yield '127.0.0.1:{}/'.format(server.server_port)
    server.shutdown()
    server.server_close()
    thread.join()


def opened(url, **settings):
    return open_source(CameraSettings(video_device=url, **settings))


@pytest.mark.parametrize('scheme, name', [
    ('http', 'video.avi'), ('HTTP', 'video.avi'), ('http', 'video.avi?tok=1'), ('http', 'video')])
def test_video_at_a_url_plays_at_its_own_rate_and_ends(make_video, serve, scheme, name):
    path = make_video()
    os.rename(path, os.path.join(os.path.dirname(path), name.split('?')[0]))
    source = opened('{}://{}{}'.format(scheme, serve, name), loop=False)
    assert isinstance(source, RemoteVideoSource) and source.rate_hz == 12.5
    for _ in range(6):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceEnded):
        source.read()
    source.close()


def test_video_at_a_url_loops(make_video, serve):
    make_video()
    source = opened('http://{}video.avi'.format(serve))
    for number in list(range(6)) * 2:
        wanted = smooth_image(number)[..., ::-1].astype(int)
        assert np.abs(source.read() - wanted).mean() < 3.0, number
    source.close()


@pytest.mark.parametrize('name', ['still.png', 'still.jpg'])
def test_picture_at_a_url_is_fetched_once(tmp_path, serve, name):
    assert cv2.imwrite(str(tmp_path / name), smooth_image(1))
    source = opened('http://{}{}'.format(serve, name), framerate=4)
    (tmp_path / name).unlink()
    assert isinstance(source, ImageSource) and source.rate_hz == 4.0
    for _ in range(3):
        assert np.abs(source.read() - smooth_image(1)[..., ::-1].astype(int)).mean() < 3.0


def test_stream_gives_frames_as_they_come_and_then_is_worth_waiting_for(serve):
    source = opened('http://{}live'.format(serve))
    assert isinstance(source, StreamSource)
    assert (source.rate_hz, source.reconnects, source.width, source.height) == (None, True, 96, 64)
    assert source.expected_hz is None
    for _ in range(12):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceError, match='live gives no more frames: ended or silent$'):
        source.read()
    source.close()


def test_stream_called_a_picture_is_a_stream(serve):
    source = opened('http://{}live.jpg'.format(serve))
    assert isinstance(source, StreamSource) and source.read().shape == (64, 96, 3)
    source.close()


def test_stream_with_a_damaged_frame_goes_on(serve):
    source, good, skipped = opened('http://{}live-damaged'.format(serve)), 0, 0
    while good < 11:
        try:
            source.read()
            good += 1
        except FrameSkipped:
            skipped += 1
    assert skipped == 1
    source.close()


def test_video_with_its_index_at_the_end_is_refused_with_a_hint(make_video, serve):
    make_video('video.mp4', 'mp4v', frames=60, size=(640, 480))
    with pytest.raises(SourceError) as refused:
        opened('http://{}video.mp4'.format(serve))
    assert str(refused.value) == (
        'cannot play http://{}video.mp4: no video that OpenCV reads from there (a server without '
        'range requests cannot serve an .mp4 whose index is at its end)'.format(serve))


def test_stream_that_nobody_serves_is_refused_without_its_password():
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        port = free.getsockname()[1]
    with pytest.raises(SourceError) as refused:
        opened('http://me:secret@127.0.0.1:{}/live'.format(port))
    assert str(refused.value).startswith('cannot open http://127.0.0.1:{}/live: '.format(port))
