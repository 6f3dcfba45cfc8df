"""fit_colors.py from recordings to its files; what it refuses."""
import csv
import os
import re
import shlex

import av
import cv2
import numpy as np
import pytest
import rosbag
import rospy
import yaml
from std_msgs.msg import Header

from img_recog.batch import fit_job
from img_recog.conversions import image_msgs
from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.fitting import marked, offers
from img_recog.recognition.fitting import picture as picture_of_histograms
from img_recog.recognition.fitting.marked import Marked
from img_recog_helpers import expected
from img_recog_helpers.figures import assert_unchanged, of_matplotlib

WIDTH, HEIGHT = 64, 48
RED, BLUE, WALL, CUP = (40, 30, 190), (170, 80, 30), (120, 125, 130), (60, 110, 190)     # BGR


def picture(*colors):
    """Return a frame of a wall and an orange cup, with cards of 20x20 px."""
    image = np.full((HEIGHT, WIDTH, 3), WALL, np.uint8)
    image[40:, 50:] = CUP
    for number, color in enumerate(colors):
        image[10:30, 5 + 30 * number:25 + 30 * number] = color
    noise = np.random.RandomState(len(colors)).randint(-3, 4, image.shape)
    return (image + noise).clip(0, 255).astype(np.uint8)


SAMPLES = '''
samples:
- {recording: a.png, color: red, rectangle: [5, 10, 20, 20]}
- {recording: a.png, color: blue, rectangle: [35, 10, 20, 20]}
'''
BAG_SAMPLES = '''
- {recording: drive.bag, color: red, in_view: [0, 1]}
- {recording: drive.bag, color: red, not_in_view: [1, 2]}
- {recording: drive.bag, color: blue, not_in_view: [0, 2]}
'''


def write_bag(path):
    """Write a bag of 20 images in 2 s from 100 s on, the first ten with a red card."""
    with rosbag.Bag(str(path), 'w') as bag:
        for number in range(20):
            image = picture(*([RED] if number < 10 else []))
            header = Header(number, rospy.Time(100 + number // 10, number % 10 * 10 ** 8), 'eye')
            bag.write('/image', image_msgs.to_msg(image, 'bgr8', header), rospy.Time(7 + number))


@pytest.fixture
def drawn_fit(tmp_path, monkeypatch, capsys, caplog, handlers_as_before):
    """A function that runs the program in a folder with a.png; returns code, output and log."""
    monkeypatch.chdir(tmp_path)
    cv2.imwrite('a.png', picture(RED, BLUE))
    (tmp_path / 's.yaml').write_text(SAMPLES)

    def fit(*arguments, samples='s.yaml'):
        caplog.clear()
        code = fit_job.main([*arguments, '--samples', samples, '--jobs', '1'])
        return code, capsys.readouterr().out, [each.getMessage() for each in caplog.records]
    return fit


@pytest.fixture
def fit(drawn_fit, monkeypatch):
    """Like drawn_fit, but with an empty picture of histograms: drawing takes half of the time."""
    monkeypatch.setattr(picture_of_histograms, 'draw', lambda figure, profiles: None)
    return drawn_fit


def table():
    with open('fit_colors.csv') as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize('output', ['there', 'there/'])
def test_a_folder_gets_the_files(fit, tmp_path, output):
    (tmp_path / 'there').mkdir()
    assert fit('a.png', '--output', output)[0] == 0
    assert sorted(os.listdir('there')) == ['fit_colors' + extension for extension in (
        '.csv', '.md', '.png', '.yaml')]
    assert sorted(os.listdir('.')) == ['a.png', 's.yaml', 'there']


def test_an_image_gives_bounds_that_find_its_cards_and_nothing_else(drawn_fit, tmp_path):
    code, output, log = drawn_fit('a.png')
    assert (code, log) == (0, [])
    assert 'fit_colors.yaml, fit_colors.md, fit_colors.png, fit_colors.csv' in output
    settings = parameter_file.read('fit_colors.yaml')
    assert [color.name for color in settings.colors] == ['red', 'blue']
    extractor = ColorExtractor(settings)
    assert extractor.measure(picture(RED, BLUE)) == [400, 400]
    assert extractor.measure(picture()) == [0, 0]
    assert all(color.area_limit_px == 19 for color in settings.colors)
    row, = table()
    assert (row['recording'], row['samples'], row['red_px'], row['red_seen'], row['red_in_view'],
            row['red_inside_px'], row['red_wrong_px'], row['red_missed_px']) == (
                'a.png', 'fit', '400', '1', '1', '400', '0', '0')
    report = open('fit_colors.md').read()
    assert '| red | fitted | fit | 100.0% | 100.0% | 100.0% | 100.0% |' in report
    # the article's red begins at the value 150, and the limit is 1000 px
    assert '| blue | before | fit | 100.0% | 100.0% | 0.0% | 0.0% |' in report
    assert sorted(os.listdir('.')) == ['a.png', 'fit_colors.csv', 'fit_colors.md',
                                       'fit_colors.png', 'fit_colors.yaml', 's.yaml']
    with open('fit_colors.png', 'rb') as file:
        assert_unchanged(of_matplotlib(file.read()),
                         os.path.join(os.path.dirname(__file__), 'fit_colors.png'), tmp_path)


def test_samples_that_the_page_has_saved_give_the_bounds_that_it_offered(fit, tmp_path):
    now, name = marked.with_picture(Marked(), picture(RED, BLUE))
    for color, x in (('red', 0.45), ('blue', 0.85)):
        now = marked.with_click(now, name, x, 0.5, color)
    (tmp_path / 'samples_1').mkdir()
    marked.write(now, str(tmp_path / 'samples_1'))
    assert fit('samples_1', samples='samples_1/samples.yaml')[0] == 0
    assert {color.name: color[1:4] for color in parameter_file.read('fit_colors.yaml').colors} \
        == {name: offer.box for name, offer in offers.offers(now).items()}


def test_bags_times_folders_and_a_check(fit, tmp_path):
    write_bag(tmp_path / 'drive.bag')
    (tmp_path / 'check.yaml').write_text('samples:' + BAG_SAMPLES.replace('[1, 2]', '[1.4, 2]'))
    (tmp_path / 's.yaml').write_text(SAMPLES + '- {recording: drive.bag, color: red, '
                                     'not_in_view: [1, 1.35]}\n')
    code, _, log = fit('.', '--check', 'check.yaml')
    assert code == 1 and log[0] == '2 of 4 entries of the folder . left out: check.yaml, s.yaml'
    assert 'frame 10 is in the samples of both' in log[1]
    (tmp_path / 'check.yaml').write_text('samples:' + BAG_SAMPLES.replace('[1, 2]', '[1.4, 2]')
                                         .replace('[0, 2]', '[0, 1]'))
    assert fit('.', '--check', 'check.yaml')[0] == 0
    report = open('fit_colors.md').read()
    assert '| red | fitted | check | - | - | 100.0% | 100.0% |' in report
    rows = table()
    assert len(rows) == 21
    assert [row['red_seen'] for row in rows] == ['1'] * 11 + ['0'] * 10
    assert [row['samples'] for row in rows] == [
        'fit', *['check'] * 10, *['fit'] * 4, *['check'] * 6]
    assert rows[11]['time_s'] == '1.000000' and rows[11]['blue_in_view'] == ''


def test_a_color_of_which_only_times_are_known(drawn_fit, tmp_path):
    write_bag(tmp_path / 'drive.bag')
    (tmp_path / 's.yaml').write_text('samples:\n- {color: red, in_view: [0, 1]}\n'
                                     '- {color: red, not_in_view: [1, 2]}\n')
    assert drawn_fit('drive.bag')[0] == 0
    assert ColorExtractor(parameter_file.read('fit_colors.yaml')).measure(
        picture(RED, BLUE)) == [400]


FPS = 5
HALVES = (('in_view', 3.0, 6.0), ('not_in_view', 0.0, 2.9))


def film_frame(number, sigma, random, *colors):
    """Return a frame of a wall, a dark floor and the cup, with moving round cards; rgb."""
    image = np.full((72, 96, 3), WALL, float)
    image[52:] = 55, 85, 110
    image[60:, 70:] = CUP
    for place, color in enumerate(colors):
        cv2.circle(image, (14 + (number * 4 + 45 * place) % 70, 16 + 24 * place), 10, color, -1)
    image = image * np.linspace(1.1, 0.6, 96)[:, None] + random.normal(0, sigma, image.shape)
    return image.clip(0, 255).astype(np.uint8)[..., ::-1]


def write_film(sigma, crf, shown):
    """Write film.mkv; shown: for each frame, the colors of its cards. crf: None for no losses."""
    options = {'crf': str(crf)} if crf else {}
    with av.open('film.mkv', 'w') as film:
        stream = film.add_stream('libx264' if crf else 'ffv1', FPS, options=options)
        stream.width, stream.height, stream.pix_fmt = 96, 72, 'yuv420p' if crf else 'bgr0'
        random = np.random.RandomState(7)
        for number, colors in enumerate(shown):
            frame = av.VideoFrame.from_ndarray(film_frame(number, sigma, random, *colors), 'rgb24')
            film.mux(stream.encode(frame.reformat(format=stream.pix_fmt)))
        film.mux(stream.encode(None))


def measured():
    """Return the areas of the colors in each frame of film.mkv, by the bounds that were found."""
    extractor = ColorExtractor(parameter_file.read('fit_colors.yaml'))
    with av.open('film.mkv') as film:
        return np.array([extractor.measure(frame.to_ndarray(format='bgr24'))
                         for frame in film.decode(video=0)])


def write_times(**colors):
    """Write the samples; colors: (in_view or not_in_view, start, end) of each."""
    with open('s.yaml', 'w') as file:
        file.write('samples:\n' + ''.join(
            '- {{color: {}, {}: [{}, {}]}}\n'.format(color, *each)
            for color, times in colors.items() for each in times))


def widths():
    """Return how many hues the bounds of each color have."""
    return {color.name: (color.hue[1] - color.hue[0]) % 180
            for color in parameter_file.read('fit_colors.yaml').colors}


@pytest.mark.parametrize('sigma, crf, color', [     # the worst that are told
    (12, None, RED), (12, None, (70, 25, 20)), (4, 28, (40, 190, 210)), (4, 28, (70, 25, 20))])
def test_times_alone_tell_a_color_in_noise_and_after_compression(fit, sigma, crf, color):
    write_film(sigma, crf, [[]] * 15 + [[color]] * 15)
    write_times(card=HALVES)
    code, output, log = fit('film.mkv')
    assert code == 0, log
    quality = 'precision 100.0%, recall 100.0% of the frames'
    assert quality in output and '# card: ' + quality in open('fit_colors.yaml').read()
    assert '| card | fitted | fit | - | - | 100.0% | 100.0% |' in open('fit_colors.md').read()
    areas_px = measured()       # of 317 px, of which some are in the shade
    assert areas_px[:15].max() < 10 and widths()['card'] < 80
    assert areas_px[15:].min() > 120 and areas_px[15:].max() < 440


def test_times_alone_tell_two_colors_that_are_in_view_together(fit):
    write_film(4, 23, [[]] * 8 + [[RED]] * 8 + [[RED, BLUE]] * 8 + [[WALL, BLUE]] * 8)
    write_times(red=[('in_view', 1.6, 4.7), ('not_in_view', 0, 1.5), ('not_in_view', 4.8, 6.4)],
                blue=[('in_view', 3.2, 6.4), ('not_in_view', 0, 3.1)])
    assert fit('film.mkv')[0] == 0
    red_px, blue_px = measured().T
    for areas_px, (first, end) in ((red_px, (8, 24)), (blue_px, (16, 32))):
        assert areas_px[first:end].min() > 220 and areas_px[first:end].max() < 440
        assert max(areas_px[:first].max(), *areas_px[end:], 0) < 10
    assert max(widths().values()) < 60


def test_other_light_does_not_hide_a_color_of_which_only_times_are_known(fit):
    write_film(4, None, [[]] * 15 + [[RED]] * 15)
    with av.open('film.mkv') as film:
        frames = [frame.to_ndarray(format='bgr24') for frame in film.decode(video=0)]
    with rosbag.Bag('film.bag', 'w') as bag:
        for number, frame in enumerate(frames):
            brighter = (frame * (0.7 + 0.02 * number)).clip(0, 255).astype(np.uint8)
            stamp = rospy.Time(10 + number // FPS, number % FPS * 2 * 10 ** 8)
            bag.write('/image', image_msgs.to_msg(brighter, 'bgr8', Header(number, stamp, 'eye')),
                      stamp)
    write_times(card=HALVES)
    assert fit('film.bag')[0] == 0
    extractor = ColorExtractor(parameter_file.read('fit_colors.yaml'))
    assert extractor.measure(frames[22])[0] > 250 and extractor.measure(frames[2])[0] < 5


@pytest.mark.parametrize('shown, times, words', [
    ([[]] * 30, dict(card=HALVES), ('card', 'correct the times, or mark the color in a frame')),
    # it is in view in a third of the time that is given
    ([[]] * 25 + [[RED]] * 5, dict(card=HALVES), (
        'no bounds separate card: the best ones, ', 'find it in 5 of 15 frames in which it is in '
        'view, and in 0 in which it is not; correct the times'))])
def test_times_that_do_not_tell_a_color_are_refused(fit, shown, times, words):
    write_film(1, None, shown)
    write_times(**times)
    before = sorted(os.listdir('.'))
    code, output, log = fit('film.mkv')
    line, = log
    assert code == 1 and not output and all(each in line for each in words), line
    assert sorted(os.listdir('.')) == before


def test_a_parameter_file_keeps_what_is_not_fitted(fit, tmp_path):
    (tmp_path / 'mine.yaml').write_text(
        'colors: [green, red]\ngreen_hue_min: 50\ngreen_hue_max: 70\ngreen_angular_z: 0.5\n'
        'red_linear_x: 0.2\nred_hue_max: 178\nroi_x_offset: 2\nstop_when_lost: 1.5\n')
    assert fit('a.png', '--colors', 'mine.yaml')[0] == 0
    values = yaml.safe_load(open('fit_colors.yaml').read())
    assert values['colors'] == ['green', 'red', 'blue']
    assert (values['green_hue_max'], values['green_angular_z'], values['red_linear_x'],
            values['roi_x_offset'], values['stop_when_lost']) == (70, 0.5, 0.2, 2, 1.5)
    assert values['red_hue_max'] != 178 and 'blue_hue_min' in values


def test_another_objective_with_several_bounds_to_choose_from(fit):
    assert fit('a.png', '--objective', 'frames')[0] == 0
    assert ColorExtractor(parameter_file.read('fit_colors.yaml')).measure(
        picture(RED, BLUE)) == [400, 400]


def test_what_cannot_be_used_is_named_and_the_rest_counts(fit, tmp_path):
    (tmp_path / 'b.mp4').write_bytes(b'\0\0\0\x20ftypisom' + bytes(400))
    (tmp_path / 'c.png').write_bytes(b'\x89PNG')
    for name, usable in (('half.bag', [False, True, False]), ('none.bag', [False])):
        with rosbag.Bag(name, 'w') as bag:
            for number, is_usable in enumerate(usable):
                msg = image_msgs.to_msg(picture(), 'bgr8', Header())
                msg.data = msg.data if is_usable else msg.data[:9]
                bag.write('/image', msg, rospy.Time(7 + number))
    code, output, log = fit('a.png', 'b.mp4', 'c.png', 'half.bag', 'none.bag')
    assert code == 1 and 'red: hue' in output
    broken = '{0}: cannot play {1}/{0}: neither a video nor an image that OpenCV reads; '
    lines = [*(broken.format(name, tmp_path) for name in ('b.mp4', 'c.png')),
             'none.bag: no image on /image in {}/none.bag can be used; message 0: cannot '.format(
                 tmp_path),
             'half.bag: 2 of 3 images on /image cannot be used; the first is message 0: cannot ']
    assert [said.startswith(line) for said, line in zip(log, lines)] == [True] * len(log), log
    report = open('fit_colors.md').read()
    assert 'Recordings: 2, with 2 frames.' in report
    assert all('\n- ' + line in report for line in log) and len(log) == len(lines)


def test_times_count_from_the_first_usable_image_though_a_part_has_none(fit, tmp_path):
    with rosbag.Bag('drive.bag', 'w') as bag:
        for number in range(1002):
            msg = image_msgs.to_msg(picture(RED) if number < 1001 else picture(), 'bgr8',
                                    Header(stamp=rospy.Time(100 + number)))
            msg.data = msg.data if number > 999 else b''
            bag.write('/image', msg, rospy.Time(7 + number))
    (tmp_path / 's.yaml').write_text(
        SAMPLES + '- {recording: drive.bag, color: red, in_view: [0, 0.5]}\n'
        '- {recording: drive.bag, color: red, not_in_view: [0.6, 1.5]}\n')
    assert fit('a.png', 'drive.bag')[0] == 0
    assert [row['time_s'] for row in table()] == ['0.000000', '0.000000', '1.000000']


def test_a_color_whose_only_recording_is_broken_has_no_sample(fit, tmp_path):
    (tmp_path / 'c.png').write_bytes(b'\x89PNG')
    (tmp_path / 's.yaml').write_text(SAMPLES + '- {recording: c.png, color: green, '
                                     'rectangle: [5, 10, 20, 20]}\n')
    code, _, log = fit('a.png', 'c.png')
    assert code == 1 and 'no pixel is a sample of green; add a rectangle' in log[-1]


def test_the_worst_frames_are_drawn(fit, tmp_path):
    cv2.imwrite('d.png', picture(RED))
    (tmp_path / 's.yaml').write_text(SAMPLES + '- {recording: d.png, color: none, '
                                     'rectangle: [0, 0, 30, 40]}\n')
    assert fit('a.png', 'd.png')[0] == 0
    report = open('fit_colors.md').read()
    assert 'red: frame 0 of d.png, 400 px wrong\n\n- red: 400 px, above the limit of ' in report
    assert '\n\n![red: frame 0 of d.png, 400 px wrong](fit_colors_worst_1.png)\n' in report
    drawn = cv2.imread('fit_colors_worst_1.png')
    assert drawn.shape == picture(RED).shape and (drawn != picture(RED)).any()


def test_two_processes_write_the_same_bytes(fit, two_processes, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(picture_of_histograms, 'draw', lambda figure, profiles: drawn.append(
        profiles))
    write_bag(tmp_path / 'drive.bag')
    (tmp_path / 's.yaml').write_text(SAMPLES + BAG_SAMPLES)
    written = []
    for jobs in ('1', '2'):
        assert fit_job.main(['a.png', 'drive.bag', '--samples', 's.yaml', '--jobs', jobs]) == 0
        written.append({name: (tmp_path / name).read_bytes() for name in os.listdir('.')
                        if name.startswith('fit_colors')})
    assert written[0] == written[1] and len(written[0]) >= 4
    np.testing.assert_equal(*drawn)


def test_samples_that_are_refused_leave_nothing(fit, tmp_path):
    before = sorted(os.listdir('.'))

    def line(text):
        (tmp_path / 's.yaml').write_text('samples:\n' + text)
        code, output, log = fit('a.png')
        assert (code, output, len(log), sorted(os.listdir('.'))) == (1, '', 1, before)
        return re.sub('(?<=the best ones, ).*', '...', log[0])
    expected.check_cases('refused/fit_samples.txt', line)


def test_refused_arguments(fit, tmp_path):
    (tmp_path / 'empty').mkdir()

    def line(arguments):
        code, output, log = fit(*shlex.split(arguments))
        assert (code, output, len(log)) == (1, '', 1)
        return log[0]
    expected.check_cases('refused/fits.txt', line)


def test_colors_of_the_check_that_are_not_fitted(fit, tmp_path):
    (tmp_path / 'c.yaml').write_text('samples: [{color: green, in_view: [0, 1]}]')
    assert 'c.yaml: there is no color green; those of s.yaml are red, blue' in fit(
        'a.png', '--check', 'c.yaml')[2][0]
