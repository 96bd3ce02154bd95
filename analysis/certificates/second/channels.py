"""The plant and the classes of several nonlinearities, read again, and the algebra of their loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat, fmpq_mat

from lure.analysis.certificates.second.classes import (
    FULL_BLOCK,
    SCALAR,
    Nonlinearities,
    read_memory,
    read_nonlinearities,
    read_operator,
)
from lure.analysis.certificates.second.numerics import (
    ball,
    half_plane_counts,
    to_fmpq,
)
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
)
from lure.analysis.certificates.second.systems import mapped

LARGEST, LATEST = 400, 20


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The plant and the classes of a certificate; bounds are those of ``phi_i(sigma)/sigma``.

    ``repeated`` says of each channel which is the first with the same nonlinearity.
    """

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat
    discrete: bool
    nonlinearities: tuple[Nonlinearities, ...]
    repeated: tuple[int, ...]
    delayed: bool = False  # whether delays were taken out of it: D had no cycle before
    late: tuple[tuple[Fraction, fmpq_mat], ...] = ()  # dead times T, and the C_T that shows x(t - T) to sigma
    inner: tuple[fmpq_mat, ...] = ()  # for each of them the A_T that shows x(t - T) to x', if there are such
    rates: tuple[tuple[fmpq_mat, fmpq_mat], ...] = ()  # and D_T, E_T, that show x'(t - T) to sigma and to x'
    pace: Fraction | None = None  # a rate a: each C_T and A_T is multiplied by e^(a T)

    def has_direct_term(self, i: int) -> bool:
        """Whether inputs show in output ``i`` without passing through a state."""
        p = self.D.nrows()
        now = any(self.D[i, j] != 0 for j in range(p))
        return now or any(D[i, j] != 0 for D, _ in self.rates for j in range(self.A.nrows()))

    @property
    def operators(self) -> list[list[int]]:
        """The channels of each operator, those from ``z`` to ``w`` among them."""
        firsts = [i for i in sorted(set(self.repeated)) if self.nonlinearities[i].operator]
        return [[i for i, first in enumerate(self.repeated) if first == own] for own in firsts]

    @property
    def scalar(self) -> list[list[int]]:
        """The channels of each operator that is one scalar operator in each of them."""
        return [block for block in self.operators if self.nonlinearities[block[0]].operator == SCALAR]

    @property
    def performance(self) -> list[int]:
        """The channels from ``z`` to ``w``, none where no gain is asked for."""
        return [i for i, one in enumerate(self.nonlinearities) if one.operator == "performance"]

    @property
    def bounds(self) -> list[tuple[Fraction, Fraction]]:
        """Finite bounds of every channel.

        Raises
        ------
        NotShown
            A channel has none.
        """
        ends = [nonlinearities.ends for nonlinearities in self.nonlinearities]
        if any(low is None or high is None or low >= high for low, high in ends):
            raise NotShown("a channel has no finite bounds")
        return [(low, high) for low, high in ends if low is not None and high is not None]


def read(document: Document) -> Asked:
    """The plant and the classes of a certificate."""
    late = document.system.get("kind") == "multivariable delay"
    sides, discrete = matrices(document, late=late)
    nonlinearities, repeated = read_classes(document, sides["D"].nrows())
    A, B, C, D = (sides[name] for name in "ABCD")
    found = Asked(A=A, B=B, C=C, D=D, discrete=discrete, nonlinearities=nonlinearities, repeated=repeated)
    return _delayed(document.system["late"], found) if late else found


def _delayed(value: object, asked: Asked) -> Asked:
    """The plant with its dead times."""
    require(not asked.discrete, "dead times are of continuous time")
    found, n = list[tuple[Fraction, fmpq_mat]](), asked.A.nrows()
    inner, rates, whole = list[fmpq_mat](), list[tuple[fmpq_mat, fmpq_mat]](), [listed(one) for one in listed(value)]
    require({len(one) for one in whole} in ({2}, {3}, {5}), "a dead time has its outputs, and perhaps what comes back")
    for tau, *given in whole:
        sides = list[fmpq_mat]()
        for side, height in zip(given, (asked.D.nrows(), n) * 2, strict=False):
            rows = [numbers(row) for row in listed(side)]
            require(len(rows) == height and {len(row) for row in rows} == {n}, "matrices of a dead time do not fit")
            sides.append(fmpq_mat([[to_fmpq(v) for v in row] for row in rows]))
        found.append((number(tau), sides[0]))
        inner += sides[1:2]
        rates += [(sides[2], sides[3])] if len(sides) == 4 else []
    times = [Fraction(0), *(tau for tau, _ in found)]
    require(0 < len(found) <= LATEST and all(a < b for a, b in pairwise(times)), "the dead times do not ascend from 0")
    return replace(asked, late=tuple(found), inner=tuple(inner), rates=tuple(rates))


def matrices(document: Document, *, late: bool = False) -> tuple[dict[str, fmpq_mat], bool]:
    """``A``, ``B``, ``C`` and ``D`` of a certificate by name, and whether time is discrete.

    ``late``: whether the system has dead times as well, which are read by who knows of them.
    """
    found = record(document.system, "kind", "time", "A", "B", "C", "D", *(("late",) if late else ()))
    kind = "multivariable delay" if late else "multivariable"
    require(found["kind"] == kind, "the kind of system is unknown for several nonlinearities")
    require(found["time"] in ("continuous", "discrete"), "the time is unknown")
    rows = {name: [numbers(row) for row in listed(found[name])] for name in "ABCD"}
    n, m = len(rows["A"]), len(rows["D"])
    require(0 < n <= LARGEST and 0 < m <= LARGEST, "there are no states or channels, or too many")
    for name, height, width in (("A", n, n), ("B", n, m), ("C", m, n), ("D", m, m)):
        fits = len(rows[name]) == height and all(len(row) == width for row in rows[name])
        require(fits, f"{name} does not fit the other matrices")
    sides = {name: fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for name, side in rows.items()}
    return sides, found["time"] == "discrete"


def read_classes(document: Document, m: int) -> tuple[tuple[Nonlinearities, ...], tuple[int, ...]]:
    """The class of each channel, and for each the first channel with the same nonlinearity.

    ``m``: how many channels there are.
    """
    stated = record(document.nonlinearities, "channels", "repeated")
    given = [mapping(one) for one in listed(stated["channels"])]
    repeated = _repeated(stated["repeated"], len(given))
    require(len(given) == m, "there is not one class for each channel")
    same = all(dict(given[first]) == dict(one) for first, one in zip(repeated, given, strict=True))
    require(same, "one nonlinearity has one class")
    classes = tuple(map(_read_class, given))
    last = [repeated[i] for i, one in enumerate(classes) if one.operator == "performance"]
    require(all(first == repeated[-1] for first in last), "there is more than one performance channel, or not the last")
    return classes, repeated


def _read_class(one: Mapping[str, object]) -> Nonlinearities:
    if "memory" in one:
        return read_memory(one)
    return read_operator(one) if "operator" in one else read_nonlinearities(one, rates=True)


def _repeated(stated: object, m: int) -> tuple[int, ...]:
    """For each channel the first one with the same nonlinearity: its own, or stated for all or block after block."""
    if isinstance(stated, bool):
        return (0,) * m if stated else tuple(range(m))
    firsts: list[int] = []
    for entry in listed(stated):
        size = count(entry, least=1)
        require(len(firsts) + size <= m, "more channels have the same nonlinearity than there are")
        firsts += [len(firsts)] * size
    require(len(firsts) == m, "the channels with the same nonlinearity do not add up")
    return tuple(firsts)


def cut(M: fmpq_mat, top: int, rows: int) -> fmpq_mat:
    """Some rows of a matrix; ``top``, ``rows``: the first row, and how many."""
    return fmpq_mat([[M[top + i, j] for j in range(M.ncols())] for i in range(rows)])


def acyclic(asked: Asked) -> bool:
    """Whether no product of entries of ``D`` leads from a channel back to it: the pattern is nilpotent.

    An operator leads from each of its channels to all of them, one that acts in each to that alone; from ``z`` nothing
    leads to ``w``.
    """
    if asked.delayed:
        return True
    m, alike = (
        asked.D.nrows(),
        {(i, j) for block in asked.operators if block not in asked.scalar for i in block for j in block},
    )
    out = set(asked.performance)
    pattern = fmpq_mat([[int(asked.D[i, j] != 0 and not {i, j} & out) for j in range(m)] for i in range(m)])
    spread = fmpq_mat([[int(i == j or (i, j) in alike) for j in range(m)] for i in range(m)])
    return bool((pattern * spread) ** m == fmpq_mat(m, m))


def require_uniform(weights: Sequence[Fraction], asked: Asked) -> None:
    """Check that an operator on all of its channels has one weight for them, that of the gain being positive.

    Raises
    ------
    NotShown
        It is not so.
    """
    require(len(weights) == asked.D.nrows(), "the multipliers are not one for each channel")
    require(min(weights) >= 0, "a weight is negative")
    for block in asked.operators:
        require(block in asked.scalar or len({weights[i] for i in block}) == 1, "an operator has several weights")
    require(all(weights[i] > 0 for i in asked.performance), "the performance channel has no weight")


def half_plane_stable(closed: fmpq_mat) -> bool:
    """Whether every eigenvalue of a loop in discrete time is strictly inside the unit circle."""
    p = closed.charpoly()
    inner = mapped(p, p.degree())
    counts = half_plane_counts(inner)
    return inner.degree() == closed.nrows() and (counts.right, counts.axis) == (0, 0)


def on_axis(asked: Asked) -> Asked:
    """The plant of discrete time in ``s``, ``z = (1 + s)/(1 - s)``.

    ``A``, ``B`` and ``D`` become ``A' = 1 - 2 E``, ``B' = 2 E E B``, ``D' = D - C E B``, where
    ``E = (1 + A)^-1``.

    Raises
    ------
    NotShown
        ``z = -1`` is an eigenvalue.
    """
    one = diagonal([Fraction(1)] * asked.A.nrows())
    require(bool((one + asked.A).det() != 0), "z = -1 is an eigenvalue")
    E = (one + asked.A).inv()
    return replace(asked, A=one - 2 * E, B=2 * E * E * asked.B, D=asked.D - asked.C * E * asked.B, discrete=False)


def diagonal(values: Sequence[Fraction]) -> fmpq_mat:
    """A diagonal matrix."""
    return fmpq_mat([[to_fmpq(v) if i == j else to_fmpq(0) for j in range(len(values))] for i, v in enumerate(values)])


def balls(values: Sequence[Fraction]) -> arb_mat:
    """A diagonal matrix, in balls."""
    return arb_mat([[ball(v) if i == j else arb(0) for j in range(len(values))] for i, v in enumerate(values)])


def stacked(above: fmpq_mat, below: fmpq_mat) -> fmpq_mat:
    """One matrix above another; ``above``, ``below``: as many columns each."""
    return fmpq_mat([*above.tolist(), *below.tolist()])


def joined(first: fmpq_mat, side: fmpq_mat, last: fmpq_mat, *, lower_left: fmpq_mat | None = None) -> fmpq_mat:
    """Four blocks; the lower left is that above it, turned, unless it is given."""
    under = side.transpose() if lower_left is None else lower_left
    left, right = stacked(first, under).tolist(), stacked(side, last).tolist()
    return fmpq_mat([[*a, *b] for a, b in zip(left, right, strict=True)])


def symmetric(value: object, order: int) -> fmpq_mat:
    """The symmetric matrix of a lower triangle; ``value``: rows of numbers."""
    rows = [numbers(row) for row in listed(value)]
    require([len(row) for row in rows] == [*range(1, order + 1)], "a lower triangle is missing")
    return fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(order)] for i in range(order)])


def growing_member(value: object, asked: Asked) -> list[Fraction]:
    """Gains of the class, of play and stop those that are left of them for large solutions; ``value``: numbers."""
    gains = numbers(value)
    require(len(gains) == len(asked.nonlinearities), "there is not one gain for each channel")
    others = list[Nonlinearities]()
    for gain, one in zip(gains, asked.nonlinearities, strict=True):
        if one.memory is None:
            others.append(one)
            continue
        kind, k = one.memory
        require(0 < gain <= k if kind == "play" else gain == 0, "a gain is not that of play or stop far out")
        others.append(Nonlinearities(lower=gain, upper=gain, slope=None, odd=False, time_varying=False, linear=True))
    return member(value, replace(asked, nonlinearities=tuple(others)))


def nearby_member(value: object, asked: Asked) -> list[Fraction]:
    """Gains of the class, and such as a play of a small width, or a stop of a large one, comes near to from rest.

    ``value``: numbers.
    """
    near = [
        replace(one, lower=Fraction(0), upper=one.memory[1], memory=None) if one.memory is not None else one
        for one in asked.nonlinearities
    ]
    return member(value, replace(asked, nonlinearities=tuple(near)))


def member(value: object, asked: Asked) -> list[Fraction]:
    """Gains of the class, one for each channel; ``value``: numbers."""
    gains = numbers(value)
    require(len(gains) == len(asked.nonlinearities), "there is not one gain for each channel")
    require(all(gains[i] == 0 for i in asked.performance), "the loop is closed from z to w")
    require(
        all(nonlinearities.has_gain(g) for nonlinearities, g in zip(asked.nonlinearities, gains, strict=True)),
        "a gain is not in its class",
    )
    alike = [
        one.operator == FULL_BLOCK or gains[first] == g
        for first, g, one in zip(asked.repeated, gains, asked.nonlinearities, strict=True)
    ]
    require(all(alike), "one nonlinearity, one gain")
    return gains


def centred(asked: Asked) -> Asked:
    """The loop with the gain ``c = (l + u)/2`` in place of functions of a block, and one of norm up to ``(u - l)/2``.

    Beside dead times: with functions that depend on time in place of these, where one weight is that of the block.

    Raises
    ------
    NotShown
        That loop is not well posed, or beside dead times ``D`` has a cycle.
    """
    own = [i for i, one in enumerate(asked.nonlinearities) if one.operator == FULL_BLOCK]
    if not own:
        return asked
    if asked.late:
        require(acyclic(asked), "D has a cycle of channels beside dead times and functions of a block")
        apart = [
            replace(one, operator="", time_varying=True) if i in own else one
            for i, one in enumerate(asked.nonlinearities)
        ]
        return replace(asked, nonlinearities=tuple(apart), delayed=True)
    classes, gains = list(asked.nonlinearities), [Fraction(0)] * len(asked.nonlinearities)
    for i in own:
        low, high = classes[i].lower, classes[i].upper
        if not (isinstance(low, Fraction) and isinstance(high, Fraction)):
            raise NotShown("a function of a block has no bounds")
        gains[i], radius = (low + high) / 2, (high - low) / 2
        classes[i] = replace(classes[i], operator="any", lower=-radius, upper=radius, time_varying=True)
    one, G = diagonal([Fraction(1)] * len(gains)), diagonal(gains)
    whole = one + asked.D * G
    require(bool(whole.det() != 0), "the loop with the middle gains is not well posed")
    C, D = whole.inv() * asked.C, whole.inv() * asked.D
    A, B = asked.A - asked.B * G * C, asked.B * (one - G * D)
    return replace(asked, A=A, B=B, C=C, D=D, nonlinearities=tuple(classes), delayed=asked.delayed or acyclic(asked))


def closed_by(asked: Asked, gains: Sequence[Fraction]) -> fmpq_mat | None:
    """The matrix of the loop with constant gains; None if it has no solution.

    ``asked``: the plant; ``gains``: one for each channel.
    """
    G = diagonal(gains)
    whole = diagonal([Fraction(1)] * len(gains)) + asked.D * G
    return None if whole.det() == 0 else asked.A - asked.B * G * whole.inv() * asked.C
