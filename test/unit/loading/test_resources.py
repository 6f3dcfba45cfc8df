"""From the URI of a mesh to its file."""
import os

import pytest
import rospkg

from img_recog.loading import resources


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / 'models' / 'shelf' / 'meshes' / 'shelf.dae'
    path.parent.mkdir(parents=True)
    path.write_text('<COLLADA/>')
    return path


def test_package():
    path = resources.find('package://img_recog/urdf/turtlebot3_burger.urdf')
    assert os.path.isabs(path) and path.endswith('/urdf/turtlebot3_burger.urdf')
    with open(path) as file:
        assert 'base_footprint' in file.read()


@pytest.mark.parametrize('uri', [
    'package://no_such_package/meshes/a.stl', 'package://img_recog/meshes/no_such_file.stl',
    'package://img_recog/urdf', 'package://img_recog', 'package://', 'package:///a.stl'])
def test_package_that_is_not_there_or_has_no_such_file(uri):
    assert resources.find(uri) is None


def test_model_in_the_first_folder_that_has_it(monkeypatch, tmp_path, mesh):
    folders = [str(tmp_path / 'nothing'), '', str(tmp_path / 'models'), str(tmp_path)]
    monkeypatch.setenv('GAZEBO_MODEL_PATH', os.pathsep.join(folders))
    assert resources.find('model://shelf/meshes/shelf.dae') == str(mesh)
    assert resources.find('model://models/shelf/meshes/shelf.dae') == str(mesh)
    assert resources.find('model://shelf/meshes/table.dae') is None
    assert resources.find('model:///shelf/meshes/shelf.dae') == str(mesh)
    assert resources.find('model://shelf') == str(mesh.parent.parent)


@pytest.mark.parametrize('change', [
    lambda patched: patched.delenv('GAZEBO_MODEL_PATH', raising=False),
    lambda patched: patched.setenv('GAZEBO_MODEL_PATH', '')])
def test_no_model_without_a_model_path(monkeypatch, mesh, change):
    monkeypatch.chdir(mesh.parent.parent.parent)
    change(monkeypatch)
    assert resources.find('model://shelf/meshes/shelf.dae') is None


def test_file_and_path(monkeypatch, mesh):
    monkeypatch.chdir(mesh.parent)
    assert resources.find('file://' + str(mesh)) == str(mesh)
    assert resources.find(str(mesh)) == str(mesh)
    assert resources.find('shelf.dae') == str(mesh)
    assert resources.find('file://' + str(mesh) + '.gz') is None
    for uri in ('http://example.org/shelf.dae', '', 'file://'):
        assert resources.find(uri) is None


@pytest.mark.parametrize('uri', ['file://shelf/meshes', 'file://shelf/meshes/shelf.dae',
                                 'shelf/meshes/shelf.dae'])
def test_a_relative_path_is_searched_for_where_gazebo_does(monkeypatch, tmp_path, mesh, uri):
    monkeypatch.setenv('GAZEBO_RESOURCE_PATH', str(tmp_path / 'nothing'))
    assert resources.find(uri) is None
    monkeypatch.setenv('GAZEBO_RESOURCE_PATH', ':'.join(['/nowhere', str(tmp_path / 'models')]))
    assert resources.find(uri) == str(tmp_path / 'models' / uri.replace('file://', ''))


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
