"""The mesh files of a URDF or SDF."""
import copy
import os
import xml.etree.ElementTree as ElementTree
from typing import List

from img_recog.files import FindFile

_READABLE = ('.dae', '.obj', '.stl')        # by PyBullet


def resolve(root: ElementTree.Element, find: FindFile) -> List[str]:
    """Write absolute paths into all meshes under `root`; return the URIs that lead nowhere.

    A shape whose mesh is missing is left out; where that leaves a link with nothing to be seen
    (or to be touched), it gets its collision (or visual) shapes instead.
    """
    missing = []
    for link in root.iter('link'):
        lost = {kind: _resolve_shapes(link, kind, find, missing)
                for kind in ('visual', 'collision')}
        for kind, other in (('visual', 'collision'), ('collision', 'visual')):
            if lost[kind] and link.find(kind) is None:
                _stand_in(link, kind, link.findall(other), lost[kind][0])
    return missing


def _resolve_shapes(link, kind: str, find: FindFile, missing: List[str]) -> list:
    lost = []
    for shape in link.findall(kind):
        mesh = shape.find('geometry/mesh')
        if mesh is None:
            continue
        uri = mesh.get('filename') or mesh.findtext('uri', '').strip()     # of URDF, of SDF
        path = find(uri)
        if path is None or not path.lower().endswith(_READABLE):
            lost.append(shape)
            link.remove(shape)
            if uri not in missing:
                missing.append(uri)
        elif mesh.get('filename') is not None:
            mesh.set('filename', os.path.abspath(path))
        else:
            mesh.find('uri').text = os.path.abspath(path)
    return lost


def _stand_in(link, kind: str, shapes: list, lost: ElementTree.Element) -> None:
    material = lost.find('material')
    for number, shape in enumerate(shapes):
        double = ElementTree.SubElement(link, kind, name='stand_in_{}'.format(number))
        for tag in ('origin', 'pose', 'geometry'):
            double.extend(copy.deepcopy(shape.findall(tag)))
        if kind == 'visual' and material is not None:
            double.append(material)


def described(missing: List[str]) -> str:
    """Return one line about meshes that are missing."""
    return ('mesh{} not found, other shapes of the link stand in: {}; PyBullet reads {} files, '
            'and package:// needs the package to be built and sourced'.format(
                '' if len(missing) == 1 else 'es', ', '.join(missing), ', '.join(_READABLE)))
