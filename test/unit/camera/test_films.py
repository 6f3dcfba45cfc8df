"""Films as phones, browsers and editors write them: times, upright images, several in a file."""
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from img_recog.camera.selection import open_file, open_source
from img_recog.camera.source import SourceEnded
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera.video_source import VideoSource
from img_recog.recordings import parts
from img_recog.recordings.films import FilmFrames
from img_recog_helpers.fake_decoder import FakeDecoder

# every third of 9 frames at 10 Hz, then all
UNEVEN = ['-vf', "select='not(mod(n,3))+gt(n,8)'", '-vsync', 'vfr']
UNEVEN_S = [0.0, 0.3, 0.6, 0.9, 1.0, 1.1]
H264 = ['-c:v', 'libx264', '-pix_fmt', 'yuv420p']


def times(source, count=50):
    """Return the times of the next frames of a source, at most `count`."""
    found = []
    try:
        while len(found) < count:
            source.read()
            found.append(source.time_s)
    except SourceEnded:
        pass
    finally:
        source.close()
    return found


@pytest.mark.parametrize('name, options', [
    ('a.mp4', H264), ('a.mkv', H264), ('a.webm', ['-c:v', 'libvpx', '-b:v', '200k'])])
def test_a_film_plays_at_the_times_of_its_frames(make_film, name, options):
    path, warnings = make_film(name, *UNEVEN, *options, seconds=1.2), []
    source = open_file(path, 30.0, loop=False, warn=warnings.append)
    assert 'variable rate' in source.description and source.expected_hz is None
    assert times(source) == pytest.approx(UNEVEN_S, abs=1e-3) and not warnings
    frames = FilmFrames(path)
    assert [frame.stamp_ns / 1e9 for frame in frames] == pytest.approx(UNEVEN_S, abs=1e-3)
    assert frames.period_ns / 1e9 == pytest.approx(0.1, abs=1e-3)


@pytest.mark.parametrize('name, options, rate_hz', [
    ('a.mkv', H264, 10.0), ('a.mkv', H264, 30000 / 1001),
    ('a.ts', H264, 10.0), ('a.h264', H264, 10.0), ('a.mjpeg', ['-c:v', 'mjpeg'], 25.0)])
def test_times_at_a_constant_rate_are_exact(make_film, name, options, rate_hz):
    made_hz = '30000/1001' if rate_hz == 30000 / 1001 else '10'
    path = make_film(name, *options, seconds=1.2,
                     source='testsrc2=size=96x64:rate={}'.format(made_hz))
    source = open_file(path, 30.0, loop=False)
    assert source.rate_hz == source.expected_hz == rate_hz
    found = times(source)
    assert len(found) >= 12 and found == [number / rate_hz for number in range(len(found))]


@pytest.mark.parametrize('stated_hz', [1000.0, 0.0])
def test_a_rate_that_is_wrong_or_missing_is_not_used(clock, stated_hz):
    decoder = FakeDecoder(clock, [True] * 4 + [False], stated_hz,
                          times_s=[0.0, 0.033, 0.067, 0.133])
    source = VideoSource('film.webm', loop=False, decoder=decoder)
    assert source.expected_hz is None and source.rate_hz == pytest.approx(1 / 0.033)
    assert times(source) == pytest.approx([0.0, 0.033, 0.067, 0.133])


@pytest.mark.parametrize('orientation, red', [
    (1, 'top left'), (2, 'top right'), (3, 'bottom right'), (4, 'bottom left'),
    (5, 'top left'), (6, 'top right'), (7, 'bottom right'), (8, 'bottom left')])
def test_an_image_is_upright(served, tmp_path, orientation, red):
    image = Image.new('RGB', (64, 48))
    image.paste((255, 0, 0), (0, 0, 32, 24))
    exif = image.getexif()
    exif[0x112] = orientation       # Exif 2.3, 4.6.4: where the first row and column are
    for name in ('phone.jpg', 'phone.png', 'phone.tif', 'phone.webp'):
        image.save(str(tmp_path / name), exif=exif)
    for device in (*map(str, sorted(tmp_path.iterdir())), 'http://' + served + 'phone.jpg'):
        source = open_source(UsbCamSettings(video_device=device))
        read = source.read()
        assert read.shape == ((48, 64, 3) if orientation < 5 else (64, 48, 3)), device
        row, column = red.split()
        quarter = read[:20] if row == 'top' else read[-20:]
        quarter = quarter[:, :20] if column == 'left' else quarter[:, -20:]
        assert quarter[..., 0].mean() > 230 and read[..., 0].mean() < 80, device
        source.close()


@pytest.mark.parametrize('name', ['a.webp', 'a.png', 'a.tif'])
def test_of_several_images_in_a_file_the_first_is_used_with_a_warning(tmp_path, name):
    path, warnings = str(tmp_path / name), []
    first, *others = (Image.fromarray(np.full((48, 64, 3), 60 * number, np.uint8))
                      for number in range(3))
    first.save(path, save_all=True, append_images=others)
    assert open_file(path, 30.0, warn=warnings.append).read().max() == 0
    assert warnings == ['{} has 3 images, only the first is used; convert it to a video, or write '
                        'each to a file of a folder'.format(path)]
    first.save(path)
    open_file(path, 30.0, warn=warnings.append)
    assert len(warnings) == 1


@pytest.mark.parametrize('name', ['10:30.avi', 'http:film.avi', 'topic:=film.avi'])
def test_a_path_with_a_colon_is_a_file(make_video, tmp_path, monkeypatch, name):
    make_video(name, frames=3)
    monkeypatch.chdir(tmp_path)
    assert len(list(FilmFrames(name))) == 3


# in a process of its own, which a crash would end
COUNT = """
import sys
from img_recog.camera.selection import open_source
from img_recog.camera.source import SourceEnded
from img_recog.camera.usb_cam_settings import UsbCamSettings
for device in sys.argv[1:]:
    source, count = open_source(UsbCamSettings(video_device=device, loop=False)), 0
    try:
        while True:
            source.read()
            count += 1
    except SourceEnded:
        print(count)
"""


@pytest.mark.parametrize('name, options', [
    ('a.flv', ['-c:v', 'flv']), ('a.mpg', ['-c:v', 'mpeg1video', '-r', '25']),
    ('b.mpg', ['-c:v', 'mpeg2video', '-r', '25'])])
def test_a_film_whose_streams_are_found_late(make_film, served, name, options):
    path = make_film(name, *options, seconds=1.2)
    found = subprocess.run([sys.executable, '-c', COUNT, path, 'http://' + served + name],
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                           universal_newlines=True)
    assert found.returncode == 0, found.stdout
    first, second = map(int, found.stdout.split())
    assert first >= 12 and second >= 12


def test_what_an_edit_list_hides_is_not_missing(make_film, tmp_path):
    film, path, warnings = make_film(
        'a.mp4', *H264, '-g', '20', seconds=4), str(tmp_path / 'cut.mp4'), []
    subprocess.run(['ffmpeg', '-v', 'error', '-ss', '1', '-i', film, '-c', 'copy', path],
                   check=True)
    assert len(times(open_file(path, 30.0, loop=False, warn=warnings.append))) == 30
    assert not warnings
    frames = FilmFrames(path)
    numbers = [frame.number for frame in frames]
    assert numbers == list(range(30)) and frames.expected == 30
    found = parts.divide(path, frames=10)
    assert [part.first for part in found] == [0, 10]
    assert [frame.number for part in found for frame in parts.read(path, part)] == numbers
