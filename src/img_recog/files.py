"""Files: how a path that a user types is resolved, and files that are written atomically."""
import contextlib
import errno
import fcntl
import io
import itertools
import logging
import os
import re
import stat
import uuid
from typing import Callable, Iterator, List, Optional, Sequence, Set, Tuple

from img_recog.errors import UserError, one_line

_log = logging.getLogger(__name__)
# a hidden file, until it replaces the file NAME: .NAME.12 hexadecimal digits.img_recog
_PART, _DIGITS, _SUFFIX = '.{}.{}{}', 12, '.img_recog'
# of a disk that is full or fails, and of the limits of a user
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
# Maps the URI of a file to its path, or to None when there is no such file.
FindFile = Callable[[str], Optional[str]]
_noted: List[Set[str]] = []


def plain(path: str, flags: int) -> int:
    """Open what a file names, as the `opener` of `open`; UserError for a pipe or device."""
    descriptor = os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):       # `open` refuses folders
        os.close(descriptor)
        raise UserError(path + ' is a pipe or device, not a file')
    for paths in _noted:
        paths.add(path)
    return descriptor


@contextlib.contextmanager
def noting() -> Iterator[Set[str]]:
    """Yield a set that gets the path of each file that `plain` opens in the block."""
    _noted.append(set())
    try:
        yield _noted[-1]
    finally:
        _noted.pop()


def no_file(path: Optional[str]) -> str:
    """Return the words that what is at a path is no file, '' if nothing is there.

    >>> no_file('/dev/null'), no_file('/'), no_file(None)
    (' (a pipe or device, not a file)', ' (a folder, not a file)', '')
    """
    if path is None or not os.path.exists(path):
        return ''
    return ' (a {}, not a file)'.format('folder' if os.path.isdir(path) else 'pipe or device')


def user_folders() -> Tuple[str, ...]:
    """Return the folders in which a relative path that a user typed is searched for.

    roslaunch starts nodes in ROS_HOME; PWD is still the folder in which the user started it.
    """
    return os.environ.get('PWD', ''), os.getcwd()


def cache_folder(kind: str) -> str:
    """Return the folder for files of a kind that can be made again, in the user's for caches."""
    return os.path.join(os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache'),
                        'img_recog', kind)


def find_user_path(path: str) -> str:
    """Return the first existing file that a relative path can mean, or else the path as given."""
    candidates = (os.path.join(folder, os.path.expanduser(path)) for folder in user_folders())
    return next(filter(os.path.isfile, candidates), path)


def user_output_path(path: str) -> str:
    """Return the absolute path of a file to write; a relative path starts in the user's folder."""
    folder = next(filter(os.path.isdir, user_folders()))
    return os.path.abspath(os.path.join(folder, os.path.expanduser(path)))


def free_output_path(name: str, extension: str) -> str:
    """Return the path of a new file NAME_1, NAME_2, ... in the user's folder.

    A file that rosbag has begun to record (with the suffix .active) takes its name.
    """
    paths = (user_output_path('{}_{}{}'.format(name, number, extension))
             for number in itertools.count(1))
    return next(path for path in paths if not any(
        os.path.exists(path + suffix) for suffix in ('', '.active')))


def find_in(folder: str) -> FindFile:
    """Return a function that finds file:// URIs, absolute paths and paths relative to `folder`.
    """
    def find(uri: str) -> Optional[str]:
        if '://' in uri and not uri.startswith('file://'):
            return None
        path = os.path.join(folder, uri[len('file://'):] if uri.startswith('file://') else uri)
        return path if os.path.isfile(path) else None
    return find


def output_paths(source: str, output: str, extensions: Sequence[str],
                 kind: str = 'replay') -> Tuple[str, ...]:
    """Return the paths of the output files for the input file `source`, one for each extension.

    output: a folder, the common prefix of the paths, or empty for the current folder. kind: of
    the output, a part of the names.
    Raises UserError when there is no such folder, or when a path is that of `source`.
    """
    prefix = output_prefix(
        output, os.path.splitext(os.path.basename(source))[0] + '.' + kind)
    paths = tuple(prefix + extension for extension in extensions)
    for path in paths:
        refuse_input(path, source, 'read', 'set --output to another')
    return paths


def output_prefix(output: str, name: str) -> str:
    """Return the common prefix of the paths of output files.

    output: as for `output_paths`. name: Prefix in a folder. Raises UserError if the folder of the
    files does not exist.
    """
    prefix = os.path.join(output, name) if os.path.isdir(output or '.') else output
    if not os.path.isdir(os.path.dirname(prefix) or '.'):
        raise UserError('cannot write to {}: no such folder'.format(output),
                        'make it, or set --output to another')
    return prefix


def refuse_input(path: str, source: str, use: str, advice: str) -> None:
    """Raise UserError, with `advice`, if the file to write is the input file, also by a link.

    use: what is done with the input, as 'replayed'.
    """
    if os.path.exists(path) and os.path.exists(source) and os.path.samefile(path, source):
        raise UserError('cannot write {}: that is what is {}'.format(path, use), advice)


@contextlib.contextmanager
def atomic_write(paths: Sequence[str],
                 advice: str = 'set --output to a folder or the beginning of a path where files '
                 'can be written') -> Iterator[List[io.BufferedRandom]]:
    """Yield a binary file for each path; replace the files at `paths` when the block succeeds.

    When anything fails, the old files stay. Symlinks stay and their targets are replaced; folders,
    devices and pipes are never replaced. The yielded files are hidden; those that a killed program
    has left are removed first, with a warning in the log.
    Raises UserError naming the path that cannot be written, with `advice`; its cause is the
    OSError of the system, if there was one. So is an OSError of DISK_ERRORS that is raised in the
    block; it names a path if its file name is that of a yielded file. Others are passed on.
    """
    for path in paths:
        if os.path.exists(path) and not os.path.isfile(path):
            raise UserError('cannot write {}: it is a {}'.format(
                path, 'folder' if os.path.isdir(path) else 'device or pipe'), advice)
    targets = [os.path.realpath(path) for path in paths]
    removed = remove_leftovers(targets)
    if removed:
        _log.warning('%s', removed)
    # threads may write the same file: two calls of a service of rospy do
    parts = [os.path.join(os.path.dirname(target), _PART.format(
        os.path.basename(target), uuid.uuid4().hex[:_DIGITS], _SUFFIX)) for target in targets]
    files: List[io.BufferedRandom] = []
    locks: List[int] = []
    try:
        for path, part in zip(paths, parts):
            with refusal(path, advice):
                files.append(_create(part, locks))
        try:
            yield files
        except OSError as error:
            if error.errno not in DISK_ERRORS or error.filename not in (None, *parts):
                raise
            # without a file name it may be about each of them
            with refusal(', '.join(path for path, part in zip(paths, parts)
                                   if error.filename in (None, part)), advice):
                raise
        for path, file in zip(paths, files):        # the disk may be full only now
            with refusal(path, advice):
                file.close()
        for path, part, target in zip(paths, parts, targets):
            with refusal(path, advice):
                os.replace(part, target)
    finally:
        for file in files:
            with contextlib.suppress(OSError):
                file.close()
        for part in parts:      # one more than `files` if a signal arrived between open and append
            with contextlib.suppress(OSError):
                os.remove(part)
        for lock in locks:
            os.close(lock)


def remove_leftovers(paths: Sequence[str]) -> str:
    """Remove the hidden files of programs that were killed while they wrote one of `paths`.

    Returns a line for the log, empty if there are none. Files that a program still writes stay: it
    locks them.
    """
    removed = [each for path in paths for each in _hidden(path) if _removed_if_unlocked(each)]
    return ('removed what a program that was killed has left: ' + ', '.join(removed)
            if removed else '')


def _hidden(path: str) -> List[str]:
    """Return the hidden files that `atomic_write` has made for `path`."""
    folder, name = os.path.split(os.path.realpath(path))
    pattern = re.compile(re.escape(_PART.format(name, '#', _SUFFIX)).replace(
        re.escape('#'), '[0-9a-f]{{{}}}'.format(_DIGITS)))
    try:
        names = sorted(filter(pattern.fullmatch, os.listdir(folder)))
    except OSError:         # the error of opening the file is clearer
        return []
    return [os.path.join(folder, each) for each in names]


def _create(part: str, locks: List[int]) -> io.BufferedRandom:
    """Create a hidden file, and lock it until the descriptor that is added to `locks` is closed.

    The kernel releases the lock of a program that is killed. The process id would not tell: it may
    be used again, or be of another container.
    """
    while True:
        file = open(part, 'x+b')        # never through a symlink
        locks.append(os.dup(file.fileno()))     # the caller may close the file
        with contextlib.suppress(OSError):      # a file system without locks
            fcntl.flock(locks[-1], fcntl.LOCK_EX)
        if os.path.exists(part):
            return file
        file.close()        # another program removed it before it was locked


def _removed_if_unlocked(path: str) -> bool:
    try:
        lock = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        if not stat.S_ISREG(os.fstat(lock).st_mode):
            return False
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.remove(path)
        return True
    except OSError:
        return False
    finally:
        os.close(lock)


@contextlib.contextmanager
def refusal(path: str, advice: str) -> Iterator[None]:
    """Raise UserError for an OSError in the block, which says that `path` cannot be written."""
    try:
        yield
    except OSError as error:
        raise UserError('cannot write {}: {}'.format(path, one_line(error).lower()),
                        advice) from error
