"""Makes what draws; the libraries that it needs are loaded when it is made."""
from typing import Any, Callable, Tuple

from img_recog.errors import UserError, one_line


def make_or(make_fallback: Callable[[], Any]) -> Tuple[Any, str]:
    """Return a renderer by OpenGL and '', or what make_fallback makes and why OpenGL cannot be."""
    try:
        # takes 0.3 s, and half of the memory of a process that only wants images
        from img_recog.rendering.opengl import Renderer
        return Renderer(), ''
    except ImportError as error:
        reason = ('moderngl cannot be loaded: {}; install it, see packages-debian.txt and '
                  'requirements.txt'.format(one_line(error)))
    except UserError as error:
        reason = str(error)
    return make_fallback(), reason
