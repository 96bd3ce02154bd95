"""One theorem applied to one loop and class, and the checks that several theorems share."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq_poly

from analysis.certificates.second.claims import Claim
from analysis.certificates.second.cover import read_boxes
from analysis.certificates.second.positivity import Need, holds_from_zero, require_same
from analysis.certificates.second.reading import Document, listed, record, require, text, whole
from analysis.certificates.second.shifting import Shifted
from analysis.certificates.second.systems import Delayed, Rational
from analysis.polynomial import X, even_odd


@dataclass(frozen=True, kw_only=True, slots=True)
class Question:
    """One theorem applied to one loop and class."""

    theorem: str
    system: Rational | Delayed
    claim: Claim
    document: Document

    @property
    def direct(self) -> Fraction:
        """``H(inf)`` after the shift by the lower bound."""
        return self.plain_direct / (1 + self.claim.lower * self.plain_direct)

    @property
    def plain_direct(self) -> Fraction:
        """``H(inf)`` as given."""
        return Fraction(0) if isinstance(self.system, Delayed) else self.system.feedthrough


def require_polynomial(
    asked: Question, block: Shifted, inequality: tuple[fmpq_poly, int], need: Need, factors: tuple[fmpq_poly, ...] = ()
) -> None:
    """Check an inequality without delays, by isolated roots; a cover in the file is not needed for it.

    Parameters
    ----------
    asked : Question
        The theorem and the file.
    block : Shifted
        The block after the shift.
    inequality : (fmpq_poly, int)
        Its left-hand side and the degree of one that does not decay.
    need : {"positive", "nonnegative", "decaying"}
        See :func:`analysis.certificates.second.positivity.holds_from_zero`.
    factors : tuple of fmpq_poly
        Positive factors in ``omega^2`` by which the file may differ.

    Raises
    ------
    NotShown
        It fails at some frequency, or the file shows another polynomial.
    """
    if asked.document.proof.get("method") == "cover":
        read_boxes(asked.document.proof)
    else:
        require_written(asked, inequality[0], block, factors)
    require(holds_from_zero(*inequality, need), "the inequality does not hold at every frequency")


def require_written(asked: Question, own: fmpq_poly, block: Shifted, factors: tuple[fmpq_poly, ...]) -> None:
    """Check that the file shows the same polynomial; what is decided here does not rest on it."""
    found = record(asked.document.proof, "method", "variable", "coefficients", "limits")
    require(found["method"] == "polynomial", "the method does not fit the theorem")
    variable = "omega" if asked.theorem == "off-axis-circle" else "omega^2"
    if variable == "omega" and found["variable"] == "omega^2" and not any(own.coeffs()[1::2]):  # an even polynomial
        variable, own = "omega^2", fmpq_poly(own.coeffs()[::2])
    require(found["variable"] == variable, f"the variable is not {variable}")
    for limit in listed(found["limits"]):
        text(limit)
    positive = list(factors)
    if block.plant is not None:
        even, odd = even_odd(block.plant.hidden)
        positive.append(even * even + X * odd * odd)
    if variable == "omega":
        positive = [factor(X * X) for factor in positive]
    require_same(fmpq_poly([whole(c) for c in listed(found["coefficients"])]), own, positive)
