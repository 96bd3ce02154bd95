"""Several nonlinearities on pieces of the frequency axis, where there are delays or dead times: part of the checker.

Standard library only.  Signs of sums of ``omega^n e^(-i omega tau)`` are shown in balls.  Every function raises
``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import ceil, factorial
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import blocks
from .arithmetic import ZERO, Critical, form, need
from .balls import WORD, Lift, above, box, dot, outward, right_zeros, tail, turning
from .frequencies import chained, quotient, shifted, signed, transfer

TAYLOR = 12  # of the exponentials on a piece
FEW_DOUBLINGS, MOST_PRODUCTS = 12, 8
Rows = list[list[Fraction]]


class Member(NamedTuple):
    """What multiplies one channel: constant weights, or with ``kind`` "scaled", "delay", "slow" numbers of each piece.

    After the shift by the lower bound, of a delay the gain 1: ``psi = -mu`` against ``width sigma - psi``; for a delay
    up to ``bound`` ``w = -mu = sigma(t - tau) - sigma``; of a slow one, ``tau' <= d``, the width is ``d/(1 - d)``.
    Shifted by another gain of the class ``phi - l sigma`` against ``u sigma - phi``, ``low = l <= 0 <= u``.  With
    kernels ``M`` in place of the weight is ``acting/over``, the latter ``> 0`` and of the degree ``rise``.
    """

    kind: str
    width: Fraction
    weight: Fraction
    theta: Fraction
    bound: Fraction
    low: Fraction = ZERO
    acting: exact.Form | None = None
    over: exact.Form = exact.real(1)
    rise: int = 0


class Axis(NamedTuple):
    """``d``, ``N``, ``|d|^2`` and ``N d^*`` on the axis, the loop being ``N/d`` after the shift, of order ``n``.

    With a pace ``a`` each ``exp(-s tau)`` of ``d`` and ``N`` stands for ``exp(a tau) exp(-s tau)``, of their products
    with conjugates on an interval alone.
    """

    d: Any  # a form, or what stands for it on an interval
    bare: list[list[Any]]
    own: Any
    seen: list[list[Any]]
    moved: list[list[Any]]  # s N d^*, of channels with Popov's terms
    order: int
    members: list[Member]
    late: bool
    pace: Fraction | None

    def over(self, near: Any) -> Axis:
        """With what stands for ``d`` and ``N`` on an interval."""
        d, bare = near(self.d), [[near(f) for f in row] for row in self.bare]
        back, turning = d.conjugate(), [row if one.theta else [] for one, row in zip(self.members, self.bare)]
        moved = [[near(exact.S * f) * back for f in row] for row in turning]
        return self._replace(d=d, bare=bare, own=d * back, seen=[[f * back for f in row] for row in bare], moved=moved)


def base(low: Fraction, high: Fraction) -> Fraction:
    """The gain by which a channel is shifted beside dead times: 0, or what is next to it in the bounds."""
    return min(max(low, ZERO), high)


def with_kernels(one: Member, given: Any, odd: bool) -> Member:
    """A function with ``M = lambda - sum c h``: kernels ``h >= 0`` of mass 1, ``c >= 0`` unless it is odd.

    ``sum |c| <= lambda``.  Each ``h = (a/(a +- s))^n`` is ``(1 -+ s/a)^n`` over ``(1 + omega^2/a^2)^n``.
    """
    plain = isinstance(given, list) and all(isinstance(item, dict) and "delay" not in item for item in given)
    form(plain, "kernels are a list, each with a rate")
    _, terms = blocks.kernels({"theta": "0", "kernels": given}, False)
    top = {a: max(n for _, _, b, n in terms if b == a) for _, _, a, _ in terms}
    over = acting = exact.real(1)
    for a, n in top.items():
        over = over * exact.real(1, 0, 1 / a**2) ** n
    acting = over * exact.real(one.weight)
    for c, h, a, n in terms:
        beside = exact.real(-c / a ** (2 * n))
        for b, k in top.items():
            beside = beside * exact.real(1, 0, 1 / b**2) ** (k - n * (b == a))
        acting = acting + h * beside
    need(sum((abs(c) for c, *_ in terms), ZERO) <= one.weight, "lambda is less than the masses of the kernels")
    need(odd or all(c >= 0 for c, *_ in terms), "M has a kernel below 0, and the nonlinearity need not be odd")
    return one._replace(acting=acting, over=over, rise=2 * sum(top.values()))


def axis_of(H: Any, low: list[Fraction], members: list[Member]) -> Axis:
    """The loop after the shift by ``low``, on the imaginary axis or the unit circle."""
    d, bare = quotients(H, low)
    return Axis(d, bare, d, bare, [], len(H.A), members, bool(H.late), H.pace).over(lambda f: f)


def quotients(H: Any, low: list[Fraction]) -> tuple[exact.Form, list[list[exact.Form]]]:
    """``d`` and ``N`` of the loop ``N/d`` after the shift by ``low``, on the axis."""
    if H.inner or (H.late and any(low)):
        chi, seen = looped(H, low)
        return on_line(chi), [[on_line(f) for f in row] for row in seen]
    A, B, C, D = H[:4] if H.late else shifted(H, low)
    d, parts = transfer_parts(H._replace(A=A, B=B, C=C, D=D))
    bare = [[exact.Form() for _ in D] for _ in D]
    for tau, N in parts:
        wait = exact.Form({(tau, 0): (Fraction(1), ZERO)}) if tau else exact.real(1)
        bare = [[f + wait * on_axis(g, H.discrete) for f, g in zip(*rows)] for rows in zip(bare, N)]
    return on_axis(d, H.discrete), bare


def transfer_parts(H: Any) -> tuple[list[int], list[tuple[Fraction, Any]]]:
    """``d``, and ``N_tau`` of each dead time, 0 first: ``H = sum e^(-s tau) N_tau/d``.

    Of ``rates`` ``D_T x' = D_T A x + D_T B mu``.
    """
    need(not (H.pace and H.rates), "in neutral equations no rates are shown")
    m, C, D = len(H.D), [*H.C], [*H.D]
    rates = [moved for moved, _ in H.rates] or [[[ZERO] * len(H.A)] * m] * len(H.late)
    for (_, rows), moved in zip(H.late, rates):
        C += [[v + dot(rate, column) for v, column in zip(row, zip(*H.A))] for row, rate in zip(rows, moved)]
        D += [[dot(rate, column) for column in zip(*H.B)] for rate in moved]
    d, N = transfer(H.A, H.B, C, D)
    return d, [(tau, N[k * m : (k + 1) * m]) for k, tau in enumerate([ZERO, *(tau for tau, _ in H.late)])]


def looped(H: Any, low: list[Fraction]) -> tuple[exact.Form, list[list[exact.Form]]]:
    """``chi`` and ``N``: the plant with dead times and ``mu = w - L sigma`` is ``N/chi``, sums of ``s^n e^(-s tau)``.

    ``chi = det(s - A) det(1 + H L)``; forms in ``s`` here.  By Cramer's rule, each determinant of ``d + N L`` having
    the factor ``d^(m - 1)``.  States that come back late do so through channels of their own, :func:`opened`.
    """
    own_channels, (H, inner) = range(len(H.D)), opened(H)
    low = low + inner
    m, (d, parts) = len(H.D), transfer_parts(H)
    own = exact.real(*d)
    N = [[exact.Form() for _ in range(m)] for _ in range(m)]
    for tau, seen in parts:
        wait = exact.Form({(tau, 0): (Fraction(1), ZERO)}) if tau else exact.real(1)
        N = [[f + wait * exact.real(*g) for f, g in zip(*rows)] for rows in zip(N, seen)]
    whole = [
        [f * exact.real(g) + (own if i == j else exact.Form()) for j, (f, g) in enumerate(zip(row, low))]
        for i, row in enumerate(N)
    ]
    more = chained([d] * (m - 1))

    def reduced(F: list[list[exact.Form]]) -> exact.Form:
        """The determinant over ``d^(m - 1)``."""
        found, det = exact.Form(), leading(F)[-1]
        for tau in {tau for tau, _ in det}:
            wait = exact.Form({(tau, 0): (Fraction(1), ZERO)}) if tau else exact.real(1)
            found = found + wait * exact.real(*quotient(det.part(0, tau), more))
        return found

    columns = [[row[j] for row in N] for j in own_channels]
    over = [
        [reduced([[*row[:i], c, *row[i + 1 :]] for row, c in zip(whole, column)]) for column in columns]
        for i in own_channels
    ]
    return reduced(whole), over


def opened(H: Any) -> tuple[Any, list[Fraction]]:
    """``mu_k`` for what comes late to ``x_i'``, ``sigma_k = -sum_T A_T x(t - T)``, row ``i``; and the gains 1.

    And ``-sum_T E_T x'(t - T)``, with ``x'`` of the opened plant.
    """
    n, m = len(H.A), len(H.D)
    fed = [i for i in range(n) if any(any(A[i]) for A in (*H.inner, *(E for _, E in H.rates)))]
    if not H.inner:
        return H, []
    zeros = [ZERO] * len(fed)
    B = [[*row, *(Fraction(i == k) for k in fed)] for i, row in enumerate(H.B)]
    D = [[*row, *zeros] for row in H.D] + [[ZERO] * m + zeros for _ in fed]
    late = [(tau, [*C, *([-v for v in A[i]] for i in fed)]) for (tau, C), A in zip(H.late, H.inner)]
    rates = tuple(([*moved, *([-v for v in E[i]] for i in fed)], list[Any]()) for moved, E in H.rates)
    whole = H._replace(B=B, C=[*H.C, *([ZERO] * n for _ in fed)], D=D, late=tuple(late), inner=(), rates=rates)
    return whole, [Fraction(1)] * len(fed)


def on_line(p: exact.Form) -> exact.Form:
    """A sum of ``s^n e^(-s tau)`` at ``s = i omega``."""
    turns = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    return exact.Form({(tau, k): (c * turns[k % 4][0], c * turns[k % 4][1]) for (tau, k), (c, _) in p.items()})


def right_roots(H: Any, low: list[Fraction]) -> tuple[int, int, str]:
    """How many roots with ``Re s > 0`` a plant with dead times has with the gains ``low``, and ``s = 0`` how often.

    Those of ``chi``, :func:`looped`, which is analytic and ``s^n det(1 + D L) (1 + o(1))`` in ``Re s >= 0``; with
    ``rates`` it is ``s^n (c + sum c_T e^(-s T) + o(1))``.  No other root lies on the axis.
    """
    chi = looped(H, low)[0]
    zeros = 0 if H.pace else next(k for k in range(len(chi) + len(H.A) + 1) if taylor(chi, k))
    number, rise = right_zeros(on_line(chi), len(H.A), zeros, pace=H.pace)
    late = "(A_T + s E_T)" if H.rates else "A_T"
    back, over = f" - sum {late} e^(-s T)" * bool(H.inner), f" over (i omega)^{zeros}" * bool(zeros)
    return number, zeros, f"chi(i omega) = det(s - A{back}) det(1 + H L){over} {rise}"


def taylor(p: exact.Form, k: int) -> Fraction:
    """The coefficient of ``s^k`` of a sum of ``s^n e^(-s tau)``."""
    return sum((c * (-tau) ** (k - n) / factorial(k - n) for (tau, n), (c, _) in p.items() if n <= k), ZERO)


def minors(axis: Axis, piece: Any, near: Any = exact.Form, apart: Any = None) -> list[Any]:
    r"""The leading minors of ``F`` with the multipliers ``(x, y)`` of one piece, times powers of ``|d|^2``.

    Row ``i`` of ``F``, plus its adjoint: ``lambda (1 + w H_i) + s theta H_i``, of a piece ``(x + i y)(1 + w H_i)``, and
    for delays ``(y e^(-i omega h/2) - x) H_i + x/2``: with ``e^(-i omega tau)`` on the unit circle ``x (|sigma|^2 -
    |sigma + w|^2) = 0``, and ``2 y (cos(omega (h/2 - tau)) - cos(omega h/2)) |sigma|^2 >= 0`` as ``omega h <= 2 pi``,
    ``y >= 0``: the chord below its arc.  Slow ones: ``x (|sigma|^2/(1 - d) - |sigma + w|^2)``, as ``s = t - tau`` has
    ``dt <= ds/(1 - d)``, and ``y (h^2 |sigma'|^2 - |w|^2)``, both ``>= 0`` when integrated.

    With ``low`` it is ``Re (e_i + l H_i)^* (x + lambda + i y) (e_i + u H_i)``, of a gain ``g`` ``(g - l)(u - g)``.
    So it is with ``M``, times ``over``: ``u M + l M^*`` multiplies ``H_i``, and ``l u Re M`` the square of its modulus.

    ``near`` says what forms become on an interval, as those of the axis have; ``apart`` the same of multipliers.
    """
    apart = apart or near
    Y, less = list[list[Any]](), list[tuple[list[Any], exact.Form]]()
    for i, (one, (x, y)) in enumerate(zip(axis.members, piece)):
        if one.kind == "delay":
            turn, direct = exact.Form({(one.bound / 2, 0): (y, ZERO)}) + exact.real(-x), exact.real(x / 2)
        elif one.kind == "slow":
            turn, direct = exact.real(-x), exact.real((x + y) / 2)
            less.append((axis.bare[i], exact.real(-x * one.width, 0, -y * one.bound**2)))
        elif one.acting is not None:
            direct, back = one.acting, one.acting.conjugate()
            turn = exact.real(one.low + one.width) * direct + exact.real(one.low) * back
            if one.low:
                less.append((axis.bare[i], exact.real(one.low * (one.low + one.width)) * (direct + back)))
        else:
            direct = exact.Form({(ZERO, 0): (one.weight + x, y)})
            turn = exact.Form({(ZERO, 0): ((one.weight + x) * (one.width + 2 * one.low), y * one.width)})
            if one.low:
                less.append((axis.bare[i], exact.real(2 * (one.weight + x) * one.low * (one.width + one.low))))
        Y.append([apart(turn) * f for f in axis.seen[i]])
        Y[i] = [f + apart(exact.real(one.theta) * one.over) * g for f, g in zip(Y[i], axis.moved[i])] or Y[i]
        Y[i][i] = Y[i][i] + apart(direct) * axis.own
    for i, row in enumerate(Y):  # half of it, as the adjoint is added
        for bare, weight in less:
            half = apart(weight * exact.real(Fraction(1, 2)))
            Y[i] = row = [f + half * bare[i].conjugate() * g for f, g in zip(row, bare)]
    return leading([[Y[i][j] + Y[j][i].conjugate() for j in range(len(Y))] for i in range(len(Y))], near)


def leading(F: list[list[Any]], near: Any = exact.Form) -> list[Any]:
    """The leading minors, as in :func:`determinant`."""
    parts, found, signs = {0: near(exact.real(1))}, list[Any](), [near(exact.real(1)), near(exact.real(-1))]
    for i, row in enumerate(F):
        wider = dict[int, Any]()
        for columns, p in parts.items():
            for j in (j for j in range(len(F)) if not columns >> j & 1):
                f = p * row[j] * signs[(columns >> j).bit_count() % 2]
                wider[columns | 1 << j] = wider[columns | 1 << j] + f if columns | 1 << j in wider else f
        parts = wider
        found.append(parts[2 ** (i + 1) - 1])
    return found


def on_piece(axis: Axis, piece: Any, a: Fraction, b: Fraction | None, zeros: int = 0, halvings: int = 0) -> str:
    """Why ``F > 0`` fails on ``[a, b]``, or undecided; empty if it holds.

    ``b`` None: up to infinity, without delays, or where what is without dead time prevails.  ``d`` has ``zeros`` at 0.
    ``halvings``: how often the interval may be halved.
    """
    if b is not None and not (zeros and a == 0):
        return _between(axis, piece, a, b, halvings)
    if axis.pace:
        return _beyond(axis, piece, a, halvings)
    if b is None and axis.late and a and all(one.kind in ("", "scaled") for one in axis.members):
        if _far_out(axis, piece, a):
            return ""
        if len(axis.members) > 1 and len({tau for row in axis.bare for f in row for tau, _ in f}) > MOST_PRODUCTS:
            return f"F > 0 is not shown from {float(a):.9g} on, with any phases of what comes late"
    rise = sum(one.rise for one in axis.members)
    for k, p in enumerate(minors(axis, piece), 1):
        full = 2 * axis.order * k + rise
        if b is None and axis.late:
            late = any(tau and n == full for tau, n in p)
            if not ((late and turning(p, a, full)) or tail(p, a, full)):
                return f"F > 0 is not shown from {float(a):.9g} on"
        elif b is None:
            left = p.part()
            if any(tau for tau, _ in p) or len(left) != 2 * axis.order * k + 1 or not exact.positive(left, a):
                return f"F > 0 fails from {float(a):.9g} on"
        elif not box(p, a, b, TAYLOR, zeros * k):
            return f"F > 0 fails between {float(a):.9g} and {float(b):.9g}"
    return ""


def _between(axis: Axis, piece: Any, a: Fraction, b: Fraction, halvings: int) -> str:
    """The same on an interval, with polynomials off by known errors in place of the forms; ``|d|^2`` is about 1."""
    near, own = Lift(a, b, axis.pace), axis.own.part()
    tops = [sum((c * w**n for n, c in enumerate(own)), ZERO) for w in (a, (a + b) / 2, b)]
    size = (max(tops).numerator.bit_length() - max(tops).denominator.bit_length()) // 2
    if all(map(above, minors(axis.over(partial(near, halvings=size)), piece, near))):
        return ""
    if not halvings:
        return f"F > 0 fails between {float(a):.9g} and {float(b):.9g}"
    ends = pairwise((a, (a + b) / 2, b))
    return next((failed for v, w in ends if (failed := _between(axis, piece, v, w, halvings - 1))), "")


def _far_out(axis: Axis, piece: Any, a: Fraction) -> bool:
    """Whether ``F > 0`` from ``a`` up to infinity, what comes late having any phase in each entry of ``N``, ``d``."""
    near = partial(outward, start=a, degree=axis.order, pace=axis.pace or ZERO)
    (one, *_), unit = axis.members, Lift(ZERO, 1 / a)
    apart = partial(near, degree=one.rise) if one.rise else unit  # kernels are of one channel
    return all(map(above, minors(axis.over(near), piece, unit, apart))) or _in_discs(axis, piece, a, near)


def _in_discs(axis: Axis, piece: Any, a: Fraction, near: Any) -> bool:
    """The same of one channel, ``Re(z + g/d) > 0`` with ``g = (z w + theta s) N``, ``d`` and ``g`` being in discs.

    With the middles ``d_0``, ``g_0``, the radii ``r``, ``q`` and ``P = |d_0|^2 - r^2 > 0``, ``1/d`` is in the disc
    about ``d_0^*/P`` of the radius ``r/P``, and ``P Re(g/d) >= Re g_0 d_0^* - |g_0| r - q |d_0| - q r``.
    """
    (one, *others), (x, y) = axis.members, piece[0]
    if others or one.low or one.rise or one.kind not in ("", "scaled"):
        return False
    z, y = one.weight + x, y * one.width
    turn = exact.Form({(ZERO, 0): (z * one.width, y)}) + exact.S * exact.real(one.theta)
    d, g = near(axis.d), near(turn * axis.bare[0][0])
    lost = g.most() * d.off + g.off * d.most() + g.off * d.off
    middle, own = d._replace(off=0), d.off**2
    square = middle * middle.conjugate()
    whole = square * Lift(ZERO, 1 / a)(exact.real(z)) + g._replace(off=0) * middle.conjugate()
    lost += ceil(max(z, ZERO) * own)
    return all(above(p._replace(off=p.off + (less >> WORD) + 1)) for p, less in ((square, own), (whole, lost)))


def _beyond(axis: Axis, piece: Any, a: Fraction, halvings: int) -> str:
    """The same from ``a`` up to infinity with a rate, first on intervals as far as is needed, all over ``omega^n``."""
    for _ in range(FEW_DOUBLINGS if a else 0):
        if _far_out(axis, piece, a):
            return ""
        if failed := _between(axis, piece, a, 2 * a, halvings):
            return failed
        a *= 2
    return f"F > 0 is not shown from {float(a):.9g} on"


def on_axis(p: Any, discrete: bool) -> exact.Form:
    """A polynomial at ``i omega``, or at ``e^(i omega)``."""
    if not discrete:
        return on_line(exact.real(*p))
    return exact.Form({(Fraction(-k), 0): (Fraction(c), ZERO) for k, c in enumerate(p) if c})


def residues(H: Any, low: list[Fraction], r: int) -> Rows:
    """``lim s H`` at 0 with the gains ``low``, a zero of ``chi`` of the order ``r``."""
    chi, N = looped(H, low)
    need(not any(taylor(f, k) for row in N for f in row for k in range(r - 1)), "a pole at 0 is not simple", Critical)
    return [[taylor(f, r - 1) / taylor(chi, r) for f in row] for row in N]


def integrators(H: Any, low: list[Fraction], r: int, members: list[Member], families: Any) -> dict[str, str]:
    """The same beside dead times, ``chi`` having the zero 0 ``r`` times: docs/theory/channel-dead-times.md.

    Functions, those of channels that show these poles in ``[0, w]`` and at all times the same; ``theta >= 0``.
    """
    need(H.pace is None and not H.rates, "with a rate, and in neutral equations, poles at 0 are not covered", Critical)
    plain = all(not one.kind and one.theta >= 0 and not (one.theta and one.low) for one in members)
    plain = plain and not any(one.operator for one in families)
    need(
        plain,
        "beside dead times and an eigenvalue 0 there are functions alone, theta >= 0, 0 if not in [0, u]",
        Critical,
    )
    R = residues(H, low, r)
    shown = [i for i, row in enumerate(R) if any(row)]
    resting = all(not (families[i].varying or members[i].low) for i in shown)
    need(resting, "what shows a pole at 0 has functions in [0, u] that do not depend on time", Critical)
    smooth = not any(one.varying for one in families) or not any(any(H.D[i]) for i in shown)
    need(smooth, "beside functions that depend on time what shows a pole at 0 is a function of the states", Critical)
    return signed([[one.weight * one.width * v for v in row] for one, row in zip(members, R)], r, "Lambda")
