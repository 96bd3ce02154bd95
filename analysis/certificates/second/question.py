"""One theorem applied to one loop and class, and the checks that several theorems share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq_poly

from lure.analysis.certificates.second.axis import Need, holds_from_zero, require_same
from lure.analysis.certificates.second.classes import Claim
from lure.analysis.certificates.second.cover import read_boxes
from lure.analysis.certificates.second.numerics import X, even_odd
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    whole,
)
from lure.analysis.certificates.second.systems import Delayed, Rational, Shifted

# Zames-Falb multipliers as written in a certificate, and whether they are legal for a class of nonlinearities.

Kernel = Fraction | tuple[Fraction, int, int]
SIDES = {"causal": 1, "anticausal": -1}
LARGEST_ORDER = 1000


def read_kernels(multiplier: Mapping[str, object]) -> tuple[Fraction, list[tuple[Fraction, Kernel]]]:
    """``theta`` and the ``c_j`` with their kernels: a delay, or rate, order and side (1 causal, -1 anticausal)."""
    found = record(multiplier, "theta", "kernels")
    kernels: list[tuple[Fraction, Kernel]] = []
    for entry in listed(found["kernels"]):
        if "delay" in mapping(entry):
            given = record(entry, "coefficient", "delay")
            delay = number(given["delay"])
            require(delay != 0, "a kernel has no delay")
            kernels.append((number(given["coefficient"]), delay))
            continue
        given = record(entry, "coefficient", "rate", "order", "side")
        rate, order, side = number(given["rate"]), count(given["order"], least=1), given["side"]
        require(rate > 0 and order <= LARGEST_ORDER, "the rate of a kernel is not positive, or its order too high")
        if not isinstance(side, str) or side not in SIDES:
            raise NotShown("the side of a kernel is neither causal nor anticausal")
        kernels.append((number(given["coefficient"]), (rate, order, SIDES[side])))
    return number(found["theta"]), kernels


def read_taps(multiplier: Mapping[str, object]) -> dict[int, Fraction]:
    """``h_i`` for each shift ``i``, of either sign."""
    taps: dict[int, Fraction] = {}
    for entry in listed(record(multiplier, "taps")["taps"]):
        pair = listed(entry)
        require(len(pair) == 2, "a tap is not a pair")
        shift = count(pair[0], least=-10_000)
        require(shift != 0 and shift not in taps and shift <= 10_000, "a shift is 0, too large or given twice")
        taps[shift] = number(pair[1])
    return taps


def require_legal(
    coefficients: Sequence[Fraction], claim: Claim, *, strict: bool, masses: Sequence[Fraction] | None = None
) -> None:
    """Check the bound on the L1 norm and, unless the nonlinearities are odd, the signs.

    Parameters
    ----------
    coefficients : sequence of Fraction
        ``c_j``, or the taps.
    claim : Claim
        For the class ``finite`` the bound must be strict: ``Re M`` is then bounded away from 0.
    strict : bool
        Whether it must be strict in any case.
    masses : sequence of Fraction, optional
        With a rate, the weighted sums in the place of that of ``|c_j|``.
    """
    mass = sum((abs(c) for c in coefficients), Fraction(0)) if masses is None else max(masses)
    require(mass < 1 or (mass == 1 and not strict and claim.width is not None), "the multiplier is too large in L1")
    require(
        claim.nonlinearities.odd or all(c >= 0 for c in coefficients), "negative coefficients need odd nonlinearities"
    )


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
        See :func:`lure.analysis.certificates.second.axis.holds_from_zero`.
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
    coefficients, limits = [whole(c) for c in listed(found["coefficients"])], numbers(found["limits"])
    first, last = (int(coefficients[i]) if coefficients else 0 for i in (0, -1))
    require(len(limits) == 2, "there are not two limits")
    scale = limits[0] / first if first else Fraction(1)
    require(scale > 0 and limits == [scale * first, scale * last], "the limits are not those of the coefficients")
    positive = list(factors)
    if block.plant is not None:
        even, odd = even_odd(block.plant.hidden)
        positive.append(even * even + X * odd * odd)
    if variable == "omega":
        positive = [factor(X * X) for factor in positive]
    require_same(fmpq_poly(coefficients), own, positive)
