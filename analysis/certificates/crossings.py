"""Proofs for certificates that a linear gain between two others puts a root on the imaginary axis."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, fmpq_poly

from analysis.certificates.systems import texts
from analysis.dead_time.criteria import DelayPlant
from analysis.plant import Plant
from analysis.polynomial import exact_midpoint, real_roots
from analysis.precision import ball, working_precision
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.rational import RationalBlock

BITS = 384
WIDTH = 96
SAMPLES = 20_001


@dataclass(frozen=True, slots=True)
class _Curve:
    """``H`` on the axis: ``(Re H, -w Im H)`` at an exact ``w``, and guesses of where it is real."""

    parts: Callable[[Fraction], tuple[arb, arb]]
    guesses: tuple[tuple[Fraction, Fraction], ...]


def crossing_proof(block: RationalBlock | DelayBlock, gains: tuple[Fraction, Fraction]) -> dict[str, Any]:
    r"""The proof by ``crossing``: ``Im H`` changes sign between two frequencies, there ``-1/Re H`` is between gains.

    ``1 + g H(i omega) = 0`` at the frequency where ``Im H = 0``, for ``g = -1/Re H`` there.  In discrete time
    ``z = (1 + i omega)/(1 - i omega)``.

    Parameters
    ----------
    block : RationalBlock or DelayBlock
        The block.
    gains : tuple of Fraction
        Two gains with such a one strictly between them.

    Returns
    -------
    dict
        ``proof`` of the certificate, the frequencies so close to each other that the gain stays between the two.

    Raises
    ------
    AssumptionError
        No such frequency was found.

    Notes
    -----
    Where the curve ``H`` only touches the real axis, ``Im H`` has a double root between the frequencies and changes
    no sign; a polynomial is then decided by Sturm's theorem.
    """
    with working_precision(BITS):
        curve = _delayed(block) if isinstance(block, DelayBlock) else _rational(block)
        for a, b in curve.guesses:
            for low, high in _narrowed(curve, a, b):
                ends = [-1 / curve.parts(omega)[0] for omega in (low, high)]
                if all(ball(gains[0]) < end < ball(gains[1]) for end in ends):
                    return {"method": "crossing", "gains": texts(gains), "frequencies": texts((low, high))}
    raise AssumptionError(f"no root on the axis was found for gains between {float(gains[0])} and {float(gains[1])}")


def _narrowed(curve: _Curve, a: Fraction, b: Fraction) -> Iterator[tuple[Fraction, Fraction]]:
    """The interval after bisection, if ``Im H`` changes sign on it; else as it is."""
    sign = curve.parts(a)[1] > 0
    if not curve.parts(a)[1] * curve.parts(b)[1] < 0:
        yield a, b
        return
    while (b - a) * 2**WIDTH > b:
        middle = (a + b) / 2
        slope = curve.parts(middle)[1]
        if not (slope > 0 or slope < 0):
            break
        a, b = (middle, b) if (slope > 0) == sign else (a, middle)
    yield a, b


def _rational(block: RationalBlock) -> _Curve:
    plant = Plant.of(block)
    response = plant.response()

    def at(p: fmpq_poly, x: arb) -> arb:
        """``p(x)``."""
        value = arb(0)
        for c in reversed(p.coeffs()):
            value = value * x + arb(c)
        return value

    def parts(omega: Fraction) -> tuple[arb, arb]:
        """``Re H`` and ``-omega Im H``."""
        x = ball(omega * omega)
        return at(response.U, x) / at(response.D, x), at(response.W, x) / at(response.D, x)

    roots = [exact_midpoint(x.sqrt()) for x in real_roots(response.W) if x > 0] if response.W.degree() > 0 else []
    return _Curve(parts, tuple((_short(w * (1 - e)), _short(w * (1 + e))) for w in roots for e in _MARGINS))


_MARGINS = (Fraction(1, 2**WIDTH), Fraction(1, 2**40), Fraction(1, 2**20))


def _delayed(block: DelayBlock) -> _Curve:
    plant = DelayPlant.of(block)
    start = plant.start
    omega = np.union1d(
        np.geomspace(start * 1e-6, 64 * start, 4 * SAMPLES), np.linspace(start / SAMPLES, start, SAMPLES)
    )
    values = block.transfer(1j * omega)
    turns = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    ordered = sorted((i for i in turns.tolist() if values.real[i] < 0), key=lambda i: float(values.real[i]))
    guesses = tuple((Fraction(float(omega[i])), Fraction(float(omega[i + 1]))) for i in ordered[:8])
    return _Curve(lambda w: plant.response.parts(ball(w)), guesses)


def _short(value: Fraction) -> Fraction:
    """A rational near a positive one, of little more than ``WIDTH`` binary digits."""
    shift = WIDTH + 24 - math.frexp(float(value))[1]
    return Fraction(round(value * Fraction(2) ** shift)) / Fraction(2) ** shift
