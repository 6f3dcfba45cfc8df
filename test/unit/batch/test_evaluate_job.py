"""evaluate.py: sets of colors side by side, against what replay.py says of each."""
import csv
import logging
import os
import sys

import cv2
import genpy
import numpy as np
import pytest
import rosbag
from std_msgs.msg import Header

from img_recog.batch import evaluate_job
from img_recog.conversions import image_msgs
from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recordings.films import FilmFrames
from img_recog_helpers import expected

GREEN, FRAMES = (0, 200, 0), 8
WIDE = '{colors: [green], green_hue_min: 40, green_hue_max: 80, green_area_limit: 100, ' \
    'green_linear_x: 0.1}'


@pytest.fixture
def folder(tmp_path, monkeypatch, handlers_as_before):
    """A folder with a film in which a green square grows, and two sets of colors."""
    writer = cv2.VideoWriter(str(tmp_path / 'film.avi'), cv2.CAP_FFMPEG,
                             cv2.VideoWriter_fourcc(*'MJPG'), 10, (96, 64))
    for number in range(FRAMES):
        image = np.full((64, 96, 3), 90, np.uint8)
        image[:, :4 * number] = GREEN
        writer.write(image)
    writer.release()
    (tmp_path / 'low.yaml').write_text(WIDE)
    (tmp_path / 'high.yaml').write_text(WIDE.replace('100', '900'))
    (tmp_path / 'broken.avi').write_bytes(b'RIFF' + bytes(99))
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    logging.getLogger('evaluate.py').handlers.clear()


def run(monkeypatch, *arguments):
    monkeypatch.setattr(sys, 'argv', ['evaluate.py', *arguments, '--jobs', '1'])
    return evaluate_job.main()


def rows(path='film.evaluated.csv'):
    with open(path) as file:
        return list(csv.DictReader(file))


def test_areas_and_commands_of_each_set(folder, monkeypatch, capsys):
    assert run(monkeypatch, 'film.avi', '--colors', 'low.yaml', 'high.yaml') == 0
    assert capsys.readouterr().out.startswith(
        '1 of 1 recording, 8 frames, 2 sets of colors; wrote film.evaluated.csv')
    found = rows()
    extractor = ColorExtractor(parameter_file.read('low.yaml'))
    areas = [extractor.measure(frame.image, frame.encoding)[0]
             for frame in FilmFrames('film.avi')]
    for colors, limit in (('low', 100), ('high', 900)):
        mine = [row for row in found if row['colors'] == colors]
        assert [int(row['green_px']) for row in mine] == areas
        assert [row['linear_x_m_per_s'] for row in mine] == [
            '0.1' if area > limit else '' for area in areas]
        assert [(row['frame'], row['time_s']) for row in mine][3] == ('3', '0.3')
    assert cv2.imread('film.evaluated.png').shape[1] == 1200
    assert not [name for name in os.listdir(str(folder)) if 'work' in name]


def test_truth_gives_precision_and_recall(folder, monkeypatch):
    lines = ['recording,frame,color,in_view'] + [
        'film.avi,{},green,{}'.format(frame, int(frame in (3, 4, 5))) for frame in range(1, 7)]
    (folder / 'truth.csv').write_text('\n'.join(lines), encoding='utf-8-sig')    # as of Excel
    assert run(monkeypatch, 'film.avi', '--colors', 'low.yaml', 'high.yaml', '--truth',
               'truth.csv') == 0
    expected.check_printed('evaluate/truth.md', (folder / 'film.evaluated.md').read_text())


def write_bag(path, usable):
    """Write an image of 64x48 for each number, of which those that are not `usable` are short."""
    with rosbag.Bag(str(path), 'w') as bag:
        for number, is_usable in enumerate(usable):
            msg = image_msgs.to_msg(np.full((48, 64, 3), GREEN, np.uint8), 'bgr8', Header())
            msg.data = msg.data if is_usable else msg.data[:100]
            bag.write('/eye', msg, genpy.Time(5 + number))


@pytest.mark.parametrize('name, arguments, code, printed, frames', [
    ('same commands', ('film.avi', '--colors', 'low.yaml', 'same.yaml'), 0,
     '1 of 1 recording, 8 frames, 2 sets of colors;',
     2 * [*range(FRAMES)]),
    ('no recording', ('broken.avi', '--colors', 'low.yaml'), 1, '0 of 1 recording, 0 frames', []),
    ('broken recordings', ('film.avi', 'broken.avi', 'bad.bag', 'half.bag', '--colors',
                           'low.yaml'), 1, '2 of 4 recordings, 10 of 12 frames',
     [*range(FRAMES), 0, 3])])
def test_what_is_reported(folder, monkeypatch, capsys, caplog, name, arguments, code, printed,
                          frames):
    (folder / 'same.yaml').write_text(WIDE)
    write_bag(folder / 'half.bag', [True, False, False, True])
    write_bag(folder / 'bad.bag', 8 * [False])
    before = set(os.listdir(str(folder)))
    assert run(monkeypatch, *arguments, '--output', 'it') == code
    assert capsys.readouterr().out.startswith(printed)
    assert set(os.listdir(str(folder))) - before == {'it.csv', 'it.md', 'it.png'}
    assert [int(row['frame']) for row in rows('it.csv')] == frames
    text = (folder / 'it.md').read_text()
    assert all('\n- {}\n'.format(line) in text for line in caplog.messages)
    assert [record.levelname for record in caplog.records].count('WARNING') == ('half' in text)
    expected.check_printed('evaluate/{}.md'.format(name.replace(' ', '_')),
                           text.replace(str(folder), 'FOLDER'))


def test_truth_that_is_refused(folder, monkeypatch, caplog):
    def line(rows):
        caplog.clear()
        (folder / 'truth.csv').write_text('recording,frame,color,in_view\n' + rows)
        assert run(monkeypatch, 'film.avi', '--colors', 'low.yaml', '--truth', 'truth.csv') == 1
        return '\n'.join(caplog.messages)
    expected.check_cases('refused/truths.txt', line)


@pytest.mark.parametrize('names, shown', [
    (('low.yaml', 'b/low.yaml'), {'{}/low', 'b/low'}),
    (('my.yaml', 'my.yml'), {'my.yaml', 'my.yml'})])
def test_sets_of_colors_are_told_apart(folder, monkeypatch, names, shown):
    for name in names:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(WIDE)
    assert run(monkeypatch, 'film.avi', '--colors', *names) == 0
    found = [row['colors'] for row in rows()]
    assert set(found) == {name.format(folder.name) for name in shown}
    assert found.count(found[0]) == FRAMES
