r"""Plants of several channels with parameters that are unknown in a box: Lyapunov matrices, box by box.

With ``c`` for the common denominator and ``R = c (A, -B)``, ``S = c (C, -D)``, ``E = (0, 1)``, all polynomials in the
parameters, the matrix of ``-V'`` less the forms of the classes is, times ``c^2``,

.. math:: -c\, \mathrm{Sym}(J'P R) - \sum_i \lambda_i\, \mathrm{Sym}((c E_i - l_i S_i)'(u_i S_i - c E_i))
    - \sum_i \theta_i\, \mathrm{Sym}(E_i'\, (c C_i) R),

less, with a rate, what Popov's terms add to ``V'`` then (:mod:`lure.analysis.certificates.second.pace`).
``J = (1, 0)``, ``Sym X = X + X'``; for an operator of norm ``u`` the same, with ``l = -u``.  In discrete time the first
term is ``c^2 J'PJ - R'PR``.  On a box ``p_j = low_j + w_j t_j``, ``P = P_0 + sum t_j P_j``, it is multiplied out in
``t``, ``0 <= t_j <= 1``, and is a mean of its Bernstein coefficients.  Where parameters change with time, ``V'`` has
``sum t_j' P_j`` besides, and their intervals are not cut.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import comb

from flint import arb_mat, fmpq_mat

from lure.analysis.certificates.second.boxes import (
    Box,
    Powers,
    bernstein,
    leaves,
    read_parameters,
    require_inside,
)
from lure.analysis.certificates.second.channel_gains import LONGEST, Step, require_outside
from lure.analysis.certificates.second.channels import Asked, closed_by, member, read, read_classes, require_uniform
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import to_fmpq, working_precision
from lure.analysis.certificates.second.pace import popov_terms
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

Polynomial = dict[Powers, fmpq_mat]
KIND, VARYING = "channel-family", "varying-family"
Rate = Fraction | None  # how fast a parameter may change; None: at any speed


@dataclass(frozen=True, kw_only=True, slots=True)
class Plants:
    """The share of each product of powers in the common denominator, 1 x 1, and in ``A``, ``B``, ``C``, ``D``."""

    discrete: bool
    box: Box
    terms: tuple[tuple[Powers, tuple[fmpq_mat, ...]], ...]
    rates: tuple[Rate, ...]

    @property
    def pattern(self) -> fmpq_mat:
        """``D`` with an entry that is not 0 where that of a plant may not be."""
        through = [sides[4] for _, sides in self.terms]
        m = through[0].nrows()
        return fmpq_mat([[int(any(D[i, j] != 0 for D in through)) for j in range(m)] for i in range(m)])

    def at(self, point: Sequence[Fraction]) -> dict[str, object]:
        """One plant, as in a file."""
        total: list[fmpq_mat] = [0 * side for side in self.terms[0][1]]
        for powers, sides in self.terms:
            weight = Fraction(1)
            for value, power in zip(point, powers, strict=True):
                weight *= value**power
            total = [whole + to_fmpq(weight) * side for whole, side in zip(total, sides, strict=True)]
        common = total[0][0, 0]
        require(common != 0, "the plant divides by 0")
        rows = {name: (side / common).tolist() for name, side in zip("ABCD", total[1:], strict=True)}
        texts = {name: [[str(v) for v in row] for row in side] for name, side in rows.items()}
        return {"kind": "multivariable", "time": "discrete" if self.discrete else "continuous", **texts}

    def within(self, box: Box) -> list[Polynomial]:
        """The denominator and the matrices in ``t``, each of which goes from 0 to 1 over the box."""
        found: list[Polynomial] = [{} for _ in self.terms[0][1]]
        for powers, sides in self.terms:
            tick()
            for turned in product(*(range(e + 1) for e in powers)):
                weight = Fraction(1)
                for (low, high), e, i in zip(box, powers, turned, strict=True):
                    weight *= comb(e, i) * low ** (e - i) * (high - low) ** i
                for whole, side in zip(found, sides, strict=True):
                    part = to_fmpq(weight) * side
                    whole[turned] = whole[turned] + part if turned in whole else part
        return [{powers: M for powers, M in side.items() if any(v != 0 for v in M.entries())} for side in found]


def read_plants(system: Mapping[str, object]) -> Plants:
    """The plants of a system of several channels with parameters; ``system``: the system of a certificate.

    Raises
    ------
    NotShown
        It is none.
    """
    varying = system.get("kind") == VARYING
    found = record(system, "kind", "time", "parameters", "terms", *(("rates",) if varying else ()))
    require(varying or found["kind"] == KIND, "the kind of system is unknown")
    require(found["time"] in ("continuous", "discrete"), "time is neither continuous nor discrete")
    box = read_parameters(found["parameters"])
    terms = list[tuple[Powers, tuple[fmpq_mat, ...]]]()
    for entry in listed(found["terms"]):
        term = record(entry, "powers", "common", "A", "B", "C", "D")
        powers = tuple(count(e) for e in listed(term["powers"]))
        require(len(powers) == len(box) and max(powers) <= 40, "the powers of a term do not fit")
        rows = [[numbers(row) for row in listed(term[name])] for name in "ABCD"]
        n, m = len(rows[0]), len(rows[3])
        shapes = [(n, n), (n, m), (m, n), (m, m)]
        fit = all(
            len(side) == h and all(len(row) == w for row in side) for side, (h, w) in zip(rows, shapes, strict=True)
        )
        require(fit and n > 0 and m > 0, "the matrices of a term do not fit")
        sides = [[[number(term["common"])]], *rows]
        terms.append((powers, tuple(fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for side in sides)))
    require(len({powers for powers, _ in terms}) == len(terms), "a term is there twice")
    sizes = {(sides[1].nrows(), sides[4].nrows()) for _, sides in terms}
    require(len(sizes) == 1, "there are no terms, or with matrices of different order")
    rates: tuple[Rate, ...] = (Fraction(0),) * len(box)
    if varying:
        rates = tuple(None if rate == "inf" else number(rate) for rate in listed(found["rates"]))
        require(len(rates) == len(box) and all(r is None or r >= 0 for r in rates), "the rates do not fit")
        require(any(r is None or r > 0 for r in rates), "no parameter changes")
    return Plants(discrete=found["time"] == "discrete", box=box, terms=tuple(terms), rates=rates)


def one_member(document: Document) -> Document:
    """The document of one plant of a box, with which a refutation is about an ordinary loop.

    Raises
    ------
    NotShown
        The parameters are not in the box.
    """
    plants, found = read_plants(document.system), record(document.proof, "method", "at", "proof")
    require(found["method"] == "member", "one plant of the box is needed")
    point = require_inside(found["at"], plants.box)
    return replace(document, system=plants.at(point), proof=mapping(found["proof"]))


def require_growth(document: Document) -> None:
    """Check that some solution grows where parameters move over and over, beside gains that stay or jump.

    Parameters of a bounded rate go linearly, and then the matrix of the loop has to: ``A`` is affine in them, and
    nothing else has them.

    Raises
    ------
    NotShown
        They may not move so, or nothing is shown to grow.
    """
    plants, late = read_plants(document.system), () if document.system["time"] == "discrete" else ("times",)
    require(document.verdict == "REFUTED", "growth is no proof")
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    require(document.rate is None, "with parameters that change no rates are refuted")
    found = record(document.proof, "method", "at", "gains", "squarings", "bits", *late)
    count(found["squarings"])
    count(found["bits"], least=2)
    points = [require_inside(one, plants.box) for one in listed(found["at"])]
    loops = [read(replace(document, system=plants.at(point))) for point in points]
    require(0 < len(points) <= LONGEST, "there are no parameters, or too many")
    rows = [member(one, loops[0]) for one in listed(found["gains"])]
    times = [None] * len(rows) if plants.discrete else numbers(found["times"])
    require(len(rows) == len(points) == len(times), "parameters, gains and times do not fit")
    require(all(t is None or t > 0 for t in times), "a time is not positive")
    require(not loops[0].operators and not loops[0].performance, "operators are not covered with parameters that move")
    for one, gains in zip(loops[0].nonlinearities, zip(*rows, strict=True), strict=True):
        require(one.memory is None and not one.relu, "memory and ReLUs have no gains")
        require(
            len(set(gains)) == 1 or (one.time_varying and not one.linear), "the class has no gains that vary so fast"
        )
    going = set[int]()
    for j, rate in enumerate(plants.rates):
        path = [point[j] for point in points]
        if len(set(path)) == 1 or rate is None:
            continue
        for here, there, t in zip(path, path[1:] + path[:1], times, strict=True):
            require(t is not None and -rate * t <= there - here <= rate * t, "a parameter does not change so fast")
        going.add(j)
    for powers, (common, _, *others) in plants.terms:
        degree = sum(powers[j] for j in going)
        still = common[0, 0] == 0 and all(v == 0 for side in others for v in side.entries())
        require(degree == 0 or (degree == 1 and still), "the loop does not go linearly with its parameters")
    steps = list[Step]()
    for loop, point, after, row, t in zip(loops, points, points[1:] + points[:1], rows, times, strict=True):
        end = [after[j] if j in going else v for j, v in enumerate(point)]
        first = closed_by(loop, row)
        last = first if end == point else closed_by(read(replace(document, system=plants.at(end))), row)
        if first is None or last is None:
            raise NotShown("with some of the parameters the loop has no solution")
        steps.append((first, last, t))
    require_outside(steps)


def require_proved(document: Document) -> bool:
    """Check the inequality on boxes that cover the box, and say whether a gain is asked for.

    Raises
    ------
    NotShown
        A hypothesis fails, or it is another theorem.
    """
    plants, found = read_plants(document.system), record(document.proof, "method", "boxes")
    require(found["method"] == "boxes" and not document.multiplier, "the method does not fit a plant with parameters")
    require(document.theorem in ("diagonal-circle", "diagonal-popov"), "the theorem is not shown for all parameters")
    popov, first = document.theorem == "diagonal-popov", plants.terms[0][1]
    require(not (popov and plants.discrete), "Popov's criterion is for continuous time")
    classes, repeated = read_classes(document, plants.pattern.nrows())
    asked = Asked(
        A=first[1],
        B=first[2],
        C=first[3],
        D=plants.pattern,
        discrete=plants.discrete,
        nonlinearities=classes,
        repeated=repeated,
    )
    bounds, m = asked.bounds, len(classes)
    require(all(one.memory is None and not one.rough for one in classes), "a class is not covered with parameters")
    require(all("delay" not in one.operator for one in classes), "a delay is not covered with parameters")
    changing = [j for j, rate in enumerate(plants.rates) if rate != 0]
    for box, entry in leaves(mapping(found["boxes"]), plants.box):
        require(all(box[j] == plants.box[j] for j in changing), "the interval of a parameter that changes is cut")
        given = record(entry, "lambda", "P", "exponent", *(("theta",) if popov else ()))
        weights, theta = numbers(given["lambda"]), numbers(given["theta"]) if popov else [Fraction(0)] * m
        require_uniform(weights, asked)
        require(len(theta) == m, "the multipliers are not one for each channel")
        for i, one in enumerate(classes):
            alone = all(asked.D[i, j] == 0 for j in range(m))
            fits = alone and not one.time_varying and not one.operator
            require(theta[i] == 0 or fits, "Popov's term does not fit its channel")
            seen = [M[0][0, 0] != 0 or M[3].tolist()[i] != [0] * M[3].ncols() for M in _moved(plants, changing)]
            require(theta[i] == 0 or not any(seen), "Popov's term is about an output that changes with the parameters")
        exponent = count(given["exponent"])
        require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
        n, unit, parts = first[1].nrows(), to_fmpq(Fraction(2) ** -exponent), listed(given["P"])
        require(len(parts) in (1, 1 + len(box)), "P is not one more matrix than parameters")
        P: Polynomial = {}
        for k, part in enumerate(parts):  # P_0 + sum t_j P_j
            rows = triangle(part, n)
            own = fmpq_mat([[unit * rows[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)])
            P[tuple(int(j == k - 1) for j in range(len(box)))] = own
        c, *sides = plants.within(box)
        signs = [v[0, 0] for v in bernstein(c, _degrees(c))]
        require(all(v > 0 for v in signs) or all(v < 0 for v in signs), "the plant may divide by 0")
        rate = document.rate or Fraction(0)
        more = [
            popov_terms(turn * rate, high - low, sloped=one.slopes_within(low, high)) if turn else None
            for one, turn, (low, high) in zip(classes, theta, bounds, strict=True)
        ]
        least, falls = _forms(P, (weights, theta, more), bounds, (c, *sides), discrete=plants.discrete)
        for form in (least, *(_total(falls, more) for more in _drifts(P, c, plants, (box, m)))):
            for M in bernstein(form, _degrees(form)):
                _require_definite(M)
    return bool(asked.performance)


def _moved(plants: Plants, changing: Sequence[int]) -> list[tuple[fmpq_mat, ...]]:
    """The terms with a power of a parameter that changes."""
    return [sides for powers, sides in plants.terms if any(powers[j] for j in changing)]


def _drifts(P: Polynomial, c: Polynomial, plants: Plants, on: tuple[Box, int]) -> list[Polynomial]:
    """``-c^2 J' sum t_j' P_j J`` for the extreme ``t_j'``; ``P_j = 0`` of what may jump."""
    (box, m), zero = on, (0,) * len(plants.box)
    n = P[zero].nrows()
    left, own = _eye(n, n + m, 0), list[fmpq_mat]()
    for j, rate in enumerate(plants.rates):
        one = P.get(tuple(int(i == j) for i in range(len(box))))
        if rate == 0 or one is None:
            continue
        if rate is None or plants.discrete:
            require(all(v == 0 for v in one.entries()), "P depends on a parameter that may jump")
            continue
        own.append(to_fmpq(rate / (box[j][1] - box[j][0])) * one)
    square, found = _times(c, c), list[Polynomial]()
    for signs in product((1, -1), repeat=len(own)):
        whole = sum((sign * M for sign, M in zip(signs, own, strict=True)), 0 * P[zero])
        found.append({k: -v[0, 0] * (left.transpose() * whole * left) for k, v in square.items()})
    return found


def _forms(
    P: Polynomial,
    multiplier: tuple[Sequence[Fraction], Sequence[Fraction], Sequence[tuple[Fraction, ...] | None]],
    bounds: Sequence[tuple[Fraction, Fraction]],
    sides: tuple[Polynomial, ...],
    *,
    discrete: bool,
) -> tuple[Polynomial, Polynomial]:
    """What has to be positive definite, times ``c^2``: for ``V``, and for its fall."""
    c, A, B, C, D = sides
    zero = (0,) * len(next(iter(P)))
    n, m, (weights, theta, more) = P[zero].nrows(), len(bounds), multiplier
    left, right = _eye(n, n + m, 0), _eye(m, n + m, n)
    R = _total(_turned(A, last=left), _turned(B, last=-1 * right))
    S = _total(_turned(C, last=left), _turned(D, last=-1 * right))
    spread = _scaled(c, right)
    least = _times(_scaled(_times(c, c), _eye(n, n, 0)), P)
    if discrete:
        square = _turned(least, first=left.transpose(), last=left)
        falls = _total(square, _negative(_times(_transposed(R), _times(P, R))))
    else:
        falls = _negative(_symmetric(_times(_turned(_times(_scaled(c, _eye(n, n, 0)), P), first=left.transpose()), R)))
    for i, ((low, high), weight, turn, grown) in enumerate(zip(bounds, weights, theta, more, strict=True)):
        row = {zero: _eye(1, m, i)}
        sigma, phi = _times(row, S), _times(row, spread)
        above = _total(phi, {k: to_fmpq(-low) * M for k, M in sigma.items()})
        below = _total({k: to_fmpq(weight * high) * M for k, M in sigma.items()}, _negative(phi, weight))
        falls = _total(falls, _negative(_symmetric(_times(_transposed(above), below))))
        if turn:
            seen = _times(row, C)
            rate = _times(_turned(seen, first=to_fmpq(turn) * _eye(1, 1, 0)), R)
            own = {zero: (_eye(1, m, i) * right).transpose()}
            falls = _total(falls, _negative(_symmetric(_times(own, rate))))
            if grown is not None:  # p sigma^2 + 2 q psi sigma + r psi^2
                both = _times(_transposed(above), sigma)
                falls = _total(falls, _negative(_times(_transposed(sigma), sigma), grown[0]))
                falls = _total(falls, _negative(_symmetric(both), grown[1]))
                falls = _total(falls, _negative(_times(_transposed(above), above), grown[2]))
            end = to_fmpq(min(turn * low, turn * high))
            least = _total(least, {k: end * M for k, M in _times(_transposed(seen), seen).items()})
    return least, falls


def _require_definite(M: fmpq_mat) -> None:
    for bits in BITS:
        with working_precision(bits):
            if positive_definite(arb_mat(M)):
                return
    raise NotShown("V, or that it falls, is not shown on a box")


def _degrees(p: Polynomial) -> Powers:
    require(bool(p), "a form vanishes on a box")
    return tuple(max(column) for column in zip(*p, strict=True))


def _eye(rows: int, columns: int, start: int) -> fmpq_mat:
    return fmpq_mat([[int(j == start + i) for j in range(columns)] for i in range(rows)])


def _total(p: Polynomial, q: Polynomial) -> Polynomial:
    return {k: p[k] + q[k] if k in p and k in q else p[k] if k in p else q[k] for k in {**p, **q}}


def _negative(p: Polynomial, factor: Fraction = Fraction(1)) -> Polynomial:
    return {k: to_fmpq(-factor) * M for k, M in p.items()}


def _transposed(p: Polynomial) -> Polynomial:
    return {k: M.transpose() for k, M in p.items()}


def _symmetric(p: Polynomial) -> Polynomial:
    return _total(p, _transposed(p))


def _scaled(c: Polynomial, M: fmpq_mat) -> Polynomial:
    """A number that is a polynomial, times a matrix."""
    return {k: one[0, 0] * M for k, one in c.items()}


def _turned(p: Polynomial, *, first: fmpq_mat | None = None, last: fmpq_mat | None = None) -> Polynomial:
    """The product with matrices that do not depend on the parameters."""
    left = {k: M if first is None else first * M for k, M in p.items()}
    return {k: M if last is None else M * last for k, M in left.items()}


def _times(p: Polynomial, q: Polynomial) -> Polynomial:
    found: Polynomial = {}
    for i, M in p.items():
        tick()
        for j, N in q.items():
            k, one = tuple(a + b for a, b in zip(i, j, strict=True)), M * N
            found[k] = found[k] + one if k in found else one
    return found
