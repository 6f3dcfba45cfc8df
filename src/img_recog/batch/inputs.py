"""All that a world and a robot are read from, on which results of a simulation depend."""
import functools
import os
import xml.etree.ElementTree as ElementTree

from img_recog.batch.work_folder import digest, identity
from img_recog.errors import UserError, one_line
from img_recog.rendering import prepared
from img_recog.replay import scenario


@functools.lru_cache(maxsize=None)      # a program reads them once
def of_scene(world: str, urdf: str) -> str:
    """Return a hash of what a world and a robot are once they are read, and of their files.

    world, urdf: as for scenario.build. What is included, expanded, found somewhere else, or not
    found any more makes another text, so only the files that the texts name are left.
    """
    try:
        file, robot, text = scenario.read(world, urdf)
    except UserError as error:      # what cannot be read has no result
        return one_line(error)
    urdfs = [robot.description.urdf, *(tree.urdf for tree in file.trees)]
    paths = {path for urdf in urdfs for element in ElementTree.fromstring(urdf).iter()
             for named in filter(os.path.isabs, element.attrib.values())
             for path in prepared.files_of(named)}
    return digest((text, urdfs[0], file, [
        (path, os.path.isfile(path) and identity(path)) for path in sorted(paths)]))
