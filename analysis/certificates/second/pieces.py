r"""Multipliers by pieces of the axis, checked again: pivots in balls, by Taylor's formula on ever shorter intervals.

After the shift by the lower bounds, of delays by the gain 1, ``F = Y + Y^*`` with rows of ``Y``

.. math:: \lambda (e_i + w H_i) + s \theta H_i, \qquad (x + i y)(e_i + w H_i), \qquad
    (y e^{-i \omega h/2} - x) H_i + x e_i/2,

of functions, of what is linear and does not depend on time, and of delays up to ``h``.  On a piece each pivot of ``F``
is a ball; from the last frequency on entries are functions of ``1/omega``, analytic at 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import pairwise, product

from flint import acb, acb_mat, acb_series, arb, fmpq, fmpq_mat, fmpq_poly, fmpq_series

from lure.analysis.certificates.second.channels import Asked, acyclic
from lure.analysis.certificates.second.classes import DELAYS
from lure.analysis.certificates.second.frequencies import Matrices
from lure.analysis.certificates.second.late_loops import NONE, Arriving, Kernels, LateLoop, grown
from lure.analysis.certificates.second.numerics import (
    SERIES_TERMS,
    X,
    ball,
    half_plane_counts,
    taylor,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.reading import Document, NotShown, listed, numbers, record, require, tick
from lure.analysis.certificates.second.zero import require_one_solution, shifted_by

_BITS, _MOST, _NARROWEST, _DOUBLINGS, _PHASES, _HALVINGS, _CUTS, _SMALL = 192, 20_000, 2**70, 6, 500, 40, 16, 2**20
_TURNS, _SHARE = 16, 8  # times as many where phases go together; of an arc, as wide as all frequencies beyond the last
_TURN, _HALF = Fraction(6283185, 10**6), Fraction(3141593, 10**6)  # below 2 pi, above pi


@dataclass(frozen=True, slots=True)
class _Channel:
    kind: str  # "", "free", "delay" or "slow"
    width: Fraction
    weight: Fraction
    theta: Fraction
    rate: Fraction = Fraction(0)
    low: Fraction = Fraction(0)  # beside dead times: of the bounds, less what the channel is shifted by
    shift: Fraction = Fraction(0)
    kernels: Kernels = NONE


Balls = list[list[list[acb]]]
_Series = Callable[[acb_series], list[list[acb_series]] | None]  # F of a frequency
_Row = Sequence[tuple[Fraction, Fraction] | None]  # multipliers of the channels on a piece


@dataclass(frozen=True, slots=True)
class _Loop:
    """``N/d`` of the shifted loop, ascending in ``s`` or ``z``, or far out in ``1/omega`` times ``i^n``."""

    d: list[acb]
    N: Balls
    turned: Balls  # of s N/d, where Popov's terms are
    discrete: bool
    far: bool
    late: tuple[tuple[arb, Balls, Balls], ...] = ()  # dead times, and what arrives so late of N and of s N
    closed: LateLoop | None = None  # in place of all these
    plant: LateLoop | None = None  # far out, where its states come back late


def require_pieces(document: Document, asked: Asked) -> bool:
    """Check that the loop without delay is stable at the lower bounds, and ``F > 0`` on every piece of the axis.

    Whether there are poles at 0 in that loop.

    ``asked``: the plant and its classes, constant delays among them.

    Raises
    ------
    NotShown
        It is not so, or a multiplier is none for its channel.
    """
    known, rows, ends = _read(document, asked)
    m = len(known)
    bounds = [(Fraction(1), Fraction(2)) if one.operator in DELAYS else one.ends for one in asked.nonlinearities]
    closed, gains = None, [one.shift for one in known]
    if asked.late:
        require(not (asked.rates and asked.operators), "a neutral equation has functions and constant gains alone")
        bounds = [(Fraction(0), Fraction(1))] * m
    if any(gains) or asked.inner:
        closed = LateLoop.of(asked, gains)
    shifted = shifted_by(asked, [(low, high) for low, high in bounds if low is not None and high is not None])
    resting, stable = False, asked.discrete or half_plane_counts(shifted[0].charpoly()).left == asked.A.nrows()
    require(stable or bool(asked.late), "no stable loop")
    require(not asked.discrete or _inside(shifted[0].charpoly()), "the loop without delay is not stable")
    d, N = numerators(shifted)
    later = [(tau, numerators((shifted[0], shifted[1], C, 0 * shifted[3]))[1]) for tau, C in asked.late]

    def balls(*, near: bool) -> _Loop:
        """The loop near 0, or far out."""
        if near:
            late = tuple((ball(tau), _larger(_balls(part), asked, tau), [list[list[acb]]()]) for tau, part in later)
            return _Loop(
                [acb(arb(c)) for c in d.coeffs()], _balls(N), [[]], asked.discrete, far=False, late=late, closed=closed
            )
        n = d.degree()

        def outward(part: Sequence[Sequence[fmpq_poly]]) -> tuple[Balls, Balls]:
            """A part of ``N``, and of ``s N`` where that is asked for."""
            turned = [
                [_reversed(f * X, n) if one.theta or one.kind == "slow" else [acb(0)] for f in line]
                for one, line in zip(known, part, strict=True)
            ]
            return [[_reversed(f, n) for f in line] for line in part], turned

        sides = [(tau, *outward(part)) for tau, part in later]
        late = tuple((ball(tau), _larger(part, asked, tau), _larger(moved, asked, tau)) for tau, part, moved in sides)
        plant = LateLoop.of(asked, [Fraction(0)] * m) if asked.inner else None
        return _Loop(_reversed(d, n), *outward(N), discrete=False, far=True, late=late, plant=plant)

    with working_precision(_BITS):
        near, start = balls(near=True), Fraction(0)
        if asked.late and (closed is not None or not stable):
            loop = LateLoop.of(asked, gains) if closed is None else closed
            resting = not asked.pace and bool(loop.at_rest() == 0)
            if resting:
                start = _past_zero(asked, known, loop, ends[0])
            else:
                require(loop.right_roots() == 0, "the loop with constant gains is not stable")
        for row, (a, b) in zip(rows, pairwise([start, *ends]), strict=False):
            _require_piece(partial(_series, near, known, row), a, b)
        if not asked.discrete:
            outer, end = balls(near=False), ends[-1]
            ways = [outer]
            if len(asked.late) > 1 and any(one.theta for one in known):  # else phases far out hardly matter
                ways.append(replace(outer, plant=replace(LateLoop.of(asked, [Fraction(0)] * m), together=True)))
            while asked.late and not any(_at_any_phase(way, known, rows[-1], 1 / end) for way in ways):
                require(end < ends[-1] * 2**_DOUBLINGS, "F > 0 is not shown far out")
                _require_piece(partial(_series, near, known, rows[-1]), end, 2 * end)
                end *= 2
            if not asked.late:
                _require_piece(partial(_series, outer, known, rows[-1]), Fraction(0), 1 / end)
    return resting


def _read(document: Document, asked: Asked) -> tuple[list[_Channel], list[_Row], list[Fraction]]:
    """The channels, the multipliers of each piece and where the pieces end, if they are such of these classes."""
    moved = document.theorem == "late-zames-falb"
    popov = moved or document.theorem == "piecewise-popov"
    given = record(document.multiplier, "lambda", "kernels" if moved else "pieces", *(["theta"] if popov else []))
    proof = record(document.proof, "method", "ends")
    m, weights = asked.D.nrows(), numbers(given["lambda"])
    theta, ends = numbers(given["theta"]) if popov else [Fraction(0)] * m, numbers(proof["ends"])
    require(proof["method"] == "pieces" and len(weights) == len(theta) == m, "there is not one multiplier a channel")
    require(not (popov and asked.discrete), "Popov's criterion is for continuous time")
    far = not (asked.discrete or asked.late or any(one.operator in DELAYS for one in asked.nonlinearities))
    if not acyclic(asked) and not far:  # else the last piece says it of differences, as constant weights do
        sides = [one.ends for one in asked.nonlinearities if not one.operator]
        plain = [(low, high) for low, high in sides if low is not None and high is not None]
        require(len(plain) == m, "D has a cycle of channels beside operators, or of such without bounds")
        require_one_solution(asked, plain)
    known = _channels(asked, weights, theta)
    if moved:
        known = [_with_kernels(asked, known, given["kernels"])]
    pieces = [[None]] * (len(ends) + 1) if moved else listed(given["pieces"])
    rows: list[_Row] = [[_pair(one) for one in listed(row)] for row in pieces]
    require(all(len(row) == m for row in rows), "a piece has not one multiplier for each channel")
    require(len(rows) == len(ends) + (not asked.discrete), "there is not one multiplier for each piece")
    require(all(a < b for a, b in pairwise([Fraction(0), *ends])), "the pieces do not follow one another")
    require(not asked.discrete or ends[-1] >= _HALF, "the pieces end before pi")
    for i, one in enumerate(known):
        same = one.kind != "slow" or all(row[i] == rows[0][i] for row in rows)
        require(same, "a delay that varies has several multipliers")
    for k, row in enumerate(rows):
        _require_row(asked, known, row, ends[k] if k < len(ends) else None)
    return known, rows, ends


def _past_zero(asked: Asked, known: Sequence[_Channel], loop: LateLoop, end: Fraction) -> Fraction:
    """A frequency up to which ``F > 0`` where 0 is a root of ``chi`` ``r`` times, ``s H = G`` with the limit ``R``.

    ``Lambda W R`` is symmetric, so that ``F`` is the Hermitian part of ``Lambda + Lambda W (G - R)/s + Theta G``, and
    more for rows of ``R`` that are 0.  ``chi/s^r`` is a mean of values of ``chi^(r)/r!``, and so are the derivatives.

    Raises
    ------
    NotShown
        There is none, or the theorem is not for these poles, classes or multipliers.
    """
    m, theirs = len(known), asked.nonlinearities
    most = SERIES_TERMS + 1 + m
    with working_precision(_BITS, most):
        chi, N = loop.at_zero()
    zeros = next((k for k in range(m + 1) if chi[k] != 0), m + 1)
    for one, class_ in zip(known, theirs, strict=True):
        plain = one.kind == "" and one.theta >= 0 and 0 in (one.theta, one.low) and not class_.operator
        require(not one.kernels.terms, "beside kernels and dead times an eigenvalue 0 is not covered")
        require(plain, "beside dead times an eigenvalue 0 is covered for functions, theta >= 0, 0 if not in [0, u]")
    require(asked.pace is None and not asked.rates, "with a rate, or in neutral equations, no pole lies at 0")
    require(zeros <= m and loop.right_roots(zeros) == 0, "the plant is not stable")
    simple = all(f[k] == 0 for row in N for f in row for k in range(zeros - 1))
    require(simple, "H has a pole of higher order at 0")
    R = [[f[zeros - 1] / chi[zeros] for f in row] for row in N]
    varying = any(class_.time_varying for class_ in theirs)
    for i, row in enumerate(R):
        if any(v != 0 for v in row):
            require(known[i].low == 0 and not theirs[i].time_varying, "what shows the pole is no function in [0, u]")
            require(not varying or not asked.has_direct_term(i), "what shows the pole is no function of the states")
    S = fmpq_mat([[to_fmpq(one.weight * one.width) * v for v in row] for one, row in zip(known, R, strict=True)])
    require(S.transpose() == S and S.rank() == zeros, "Lambda W R is not symmetric, or has another rank")
    p = S.charpoly()  # of real roots: none is negative if its signs alternate
    require(all(p[m - k] * (-1) ** k >= 0 for k in range(m + 1)), "Lambda W R has a negative eigenvalue")
    for _ in range(_HALVINGS):
        tick()
        parts = [ball(end * k / _CUTS).union(ball(end * (k + 1) / _CUTS)) for k in range(_CUTS)]
        with working_precision(_BITS, most):
            wide = [loop.adjugate(acb_series([acb(0, omega), acb(1)])) for omega in parts]
        bottom = _ascending(chi, [below for below, _ in wide], zeros)
        tops = [[_ascending(N[i][j], [M[i][j] for _, M in wide], zeros - 1) for j in range(m)] for i in range(m)]
        left = [abs(f[-1]) * ball(end) ** SERIES_TERMS for f in (bottom, *(f for line in tops for f in line))]
        if all(v < abs(bottom[0]) / _SMALL for v in left):
            with suppress(NotShown):
                _require_piece(partial(_near_zero, known, R, bottom, tops), Fraction(0), end)
                return end
        end /= 2
    raise NotShown("F > 0 is not shown near 0")


def _ascending(exact: fmpq_series, wide: Sequence[acb_series], skipped: int) -> list[acb]:
    """Of ``f/s^k`` the Taylor coefficients at 0, the last a mean of those elsewhere, on some parts."""
    last = skipped + SERIES_TERMS
    rest = wide[0][last]
    for one in wide[1:]:
        rest = rest.union(one[last])
    return [*(acb(arb(exact[k])) for k in range(skipped, last)), rest]


def _near_zero(
    known: Sequence[_Channel],
    R: Sequence[Sequence[fmpq]],
    bottom: list[acb],
    tops: list[list[list[acb]]],
    t: acb_series,
) -> list[list[acb_series]] | None:
    """``F`` as series in ``omega`` near 0, without what is skew and has a pole there; None if ``chi`` may vanish."""
    m, s = len(known), t * acb(0, 1)
    Y, squares, below = list[list[acb_series]](), list[tuple[list[acb_series], arb]](), _at(bottom, s)
    if below[0].contains(0):
        return None
    for i, one in enumerate(known):
        low = one.low * (one.low + one.width)
        rest = [
            _at([p - acb(arb(r)) * q for p, q in zip(f[1:], bottom[1:], strict=True)], s) / below
            for f, r in zip(tops[i], R[i], strict=True)
        ]  # (G - R)/s
        whole = s * ball(one.theta) + acb(ball(one.weight * (one.width + 2 * one.low)))
        Y.append([h * whole + acb(arb(r) * ball(one.theta)) for h, r in zip(rest, R[i], strict=True)])
        Y[i][i] += acb(ball(one.weight))
        if low:
            squares.append((rest, ball(-2 * one.weight * low)))
    F = [[Y[i][j] + _conjugate(Y[j][i]) for j in range(m)] for i in range(m)]
    for row, weight in squares:
        F = [[f - _conjugate(row[i]) * row[j] * weight for j, f in enumerate(line)] for i, line in enumerate(F)]
    return F


def _pair(value: object) -> tuple[Fraction, Fraction] | None:
    if value is None:
        return None
    pair = numbers(value)
    require(len(pair) == 2, "a multiplier is no pair")
    return pair[0], pair[1]


def _channels(asked: Asked, weights: Sequence[Fraction], theta: Sequence[Fraction]) -> list[_Channel]:
    """What multiplies each channel, if its multipliers are such of its class."""
    found = []
    for i, one in enumerate(asked.nonlinearities):
        low, high = one.ends
        single = list(asked.repeated).count(asked.repeated[i]) == 1
        gain = one.linear and not one.time_varying and single
        kind = "free" if one.operator == "linear time-invariant" or gain else ""
        if one.operator in DELAYS:
            kind = "slow" if one.time_varying else "delay"
        late = kind in ("delay", "slow")
        known = one.rate is not None or bool(asked.late)  # else it is taken out
        require(kind != "slow" or (known and not asked.discrete), "a delay changes too fast")
        require(not one.rough and (late or None not in (low, high)), "a channel has no finite bounds")
        require(weights[i] >= 0 and (kind == "" or weights[i] == theta[i] == 0), "a weight does not fit its channel")
        fixed = not (one.time_varying or one.operator or asked.has_direct_term(i))
        require(theta[i] == 0 or fixed, "Popov's term does not fit its channel")
        if asked.pace and theta[i] != 0:  # |psi sigma - 2 int psi| <= psi (sigma - psi/w), times theta a
            outweighs = weights[i] * ((high or Fraction(0)) - (low or Fraction(0))) >= abs(theta[i] * asked.pace)
            inside = low is not None and high is not None and one.slopes_within(low, high)
            require(inside and outweighs, "Popov's term with a rate needs slopes within the bounds, and lambda")
        width = one.upper if late else (high or Fraction(0)) - (low or Fraction(0))
        require(isinstance(width, Fraction) and width > 0, "a channel has no finite bounds")
        slope = one.rate if kind == "slow" and one.rate is not None else Fraction(0)
        bounds = (Fraction(1), Fraction(1)) if late else (low or Fraction(0), high or Fraction(0))
        shift = min(max(bounds[0], Fraction(0)), bounds[1]) if asked.late else bounds[0]
        found.append(
            _Channel(kind, Fraction(width), weights[i], theta[i], slope, bounds[0] - shift, shift * bool(asked.late))
        )
    for block in asked.operators:
        require(all(weights[i] == weights[block[0]] for i in block), "an operator has several weights")
    require(not asked.performance or weights[-1] > 0, "the weight of the performance channel is not positive")
    return found


def _with_kernels(asked: Asked, known: Sequence[_Channel], value: object) -> _Channel:
    """The one channel, ``M = lambda - sum c h`` in place of ``lambda``, for slopes within its bounds.

    ``int v(t) e(t - T) dt`` is at most ``int v e``, for odd functions at least ``-int v e``, where ``e`` and ``v`` do
    not decrease with ``sigma``: ``v = phi - l sigma`` and ``e = u sigma - phi``.
    """
    require(bool(asked.late) and not asked.pace and len(known) == 1, "kernels beside dead times are of one channel")
    one, theirs, kernels = known[0], asked.nonlinearities[0], Kernels.read(value)
    plain, (low, high) = not (theirs.operator or theirs.time_varying or theirs.memory or one.kind), theirs.ends
    require(plain, "kernels are of a function that does not depend on time")
    require(low is not None and high is not None and theirs.slopes_within(low, high), "slopes leave the bounds")
    require(kernels.mass <= one.weight, "the kernels outweigh lambda")
    require(kernels.monotone or theirs.odd, "a kernel is negative, and the function need not be odd")
    return replace(one, kernels=kernels)


def _require_row(asked: Asked, known: Sequence[_Channel], row: _Row, end: Fraction | None) -> None:
    """Check the signs of one piece, which ends at ``end``."""
    for i, (one, pair) in enumerate(zip(known, row, strict=True)):
        require((pair is None) is (one.kind == ""), "a multiplier by pieces does not fit its channel")
        if pair is None:
            continue
        x, y = pair
        smooth = not asked.discrete and all(asked.D[i, j] == 0 for j in range(len(known)))
        require(x >= 0 or (one.kind == "delay" and smooth), "x is negative")
        if one.kind == "delay":
            short = end is not None and end * one.width <= _TURN
            require(y == 0 or (y > 0 and short), "the chord of a delay is none there")
        elif one.kind == "slow":
            require(y == 0 or (y > 0 and smooth), "y is negative, or sigma no function of the state alone")
            require(x == 0 or asked.nonlinearities[i].rate is not None, "a delay changes too fast")
        else:
            require(y == 0 or asked.nonlinearities[i].operator == "", "the multiplier of an operator is not real")
    for block in asked.operators:
        require(
            asked.nonlinearities[block[0]].operator in DELAYS or all(row[i] == row[block[0]] for i in block),
            "an operator has several multipliers",
        )


def _inside(p: fmpq_poly) -> bool:
    """Whether all roots lie in the open unit disc: those of ``(1 - s)^n p((1 + s)/(1 - s))`` in the left half-plane."""
    n, up, down = p.degree(), fmpq_poly([1, 1]), fmpq_poly([1, -1])
    total = fmpq_poly([])
    for k in range(n + 1):
        total += p[k] * up**k * down ** (n - k)
    return total.degree() == n and half_plane_counts(total).left == n


def numerators(shifted: Matrices) -> tuple[fmpq_poly, list[list[fmpq_poly]]]:
    """``d = det(s - A)`` and ``N = d H``: ``det(s - A + b_j c_i) - d + D_ij d``."""
    A, B, C, D = shifted
    d, m, n = A.charpoly(), D.nrows(), A.nrows()
    rows = list[list[fmpq_poly]]()
    for i in range(m):
        line = list[fmpq_poly]()
        for j in range(m):
            tick()
            moved = A - fmpq_mat([[B[k, j] * C[i, h] for h in range(n)] for k in range(n)])
            line.append(moved.charpoly() - d + D[i, j] * d)
        rows.append(line)
    return d, rows


def _balls(N: Sequence[Sequence[fmpq_poly]]) -> list[list[list[acb]]]:
    return [[[acb(arb(c)) for c in f.coeffs()] or [acb(0)] for f in row] for row in N]


def _larger(N: Balls, asked: Asked, tau: Fraction) -> Balls:
    """What arrives so late of the solutions times ``e^(a t)``."""
    return [[[c * grown(asked.pace, tau) for c in f] for f in row] for row in N]


def _reversed(p: fmpq_poly, n: int) -> list[acb]:
    """``u^n p(i/u)``, ascending in ``u``."""
    require(p.degree() <= n, "an output with a Popov term has a direct one")
    return [acb(arb(p[n - k])) * acb(0, 1) ** (n - k) for k in range(n + 1)]


def _require_piece(series: _Series, low: Fraction, high: Fraction) -> None:
    """Check ``F > 0`` from ``low`` to ``high``, of ``omega`` or of ``1/omega``."""
    stack, narrow, looked_at = [(low, high)], (high - low) / _NARROWEST, 0
    while stack:
        tick()
        looked_at += 1
        require(looked_at < _MOST, "F > 0 is not shown on a piece")
        a, b = stack.pop()
        if _positive(series, a, b):
            continue
        require(b - a > narrow, "F > 0 is not shown on a piece")
        middle = (a + b) / 2
        stack += [(a, middle), (middle, b)]


def _positive(series: _Series, a: Fraction, b: Fraction) -> bool:
    """Whether ``F > 0`` is shown on ``[a, b]``: each pivot of its elimination is, as a function of the frequency."""
    middle, radius = ball((a + b) / 2), ball((b - a) / 2).upper()
    here = series(acb_series([acb(middle), acb(1)]))
    wide = series(acb_series([acb(ball(a).union(ball(b))), acb(1)]))
    if here is None or wide is None:
        return False
    m = len(here)
    for k in range(m):
        pivot = taylor(here[k][k], wide[k][k], radius)
        if not pivot.real > 0:
            require(not here[k][k][0].real < 0, "F > 0 is not shown on a piece")  # it is not, on any part of it
            return False
        wide[k][k] = acb_series([pivot, *(wide[k][k][h] for h in range(1, SERIES_TERMS))])
        for side in (here, wide):
            for i in range(k + 1, m):
                factor = side[i][k] / side[k][k]
                side[i] = [v - factor * u for v, u in zip(side[i], side[k], strict=True)]
    return True


def _at_any_phase(loop: _Loop, known: Sequence[_Channel], row: _Row, most: Fraction) -> bool:
    """Whether ``F > 0`` for ``1/omega`` in ``[0, most]`` whatever phases the dead times give.

    With ``Y = Y_0 + sum w_k Y_k``, ``|w_k| = 1``, ``x^* F x`` is at least the form of ``|x|`` with ``2 Re Y_0 - 2 sum
    |Y_k|`` on the diagonal and less ``|Y_0 + Y_0^*| + sum |Y_k| + |Y_k'|`` beside it; less what is quadratic in ``H``.
    """
    steps = loop.plant.steps if loop.plant is not None else []
    stack = [((Fraction(0), most), *[(Fraction(0), Fraction(1))] * bool(steps))]
    for _ in range(_PHASES * (_TURNS if steps else 1)):
        tick()
        if not stack:
            return True
        (a, b), *turn = sides = stack.pop()
        u, arcs = ball(a).union(ball(b)), [(start * k, end * k) for start, end in turn for k in steps]
        arriving = loop.plant.at_any_phase(u, arcs) if loop.plant is not None else _arriving(loop, u)
        if arriving is None or not _above(arriving, known, row, u):
            at = [(start + end) / 2 * k for start, end in turn for k in steps]
            here = loop.plant.at_any_phase(ball(a), [(v, v) for v in at]) if loop.plant and turn else arriving
            if turn and (here is None or not _above(here, known, row, ball(a))):
                return False  # at one frequency and phase
            wide = [(b - a) / most / _SHARE, *((end - start) * max(steps) for start, end in turn)]
            k = wide.index(max(wide))
            start, end = sides[k]
            middle = (start + end) / 2
            stack += [(*sides[:k], half, *sides[k + 1 :]) for half in ((start, middle), (middle, end))]
    return False


def _above(arriving: Arriving, known: Sequence[_Channel], row: _Row, u: arb) -> bool:
    """Whether the form of ``|x|`` is positive definite there, in ``mu`` before any shift: ``(e + l H)* x (e + u H)``.

    Of delays ``x (|mu|^2 - |sigma|^2)``, of slow ones ``x |mu|^2 - x |sigma|^2/(1 - d) + y |mu + sigma|^2 - y h^2
    |sigma'|^2``.
    """
    m = len(known)
    first, late = [[acb(0)] * m for _ in known], [[arb(0)] * m for _ in known]
    less = [[arb(0)] * m for _ in known]
    for i, (one, pair) in enumerate(zip(known, row, strict=True)):
        direct = one.kernels.far(one.weight, u) if pair is None else acb(ball(pair[0]), ball(pair[1]))
        low, squares = one.low + one.shift, [arb(0), arb(0)]
        factor = direct * ball(one.width) + direct.real * ball(2 * low)
        square = direct.real * ball(2 * low * (low + one.width))
        squares[0] = -square.lower() if square < 0 else square.abs_upper() if not square >= 0 else arb(0)
        if one.kind in ("delay", "slow") and pair is not None:
            x, y = map(ball, pair)
            direct, factor = acb((x + y if one.kind == "slow" else x) / 2), acb(y)
            squares = [(x * ball(1 / (1 - one.rate))).abs_upper(), y * ball(one.width**2) * bool(one.kind == "slow")]
        sizes, rates = [arb(0)] * m, [arb(0)] * m
        for k, (plain, turned, *most) in enumerate(arriving):
            for j in range(m):
                h = plain[i, j]
                value = factor * h + (turned[i, j] * ball(one.theta) if one.theta else 0)
                sizes[j] += min(h.abs_upper(), *(size[i, j].upper() for size in most)) if most else h.abs_upper()
                if squares[1] > 0:
                    rates[j] += turned[i, j].abs_upper()
                if k:
                    late[i][j] += value.abs_upper()
                else:
                    first[i][j] += value
        first[i][i] += direct
        # |sigma| is at least what comes at once less the rest
        if m == 1 and square > 0 and one.kind not in ("delay", "slow"):
            left = arriving[0][0][0, 0].abs_lower() - sum((h[0][0, 0].abs_upper() for h in arriving[1:]), arb(0))
            less[0][0] -= (square.lower() * left * left).lower() if left > 0 else 0
        for j, k in product(range(m), repeat=2):
            less[j][k] += squares[0] * sizes[j] * sizes[k] + squares[1] * rates[j] * rates[k]
    rows = [
        [
            2 * (first[i][i].real - late[i][i]) - less[i][i]
            if i == j
            else -((first[i][j] + first[j][i].conjugate()).abs_upper() + late[i][j] + late[j][i] + less[i][j])
            for j in range(m)
        ]
        for i in range(m)
    ]
    for k in range(m):
        if not rows[k][k] > 0:
            return False
        for i in range(k + 1, m):
            factor_ik = rows[i][k] / rows[k][k]
            rows[i] = [v - factor_ik * w for v, w in zip(rows[i], rows[k], strict=True)]
    return True


def _arriving(loop: _Loop, u: arb) -> Arriving | None:
    """``H`` and ``s H`` without dead time, and with each; None if ``d`` may vanish."""
    below = _value(loop.d, acb(u))
    if below.contains(0):
        return None

    def over(side: Balls) -> acb_mat:
        """These numerators over ``d``."""
        return acb_mat([[_value(f, acb(u)) / below for f in row] for row in side])

    return [(over(loop.N), over(loop.turned)), *((over(part), over(moved)) for _, part, moved in loop.late)]


def _value(coefficients: Sequence[acb], s: acb) -> acb:
    total = acb(0)
    for c in reversed(coefficients):
        total = total * s + c
    return total


def _series(loop: _Loop, known: Sequence[_Channel], row: _Row, t: acb_series) -> list[list[acb_series]] | None:
    """``F`` as series in ``omega``, or in ``1/omega``; None if ``d`` may vanish.

    Less ``x d/(1 - d) H_i^* H_i + y h^2 (s H_i)^* (s H_i)`` for the slow delays.
    """
    s = t if loop.far else (t * acb(0, 1)).exp() if loop.discrete else t * acb(0, 1)
    below, whole = _at(loop.d, s), loop.closed.response(s) if loop.closed else None
    if whole is None and (loop.closed or below[0].contains(0)):
        return None
    found, squares = list[list[acb_series]](), list[tuple[list[acb_series], arb | acb_series]]()
    waits = [(s * -tau).exp() for tau, _, _ in loop.late]

    def outputs(i: int, *, turned: bool) -> list[acb_series]:
        """A row of ``H``, or of ``s H``."""
        if turned and not loop.far:
            return [s * h for h in outputs(i, turned=False)]
        if whole is not None:
            return whole[i]
        line = [_at(f, s) / below for f in (loop.turned if turned else loop.N)[i]]
        for wait, (_, part, moved) in zip(waits, loop.late, strict=True):
            line = [h + wait * _at(f, s) / below for h, f in zip(line, (moved if turned else part)[i], strict=True)]
        return line

    for i, (one, pair) in enumerate(zip(known, row, strict=True)):
        H, M = outputs(i, turned=False), None
        if one.kind in ("delay", "slow") and pair is not None:
            x, y = map(ball, pair)
            turn, direct = acb(-x), acb((x + y if one.kind == "slow" else x) / 2)
            factor = 0 * t + turn
            if one.kind == "slow":
                moved = outputs(i, turned=True)
                squares.append((H, x * ball(one.rate / (1 - one.rate))))
                squares.append((moved, y * ball(one.width**2)))
            if pair[1] and one.kind == "delay":
                factor = factor + (t * acb(0, -1) * ball(one.width / 2)).exp() * y
        elif one.kernels.terms:
            M = one.kernels.near(one.weight, s)
            twice = M + _conjugate(M)
            direct, factor = acb(0), M * ball(one.width) + twice * ball(one.low)
            squares.append((H, twice * ball(-one.low * (one.low + one.width))))
        else:
            direct = acb(ball(one.weight)) if pair is None else acb(ball(pair[0]), ball(pair[1]))
            factor = 0 * t + direct * ball(one.width)
            if one.low:  # (e + l H)* x (e + u H): e* x (l + u) H, and x l u H* H
                factor = factor + direct.real * ball(2 * one.low)
                squares.append((H, direct.real * ball(-2 * one.low * (one.low + one.width))))
        line = [factor * h for h in H]
        line[i] = line[i] + (direct if M is None else M)
        if one.theta:
            line = [f + h * ball(one.theta) for f, h in zip(line, outputs(i, turned=True), strict=True)]
        found.append(line)
    both = range(len(found))
    F = [[found[i][j] + _conjugate(found[j][i]) for j in both] for i in both]
    for side, weight in squares:
        F = [[f - _conjugate(side[i]) * side[j] * weight for j, f in enumerate(row)] for i, row in enumerate(F)]
    return F


def _conjugate(f: acb_series) -> acb_series:
    """The conjugate of a function of a real variable."""
    return acb_series([f[k].conjugate() for k in range(SERIES_TERMS)])


def _at(coefficients: Sequence[acb], s: acb_series) -> acb_series:
    total = 0 * s
    for c in reversed(coefficients):
        total = total * s + c
    return total
