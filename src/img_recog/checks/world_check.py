"""How the world in a file is simulated: built as in the node."""
from typing import Iterator, Sequence

import numpy as np

from img_recog.checks import looks
from img_recog.checks.check_report import SIMULATED, CheckReport, CheckRow, rows_of
from img_recog.loading import assemble
from img_recog.report import LEFT_OUT
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings

_OPTION = 'allow_partial_world:=true'


def check(path: str, allow_partial: bool = False) -> CheckReport:
    """Return what is simulated of a world; path: of an SDF, URDF or xacro file.

    allow_partial: whether one of which something is left out can be used.
    Raises a UserError when the file cannot be used at all.
    """
    simulator = assemble.simulator(PhysicsSettings(world=path, allow_partial_world=True),
                                   with_sensors=True, with_drives=True)
    world = simulator.world
    file, report = world.file, world.report
    drawn, boxes = looks.read(simulator)
    rows = list(_models(world, boxes))
    if file.has_floor:
        rows.append(CheckRow(SIMULATED, 'floor', 'at z 0'))
    rows += [CheckRow(SIMULATED, 'gravity', '{:g} {:g} {:g} m/s2'.format(*file.gravity)), drawn,
             *rows_of(report)]
    problem = '' if allow_partial or not report.of(LEFT_OUT) else (
        'something is left out of it; give --allow-partial-world here, and {} to the demo'.format(
            _OPTION))
    return CheckReport('world {} in {}'.format(file.name, path), rows, report.lines(), problem,
                       report.is_partial)


def _models(world: World, boxes: Sequence[looks.Box]) -> Iterator[CheckRow]:
    for tree, body, box in zip(world.trees, world.bodies, boxes):
        how = '{:.4g} kg'.format(body.mass())
        if tree.fixed:      # what is static has no inertia
            mass = sum(link.inertia.mass for link in tree.model.links if link.inertia)
            how = '{:.4g} kg, joined to the world'.format(mass) if mass else 'static'
        yield CheckRow(SIMULATED, 'model ' + tree.name, '{}, {}'.format(how, looks.size(box)))
    of_drawn = [box for box in boxes if box is not None]
    if of_drawn:
        yield CheckRow(SIMULATED, 'models', '{}, {}'.format(
            sum(tree.first for tree in world.trees),
            looks.size(np.array([np.min(of_drawn, axis=0)[0], np.max(of_drawn, axis=0)[1]]))))
