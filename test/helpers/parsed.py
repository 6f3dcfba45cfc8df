"""What is read of the text of a URDF."""

from img_recog.formats import lumping, urdf


def given(text, find=lambda uri: None):
    """Return the links and joints of a URDF as it has them."""
    return urdf.read(urdf.root_of(text), find)


def lumped(text, find=lambda uri: None):
    """Return the robot in a URDF."""
    return lumping.lumped(given(text, find))


def part(parts, name):
    """Return the link or the joint of a name."""
    found, = (each for each in parts if each.name == name)
    return found
