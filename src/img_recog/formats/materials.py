"""The colors and textures of SDF visuals: Gazebo's named materials, and Ogre's scripts."""
import xml.etree.ElementTree as ElementTree
from typing import Optional, Sequence, Tuple

from img_recog.files import FindFile
from img_recog.formats import gazebo_materials, material_scripts
from img_recog.formats.numbers import read_number, read_numbers
from img_recog.formats.texts import name_of
from img_recog.model import Color, Material

_AMBIENT_LIGHT = 0.4                    # of all light, in Gazebo's usual <scene>
_DEFAULT = '__default__'                # SDF's own word for no script
_SCRIPTS = 'file://media/materials/scripts'     # where Gazebo looks for what names no file


def of_sdf(visual: ElementTree.Element, find: FindFile) -> Tuple[Optional[Material], str]:
    """Return the material of an SDF <visual>, and what of it was not found, or ''.

    None if it has neither a color nor a script that is found: then that of a mesh file counts,
    like in Gazebo. Colors count in addition to a script: they replace its colors.
    find: returns the path of the file or folder at a URI.
    """
    material, missing = _scripted(visual, find)
    ambient, diffuse = _given_color(visual, 'ambient'), _given_color(visual, 'diffuse')
    if material is not None:
        is_plain = not material.texture
        if diffuse is not None:
            material = material._replace(color=diffuse if is_plain else _product(
                material.color, diffuse))
        elif ambient is not None and is_plain:
            material = material._replace(color=_lit(ambient, material.color))
    elif ambient is not None or diffuse is not None:
        material = Material(diffuse or ambient or Material().color)
    if material is not None:
        material = material._replace(
            color=(*material.color[:3], material.color[3] * opacity(visual)))
    return material, missing


def opacity(visual: ElementTree.Element) -> float:
    """Return the opacity that the <transparency> of an SDF <visual> leaves."""
    transparency = read_number('<transparency> of visual ' + name_of(visual),
                               visual.findtext('transparency', '0'))
    return min(max(1.0 - transparency, 0.0), 1.0)


def _given_color(visual: ElementTree.Element, tag: str) -> Optional[Color]:
    text = visual.findtext('material/' + tag)
    return None if text is None else _color(read_numbers(
        '<{}> of visual {}'.format(tag, name_of(visual)), _four(text), 4).tolist())


def _product(first: Color, second: Color) -> Color:
    return _color([one * other for one, other in zip(first, second)])


def _lit(ambient: Color, diffuse: Color) -> Color:
    """Return the color that both colors of a material give together."""
    return _color([_AMBIENT_LIGHT * one + (1 - _AMBIENT_LIGHT) * other
                   for one, other in zip(ambient[:3], diffuse[:3])] + [diffuse[3]])


def of_script(name: str, uris: Sequence[str], find: FindFile) -> Tuple[Optional[Material], str]:
    """Return the material that a <script> names, and what was not found or ''.

    uris: of the folders and files of scripts; none where Gazebo's own are meant.
    """
    if name in ('', _DEFAULT):
        return None, ''
    material = gazebo_materials.named(name)     # of a file that is a part of Gazebo
    if material is not None:
        return material, ''
    paths = [path for path in map(find, uris or [_SCRIPTS]) if path is not None]
    return material_scripts.find(name, paths) or (None, 'material ' + name)


def _scripted(visual: ElementTree.Element, find: FindFile) -> Tuple[Optional[Material], str]:
    script = visual.find('material/script')
    if script is None:
        return None, ''
    return of_script((script.findtext('name') or script.text or '').strip(),
                     [uri.text.strip() for uri in script.findall('uri') if uri.text], find)


def _four(text: str) -> str:
    """Return the numbers of a color with an opacity, which SDF may omit."""
    return text + ' 1' if len(text.split()) == 3 else text


def _color(values: Sequence[float]) -> Color:
    red, green, blue, alpha = [*values, 1.0][:4]
    return float(red), float(green), float(blue), float(alpha)
