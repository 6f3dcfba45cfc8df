"""SDF files with what they include."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import sdf_file
from img_recog.report import LEFT_OUT, Report
from img_recog_helpers.sdf import BUILT_IN, sdf

LINK = '<link name="l"><pose>0 0 1 0 0 0</pose></link>'

FUEL = 'https://fuel.gazebosim.org/1.0/OpenRobotics/models/'


@pytest.fixture
def folder(tmp_path):
    """A folder with worlds/ and models/, like that of a Gazebo package."""
    for name in ('worlds', 'models/table', 'models/nested/chair', 'far/lamp'):
        (tmp_path / name).mkdir(parents=True)
    model(tmp_path / 'models' / 'table' / 'model.sdf', 'table', LINK)
    return tmp_path


def model(path, name, inside, version='1.6'):
    path.write_text('<sdf version="{}"><model name="{}">{}</model></sdf>'.format(
        version, name, inside))


def include(uri, inside=''):
    return '<include><uri>{}</uri>{}</include>'.format(uri, inside)


def read(folder, *inside, find=lambda uri: None, problems=(), found=None):
    """Return the contents of a world; problems: the names of what is left out of it."""
    path, found = folder / 'worlds' / 'hall.world', found or Report()
    contents = sdf_file.read(ElementTree.fromstring(sdf(*inside)), str(path), find, found)
    assert [words for name, words in zip(found.of(LEFT_OUT), problems) if words not in name] == []
    assert len(found.of(LEFT_OUT)) == len(problems)
    return contents


def places(contents):
    return {tree.name: tree.pose.translation.tolist() for tree in contents.trees}


def test_a_model_in_a_folder_above(folder):
    contents = read(folder, BUILT_IN, include(' model://table '))
    assert places(contents) == {'table': [0, 0, 1]}


@pytest.mark.parametrize('uri', ['../models/table', '../models/table/model.sdf',
                                 'file://../models/table', 'model:///table', 'model://table/'])
def test_ways_to_name_a_model(folder, uri):
    assert places(read(folder, include(uri))) == {'table': [0, 0, 1]}


def test_what_the_finder_finds_comes_first(folder):
    model(folder / 'far' / 'lamp' / 'model.sdf', 'lamp', LINK)
    found = {'model://table': str(folder / 'far' / 'lamp')}
    assert places(read(folder, include('model://table'), find=found.get)) == {'lamp': [0, 0, 1]}


NEWER = '<sdf version="1.4">a.sdf</sdf><sdf version="1.6">b.sdf</sdf>'


@pytest.mark.parametrize('entries, files, name', [
    (NEWER, 'ab', 'b'), (NEWER, 'a', 'a'), (NEWER, '', 'table'), ('', 'ab', 'table'),
    ('<sdf version="1.10"> b.sdf </sdf><sdf version="1.9">a.sdf</sdf>', 'ab', 'b'),
    ('<sdf>b.sdf</sdf><sdf version="1.2">a.sdf</sdf>', 'ab', 'a'),
    ('<sdf version="x">b.sdf</sdf><sdf version="1.2"/>', 'ab', 'b')])
def test_the_newest_version_in_model_config_is_read(folder, entries, files, name):
    table = folder / 'models' / 'table'
    (table / 'model.config').write_text('<model><name>n</name>{}</model>'.format(entries))
    for each in files:
        model(table / (each + '.sdf'), each, LINK)
    assert list(places(read(folder, include('model://table')))) == [name]


def test_includes_in_models(folder):
    model(folder / 'models' / 'nested' / 'chair' / 'model.sdf', 'chair', LINK)
    model(folder / 'models' / 'nested' / 'model.sdf', 'room', include(
        'model://table', '<pose>1 0 0 0 0 0</pose>') + '<model name="inner">'
        '<pose>0 1 0 0 0 0</pose>' + include('chair') + '</model>')
    contents = read(folder, include('model://nested', '<pose>10 0 0 0 0 0</pose>'))
    assert places(contents) == {'room': [10, 1, 1], 'room::table::l': [11, 0, 1]}


def test_uris_in_an_included_model_are_relative_to_its_file(folder):
    (folder / 'models' / 'table' / 'top.stl').write_text('')
    model(folder / 'models' / 'table' / 'model.sdf', 'table', '<link name="l"><collision name="c">'
          '<geometry><mesh><uri>top.stl</uri></mesh></geometry></collision></link>')
    tree, = read(folder, include('model://table')).trees
    solid, = tree.model.links[0].solids
    assert solid.shape.path == str(folder / 'models' / 'table' / 'top.stl')


def test_the_version_of_each_file_counts(folder):
    links = ('<link name="a"/><link name="b"><pose>0 0 0 1.5707963267948966 0 0</pose></link>'
             '<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis>'
             '<xyz>0 0 1</xyz></axis></joint>')
    table = folder / 'models' / 'table' / 'model.sdf'
    axes = []
    for version in ('1.4', '1.6'):
        model(table, 'table', links, version)
        tree, = read(folder, include('model://table')).trees
        axes.append(tree.model.joints[0].axis.round(6).tolist())
    assert axes == [[0, 1, 0], [0, 0, 1]]


def test_a_model_file_is_a_world_with_the_floor(folder):
    root = ElementTree.fromstring('<sdf version="1.6"><model name="m">' + LINK + '</model></sdf>')
    contents = sdf_file.read(root, str(folder / 'a.sdf'), lambda uri: None, Report())
    assert places(contents) == {'m': [0, 0, 1]}
    assert contents.gravity == sdf_file.GRAVITY and contents.has_floor


def test_what_is_not_found_is_named_once(folder):
    contents = read(folder, include('model://sofa'), include('model://sofa'), '<include/>',
                    '<population name="p"/>', include('https://host/table'),
                    include('http://host/table'), include('ftp://host/table'),
                    '<actor/>', include('model://table'), problems=[
        'model://sofa', 'an <include> without a <uri>', 'population p has no <model>',
        'https://host/table (a URL, which is not downloaded)',
        'http://host/table (a URL, which is not downloaded)',
        'ftp://host/table (a URL, which is not downloaded)', 'actor'])
    assert list(places(contents)) == ['table']


@pytest.mark.parametrize('text, words', [
    ('<sdf', 'cannot use '), ('<robot/>', ' is <robot>, not <sdf>'),
    ('<sdf><world name="w"/></sdf>', 'which it includes, has no <model>'),
    ('<sdf><model name="m"><pose>1</pose>' + LINK + '</model></sdf>', '<pose> of model m')])
def test_an_included_file_is_left_out(folder, text, words):
    (folder / 'models' / 'nested' / 'model.sdf').write_text(text)
    contents = read(folder, include('model://nested'), include('model://table'), problems=[words])
    assert list(places(contents)) == ['table']


@pytest.mark.parametrize('inside', ['', LINK])
def test_a_model_without_what_it_includes_is_loaded(folder, inside):
    model(folder / 'models' / 'nested' / 'model.sdf', 'room', include('model://sofa') + inside)
    contents = read(folder, include('model://nested'), '<model name="hall">' + include(
        'model://chair') + inside + '</model>', problems=['model://sofa', 'model://chair'])
    assert list(places(contents)) == (['room', 'hall'] if inside else [])


def test_two_files_that_include_each_other(folder):
    model(folder / 'models' / 'table' / 'model.sdf', 'a', LINK + include('../nested/b.sdf'))
    model(folder / 'models' / 'nested' / 'b.sdf', 'b', LINK + include('model://table'))
    contents = read(folder, include('model://table'), problems=['model.sdf includes itself'])
    assert list(places(contents)) == ['a', 'a::b::l']


def chain(folder, length):
    """Write model 0, which includes 1, and so on up to `length`, which has a link."""
    for number in range(length):
        (folder / 'models' / str(number)).mkdir()
        model(folder / 'models' / str(number) / 'model.sdf', 'm', include(
            'model://{}'.format(number + 1 if number + 1 < length else 'table')))


def test_models_nested_too_deeply(folder):
    chain(folder, 120)
    tree, = read(folder, include('model://21')).trees
    assert tree.name == 'm' and tree.model.root == 'm::' * 98 + 'table::l'
    read(folder, include('model://20'), problems=[
        'models are nested more than 100 deep, at table in {}'.format(
            folder / 'models' / 'table' / 'model.sdf')])
    inside = '<model name="n">' * 60 + include('model://0') + '</model>' * 60
    read(folder, '<model name="o">{}</model>'.format(inside), problems=[
        'models are nested more than 100 deep, at m in '])


def test_too_many_included_models(folder, monkeypatch):
    monkeypatch.setattr(sdf_file, '_MAX_INCLUDED', 200)
    for number in range(30):        # 2 ** 30 models
        (folder / 'models' / str(number)).mkdir()
        model(folder / 'models' / str(number) / 'model.sdf', 'm', ''.join(include(
            'model://{}'.format(number + 1 if number < 29 else 'table'),
            '<name>{}</name>'.format(name)) for name in 'ab'))
    problems = Report()
    sdf_file.read(ElementTree.fromstring(sdf(include('model://0'))), str(folder / 'worlds' / 'w'),
                  lambda uri: None, problems)
    assert problems.of(LEFT_OUT)[0].startswith('it includes more than 200 models, at {}'.format(
        folder / 'models'))
    many = ''.join(include('model://table', '<name>{}</name>'.format(number))
                   for number in range(120))
    assert len(read(folder, many).trees) == 120


def test_what_included_files_ask_for_is_found_too(folder):
    plugin = '<plugin name="p" filename="lib{}.so"/>'
    model(folder / 'models' / 'table' / 'model.sdf', 'table', LINK.replace(
        '</link>', '<battery name="eye"/></link>') + plugin.format('b'))
    problems = Report()
    read(folder, include('model://table'), found=problems)
    assert [each.text() for each in problems.findings] == [
        '<battery> of model table link l', 'plugin libb.so of model table']


@pytest.mark.parametrize('inside, has_floor', [
    ('', False), (BUILT_IN, True), (include('model://ground_plane/'), True),
    (include('model://sun'), False), (include(FUEL + 'Ground Plane'), True),
    (include(FUEL + 'ground%20plane/2'), True), (include(FUEL + 'Sun'), False),
    (include('model://ground_plane', '<pose>0 0 1 0 0 0</pose>'), False),
    ('<model name="ground_plane"><static>1</static>' + LINK + '</model>', False)])
def test_a_floor_at_z_0_is_that_of_the_simulator(folder, inside, has_floor):
    assert read(folder, inside).has_floor is has_floor


def test_what_an_include_says_replaces_what_the_model_says(folder):
    model(folder / 'models' / 'table' / 'model.sdf', 'table',
          '<pose>7 8 9 0 0 0</pose><static>1</static>' + LINK)
    contents = read(folder, include('model://table', '<name>a</name>'), include(
        'model://table', '<name> b </name><pose>1 2 3 0 0 0</pose>'), include(
            'model://table', '<name> </name><static>0</static>'))
    assert places(contents) == {'a': [7, 8, 10], 'b': [1, 2, 4], 'table': [7, 8, 10]}
    assert [tree.fixed for tree in contents.trees] == [True, True, False]


def test_relative_paths(tmp_path):
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'a.stl').write_text('')
    found = {'model://b': 'found', 'file://elsewhere/a.stl': 'there'}
    find = sdf_file.find_relative(str(tmp_path), found.get)
    assert find('meshes/a.stl') == str(tmp_path / 'meshes' / 'a.stl')
    assert find('file://meshes') == str(tmp_path / 'meshes')
    assert find('file://' + str(tmp_path / 'meshes')) == str(tmp_path / 'meshes')
    assert (find('model://b'), find('none'), find('')) == ('found', None, None)
    assert find('file://elsewhere/a.stl') == 'there'
