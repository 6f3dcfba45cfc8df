"""Files: how a path that a user types is resolved, and files that are written atomically."""
import contextlib
import io
import os
import threading
from typing import Callable, Iterator, List, Optional, Sequence, Tuple

from img_recog.errors import UserError, one_line

# Maps the URI of a file to its path, or to None when there is no such file.
FindFile = Callable[[str], Optional[str]]


def user_folders() -> Tuple[str, ...]:
    """Return the folders in which a relative path that a user typed is searched for.

    roslaunch starts nodes in ROS_HOME; PWD is still the folder in which the user started it.
    """
    return os.environ.get('PWD', ''), os.getcwd()


def find_user_path(path: str, except_names: Sequence[str] = ()) -> str:
    """Return the first existing file that a relative path can mean, or else the path as given.

    except_names: names that are not paths, even where a file has the same name.
    """
    if path in except_names:
        return path
    candidates = (os.path.join(folder, os.path.expanduser(path)) for folder in user_folders())
    return next(filter(os.path.isfile, candidates), path)


def find_in(folder: str) -> FindFile:
    """Return a function that finds file:// URIs, absolute paths and paths relative to `folder`.
    """
    def find(uri: str) -> Optional[str]:
        if '://' in uri and not uri.startswith('file://'):
            return None
        path = os.path.join(folder, uri[len('file://'):] if uri.startswith('file://') else uri)
        return path if os.path.isfile(path) else None
    return find


def output_paths(source: str, output: str, extensions: Sequence[str]) -> Tuple[str, ...]:
    """Return the paths of the output files for the input file `source`, one for each extension.

    output: a folder, the common prefix of the paths, or empty for the current folder.
    Raises UserError when there is no such folder, or when a path is that of `source`.
    """
    stem = os.path.splitext(os.path.basename(source))[0] + '.replay'
    prefix = os.path.join(output, stem) if os.path.isdir(output or '.') else output
    if prefix.endswith(os.sep):
        raise UserError('cannot write to {}: no such folder'.format(output),
                        'make it, or set --output to another')
    paths = tuple(prefix + extension for extension in extensions)
    for path in paths:
        if os.path.exists(path) and os.path.samefile(path, source):
            raise UserError('cannot write {}: that is what is replayed'.format(path),
                            'set --output to another')
    return paths


@contextlib.contextmanager
def atomic_write(paths: Sequence[str],
                 advice: str = 'set --output to a folder or the beginning of a path where files '
                 'can be written') -> Iterator[List[io.BufferedRandom]]:
    """Yield a binary file for each path; replace the files at `paths` when the block succeeds.

    When anything fails, the old files stay. Symlinks stay and their targets are replaced; folders,
    devices and pipes are never replaced.
    Raises UserError naming the path that cannot be written, with `advice`; its cause is the
    OSError of the system, if there was one. An error that is raised in the block is passed on.
    """
    for path in paths:
        if os.path.exists(path) and not os.path.isfile(path):
            raise UserError('cannot write {}: it is a {}'.format(
                path, 'folder' if os.path.isdir(path) else 'device or pipe'), advice)
    targets = [os.path.realpath(path) for path in paths]
    # threads may write the same file: two calls of a service of rospy do
    suffix = '{}.{}'.format(os.getpid(), threading.get_ident())
    parts = [os.path.join(os.path.dirname(target), '.{}.{}'.format(os.path.basename(target),
                                                                   suffix))
             for target in targets]
    files: List[io.BufferedRandom] = []
    try:
        for path, part in zip(paths, parts):
            with _refusal(path, advice):
                files.append(open(part, 'w+b'))
        yield files
        for path, part, target, file in zip(paths, parts, targets, files):
            with _refusal(path, advice):
                file.close()
                os.replace(part, target)
    finally:
        for file in files:
            with contextlib.suppress(OSError):
                file.close()
        for part in parts:      # one more than `files` if a signal arrived between open and append
            with contextlib.suppress(OSError):
                os.remove(part)


@contextlib.contextmanager
def _refusal(path: str, advice: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UserError('cannot write {}: {}'.format(path, one_line(error).lower()),
                        advice) from error
