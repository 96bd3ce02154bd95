r"""Several channels with known dead times, checked again.

``sigma(t) = C x(t) + D mu(t) + sum_k C_k x(t - T_k)``; only what is meant for such a plant reads it.  Gains are refuted
by a zero of ``q = det(1 + H(i omega) G)``, enclosed by Krawczyk's operator in ``omega`` and one parameter of ``G``.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import acb, acb_series, arb, fmpq_poly

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channel_gains import read_jumps
from lure.analysis.certificates.second.channels import Asked, centred, diagonal, member
from lure.analysis.certificates.second.delays import refuted_by_delay, refuted_by_delayed_members
from lure.analysis.certificates.second.late_loops import LateLoop, opened, require_returning
from lure.analysis.certificates.second.numerics import ball, half_plane_counts, working_precision
from lure.analysis.certificates.second.pieces import numerators, require_pieces
from lure.analysis.certificates.second.reading import Document, count, listed, number, numbers, record, require, tick

_BITS, _MOST_CHANNELS = 256, 8


def shown_late(document: Document, asked: Asked) -> str:
    """The sentence that a certificate about a plant with dead times shows.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    require(all(one.memory is None for one in asked.nonlinearities), "play and stop are not covered beside dead times")
    proved = document.verdict == "PROVED"  # of sectors, in which ReLUs are; no gain is a ReLU
    require(proved or not any(one.relu for one in asked.nonlinearities), "ReLUs are not refuted beside dead times")
    require(not (asked.pace and asked.rates), "a neutral equation has no rate here")
    if proved:
        theorems = ("piecewise-circle", "piecewise-popov", "late-zames-falb")
        require(document.theorem in theorems, "the theorem is not for dead times")
        apart, weights = centred(asked), numbers(document.multiplier.get("lambda"))
        for block in asked.operators:
            one_weight = len({weights[i] for i in block if i < len(weights)}) == 1
            joint = asked.nonlinearities[block[0]].operator == claims.FULL_BLOCK
            require(one_weight or not joint, "a function of a block has two weights")
        if not require_pieces(document, apart):
            return claims.GAIN if asked.performance else claims.DELAYED
        return claims.EQUILIBRIA  # what depends on time shows no pole at 0
    require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    require(asked.D.nrows() <= _MOST_CHANNELS, "there are too many channels")
    if document.proof.get("method") == "delayed-members":
        return refuted_by_delayed_members(document, asked)
    if "unlimited" in document.proof:
        _require_pole(document, asked)
        return claims.UNLIMITED
    require(not asked.performance, "of a gain, members at a frequency refute beside dead times")
    if document.proof.get("method") == "delayed-gains":
        require(not asked.rates, "a neutral equation has no other delays")
        return refuted_by_delay(document, asked)
    ways = {"late-gains": _still, "late-turns": _turning, "switched-gains": _jumping}
    return ways.get(str(document.proof.get("method")), _crossing)(document, asked)


def _still(document: Document, asked: Asked) -> str:
    """Constant gains with ``det(s - M(s)) <= 0`` at 0: a root ``s >= 0``, ``x' = M x`` being the loop."""
    proof = record(document.proof, "method", "gains")
    gains, n = member(proof["gains"], asked), asked.A.nrows()
    G, outputs = diagonal(gains), sum((late for _, late in asked.late), asked.C)
    whole = diagonal([Fraction(1)] * len(gains)) + asked.D * G
    require(bool(whole.det() > 0), "det(1 + D G) > 0 fails")
    near = (asked.B * G * whole.inv() * outputs - sum(asked.inner, asked.A)).det()
    regular = near != 0 or (not asked.inner and half_plane_counts(asked.A.charpoly()).left == n)
    require(bool(near <= 0) and regular, "no root s >= 0 is shown")
    return claims.NO_REST if near != 0 else claims.OTHER_EQUILIBRIA


def _turning(document: Document, asked: Asked) -> str:
    """Constant gains with roots ``Re s > 0``, which are counted; with all gains 0 some ``s != 0``, ``Re s >= 0``."""
    gains = member(record(document.proof, "method", "gains")["gains"], asked)
    whole = diagonal([Fraction(1)] * len(gains)) + asked.D * diagonal(gains)
    require(bool(whole.det() > 0), "det(1 + D G) > 0 fails")
    if not (any(gains) or asked.inner):
        p = asked.A.charpoly()
        counts, zeros = half_plane_counts(p), next(k for k in range(p.degree() + 1) if p[k] != 0)
        zeros = zeros if asked.pace is None else 0  # at a rate a root 0 does not fall either
        require(counts.right > 0 or counts.axis > zeros, "no root s != 0, Re s >= 0, is shown")
        return claims.NO_REST
    with working_precision(_BITS):
        require(LateLoop.of(asked, gains).right_roots() > 0, "no root Re s > 0 is shown")
    return claims.NO_REST


def _jumping(document: Document, asked: Asked) -> str:
    """Gains that jump and repeat."""
    found = record(document.proof, "method", "gains", "times", "multiplier", "bits")
    require(not asked.rates, "a neutral equation has no gains that jump")
    rows, times, _ = read_jumps(found, asked)
    with working_precision(_BITS):
        require_returning([LateLoop.of(asked, row) for row in rows], times, numbers(found["multiplier"]))
    return claims.NO_REST


def _require_pole(document: Document, asked: Asked) -> None:
    """Check that constant gains leave a pole from ``w_j`` to ``z_i`` near a point of ``Re s > 0``, or at 0.

    With ``x' = M x + b w_j`` and ``z_i = c x + d w_j`` the function is ``det [[s - M, b], [-c, d]]/det(s - M)``: the
    numerator excludes 0 in the box, and Newton's operator of the denominator maps the box into itself.

    Raises
    ------
    NotShown
        It is not shown.
    """
    proof = record(document.proof, "method", "gains", "unlimited", "root", "radius")
    require(proof["method"] == "late-gains" and bool(asked.performance), "no gain is asked for")
    gains, places = member(proof["gains"], asked), [count(v, least=1) for v in listed(proof["unlimited"])]
    (x, y), r, own = numbers(proof["root"]), number(proof["radius"]), sorted(asked.performance)
    require(len(places) == 2 and max(places) <= len(own), "an output and an input are named")
    i, j = (own[place - 1] for place in places)
    with working_precision(_BITS):
        loop = LateLoop.of(asked, gains)
        if x == y == r == 0:
            bottom, top = loop.at_rest(), loop.at_rest((i, j))
            require(bool(bottom == 0 and top != 0), "0 is no pole from w to z")
            return
        require(0 < r < x, "the pole is not in Re s > 0")
        wide = acb(ball(x - r).union(ball(x + r)), ball(y - r).union(ball(y + r)))
        below, here = (loop.determinant(acb_series([s, acb(1)])) for s in (wide, acb(ball(x), ball(y))))
        above = loop.determinant(acb_series([wide]), (i, j))
        require(not below[1].contains(0), "the root is not simple")
        inner = acb(ball(x), ball(y)) - here[0] / below[1]
        require(bool(wide.contains_interior(inner)), "no root is shown there")
        require(not above[0].contains(0), "w does not move what grows, or z does not see it")


def _crossing(document: Document, asked: Asked) -> str:
    """A zero of ``q`` for one ``omega`` between two and ``G`` between two."""
    proof = record(document.proof, "method", "gains", "frequencies", "turn")
    require(proof["method"] == "late-crossing", "the method is not for dead times")
    rows, band = [member(row, asked) for row in listed(proof["gains"])], numbers(proof["frequencies"])
    asked, inner = opened(asked)
    rows = [row + inner for row in rows]
    require(len(rows) == len(band) == 2 and 0 < band[0] < band[1], "there are not two ends of each")
    numbers(proof["turn"])
    d = asked.A.charpoly()
    parts = [(Fraction(0), numerators((asked.A, asked.B, asked.C, asked.D))[1])]
    moved = [D for D, _ in asked.rates] or [0 * C for _, C in asked.late]
    for (tau, C), D in zip(asked.late, moved, strict=True):
        parts.append((tau, numerators((asked.A, asked.B, C + D * asked.A, D * asked.B))[1]))
    with working_precision(_BITS):
        found = _Response(d, parts, rows)
        t, omega = (arb(0.5), arb(0).union(arb(1))), (ball((band[0] + band[1]) / 2), ball(band[0]).union(ball(band[1])))
        (value, a, b), (_, u, v) = found.at(t[0], omega[0]), found.at(t[1], omega[1])
        det = a.real * b.imag - a.imag * b.real
        require(bool(det != 0), "the root is not simple")
        inverse = [[b.imag / det, -b.real / det], [-a.imag / det, a.real / det]]
        inverse = [[x.mid() for x in row] for row in inverse]
        J = [[u.real, v.real], [u.imag, v.imag]]
        f = [value.real, value.imag]
        away = [t[1] - t[0], omega[1] - omega[0]]
        for k, (centre, whole) in enumerate(((t[0], t[1]), (omega[0], omega[1]))):
            rest = [arb(int(j == k)) - sum((inverse[k][i] * J[i][j] for i in range(2)), arb(0)) for j in range(2)]
            image = centre - inverse[k][0] * f[0] - inverse[k][1] * f[1] + rest[0] * away[0] + rest[1] * away[1]
            require(bool(whole.contains_interior(image)), "no root is shown between the gains and the frequencies")
    return claims.NO_REST


class _Response:
    """``q = det(1 + H G)`` and its derivatives."""

    def __init__(
        self, d: fmpq_poly, parts: Sequence[tuple[Fraction, list[list[fmpq_poly]]]], gains: Sequence[Sequence[Fraction]]
    ) -> None:
        self.d, self.parts, self.gains = d, parts, gains

    def at(self, t: arb, omega: arb) -> tuple[acb, acb, acb]:
        """``q``, and its derivatives in ``t`` and in ``omega``."""
        by_t = self._q(acb_series([acb(t), acb(1)]), acb_series([acb(omega)]))
        by_omega = self._q(acb_series([acb(t)]), acb_series([acb(omega), acb(1)]))
        return by_t[0], by_t[1], by_omega[1]

    def _q(self, t: acb_series, omega: acb_series) -> acb_series:
        s, m = omega * acb(0, 1), len(self.gains[0])
        below = _value(self.d, s)
        require(not below[0].contains(0), "d may vanish between the frequencies")
        waits = [(s * -ball(tau)).exp() for tau, _ in self.parts]
        G = [t * ball(h - g) + acb(ball(g)) for g, h in zip(*self.gains, strict=True)]
        rows = []
        for i in range(m):
            line = [
                sum((w * _value(N[i][j], s) for w, (_, N) in zip(waits, self.parts, strict=True)), 0 * s)
                for j in range(m)
            ]
            rows.append([v / below * G[j] + int(i == j) for j, v in enumerate(line)])
        return _determinant(rows)


def _value(p: fmpq_poly, s: acb_series) -> acb_series:
    total = 0 * s
    for c in reversed(p.coeffs()):
        total = total * s + acb(arb(c))
    return total


def _determinant(rows: list[list[acb_series]]) -> acb_series:
    """By the first column."""
    tick()
    if len(rows) == 1:
        return rows[0][0]
    total = 0 * rows[0][0]
    for i, row in enumerate(rows):
        rest = [other[1:] for k, other in enumerate(rows) if k != i]
        total += row[0] * _determinant(rest) * (-1) ** i
    return total
