"""The materials of a COLLADA file, read as by ColladaLoader of Gazebo 11."""
import contextlib
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Optional, Sequence

import numpy as np

from img_recog.formats.meshes.file_material import UNSTATED, UNSTATED_AMBIENT
from img_recog.model import Material, Rgb

_SHADERS = 'lambert', 'phong', 'blinn', 'constant'
_LUMINANCE = 0.212671, 0.71516, 0.072169        # of ITU-R BT.709, as in the specification

# of a tag and the URL of an element
Get = Callable[[str, Optional[str]], Optional[ElementTree.Element]]


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
