"""The poses in an SDF, and the frames that they are given in."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, Optional, Sequence

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats.reader import name_of, read, text_of, words
from img_recog.report import NOT_KNOWN, Report
from img_recog.rotations import IDENTITY, Transform, transform

WORLD = 'world'
_MODEL = '__model__'


def pose_of(element: ElementTree.Element) -> Transform:
    """Return the <pose> of an element, in the frame that it is given in."""
    text = text_of(element, 'pose') or '0 0 0 0 0 0'
    values = read('6lengths', text, '<pose> of {} {}'.format(element.tag, name_of(element)))
    return transform(values[:3], values[3:])


def set_pose(element: ElementTree.Element, pose: Transform) -> None:
    """Give an element a <pose> in the frame of its parent."""
    for old in element.findall('pose'):
        element.remove(old)
    ElementTree.SubElement(element, 'pose').text = words(
        (*pose.translation, *rotations.to_rpy(pose.rotation)))


class Scope:
    """The frames in an element: of its links, joints, frames and models.

    A name that it has not is one of the scope around it, if there is one; if it is in none, the
    pose counts without it, as in Gazebo, and that is a finding.
    """

    def __init__(self, owner: ElementTree.Element, report: Report,
                 outer: Optional['Scope'] = None):
        """owner: a world, a model or a link; outer: the scope around a link, its model."""
        self._owner, self._name, self._outer = owner, name_of(owner), outer
        self._report = report
        # until SDF 1.6 they may bear the same names, and poses were relative to links
        self._elements: Dict[str, ElementTree.Element] = {}
        for tag in ('link', 'model', 'frame', 'joint'):
            for element in owner.findall(tag):
                self._elements.setdefault(name_of(element), element)

    def pose(self, element: ElementTree.Element,
             visited: Sequence[ElementTree.Element] = ()) -> Transform:
        """Return the pose of an element in the owner."""
        if any(element is each for each in visited):
            raise SimulationError('{} {}: the pose of {} depends on itself'.format(
                self._owner.tag, self._name, name_of(element)))
        pose = element.find('pose')
        base = '' if pose is None else (pose.get('relative_to') or pose.get('frame') or '').strip()
        frame = self.frame(base, element, (*visited, element)) if base else None
        if frame is None and element.tag == 'joint':
            frame = self.frame(text_of(element, 'child'), element, (*visited, element))
        if frame is None and element.tag == 'frame':
            frame = self.frame(element.get('attached_to', ''), element, (*visited, element))
        return (frame or IDENTITY) @ pose_of(element)

    def frame(self, name: str, element: ElementTree.Element,
              visited: Sequence[ElementTree.Element] = ()) -> Optional[Transform]:
        """Return the pose in the owner of the frame that an element names; None if unknown."""
        found = self._frame(name, visited)
        if found is None:
            self._report.add(
                NOT_KNOWN, 'the frame {}'.format(name), '{} {} {}'.format(
                    self._name, element.tag, name_of(element)).strip())
        return found

    def _frame(self, name: str, visited: Sequence[ElementTree.Element]) -> Optional[Transform]:
        outer, _, inner = name.partition('::')
        element = self._elements.get(outer) if outer else None      # '' is the owner
        if element is not None:
            pose = self.pose(element, visited)
            within = Scope(element, self._report)._frame(inner, ()) if inner else IDENTITY
            return None if within is None else pose @ within
        if name and self._outer is not None:
            found = self._outer._frame(name, ())
            return None if found is None else self._outer.pose(self._owner).inverse @ found
        if name in ('', _MODEL, WORLD, self._name):
            return IDENTITY
        return self._frame(inner, visited) if inner and outer == self._name else None
