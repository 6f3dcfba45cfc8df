"""The mesh files of a URDF or SDF."""
import copy
import os
import xml.etree.ElementTree as ElementTree
from typing import List, Optional, Sequence

from img_recog.files import FindFile
from img_recog.mesh_file import READABLE
from img_recog.simulation.descriptions.texts import text_of


def resolve(root: ElementTree.Element, find: FindFile) -> List[str]:
    """Write absolute paths into all meshes under `root`; return the URIs that were not found.

    A shape whose mesh is missing is removed. A link that has no visual (or collision) shape left
    because of that gets copies of its collision (or visual) shapes instead.
    """
    missing: List[str] = []
    for link in root.iter('link'):
        removed = {kind: _resolve_shapes(link, kind, find, missing)
                   for kind in ('visual', 'collision')}
        for kind, other in (('visual', 'collision'), ('collision', 'visual')):
            if removed[kind] and link.find(kind) is None:
                add_replacements(link, kind, link.findall(other),
                                 removed[kind][0].find('material'))
    return missing


def _resolve_shapes(link: ElementTree.Element, kind: str, find: FindFile,
                    missing: List[str]) -> List[ElementTree.Element]:
    """Resolve the meshes of one kind of shapes; return the shapes that were removed."""
    removed = []
    for shape in link.findall(kind):
        mesh = shape.find('geometry/mesh')
        if mesh is None:
            continue
        sdf_uri = mesh.find('uri')
        uri = mesh.get('filename') or text_of(mesh, 'uri')
        path = find(uri)
        if path is None or not path.lower().endswith(READABLE):
            removed.append(shape)
            link.remove(shape)
            if uri not in missing:
                missing.append(uri)
        elif mesh.get('filename') is not None or sdf_uri is None:
            mesh.set('filename', os.path.abspath(path))
        else:
            sdf_uri.text = os.path.abspath(path)
    return removed


def add_replacements(link: ElementTree.Element, kind: str, shapes: Sequence[ElementTree.Element],
                     material: Optional[ElementTree.Element] = None) -> None:
    """Add copies of shapes of a URDF's link as shapes of another kind; material: of visuals."""
    for number, shape in enumerate(shapes):
        added = ElementTree.SubElement(link, kind, name='replacement_{}'.format(number))
        for tag in ('origin', 'pose', 'geometry'):
            added.extend(copy.deepcopy(shape.findall(tag)))
        if kind == 'visual' and material is not None:
            added.append(material)


def warning_about(missing: Sequence[str]) -> str:
    """Return one line about meshes that were not found."""
    return ('mesh{} not found, replaced by other shapes of the link: {}; PyBullet reads {} files; '
            'for package:// the package must be built and sourced'.format(
                '' if len(missing) == 1 else 'es', ', '.join(missing), ', '.join(READABLE)))
