"""From the URI of a mesh to its file."""
import os

import pytest

from img_recog import resources


@pytest.fixture
def mesh(tmp_path):
    """A file in a folder of models."""
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
    assert resources.find('model://shelf') is None


def test_no_model_without_a_model_path(monkeypatch, mesh):
    monkeypatch.chdir(mesh.parent.parent.parent)
    monkeypatch.delenv('GAZEBO_MODEL_PATH', raising=False)
    assert resources.find('model://shelf/meshes/shelf.dae') is None
    monkeypatch.setenv('GAZEBO_MODEL_PATH', '')
    assert resources.find('model://shelf/meshes/shelf.dae') is None


def test_file_and_path(monkeypatch, mesh):
    monkeypatch.chdir(mesh.parent)
    assert resources.find('file://' + str(mesh)) == str(mesh)
    assert resources.find(str(mesh)) == str(mesh)
    assert resources.find('shelf.dae') == str(mesh)
    assert resources.find('file://' + str(mesh) + '.gz') is None
    assert resources.find('http://example.org/shelf.dae') is None
