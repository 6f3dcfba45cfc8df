"""The drives of robots, by the names that the setting `drive` has for them."""
from typing import Callable, Dict

from img_recog.model import DIFFERENTIAL, PLANAR
from img_recog.simulation.physics.differential_drive import DifferentialDrive
from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.physics.planar_drive import PlanarDrive
from img_recog.simulation.settings import DriveSettings

_DRIVES: Dict[str, Callable[[DriveSettings], Drive]] = {
    DIFFERENTIAL: DifferentialDrive, PLANAR: PlanarDrive}


def make_drive(settings: DriveSettings) -> Drive:
    """Return the drive; SimulationError when the settings do not fit together."""
    return _DRIVES[settings.drive](settings)
