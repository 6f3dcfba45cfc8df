"""The poses in an SDF, and the frames that they are given in."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, Optional, Sequence

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats.numbers import read_lengths, words
from img_recog.formats.texts import name_of, text_of
from img_recog.rotations import IDENTITY, Transform, transform

WORLD = 'world'
_MODEL = '__model__'


def pose_of(element: ElementTree.Element) -> Transform:
    """Return the <pose> of an element, in the frame that it is given in."""
    text = text_of(element, 'pose') or '0 0 0 0 0 0'
    values = read_lengths('<pose> of {} {}'.format(element.tag, name_of(element)), text, 6)
    return transform(values[:3], values[3:])


def apply_state(model: ElementTree.Element, state: Optional[ElementTree.Element]) -> None:
    """Move a model to where the <state> of its world has it, like Gazebo."""
    if state is None:
        return
    for each in state.findall('model'):
        if each.get('name') == model.get('name') and each.find('pose') is not None:
            pose = pose_of(each)
            for old in model.findall('pose'):
                model.remove(old)
            values = (*pose.translation, *rotations.to_rpy(pose.rotation))
            ElementTree.SubElement(model, 'pose').text = words(values)


class Scope:
    """The frames of one model: of its links, joints, frames and models."""

    def __init__(self, model: ElementTree.Element):
        self._name = name_of(model)
        # until SDF 1.6 they may bear the same names, and poses were relative to links
        self._elements: Dict[str, ElementTree.Element] = {}
        for tag in ('link', 'model', 'frame', 'joint'):
            for element in model.findall(tag):
                self._elements.setdefault(name_of(element), element)

    def pose(self, element: ElementTree.Element,
             visited: Sequence[ElementTree.Element] = ()) -> Transform:
        """Return the pose of a link, joint, frame or model in the model."""
        if any(element is each for each in visited):
            raise SimulationError('model {}: the pose of {} depends on itself'.format(
                self._name, name_of(element)))
        pose = element.find('pose')
        base = '' if pose is None else (pose.get('relative_to') or pose.get('frame') or '').strip()
        if not base and element.tag == 'joint':
            base = text_of(element, 'child')
        if not base and element.tag == 'frame':
            base = element.get('attached_to', '')
        return self.frame(base, (*visited, element)) @ pose_of(element)

    def frame(self, name: str, visited: Sequence[ElementTree.Element] = ()) -> Transform:
        """Return the pose of a frame in the model, by its name."""
        outer, _, inner = name.partition('::')
        element = self._elements.get(outer) if outer else None      # '' is the model
        if element is None and name in ('', _MODEL, WORLD, self._name):
            return IDENTITY
        if element is None and outer == self._name:
            return self.frame(inner, visited)
        if element is None:
            raise SimulationError('model {}: a pose is relative to {}, which does not exist'
                                  .format(self._name, name))
        pose = self.pose(element, visited)
        return pose @ Scope(element).frame(inner) if inner else pose
