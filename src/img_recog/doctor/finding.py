"""What a check has found."""
from typing import NamedTuple


class Finding(NamedTuple):
    """Something that is wrong, and what to do about it.

    is_note: it may be meant to be so.
    """

    problem: str
    advice: str
    is_note: bool = False
