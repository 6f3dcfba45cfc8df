"""What is drawn of files is kept for the next start, and read again when a file has changed."""
import os

import numpy as np
import pytest
from PIL import Image

from img_recog.formats import materials
from img_recog.formats.meshes import mesh_file
from img_recog.rendering import prepared

OBJ = ('mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\no first\n'
       'usemtl a\nf 1/1 2/2 3/3\no second\nf 1/1 2/2 4/3\n')


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a mesh, its material and its texture; the cache is empty."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    (tmp_path / 'a.obj').write_text(OBJ)
    (tmp_path / 'm.mtl').write_text('newmtl a\nKd 1 0 0\nmap_Kd a.png\n')
    Image.fromarray(np.arange(3 * 4 * 4, dtype=np.uint8).reshape(4, 3, 4)).save(
        str(tmp_path / 'a.png'))
    return tmp_path


def reads(monkeypatch, module, name='read'):
    """Return a list of what a function of a module reads from now on."""
    found, read = [], getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given: found.append(given) or read(*given))
    return found


def read_mesh(folder):
    parts = prepared.read_mesh(str(folder / 'a.obj'))
    prepared.wait_for_writers()
    return parts


def cached_files(folder):
    return [os.path.join(parent, name) for parent, _, names in os.walk(str(folder / 'cache'))
            for name in names]


def test_a_mesh_is_read_once_and_the_same_the_next_time(folder, monkeypatch):
    found = reads(monkeypatch, mesh_file)
    first, second = read_mesh(folder), read_mesh(folder)
    assert len(found) == 1 and len(first) == len(second) == 2
    for one, other in zip(first, second):
        assert other[3:] == one[3:] and other.material.texture == str(folder / 'a.png')
        for name in ('positions', 'normals', 'uvs'):
            assert np.array_equal(getattr(other, name), getattr(one, name))
    assert {part.name for part in second} == {'first', 'second'}


@pytest.mark.parametrize('name, text', [
    ('a.obj', OBJ.replace('o second', 'o third')), ('m.mtl', 'newmtl a\nKd 0 1 0\n')])
def test_a_mesh_that_has_changed_is_read_again(folder, name, text):
    before = read_mesh(folder)
    (folder / name).write_text(text)
    os.utime(str(folder / name), (1, 1))        # whatever the resolution of the clock
    after = read_mesh(folder)
    assert [part[3:] for part in after] != [part[3:] for part in before]


def test_a_mesh_whose_texture_is_not_found_is_read_each_time(folder, monkeypatch):
    found = reads(monkeypatch, mesh_file)
    read_mesh(folder)
    (folder / 'a.png').rename(folder / 'b.png')
    read_mesh(folder)
    read_mesh(folder)
    assert len(found) == 3


@pytest.mark.parametrize('mode, shape', [('RGB', (4, 3, 3)), ('RGBA', (4, 3, 4))])
def test_a_texture_is_decoded_once(folder, monkeypatch, mode, shape):
    path = str(folder / 'a.png')
    expected = materials.read_texture(path, mode)
    found = reads(monkeypatch, materials, 'read_texture')
    for _ in range(2):
        image = prepared.read_texture(path, mode)
        prepared.wait_for_writers()
        assert image.shape == shape and np.array_equal(image, expected)
    assert len(found) == 1
    os.utime(path, (1, 1))
    prepared.read_texture(path, mode)
    assert len(found) == 2


def test_errors_are_those_of_the_readers(folder):
    for name, read, error in (('a.stl', prepared.read_mesh, mesh_file.MeshError),
                              ('b.obj', prepared.read_mesh, mesh_file.MeshError),
                              ('m.mtl', prepared.read_texture, materials.TextureError)):
        with pytest.raises(error, match='cannot read the .*' + name):
            read(str(folder / name))


@pytest.mark.parametrize('size', [0, 40, -10])
def test_a_damaged_file_of_the_cache_is_written_anew(folder, monkeypatch, size):
    first = read_mesh(folder)
    path, = cached_files(folder)
    with open(path, 'r+b') as file:
        file.truncate(size % os.path.getsize(path))
    found = reads(monkeypatch, mesh_file)
    for _ in range(2):
        assert np.array_equal(read_mesh(folder)[1].positions, first[1].positions)
    assert len(found) == 1


def test_without_a_folder_that_can_be_written_it_reads_each_time(folder, monkeypatch):
    (folder / 'file').write_text('')
    monkeypatch.setenv('XDG_CACHE_HOME', str(folder / 'file'))
    assert len(read_mesh(folder)) == len(read_mesh(folder)) == 2


def test_the_files_that_were_not_used_for_longest_are_removed(folder, monkeypatch):
    monkeypatch.setattr(prepared, 'MAX_BYTES', 3000)
    for number in range(3):
        prepared.store_prepared(np.full(1000, number, np.uint8), number, 'key', number)
        prepared.wait_for_writers()
        for path in cached_files(folder):
            status = os.stat(path)
            os.utime(path, (status.st_atime - 9, status.st_mtime - 9))
        assert prepared.load_stored('key', 0)[1] == 0        # it is in use
    assert [prepared.load_stored('key', number) is None for number in range(3)] == [
        False, True, False]
    assert len(cached_files(folder)) == 2
