"""Makes the renderer; the libraries that it needs are loaded when it is made."""
from typing import TYPE_CHECKING

from img_recog.errors import UserError, one_line

if TYPE_CHECKING:
    from img_recog.rendering.opengl import Renderer


class OpenGLError(UserError):
    """There is no OpenGL that can be used."""


def make() -> 'Renderer':
    """Return a renderer by OpenGL; raise OpenGLError if there is none, or no library for it."""
    try:
        # takes 0.3 s, and half of the memory of a process that only wants images
        from img_recog.rendering.opengl import Renderer
    except ImportError as error:
        raise OpenGLError('moderngl or trimesh cannot be loaded: {}'.format(one_line(error)),
                          'install them, see packages-debian.txt and requirements.txt')
    return Renderer()
