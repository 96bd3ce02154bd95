r"""Periodic solutions of a loop with one play or stop: a balance of the first harmonic, then Newton's method.

With ``sigma = a cos(omega t)`` and the half-width 1 the stop has the describing function ``N(a)``, the play ``1 -
N(a)``: ``xi`` goes with ``sigma`` from 1 to -1, for ``cos(omega t_1) = 1 - 2/a``, and stays there.  ``1 + g N(a) H(i
omega) = 0`` gives slopes ``g``; from the least of them on the exact pieces are solved for, and followed to the
least slope that has a solution.  Nothing here is believed: a checker encloses them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from lure.analysis.counterexamples.channel_orbits import LADDER, SHARES, Course
from lure.analysis.deadline import checkpoint
from lure.arrays import Complexes, Reals, np

_AMPLITUDES, _FREQUENCIES, _PHASES, _KEPT = 80, 400, 2000, 6
_ABOVE = (1.002, 1.01, 1.03, 1.1, 1.3)
_STEPS, _LEAST_STEP = 40, 2e-4


class Guess(NamedTuple):
    """A slope, an amplitude and a frequency of the first harmonic."""

    slope: float
    amplitude: float
    omega: float


class MemoryLoop(NamedTuple):
    """``x' = A x + b mu``, ``sigma = c x``, ``mu = -phi``.

    Attributes
    ----------
    A : list of lists of Fraction
        (n, n).
    b, c : list of Fraction
        (n,).
    stop : bool
        Whether a stop; else a play.
    """

    A: list[list[Fraction]]
    b: list[Fraction]
    c: list[Fraction]
    stop: bool

    def stays(self, slope: Fraction) -> list[tuple[list[list[Fraction]], list[Fraction]]]:
        """``G`` and ``entry`` of both parts, ``(x, xi, 1)' = G (x, xi, 1)``.

        Parameters
        ----------
        slope : Fraction
            Of the play or stop.
        """
        zero, n = Fraction(0), len(self.A)
        sign = Fraction(-1 if self.stop else 1)
        rows = [
            [
                *(v - (0 if self.stop else b * slope * u) for v, u in zip(row, self.c, strict=True)),
                sign * b * slope,
                zero,
            ]
            for row, b in zip(self.A, self.b, strict=True)
        ]
        rate = [sum((u * row[k] for u, row in zip(self.c, rows, strict=True)), zero) for k in range(n + 2)]
        still = [zero] * (n + 2)
        return [([*rows, rate, still], rate), ([*rows, still, still], [*still[2:], Fraction(1), Fraction(1)])]

    def guesses(self) -> list[Guess]:
        """Balances of the first harmonic, the least slopes first."""
        A, b, c = np.array(self.A, dtype=float), np.array(self.b, dtype=float), np.array(self.c, dtype=float)
        amplitudes = 1 + np.geomspace(1e-3, 1e3, _AMPLITUDES)
        N = _describing(amplitudes)
        N = N if self.stop else 1 - N
        poles = np.abs(np.linalg.eigvals(A))
        omega = np.geomspace(max(poles.min(), 1e-9) / 100, max(poles.max(), 1e-9) * 100, _FREQUENCIES)
        H = np.array([c @ np.linalg.solve(1j * w * np.eye(len(A)) - A, b) for w in omega])
        loop = N[:, None] * H[None, :]
        crossing = (loop.imag[:, 1:] * loop.imag[:, :-1] < 0) & (loop.real[:, 1:] < 0)
        found = list[Guess]()
        for i, j in np.argwhere(crossing):
            share = loop.imag[i, j] / (loop.imag[i, j] - loop.imag[i, j + 1])
            size = abs(loop.real[i, j] + share * (loop.real[i, j + 1] - loop.real[i, j]))
            found.append(
                Guess(float(1 / size), float(amplitudes[i]), float(omega[j] + share * (omega[j + 1] - omega[j])))
            )
        found.sort(key=lambda one: one.slope)
        return found

    def begun(self, guess: Guess) -> tuple[list[Fraction], list[Fraction]]:
        """First state, ``xi`` included, and durations of a balance.

        Parameters
        ----------
        guess : Guess
            The balance.
        """
        A, b = np.array(self.A, dtype=float), np.array(self.b, dtype=float)
        N = _describing(np.array([guess.amplitude]))[0]
        phi = guess.slope * guess.amplitude * (N if self.stop else 1 - N)
        x = np.linalg.solve(1j * guess.omega * np.eye(len(A)) - A, -b * phi).real
        first = math.acos(1 - 2 / guess.amplitude)
        durations = [first / guess.omega, (math.pi - first) / guess.omega]
        return [*(Fraction(float(v)) for v in x), Fraction(1)], [Fraction(v) for v in durations]

    def course(self, slope: Fraction, state: list[Fraction], durations: list[Fraction]) -> Course | None:
        """The solution near a first state and durations; None if there is none, or not of this shape.

        Parameters
        ----------
        slope : Fraction
            The slope.
        state, durations : list of Fraction
            (n + 1,) and (2,).
        """
        checkpoint()
        found = Course(self.stays(slope), state, durations, half=True).closed()
        return found if found is not None and abs(float(found.state[-1]) - 1) < 1e-6 else None

    def least(self, known: float, most: float) -> Iterator[tuple[Fraction, Course]]:
        """Slopes between two with a solution each, the least found first.

        Parameters
        ----------
        known, most : float
            A slope up to which there is none, and one above which none is sought.
        """
        tried = [one for one in self.guesses() if one.slope < most * 2]
        for guess in tried[:: max(1, len(tried) // _KEPT)][:_KEPT]:
            state, durations = self.begun(guess)
            for above in _ABOVE:
                slope = _short(max(guess.slope, known) * above)
                one = self.course(slope, state, durations)
                if one is not None:
                    found = self._followed(slope, one, known)
                    yield from ((g, course) for g, course in reversed(found) if known < g < most)
                    break

    def _followed(self, slope: Fraction, one: Course, known: float) -> list[tuple[Fraction, Course]]:
        """Solutions for ever smaller slopes."""
        found, step = [(slope, one)], 0.05
        for _ in range(_STEPS):
            smaller = _short(float(slope) * (1 - step))
            near = self.course(smaller, list(one.state), list(one.durations)) if smaller > known else None
            change = (
                1.0
                if near is None
                else max(abs(float(u / v) - 1) for u, v in zip(near.durations, one.durations, strict=True))
            )
            if near is not None and change < 0.5:
                slope, one = smaller, near
                found.append((slope, one))
            else:
                step /= 2
                if step < _LEAST_STEP:
                    break
        return found


def memory_proofs(course: Course, gains: list[Fraction]) -> Iterator[dict[str, Any]]:
    """Proofs by ``memory-orbit``, with numbers of more and more digits.

    Parameters
    ----------
    course : Course
        The solution.
    gains : list of Fraction
        One for each channel, the slope of the play or stop among them.
    """
    for bits in LADDER[:2]:
        numbers = course.numbers(bits)
        for share in SHARES:
            around = {"radius": str(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            yield {"method": "memory-orbit", "gains": [*map(str, gains)], **numbers, **around}


def _describing(amplitudes: Reals) -> Complexes:
    """The describing function of the stop of half-width 1 and slope 1, of amplitudes above 1."""
    theta = (np.arange(_PHASES) + 0.5) * (math.pi / _PHASES)
    xi = np.maximum(1 - amplitudes[:, None] * (1 - np.cos(theta)), -1.0)
    return np.asarray(2 / _PHASES * (xi * np.exp(-1j * theta)).sum(axis=1) / amplitudes)


def _short(value: float) -> Fraction:
    return Fraction(f"{value:.9g}")
