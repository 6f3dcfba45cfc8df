"""What is said of several times that were measured."""
import statistics
from typing import List


def seconds(values: List[float]) -> List[str]:
    """Return count, median and maximum of some times in seconds."""
    if not values:
        return ['0', '', '']
    return [str(len(values)), '{:.2f}'.format(statistics.median(values)),
            '{:.2f}'.format(max(values))]
