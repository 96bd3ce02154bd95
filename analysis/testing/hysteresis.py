"""A law with memory that stays in a sector: one graph while the input rises, another while it falls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from analysis.testing.numbers import strategies as st
from lure.laws import PiecewiseLinear
from lure.sector import Sector


@dataclass(frozen=True, kw_only=True, slots=True)
class HystereticLaw:
    """``phi = rising(sigma)`` after ``sigma`` has grown, ``falling(sigma)`` after it has fallen.

    Not a law of :mod:`lure.laws`, which have no memory; what covers it is a theorem for the sector alone, without
    time-invariance, such as the circle criterion.

    Attributes
    ----------
    rising, falling : PiecewiseLinear
        The two graphs.
    """

    rising: PiecewiseLinear
    falling: PiecewiseLinear

    @property
    def sector(self) -> Sector:
        """The smallest sector that contains both graphs."""
        first, second = self.rising.graph.sector, self.falling.graph.sector
        return Sector(min(first.lower, second.lower), max(first.upper, second.upper))

    def respond(self, sigma: Sequence[Fraction]) -> Fraction:
        """The value after a history of inputs, exactly; an input that repeats the last takes the graph for falling.

        Parameters
        ----------
        sigma : sequence of Fraction
            The inputs up to now, the last one being the present; before the first the input was 0.
        """
        now, before = sigma[-1], sigma[-2] if len(sigma) > 1 else Fraction(0)
        return (self.rising if now > before else self.falling).exact(now)


def hysteretic(graphs: st.SearchStrategy[PiecewiseLinear]) -> st.SearchStrategy[HystereticLaw]:
    """Hysteretic laws from two graphs of a class.

    Parameters
    ----------
    graphs : SearchStrategy of PiecewiseLinear
        The class.
    """
    return st.builds(HystereticLaw, rising=graphs, falling=graphs)
