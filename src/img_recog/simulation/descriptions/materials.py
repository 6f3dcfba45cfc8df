"""The colors and textures of SDF visuals: Gazebo's named materials, and Ogre's scripts."""
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, Optional, Sequence, Tuple

from img_recog.files import FindFile
from img_recog.simulation.descriptions.numbers import read_number, read_numbers
from img_recog.visuals import GREY, Color, Material

_AMBIENT_LIGHT = 0.4                    # of all light, in Gazebo's usual <scene>
_MAX_SCRIPT_BYTES = 1 << 20
_GAZEBO = 'Gazebo/'
_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
# diffuse colors of gazebo.material of Gazebo 11
_NAMED: Dict[str, Sequence[float]] = {
    'Black': (0, 0, 0), 'Blue': (0, 0, 1), 'BlueGlow': (0, 0, 1), 'BlueLaser': (0, 0, 1, 0.4),
    'BlueTransparent': (0, 0, 1, 0.5), 'BlueTransparentOverlay': (0, 0, 1, 0.5),
    'DarkGray': (0.175, 0.175, 0.175), 'DarkGrey': (0.175, 0.175, 0.175),
    'DarkYellow': (0.7, 0.7, 0), 'FlatBlack': (0.1, 0.1, 0.1), 'Gold': (0.8, 0.649, 0.121),
    'Gray': (0.7, 0.7, 0.7), 'Green': (0, 1, 0), 'GreenGlow': (0, 1, 0),
    'GreenTransparent': (0, 1, 0, 0.5), 'GreenTransparentOverlay': (0, 1, 0, 0.5),
    'Grey': (0.7, 0.7, 0.7), 'GreyTransparent': (0.5, 0.5, 0.5, 0.5), 'Indigo': (0.33, 0, 0.5),
    'LightOff': (1, 0, 0), 'LightOn': (0, 1, 0), 'Orange': (1, 0.5088, 0.0468),
    'OrangeTransparent': (1, 0.44, 0, 0.4), 'Pioneer2Body': (0.681, 0.001, 0.001),
    'PioneerBody': (1, 0, 0), 'Purple': (1, 0, 1), 'PurpleGlow': (1, 0, 1), 'Red': (1, 0, 0),
    'RedBright': (0.87, 0.26, 0.07), 'RedGlow': (1, 0, 0), 'RedTransparent': (1, 0, 0, 0.5),
    'RedTransparentOverlay': (1, 0, 0, 0.5), 'SkyBlue': (0.13, 0.44, 0.7),
    'Turquoise': (0, 1, 1), 'TurquoiseGlow': (0, 1, 1), 'White': (1, 1, 1),
    'WhiteGlow': (1, 1, 1), 'Yellow': (1, 1, 0), 'YellowGlow': (1, 1, 0),
    'YellowTransparent': (1, 1, 0, 0.5), 'ZincYellow': (0.9725, 0.9529, 0.2078)}
# the mean color of the texture that Gazebo has for it
_TEXTURED: Dict[str, Sequence[float]] = {
    'Bricks': (0.56, 0.38, 0.37), 'Wood': (0.74, 0.65, 0.64), 'WoodPallet': (0.54, 0.38, 0.18)}


def named(name: str) -> Optional[Material]:
    """Return the material that Gazebo gives that name, like Gazebo/Blue; None if it has none.

    One with a texture has the mean color of that instead.
    """
    if not name.startswith(_GAZEBO):
        return None
    color = {**_NAMED, **_TEXTURED}.get(name[len(_GAZEBO):])
    return None if color is None else Material(_color(color))


def is_given(visual: ElementTree.Element) -> bool:
    """Return whether an SDF <visual> has a material with a script or a color."""
    return bool(visual.findtext('material/script/name', '').strip()) or any(
        visual.find('material/' + tag) is not None for tag in ('ambient', 'diffuse'))


def of_sdf(visual: ElementTree.Element, find: FindFile) -> Tuple[Material, str]:
    """Return the material of an SDF <visual>, and what of it was not found or ''.

    Like in Gazebo, colors count in addition to a script: they replace its colors.
    find: returns the path of the file or folder at a URI.
    """
    script = visual.find('material/script')
    material, missing = Material(), ''
    ambient, diffuse = _given_color(visual, 'ambient'), _given_color(visual, 'diffuse')
    if script is not None and script.findtext('name', '').strip():
        material, missing = _scripted(script, find)
        name = script.findtext('name', '').strip()
        is_plain = not material.texture and name[len(_GAZEBO):] not in _TEXTURED
        if diffuse is not None:
            material = material._replace(color=diffuse if is_plain else _product(
                material.color, diffuse))
        elif ambient is not None and is_plain:
            material = material._replace(color=_lit(ambient, material.color))
    elif ambient is not None or diffuse is not None:
        material = Material(diffuse or ambient or GREY)
    transparency = read_number('<transparency> of visual ' + visual.get('name', ''),
                               visual.findtext('transparency', '0'))
    opacity = material.color[3] * min(max(1.0 - transparency, 0.0), 1.0)
    return material._replace(color=(*material.color[:3], opacity)), missing


def _given_color(visual: ElementTree.Element, tag: str) -> Optional[Color]:
    text = visual.findtext('material/' + tag)
    return None if text is None else _color(read_numbers(
        '<{}> of visual {}'.format(tag, visual.get('name', '')), _four(text), 4).tolist())


def _product(first: Color, second: Color) -> Color:
    return _color([one * other for one, other in zip(first, second)])


def _lit(ambient: Color, diffuse: Color) -> Color:
    """Return the color that both colors of a material give together."""
    return _color([_AMBIENT_LIGHT * one + (1 - _AMBIENT_LIGHT) * other
                   for one, other in zip(ambient[:3], diffuse[:3])] + [diffuse[3]])


def _scripted(script: ElementTree.Element, find: FindFile) -> Tuple[Material, str]:
    """Return the material that a <script> names, and what was not found or ''."""
    name = script.findtext('name', '').strip()
    material = named(name)      # of gazebo.material, which is a part of Gazebo
    if material is not None:
        return material, ''
    folders = [path for path in (find(uri.text.strip()) for uri in script.findall('uri')
                                 if uri.text) if path is not None]
    for path in folders:
        for text in _scripts(path):
            found = _from_script(text, name, folders)
            if found is not None:
                return found
    return Material(), 'material ' + name


def _scripts(path: str) -> Iterator[str]:
    """Return the texts of a material script or of those in a folder."""
    paths = [path]
    if os.path.isdir(path):
        paths = sorted(os.path.join(path, name) for name in os.listdir(path)
                       if name.endswith('.material'))
    for each in paths:
        try:
            if os.path.isfile(each) and os.path.getsize(each) <= _MAX_SCRIPT_BYTES:
                with open(each, errors='replace') as file:
                    yield file.read()
        except OSError:     # it counts as not found
            pass


def _from_script(text: str, name: str, folders: Sequence[str]
                 ) -> Optional[Tuple[Material, str]]:
    """Return the material `name` of an Ogre script, and its texture if that is not found or ''."""
    text = re.sub(r'//[^\n]*|/\*.*?\*/', '', text, flags=re.DOTALL)
    begin = re.search(r'^\s*material\s+"?{}"?\s*(?::[^{{]*)?{{'.format(re.escape(name)), text,
                      re.MULTILINE)
    if begin is None:
        return None
    end = re.search(r'^\s*material\s', text[begin.end():], re.MULTILINE)
    block = text[begin.end():begin.end() + end.start() if end else len(text)]
    texture = re.search(r'\btexture\s+(\S+)', block)
    color: Sequence[float] = (1.0, 1.0, 1.0) if texture else GREY
    diffuse = re.search(r'\bdiffuse((?:\s+{0}){{3}}(?:\s+{0})?)(?=[\s}}])'.format(_NUMBER), block)
    if diffuse:
        color = [float(word) for word in diffuse.group(1).split()]
    if texture is None:
        return Material(_color(color)), ''
    path = _texture(texture.group(1), folders)
    return Material(_color(color), path), '' if path else 'texture ' + texture.group(1)


def _texture(name: str, folders: Sequence[str]) -> str:
    """Return the path of a texture, '' if it is in none of the folders, nor in their textures."""
    for folder in folders:
        base = folder if os.path.isdir(folder) else os.path.dirname(folder)
        for path in (os.path.join(base, name),
                     os.path.join(os.path.dirname(base), 'textures', name)):
            if os.path.isfile(path):
                return os.path.abspath(path)
    return ''


def _four(text: str) -> str:
    """Return the numbers of a color with an opacity, which SDF may omit."""
    return text + ' 1' if len(text.split()) == 3 else text


def _color(values: Sequence[float]) -> Color:
    red, green, blue, opacity = [*values, 1.0][:4]
    return float(red), float(green), float(blue), float(opacity)
