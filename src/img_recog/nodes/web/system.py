"""What the page shows and does: implemented by node.py and robot.py."""
from typing import Any, Dict, List, Protocol, Tuple

PictureTopic = Tuple[str, str, str]         # topic, key of its title, and color


class Robot(Protocol):
    """One of the robots; methods that wait are called in threads."""

    name: str
    colors: Any
    driving: Any

    def picture_topics(self) -> List[PictureTopic]:
        """Return the pictures of the robot and of the simulator."""

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Move the robot."""

    def propose(self, topic: str, x: float, y: float, color: str) -> Dict[str, int]:
        """Set bounds of a color around that in a picture; return them."""

    def save_colors(self) -> str:
        """Save the parameters of the colors; return the path."""

    def watch(self, page: object, is_watched: bool) -> None:
        """Begin or end to follow the parameters for a page."""


class System(Protocol):
    """What all robots have in common; methods that wait are called in threads."""

    simulator: Any

    def robots(self) -> List[str]:
        """Return the names of the robots, at least one; '' for one without a namespace."""

    def robot(self, name: str) -> Robot:
        """Return the robot of this name, or the first one if there is none."""

    def act(self, action: str) -> None:
        """Call a service of the simulator."""

    def record(self, is_wanted: bool) -> str:
        """Start or stop a recording; return its path."""

    def recording(self) -> str:
        """Return the path of the recording that runs, '' if there is none."""

    def graph(self, is_dark: bool, leaves: bool) -> bytes:
        """Return the graph of nodes and topics as SVG."""

    def watch(self, page: object, is_watched: bool) -> None:
        """Begin or end to follow the simulator's parameters for a page."""
