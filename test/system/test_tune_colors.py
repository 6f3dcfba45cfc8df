"""tune_colors.py as a user runs it; the tests read the images that it writes."""
import os
import re
import stat

import cv2
import numpy as np
import pytest

from img_recog.nodes.tune_colors import cli
from img_recog_testing.waiting import DEADLINE_S, stretch, wait_for

BLUE, RED, WALL = (215, 70, 25), (60, 25, 215), (190, 200, 206)      # BGR
WIDTH, HEIGHT = 1200, 1015          # of the picture with two colors
FRAME = (slice(48, 372), slice(33, 465))        # a 640x480 frame in it, without its border
BLUE_LINE = (r'^blue: (\d+) px, (above|below) the limit of 1000 px; '
             r'hue 50-150, saturation 100-255, value 100-255$')
RED_LINE = (r'^red: (\d+) px, (above|below) the limit of 1000 px; '
            r'hue 150-180, saturation 100-255, value 150-255$')


def card(color=BLUE):
    """Return a frame with a card of 320x240 px in its middle."""
    image = np.full((480, 640, 3), WALL, np.uint8)
    image[120:360, 160:480] = color
    return image


@pytest.fixture
def folder(tmp_path):
    """The working directory, with a frame of a blue card in it."""
    folder = tmp_path / 'here'
    folder.mkdir()
    assert cv2.imwrite(str(folder / 'card.png'), card())
    return folder


def start(ros, folder, *arguments, **env):
    if '--timeout' not in arguments:        # its default is for a machine that is not busy
        arguments = (*arguments, '--timeout', DEADLINE_S * stretch())
    return ros.start_node('tune_colors.py', *arguments, cwd=str(folder),
                          env=dict(ros.env, PWD=str(folder), **env))


class Here:
    """Runs the tool in this process, which is fast, and without a master."""

    def __init__(self, folder, capfd):
        self.folder, self._capfd = folder, capfd

    def run(self, *arguments):
        """Return the exit code, and all that was written to the terminal."""
        try:
            code = cli.main(arguments)
        except SystemExit as error:
            code = error.code
        return code, ''.join(self._capfd.readouterr())


@pytest.fixture
def here(ros, folder, capfd, monkeypatch):
    """The tool in this process, in the working directory of the tests."""
    monkeypatch.chdir(folder)
    for name, value in {**ros.env, 'PWD': str(folder)}.items():
        monkeypatch.setenv(name, value)
    return Here(folder, capfd)


def refusal(process, code=1):
    """Return the one line of a tool that ended with an error."""
    assert process.wait() == code, process.output
    lines = process.output.splitlines()
    assert len(lines) == 1, process.output
    return lines[0]


def lines(process):
    assert process.wait() == 0, process.output
    return process.output.splitlines()


def read(path):
    picture = cv2.imread(str(path))
    assert picture is not None, path
    return picture


def assert_shows(picture, frame):
    """Assert that a picture shows the frame in its place; edges may differ after scaling."""
    part = picture[FRAME]
    like = cv2.resize(frame, part.shape[1::-1], interpolation=cv2.INTER_AREA)
    differs = (np.abs(part.astype(int) - like).max(axis=2) > 8).mean()
    assert differs < 0.02, differs


def test_an_image_without_a_master(ros, folder):
    blue, red, path = lines(start(ros, folder, 'card.png'))
    assert re.match(BLUE_LINE, blue).groups() == ('76800', 'above')
    assert re.match(RED_LINE, red).groups() == ('0', 'below')
    assert path == str(folder / 'tune_colors.png')
    picture = read(path)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert_shows(picture, card())
    masked = picture[480:670, 33:295]
    assert (masked == 0).all(axis=2).mean() > 0.7 and (masked == BLUE).all(axis=2).mean() > 0.2
    assert (picture[760:955, 33:295] == 0).all()
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o644
    assert sorted(os.listdir(str(folder))) == ['card.png', 'tune_colors.png']


def test_colors_of_a_file(ros, folder):
    (folder / 'mine.yaml').write_text(
        'colors: [wall, blue]\nwall_hue_min: 170\nwall_hue_max: 30\nwall_saturation_min: 0\n'
        'wall_area_limit: 1000000\nblue_value_min: 230\n')
    wall, blue, path = lines(start(ros, folder, 'card.png', '--colors', 'mine.yaml', '--output',
                                   'why.png'))
    assert wall == ('wall: 230400 px, below the limit of 1000000 px; hue 170-30, saturation '
                    '0-255, value 100-255')
    assert blue.startswith('blue: 0 px, below') and 'value 230-255' in blue
    assert path == str(folder / 'why.png')
    assert_shows(read(path), card())


def test_a_frame_of_a_video(ros, folder):
    video = cv2.VideoWriter(str(folder / 'video.avi'), cv2.CAP_FFMPEG,
                            cv2.VideoWriter_fourcc(*'MJPG'), 10, (640, 480))
    if not video.isOpened():
        pytest.skip('this OpenCV cannot write a video')
    for color in (BLUE, RED):
        video.write(card(color))
    video.release()
    for frame, seen in (((), 'blue'), (('--frame', '0'), 'blue'), (('--frame', '1'), 'red')):
        *colors, path = lines(start(ros, folder, 'video.avi', *frame))
        above = [line.partition(':')[0] for line in colors if 'above' in line]
        assert above == [seen]
        assert_shows(read(path), card(BLUE if seen == 'blue' else RED))
    line = refusal(start(ros, folder, 'video.avi', '--frame', '2'))
    assert 'no frame 2' in line and 'after 2 frames' in line


FILE_CASES = {
    'no file': (('nix.jpg',), 'cannot open nix.jpg: no such file', 'name of a topic'),
    'empty': (('',), "cannot open ''", 'name of a topic'),
    'a folder': (('/usr',), 'cannot use /usr', 'name of a topic'),
    'a text': (('mine.txt',), 'mine.txt: neither a video nor an image', 'name of a topic'),
    'no master': (('/nix/image',), 'no file /nix/image', 'no master'),
    'frame of an image': (('card.png', '--frame', '1'), 'card.png is an image', 'no frame 1'),
    'frame of a topic': (('/nix', '--frame', '1'), '--frame needs a video', '/nix'),
    'watch a file': (('card.png', '--watch'), '--watch needs a topic', 'card.png is a file'),
    'no colors': (('card.png', '--colors', 'nix.yaml'), 'nix.yaml', 'No such file'),
    'bad colors': (('card.png', '--colors', 'mine.txt'), 'mine.txt', 'colors: [blue, red]'),
    'no place': (('card.png', '--output', '/nix/it.png'), 'write /nix/it.png', 'set --output'),
}


@pytest.mark.parametrize('arguments, named, advice', list(FILE_CASES.values()),
                         ids=list(FILE_CASES))
def test_refused_arguments(here, arguments, named, advice):
    folder = here.folder
    (folder / 'mine.txt').write_text('a letter\n')
    code, output = here.run(*arguments)
    assert code == 1, output
    line, = output.splitlines()
    assert line.startswith('tune_colors.py: ') and named in line and advice in line, line
    assert not (folder / 'tune_colors.png').exists()


def test_half_a_video(ros, folder):
    (folder / 'half.mp4').write_bytes(b'\0\0\0\x20ftypisom\0\0\2\0isomiso2avc1mp41\0\0\0\x08free')
    line = refusal(start(ros, folder, 'half.mp4'))      # without the messages of ffmpeg
    assert 'half.mp4: neither a video nor an image' in line and 'name of a topic' in line, line


@pytest.mark.parametrize('arguments, named', [
    ((), 'IMAGE_OR_TOPIC'), (('card.png', '--output', 'it.jpg'), '.png'),
    (('card.png', '--timeout', 'soon'), "'soon'"), (('card.png', '--timeout', '0'), "'0'"),
    (('card.png', '--frame', '-1'), 'frame'), (('card.png', '--nix'), '--nix'),
    (('/image', '--colors', 'x.yaml', '--node', '/x'), 'not allowed with')])
def test_usage(here, arguments, named):
    code, output = here.run(*arguments)
    assert code == 2, output
    assert named in output.splitlines()[-1], output
    assert 'usage: tune_colors.py' in output


@pytest.fixture
def camera(shared_ros, folder):
    """The master with a camera that shows the blue card, and no parameters of other tests."""
    master = shared_ros.master()
    for name in ('/color_extract', '/other'):
        master.deleteParam('/test', name)
    shared_ros.master = master
    process = shared_ros.start_node('usb_cam_node.py', '_framerate:=20',
                                    '_video_device:={}'.format(folder / 'card.png'))
    process.wait_output('camera: image')
    return shared_ros


def nodes(ros):
    """Return the names of all nodes."""
    state = ros.master.getSystemState('/test')[2]
    return {node for kind in state for _, names in kind for node in names}


@pytest.mark.parametrize('topic', ['/usb_cam/image_raw', 'usb_cam/image_raw/compressed'])
def test_a_topic(camera, folder, topic):
    seen = nodes(camera)
    blue, red, path = lines(start(camera, folder, topic))
    areas_px = [int(re.match(pattern, line).group(1))
                for pattern, line in ((BLUE_LINE, blue), (RED_LINE, red))]
    assert abs(areas_px[0] - 76800) < 800 and areas_px[1] == 0
    picture = read(path)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert_shows(picture, card())

    def leaves_no_name():
        nonlocal seen
        before, seen = seen, nodes(camera)
        if seen <= before:
            return True
        lines(start(camera, folder, topic))
        return False
    # it ends without the answer of a master that is busy; the name then stays
    wait_for(leaves_no_name, lambda: 'a run after which its name is gone: {}'.format(seen))
    assert '/usb_cam' in seen


def test_colors_of_the_running_node(camera, folder):
    camera.master.setParam('/test', '/color_extract', {'blue_hue_max': 112})
    camera.master.setParam('/test', '/other', {'colors': ['blue'], 'blue_area_limit': 76800})
    blue, red, _ = lines(start(camera, folder, '/usb_cam/image_raw'))
    assert blue == ('blue: 0 px, below the limit of 1000 px; hue 50-112, saturation 100-255, '
                    'value 100-255')
    blue, path = lines(start(camera, folder, '/usb_cam/image_raw', '--node', 'other'))
    assert blue.startswith('blue: 76800 px, not above the limit of 76800 px'), blue
    assert read(path).shape[0] < HEIGHT
    (folder / 'mine.yaml').write_text('colors: [red]\n')
    red, _ = lines(start(camera, folder, '/usb_cam/image_raw', '--colors', 'mine.yaml'))
    assert re.match(RED_LINE, red)


def test_watching_follows_the_parameters(camera, folder):
    watch = start(camera, folder, '/usb_cam/image_raw', '--watch')
    path = watch.wait_output(r'(?m)^/.*\.png$').group()
    blue = (slice(480, 670), slice(33, 295))
    wait_for(lambda: read(path)[blue].any(), 'the blue card')
    camera.master.setParam('/test', '/color_extract', {'blue_hue_max': 112})
    wait_for(lambda: not read(path)[blue].any(), 'a picture by the new bounds')
    camera.master.setParam('/test', '/color_extract', {'blue_hue_max': 1120})
    watch.wait_output(r'\[WARN\].*the picture is not updated: .*/color_extract/blue_hue_max')
    camera.master.setParam('/test', '/color_extract', {'blue_hue_max': 150})
    wait_for(lambda: read(path)[blue].any(), 'the blue card again')
    assert watch.interrupt() == 0
    assert 'Traceback' not in watch.output
    assert sorted(os.listdir(str(folder))) == ['card.png', 'tune_colors.png']


@pytest.mark.parametrize('arguments, named, advice', [
    (('/usb_cam/nix',), 'nobody publishes a topic /usb_cam/nix', '/usb_cam/image_raw,'),
    (('/usb_cam/camera_info',), 'has sensor_msgs/CameraInfo, no images', '/usb_cam/image_raw,'),
    (('/usb_cam/image_raw', '--node', '/nix'), 'no parameters of a node /nix', '--colors')])
def test_refused_arguments_with_a_topic(camera, folder, arguments, named, advice):
    line = refusal(start(camera, folder, *arguments))
    assert named in line and advice in line, line


def test_a_topic_without_an_image(shared_ros, folder):
    silent = shared_ros.start_node('usb_cam_node.py', '_video_device:=synthetic',
                                   '_create_suspended:=true')
    silent.wait_output('camera: suspended')
    line = refusal(start(shared_ros, folder, '/usb_cam/image_raw', '--timeout', '0.5'))
    assert 'no image received on /usb_cam/image_raw within 0.5 s' in line


def test_a_display_that_does_not_exist(ros, folder):
    *_, path, line = lines(start(ros, folder, 'card.png', DISPLAY=':nix'))
    assert line.startswith('no window: ') and line.endswith('the picture is only in the file')
    assert_shows(read(path), card())
    assert len(lines(start(ros, folder, 'card.png', '--no-window', DISPLAY=':nix'))) == 3


def test_without_tkinter(ros, folder, tmp_path):
    (tmp_path / 'tkinter.py').write_text('raise ImportError("not here")\n')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    *_, line = lines(start(ros, folder, 'card.png', DISPLAY=':0', PYTHONPATH=path))
    assert line == ('no window: tkinter cannot be loaded: not here; install python3-tk; the '
                    'picture is only in the file')
