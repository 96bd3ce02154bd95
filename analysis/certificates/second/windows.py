r"""Forms that couple channels and samples, checked again.

With ``u = phi - l sigma`` and ``v = h sigma - phi`` of all samples of some channels, ``w = (u, v)``, a form ``w'M w``
is nonnegative for ReLUs if ``M``, the signs of ``v`` turned, has no entry below 0 but between ``u_k`` and ``v_k`` of
one sample, where ``u_k v_k = 0``; for channels of one monotone nonlinearity if ``w'M w = 2 u'Q v`` and ``Q`` maps the
vector of ones, from both sides, to nonnegative ones with no entry above 0 beside the diagonal (for odd ones with
``-|q|`` there).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb_mat, fmpq, fmpq_mat

from lure.analysis.certificates.second.channels import (
    Asked,
    acyclic,
    closed_by,
    cut,
    diagonal,
    half_plane_stable,
    joined,
    require_uniform,
    stacked,
    symmetric,
)
from lure.analysis.certificates.second.classes import at_least
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import (
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.order import require_positive_on_orders
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    flag,
    listed,
    mapping,
    numbers,
    record,
    require,
)
from lure.analysis.certificates.second.zero import leading, null_space, require_rests, shifted_by

Bounds = tuple[Fraction, Fraction]
MOST_SAMPLES = 100
_ONE_SIDED = ("rising", "odd rising", "falling", "odd falling")


@dataclass(frozen=True)
class Form:
    """A form ``w' M w`` of the samples of some channels, sample after sample."""

    channels: list[int]
    M: fmpq_mat


@dataclass(frozen=True)
class Forms:
    """Forms of one number of samples; the bounds that ``u`` and ``v`` of each channel are about."""

    samples: int
    each: list[Form]
    bounds: list[Bounds]


def read_forms(value: object, asked: Asked, samples: int, *, over_time: bool, rate: Fraction = Fraction(1)) -> Forms:
    """The forms of a certificate.

    Parameters
    ----------
    value : object
        Kind, channels and rows of each.
    asked : Asked
        The classes.
    samples : int
        Of each channel.
    over_time : bool
        Whether the sum of each form over all time has to be nonnegative, else the form itself.
    rate : Fraction
        The samples are those at the time ``t`` times ``rate^-t``.

    Raises
    ------
    NotShown
        A form is not nonnegative for every nonlinearity of the class.
    """
    m, found, taken, alone = asked.D.nrows(), list[Form](), list[int](), list[int]()
    sloped = dict[int, Bounds]()
    for one in map(mapping, listed(value)):
        given = record(one, "kind", "channels", "rows")
        channels = [count(i, least=1) - 1 for i in listed(given["channels"])]
        require(bool(channels) and max(channels) < m, "a form is about no channel, or one that there is not")
        once = [i for i in channels if given["kind"] not in ("sector", *_ONE_SIDED)]
        clash = {*once} & {*taken, *alone} or {*channels} & {*alone}
        require(len(set(channels)) == len(channels) and not clash, "a channel stands twice in the forms")
        taken, alone = [*taken, *channels], [*alone, *once]
        require(not any(asked.nonlinearities[i].operator for i in channels), "a form is about an operator")
        own, size = [asked.nonlinearities[i] for i in channels], samples * len(channels)
        if given["kind"] == "relu":
            require(all(one.relu for one in own) and not over_time, "the form does not fit the classes")
            M = symmetric(given["rows"], 2 * size)
            _require_rectified(M, size)
        else:
            rows = [numbers(row) for row in listed(given["rows"])]
            require(len(rows) == size and all(len(row) == size for row in rows), "the rows of a form do not fit")
            if given["kind"] == "sector":
                off = all(row[j] == 0 for i, row in enumerate(rows) for j in range(size) if i != j)
                require(
                    off and all(rows[i][i] >= 0 for i in range(size)), "the form of a sector is not diagonal, or < 0"
                )
            else:
                kind = str(given["kind"]).removeprefix("odd ")
                require(given["kind"] in ("monotone", "odd", *_ONE_SIDED), "the kind of a form is unknown")
                require(len({asked.repeated[i] for i in channels}) == 1, "a form couples different nonlinearities")
                odd = str(given["kind"]).startswith("odd")
                require(own[0].odd or not odd, "a form is for odd nonlinearities")
                require(not own[0].time_varying, "the nonlinearities depend on time")
                if kind in ("rising", "falling"):
                    for i in channels:
                        _require_side(asked, i, rising=kind == "rising")
                else:
                    low, high = own[0].slope or (None, None)
                    if not (isinstance(low, Fraction) and isinstance(high, Fraction)):
                        raise NotShown("a channel has no finite slope bounds")
                    sloped |= dict.fromkeys(channels, (low, high))
                turned = _slowed(rows, len(channels), rate)
                _require_dominant(turned, len(channels), over_time=over_time, odd=odd, rate=rate)
            Q = fmpq_mat([[to_fmpq(v) for v in row] for row in rows])
            M = joined(0 * Q, Q, 0 * Q)
            if given["kind"] in _ONE_SIDED:  # w sigma = u + v in place of the other
                M = M if kind == "rising" else joined(0 * Q, Q.transpose(), 0 * Q)
                square, none = Q + Q.transpose(), 0 * Q
                M += joined(square, none, none) if kind == "rising" else joined(none, none, square)
        found.append(Form(channels, M))
    require(not any(one.rough for one in asked.nonlinearities), "the nonlinearities are locally Lipschitz")
    if len(sloped) < m:
        sloped = dict(enumerate(asked.bounds)) | sloped
    return Forms(samples, found, [sloped[i] for i in range(m)])


def _require_side(asked: Asked, i: int, *, rising: bool) -> None:
    """Check that ``phi - l sigma`` ascends, ``l`` the lower bound of the sector, or ``h sigma - phi``."""
    (low, high), (least, most) = asked.bounds[i], asked.nonlinearities[i].slope or ("-inf", "inf")
    if rising:
        require(at_least(least, low), "a slope may be below the lower bound of its sector")
    else:
        require(isinstance(most, Fraction) and most <= high, "a slope may be above the upper bound of its sector")


def _require_rectified(M: fmpq_mat, size: int) -> None:
    for i in range(2 * size):
        for j in range(2 * size):
            sign = 1 if (i < size) == (j < size) else -1
            require(abs(i - j) == size or sign * M[i, j] >= 0, "an entry of a form for ReLUs has the wrong sign")


def _slowed(rows: Sequence[Sequence[Fraction]], width: int, rate: Fraction) -> list[list[Fraction]]:
    """The same forms in samples that are not weighed, up to a power of the rate at the first of them."""
    powers = [rate ** -(k // width) for k in range(len(rows))]
    return [[p * v * q for v, q in zip(row, powers, strict=True)] for row, p in zip(rows, powers, strict=True)]


def _require_dominant(
    rows: Sequence[Sequence[Fraction]], width: int, *, over_time: bool, odd: bool, rate: Fraction
) -> None:
    """Rows and columns of ``Q`` in samples that are not weighed.

    Over all time ``sum_t r^-2t`` of the forms from ``t`` on: an entry of the times ``i`` and ``j`` stands with the
    weight of the row at ``r^2i``, of the column at ``r^2j``.
    """
    size, samples = len(rows), len(rows) // width
    if over_time:  # the later of two samples moved to the middle of a window of 2 T - 1
        wide, ends = ([[Fraction(0)] * (width * (2 * samples - 1)) for _ in range(width)] for _ in range(2))
        for i in range(size):
            for j in range(size):
                at = (j // width - i // width + samples - 1) * width + j % width
                wide[i % width][at] += rows[i][j] * rate ** (2 * (i // width))
                ends[i % width][at] += rows[i][j] * rate ** (2 * (j // width))
        middle = (samples - 1) * width
        out = [2 * row[middle + i] - sum(map(abs, row)) for i, row in enumerate(wide)]
        into = [2 * ends[j][middle + j] for j in range(width)]
        for row in ends:
            for at, value in enumerate(row):
                into[at % width] -= abs(value)
        beside = [v for i, row in enumerate(wide) for at, v in enumerate(row) if at != middle + i]
    else:
        out = [2 * row[i] - sum(map(abs, row)) for i, row in enumerate(rows)]
        into = [2 * rows[j][j] - sum(abs(row[j]) for row in rows) for j in range(size)]
        beside = [v for i, row in enumerate(rows) for j, v in enumerate(row) if i != j]
    require(min(*out, *into) >= 0, "the form is not doubly dominant")
    require(odd or all(v <= 0 for v in beside), "an entry beside the diagonal is above 0")


def static_form(value: object, asked: Asked) -> tuple[fmpq_mat, list[Bounds]]:
    """``Pi`` for ``(sigma, psi)``, ``psi = phi - l sigma``, of forms of one sample, and the bounds ``(l, h)``."""
    forms = read_forms(value, asked, 1, over_time=False)
    m = len(forms.bounds)
    total = [[fmpq(0)] * 2 * m for _ in range(2 * m)]  # of (psi, w sigma - psi)
    for one in forms.each:
        places = [*one.channels, *(m + i for i in one.channels)]
        for i, a in enumerate(places):
            for j, b in enumerate(places):
                total[a][b] += one.M[i, j]
    unit = fmpq_mat([[int(i == j) for j in range(m)] for i in range(m)])
    width = fmpq_mat(m, m)
    for i, (low, high) in enumerate(forms.bounds):
        width[i, i] = to_fmpq(high - low)
    view = joined(0 * unit, unit, -unit, lower_left=width)
    return view.transpose() * fmpq_mat(total) * view, forms.bounds


def _ordered_forms(given: Mapping[str, object], asked: Asked) -> Forms:
    """Forms that are positive on the order cones."""
    found = record(given, "windows", "odd")
    firsts = sorted({i for i in asked.repeated if not asked.nonlinearities[i].operator})
    windows = [[numbers(row) for row in listed(one)] for one in listed(found["windows"])]
    odd = [flag(one) for one in listed(found["odd"])]
    require(len(firsts) == len(windows) == len(odd), "there is not one form for each nonlinearity")
    require(bool(firsts), "there are no forms")
    m, T = asked.D.nrows(), len(windows[0]) // (2 * asked.repeated.count(firsts[0]))
    require(T > 0, "there are no samples")
    slopes = [asked.bounds[i] if one.operator else one.slope for i, one in enumerate(asked.nonlinearities)]
    ends = [one for one in slopes if one is not None and all(isinstance(end, Fraction) for end in one)]
    require(len(ends) == m, "a channel has no finite slope bounds")
    forms = list[Form]()
    for first, rows, only_odd in zip(firsts, windows, odd, strict=True):
        block = [i for i in range(m) if asked.repeated[i] == first]
        own = asked.nonlinearities[first]
        require(len(rows) == 2 * T * len(block), "a form has another number of samples")
        require(not (own.time_varying or own.rough), "the nonlinearities are fixed in time and locally Lipschitz")
        require(own.odd or not only_odd, "a form is for odd nonlinearities")
        require_positive_on_orders(rows, odd=only_odd)
        M = fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(len(rows))] for i in range(len(rows))])
        forms.append(Form(block, M))
    return Forms(T, forms, [(Fraction(low), Fraction(high)) for low, high in ends])


def _read(document: Document, asked: Asked) -> tuple[list[Fraction], Forms, Forms | None]:
    """The weights of the operators, the forms, and those at the start if there are such."""
    stated, weights = dict(document.multiplier), [Fraction(0)] * asked.D.nrows()
    if asked.operators:
        require("lambda" in stated, "the operators have no weights")
        weights = numbers(stated.pop("lambda"))
        others = [i for i, one in enumerate(asked.nonlinearities) if not one.operator]
        require(len(weights) == asked.D.nrows() and not any(weights[i] for i in others), "a weight is of no operator")
    require_uniform(weights, asked)
    if document.theorem == "order-cones":
        return weights, _ordered_forms(stated, asked), None
    given = record(stated, "samples", "forms", "start")
    T = count(given["samples"], least=2)
    require(T <= MOST_SAMPLES, "there are too many samples")
    rate = document.rate or Fraction(1)
    forms = read_forms(given["forms"], asked, T, over_time=given["start"] is None, rate=rate)
    if given["start"] is None:
        return weights, forms, None
    start = read_forms(given["start"], asked, T - 1, over_time=False, rate=rate)
    require(start.bounds == forms.bounds, "the forms at the start are about other bounds")
    return weights, forms, start


def require_windows(document: Document, asked: Asked) -> bool:
    """Forms of ``T`` samples: ``V(xi+) - V(xi) + sum w' M w < 0``, nonnegative along solutions, or summed over time.

    With forms at the start ``V - sum w' N w > 0``; else the loop with the least slopes is stable.  Returned is whether
    that loop has an eigenvalue 1, where the inequality is an equality at equilibria.

    Raises
    ------
    NotShown
        One of these is not shown.
    """
    zero = ("zero",) if "zero" in mapping(document.proof) else ()
    proof = record(document.proof, "method", "P", "exponent", *zero)
    require(proof["method"] == "matrix" and asked.discrete, "forms of several samples: by matrices, in discrete time")
    require(acyclic(asked), "D has a cycle of channels")
    weights, forms, start = _read(document, asked)
    both = zip(asked.nonlinearities, forms.bounds, strict=True)
    ends = [(Fraction(0) if one.operator else low, high) for one, (low, high) in both]
    loop = shifted_by(asked, ends) if zero else None
    if start is None and loop is None:
        closed = closed_by(asked, [low for low, _ in ends])
        require(closed is not None and half_plane_stable(closed), "the loop with the least slopes is not stable")
    n, m, T = asked.A.nrows(), asked.D.nrows(), forms.samples
    size, order = n + m * T, n + m * (T - 1)
    unit = fmpq_mat([[int(i == j) for j in range(size)] for i in range(size)])
    phi = [cut(unit, n + m * t, m) for t in range(T)]
    x, sigma, later = cut(unit, 0, n), list[fmpq_mat](), unit
    for t in range(T):
        sigma.append(asked.C * x - asked.D * phi[t])
        x = asked.A * x - asked.B * phi[t]
        later = stacked(x, cut(unit, n + m, order - n)) if t == 0 else later
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    half, scale = triangle(proof["P"], order), to_fmpq(Fraction(2)) ** -exponent
    P = fmpq_mat([[fmpq(half[max(i, j)][min(i, j)]) * scale for j in range(order)] for i in range(order)])
    now = cut(unit, 0, order)
    before = now.transpose() * P * now
    falls, needed = before - later.transpose() * P * later - _total(forms, phi, sigma), list[fmpq_mat]()
    for block in asked.operators:  # at the last of the samples
        r, weight = asked.bounds[block[0]][1], weights[block[0]]
        w = _rows([cut(side[T - 1], i, 1) for side in (sigma, phi) for i in block])
        form = diagonal([weight * r * r] * len(block) + [-weight] * len(block))
        falls -= w.transpose() * form * w
    if loop is not None:
        require(document.rate is None, "there is a rate, and an eigenvalue 1")
        states, seen = require_rests(asked, loop, ends, proof["zero"])
        rests = states
        for _ in range(T):
            rests = stacked(rests, diagonal([low for low, _ in ends]) * seen)
        require(bool(falls * rests == fmpq_mat(size, rests.ncols())), "the inequality is no equality at an equilibrium")
        kept = [i for i in range(size) if i not in leading(*states.transpose().rref())]
        falls = fmpq_mat([[falls[i, j] for j in kept] for i in kept])
        if start is None:
            _require_settling(asked, loop[0], forms, states, seen)
            needed.append(rests.transpose() * before * rests)
    needed.append(falls)
    if start is not None:
        whole = before - _total(start, phi, sigma)
        needed.append(fmpq_mat([[whole[i, j] for j in range(order)] for i in range(order)]))
    for bits in BITS:
        with working_precision(bits):
            if all(positive_definite(arb_mat(one)) for one in needed):
                return loop is not None
    raise NotShown("the matrix of the inequality is not shown to be positive definite")


def _require_settling(asked: Asked, A: fmpq_mat, forms: Forms, states: fmpq_mat, seen: fmpq_mat) -> None:
    """What forms summed over time need beside an eigenvalue 1, and that all others are strictly inside.

    With ``A~ N = N``, ``K A~ = K``, ``K N = 1`` those are the eigenvalues of ``A~ - N K``, beside 0.  ``He`` of the sum
    of ``M_uv`` over all pairs of samples is positive definite on ``W C~ N``.
    """
    require(not asked.operators, "there is an operator beside an eigenvalue 1")
    for one, (low, _) in zip(asked.nonlinearities, forms.bounds, strict=True):
        rising = one.slope is not None and at_least(one.slope[0], low) and not one.time_varying
        require(rising, "an eigenvalue 1, and no lower bound of a slope")
    unit = diagonal([Fraction(1)] * A.nrows())
    left = null_space((A - unit).transpose()).transpose()
    require(left.nrows() == states.ncols(), "there are more equilibria than those stated")
    overlap = left * states
    require(bool(overlap.det() != 0), "the eigenvalue 1 has too few eigenvectors")
    require(half_plane_stable(A - states * overlap.inv() * left), "another eigenvalue is not strictly inside")
    r = states.ncols()
    moves = fmpq_mat(r, r)
    for each in forms.each:
        rows = [to_fmpq(forms.bounds[i][1] - forms.bounds[i][0]) * cut(seen, i, 1) for i in each.channels]
        v = _rows(rows * forms.samples)
        p = v.nrows()
        squares = (each.M[p + i, p + j] for i in range(p) for j in range(p))
        require(all(one == 0 for one in squares), "a form has products of v, beside an eigenvalue 1")
        moves += v.transpose() * fmpq_mat([[each.M[i, p + j] for j in range(p)] for i in range(p)]) * v
    signs = (moves + moves.transpose()).charpoly().coeffs()  # all roots are real
    require(all(c * (-1) ** (r - i) > 0 for i, c in enumerate(signs)), "the forms do not move every equilibrium")


def _total(forms: Forms, phi: Sequence[fmpq_mat], sigma: Sequence[fmpq_mat]) -> fmpq_mat:
    """``sum w' M w`` in the coordinates of the rows."""
    size = phi[0].ncols()
    total = fmpq_mat(size, size)
    for one in forms.each:
        lines = list[fmpq_mat]()
        for side in (0, 1):
            for t in range(forms.samples):
                for i in one.channels:
                    end, sign = to_fmpq(forms.bounds[i][side]), 1 - 2 * side
                    lines.append(sign * (cut(phi[t], i, 1) - end * cut(sigma[t], i, 1)))
        w = _rows(lines)
        total += w.transpose() * one.M * w
    return total


def _rows(lines: Iterable[fmpq_mat]) -> fmpq_mat:
    return fmpq_mat([[line[0, j] for j in range(line.ncols())] for line in lines])
