"""Looks for robots that stand on other links than their driven wheels, and so cannot drive."""
from typing import Dict, List, Sequence, Set

from img_recog import rotations
from img_recog.report import NOTE, Report
from img_recog.simulation.physics import tires
from img_recog.simulation.simulated_model import Robot

_LOOKS = 2              # in a row: at the start, a robot may still fall
_UPRIGHT = 0.95         # vertical part of the z axis of a robot: 18 degrees


class HangingWheels:
    """Warns of each robot whose wheels hang in the air, once."""

    def __init__(self) -> None:
        self._counts: Dict[str, int] = {}       # of looks in a row, by robot
        self._told: Set[str] = set()

    def reset(self) -> None:
        """Call after the robots were moved to their starts."""
        self._counts.clear()

    def look(self, robots: Sequence[Robot], report: Report) -> None:
        """Look at robots; report: gets a line about each one."""
        for robot in robots:
            name, links = robot.body.name, _standing_on(robot)
            self._counts[name] = self._counts.get(name, 0) + 1 if links else 0
            if self._counts[name] == _LOOKS and name not in self._told:
                self._told.add(name)
                report.about(name).add(
                    NOTE, 'no driven wheel touches anything, it stands on {}; lower its wheels, '
                    'or raise what it stands on'.format(', '.join(links)))


def _standing_on(robot: Robot) -> List[str]:
    """Return the links on which a robot stands upright, if none of them is a driven wheel."""
    body, drive = robot.body, robot.settings.drive
    names = {index: tires.owner(name) for name, index in body.link_indices.items()}
    driven = {names[body.joints[name]] for name in (*drive.left_joints, *drive.right_joints)
              if name in body.joints}
    if not driven or rotations.matrix(body.pose().orientation)[2, 2] < _UPRIGHT:
        return []
    touching = {names[point.link] for point in body.contacts() if point.force > 0}
    return [] if touching & driven else sorted(touching)
