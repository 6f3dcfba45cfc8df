"""How well a color is found: in pixels, or in frames."""
from typing import NamedTuple, Tuple


class Score(NamedTuple):
    """How many pixels within bounds, or frames in which a color is recognized, are right.

    found: of the color, and found; wrong: found, but not of the color; missed: of the color, but
    not found.
    """

    found: int
    wrong: int
    missed: int

    @property
    def precision(self) -> float:
        """Share of what was found that is of the color, 0 to 1."""
        return self.found / max(1, self.found + self.wrong)

    @property
    def recall(self) -> float:
        """Share of what is of the color that was found, 0 to 1."""
        return self.found / max(1, self.found + self.missed)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall.

        >>> Score(60, 20, 20).f1
        0.75
        """
        return 2 * self.found / max(1, 2 * self.found + self.wrong + self.missed)

    @property
    def shares(self) -> Tuple[str, str]:
        """Precision and recall as text; dashes if nothing is of the color.

        >>> Score(60, 20, 40).shares, Score(0, 3, 0).shares
        (('75.0%', '60.0%'), ('-', '-'))
        """
        if not self.found + self.missed:
            return '-', '-'
        return '{:.1%}'.format(self.precision), '{:.1%}'.format(self.recall)
