"""Makes the renderer; the libraries that it needs are loaded when it is made."""
from typing import TYPE_CHECKING, Any, Callable, Tuple

from img_recog.errors import UserError, one_line
from img_recog.rendering.errors import OpenGLError

if TYPE_CHECKING:
    from img_recog.rendering.opengl import Renderer


def make_or(make_first: Callable[[], Any], make_fallback: Callable[[], Any]) -> Tuple[Any, str]:
    """Return what make_first makes and '', or what make_fallback makes and why it was used."""
    try:
        return make_first(), ''
    except UserError as error:
        return make_fallback(), str(error)


def make() -> 'Renderer':
    """Return a renderer by OpenGL; raise OpenGLError if there is none, or no library for it."""
    try:
        # takes 0.3 s, and half of the memory of a process that only wants images
        from img_recog.rendering.opengl import Renderer
    except ImportError as error:
        raise OpenGLError('moderngl or trimesh cannot be loaded: {}'.format(one_line(error)),
                          'install them, see packages-debian.txt and requirements.txt')
    return Renderer()
