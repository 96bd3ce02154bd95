"""Zames-Falb multipliers as written in a certificate, and whether they are legal for a class of laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from analysis.certificates.second.claims import Claim
from analysis.certificates.second.reading import NotShown, count, listed, mapping, number, record, require

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


def require_legal(coefficients: Sequence[Fraction], claim: Claim, *, strict: bool) -> None:
    """Check the bound on the L1 norm and, unless the laws are odd, the signs.

    Parameters
    ----------
    coefficients : sequence of Fraction
        ``c_j``, or the taps.
    claim : Claim
        For the class ``finite`` the bound must be strict: ``Re M`` is then bounded away from 0.
    strict : bool
        Whether it must be strict in any case.
    """
    mass = sum((abs(c) for c in coefficients), Fraction(0))
    require(mass < 1 or (mass == 1 and not strict and claim.width is not None), "the multiplier is too large in L1")
    require(claim.laws.odd or all(c >= 0 for c in coefficients), "negative coefficients need odd laws")
