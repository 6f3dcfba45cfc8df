"""What the command lines of replay.py and film.py have in common."""
from typing import List, Sequence


def without_special_keys(words: Sequence[str]) -> List[str]:
    """Return the arguments without __name:=... and __log:=..., which roslaunch adds."""
    return [word for word in words if not (word.startswith('__') and ':=' in word)]
