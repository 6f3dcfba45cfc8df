"""COLLADA files in the form that trimesh reads whole: each geometry once, in plain colors.

Of other files trimesh drops in silence: geometries whose material, effect or image is incomplete,
texture coordinates without a material, skins, and each mesh with a comment or with lines. The
scene and the materials are read as by ColladaLoader of Gazebo 11.
"""
import contextlib
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.formats.meshes.collada_geometry import count_triangles, simplify
from img_recog.formats.meshes.file_material import UNSTATED, UNSTATED_AMBIENT, number_color
from img_recog.formats.meshes.simplified import FilePart, Simplified
from img_recog.model import Material, Rgb

_SHADERS = 'lambert', 'phong', 'blinn', 'constant'
_LUMINANCE = 0.212671, 0.71516, 0.072169        # of ITU-R BT.709, as in the specification

# of a tag and the URL of an element
Get = Callable[[str, Optional[str]], Optional[ElementTree.Element]]
_NAMESPACE = 'http://www.collada.org/2005/11/COLLADASchema'
_MAX_NODES = 200_000        # that nodes refer to
_MAX_CONTROLLERS = 10                           # that refer to one another


def read_floats(text: Optional[str]) -> np.ndarray:
    """Return the numbers in the text of an element."""
    return np.array((text or '').split(), float)


class Materials:
    """The materials that are in use, each read once."""

    def __init__(self, get: Get, find_texture: Callable[[str], str]):
        """get: returns an element of the file; find_texture: the path of a texture by name."""
        self._get, self._find_texture = get, find_texture
        self._found: Dict[str, Optional[Material]] = {}

    def get(self, url: str) -> Optional[Material]:
        """Return the material at a URL, None if there is none."""
        if url not in self._found:
            element = self._get('material', url)
            self._found[url] = None if element is None else UNSTATED
            if element is not None:
                with contextlib.suppress(ValueError):       # of a number: it is grey
                    self._found[url] = self._read(element)
        return self._found[url]

    def _read(self, material: ElementTree.Element) -> Material:
        instance = material.find('instance_effect')
        effect = None if instance is None else self._get('effect', instance.get('url'))
        shaders = [] if effect is None else [
            shader for name in _SHADERS
            for shader in effect.findall('profile_COMMON/technique/' + name)]
        if effect is None or not shaders:
            return UNSTATED
        shader = shaders[0]
        glow = _color(shader, 'emission', (0.0, 0.0, 0.0))
        *rgb, opacity = [*_color(shader, 'diffuse', glow if shader.tag == 'constant' else
                                 UNSTATED.color), 1.0][:4]
        found = Material(
            (*_rgb(rgb), min(max(opacity, 0.0), 1.0) * _opacity(shader)),
            ambient=_rgb(_color(shader, 'ambient', UNSTATED_AMBIENT)),
            specular=_rgb(_color(shader, 'specular', (0.0, 0.0, 0.0))), emissive=_rgb(glow),
            shininess=float(shader.findtext('shininess/float') or 0))
        texture = shader.find('diffuse/texture')
        if texture is None:
            return found
        return found._replace(color=(1.0, 1.0, 1.0, found.color[3]), texture=self._find_texture(
            self._image(effect, texture.get('texture', ''))))

    def _image(self, effect: ElementTree.Element, name: str) -> str:
        """Return the file name of an image that an effect refers to, '' without one."""
        parameters = {each.get('sid', ''): each for each in effect.iter('newparam')}
        image = self._get('image', name)
        if name in parameters:
            source = parameters[name].findtext('sampler2D/source', '').strip()
            surface = parameters.get(source)
            url = None if surface is None else surface.findtext('surface/init_from')
            instance = parameters[name].find('sampler2D/instance_image')      # COLLADA 1.5
            image = self._get('image', url if instance is None else instance.get('url'))
        if image is None:
            return ''
        return image.findtext('init_from', '').strip() or image.findtext('init_from/ref', '')


def _color(shader: ElementTree.Element, tag: str, default: Sequence[float]) -> Sequence[float]:
    values = read_floats(shader.findtext(tag + '/color')).tolist()
    return default if len(values) < 3 else [*values, 1.0][:4]


def _rgb(values: Sequence[float]) -> Rgb:
    red, green, blue = (min(max(value, 0.0), 1.0) for value in values[:3])
    return red, green, blue


def _opacity(shader: ElementTree.Element) -> float:
    """Return the opacity of a material; like in Gazebo, it is 1 where no mode is stated."""
    transparent = shader.find('transparent')
    color = _color(shader, 'transparent', ())
    mode = '' if transparent is None else transparent.get('opaque', '')
    if not mode or not color:
        return 1.0
    amount = float(shader.findtext('transparency/float') or 1)
    amount *= color[3] if mode.startswith('A_') else float(np.dot(_LUMINANCE, color[:3]))
    return float(np.clip(amount if mode.endswith('_ONE') else 1 - amount, 0, 1))


class _Group(NamedTuple):
    """What the instances of a geometry have in common.

    name: of the node that they are in; bound: (symbol, URL) of their materials.
    """

    geometry: ElementTree.Element
    name: str
    bound: Tuple[Tuple[str, str], ...]


def simplified(content: bytes, find_texture: Callable[[str], str],
               max_triangles: int) -> Simplified:
    """Return a COLLADA file with what Gazebo draws of another one.

    find_texture: returns the path of a texture of that name. Raises an error of any type if it
    cannot be read, or has more than that many triangles.
    """
    if b'<!ENTITY' in content or b'\0' in content:
        # entities within entities make a small file large; expat limits them from 2.4.0 on
        raise ValueError('it has entities, or is not UTF-8')
    document = _Document(ElementTree.fromstring(content.lstrip(b'\xef\xbb\xbf \t\r\n')))
    groups: Dict[_Group, List[np.ndarray]] = {}
    counts: Dict[int, int] = {}
    total = 0
    for group, pose in document.shapes():
        key = id(group.geometry)
        if key not in counts:
            counts[key] = count_triangles(group.geometry)
        total += counts[key]
        if total > max_triangles:
            raise ValueError('it has more than {} triangles'.format(max_triangles))
        if np.isfinite(pose).all():
            groups.setdefault(group, []).append(pose)
    written, parts = _written(document.unit(), groups, Materials(document.get, find_texture))
    return Simplified(ElementTree.tostring(written), parts, total)


class _Document:
    """The elements of a COLLADA file, without their namespace."""

    def __init__(self, root: ElementTree.Element):
        self._root = root
        self._named: Dict[Tuple[str, str], ElementTree.Element] = {}
        for element in root.iter():
            element.tag = element.tag.rpartition('}')[2]
            for key in ('id', 'sid'):
                if key in element.attrib:
                    self._named.setdefault((element.tag, element.attrib[key]), element)

    def get(self, tag: str, url: Optional[str]) -> Optional[ElementTree.Element]:
        """Return the element that is named so, with or without #; None without one."""
        name = (url or '').strip()      # a name may contain # as well
        return self._named.get((tag, name[1:] if name.startswith('#') else name))

    def unit(self) -> str:
        """Return the length of the unit in m."""
        unit = self._root.find('asset/unit')
        return '1' if unit is None else unit.get('meter', '1')

    def shapes(self) -> Iterator[Tuple[_Group, np.ndarray]]:
        """Yield what the nodes of the scene show, and its pose (4, 4) in the scene."""
        instance = self._root.find('scene/instance_visual_scene')
        scene = None if instance is None else self.get('visual_scene', instance.get('url'))
        if scene is None:
            raise ValueError('it has no visual scene')
        waiting = [(node, np.eye(4), '') for node in reversed(scene.findall('node'))]
        transforms: Dict[ElementTree.Element, np.ndarray] = {}
        count = 0
        while waiting:
            node, pose, name = waiting.pop()
            name = node.get('name', name)
            count += 1
            if count > _MAX_NODES:
                raise ValueError('it has more than {} nodes'.format(_MAX_NODES))
            if node not in transforms:
                transforms[node] = _transform(node)
            pose = pose @ transforms[node]
            for child in node:
                if child.tag == 'node':
                    waiting.append((child, pose, name))
                elif child.tag == 'instance_node':
                    used = self.get('node', child.get('url'))
                    waiting += [] if used is None else [(used, pose, name)]
                elif child.tag in ('instance_geometry', 'instance_controller'):
                    yield from self._shape(child, pose, name)

    def _shape(self, instance: ElementTree.Element, pose: np.ndarray,
               name: str) -> Iterator[Tuple[_Group, np.ndarray]]:
        url = instance.get('url')
        if instance.tag == 'instance_controller':
            # the mesh of a skin, in the pose that it was bound in, or of a morph
            for _ in range(_MAX_CONTROLLERS):
                controller = self.get('controller', url)
                if controller is None or not len(controller):
                    break
                url = controller[0].get('source')
                matrix = controller[0].findtext('bind_shape_matrix')
                pose = pose if matrix is None else read_floats(matrix).reshape(4, 4) @ pose
        geometry = self.get('geometry', url)
        if geometry is not None:
            yield _Group(geometry, name, tuple(
                (each.get('symbol', ''), each.get('target', '')) for each in instance.findall(
                    'bind_material/technique_common/instance_material'))), pose


def _transform(node: ElementTree.Element) -> np.ndarray:
    """Return the transform (4, 4) of a node to its parent."""
    pose = np.eye(4)
    for child in node:
        step = np.eye(4)
        if child.tag == 'matrix':
            step = read_floats(child.text).reshape(4, 4)
        elif child.tag == 'translate':
            step[:3, 3] = read_floats(child.text)
        elif child.tag == 'scale':
            step[range(3), range(3)] = read_floats(child.text)
        elif child.tag == 'rotate':
            *axis, angle = read_floats(child.text)
            step[:3, :3] = _rotation(np.array(axis), np.radians(angle))
        pose = pose @ step
    return pose


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix of a rotation about an axis of any length (Rodrigues' formula)."""
    x, y, z = axis / max(float(np.linalg.norm(axis)), 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _written(unit: str, groups: Dict[_Group, List[np.ndarray]], materials: Materials
             ) -> Tuple[ElementTree.Element, List[FilePart]]:
    """Return the root element, and what the triangles of each number are."""
    root = ElementTree.Element('COLLADA', version='1.4.1', xmlns=_NAMESPACE)
    _add(_add(root, 'asset'), 'unit', meter=unit, name='unit')
    effects, made, geometries, scenes = (_add(root, 'library_' + name) for name in (
        'effects', 'materials', 'geometries', 'visual_scenes'))
    scene = _add(scenes, 'visual_scene', id='scene')
    names: Dict[int, str] = {}
    parts: List[FilePart] = []
    for group, poses in groups.items():
        key = id(group.geometry)
        if key not in names:
            names[key] = 'geometry_{}'.format(len(names))
            group.geometry.set('id', names[key])
            geometries.append(simplify(group.geometry))
        instance = _add(_add(scene, 'node'), 'instance_geometry', url='#' + names[key])
        bound = _add(_add(instance, 'bind_material'), 'technique_common')
        for symbol in {each.get('material', '') for each in group.geometry.iterfind('mesh/*')}:
            if symbol:
                _add(bound, 'instance_material', symbol=symbol, target='#m{}'.format(len(parts)))
                url = dict(group.bound).get(symbol, symbol)
                parts.append(FilePart(group.name, materials.get(url), np.array(poses)))
    for number in range(len(parts)):
        effect = _add(_add(effects, 'effect', id='e{}'.format(number)), 'profile_COMMON')
        diffuse = _add(_add(_add(effect, 'technique', sid='t'), 'lambert'), 'diffuse')
        _add(diffuse, 'color').text = ' '.join(map(repr, [*number_color(number), 1.0]))
        _add(_add(made, 'material', id='m{}'.format(number)), 'instance_effect',
             url='#e{}'.format(number))
    _add(_add(root, 'scene'), 'instance_visual_scene', url='#scene')
    return root, parts


def _add(parent: ElementTree.Element, tag: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)
