"""Streams and videos that a server sends."""
import functools
import http.server
import os
import socket
import threading

import cv2
import numpy as np
import pytest

from img_recog.camera.selection import open_source
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.url_source import RemoteVideoSource, StreamSource
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers.videos import smooth_image
from img_recog_helpers.waiting import DEADLINE_S


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves files, and at /live... a stream of images, one of them damaged on request."""

    def log_message(self, *_):
        pass

    def do_GET(self):
        try:
            if self.path.startswith('/live'):
                self._stream()
            else:
                super().do_GET()
        except OSError:         # the client has closed the connection
            pass

    def _stream(self):
        self.send_response(200)
        self.send_header('Content-Type', 'multipart/x-mixed-replace; boundary=next')
        self.end_headers()
        for number in range(12):
            image = cv2.imencode('.jpg', smooth_image(number % 6))[1].tobytes()
            if 'damaged' in self.path and number == 6:
                image = image[:200]
            self.wfile.write(b'--next\r\nContent-Type: image/jpeg\r\nContent-Length: '
                             + str(len(image)).encode() + b'\r\n\r\n' + image + b'\r\n')


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    """A busy machine may need longer for an answer."""
    for name in ('_OPEN_TIMEOUT_S', '_READ_TIMEOUT_S', '_STALL_TIMEOUT_S'):
        monkeypatch.setattr('img_recog.camera.url_source.' + name, DEADLINE_S)


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
    return open_source(UsbCamSettings(video_device=url, **settings))


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


def test_stream_ends_after_its_frames_and_reconnects(serve):
    source = opened('http://{}live'.format(serve))
    assert isinstance(source, StreamSource)
    assert (source.rate_hz, source.reconnects, source.width, source.height) == (None, True, 96, 64)
    assert source.expected_hz is None
    for _ in range(12):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceError, match='live gives no more frames: ended or silent$'):
        source.read()
    source.close()


def test_stream_with_the_name_of_an_image_is_a_stream(serve):
    source = opened('http://{}live.jpg'.format(serve))
    assert isinstance(source, StreamSource) and source.read().shape == (64, 96, 3)
    source.close()


def test_stream_with_a_damaged_frame_continues(serve):
    source, good, skipped = opened('http://{}live-damaged'.format(serve)), 0, 0
    while good < 11:
        try:
            source.read()
            good += 1
        except FrameSkipped:
            skipped += 1
    assert skipped == 1
    source.close()


def test_video_with_its_index_at_the_end_is_refused(make_video, serve):
    make_video('video.mp4', 'mp4v', frames=60, size=(640, 480))
    with pytest.raises(SourceError) as refused:
        opened('http://{}video.mp4'.format(serve))
    assert str(refused.value) == (
        'cannot play http://{}video.mp4: FFmpeg decodes no frame of it (codec mpeg4): it has no '
        'decoder for that, or the server has no range requests and the index of the .mp4 is at '
        'its end'.format(serve))


def test_error_of_a_stream_without_a_server_has_no_password():
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))         # so that no other program listens there
        port = free.getsockname()[1]
        with pytest.raises(SourceError) as refused:
            opened('http://me:secret@127.0.0.1:{}/live'.format(port))
    assert str(refused.value).startswith('cannot open http://127.0.0.1:{}/live: '.format(port))
