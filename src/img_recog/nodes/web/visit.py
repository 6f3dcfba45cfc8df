"""What the tabs of a page get to know."""
from typing import List, NamedTuple

from img_recog.nodes.web.shown_robot import PictureTopic, ShownRobot
from img_recog.nodes.web.shown_robots import ShownRobots
from img_recog.nodes.web.page_texts import Texts
from img_recog.nodes.web.tuning import Tuning
from img_recog.processes.bag_recording import RecordingSwitch


class Shared(NamedTuple):
    """What all pages share. simulator: its parameters."""

    robots: ShownRobots
    simulator: Tuning
    recorder: RecordingSwitch


class Visit(NamedTuple):
    """A page of a visitor, for one robot. pictures: those that it can show."""

    shared: Shared
    robot: ShownRobot
    texts: Texts
    pictures: List[PictureTopic]
