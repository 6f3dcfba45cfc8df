"""Paths that users type, and output files that are written whole or not at all."""
import errno
import logging
import os
import signal
import subprocess
import sys
import threading

import pytest

from img_recog import files
from img_recog.errors import UserError
from img_recog_helpers.refusals import refusal

EXTENSIONS = ('.bag', '.csv')


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Make an empty folder the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(*names):
    with files.atomic_write(names) as outputs:
        for file in outputs:
            file.write(b'new')


@pytest.mark.parametrize('source, output, wanted', [
    ('/videos/a.mp4', '', 'a.replay'), ('a.bag', '', 'a.replay'), ('a', '.', './a.replay'),
    ('a.b.mp4', 'there', 'there/a.b.replay'), ('a.mp4', 'there/', 'there/a.replay'),
    ('a.mp4', 'new', 'new'), ('a.mp4', 'there/new', 'there/new')])
def test_names(folder, source, output, wanted):
    (folder / 'there').mkdir()
    assert files.output_paths(source, output, EXTENSIONS) == (wanted + '.bag', wanted + '.csv')


@pytest.mark.parametrize('output, named', [
    ('not/', 'cannot write to not/: no such folder; make it'),
    ('not/a', 'cannot write to not/a: no such folder; make it'),
    ('a', 'cannot write a.bag: that is what is read; set --output'),
    ('link', 'cannot write link.bag: that is what is read')])
def test_names_that_are_refused(folder, output, named):
    (folder / 'a.bag').write_text('recorded')
    (folder / 'link.bag').symlink_to('a.bag')
    assert refusal(files.output_paths, 'a.bag', output, EXTENSIONS).startswith(named)


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


@pytest.mark.parametrize('number', files.DISK_ERRORS)
def test_a_full_disk_names_the_files(folder, number):
    (folder / 'a').write_text('old')
    with pytest.raises(UserError) as refused:
        with files.atomic_write(('a', 'b'), advice='try c'):
            raise OSError(number, 'No Space')
    assert str(refused.value) == 'cannot write a, b: no space; try c'
    assert refused.value.__cause__.errno == number
    assert os.listdir('.') == ['a'] and (folder / 'a').read_text() == 'old'


def test_a_full_disk_names_the_one_file_that_is_known(folder):
    with pytest.raises(UserError, match='^cannot write b: no space; try c$'):
        with files.atomic_write(('a', 'b'), advice='try c') as outputs:
            raise OSError(errno.ENOSPC, 'No space', outputs[1].name)
    assert os.listdir('.') == []


@pytest.mark.parametrize('error', [
    OSError(errno.ENOSPC, 'No space', 'other'), OSError(errno.EPIPE, 'Broken pipe')])
def test_errors_of_other_files_are_passed_on(error):
    with pytest.raises(OSError) as raised:
        with files.atomic_write(('a', 'b')):
            raise error
    assert raised.value is error and os.listdir('.') == []


LIMITED = '''
import resource, sys
from img_recog import errors, files
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with files.atomic_write(['b', 'a']) as (other, file):
        other.write(b'x')
        file.write(b'x' * int(sys.argv[1]))
except errors.UserError as error:
    print(error)
'''


@pytest.mark.parametrize('size, named', [     # written when it is closed, or before
    (2000, b'a'), (2000000, b'b, a')])
def test_a_file_that_becomes_too_large(folder, size, named):
    done = subprocess.run([sys.executable, '-c', LIMITED, str(size)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    assert done.stdout.startswith(
        b'cannot write ' + named + b': file too large; set --output to ')
    assert os.listdir('.') == []


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
    with pytest.raises(UserError) as refused:
        write('a', 'no/b')
    problem, advice = refused.value.problem, refused.value.advice
    assert problem == 'cannot write no/b: no such file or directory'
    assert advice.startswith('set --output to a folder')
    assert isinstance(refused.value.__cause__, FileNotFoundError)
    assert os.listdir('.') == []


@pytest.mark.parametrize('make, named', [(os.mkdir, 'folder'), (os.mkfifo, 'device or pipe')])
def test_special_file_stays(make, named):
    make('taken')
    mode = os.stat('taken').st_mode
    os.symlink('taken', 'link')
    for name in ('taken', 'link'):
        with pytest.raises(UserError, match='cannot write {}: it is a {}; set '.format(
                name, named)):
            write('a', name)
    assert sorted(os.listdir('.')) == ['link', 'taken'] and os.stat('taken').st_mode == mode


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


WRITER = '''
import sys
from img_recog import files
with files.atomic_write(sys.argv[1:]) as outputs:
    for file in outputs:
        file.write(b'half')
        file.flush()
    outputs[0].close()      # as rosbag does
    print('written', flush=True)
    sys.stdin.read()
'''


@pytest.fixture
def writer(folder):
    """A process that has begun to write a and b, and finishes when its stdin is closed."""
    with subprocess.Popen([sys.executable, '-c', WRITER, 'a', 'b'], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b'written\n'
        yield process
        process.kill()


def test_files_of_a_killed_program_are_removed_by_the_next_one(folder, writer, caplog):
    (folder / 'there').mkdir()
    (folder / 'there' / 'a').symlink_to('../a')
    writer.kill()
    assert writer.wait() == -signal.SIGKILL
    hidden_a, hidden_b = sorted(os.listdir('.'))[:2]
    assert (hidden_a[:3], hidden_b[:3]) == ('.a.', '.b.')
    with caplog.at_level(logging.WARNING):
        write('c', 'b')
        assert sorted(os.listdir('.')) == [hidden_a, 'b', 'c', 'there']
        write('there/a')
    assert sorted(os.listdir('.')) == ['a', 'b', 'c', 'there']
    assert [record.getMessage() for record in caplog.records] == [
        'removed what a program that was killed has left: {}'.format(folder / name)
        for name in (hidden_b, hidden_a)]


def test_files_of_a_running_program_stay(folder, writer, caplog):
    write('a', 'b')
    assert len(os.listdir('.')) == 4 and (folder / 'a').read_text() == 'new'
    writer.stdin.close()
    assert writer.wait() == 0 and not caplog.records
    assert sorted(os.listdir('.')) == ['a', 'b'] and (folder / 'a').read_text() == 'half'


def test_only_our_hidden_files_are_removed(folder, tmp_path_factory):
    ours = ['.a.0123456789ab.img_recog', '.b.0123456789ab.img_recog']
    other = tmp_path_factory.mktemp('other') / 'precious'
    other.write_text('precious')
    names = ['.a', '.a.1.2', '.c.0123456789ab.img_recog', '.a.0123456789ag.img_recog',
             'x.a.0123456789ab.img_recog', '.aa.0123456789ab.img_recog',
             '.a.b.0123456789ab.img_recog', '.a.0123456789ab.img_recog.bag']
    for name in names + ours:
        (folder / name).write_text('')
    links = ['.a.00000000000{}.img_recog'.format(digit) for digit in range(3)]
    os.symlink(str(other), links[0])
    os.mkfifo(links[1])
    os.mkdir(links[2])
    assert files.remove_leftovers(['a', 'b']) == (
        'removed what a program that was killed has left: {}, {}'.format(
            *(folder / name for name in ours)))
    assert sorted(os.listdir('.')) == sorted(names + links) and other.read_text() == 'precious'
    assert files.remove_leftovers(['no/such/folder']) == ''


def test_a_planted_symlink_is_not_followed(folder, monkeypatch):
    (folder / 'precious').write_text('precious')
    numbers = iter(['0' * 12, '0' * 12])

    class Fixed:
        hex = property(lambda self: next(numbers))
    monkeypatch.setattr(files.uuid, 'uuid4', Fixed)
    os.symlink('precious', '.a.000000000000.img_recog')
    with pytest.raises(UserError, match='cannot write a: file exists'):
        write('a')
    assert (folder / 'precious').read_text() == 'precious'


def test_file_that_is_taken_for_a_leftover_before_it_is_locked(folder, monkeypatch):
    removed = []

    def lock(descriptor, how):
        if not removed:
            removed.extend(name for name in os.listdir('.') if name.startswith('.'))
            os.remove(removed[0])
    monkeypatch.setattr(files.fcntl, 'flock', lock)
    write('a')
    assert len(removed) == 1 and os.listdir('.') == ['a']


def test_symlink_stays_and_its_target_is_written(folder):
    (folder / 'there').mkdir()
    os.symlink('there/file', 'link')
    write('link')
    assert os.path.islink('link') and (folder / 'there' / 'file').read_text() == 'new'
    assert os.listdir('there') == ['file']


def test_relative_paths_are_searched_for_in_the_folder_of_the_user(monkeypatch, tmp_path):
    (tmp_path / 'my.urdf').write_text('')
    monkeypatch.setenv('PWD', str(tmp_path))
    assert files.find_user_path('my.urdf') == str(tmp_path / 'my.urdf')
    assert files.find_user_path('no.urdf') == 'no.urdf'


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


def test_a_free_name_is_not_that_of_a_file_or_of_a_recording(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    assert files.free_output_path('recording', '.bag') == str(tmp_path / 'recording_1.bag')
    (tmp_path / 'recording_1.bag').touch()
    (tmp_path / 'recording_2.bag.active').touch()       # rosbag records it
    assert files.free_output_path('recording', '.bag') == str(tmp_path / 'recording_3.bag')


@pytest.mark.parametrize('chosen, folder', [('', '/home/a/.cache'), ('/cache', '/cache')])
def test_folder_for_what_can_be_made_again(monkeypatch, chosen, folder):
    monkeypatch.setenv('HOME', '/home/a')
    monkeypatch.setenv('XDG_CACHE_HOME', chosen)
    assert files.cache_folder('x') == folder + '/img_recog/x'
