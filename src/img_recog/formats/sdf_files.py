"""Finds and reads the files that an SDF file refers to."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Callable, Optional

from img_recog.errors import SimulationError
from img_recog.files import FindFile, plain
from img_recog.formats import sdf_versions
from img_recog.formats.markup import MarkupError, parse_xml, read_bytes


def find_relative(folder: str, find: FindFile) -> Callable[[str], Optional[str]]:
    """Return a function that finds files and folders: a relative path in `folder` first."""
    def found(uri: str) -> Optional[str]:
        path = uri[len('file://'):] if uri.startswith('file://') else uri
        joined = os.path.join(folder, path)
        return joined if path and '://' not in path and os.path.exists(joined) else find(uri)
    return found


def find_above(folder: str, path: str) -> Optional[str]:
    """Return where a model's path is: in a folder above, or in `models` in one."""
    while True:
        for candidate in (os.path.join(folder, path), os.path.join(folder, 'models', path)):
            if os.path.exists(candidate):
                return candidate
        parent = os.path.dirname(folder)
        if parent == folder:
            return None
        folder = parent


def model_file(path: str) -> Optional[str]:
    """Return the SDF file of a model: of a folder, that of the newest version in model.config."""
    if os.path.isfile(path):
        return os.path.abspath(path)
    names = ['model.sdf']
    config = os.path.join(path, 'model.config')
    if os.path.isfile(config):
        found = [(sdf_versions.version_of(sdf), (sdf.text or '').strip())
                 for sdf in parsed(config, 'model').findall('sdf')]
        names = [name for _, name in sorted(found, reverse=True) if name] + names
    paths = (os.path.join(path, name) for name in names)
    return next((os.path.abspath(each) for each in paths if os.path.isfile(each)), None)


def parsed(path: str, tag: str = 'sdf') -> ElementTree.Element:
    """Return the root element of a file; raise SimulationError if its tag is not `tag`."""
    try:
        root = parse_xml(read_bytes(path, opener=plain))
    except (OSError, ValueError) as error:
        raise SimulationError('cannot read {} ({})'.format(path, error))
    except MarkupError as error:
        raise SimulationError('cannot use {} ({})'.format(path, error.problem), error.advice)
    if root.tag != tag:
        raise SimulationError('the root element of {} is <{}>, not <{}>'.format(
            path, root.tag, tag))
    sdf_versions.unify(root)
    return root
