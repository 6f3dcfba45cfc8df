"""Reads the text of a model that is added to a world while that is simulated."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Sequence

from img_recog.errors import SimulationError
from img_recog.files import FindFile
from img_recog.formats import (allowed_names, audit, drive_controllers, drive_tags, lumping,
                               sdf_file, sdf_versions, urdf, world_file)
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.markup import MarkupError, check_expanded, parse_xml
from img_recog.model import Tree
from img_recog.report import LEFT_OUT, Report

_NOWHERE = os.path.join(os.sep, 'model.sdf')        # a text has no folder
_ANY_STEP_S = 0.001
_WORLD_LINK = 'world'       # a URDF whose root has that name is fixed to the world


def is_robot(text: str, controllers: FindControllers = drive_controllers.none) -> bool:
    """Return whether a model is a robot that drives: a URDF with the plugin of a drive.

    controllers: returns those of ros_control that it can have. Raises SimulationError when it is
    not a URDF.
    """
    root = urdf.root_of(text)
    return drive_tags.is_drive(root.findall('gazebo/plugin')) or (
        drive_controllers.find(root, controllers, _ANY_STEP_S, Report()) is not None)


def read(text: str, name: str, find: FindFile, report: Report) -> Sequence[Tree]:
    """Return the trees of a model that is given as SDF or URDF, under a new name.

    find: returns the path of a file or folder at a URI; report: gets what is not done as asked.
    Raises SimulationError when it is neither, something in it cannot be had, or the name is not
    allowed.
    """
    allowed_names.check_model(name)
    report = report.about('model ' + name)
    try:
        root = parse_xml(text)
        check_expanded(root)
        if root.tag in ('robot', 'sdf'):
            sdf_versions.unify(root)
            report.extend(audit.audit(root))
        if root.tag == 'robot':
            trees = _of_urdf(root, name, find, report)
        elif root.tag == 'sdf':
            trees = _of_sdf(root, name, find, report)
        else:
            raise SimulationError('got the root element <{}>, expected <sdf> or <robot> (URDF)'
                                  .format(root.tag))
    except (MarkupError, SimulationError) as error:
        raise SimulationError('model {}: {}'.format(name, error.problem), error.advice)
    report.refuse('remove that from the model')
    return trees


def _of_sdf(root: ElementTree.Element, name: str, find: FindFile,
            report: Report) -> Sequence[Tree]:
    models = root.findall('model') + root.findall('include')
    if len(models) != 1:
        raise SimulationError('got {} models, expected one <model> in <sdf>'.format(len(models)))
    if models[0].tag == 'model':
        models[0].set('name', name)
    else:
        for old in models[0].findall('name'):
            models[0].remove(old)
        ElementTree.SubElement(models[0], 'name').text = name
    contents = sdf_file.read(root, _NOWHERE, find, report)
    if not contents.trees and not report.of(LEFT_OUT):
        raise SimulationError('it has only lights, which every world here has already',
                              'add a model that has a <link>')
    return contents.trees


def _of_urdf(robot: ElementTree.Element, name: str, find: FindFile,
             report: Report) -> Sequence[Tree]:
    model = urdf.read(robot, find, report)
    if _WORLD_LINK in model.roots:
        return [world_file.fixed_tree(model, name)]
    return [Tree(name, lumping.lumped(model, report))]
