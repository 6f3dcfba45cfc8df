"""Forces on the links and joints of models, as the services of gazebo_ros apply them."""
import math
from typing import Sequence, Tuple

import numpy as np

from img_recog.simulation.models import WORLD, Models
from img_recog.simulation.physics.pushes import Effort, Wrench
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.states import check


class ModelForces:
    """Lets wrenches and efforts act for a time.

    Times: start_s: simulated, what has passed is now; duration_s: at least one step, below 0 until
    it is cleared, and with 0 nothing acts. A reset of the world clears all.
    """

    def __init__(self, simulator: Simulator, models: Models):
        self._simulator, self._models = simulator, models
        self._pushes = simulator.world.pushes

    def apply_wrench(self, link: str, force: Sequence[float], torque: Sequence[float],
                     start_s: float, duration_s: float, point: Sequence[float] = (0.0, 0.0, 0.0),
                     frame: str = WORLD) -> None:
        """Let a force (3,) in N and a torque (3,) in N m act on a link.

        They act at the center of mass, along the axes of the world, whatever the frame. In the
        frame of the world, the lever of the force is `point` (3,) in m. Any other is the name of a
        model or link: there, force, torque and point are given, and as gazebo_ros does it, they
        are seen from the link as it stands now; its axes then count as those of the world.
        Raises SimulationError when there is no such link or frame, or a number is not finite.
        """
        check('wrench', [*force, *torque, *point])
        body, name = self._models.link(link)
        act = np.array(force), np.array(torque) + np.cross(point, force)
        if frame != WORLD:
            seen = self._models.state(frame, link).pose()
            turned = seen.rotation @ act[0]
            act = turned, seen.rotation @ act[1] + np.cross(seen.translation, turned)
        wait, left = self._steps(start_s, duration_s)
        if left:
            self._pushes.add(Wrench(body, name, wait, left, *act))

    def apply_effort(self, joint: str, effort: float, start_s: float, duration_s: float) -> None:
        """Let a torque in N m or a force in N act on the first axis of a joint.

        Not more than the file gives as the limit of the effort, and not beyond that of the
        velocity. Raises SimulationError when there is no such joint that moves, or a number is not
        finite.
        """
        check('effort', [effort])
        body, name = self._models.joint(joint)
        limits = body.limits(name)
        wait, left = self._steps(start_s, duration_s)
        if left:
            within = min(max(effort, -limits.effort), limits.effort)
            self._pushes.add(Effort(body, name, wait, left, within, limits.velocity))

    def _steps(self, start_s: float, duration_s: float) -> Tuple[int, float]:
        """Return the steps until something begins, and those for which it acts."""
        step_s = self._simulator.world.step_s
        wait = max(0, round(start_s / step_s) - self._simulator.steps)
        if duration_s <= 0:
            return wait, math.inf if duration_s < 0 else 0
        return wait, max(1, round(duration_s / step_s))

    def clear_wrenches(self, link: str) -> None:
        """End those on MODEL::LINK, or on all links of a name.

        Like in Gazebo, nothing happens if there are none.
        """
        self._clear(Wrench, list(self._models.links(link)))

    def clear_efforts(self, joint: str) -> None:
        """End those of MODEL::JOINT, or of all joints of a name; as for `clear_wrenches`."""
        self._clear(Effort, list(self._models.joints(joint)))

    def _clear(self, kind: type, targets: Sequence[Tuple[object, str]]) -> None:
        self._pushes.remove(lambda push: isinstance(push, kind)
                            and (push.body, push.name) in targets)
