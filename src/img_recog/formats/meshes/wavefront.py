"""OBJ files of Wavefront, and their files of materials, in the form that trimesh reads whole."""
import contextlib
import os
import re
from typing import Dict, List, Optional

from img_recog.files import plain
from img_recog.formats.meshes.file_material import find_texture, number_color
from img_recog.formats.meshes.simplified import FilePart, Simplified
from img_recog.model import Material, Rgb

# lines of an OBJ that trimesh misreads: with a tab or a space first, or with an index up to 0
_UNUSUAL = re.compile(rb'^[ \t]|^[vf][nt]?\t|^f.*[ \t/](-|0([/\s]|$))', re.MULTILINE)
_LIBRARY = re.compile(rb'^[ \t]*mtllib[ \t]+(.*?)[ \t]*\r?$', re.MULTILINE)
_PART = re.compile(rb'^[ \t]*(o|g|usemtl)(?=\s)([^\r\n]*)', re.MULTILINE)
_CONTINUED = re.compile(rb'\\\r?\n')        # a line that goes on in the next one
_KINDS = ('v', 'vt', 'vn')      # what the indices of a corner of a face count
_MAX_BYTES = 1 << 24
_DARK = (0.0, 0.0, 0.0)
_BLACK = Material((*_DARK, 1.0), ambient=_DARK)      # what states no color
_OPTIONS = re.compile(r'(?:-[a-z]+(?:\s+(?:on|off|[-+.\d]+(?=\s)))*\s+)*', re.IGNORECASE)


def simplified(content: bytes, mesh: str) -> Simplified:
    """Return an OBJ without what trimesh misreads, and its parts; mesh: its path.

    The name of a part is that of the object or group before it, like in Gazebo.
    """
    materials: Dict[str, Material] = {}
    for name in libraries(content, mesh):
        materials.update(read_mtl(_text(name), mesh))
    numbers = {FilePart(): 0}
    part = FilePart()

    def use(line: 're.Match[bytes]') -> bytes:
        nonlocal part
        name = ' '.join(line.group(2).decode('utf-8', 'replace').split())
        part = (part._replace(material=materials.get(name)) if line.group(1) == b'usemtl'
                else part._replace(name=name))
        return b'usemtl %d' % numbers.setdefault(part, len(numbers))
    content = b'mtllib m\nusemtl 0\n' + _PART.sub(use, _CONTINUED.sub(b' ', content))
    if _UNUSUAL.search(content):
        content = _as_usual(content.decode('utf-8', 'replace')).encode()
    mtl = '\n'.join('newmtl {0}\nKd {1} {2} {3}'.format(number, *number_color(number))
                    for number in range(len(numbers)))
    return Simplified(content, list(numbers), mtl=mtl)


def libraries(content: bytes, mesh: str) -> List[str]:
    """Return the paths of the files of materials that an OBJ names; mesh: its path."""
    return [name for line in _LIBRARY.findall(content)
            for name in _library_names(line.decode('utf-8', 'replace'), mesh)]


def _library_names(line: str, mesh: str) -> List[str]:
    """Return the paths of the files of materials that a line names: one, or several."""
    folder = os.path.dirname(os.path.abspath(mesh))
    whole = os.path.join(folder, line)
    return [whole] if os.path.isfile(whole) else [
        os.path.join(folder, name) for name in line.split()]


def _text(path: str) -> str:
    """Return the content of a file of materials, '' if there is none, like in Gazebo."""
    try:
        with open(path, 'rb', opener=plain) as file:
            return file.read(_MAX_BYTES).decode('utf-8', 'replace')
    except OSError:
        return ''


def read_mtl(text: str, mesh: str) -> Dict[str, Material]:
    """Return the materials of an OBJ's material file by name; mesh: the path of the OBJ."""
    found: Dict[str, Material] = {}
    name: Optional[str] = None
    for line in text.splitlines():
        words = line.split(None, 1)
        if len(words) < 2:
            continue
        key, value = words[0].lower(), words[1].strip()
        if key == 'newmtl':
            name = ' '.join(value.split())
            found[name] = _BLACK
        elif name is not None:
            with contextlib.suppress(ValueError, IndexError):       # like Gazebo
                found[name] = _with_property(found[name], key, value, mesh)
    return found


def _with_property(material: Material, key: str, value: str, mesh: str) -> Material:
    """Return a material with a property of a material file; ValueError for a wrong number."""
    red, green, blue, opacity = material.color
    if key == 'd':
        opacity = float(value.split()[-1])
    elif key == 'tr':
        opacity = 1.0 - float(value.split()[-1])
    elif key == 'ns':
        return material._replace(shininess=float(value.split()[0]))
    elif key == 'map_kd':
        return material._replace(texture=find_texture(mesh, _OPTIONS.sub('', value, count=1)))
    elif key == 'kd':
        red, green, blue = _rgb(value, (red, green, blue))
    elif key == 'ka':
        return material._replace(ambient=_rgb(value, material.ambient or _DARK))
    elif key == 'ks':
        return material._replace(specular=_rgb(value, material.specular))
    elif key == 'ke':
        return material._replace(emissive=_rgb(value, material.emissive))
    return material._replace(color=(red, green, blue, min(max(opacity, 0.0), 1.0)))


def _rgb(value: str, default: Rgb) -> Rgb:
    """Return a color; default: in place of a spectral or CIEXYZ one, which are not in use."""
    if value[:1] in ('s', 'x'):
        return default
    red, green, blue = (float(word) for word in (value.split() * 3)[:3])
    return red, green, blue


def _as_usual(text: str) -> str:
    """Return an OBJ in which all lines begin with a word, and all indices count from the first."""
    counts = dict.fromkeys(_KINDS, 0)
    lines = []
    for line in text.splitlines():
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        if words and words[0] == 'f':
            words = ['f'] + ['/'.join(_absolute(index, counts[kind]) for kind, index in zip(
                _KINDS, corner.split('/'))) for corner in words[1:]]
        lines.append(' '.join(words))
    return '\n'.join(lines)


def _absolute(index: str, count: int) -> str:
    """Return an index that counts from 1; `index` may count backward from the last one, -1.

    >>> _absolute('-1', 8), _absolute('3', 8)
    ('8', '3')
    """
    number = int(index or 1)
    if not -count <= number or number == 0:
        raise ValueError('a face refers to vertex {} of {}, the first is 1'.format(number, count))
    return str(count + 1 + number) if number < 0 else index
