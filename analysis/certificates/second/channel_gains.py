"""Gains in several channels, checked again: boxes of constant ones, and what constant or switched ones refute."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, product

from flint import arb, arb_mat, ctx, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channels import (
    Asked,
    balls,
    closed_by,
    diagonal,
    growing_member,
    member,
    nearby_member,
)
from lure.analysis.certificates.second.matrix import BITS
from lure.analysis.certificates.second.numerics import (
    X,
    ball,
    even_odd,
    half_plane_counts,
    positive_from_zero,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.orbits import Stay, Watched, orbit_numbers, require_periodic
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
    tick,
)
from lure.analysis.certificates.second.systems import mapped

MOST_VERTICES, MOST_BOXES, LONGEST, SQUARINGS = 10, 20_000, 10_000, 80


def require_gains(document: Document, asked: Asked) -> None:
    """Check boxes of constant gains: at each frequency Bernstein's coefficients lie in one open half-plane."""
    record(document.multiplier)
    proof, bounds = record(document.proof, "method", "tree"), asked.bounds
    require(proof["method"] == "hull", "the method does not fit the theorem")
    constant = all(one.linear and one.rate is None for one in asked.nonlinearities)
    require(constant, "a class is not one of constant gains")
    require(len(bounds) <= MOST_VERTICES, "there are too many channels for boxes of gains")
    firsts = sorted(set(asked.repeated))
    of = [firsts.index(first) for first in asked.repeated]  # which gain of the box a channel has
    least = [bounds[first][0] for first in firsts]
    det, p = _characteristic(asked, [least[j] for j in of])
    n, counts = asked.A.nrows(), half_plane_counts(p)
    require(p.degree() == n and counts.axis == counts.right == 0, "the loop at the lower bounds is unstable")
    signs, known = (det > 0, p[n] > 0), dict[tuple[Fraction, ...], tuple[fmpq, fmpq_poly]]()
    pending, boxes = [(proof["tree"], least, [bounds[first][1] for first in firsts])], 0
    while pending:
        tick()
        node, low, high = pending.pop()
        found, boxes = mapping(node), boxes + 1
        require(boxes <= MOST_BOXES, "there are too many boxes")
        if "split" in found:
            which, value = listed(record(found, "split", "parts")["split"])
            j, at, parts = count(which), number(value), listed(found["parts"])
            require(len(parts) == 2 and j < len(low) and low[j] < at < high[j], "a box is not split into two")
            left, right = list(high), list(low)
            left[j] = right[j] = at
            pending += [(parts[0], low, left), (parts[1], right, high)]
            continue
        record(found, "omega", "directions")
        omega = [number(v) for v in listed(found["omega"])]
        directions = [numbers(pair) for pair in listed(found["directions"])]
        ends: list[Fraction | None] = [Fraction(0), *omega, None]
        require(all(a < b for a, b in pairwise([Fraction(0), *omega])), "the frequencies are not in order")
        require([len(pair) for pair in directions] == [2] * (len(ends) - 1), "each part has one direction")
        hull = dict[tuple[int, ...], tuple[fmpq, fmpq_poly]]()  # sums over the corners that differ by turns of one gain
        for upper in product((False, True), repeat=len(of)):
            corner = tuple(high[j] if up else low[j] for j, up in zip(of, upper, strict=True))
            if corner not in known:
                known[corner] = _characteristic(asked, corner)
            key = tuple(sum(up for i, up in zip(of, upper, strict=True) if i == j) for j in range(len(low)))
            before = hull.get(key, (fmpq(0), fmpq_poly([0])))
            hull[key] = before[0] + known[corner][0], before[1] + known[corner][1]
        for det, p in hull.values():
            require(p.degree() == n and (det > 0, p[n] > 0) == signs, "a leading coefficient changes its sign")
            for (a, b), (real, imaginary) in zip(pairwise(ends), directions, strict=True):
                even, odd = (half(X * X) for half in even_odd(p))
                line = to_fmpq(real) * even + to_fmpq(imaginary) * X * odd  # Re u* (e + i w o)
                require(positive_between(line, a, b), "the vertices are not shown to lie in a half-plane")


def _characteristic(asked: Asked, gains: Sequence[Fraction]) -> tuple[fmpq, fmpq_poly]:
    """``det(1 + D G)``, and it times ``det(s - A + B G (1 + D G)^-1 C)``; in discrete time ``z = (1 + s)/(1 - s)``."""
    closed = closed_by(asked, gains)
    if closed is None:
        raise NotShown("with some of the gains the loop has no solution")
    det = (diagonal([Fraction(1)] * len(gains)) + asked.D * diagonal(gains)).det()
    p = closed.charpoly()
    return det, det * (mapped(p, p.degree()) if asked.discrete else p)


def positive_between(p: fmpq_poly, low: Fraction | None, high: Fraction | None) -> bool:
    """Whether ``p > 0`` on ``[low, high]``; None: on ``[low, inf)``.  By ``x = (low + high y)/(1 + y)``, ``y >= 0``.

    ``low``, ``high``: the interval.
    """
    a = to_fmpq(low or Fraction(0))
    if high is None:
        return positive_from_zero(p(X + a))
    b, whole, power = to_fmpq(high), fmpq_poly([0]), fmpq_poly([1])
    for c in reversed(p.coeffs()):
        whole, power = whole * (X * b + a) + c * power, power * (X + 1)
    return bool(p(b) > 0) and positive_from_zero(whole)


Step = tuple[fmpq_mat, fmpq_mat, Fraction | None]


def refuted(document: Document, asked: Asked) -> str:
    """What gains do that are constant, or that jump and repeat."""
    if document.proof.get("method") in ("switched-gains", "ramped-gains"):
        _require_growth(document, asked)
        return claims.NO_REST
    if document.proof.get("method") == "flow-orbit":
        _require_oscillation(document, asked)
        return claims.NO_REST
    if document.proof.get("method") == "memory-orbit":
        _require_hysteresis(document, asked)
        return claims.NO_REST
    if document.proof.get("method") == "sampled-orbit":
        _require_repetition(document, asked)
        return claims.NO_REST
    if document.proof.get("method") == "equilibrium":
        _require_rest(document, asked)
        return claims.OTHER_EQUILIBRIA
    if "unlimited" in document.proof:
        _require_unlimited(document, asked)
        return claims.UNLIMITED
    grows = "growth" in document.proof
    more = [key for key in ("growth", "matrices") if key in document.proof]
    proof = record(document.proof, "method", "gains", *more)
    require(proof["method"] == "linear-gains", "the method is unknown for several nonlinearities")
    if "matrices" in proof:
        require(not grows, "solutions of a given growth are those of gains alone")
        G = _matrices(member(proof["gains"], asked), proof["matrices"], asked)
        whole = diagonal([Fraction(1)] * len(asked.nonlinearities)) + asked.D * G
        require(bool(whole.det() != 0), "the loop with these matrices is not well posed")
        return unstable(asked.A - asked.B * G * whole.inv() * asked.C, discrete=asked.discrete)
    if grows:
        return _growing(asked, growing_member(proof["gains"], asked), number(proof["growth"]))
    closed = closed_by(asked, member(proof["gains"], asked))
    return claims.NO_SOLUTION if closed is None else unstable(closed, discrete=asked.discrete)


def _matrices(gains: Sequence[Fraction], value: object, asked: Asked) -> fmpq_mat:
    """Gains, on the channels of each function of a block a matrix ``G = c + R`` with ``r^2 - R'R >= 0``.

    ``c`` is the middle of the sector and ``r`` half its width; the sign of a symmetric matrix is that of its roots.

    Raises
    ------
    NotShown
        A matrix is missing, or not of its class.
    """
    G, blocks = (
        diagonal(gains),
        [b for b in asked.operators if asked.nonlinearities[b[0]].operator == claims.FULL_BLOCK],
    )
    given = listed(value)
    require(0 < len(blocks) == len(given), "there is not one matrix for each function of a block")
    for block, stated in zip(blocks, given, strict=True):
        rows, one = [numbers(row) for row in listed(stated)], asked.nonlinearities[block[0]]
        require([len(row) for row in rows] == [len(block)] * len(block), "a matrix does not fit its block")
        if not (isinstance(one.lower, Fraction) and isinstance(one.upper, Fraction)):
            raise NotShown("a function of a block has no bounds")
        middle, radius, size = (one.lower + one.upper) / 2, (one.upper - one.lower) / 2, len(block)
        R = fmpq_mat([[to_fmpq(v - middle * (i == j)) for j, v in enumerate(row)] for i, row in enumerate(rows)])
        p = (diagonal([radius**2] * size) - R.transpose() * R).charpoly()
        require(all(c * (-1) ** (size - i) >= 0 for i, c in enumerate(p.coeffs())), "a matrix is not in its class")
        for i, row in zip(block, rows, strict=True):
            for j, v in zip(block, row, strict=True):
                G[i, j] = to_fmpq(v)
    return G


def _require_unlimited(document: Document, asked: Asked) -> None:
    """Check that constant gains leave a pole in what ``z`` sees of ``w`` that is not strictly inside.

    With ``y = (1 + D G)^-1 (C x + D w)``, ``x' = A x + B (w - G y)``, what is seen of ``w_j`` is ``c (s - A)^-1 b``
    of a certain row and column; its numerator has the coefficients ``sum a_l c A^(k-l) b``, those of ``det(s - A)``
    being ``a_l``.

    Raises
    ------
    NotShown
        They are not of the class, or all that ``z`` sees of ``w`` is stable.
    """
    proof = record(document.proof, "method", "gains", "unlimited")
    require(proof["method"] == "linear-gains" and bool(asked.performance), "no gain is asked for")
    gains, places = nearby_member(proof["gains"], asked), [count(v, least=1) for v in listed(proof["unlimited"])]
    require(len(places) == 2 and max(places) <= len(asked.performance), "an output and an input are named")
    closed, own = closed_by(asked, gains), sorted(asked.performance)
    if closed is None or not closed.nrows():
        raise NotShown("the loop with these gains has no solution, or no state")
    G, one = diagonal(gains), diagonal([Fraction(1)] * len(gains))
    E, (i, j), n = (one + asked.D * G).inv(), (own[place - 1] for place in places), closed.nrows()
    into, seen = asked.B * (one - G * E * asked.D), E * asked.C
    state, row = fmpq_mat([[into[k, j]] for k in range(n)]), fmpq_mat([[seen[i, k] for k in range(n)]])
    p, markov = closed.charpoly(), list[fmpq]()
    for _ in range(n):
        tick()
        markov.append((row * state)[0, 0])
        state = closed * state
    top = [sum((p[k + 1 + h] * markov[h] for h in range(n - k)), fmpq(0)) for k in range(n)]
    poles = p // p.gcd(fmpq_poly(top))
    inner = mapped(poles, poles.degree()) if asked.discrete else poles
    counts = half_plane_counts(inner)
    lost = poles.degree() - inner.degree()  # z = -1
    require(counts.right + counts.axis + lost > 0, "all that z sees of w is stable")


def _growing(asked: Asked, gains: Sequence[Fraction], rate: Fraction) -> str:
    """What solutions do that grow at a rate, whatever is bounded beside the gains."""
    closed = closed_by(asked, gains)
    if closed is None or rate <= 0:
        raise NotShown("there is no such loop, or the rate is not positive")
    if asked.discrete:  # eigenvalues of modulus 1 + rate or more
        slower = closed * to_fmpq(1 / (1 + rate))
        p = slower.charpoly()
        inner = mapped(p, p.degree())
        counts = half_plane_counts(inner)
        out = counts.right + counts.axis + p.degree() - inner.degree()
    else:
        counts = half_plane_counts(closed.charpoly()(X + to_fmpq(rate)))
        out = counts.right + counts.axis
    require(out > 0, "no solution is shown to grow")
    return claims.NO_REST


def _require_growth(document: Document, asked: Asked) -> None:
    """Check that gains that jump, or go linearly, let some solution grow."""
    found = record(document.proof, "method", "gains", "squarings", "bits", *([] if asked.discrete else ["times"]))
    count(found["squarings"])
    rows, times, ramps = read_jumps(found, asked)
    closed = {tuple(row): closed_by(asked, row) for row in rows}
    steps = list[Step]()
    for row, after, time in zip(rows, rows[1:] + rows[:1], times, strict=True):
        first, last = closed[tuple(row)], closed[tuple(after)]
        if first is None or last is None:
            raise NotShown("with some of the gains the loop has no solution")
        steps.append((first, last if ramps and row != after else first, None if asked.discrete else time))
    require_outside(steps)


def read_jumps(found: Mapping[str, object], asked: Asked) -> tuple[list[list[Fraction]], list[Fraction], bool]:
    """Gains and times of a proof, if the classes have gains that move so, and whether they go linearly.

    Raises
    ------
    NotShown
        They have none, or gains and times do not fit.
    """
    ramps = found["method"] == "ramped-gains"
    require(not (ramps and asked.discrete), "gains go linearly in continuous time only")
    count(found["bits"], least=2)
    rows = [member(one, asked) for one in listed(found["gains"])]
    times = [Fraction(1)] * len(rows) if asked.discrete else numbers(found["times"])
    require(0 < len(rows) == len(times) <= LONGEST and all(t > 0 for t in times), "gains and times do not fit")
    for i, (gains, nonlinearities) in enumerate(zip(zip(*rows, strict=True), asked.nonlinearities, strict=True)):
        if len(set(gains)) == 1:
            continue
        free, rate = nonlinearities.time_varying and not nonlinearities.linear, nonlinearities.rate
        if rate is not None and (asked.discrete or ramps):
            ends = zip(gains, gains[1:] + gains[:1], times, strict=True)
            free = all(-rate * t <= b - a <= rate * t for a, b, t in ends)
        require(free, "the class has no gains that vary so fast")
        alone = all(asked.D[i, j] == 0 for j in range(asked.D.ncols()))
        require(alone or not ramps, "a gain moves whose sigma is no function of the state alone")
    return rows, times, ramps


def require_outside(steps: Sequence[Step]) -> None:
    """Check ``|tr M^N| > n`` for the matrix ``M`` of one period: it has an eigenvalue outside the unit disc.

    ``steps``: the matrix at the beginning of each step and at its end, to which it goes linearly, and the time; None
    for a step of discrete time.

    Raises
    ------
    NotShown
        None is shown.
    """
    n, ramps = steps[0][0].nrows(), any(first != last for first, last, _ in steps)
    for bits in BITS[: 2 if ramps else len(BITS)]:
        with working_precision(bits):
            whole, known = balls([Fraction(1)] * n), dict[tuple[str, ...], arb_mat]()
            for first, last, time in steps:
                key = str(first.entries()), str(last.entries()), str(time)
                if key not in known:
                    G = arb_mat(first)
                    if first != last and time is not None:
                        known[key] = _ramp(G, arb_mat(last), ball(time))
                    else:
                        known[key] = G if time is None else (G * ball(time)).exp()
                whole = known[key] * whole
            for _ in range(SQUARINGS):
                tick()
                if abs(whole.trace()) > n:
                    return
                whole = whole * whole
    raise NotShown("no eigenvalue outside the unit disc is shown")


def _members(given: object, asked: Asked, *, half: bool) -> list[claims.Graph]:
    """The piecewise-linear nonlinearity of each channel; where half a period is given they are odd."""
    firsts, rows = sorted(set(asked.repeated)), listed(given)
    require(len(rows) == len(firsts), "there is not one nonlinearity for each block")
    graphs = dict[int, claims.Graph]()
    for first, one in zip(firsts, rows, strict=True):
        graphs[first] = claims.graph(*(record(one, "points", "left", "right")[k] for k in ("points", "left", "right")))
        member_of = asked.nonlinearities[first].has(graphs[first]) and (graphs[first].odd or not half)
        require(member_of, "a nonlinearity of the solution is not in the class, or half a period needs an odd one")
    return [graphs[first] for first in asked.repeated]


def _require_repetition(document: Document, asked: Asked) -> None:
    """Check a periodic solution in discrete time: all samples solve the equations of the loop, as one linear system.

    With ``X = (x_0, .., x_N-1)`` and ``U`` of the inputs each column satisfies ``S X = A X - B U``, ``S`` the shift.
    """
    found = record(document.proof, "method", "nonlinearities", "inputs", "state", "half")
    plain = not asked.operators and not any(one.memory for one in asked.nonlinearities)
    require(asked.discrete and plain, "samples are for discrete time, and for functions")
    half, m, n = found["half"], len(asked.repeated), asked.A.nrows()
    require(half in (True, False) and isinstance(half, bool), "half is neither true nor false")
    own = _members(found["nonlinearities"], asked, half=half is True)
    rows = [numbers(row) for row in listed(found["inputs"])]
    start = numbers(found["state"])
    require(0 < len(rows) <= LONGEST and all(len(row) == m for row in rows), "an orbit has inputs at each sample")
    require(len(start) == n, "the state does not fit")
    U = fmpq_mat([[to_fmpq(row[i]) for row in rows] for i in range(m)])
    columns = [[to_fmpq(v) for v in start]]
    for t in range(len(rows)):
        tick()
        moved = asked.A * fmpq_mat([[v] for v in columns[-1]]) - asked.B * fmpq_mat([[U[i, t]] for i in range(m)])
        columns.append([moved[i, 0] for i in range(n)])
    require(columns[-1] == [-v if half else v for v in columns[0]], "the orbit does not close")
    require(columns[1] != columns[0], "the solution is at rest")
    states = fmpq_mat([[column[i] for column in columns[:-1]] for i in range(n)])
    seen = asked.C * states - asked.D * U
    fits = all(own[i].at(to_fraction(seen[i, t])) == rows[t][i] for i in range(m) for t in range(len(rows)))
    require(fits, "a sample is not on its nonlinearity")


def _require_rest(document: Document, asked: Asked) -> None:
    """Check an equilibrium: ``(A - 1, -B; C, -D) (x, phi) = (0, sigma)``, the 1 in discrete time only.

    Raises
    ------
    NotShown
        It is 0 or none, a nonlinearity is not in its class, or the loop at the lower bounds has an eigenvalue 0 (1).
    """
    found = record(document.proof, "method", "nonlinearities", "inputs", "state")
    functions = not asked.operators and not any(one.memory for one in asked.nonlinearities)
    require(functions, "equilibria are looked for with functions alone")
    own, n = _members(found["nonlinearities"], asked, half=False), asked.A.nrows()
    state, phi = numbers(found["state"]), numbers(found["inputs"])
    require(len(state) == n and len(phi) == len(own) and any(state), "the state is 0, or does not fit")
    still = diagonal([Fraction(int(asked.discrete))] * n)
    x, u = (fmpq_mat([[to_fmpq(v)] for v in side]) for side in (state, phi))
    require((asked.A - still) * x == asked.B * u, "the state does not stay")
    seen = asked.C * x - asked.D * u
    fits = all(graph.at(to_fraction(seen[i, 0])) == phi[i] for i, graph in enumerate(own))
    require(fits, "phi is not that of sigma")
    closed = closed_by(asked, [low for low, _ in asked.bounds])
    if closed is None or (closed - still).det() == 0:
        raise NotShown("where the loop at the lower bounds has an eigenvalue 0 (z = 1), equilibria refute nothing")


def _require_oscillation(document: Document, asked: Asked) -> None:
    """Check a periodic solution with a piecewise-linear nonlinearity of the class in each channel.

    Where ``phi = K sigma + q`` the loop is ``x' = (A - B K E C) x - B (1 - K E D) q``, ``E = (1 + D K)^-1``, with
    ``sigma = E (C x - D q)``; when one ``sigma_i`` is on a kink, ``q`` and ``K`` of both sides give the same.
    """
    names = ("method", "nonlinearities", "pieces", "durations", "state", "half", "inverse", "radius", "bits")
    found = record(document.proof, *names)
    require(not asked.discrete and not asked.operators, "flows are for continuous time, and for functions")
    state, durations, half = orbit_numbers(found)
    own = _members(found["nonlinearities"], asked, half=half)
    path = [[count(piece) for piece in listed(row)] for row in listed(found["pieces"])]
    require(len(state) == asked.A.nrows() and len(durations) == len(path) > 1, "the orbit has gaps")
    fits = all(len(row) == len(own) and all(p <= len(g.kinks) for p, g in zip(row, own, strict=True)) for row in path)
    require(fits, "there is no such piece")
    path.append([len(g.kinks) - p for p, g in zip(path[0], own, strict=True)] if half else path[0])
    crossed = list[tuple[int, int, Fraction]]()  # the channel, whether it ascends, at which kink
    for before, after in pairwise(path):
        moves = [(i, q - p) for i, (p, q) in enumerate(zip(before, after, strict=True)) if p != q]
        require(len(moves) == 1 and abs(moves[0][1]) == 1, "the pieces do not follow one another")
        i, up = moves[0]
        crossed.append((i, up, own[i].kinks[min(before[i], after[i])][0]))
    i, up, level = crossed[-1]
    into = [(i, -up, -level) if half else crossed[-1], *crossed]
    stays, known = list[Stay](), dict[tuple[int, ...], tuple[fmpq_mat, fmpq_mat]]()
    for row, entered, left in zip(path, into, crossed, strict=False):
        if tuple(row) not in known:
            known[tuple(row)] = _on_pieces(asked, own, row)
        G, seen = (_fractions(M) for M in known[tuple(row)])
        watched = tuple(
            Watched(
                row=seen[i],
                low=g.kinks[p - 1][0] if p else None,
                high=g.kinks[p][0] if p < len(g.kinks) else None,
                enters=entered[1] * (entered[0] == i),
                leaves=left[1] * (left[0] == i),
            )
            for i, (g, p) in enumerate(zip(own, row, strict=True))
        )
        at = seen[entered[0]]
        still = (Fraction(0),) * (len(state) + 1)
        stays.append(Stay(G=(*G, still), entry=(*at[:-1], at[-1] - entered[2]), watched=watched))
    require_periodic(stays, state, durations, half=half)


def _require_hysteresis(document: Document, asked: Asked) -> None:
    """Check a periodic solution with one play or stop, of half-width 1, the other channels having constant gains.

    While ``p`` rests ``xi = sigma - p`` falls from 1 to -1 with ``sigma``; while ``xi`` rests ``p`` falls.
    """
    names = ("method", "gains", "durations", "state", "half", "inverse", "radius", "bits")
    found = record(document.proof, *names)
    state, durations, half = orbit_numbers(found)
    gains, n = nearby_member(found["gains"], asked), asked.A.nrows()
    own = [i for i, one in enumerate(asked.nonlinearities) if one.memory is not None]
    require(len(own) == 1 and not asked.operators and not asked.discrete, "one play or stop in continuous time")
    require(half and len(durations) == 2 and len(state) == n + 1, "the orbit has two parts and a state more")
    i, slope = own[0], gains[own[0]]
    require(slope > 0, "a slope is not positive")
    others = diagonal([Fraction(0) if j == i else gain for j, gain in enumerate(gains)])
    whole = diagonal([Fraction(1)] * len(gains)) + asked.D * others
    require(bool(whole.det() != 0), "the loop of the gains has no solution")
    inner = whole.inv()
    A, B = (
        asked.A - asked.B * others * inner * asked.C,
        asked.B * (diagonal([Fraction(1)] * len(gains)) - others * inner * asked.D),
    )
    C, D = inner * asked.C, inner * asked.D
    require(bool(D[i, i] == 0), "sigma is no function of the state alone")
    kind, g = (asked.nonlinearities[i].memory or ("", 0))[0], to_fmpq(slope)
    phi = [fmpq(0)] * n + [g] if kind == "stop" else [*(g * C[i, k] for k in range(n)), -g]
    flow = fmpq_mat(
        [[*((A[j, k] if k < n else fmpq(0)) - B[j, i] * phi[k] for k in range(n + 1)), 0] for j in range(n)]
    )
    rate = fmpq_mat([[C[i, k] for k in range(n)]]) * flow
    nothing = fmpq_mat(1, n + 2)
    (seen,), (still,), rows = _fractions(rate), _fractions(nothing), _fractions(flow)
    reached = tuple(Fraction(int(k >= n)) for k in range(n + 2))  # xi = -1
    parts = [((*rows, seen, still), seen, -1, 0), ((*rows, still, still), reached, 0, 1)]
    stays = [
        Stay(G=G, entry=entry, watched=(Watched(row=seen, low=None, high=Fraction(0), enters=first, leaves=last),))
        for G, entry, first, last in parts
    ]
    require_periodic(stays, state, durations, half=True)


def _on_pieces(asked: Asked, own: Sequence[claims.Graph], row: Sequence[int]) -> tuple[fmpq_mat, fmpq_mat]:
    """``x'`` and ``sigma`` from ``(x, 1)`` where every nonlinearity is on a piece."""
    slopes, offsets = list[Fraction](), list[Fraction]()
    for g, p in zip(own, row, strict=True):
        x, y, k = g.kinks[p - 1] if p else (g.knots[0], g.values[0], g.slopes[0])
        slopes.append(k)
        offsets.append(y - k * x)
    K, q = diagonal(slopes), fmpq_mat([[to_fmpq(v)] for v in offsets])
    whole = diagonal([Fraction(1)] * len(slopes)) + asked.D * K
    require(bool(whole.det() != 0), "on a piece the loop has no solution")
    E = whole.inv()
    gain, shift = E * asked.C, E * asked.D * q
    flow, force = asked.A - asked.B * K * gain, asked.B * (K * shift - q)
    return _beside(flow, force), _beside(gain, -1 * shift)


def _beside(left: fmpq_mat, right: fmpq_mat) -> fmpq_mat:
    """One matrix beside another."""
    return fmpq_mat([[*a, *b] for a, b in zip(left.tolist(), right.tolist(), strict=True)])


def _fractions(M: fmpq_mat) -> list[tuple[Fraction, ...]]:
    return [tuple(to_fraction(v) for v in row) for row in M.tolist()]


def _ramp(first: arb_mat, last: arb_mat, time: arb) -> arb_mat:
    """The solution at ``t`` of ``Y' = G Y``, ``Y(0) = 1``, ``G`` going linearly from the first to the last.

    By Taylor's series on short pieces: ``(k + 1) Y_(k+1) = X Y_k + Z Y_(k-1)``, so that with ``|X| + |Z| <= q < 1/2``
    the term ``Y_k`` is at most ``q^(ceil(k/2))`` in norm, and all from the N-th on at most ``4 q^(N/2)``.
    """
    n, bits = first.nrows(), ctx.prec
    pieces = int(8 * float((time * _norm(first).max(_norm(last))).upper())) + 1
    require(pieces <= 2**15, "a stay is too long")
    whole = arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
    turn = (last - first) * (time / pieces / pieces)
    for i in range(pieces):
        tick()
        X = (first + (last - first) * (arb(i) / pieces)) * (time / pieces)
        q = _norm(X) + _norm(turn)
        require(q < arb(1) / 2, "the pieces of a stay are too long")
        older, term = arb_mat(n, n), arb_mat(n, n, [int(a == b) for a in range(n) for b in range(n)])
        total = term
        for k in range(1, bits):
            older, term = term, (X * term + turn * older) * (1 / arb(k))
            total += term
        rest = 4 * q ** (bits // 2)
        whole = (total + arb_mat(n, n, [arb(0, rest.upper())] * (n * n))) * whole
    return whole


def _norm(matrix: arb_mat) -> arb:
    """The largest sum of absolute values in a row."""
    largest = arb(0)
    for i in range(matrix.nrows()):
        largest = largest.max(sum((abs(matrix[i, j]) for j in range(matrix.ncols())), arb(0)))
    return largest


def unstable(closed: fmpq_mat, *, discrete: bool) -> str:
    """What follows of the characteristic polynomial of a loop, its roots counted by their side."""
    tick()
    p = closed.charpoly()
    require(p.degree() == closed.nrows(), "the characteristic polynomial has another degree")
    inner = mapped(p, p.degree()) if discrete else p
    counts = half_plane_counts(inner)
    at_infinity = p.degree() - inner.degree()  # z = -1
    at_zero = next(i for i in range(inner.degree() + 1) if to_fraction(inner[i]) != 0)
    require(counts.right + counts.axis + at_infinity > 0, "the loop with these gains is asymptotically stable")
    rests = counts.right == 0 and at_infinity == 0 and counts.axis == at_zero
    if rests and at_zero:  # with too few eigenvectors some solution grows like t
        rests = closed.nrows() - (closed - discrete * diagonal([Fraction(1)] * closed.nrows())).rank() == at_zero
    return claims.OTHER_EQUILIBRIA if rests else claims.NO_REST
