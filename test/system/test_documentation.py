"""README.md and doc/ agree with the code: lists are complete, names exist, defaults are right."""
import ast
import dataclasses
import functools
import glob
import importlib
import os
import pkgutil
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

import img_recog
from img_recog.batch import sweep_file
from img_recog.batch.sweep_file import Success, SweepSettings
from img_recog.conversions.sensor_table import SENSORS
from img_recog.nodes.gazebo.physics_services import RuntimeSettings
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.settings import Settings
from img_recog_helpers import expected
from img_recog_helpers.ignored import shown as shown_by_git
from img_recog_helpers.pages import (LAUNCH_FOLDER, ROOT, anchors, code, launch_arguments,
                                     links, paths, read, rows, tables, tool)

REFERENCE = read('doc/reference.md')
PAGES = tool('generated_pages')
NODES = PAGES.NODES
# topics that are in no docstring, with their types
TOPICS = {'gazebo': {kind.topic(kind.settings()): kind.msg_type._type for kind in SENSORS
                     if not kind.missing}}
# of dynamic_reconfigure alone: parameters that are among those above; and no parameters
PARTS = {RuntimeSettings, *(kind.settings for kind in SENSORS
                            if kind.only_in_tags and not kind.is_drawn)}
NAME = r'[~/]?[a-z][a-z0-9_]*(?:/[a-z0-9_]+)*'
TYPE = r'(?:[a-z0-9_]+_msgs|std_srvs|dynamic_reconfigure)(?:/\w+)?'


@pytest.mark.parametrize('path, text', PAGES.written().items())
def test_what_is_made_from_the_code_in_a_page_is_up_to_date(path, text):
    expected.check(path, text)


@pytest.mark.parametrize('path', [path for path in paths() if 'rosrun image_view' in read(path)])
def test_each_window_of_a_page_has_a_name_of_its_own(path):
    """image_view has a fixed name since 1.14: a second one ends the first, or that of the demo."""
    of_article = [row[1].strip('`') for table in tables(read(path)) for row in table.rows
                  if row[1].startswith('`rosrun image_view')]
    windows = [line for line in code(read(path)) if 'rosrun image_view image_view image' in line]
    names = [line.partition(' __name:=')[2] for line in windows if line not in of_article]
    assert names and all(names) and len(set(names)) == len(names)
    assert not {'image_view', 'image_view_blue', 'image_view_red'} & set(names)


@pytest.mark.parametrize('old, new', (
    ('| `create_suspended` | `false` |', '| `create_suspended` | `true` |'),
    ('| `640`, `480` | a whole number from 1 to', '| `640` | a whole number from 2 to'),
    ('| `autofocus` |', '| `auto_focus` |'),
    ('\n| `focus` |', '\n| `gain` | `1` | 2 | 3 |\n| `focus` |'),
    ('| Hz;', '|  Hz;')))
def test_rows_of_parameters_are_written_again(old, new):
    assert old in REFERENCE
    found = '\n'.join(PAGES.with_parameters(REFERENCE.replace(old, new, 1).splitlines())) + '\n'
    lines = set(REFERENCE.splitlines()) - set(found.splitlines())
    # of one with another name, the row is at the end, and what it means is lost
    assert len(lines) == ('auto_focus' in new) and len(found.splitlines()) == len(
        REFERENCE.splitlines())


def test_each_parameter_has_a_meaning():
    empty = [row[0] for node in NODES for row in rows(REFERENCE, node, 'name') if not row[3]]
    assert empty == []


def test_all_settings_are_in_the_reference():
    for module in pkgutil.walk_packages(img_recog.__path__, 'img_recog.'):
        importlib.import_module(module.name)
    known = {each for node in NODES.values() for each in node.settings}
    declared = {each for each in Settings.__subclasses__()
                if each.__module__.startswith('img_recog.')} - set(
                    sweep_file.KINDS) - {SweepSettings, Success}
    # with_colors() makes it complete
    assert declared - known == {RecognitionSettings} | PARTS


def test_parameters_of_a_sweep():
    page = {row[0].strip('`'): row[1] for row in rows(REFERENCE, 'sweep.py', 'parameter')}
    declared = {field.name: '{:g}'.format(field.default) for kind in (SweepSettings, Success)
                for field in dataclasses.fields(kind)}
    assert {name: page.pop(name, None) for name in declared} == declared
    assert set(page) == {'success', 'parameters', 'cells'}


def stated_types(text):
    """Return the type of each topic and service that a docstring lists as 'name, name (type'."""
    lists = re.findall(r'((?:[\w/~]*[_/~][\w/~]*(?:, | and ))*{}) \(({})'.format(NAME, TYPE),
                       text)
    return {name: kind for names, kind in lists for name in re.split(', | and ', names)}


def topic_differences(types, node):
    """Return a line for each topic or service that only the page or only the code has."""
    text, others = docstring(node), TOPICS.get(node, {})
    stated = {**stated_types(text), **others}
    lines = ['missing: {} ({})'.format(name, kind)
             for name, kind in stated.items() if name not in types]
    # a docstring may give only the package of a type
    lines += ['{}: the page has {}, the code {}'.format(name, types[name], kind)
              for name, kind in stated.items()
              if name in types and not (types[name] + '/').startswith(kind + '/')]
    words = {word.lstrip('/') for word in [*re.findall(NAME, text), *others]}
    return lines + ['not in the code: ' + name
                    for name in types if name.lstrip('/') not in words]


@pytest.mark.parametrize('node', NODES)
def test_topics_and_services_agree_with_the_code(node):
    assert len(stated_types(docstring(node))) > 0
    lines = topic_differences(topics(REFERENCE, node), node)
    assert not lines, '\n'.join(lines)


def docstring(node):
    module = importlib.import_module('img_recog.nodes.' + NODES[node].module)
    return ' '.join(module.__doc__.split())


def topics(text, node):
    """Return the type of each topic and service; a row has one for all of its names, or for each.
    """
    return {name: kind for first in ('topic', 'service') for row in rows(text, node, first)
            for names, kinds in [(row[0].strip('`').split('`, `'), row[1].split(', '))]
            for name, kind in zip(names, kinds * (len(names) if len(kinds) == 1 else 1))}


@pytest.mark.parametrize('old, new, words', (
    ('| `imu` | sensor_msgs/Imu |', '| `imus` | sensor_msgs/Imu |', 'missing: imu'),
    ('| `imu` | sensor_msgs/Imu |', '| `imus` | sensor_msgs/Imu |', 'not in the code: imus'),
    ('| `scan` | sensor_msgs/LaserScan |', '| `scan` | sensor_msgs/Laser |', 'scan: the page'),
    ('| `~pause_physics`, ', '| `~pause`, ', 'missing: ~pause_physics'),
    ('| gazebo_msgs/GetModelState, ', '| std_srvs/GetModelState, ', 'the page has')))
def test_a_difference_of_topics_is_found(old, new, words):
    assert old in REFERENCE
    page = topics(REFERENCE.replace(old, new), 'gazebo')
    assert words in '\n'.join(topic_differences(page, 'gazebo'))


def test_the_posts_stand_where_the_page_says():
    world = ElementTree.fromstring(read('urdf/color_posts.sdf'))
    posts = [['`{}`'.format(model.get('name')), *model.findtext('pose').split()[:2]]
             for model in world.iter('model') if model.get('name') != 'field']
    assert rows(read('doc/simulator.md'), 'Your own world', 'model') == posts


def blocks(text):
    """Return the indented lines of a page without their comments."""
    return re.findall(r'(?m)^    (.*?)(?: +#.*)?$', text)


# the chapters of README.md that README.ja.md has too; its others are about the article
CHAPTERS_JA = {
    '': '', 'Quick start': 'クイックスタート',
    'Ubuntu 22.04 and 24.04, Fedora, macOS, Windows':
        'Ubuntu 22.04 と 24.04、Fedora、macOS、Windows',
    'Your own camera, video or robot': '自分のカメラ、動画、ロボットを使う',
    'The terminals of the article': '記事のターミナルとの対応',
    'Where to read on': '詳しい説明', 'License': 'ライセンス'}


def chapters(path):
    """Return the text of each chapter of a page by its heading; '' is before the first one."""
    texts = re.split('(?m)^## (.*)\n', '## \n' + read(path))[1:]
    return dict(zip(texts[::2], texts[1::2]))


def in_japanese(link):
    """Return the link that README.ja.md has where README.md has this one."""
    names = re.sub(r'^README(\.ja)?\.md', lambda name: 'README{}.md'.format(
        '' if name.group(1) else '.ja'), link)
    names = re.sub('^doc/lessons/(ja/)?', lambda name: 'doc/lessons/{}'.format(
        '' if name.group(1) else 'ja/'), names)
    headings = dict(zip(anchors_of(CHAPTERS_JA), anchors_of(CHAPTERS_JA.values())))
    return headings.get(names, names)


def anchors_of(headings):
    return ['#' + name for name in anchors('\n'.join('## ' + text for text in headings if text))]


def test_the_japanese_readme_has_the_chapters_of_the_english_one():
    english, japanese = chapters('README.md'), chapters('README.ja.md')
    assert list(english) == list(CHAPTERS_JA)
    assert [name for name in japanese if name in CHAPTERS_JA.values()] == list(
        CHAPTERS_JA.values())


@pytest.mark.parametrize('chapter', CHAPTERS_JA)
def test_the_japanese_readme_agrees_with_the_english_one(chapter):
    """Commands in their order, all other code, links, pictures and rows of tables."""
    english = chapters('README.md')[chapter]
    japanese = chapters('README.ja.md')[CHAPTERS_JA[chapter]]
    assert set(code(english)) - set(code(japanese)) == set()
    assert blocks(english) == blocks(japanese)
    assert [link for link in map(in_japanese, links(english)) if link not in links(japanese)] == []
    assert [len(table.rows) for table in tables(english)] == [
        len(table.rows) for table in tables(japanese)]


def test_the_pages_build_without_a_warning():
    pytest.importorskip('myst_parser')
    path = os.pathsep.join([os.path.dirname(sys.executable), os.environ['PATH']])
    # without writing HTML: that checks nothing more
    done = subprocess.run([os.path.join(ROOT, 'doc', 'build'), 'dummy'],
                          env=dict(os.environ, PATH=path), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    assert done.returncode == 0, done.stdout.decode()


def test_the_readme_is_short():
    assert len(read('README.md').splitlines()) <= 150


@pytest.mark.parametrize('script', sorted(os.listdir(os.path.join(ROOT, 'scripts'))))
def test_a_script_is_in_the_reference_if_users_start_it(script):
    launched = ''.join(read(path) for path in glob.glob(os.path.join(LAUNCH_FOLDER, '*.launch')))
    assert script in REFERENCE + launched, 'add a row to "Programs" in doc/reference.md'


@pytest.mark.parametrize('path', paths())
def test_link_targets_exist(path):
    for link in links(read(path)):
        file, _, anchor = link.partition('#')
        target = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
        assert os.path.exists(os.path.join(ROOT, target)), link
        assert not anchor or anchor in anchors(read(target)), link


@pytest.fixture(scope='module')
def existing():
    """The usage of ./run, the arguments of each launch file, and all parameters of nodes."""
    usage = subprocess.run([os.path.join(ROOT, 'run'), 'help'], stdout=subprocess.PIPE,
                           check=True).stdout.decode()
    known = {file: set(launch_arguments(file)) for file in os.listdir(LAUNCH_FOLDER)}
    return usage, known, {name for node in NODES.values() for name in PAGES.parameters(node)}


@pytest.mark.parametrize('path', paths())
def test_commands_exist(path, existing):
    usage, known, names = existing
    for line in code(read(path)):
        for word in re.findall(r'(?:^|/)run ([a-z]+)', line):
            assert re.search(r'^ +{}\b'.format(word), usage, re.MULTILINE), line
        for script in re.findall(r'rosrun img_recog (\S+)', line):
            assert os.path.isfile(os.path.join(ROOT, 'scripts', script)), line
            printed = read('test/expected/help/{}.txt'.format(script[:-len('.py')]))
            assert set(re.findall(r' (--[a-z-]+)', line)) <= {
                '--help', *re.findall(r'(?<!\S)--[a-z-]+', printed)}, line
        for launch in re.findall(r'roslaunch (?:--ros-args )?img_recog (\S+)', line):
            assert set(re.findall(r' ([a-z_]+):=', line)) <= known[launch], line
        if re.search(r'run demo|demo\.launch', line):
            assert set(re.findall(r' ([a-z_]+):=', line)) <= known['demo.launch'], line
        assert set(re.findall(r' _(?!_)([a-z_]+):=', line)) <= names, line
        for values in re.findall(r'dynparam set \S+ (.*)', line):
            assert set(re.findall(r'[a-z]\w+', values)) <= names, line


@functools.lru_cache(maxsize=None)
def definitions(path):
    """Return the functions, classes and Class.method of a module."""
    with open(path, encoding='utf-8') as file:
        body = ast.parse(file.read()).body
    kinds = (ast.ClassDef, ast.FunctionDef)
    found = {each.name for each in body if isinstance(each, kinds)}
    return found | {'{}.{}'.format(each.name, part.name) for each in body
                    if isinstance(each, ast.ClassDef) for part in each.body
                    if isinstance(part, kinds)}


@pytest.mark.parametrize('path', ('CONTRIBUTING.md', 'doc/architecture.md'))
def test_files_and_names_in_the_code_exist(path):
    text = read(path)
    package = os.path.join(ROOT, 'src', 'img_recog')
    files = glob.glob(os.path.join(package, '**'), recursive=True)
    everything = set().union(*(definitions(file) for file in files if file.endswith('.py')))
    for span in code(text):
        if re.fullmatch(r'(?!build/)[\w./]+(\.(py|md|svg|yaml|launch|urdf|txt|xml|cfg)|/)', span):
            assert any(os.path.exists(os.path.join(ROOT, folder, span))
                       for folder in ('', 'scripts')) or any(
                           file.endswith('/' + span.rstrip('/')) for file in files), span
        elif re.fullmatch(r'[A-Z]\w*[a-z]\w*(\.\w+)?|[a-z]\w*_to_msg', span):
            assert span in everything, span
    pairs = re.findall(r'`([\w/]+\.py)`,\s+`(?!\w+\.py)(\w+(?:\.\w+)?)`', text)
    assert len(pairs) > 1
    for file, name in pairs:
        assert name in definitions(os.path.join(package, file)), (file, name)


# in groups, what commands and examples in pages write to the current folder
WRITTEN = (
    r'\b(\w+\.(?:replay|evaluated|sweep)\.(?!work)\w+(?:\.\w+)?)',
    r'\b(fit_colors\w*\.(?!py\b)\w+)', r'`((?:recording|colors)_\d\.\w+)',
    r'graph\.py ([a-z]+\.\w+)', r'plot\.py (?:\w+\.bag )?(\w+\.png)',
    r'film\.py \w+\.bag (\w+\.mp4)', r'record:=(\w+\.bag)', r"imwrite\('(\w+\.png)'",
    r"VideoWriter\('(\w+\.mp4)'", r'\bcp \S+ (\w+\.\w+)')


def written():
    """Return the names of files that documented commands write to the current folder."""
    text = '\n'.join(map(read, paths()))
    prefixes = re.findall(r'replay\.py .*--output (\w+)', text)
    return {*(name for each in WRITTEN for name in re.findall(each, text)),
            *(name + end for name in prefixes for end in ('.bag', '.csv', '.png')),
            # folders, and what tools of others write
            'pictures/001.png', 'samples_1/samples.yaml', 'follow.sweep.work/1', 'frames.pdf'}


def test_what_documented_commands_write_is_ignored_by_git(tmp_path):
    names = written()
    assert names > {'cards.replay.csv', 'no_teleop.png', 'slow.csv', 'graph.svg', 'drive.png',
                    'demo.bag', 'posts.mp4', 'recording_1.png', 'colors_1.yaml', 'yellow.png',
                    'cards.mp4', 'fit_colors.csv', 'a.evaluated.png', 'my_posts.sdf',
                    'follow.sweep.worst_1.mp4', 'video.replay.mp4'}
    assert shown_by_git(tmp_path, names) == []


def test_what_users_make_is_not_ignored_by_git(tmp_path):
    names = ['config/colors_1.yaml', 'config/my.sweep.yaml', 'doc/graph.svg', 'doc/my.mp4',
             'my_colors.yaml', 'photo.png', 'samples.yaml', 'slow.yaml', 'test/samples/drive.bag',
             'truth.csv', 'urdf/my_posts.sdf', 'yellow.py']
    assert shown_by_git(tmp_path, names) == names
