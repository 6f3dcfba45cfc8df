"""The materials of SDF visuals: colors, Gazebo's named materials, and Ogre's scripts."""
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.files import FindFile, plain
from img_recog.formats.reader import text_of, value
from img_recog.formats.still_images import pillow
from img_recog.model import WHITE, Color, Material, Rgb
from img_recog.report import NOT_FOUND, Report

_MAX_SIZE_PX = 4096
# 8192x16384; each takes 3 bytes while it is reduced. Images of a camera have max_image_pixels
_MAX_PIXELS = 1 << 27
_PREFIX = 'Gazebo/'
_SIGN = 'drc/san_fauxcity_sign'         # the only one of that file with another prefix
_DIM = (0.1, 0.1, 0.1)
# colors, which ambient and directed light share; of the highlight; its exponent
_PLAIN: Dict[str, Tuple[Sequence[float], float, float]] = {
    'Black': ((0, 0, 0), 0.1, 5), 'Blue': ((0, 0, 1), 0.1, 1),
    'DarkGrey': ((0.175, 0.175, 0.175), 0.175, 1.5), 'DarkYellow': ((0.7, 0.7, 0), 0, 0),
    'Editor': ((1, 1, 1), 0.1, 128), 'FlatBlack': (_DIM, 0.01, 1), 'Green': ((0, 1, 0), 0.1, 1),
    'Indigo': ((0.33, 0, 0.5), 0.1, 1), 'Orange': ((1, 0.5088, 0.0468), 0.5, 128),
    'PioneerBody': ((0.884, 0, 0), 0, 0), 'Purple': ((1, 0, 1), 0.1, 1),
    'Red': ((1, 0, 0), 0.1, 1), 'Turquoise': ((0, 1, 1), 0.1, 1), 'White': ((1, 1, 1), 0.1, 128),
    'Yellow': ((1, 1, 0), 0, 0), 'TurquoiseGlowOutline': ((0, 1, 1), 0.1, 128),
    'BlackTransparent': ((0, 0, 0, 0.5), 0, 0), 'BlueLaser': ((0, 0, 1, 0.4), 0, 0),
    'BlueTransparent': ((0, 0, 1, 0.5), 0, 0), 'GreenTransparent': ((0, 1, 0, 0.5), 0, 0),
    'DarkMagentaTransparent': ((0.6, 0, 0.6, 0.5), 0, 0),
    'GreyTransparent': ((0.5, 0.5, 0.5, 0.5), 0, 0),
    'LightBlueLaser': ((0.5, 0.5, 1, 0.4), 0, 0), 'OrangeTransparent': ((1, 0.44, 0, 0.4), 0, 0),
    'YellowTransparent': ((1, 1, 0, 0.5), 0, 0)}
# what is the same in any light, or with a light of its own
_BRIGHT: Dict[str, Sequence[float]] = {
    'BlueGlow': (0, 0, 1), 'BlueTransparentOverlay': (0, 0, 1, 0.5),
    'CloudySky': (0.678, 0.736, 0.994), 'DarkOrangeTransparentOverlay': (0.6, 0.305, 0.028, 0.8),
    'GreenGlow': (0, 1, 0), 'GreenTransparentOverlay': (0, 1, 0, 0.5),
    'GreyGradientSky': (0.6, 0.6, 0.6), 'JointAnchor': (1, 1, 1), 'LightOff': (1, 0, 0),
    'LightOn': (0, 1, 0), 'OrangeTransparentOverlay': (1, 0.5088, 0.0468, 0.8),
    'PointHandle': (1, 1, 1), 'PurpleGlow': (1, 0, 1), 'RedGlow': (1, 0, 0),
    'RedTransparent': (1, 0, 0, 0.5), 'RedTransparentOverlay': (1, 0, 0, 0.5),
    'TurquoiseGlow': (0, 1, 1), 'WhiteGlow': (1, 1, 1), 'YellowGlow': (1, 1, 0)}
# of the others that glow, the glow is added to white
_WHITE_BELOW = ('BlueGlow', 'GreenGlow', 'PurpleGlow', 'TurquoiseGlow', 'YellowGlow')
_GREY = Material((0.7, 0.7, 0.7, 1.0), ambient=(0.3, 0.3, 0.3), specular=(0.01, 0.01, 0.01),
                 shininess=1.5)
_OTHERS: Dict[str, Material] = {
    'EditorPlane': _GREY, 'Grey': _GREY,
    'Gold': Material((0.8, 0.649, 0.121, 1.0), ambient=(0.4, 0.249, 0.021),
                     specular=(0.4, 0.4, 0.4), shininess=12.5),
    'Pioneer2Body': Material((0.681, 0.001, 0.001, 1.0), ambient=(0.481, 0.0, 0.0),
                             specular=(0.5, 0.5, 0.5), shininess=12.5),
    'RedBright': Material((0.87, 0.26, 0.07, 1.0), specular=(0.87, 0.26, 0.07), shininess=1.0),
    'SkyBlue': Material((0.0, 0.0, 1.0, 1.0), ambient=(0.13, 0.44, 0.7), specular=_DIM,
                        shininess=1.0),
    'ZincYellow': Material((0.9725, 0.9529, 0.2078, 1.0), specular=(0.9725, 0.9529, 0.2078),
                           shininess=1.0)}
# The mean color of a texture, which is not a part of this package; the shares of ambient and of
# directed light that it sends; of the highlight; its exponent
_LANES_1, _LANES_2 = (0.483, 0.457, 0.418), (0.412, 0.411, 0.404)
_LANES_4, _LANES_6 = (0.486, 0.459, 0.419), (0.411, 0.406, 0.396)
_HOUSES, _PAVING = (0.476, 0.452, 0.424), (0.583, 0.582, 0.53)
_ROADS: Dict[str, Rgb] = {
    'Footway': _PAVING, 'Lane_1': _LANES_1, 'Lanes_2': _LANES_2, 'Lanes_4': _LANES_4,
    'Lanes_6': _LANES_6, 'Motorway': _LANES_6, 'Pedestrian': _PAVING, 'Primary': _LANES_2,
    'Residential': _HOUSES, 'Road': _LANES_2, 'Secondary': _LANES_1, 'Steps': (0.47, 0.47, 0.47),
    'Tertiary': _HOUSES, 'Trunk': _LANES_4}
_TEXTURED: Dict[str, Tuple[Rgb, float, float, float, float]] = {
    **{name: (mean, 0.1, 0.8, 0.01, 2.0) for name, mean in _ROADS.items()},
    'Bricks': ((0.562, 0.378, 0.37), 1.0, 1.0, 0.2, 12.5),
    'BuildingFrame': ((0.64, 0.64, 0.64), 1.0, 1.0, 0.2, 12.5),
    'CeilingTiled': ((0.918, 0.918, 0.918), 0.5, 1.0, 0.0, 0.0),
    'CoM': ((0.5, 0.5, 0.5), 0.5, 1.0, 0.0, 0.0),
    'Grass': ((0.246, 0.48, 0.053), 0.5, 1.0, 0.0, 0.0),
    'PaintedWall': ((0.898, 0.772, 0.463), 1.0, 1.0, 0.0, 0.0),
    'Runway': ((0.403, 0.403, 0.388), 0.5, 1.0, 0.0, 0.0),
    'Wood': ((0.763, 0.506, 0.266), 1.0, 1.0, 0.2, 12.5),
    'WoodFloor': ((0.54, 0.25, 0.05), 0.5, 1.0, 0.0, 0.0),
    'WoodPallet': ((0.542, 0.383, 0.184), 0.5, 1.0, 0.0, 0.5)}
_SAME = {'Gray': 'Grey', 'DarkGray': 'DarkGrey'}
# those for the passes of its own renderer, on nothing that is seen
_INTERNAL = ('CameraDistortionMap', 'CameraLensFlare', 'DepthMap', 'GaussianCameraNoise',
             'LaserScan1st', 'LaserScan2nd', 'PointCloud', 'Reflectance', 'WideLensMap',
             'XYZNormals', 'XYZPoints')
_MAX_BYTES = 1 << 20
_MAX_PARENTS = 10
_COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/', re.DOTALL)
_HEAD = re.compile(
    r'^[ \t]*(?:abstract\s+)?material\s+("[^"]+"|[^\s{:]+)\s*(?::\s*([^\s{]+)\s*)?{',
    re.MULTILINE)
_CUTOUT = r'\balpha_rejection\s+(?!always_pass)|\bscene_blend\s+alpha_blend'
# what a shader gets as images besides colors, by the names that are usual for them
_NO_COLORS = re.compile(r'normal|bump|height|cube|environment|reflect|specular',
                        re.IGNORECASE)
_WHITE = (1.0, 1.0, 1.0)
_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
_NUMBERS = r'\b{}((?:\s+' + _NUMBER + r'){{{}}}(?:\s+' + _NUMBER + r')?)(?=[\s}}])'
_DEFAULT = '__default__'                # SDF's own word for no script
_SCRIPTS = 'file://media/materials/scripts'     # where Gazebo looks for what names no file
_DARK: Rgb = (0.0, 0.0, 0.0)


class TextureError(UserError):
    """A texture cannot be read."""


def read_texture(path: str, mode: str = 'RGB') -> np.ndarray:
    """Return the image of a file, (rows, columns, channels); mode: RGB or RGBA.

    An image with a side of more than 4096 pixels is reduced. Raises TextureError naming the file.
    """
    try:
        with open(path, 'rb', opener=plain) as file, pillow().open(file) as image:
            if image.width * image.height > _MAX_PIXELS:
                raise ValueError('{}x{} pixels are more than {}'.format(
                    image.width, image.height, _MAX_PIXELS))
            image.thumbnail((_MAX_SIZE_PX, _MAX_SIZE_PX))
            return np.asarray(image.convert(mode))      # which does not copy it once more
    except Exception as error:      # Pillow raises errors of many types
        raise TextureError('cannot read the texture {}: {}'.format(path, one_line(error)),
                           'give a PNG or JPEG file')


def gazebo_material(name: str) -> Optional[Material]:
    """Return the material that Gazebo gives that name, like Gazebo/Blue; None if it has none.

    >>> gazebo_material('Gazebo/Gold').ambient, gazebo_material('Gazebo/Plaid')
    ((0.4, 0.249, 0.021), None)
    """
    if name == _SIGN:
        return Material((0.05, 0.35, 0.2, 1.0), specular=_DIM, shininess=2.0)
    if not name.startswith(_PREFIX):
        return None
    name = name[len(_PREFIX):]
    name = _SAME.get(name, name)
    if name in _PLAIN:
        color, specular, shininess = _PLAIN[name]
        return Material(_color(color), specular=(specular,) * 3, shininess=shininess)
    if name in _BRIGHT:
        red, green, blue, opacity = _color(_BRIGHT[name])
        color = (1.0, 1.0, 1.0) if name in _WHITE_BELOW else (0.0, 0.0, 0.0)
        return Material((*color, opacity), emissive=(red, green, blue))
    if name in _TEXTURED:
        mean, ambient, diffuse, specular, shininess = _TEXTURED[name]
        red, green, blue = (diffuse * value for value in mean)
        return Material((red, green, blue, 1.0), specular=(specular,) * 3, shininess=shininess,
                        ambient=(ambient * mean[0], ambient * mean[1], ambient * mean[2]))
    return WHITE if name in _INTERNAL else _OTHERS.get(name)


def _color(values: Sequence[float]) -> Color:
    red, green, blue, opacity = (float(value) for value in [*values, 1.0][:4])
    return red, green, blue, opacity


class _Script(NamedTuple):
    """A material of a script; parent: its name, '' for none."""

    parent: str
    block: str


def find_in_scripts(name: str, folders: Sequence[str]) -> Optional[Tuple[Material, str]]:
    """Return the material of that name, and its texture if that is not found or ''.

    folders: of scripts and textures, or the paths of scripts. None if there is no such material.
    """
    scripts: Dict[str, _Script] = {}
    for path in folders:
        for text in _texts(path):
            for each, script in _materials(text):
                scripts.setdefault(each, script)
    blocks: List[str] = []
    while name in scripts and len(blocks) < _MAX_PARENTS:
        blocks.append(scripts[name].block)
        name = scripts[name].parent
    return _material(blocks, folders) if blocks else None


def _texts(path: str) -> Iterator[str]:
    """Yield the texts of a script or of those in a folder."""
    paths = [path]
    if os.path.isdir(path):
        paths = sorted(os.path.join(path, name) for name in os.listdir(path)
                       if name.endswith('.material'))
    for each in paths:
        try:
            if os.path.isfile(each) and os.path.getsize(each) <= _MAX_BYTES:
                with open(each, errors='replace', opener=plain) as file:
                    yield _COMMENT.sub('', file.read())
        except OSError:     # it counts as not found
            pass


def _materials(text: str) -> Iterator[Tuple[str, _Script]]:
    heads = list(_HEAD.finditer(text))
    for head, following in zip(heads, [*(each.start() for each in heads[1:]), len(text)]):
        yield head.group(1).strip('"'), _Script(head.group(2) or '', text[head.end():following])


def _material(blocks: Sequence[str], folders: Sequence[str]) -> Tuple[Material, str]:
    """Return what a script states, blocks: its own and those of its parents."""
    diffuse, ambient, emissive = (_numbers(key, 3, blocks)
                                  for key in ('diffuse', 'ambient', 'emissive'))
    red, green, blue, opacity = [*(diffuse or _WHITE), 1.0][:4]
    if _first(r'\blighting\s+off\b', blocks):      # it is as it is
        red = green = blue = 0.0
        ambient, emissive = (0.0, 0.0, 0.0), _WHITE
    # the last of three to five numbers is the exponent
    *specular, shininess = _numbers('specular', 4, blocks) or (0.0, 0.0, 0.0, 0.0)
    texture = next((found for block in blocks for found in map(_color_texture, _units(block))
                    if found), '')
    width, height = [*(_numbers('scale', 1, blocks) if texture else ()), 1.0, 1.0][:2]
    material = Material((red, green, blue, opacity), '', (width or 1.0, height or 1.0),
                        _first(_CUTOUT, blocks) is not None, _rgb(ambient or _WHITE),
                        _rgb(specular), shininess, _rgb(emissive or (0.0, 0.0, 0.0)))
    if not texture:
        return material, ''
    path = _texture(texture, folders)
    return material._replace(texture=path), '' if path else 'texture ' + texture


def _rgb(values: Sequence[float]) -> Rgb:
    red, green, blue = values[:3]
    return red, green, blue


def _units(block: str) -> Iterator[str]:
    """Yield the name and the content of each texture_unit."""
    for unit in re.finditer(r'\btexture_unit\b([^{]*{[^}]*)', block):
        yield unit.group(1)


def _color_texture(unit: str) -> str:
    """Return the image of a texture_unit, '' if it has none or one that is not of colors."""
    found = re.search(r'\btexture\s+(?:"([^"\n]+)"|(\S+))', unit)
    return '' if found is None or _NO_COLORS.search(unit) else found.group(1) or found.group(2)


def _first(pattern: str, blocks: Sequence[str]) -> 'Optional[re.Match[str]]':
    return next((found for found in (re.search(pattern, block) for block in blocks) if found),
                None)


def _numbers(key: str, count: int, blocks: Sequence[str]) -> Sequence[float]:
    """Return so many numbers of a property, or one more; () without it."""
    found = _first(_NUMBERS.format(key, count), blocks)
    return [float(word) for word in found.group(1).split()] if found else ()


def _texture(name: str, folders: Sequence[str]) -> str:
    """Return the path of a texture, '' if it is in none of the folders, nor in their textures."""
    for folder in folders:
        base = folder if os.path.isdir(folder) else os.path.dirname(folder)
        for path in (os.path.join(base, name),
                     os.path.join(os.path.dirname(base), 'textures', name)):
            if os.path.isfile(path):
                return os.path.abspath(path)
    return ''


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
    material = gazebo_material(name)     # of a file that is a part of Gazebo
    if material is not None:
        return material
    paths = [path for path in map(find, uris or [_SCRIPTS]) if path is not None]
    found, missing = find_in_scripts(name, paths) or (None, 'material ' + name)
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
