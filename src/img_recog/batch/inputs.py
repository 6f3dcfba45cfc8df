"""All that a world and a robot are read from, on which results of a simulation depend."""
import functools
import os

from img_recog.batch.work_folder import digest, identity
from img_recog.errors import UserError, one_line
from img_recog.loading import assemble, robot_file
from img_recog.rendering import prepared


@functools.lru_cache(maxsize=None)      # a program reads them once
def of_scene(world: str, urdf: str) -> str:
    """Return a hash of what a world and a robot are once they are read, and of their files.

    world, urdf: as for scenario.build. What is included, expanded, found somewhere else, or not
    found any more makes another model, so only the files that the models name are left.
    """
    try:
        text = robot_file.read(urdf, '--urdf')
        robot, file = assemble.robot_of(text, urdf), assemble.world(world, allow_partial=False)
    except UserError as error:      # what cannot be read has no result
        return one_line(error)
    models = [robot.model, *(tree.model for tree in file.trees)]
    paths = {path for model in models for named in model.files
             for path in prepared.files_of(named)}
    return digest((text, robot.model, file, [
        (path, os.path.isfile(path) and identity(path)) for path in sorted(paths)]))
