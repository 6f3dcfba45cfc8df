"""The materials of SDF visuals: colors, Gazebo's named materials, and Ogre's scripts."""
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from img_recog.files import FindFile, plain
from img_recog.formats import gazebo_materials
from img_recog.formats.reader import text_of, value
from img_recog.model import Color, Material, Rgb
from img_recog.report import NOT_FOUND, Report

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
    material = gazebo_materials.named(name)     # of a file that is a part of Gazebo
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
