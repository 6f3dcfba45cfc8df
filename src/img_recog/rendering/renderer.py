"""Makes what draws; the libraries that it needs are loaded when it is made."""
from typing import Any

from img_recog.errors import UserError, one_line


def make() -> Any:
    """Return an opengl.Renderer; UserError if there is no OpenGL."""
    try:
        # takes 0.3 s, and half of the memory of a process that only wants images
        from img_recog.rendering.opengl import Renderer
    except ImportError as error:
        raise UserError('no images can be drawn: moderngl cannot be loaded: {}'.format(
            one_line(error)), 'install it, see packages-debian.txt and requirements.txt')
    return Renderer()
