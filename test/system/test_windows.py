"""The windows, on a display of their own that is photographed."""
import os
import re
import subprocess

import pytest

from waiting import wait_for

SIMULATOR = 'Bullet Physics'


@pytest.fixture
def display(ros):
    """A virtual display; the name of it is in ros.env afterwards."""
    reader, writer = os.pipe()
    server = ros.start('Xvfb', '-displayfd', writer, '-screen', '0', '1100x800x24', '-nolisten',
                       'tcp', pass_fds=[writer])
    os.close(writer)
    with os.fdopen(reader) as file:
        number = file.readline().strip()
    assert number, server.output
    ros.env['DISPLAY'] = ':' + number
    return ros.env['DISPLAY']


def shares(ros, tmp_path, **colours):
    """Return the share of the display's pixels within each range of RGB bounds, 0 to 255."""
    path = str(tmp_path / 'display.ppm')
    subprocess.run(['import', '-window', 'root', '-depth', '8', path], env=ros.env, check=True)
    cv2 = pytest.importorskip('cv2')
    image = cv2.imread(path)[..., ::-1]
    return {name: float(((image >= low) & (image <= high)).all(axis=2).mean())
            for name, (low, high) in colours.items()}


def test_image_view_shows_the_blue_part(ros, display, tmp_path):
    demo = ros.demo('simulator:=false', 'gui:=false', 'image_view:=false')
    demo.wait_output('camera: synthetic')
    ros.start('rosrun', 'image_view', 'image_view', 'image:=/blue_image')
    card = {'blue': ((0, 40, 180), (60, 100, 255)), 'red': ((180, 0, 30), (255, 60, 90))}

    def shown():
        found = shares(ros, tmp_path, **card)
        return found['blue'] > 0.01 and found['red'] == 0
    wait_for(shown, lambda: 'the blue card: {}'.format(shares(ros, tmp_path, **card)))


def test_the_simulators_window_shows_the_world(ros, display, tmp_path):
    demo = ros.demo('camera:=none', 'gui:=true', 'image_view:=false')
    colours = {'green': ((0, 90, 0), (60, 255, 60)), 'white': ((205, 205, 205), (255, 255, 255)),
               'wall': ((20, 20, 20), (90, 90, 90)), 'floor': ((130, 130, 130), (190, 190, 190))}

    def shown():
        found = shares(ros, tmp_path, **colours)
        return (found['green'] > 0.03 and found['white'] > 0.0005 and found['wall'] > 0.01
                and found['floor'] > 0.4)
    wait_for(shown, lambda: 'the world: {}'.format(shares(ros, tmp_path, **colours)))

    # closing the window, and the display under it, leaves the simulation running
    windows = subprocess.run(['xwininfo', '-root', '-tree'], env=ros.env, stdout=subprocess.PIPE,
                             check=False).stdout.decode()
    assert SIMULATOR in windows
    window = re.search(r'(0x[0-9a-f]+) "{}'.format(SIMULATOR), windows).group(1)
    subprocess.run(['xkill', '-id', window], env=ros.env, check=True, stdout=subprocess.DEVNULL)
    demo.wait_output('no window: .*the simulation goes on')
    ros.wait_run('clock:', 'rostopic', 'echo', '-n', '1', '/clock')
