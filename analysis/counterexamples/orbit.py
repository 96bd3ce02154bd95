"""Periodic orbits of discrete-time loops, exact: steady states, the record of an orbit, and its independent check."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import cast

from flint import fmpq_mat

from lure.analysis.numerics.doubles import double_above
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.verdict import Evidence, Witness
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.rational import RationalPlant
from lure.record import described, quantity
from lure.record.values import exact_text

# Nonlinearities through finitely many points, exact: which slopes and which sector they have.

Point = tuple[Fraction, Fraction]


@described(frozen=True, slots=True)
class PiecewiseLinear:
    r"""``phi`` linear between the points, and of slope ``tail`` outside them."""

    points: tuple[Point, ...] = quantity("In ascending ``sigma``, one of them ``(0, 0)``")
    tail: Fraction = quantity("Slope to the left of the first and to the right of the last point")

    @classmethod
    def through(cls, points: Iterable[Sequence[Fraction]], tail: Fraction, *, odd: bool = False) -> PiecewiseLinear:
        """The nonlinearity through the points and ``(0, 0)``, for ``odd`` also through the mirrored points.

        Raises
        ------
        InputError
            Two points have the same ``sigma`` but not the same ``phi``: no nonlinearity passes through both.
        """
        given = {(Fraction(s), Fraction(w)) for s, w in points} | {(Fraction(0), Fraction(0))}
        if odd:
            given |= {(-s, -w) for s, w in given}
        ordered = tuple(sorted(given))
        for (s, w), (t, v) in itertools.pairwise(ordered):
            if s == t:
                raise InputError(
                    f"no nonlinearity passes through both ({s}, {w}) and ({t}, {v}); give one value for each sigma"
                )
        return cls(ordered, Fraction(tail))

    @property
    def slopes(self) -> tuple[Fraction, Fraction]:
        """Least and largest difference quotient of the nonlinearity."""
        steps = [(v - w) / (t - s) for (s, w), (t, v) in itertools.pairwise(self.points)]
        return min([self.tail, *steps]), max([self.tail, *steps])

    @property
    def sector(self) -> tuple[Fraction, Fraction]:
        """Least and largest ``phi(sigma)/sigma``: attained at a point, next to zero or in the limit of a tail."""
        chords = [w / s for s, w in self.points if s != 0]
        ends = [self.tail, *chords] if chords else [self.tail]
        return min(ends), max(ends)

    @property
    def odd(self) -> bool:
        """Whether ``phi(-sigma) = -phi(sigma)``."""
        return {(-s, -w) for s, w in self.points} == set(self.points)

    def __call__(self, sigma: Fraction) -> Fraction:
        """``phi(sigma)``, exact."""
        place = bisect.bisect_left(self.points, (sigma,))
        if place == 0 or place == len(self.points):
            s, w = self.points[0 if place == 0 else -1]
            return w + self.tail * (sigma - s)
        (s, w), (t, v) = self.points[place - 1], self.points[place]
        return w + (v - w) * (sigma - s) / (t - s)


def shifted_block(block: RationalPlant, lower: Fraction) -> RationalPlant:
    """The block of the loop for ``phi - lower sigma``: ``n / (d + lower n)``."""
    pad = len(block.denominator) - len(block.numerator)
    top = (Fraction(0),) * pad + block.numerator
    return RationalPlant(
        block.numerator, [d + lower * n for d, n in zip(block.denominator, top, strict=True)], block.dt
    )


def steady_state_map(block: RationalPlant, q: int, *, twist: int = 1) -> fmpq_mat | None:
    r"""The map from an input to the output of the same period: ``sigma = G u`` if ``u[t + q] = twist * u[t]``.

    With ``H = n/d`` the difference equation ``sum d_j sigma[t-j] = sum n_j u[t-j]`` reads ``C_d sigma = C_n u`` with
    (twisted) circulants, so that ``G = C_d^-1 C_n``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    q : int
        Number of samples.
    twist : {1, -1}
        1: period ``q``; -1: period ``2 q`` with the second half the negative of the first.

    Returns
    -------
    fmpq_mat or None
        (q, q); None if the block has a pole where ``z^q = twist``.
    """
    short_by = len(block.denominator) - len(block.numerator)
    output = _circulant(block.denominator, q, twist)
    drive = _circulant((Fraction(0),) * short_by + block.numerator, q, twist)
    try:
        return output.solve(drive)
    except ZeroDivisionError:
        return None


def _circulant(coefficients: Sequence[Fraction], q: int, twist: int) -> fmpq_mat:
    folded = [Fraction(0)] * q  # z^-q = twist
    for j, c in enumerate(coefficients):
        folded[j % q] += c * twist ** (j // q)
    return fmpq_mat([[to_fmpq(folded[(t - i) % q] * (1 if i <= t else twist)) for i in range(q)] for t in range(q)])


def steady_state(block: RationalPlant, u: Sequence[Fraction]) -> list[Fraction]:
    """The output of period ``len(u)`` under the input ``u`` repeated.

    Raises
    ------
    AssumptionError
        The block has a pole at a root of unity of that order: the output need not be periodic.
    """
    response = steady_state_map(block, len(u))
    if response is None:
        raise AssumptionError(
            f"the block has a pole with z^{len(u)} = 1, so an input of period {len(u)} has no one periodic output; "
            "shift the loop by a gain first (lower > 0)",
            code=Reason.CRITICAL,
        )
    column = response * fmpq_mat([[to_fmpq(value)] for value in u])
    return [to_fraction(column[i, 0]) for i in range(len(u))]


def orbit_witness(
    block: RationalPlant,
    nonlinearity: PiecewiseLinear,
    u: Sequence[Fraction],
    sigma: Sequence[Fraction],
    *,
    slope_restricted: bool = True,
) -> Witness:
    """The witness of an orbit ``mu[t] = u[t % p]``, ``sigma[t] = sigma[t % p]``, if it is one: checked exactly.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    nonlinearity : PiecewiseLinear
        The nonlinearity; its ``tail`` is the lower bound of the class.
    u, sigma : sequence of Fraction
        One period of ``mu``, not zero, and of ``sigma``.
    slope_restricted : bool
        Whether the class meant is that of slopes in ``[tail, k]``, or only the sector.

    Raises
    ------
    InputError
        It is no orbit, or the nonlinearity does not have the lower bound.
    """
    low, k = nonlinearity.slopes if slope_restricted else nonlinearity.sector
    record: dict[str, object] = {
        "k": str(k),
        "lower": str(nonlinearity.tail),
        "period": len(u),
        "odd": nonlinearity.odd,
        "slope_restricted": slope_restricted,
        "points": [[str(s), str(w)] for s, w in nonlinearity.points],
        "u": [str(value) for value in u],
        "sigma": [str(value) for value in sigma],
    }
    for t, (s, value) in enumerate(zip(sigma, u, strict=True)):
        if nonlinearity(s) != -value:
            raise InputError(
                f"no orbit: sample {t} has sigma = {s} and mu = {value}, but -phi(sigma) = {-nonlinearity(s)}; "
                "give exact numbers (Fraction or text p/q)"
            )
    if low < nonlinearity.tail or not verify_periodic_discrete(block, record):
        raise InputError(
            f"no destabilising orbit in the class [{nonlinearity.tail}, {k}]: its nonlinearity has the least "
            f"{'slope' if slope_restricted else 'sector bound'} {low}, or the orbit is zero or not well posed",
            code=Reason.ILL_POSED,
        )
    kind = "slope" if slope_restricted else "sector"
    description = (
        f"{'odd ' if nonlinearity.odd else ''}piecewise linear phi of {kind} [{exact_text(nonlinearity.tail, 10)}, "
        f"{exact_text(k, 10)}] through {len(nonlinearity.points)} points: an orbit of period {len(u)} samples, exact"
    )
    return Witness(
        kind="periodic orbit",
        k=double_above(k),
        evidence=Evidence.CERTIFIED,
        slope_restricted=slope_restricted,
        odd=nonlinearity.odd,
        description=description,
        data=record,
    )


def verify_periodic_discrete(block: RationalPlant, data: Mapping[str, object]) -> bool:
    r"""Whether a record is a destabilising orbit, from the record alone and in exact arithmetic.

    Checks that the signals have the stated period and are not zero; that they satisfy the difference equation
    ``sum d_j sigma[t-j] = sum n_j u[t-j]`` at each sample, step by step; that each ``(sigma, -u)`` is a point of the
    list, which holds ``(0, 0)``, one value for each ``sigma`` and, for ``odd``, all mirrored points; that the
    nonlinearity linear between the points and of slope ``lower`` outside has its slopes (or only its chords from zero,
    if the record is not ``slope_restricted``) in ``[lower, k]``; and that ``1 + g D > 0`` for every gain ``g`` of the
    class, or ``< 0`` for every one.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    data : Mapping
        As in ``Witness.data`` of kind ``periodic orbit``: numbers as text ``p/q``.

    Returns
    -------
    bool
        False also if an entry is missing or is not a number.
    """
    try:
        k, lower = Fraction(cast("str", data["k"])), Fraction(cast("str", data["lower"]))
        u, sigma = ([Fraction(value) for value in cast("list[str]", data[name])] for name in ("u", "sigma"))
        points = [(Fraction(s), Fraction(w)) for s, w in cast("list[list[str]]", data["points"])]
        period, odd, sloped = data["period"], data["odd"], data["slope_restricted"]
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return False
    if block.dt is None or not len(u) == len(sigma) == period or not any(u) or not lower < k:
        return False
    if (1 + lower * block.feedthrough) * (1 + k * block.feedthrough) <= 0:
        return False
    on_nonlinearity = set(points)
    if len({s for s, _ in on_nonlinearity}) < len(on_nonlinearity) or (Fraction(0), Fraction(0)) not in on_nonlinearity:
        return False
    if odd is not False and any((-s, -w) not in on_nonlinearity for s, w in on_nonlinearity):
        return False
    if any((s, -value) not in on_nonlinearity for s, value in zip(sigma, u, strict=True)):
        return False
    return _satisfies(block, u, sigma) and _in_class(sorted(on_nonlinearity), (lower, k), sloped=sloped is not False)


def _satisfies(block: RationalPlant, u: Sequence[Fraction], sigma: Sequence[Fraction]) -> bool:
    """The difference equation over one period, stepped from its own past."""
    p, n = len(u), block.order
    top = (Fraction(0),) * (n + 1 - len(block.numerator)) + block.numerator
    for t in range(p):
        pushed = sum((top[j] * u[(t - j) % p] for j in range(n + 1)), Fraction(0))
        pulled = sum((block.denominator[j] * sigma[(t - j) % p] for j in range(1, n + 1)), Fraction(0))
        if pushed - pulled != block.denominator[0] * sigma[t]:
            return False
    return True


def _in_class(points: Sequence[tuple[Fraction, Fraction]], bounds: tuple[Fraction, Fraction], *, sloped: bool) -> bool:
    """Every pair of points, or every point with zero, against the quadratic form of the class."""
    lower, k = bounds
    zero = (Fraction(0), Fraction(0))
    pairs = ((a, b) for a in points for b in (points if sloped else [zero]))
    return all(((w - v) - lower * (s - r)) * (k * (s - r) - (w - v)) >= 0 for (s, w), (r, v) in pairs)


def accept_orbit(
    block: RationalPlant,
    points: Sequence[Sequence[Fraction | int | str]],
    u: Sequence[Fraction | int | str],
    *,
    lower: Fraction = Fraction(0),
) -> Witness:
    r"""A given nonlinearity and orbit as a witness, if they are one.

    The nonlinearity is linear between the points and of slope ``lower`` outside them; ``mu = u`` repeats, ``sigma = H
    mu`` is its periodic response.  Certified: every comparison is exact.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    points : sequence of (sigma, phi)
        Exact numbers; ``(0, 0)`` may be left out, mirrored points may not.
    u : sequence
        One period of ``mu``; text such as ``"192/415"`` is exact.
    lower : Fraction
        Lower bound of the slopes.

    Raises
    ------
    InputError
        The block is in continuous time, a number is not exact text or rational, or nonlinearity and orbit do not fit.
    AssumptionError
        The block has a pole at a root of unity of the period's order.

    Examples
    --------
    >>> H = RationalPlant([2, Fraction(23, 25)], [1, Fraction(-1, 2), 0], dt=1)
    >>> points = [("-74498/72625", "-192/415"), ("-36864/72625", "-192/415"), ("192/175", 1)]
    >>> accept_orbit(H, points, ["192/415", "192/415", -1]).data["k"]
    '175/192'
    """
    if block.dt is None:
        raise InputError("accept_orbit needs a block in discrete time; give dt")
    try:
        listed = [(Fraction(s), Fraction(w)) for s, w in points]
        drive = [Fraction(value) for value in u]
    except (TypeError, ValueError, ZeroDivisionError) as error:
        raise InputError(f"points and u need exact numbers, as Fraction or text p/q: {error}") from None
    if not drive:
        raise InputError("u is empty; give one period of mu")
    return orbit_witness(block, PiecewiseLinear.through(listed, Fraction(lower)), drive, steady_state(block, drive))
