"""The parameters that can be changed while the simulation runs."""
from dataclasses import dataclass

from img_recog.settings import Settings, one_of, setting
from img_recog.simulation.settings import REAL_TIME_FACTORS, VIEWS


@dataclass(frozen=True)
class RuntimeSettings(Settings):
    """Parameters that dynamic_reconfigure changes; see PhysicsSettings and ViewSettings."""

    real_time_factor: float = setting(
        1.0, REAL_TIME_FACTORS, 'simulated seconds per second of wall time; 0: no limit')
    view: str = setting('above', one_of(*VIEWS), 'viewpoint of ~view/image_raw')


def timeout_scale(real_time_factor: float) -> float:
    """Return how many times longer timeouts in simulated time are, to be as long in wall time.

    Like demo.launch: never shorter, and for "as fast as possible" 100 times.
    """
    return min(100.0, max(1.0, real_time_factor or 100.0))
