"""Files: where a path that a user types leads, and files that are written whole or not at all."""
import contextlib
import os
from typing import Callable, Iterator, Optional, Sequence, Tuple

from img_recog.errors import UserError

# from the URI of a file to its path, None when there is no such file
FindFile = Callable[[str], Optional[str]]


def user_folders() -> Tuple[str, ...]:
    """Return the folders in which a relative path that a user typed is looked for.

    roslaunch starts nodes in ROS_HOME; PWD still names the folder in which the user ran it.
    """
    return os.environ.get('PWD', ''), os.getcwd()


def find_user_path(path: str, except_names: Sequence[str] = ()) -> str:
    """Return the first existing file that a relative path may mean, else the path as given.

    except_names: names that are not paths, even where a file has the same name.
    """
    if path in except_names:
        return path
    candidates = (os.path.join(folder, os.path.expanduser(path)) for folder in user_folders())
    return next(filter(os.path.isfile, candidates), path)


def find_in(folder: str) -> FindFile:
    """Return a function that finds file:// URIs, absolute paths, and paths relative to `folder`.
    """
    def find(uri: str) -> Optional[str]:
        if '://' in uri and not uri.startswith('file://'):
            return None
        path = os.path.join(folder, uri[len('file://'):] if uri.startswith('file://') else uri)
        return path if os.path.isfile(path) else None
    return find


def output_paths(source: str, output: str, extensions: Sequence[str]) -> Tuple[str, ...]:
    """Return the paths of the files that are made from the file `source`.

    output: a folder, the beginning of the paths, or empty for the current folder.
    Raises UserError when there is no such folder, or a path is that of the source itself.
    """
    stem = os.path.splitext(os.path.basename(source))[0] + '.replay'
    prefix = os.path.join(output, stem) if os.path.isdir(output or '.') else output
    if prefix.endswith(os.sep):
        raise UserError('cannot write to {}: no such folder; make it, or set --output to '
                        'another'.format(output))
    paths = tuple(prefix + extension for extension in extensions)
    for path in paths:
        if os.path.exists(path) and os.path.samefile(path, source):
            raise UserError('cannot write {}: that is what is replayed; set --output to another'
                            .format(path))
    return paths


@contextlib.contextmanager
def atomic_write(paths: Sequence[str],
                 advice: str = 'set --output to a folder or the beginning of a path where files '
                 'can be written') -> Iterator[list]:
    """Give binary files to write to, which take the place of `paths` if all goes well.

    If anything goes wrong, what was there before stays; links stay, and devices are never
    replaced. Raises UserError naming the path that cannot be written, with the advice.
    """
    for path in paths:
        if os.path.exists(path) and not os.path.isfile(path):
            raise UserError('cannot write {}: it is a {}; {}'.format(
                path, 'folder' if os.path.isdir(path) else 'device or pipe', advice))
    targets = [os.path.realpath(path) for path in paths]
    parts = [os.path.join(os.path.dirname(target), '.{}.{}'.format(os.path.basename(target),
                                                                   os.getpid()))
             for target in targets]
    files = []
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
        for part in parts:      # one more than in `files`, if a signal came in between
            with contextlib.suppress(OSError):
                os.remove(part)


@contextlib.contextmanager
def _refusal(path: str, advice: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UserError('cannot write {}: {}; {}'.format(
            path, (error.strerror or str(error)).lower(), advice))
