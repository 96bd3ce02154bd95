"""Multipliers of Zames and Falb with kernels whose L1 norm is known exactly, and the Popov term beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError

Side = Literal["causal", "anticausal"]


@dataclass(frozen=True, slots=True)
class Delay:
    r"""A unit mass at ``delay``: ``h(t) = delta(t - delay)``, ``h^(iw) = exp(-i w delay)``.

    Parameters
    ----------
    delay : Fraction
        Positive: the multiplier looks back (causal); negative: it looks ahead [s].  Not zero.
    """

    delay: Fraction

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response, in floating point; ``omega`` in rad/s."""
        return np.asarray(np.exp(-1j * float(self.delay) * omega))

    def __str__(self) -> str:
        return f"exp({-float(self.delay):+.6g} s)"


@dataclass(frozen=True, slots=True)
class Gamma:
    r"""A gamma density, nonnegative and of mass 1: ``h(t) = a^n t^(n-1) exp(-a t)/(n-1)!``, ``h^(s) = (a/(a + s))^n``.

    Parameters
    ----------
    rate : Fraction
        ``a > 0`` [1/s].
    order : int
        ``n >= 1``.
    side : {"causal", "anticausal"}
        ``anticausal`` mirrors it to ``t < 0``: ``h^(s) = (a/(a - s))^n``.
    """

    rate: Fraction
    order: int
    side: Side

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response, in floating point; ``omega`` in rad/s."""
        sign = 1 if self.side == "causal" else -1
        return np.asarray((1 / (1 + sign * 1j * omega / float(self.rate))) ** self.order)

    def __str__(self) -> str:
        power = "" if self.order == 1 else f"^{self.order}"
        return f"({float(self.rate):.6g}/({float(self.rate):.6g} {'+' if self.side == 'causal' else '-'} s)){power}"


Kernel = Delay | Gamma


@dataclass(frozen=True, slots=True)
class Multiplier:
    r"""``M(s) + theta s`` with ``M = 1 - sum_j c_j h_j^(s)``, every kernel ``h_j >= 0`` of mass 1.

    The L1 norm (total variation, where masses are) of ``sum c_j h_j`` is at most ``sum |c_j|``, with equality if no
    two terms of opposite sign overlap.

    Parameters
    ----------
    theta : Fraction
        Weight of the Popov term, of either sign [s].
    terms : tuple of (Fraction, Kernel)
        Coefficients ``c_j`` and kernels ``h_j``.
    """

    theta: Fraction
    terms: tuple[tuple[Fraction, Kernel], ...]

    @property
    def mass(self) -> Fraction:
        """``sum |c_j|``, the bound on the L1 norm."""
        return sum((abs(c) for c, _ in self.terms), Fraction(0))

    def admissible(self, *, odd: bool) -> bool:
        """Whether the multiplier is legal: mass at most 1, and no negative coefficient unless the laws are odd."""
        legal = all(
            kernel.delay != 0 if isinstance(kernel, Delay) else kernel.rate > 0 and kernel.order >= 1
            for _, kernel in self.terms
        )
        return legal and self.mass <= 1 and (odd or all(c >= 0 for c, _ in self.terms))

    def at(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """``M(i w)`` without the Popov term, in floating point; ``omega`` in rad/s."""
        points = np.asarray(omega, dtype=float)
        total = np.ones(points.shape, dtype=complex)
        for c, kernel in self.terms:
            total -= float(c) * kernel.at(points)
        return total

    def scaled(self, unit: Fraction) -> Multiplier:
        """The same multiplier when frequencies are multiplied by ``unit``: ``M(s / unit)``."""
        terms = tuple(
            (
                c,
                Delay(kernel.delay / unit)
                if isinstance(kernel, Delay)
                else Gamma(kernel.rate * unit, kernel.order, kernel.side),
            )
            for c, kernel in self.terms
        )
        return Multiplier(self.theta / unit, terms)

    def mirrored(self) -> Multiplier:
        """``M(-s) - theta s``: causal and anticausal exchanged, as for ``H(-s)``."""
        terms: list[tuple[Fraction, Kernel]] = []
        for c, kernel in self.terms:
            if isinstance(kernel, Delay):
                terms.append((c, Delay(-kernel.delay)))
            else:
                side: Side = "anticausal" if kernel.side == "causal" else "causal"
                terms.append((c, Gamma(kernel.rate, kernel.order, side)))
        return Multiplier(-self.theta, tuple(terms))

    def __str__(self) -> str:
        text = "1"
        for c, kernel in self.terms:
            text += f" {'-' if c > 0 else '+'} {abs(float(c)):.6g} {kernel}"
        if self.theta:
            text += f" {'+' if self.theta > 0 else '-'} {abs(float(self.theta)):.6g} s"
        return text

    def to_parameters(self) -> dict[str, object]:
        """Plain data with exact numbers as text ``p/q``; :func:`multiplier_of` reads them back."""
        return {"theta": str(self.theta), "kernels": [_written(c, kernel) for c, kernel in self.terms]}


def multiplier_of(parameters: Mapping[str, object]) -> Multiplier:
    """The multiplier written by :meth:`Multiplier.to_parameters`.

    Parameters
    ----------
    parameters : Mapping
        With ``theta`` and ``kernels``; other keys are left alone.

    Raises
    ------
    InputError
        A key is missing, or a value is not what it should be.
    """
    try:
        entries = list(parameters["kernels"])  # type: ignore[call-overload]  # caught below
        return Multiplier(Fraction(str(parameters["theta"])), tuple(_read(entry) for entry in entries))
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        raise InputError(
            f"parameters are {dict(parameters)!r}; give theta as text p/q and kernels as a list of "
            "{coefficient, delay} or {coefficient, rate, order, side}"
        ) from None


def _written(c: Fraction, kernel: Kernel) -> dict[str, object]:
    if isinstance(kernel, Delay):
        return {"coefficient": str(c), "delay": str(kernel.delay)}
    return {"coefficient": str(c), "rate": str(kernel.rate), "order": kernel.order, "side": kernel.side}


def _read(entry: Mapping[str, object]) -> tuple[Fraction, Kernel]:
    c = Fraction(str(entry["coefficient"]))
    if "delay" in entry:
        return c, Delay(Fraction(str(entry["delay"])))
    side = entry["side"]
    if side not in ("causal", "anticausal"):
        raise ValueError(side)
    return c, Gamma(
        Fraction(str(entry["rate"])), int(str(entry["order"])), "causal" if side == "causal" else "anticausal"
    )
