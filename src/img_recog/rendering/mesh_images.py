"""Finds and decodes what a mesh file refers to."""
import io
import os
from typing import Any, Dict, List
from urllib.parse import unquote

import numpy as np
from PIL import Image
from trimesh.resolvers import FilePathResolver

from img_recog.errors import one_line
from img_recog.rendering import textures

# where Gazebo looks for the textures of a mesh
_FOLDERS = ('', os.path.join('..', 'materials', 'textures'))
_FILE = 'file://'
_MAX_BYTES = 1 << 28
_MATERIALS = '.mtl'     # of Wavefront's OBJ, not an image


class MeshImages(FilePathResolver):
    """What trimesh reads of the files beside a mesh; it does not tell about those it cannot read.

    problems: a text for each of them.
    """

    def __init__(self, path: str):
        """path: of the mesh file."""
        super().__init__(path)
        self.problems: List[str] = []
        self._decoded: Dict[int, np.ndarray] = {}

    def get(self, name: str) -> bytes:
        """Return the content of a file, which is found as Gazebo finds it.

        Raises an error, which trimesh ignores, if there is none or it is a damaged image.
        """
        given = unquote(str(name))
        given = given[len(_FILE):] if given.startswith(_FILE) else given
        paths = (os.path.join(self.parent, folder, given) for folder in _FOLDERS)
        path = next((each for each in paths if os.path.isfile(each)), '')
        try:
            with open(path, 'rb') as file:
                content = file.read(_MAX_BYTES)
            if not given.lower().endswith(_MATERIALS):
                # trimesh copies images, which decodes them whatever they are
                with Image.open(io.BytesIO(content)) as image:
                    textures.decoded(image)
        except Exception as error:      # Pillow raises errors of many types
            text = 'its texture {}: {}'.format(given, one_line(error))
            self.problems += [] if text in self.problems else [text]
            raise
        return content

    def decoded(self, image: Any) -> np.ndarray:
        """Return the pixels of an image that trimesh has opened, RGB."""
        key = id(image)     # the material keeps it
        if key not in self._decoded:
            self._decoded[key] = textures.decoded(image)
        return self._decoded[key]
