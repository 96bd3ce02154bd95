"""The sentences a certificate may conclude with, and what has to be positive for which upper bound."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from analysis.certificates.second.classes import Laws
from analysis.certificates.second.positivity import Need
from analysis.certificates.second.reading import NotShown

ATTRACTS = "0 attracts every motion"
EQUILIBRIA = "every motion converges to the set of equilibria"
BOUNDED = "every motion is bounded"
DELAYED = "0 attracts every motion with inputs to the block and initial functions of finite energy"
AT_REST = "every motion of finite energy comes to rest, its end at a zero of the law"
GAINS = "every constant gain of the class makes the loop asymptotically stable"
NO_REST = "a loop of the class has a motion that does not converge to an equilibrium"
OTHER_EQUILIBRIA = "a loop of the class has equilibria other than 0"
INEQUALITY = "the frequency inequality holds at every frequency, which alone proves nothing about the rod"
NO_SOLUTION = "a loop of the class is not well posed: 1 + g H(inf) = 0"


@dataclass(frozen=True, kw_only=True, slots=True)
class Claim:
    """A class of laws after the mirror, with a finite lower bound.

    Attributes
    ----------
    laws : Laws
        The class.
    lower : Fraction
        Its lower bound, by which the loop is shifted.
    """

    laws: Laws
    lower: Fraction

    @classmethod
    def of(cls, laws: Laws) -> Claim:
        """The claim of a class.

        Raises
        ------
        NotShown
            The lower bound is infinite.
        """
        if not isinstance(laws.lower, Fraction):
            raise NotShown("the lower bound is infinite")
        return cls(laws=laws, lower=laws.lower)

    @property
    def width(self) -> Fraction | None:
        """``w = k - l``; None for ``finite`` and ``inf``."""
        return self.laws.upper - self.lower if isinstance(self.laws.upper, Fraction) else None

    @property
    def ease(self) -> Fraction:
        """``1/w``, or 0."""
        return Fraction(0) if self.width is None else 1 / self.width

    @property
    def unbounded(self) -> bool:
        """Whether laws without any upper bound are meant."""
        return self.laws.upper == "inf"

    @property
    def need(self) -> Need:
        """What the left-hand side without the excess must satisfy, for a bounded class."""
        return "nonnegative" if self.laws.upper == "finite" else "positive"
