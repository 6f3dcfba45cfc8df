"""The error of a machine on which nothing can be drawn by OpenGL."""
from img_recog.errors import UserError


class OpenGLError(UserError):
    """There is no OpenGL that can be used."""
