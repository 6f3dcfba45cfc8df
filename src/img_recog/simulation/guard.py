"""Keeps what the physics throws to infinity away from the rest of the world."""
import math
from typing import Dict, Iterable, List, Sequence, Set

from img_recog.report import NOTE
from img_recog.simulation.physics.body import BodyState
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.model_bodies import ModelBodies
from img_recog.simulation.physics.sleeping import IDLE_S
from img_recog.simulation.physics.world import World

# m: beyond what can be set from outside, see models.py
_FAR_M = 1e7
# m/s and rad/s: the physics cuts velocities at 1e5, see body.py; what is as fast was thrown
_FAST = 5e4
_LOOK_STEPS = 10        # from one look to the next one
_SAVED_STEPS = 100      # from one state of all bodies that is kept to the next one
_AT_A_LOOK = 8          # bodies that are looked at: more would take time


class Guard:
    """Freezes models whose state is not finite, or so large that it soon will not be.

    NaN spreads within a step to all that touches, and from a floor to all that is on it. So the
    states of all bodies are kept now and then. If one has NaN, all that have it are moved back,
    and one after another is tried: those that bring NaN are frozen until a reset.
    """

    def __init__(self, world: World):
        self._world = world
        self._states: Dict[FramedBody, BodyState] = {}      # of all that moves
        self._moving: List[FramedBody] = []                 # those of the states
        self._asleep: Set[int] = set()                      # those that slept at the last states
        self._saved_at = self._looked_at = self._next = 0
        self._revision = -1
        self._frozen: Dict[FramedBody, bool] = {}           # whether each one was fixed before
        self._has_moved_back = False

    def before_steps(self, steps: int) -> None:
        """Take note of bodies that were added or removed; to be called before a step.

        steps: the number of steps until now.
        """
        if self._revision != self._world.revision:
            self._find()
            self._save(steps)

    def look(self, steps: int) -> None:
        """Freeze what must be frozen; to be called after steps, often."""
        if steps - self._looked_at < _LOOK_STEPS:
            return
        self._looked_at = steps
        if steps - self._saved_at >= _SAVED_STEPS:
            asleep = self._world.sleeping.asleep
            # a body that slept at both times has not moved: it falls asleep only after IDLE_S
            still = (asleep & self._asleep
                     if _SAVED_STEPS * self._world.step_s < IDLE_S else set())
            states = {body: state if body.body_id in still else body.state()
                      for body, state in self._states.items()}
            self._asleep = asleep
            is_well = all(_is_small(state) for body, state in states.items()
                          if body.body_id not in still)
            if is_well:
                self._states, self._saved_at = states, steps
        else:
            looked = self._moving[self._next:self._next + _AT_A_LOOK]
            self._next = (self._next + _AT_A_LOOK) % max(len(self._moving), 1)
            # also False for NaN
            is_well = all([-_FAR_M < sum(body.center()[0]) < _FAR_M for body in looked])
        if not is_well:
            self._mend(steps)
            self._find()
            self._save(steps)

    def reset(self) -> None:
        """Let all models move again; to be called before all is moved to its start."""
        self._find()
        self._has_moved_back = False
        for model in self._models:
            if model.bodies[0] in self._frozen:
                self._thaw(model)
        self._restore({}, [model for model in self._models if not all(
            _is_small(body.state()) for body in model.bodies if _moves(body))])
        self._revision = -1

    def _find(self) -> None:
        """Look for bodies that were added or removed."""
        self._models = [model for model in self._world.models
                        if model.bodies[0] is not self._world.floor]
        self._bodies = [body for model in self._models for body in model.bodies]
        self._frozen = {body: fixed for body, fixed in self._frozen.items()
                        if body in self._bodies}
        self._revision = self._world.revision

    def _save(self, steps: int) -> None:
        self._states = {body: body.state() for body in self._bodies
                        if body not in self._frozen and _moves(body)}
        self._moving, self._asleep = list(self._states), set()
        self._saved_at = self._looked_at = steps

    def _mend(self, steps: int) -> None:
        """Move back what is not small, and freeze what brings that about."""
        before, trial = dict(self._states), steps - self._saved_at + 1
        saved_s = self._saved_at * self._world.step_s
        now = {body: body.state() for body in before}
        large: List[ModelBodies] = [
            model for model in self._models
            if any(body in now and not _is_small(now[body]) for body in model.bodies)]
        back = {body: before[body] for model in large for body in model.bodies
                if body in before}
        now.update(back)
        spread = not all(_is_finite(body.state()) for body in [*back, *self._world.fixed])
        self._restore(now, large)
        culprits = large if not spread or len(large) < 2 else self._tried(large, now, trial)
        if not culprits and not self._has_moved_back:
            self._has_moved_back = True
            self._say(', '.join(model.bodies[0].name for model in large),
                      'the physics computed nan, and not again from where they were at {:g} s; '
                      'they were moved back to there'.format(saved_s))
            return
        for model in culprits or large:
            if model.bodies[0] not in self._frozen:
                self._freeze(model, now)
            self._say(model.bodies[0].name,
                      'the physics has thrown it to infinity; it stays where it was at {:g} s; '
                      'check its masses, inertias and springs, and reset the world'.format(
                          saved_s))

    def _say(self, name: str, line: str) -> None:
        self._world.report.about(name).add(NOTE, line)

    def _tried(self, models: Sequence[ModelBodies], states: Dict[FramedBody, BodyState],
               steps: int) -> List[ModelBodies]:
        """Freeze those of some models with which a state becomes large again; return them."""
        found: List[ModelBodies] = []
        for model in models:
            self._freeze(model, states)
        for model in models:
            self._thaw(model)
            self._restore(states)
            self._world.step(steps)
            now = {body: body.state() for body in states}
            if not all(map(_is_small, now.values())):
                found.append(model)
                self._restore(states, [each for each in self._models if any(
                    body in now and not _is_small(now[body]) for body in each.bodies)])
                self._freeze(model, states)
            self._restore(states)
        return found

    def _restore(self, states: Dict[FramedBody, BodyState],
                 again: Iterable[ModelBodies] = ()) -> None:
        """Set states; again: models that are loaded again before."""
        for model in again:
            self._world.load_again(model, freeze=model.bodies[0] in self._frozen)
        for body in self._world.fixed:
            if not _is_finite(body.state()):
                body.reset()
        for body, state in states.items():
            body.restore(state.at_rest() if body in self._frozen else state)

    def _freeze(self, model: ModelBodies, states: Dict[FramedBody, BodyState]) -> None:
        for body in model.bodies:
            if body in states:
                body.restore(states[body].at_rest())
        self._world.load_again(model, freeze=True)
        for body in model.bodies:
            self._frozen[body], body.fixed = body.fixed, True
            if body in states:
                body.restore(states[body].at_rest())

    def _thaw(self, model: ModelBodies) -> None:
        for body in model.bodies:
            body.fixed = self._frozen.pop(body)
        self._world.load_again(model)


def _moves(body: FramedBody) -> bool:
    return bool(body.joints) or not body.fixed


def _is_small(state: BodyState) -> bool:
    return _is_finite(state) and all(
        abs(value) < limit for limit, vectors in ((_FAR_M, state.center[:1]),
                                                  (_FAST, state.velocity))
        for vector in vectors for value in vector)


def _is_finite(state: BodyState) -> bool:
    return all(math.isfinite(value)
               for vector in (state.center[0], *state.velocity, *state.joints)
               for value in vector)
