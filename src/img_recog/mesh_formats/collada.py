"""COLLADA files in the form that trimesh reads whole: a flat scene, a color for each material.

Of other files trimesh drops in silence: geometries whose material, effect or image is incomplete,
texture coordinates without a material, skins, and each mesh with a comment or with lines. The
scene and the materials are read as by ColladaLoader of Gazebo 11.
"""
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.mesh_formats.collada_geometry import count_triangles, simplify
from img_recog.mesh_formats.file_material import FileMaterial, number_color
from img_recog.mesh_formats.simplified import FilePart, Simplified
from img_recog.visuals import GREY

_NAMESPACE = 'http://www.collada.org/2005/11/COLLADASchema'
_MAX_NODES, _MAX_SHAPES = 100_000, 10_000       # that the nodes of a file refer to
_MAX_CONTROLLERS = 10                           # that refer to one another
_SHADERS = 'lambert', 'phong', 'blinn', 'constant'
_LUMINANCE = 0.212671, 0.71516, 0.072169        # of ITU-R BT.709, as in the specification


class _Shape(NamedTuple):
    """A geometry in the scene.

    name: of the node that it is in; bound: its materials, by the symbols that it has for them.
    """

    geometry: ElementTree.Element
    pose: np.ndarray
    name: str
    bound: Dict[str, str]


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
    shapes: List[_Shape] = []
    counts: Dict[int, int] = {}
    total = 0
    for shape in document.shapes():
        key = id(shape.geometry)
        if key not in counts:
            counts[key] = count_triangles(shape.geometry)
        total += counts[key]
        shapes.append(shape)
        if len(shapes) > _MAX_SHAPES or total > max_triangles:
            raise ValueError('it has more than {} shapes or {} triangles'.format(
                _MAX_SHAPES, max_triangles))
    parts = _Parts(_Materials(document, find_texture))
    written = _written(document.unit(), shapes, parts)
    return Simplified(ElementTree.tostring(written), parts.found, total)


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

    def shapes(self) -> Iterator[_Shape]:
        """Yield what the nodes of the scene show."""
        instance = self._root.find('scene/instance_visual_scene')
        scene = None if instance is None else self.get('visual_scene', instance.get('url'))
        if scene is None:
            raise ValueError('it has no visual scene')
        waiting = [(node, np.eye(4), '') for node in reversed(scene.findall('node'))]
        count = 0
        while waiting:
            node, pose, name = waiting.pop()
            name = node.get('name', name)
            count += 1
            if count > _MAX_NODES:
                raise ValueError('it has more than {} nodes'.format(_MAX_NODES))
            pose = pose @ _transform(node)
            for child in node:
                if child.tag == 'node':
                    waiting.append((child, pose, name))
                elif child.tag == 'instance_node':
                    used = self.get('node', child.get('url'))
                    waiting += [] if used is None else [(used, pose, name)]
                elif child.tag in ('instance_geometry', 'instance_controller'):
                    yield from self._shape(child, pose, name)

    def _shape(self, instance: ElementTree.Element, pose: np.ndarray,
               name: str) -> Iterator[_Shape]:
        url = instance.get('url')
        if instance.tag == 'instance_controller':
            # the mesh of a skin, in the pose that it was bound in, or of a morph
            for _ in range(_MAX_CONTROLLERS):
                controller = self.get('controller', url)
                if controller is None or not len(controller):
                    break
                url = controller[0].get('source')
                matrix = controller[0].findtext('bind_shape_matrix')
                pose = pose if matrix is None else _numbers(matrix).reshape(4, 4) @ pose
        geometry = self.get('geometry', url)
        if geometry is not None:
            yield _Shape(geometry, pose, name, {
                each.get('symbol', ''): each.get('target', '')
                for each in instance.findall('bind_material/technique_common/instance_material')})


def _numbers(text: Optional[str]) -> np.ndarray:
    return np.array((text or '').split(), float)


def _transform(node: ElementTree.Element) -> np.ndarray:
    """Return the transform (4, 4) of a node to its parent."""
    pose = np.eye(4)
    for child in node:
        step = np.eye(4)
        if child.tag == 'matrix':
            step = _numbers(child.text).reshape(4, 4)
        elif child.tag == 'translate':
            step[:3, 3] = _numbers(child.text)
        elif child.tag == 'scale':
            step[range(3), range(3)] = _numbers(child.text)
        elif child.tag == 'rotate':
            *axis, angle = _numbers(child.text)
            step[:3, :3] = _rotation(np.array(axis), np.radians(angle))
        pose = pose @ step
    return pose


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix of a rotation about an axis of any length (Rodrigues' formula)."""
    x, y, z = axis / max(float(np.linalg.norm(axis)), 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class _Parts:
    """Numbers the names and materials that triangles have; found: by number."""

    def __init__(self, materials: '_Materials'):
        self._materials = materials
        self._numbers: Dict[FilePart, int] = {}
        self.found: List[FilePart] = []

    def number(self, name: str, url: str) -> int:
        """Return the number of a node's name and the material at a URL."""
        part = FilePart(name, self._materials.get(url))
        if part not in self._numbers:
            self._numbers[part] = len(self.found)
            self.found.append(part)
        return self._numbers[part]


class _Materials:
    """The materials that are in use, each read once."""

    def __init__(self, document: _Document, find_texture: Callable[[str], str]):
        self._document, self._find_texture = document, find_texture
        self._found: Dict[str, Optional[FileMaterial]] = {}

    def get(self, url: str) -> Optional[FileMaterial]:
        """Return the material at a URL, None if there is none."""
        if url not in self._found:
            element = self._document.get('material', url)
            self._found[url] = None if element is None else self._read(element)
        return self._found[url]

    def _read(self, material: ElementTree.Element) -> FileMaterial:
        instance = material.find('instance_effect')
        effect = None if instance is None else self._document.get('effect', instance.get('url'))
        shaders = [] if effect is None else [
            shader for name in _SHADERS
            for shader in effect.findall('profile_COMMON/technique/' + name)]
        if effect is None or not shaders:
            return FileMaterial()
        shader = shaders[0]
        opacity = _opacity(shader)
        texture = shader.find('diffuse/texture')
        if texture is not None:
            return FileMaterial((*GREY[:3], opacity), self._find_texture(
                self._image(effect, texture.get('texture', ''))))
        glow = _color(shader, 'emission', (0.0, 0.0, 0.0, 1.0))
        color = _color(shader, 'diffuse', glow if shader.tag == 'constant' else GREY)
        red, green, blue = (min(max(one + other, 0.0), 1.0)
                            for one, other in zip(color[:3], glow[:3]))
        return FileMaterial((red, green, blue, opacity))

    def _image(self, effect: ElementTree.Element, name: str) -> str:
        """Return the file name of an image that an effect refers to, '' without one."""
        parameters = {each.get('sid', ''): each for each in effect.iter('newparam')}
        image = self._document.get('image', name)
        if name in parameters:
            source = parameters[name].findtext('sampler2D/source', '').strip()
            surface = parameters.get(source)
            url = None if surface is None else surface.findtext('surface/init_from')
            instance = parameters[name].find('sampler2D/instance_image')      # COLLADA 1.5
            image = self._document.get('image', url if instance is None else instance.get('url'))
        if image is None:
            return ''
        return image.findtext('init_from', '').strip() or image.findtext('init_from/ref', '')


def _color(shader: ElementTree.Element, tag: str, default: Sequence[float]) -> Sequence[float]:
    values = _numbers(shader.findtext(tag + '/color')).tolist()
    return default if len(values) < 3 else [*values, 1.0][:4]


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


def _written(unit: str, shapes: Sequence[_Shape], parts: _Parts) -> ElementTree.Element:
    root = ElementTree.Element('COLLADA', version='1.4.1', xmlns=_NAMESPACE)
    _add(_add(root, 'asset'), 'unit', meter=unit, name='unit')
    effects, made, geometries, scenes = (_add(root, 'library_' + name) for name in (
        'effects', 'materials', 'geometries', 'visual_scenes'))
    scene = _add(scenes, 'visual_scene', id='scene')
    names: Dict[int, str] = {}
    for shape in shapes:
        key = id(shape.geometry)
        if key not in names:
            names[key] = 'geometry_{}'.format(len(names))
            shape.geometry.set('id', names[key])
            geometries.append(simplify(shape.geometry))
        node = _add(scene, 'node')
        _add(node, 'matrix').text = ' '.join(map(repr, shape.pose.ravel().tolist()))
        instance = _add(node, 'instance_geometry', url='#' + names[key])
        bound = _add(_add(instance, 'bind_material'), 'technique_common')
        for symbol in {each.get('material', '') for each in shape.geometry.iterfind('mesh/*')}:
            if symbol:
                number = parts.number(shape.name, shape.bound.get(symbol, symbol))
                _add(bound, 'instance_material', symbol=symbol, target='#m{}'.format(number))
    for number in range(len(parts.found)):
        effect = _add(_add(effects, 'effect', id='e{}'.format(number)), 'profile_COMMON')
        diffuse = _add(_add(_add(effect, 'technique', sid='t'), 'lambert'), 'diffuse')
        _add(diffuse, 'color').text = ' '.join(map(repr, [*number_color(number), 1.0]))
        _add(_add(made, 'material', id='m{}'.format(number)), 'instance_effect',
             url='#e{}'.format(number))
    _add(_add(root, 'scene'), 'instance_visual_scene', url='#scene')
    return root


def _add(parent: ElementTree.Element, tag: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)
