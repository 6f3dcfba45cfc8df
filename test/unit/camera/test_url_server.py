"""Streams and videos that a server sends."""
import collections
import http.server
import os
import threading
import time

import numpy as np
import pytest

from img_recog.camera.capture import Capture, Listener
from img_recog.camera.selection import open_source
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.url_source import RemoteVideoSource, StreamSource
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers.videos import smooth_image
from img_recog_helpers.waiting import wait_for


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


class LiveSegments(http.server.ThreadingHTTPServer):
    """Serves a live playlist: two segments of 3 s, and one more each 3 s.

    fetched: how often each segment was.
    """

    def __init__(self, folder):
        super().__init__(('127.0.0.1', 0), self._handler(str(folder)))
        self.begin_s, self.fetched = time.monotonic(), collections.Counter()
        self.thread = threading.Thread(target=self.serve_forever, args=(0.02,), daemon=True)
        self.thread.start()

    def playlist(self):
        count = 2 + int((time.monotonic() - self.begin_s) / 3)
        return ''.join(['#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:3\n', *(
            '#EXTINF:3.0,\n{}.ts\n'.format(number) for number in range(min(count, 5)))]).encode()

    @staticmethod
    def _handler(folder):
        class Handler(http.server.BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def do_GET(self):
                name = self.path.strip('/')
                if name == 'live.m3u8':
                    data = self.server.playlist()
                else:
                    self.server.fetched[name] += 1
                    with open(os.path.join(folder, name), 'rb') as file:
                        data = file.read()
                self.send_response(200)
                self.send_header('Content-Length', str(len(data)))
                self.end_headers()
                self.wfile.write(data)
        return Handler


class Times(Listener):
    """When there were frames, and how often they were lost."""

    def __init__(self):
        self.frames_s, self.losses = [], []

    def frame(self, source, image):
        self.frames_s.append(time.monotonic())

    def lost(self, reason):
        self.losses.append(reason)

    def failed(self, error, opening):
        self.losses.append(str(error))


def test_live_segments_play_at_their_rate_and_are_fetched_once(make_film, tmp_path):
    make_film('x.m3u8', '-c:v', 'mpeg2video', '-g', '75', '-f', 'hls', '-hls_time', '3',
              '-hls_list_size', '0', '-hls_segment_filename', str(tmp_path / '%d.ts'), seconds=15,
              source='testsrc2=size=96x64:rate=25')
    server, times = LiveSegments(tmp_path), Times()
    url = 'http://127.0.0.1:{}/live.m3u8'.format(server.server_port)
    capture = Capture(lambda: open_source(UsbCamSettings(video_device=url)), times)
    capture.start_thread()
    capture.start()
    # into the third segment, which is listed 3 s after the first two
    wait_for(lambda: capture.check() or times.losses or len(times.frames_s) > 180, 'frames')
    capture.shut_down()
    server.shutdown()
    server.server_close()
    assert times.losses == []
    assert set(server.fetched.values()) == {1}, server.fetched
    assert times.frames_s[150] - times.frames_s[0] > 5.5        # no burst
