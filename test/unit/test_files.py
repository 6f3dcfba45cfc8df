"""Paths that users type, and output files that are written whole or not at all."""
import os
import threading

import pytest

from img_recog import files
from img_recog.errors import UserError

EXTENSIONS = ('.bag', '.csv')


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Make an empty folder the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize('source, output, wanted', [
    ('/videos/a.mp4', '', 'a.replay'), ('a.bag', '', 'a.replay'), ('a', '.', './a.replay'),
    ('a.b.mp4', 'there', 'there/a.b.replay'), ('a.mp4', 'there/', 'there/a.replay'),
    ('a.mp4', 'new', 'new'), ('a.mp4', 'there/new', 'there/new')])
def test_names(folder, source, output, wanted):
    (folder / 'there').mkdir()
    assert files.output_paths(source, output, EXTENSIONS) == (wanted + '.bag', wanted + '.csv')


@pytest.mark.parametrize('output, named', [
    ('not/', 'cannot write to not/: no such folder; make it'),
    ('a', 'cannot write a.bag: that is what is replayed; set --output'),
    ('link', 'cannot write link.bag: that is what is replayed')])
def test_names_that_are_refused(folder, output, named):
    (folder / 'a.bag').write_text('recorded')
    (folder / 'link.bag').symlink_to('a.bag')
    with pytest.raises(UserError) as refused:
        files.output_paths('a.bag', output, EXTENSIONS)
    assert str(refused.value).startswith(named)


def test_files_are_replaced_when_all_are_written(folder):
    (folder / 'a').write_text('old')
    with files.atomic_write(('a', 'b')) as outputs:
        for file in outputs:
            file.write(b'new')
        assert (folder / 'a').read_text() == 'old' and not (folder / 'b').exists()
    assert sorted(os.listdir('.')) == ['a', 'b']
    assert (folder / 'a').read_text() == (folder / 'b').read_text() == 'new'


@pytest.mark.parametrize('error', [
    UserError('wrong'), KeyboardInterrupt(), SystemExit(), OSError()])
def test_failure_leaves_the_old_files(folder, error):
    (folder / 'a').write_text('old')
    with pytest.raises(type(error)):
        with files.atomic_write(('a', 'b')) as outputs:
            outputs[0].write(b'new')
            outputs[1].close()
            raise error
    assert os.listdir('.') == ['a'] and (folder / 'a').read_text() == 'old'


@pytest.mark.parametrize('last', [1, 2])
def test_signal_right_after_a_file_is_opened(folder, monkeypatch, last):
    opened = []

    def interrupted(*arguments):
        opened.append(open(*arguments))
        if len(opened) == last:
            raise KeyboardInterrupt
        return opened[-1]
    monkeypatch.setattr(files, 'open', interrupted, raising=False)
    with pytest.raises(KeyboardInterrupt):
        with files.atomic_write(('a', 'b')):
            raise AssertionError('must not be reached')
    assert len(opened) == last and os.listdir('.') == []


def test_file_that_cannot_be_written_is_named(folder):
    with pytest.raises(UserError, match='cannot write no/b: no such file or directory; set '):
        with files.atomic_write(('a', 'no/b')):
            raise AssertionError('must not be reached')
    assert os.listdir('.') == []


@pytest.mark.parametrize('make, named', [(os.mkdir, 'folder'), (os.mkfifo, 'device or pipe')])
def test_special_file_stays(make, named):
    make('taken')
    mode = os.stat('taken').st_mode
    os.symlink('taken', 'link')
    for name in ('taken', 'link'):
        with pytest.raises(UserError, match='cannot write {}: it is a {}; set '.format(
                name, named)):
            with files.atomic_write(('a', name)):
                raise AssertionError('must not be reached')
    assert sorted(os.listdir('.')) == ['link', 'taken'] and os.stat('taken').st_mode == mode


def test_refusal_has_problem_advice_and_the_error_of_the_system(folder):
    with pytest.raises(UserError) as refused:
        with files.atomic_write(('no/b',), advice='try c'):
            raise AssertionError('must not be reached')
    assert (refused.value.problem, refused.value.advice) == (
        'cannot write no/b: no such file or directory', 'try c')
    assert isinstance(refused.value.__cause__, FileNotFoundError)


def test_threads_that_write_the_same_file_do_not_disturb_each_other(folder):
    written = []

    def write():
        with files.atomic_write(('a',)) as (file,):
            file.write(b'inner')
        written.append(True)

    with files.atomic_write(('a',)) as (outer,):
        outer.write(b'outer')
        thread = threading.Thread(target=write)
        thread.start()
        thread.join()
        assert written and (folder / 'a').read_text() == 'inner'
    assert (folder / 'a').read_text() == 'outer' and os.listdir('.') == ['a']


def test_symlink_stays_and_its_target_is_written(folder):
    (folder / 'there').mkdir()
    os.symlink('there/file', 'link')
    with files.atomic_write(('link',)) as (file,):
        file.write(b'new')
    assert os.path.islink('link') and (folder / 'there' / 'file').read_text() == 'new'
    assert os.listdir('there') == ['file']


def test_relative_paths_are_searched_for_in_the_folder_of_the_user(monkeypatch, tmp_path):
    (tmp_path / 'my.urdf').write_text('')
    (tmp_path / 'empty').write_text('')
    monkeypatch.setenv('PWD', str(tmp_path))
    assert files.find_user_path('my.urdf') == str(tmp_path / 'my.urdf')
    assert files.find_user_path('no.urdf') == 'no.urdf'
    assert files.find_user_path('empty', except_names=('empty',)) == 'empty'


def test_find_in_a_folder(tmp_path):
    path = tmp_path / 'm' / 'a.stl'
    for folder in (path.parent, tmp_path / 'package:' / 'm'):
        folder.mkdir(parents=True)
        (folder / 'a.stl').write_bytes(b'')
    find = files.find_in(str(tmp_path))
    for uri in (str(path), 'file://{}'.format(path), 'm/a.stl', './m/../m/a.stl'):
        assert os.path.samefile(find(uri), str(path))
    for uri in ('a.stl', 'm', '', 'file://', 'file://{}/b.stl'.format(tmp_path), '/m/a.stl',
                'package://m/a.stl', 'http://m/a.stl'):
        assert find(uri) is None
