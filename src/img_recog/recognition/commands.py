"""Areas to commands."""
from typing import List, Sequence

from img_recog.recognition.settings import ColorRule


def commands(areas_px: Sequence[int], rules: Sequence[ColorRule]) -> List[float]:
    """Return linear.x in m/s for each rule whose area is above its limit, in the rules' order.

    areas_px: one area a rule. No colour in view gives no command at all: stopping is left to
    whoever else commands the robot (in the article, the idle teleop).
    """
    return [rule.linear_x for rule, area_px in zip(rules, areas_px)
            if area_px > rule.area_limit_px]
