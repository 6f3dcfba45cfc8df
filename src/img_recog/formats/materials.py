"""The materials of SDF visuals: colors, Gazebo's named materials, and Ogre's scripts."""
import xml.etree.ElementTree as ElementTree
from typing import Optional, Sequence

from img_recog.files import FindFile
from img_recog.formats import gazebo_materials, material_scripts
from img_recog.formats.reader import text_of, value
from img_recog.model import Color, Material, Rgb
from img_recog.report import NOT_FOUND, Report

_DEFAULT = '__default__'                # SDF's own word for no script
_SCRIPTS = 'file://media/materials/scripts'     # where Gazebo looks for what names no file
_DARK: Rgb = (0.0, 0.0, 0.0)


def of_sdf(visual: ElementTree.Element, find: FindFile, report: Report) -> Optional[Material]:
    """Return the material of an SDF <visual>.

    None if it has neither a color nor a script that is found: then that of a mesh file counts,
    like in Gazebo. Each color replaces that of a script.
    find: returns the path of the file or folder at a URI; report: gets a finding for a script that
    is not found.
    """
    material = _scripted(visual, find, report)
    colors = {tag: value(visual, 'material/' + tag)
              for tag in ('ambient', 'diffuse', 'specular', 'emissive')}
    if any(color is not None for color in colors.values()):
        material = _colored(material or Material(), **colors)
    if not value(visual, 'material/lighting'):      # it is as it is
        material = material or Material()
        material = material._replace(color=(*_DARK, material.color[3]), ambient=_DARK,
                                     specular=_DARK, emissive=(1.0, 1.0, 1.0))
    return material


def _colored(material: Material, ambient: Optional[Color], diffuse: Optional[Color],
             specular: Optional[Color], emissive: Optional[Color]) -> Material:
    """Return a material with other colors; None: its own."""
    return material._replace(
        color=diffuse or material.color,
        ambient=(ambient or material.ambient or material.color)[:3],
        specular=(specular or material.specular)[:3],
        emissive=(emissive or material.emissive)[:3])


def opacity(visual: ElementTree.Element) -> float:
    """Return the opacity that the <transparency> of an SDF <visual> leaves."""
    return min(max(1.0 - value(visual, 'transparency'), 0.0), 1.0)


def of_script(name: str, uris: Sequence[str], find: FindFile,
              report: Report) -> Optional[Material]:
    """Return the material that a <script> names, None if it is not found.

    uris: of the folders and files of scripts; none where Gazebo's own are meant. report: gets a
    finding if it is not found.
    """
    if name in ('', _DEFAULT):
        return None
    material = gazebo_materials.named(name)     # of a file that is a part of Gazebo
    if material is not None:
        return material
    paths = [path for path in map(find, uris or [_SCRIPTS]) if path is not None]
    found, missing = material_scripts.find(name, paths) or (None, 'material ' + name)
    if missing:
        report.add(NOT_FOUND, missing)
    return found


def _scripted(visual: ElementTree.Element, find: FindFile,
              report: Report) -> Optional[Material]:
    script = visual.find('material/script')
    if script is None:
        return None
    name, text = text_of(script, 'name'), (script.text or '').strip()
    if text and not name:       # Gazebo 11 does not look at it
        report.add(NOT_FOUND, 'material {} (its <script> has no <name>)'.format(text))
        return None
    return of_script(name, [uri.text.strip() for uri in script.findall('uri') if uri.text], find,
                     report)
