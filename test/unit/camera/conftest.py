"""Films that ffmpeg writes, and a server of files and streams."""
import functools
import http.server
import subprocess
import threading

import cv2
import pytest

from img_recog_helpers.videos import smooth_image
from img_recog_helpers.waiting import DEADLINE_S


@pytest.fixture
def make_film(tmp_path):
    """A function that has ffmpeg write a film, by default of 96x64, and returns its path."""
    def make(name, *options, seconds=1.0, source='testsrc2=size=96x64:rate=10'):
        path = str(tmp_path / name)
        made = subprocess.run(
            ['ffmpeg', '-v', 'error', '-f', 'lavfi', '-i', source, '-t', str(seconds), *options,
             path], stderr=subprocess.PIPE, universal_newlines=True)
        assert made.returncode == 0, made.stderr
        return path
    return make


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves files, and at /live... 12 images, of which the path says what happens midway."""

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
            turned = 'turned' in self.path and number >= 6
            image = cv2.imencode('.jpg', smooth_image(number, *((64, 96) if turned else ())))[1]
            image = image.tobytes()
            if 'damaged' in self.path and number == 6:
                image = image[:200]
            self.wfile.write(b'--next\r\nContent-Type: image/jpeg\r\nContent-Length: '
                             + str(len(image)).encode() + b'\r\n\r\n' + image + b'\r\n')


@pytest.fixture
def served(tmp_path, monkeypatch):
    """The address of a server of the files in tmp_path, without http://."""
    for name in ('_OPEN_TIMEOUT_S', '_READ_TIMEOUT_S', '_STALL_TIMEOUT_S'):     # of a busy machine
        monkeypatch.setattr('img_recog.camera.url_source.' + name, DEADLINE_S)
    server = http.server.ThreadingHTTPServer(
        ('127.0.0.1', 0), functools.partial(Handler, directory=str(tmp_path)))
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    yield '127.0.0.1:{}/'.format(server.server_port)
    server.shutdown()
    server.server_close()
    thread.join()
