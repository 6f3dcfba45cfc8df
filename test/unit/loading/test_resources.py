"""From the URI of a mesh to its file."""
import os

import pytest
import rospkg

from img_recog.loading import resources


def test_package():
    path = resources.find('package://img_recog/urdf/turtlebot3_burger.urdf')
    assert os.path.isabs(path) and path.endswith('/urdf/turtlebot3_burger.urdf')
    with open(path) as file:
        assert 'base_footprint' in file.read()


@pytest.mark.parametrize('uri', [
    'package://no_such_package/meshes/a.stl', 'package://img_recog/meshes/no_such_file.stl',
    'package://img_recog/urdf', 'package://img_recog', 'package://', 'package:///a.stl',
    'http://example.org/shelf.dae', '', 'file://'])
def test_what_is_not_there_or_no_file(uri):
    assert resources.find(uri) is None


MESH, SHELF = 'models/shelf/meshes/shelf.dae', 'model://shelf/meshes/shelf.dae'
FOLDERS = '{0}/nothing::{0}/models:{0}'


# the folders of models or of resources, from where it is searched, and what is found; {0}: of all
@pytest.mark.parametrize('variable, folders, here, uri, found', [
    # model://, in the first folder that has it
    *(('MODEL', FOLDERS, '', uri, found) for uri, found in (
        (SHELF, MESH), ('model://models/shelf/meshes/shelf.dae', MESH),
        ('model://shelf/meshes/table.dae', None), ('model:///shelf/meshes/shelf.dae', MESH),
        ('model://shelf', 'models/shelf'))),
    # not without a path of models
    ('MODEL', None, 'models', SHELF, None), ('MODEL', '', 'models', SHELF, None),
    *(('MODEL', '', 'models/shelf/meshes', uri, found) for uri, found in (
        ('file://{0}/' + MESH, MESH), ('{0}/' + MESH, MESH), ('shelf.dae', MESH),
        ('file://{0}/' + MESH + '.gz', None))),
    # a relative path, where Gazebo searches for it
    *(('RESOURCE', folders, '', uri, found) for path in ('shelf/meshes', 'shelf/meshes/shelf.dae')
      for uri in (path, 'file://' + path)
      for folders, found in (('{0}/nothing', None), ('/nowhere:{0}/models', 'models/' + path)))])
def test_files_and_folders(monkeypatch, tmp_path, variable, folders, here, uri, found):
    (tmp_path / MESH).parent.mkdir(parents=True)
    (tmp_path / MESH).write_text('<COLLADA/>')
    monkeypatch.chdir(tmp_path / here)
    monkeypatch.delenv('GAZEBO_MODEL_PATH', raising=False)
    if folders is not None:
        monkeypatch.setenv('GAZEBO_{}_PATH'.format(variable), folders.format(tmp_path))
    assert resources.find(uri.format(tmp_path)) == (found and str(tmp_path / found))


def test_models_that_gazebo_has_downloaded(monkeypatch, tmp_path):
    monkeypatch.setenv('HOME', str(tmp_path))
    folder = tmp_path / '.gazebo' / 'models' / 'table'
    assert resources.find('model://table') is None
    folder.mkdir(parents=True)
    assert resources.find('model://table') == str(folder)


@pytest.fixture
def packages(monkeypatch, tmp_path):
    """A folder of packages, of which one is turtlebot3_gazebo."""
    def add(name, export=''):
        path = tmp_path / 'packages' / name
        (path / 'worlds').mkdir(parents=True)
        (path / 'package.xml').write_text(
            '<package><name>{}</name><version>1.0.0</version><description>d</description>'
            '<maintainer email="m@example.org">m</maintainer><license>l</license>'
            '<export>{}</export></package>'.format(name, export))
        return path
    paths = {'bare': add('bare'), 'turtlebot3_gazebo': add(
        'turtlebot3_gazebo', '<gazebo_ros gazebo_model_path="${prefix}/models" '
        'gazebo_media_path="${prefix}/media"/>')}
    (add('broken') / 'package.xml').write_text('<package><name>broken</name></package>')
    monkeypatch.setattr(resources, '_packages',
                        rospkg.RosPack([str(tmp_path / 'packages')]))
    monkeypatch.delenv('GAZEBO_MODEL_PATH', raising=False)
    return paths


@pytest.mark.parametrize('uri, folder', [
    ('model://course', 'models/course'), ('file://materials', 'media/materials')])
def test_folders_that_a_package_exports(packages, uri, folder):
    path = packages['turtlebot3_gazebo'] / folder
    assert resources.find(uri) is None
    path.mkdir(parents=True)
    assert resources.find(uri) == str(path)


def test_names_of_worlds(packages):
    worlds = packages['turtlebot3_gazebo'] / 'worlds'
    for name in ('turtlebot3_house.world', 'turtlebot3_world.world', 'readme.txt'):
        (worlds / name).write_text('')
    found = resources.worlds()
    assert set(found) == {'color_posts', 'turtlebot3_house', 'turtlebot3_world'}
    assert found['turtlebot3_house'] == str(worlds / 'turtlebot3_house.world')
    assert found['turtlebot3_world'].endswith('/urdf/turtlebot3_world.urdf')


def test_names_of_worlds_without_turtlebot3_gazebo(monkeypatch, tmp_path):
    monkeypatch.setattr(resources, '_packages', rospkg.RosPack([str(tmp_path)]))
    assert set(resources.worlds()) == {'color_posts', 'turtlebot3_world'}
    assert all(map(os.path.isfile, resources.worlds().values()))


def test_the_colors_of_the_article():
    path = resources.colors()
    assert path.endswith('/config/colors.yaml') and os.path.isfile(path)
