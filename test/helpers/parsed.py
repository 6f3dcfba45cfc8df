"""What is read of the text of a URDF."""

from img_recog.formats import lumping, urdf
from img_recog.report import Report


def given(text, find=lambda uri: None, report=None):
    """Return the links and joints of a URDF as it has them; report: gets what is not done."""
    return urdf.read(urdf.root_of(text), find, Report() if report is None else report)


def lumped(text, find=lambda uri: None, report=None):
    """Return the robot in a URDF; report: gets what is not done."""
    report = Report() if report is None else report
    return lumping.lumped(given(text, find, report), report)


def part(parts, name):
    """Return the link or the joint of a name."""
    found, = (each for each in parts if each.name == name)
    return found
