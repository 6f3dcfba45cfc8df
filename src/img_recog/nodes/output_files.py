"""Files that are there whole or not at all."""
import contextlib
import os
from typing import Iterator, Sequence, Tuple

from img_recog.errors import UserError


def names(source: str, output: str, extensions: Sequence[str]) -> Tuple[str, ...]:
    """Return the paths of the files that are made of a file.

    output: the folder for them, the beginning of their paths, or nothing for the current folder.
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
def written(paths: Sequence[str], advice: str = 'set --output to a folder or the beginning of a '
            'path where files can be written') -> Iterator[list]:
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
