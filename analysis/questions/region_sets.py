"""What is known of the nonlinearities of a region of attraction, the region of one state, and sizes of sets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from flint import arb, fmpq_mat, fmpq_poly

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import system_of
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.nonlinearity.pieces import known_nonlinearity
from lure.analysis.nonlinearity.rational import interval_of, roots_between
from lure.analysis.numerics.polynomial import X, to_fmpq, to_fraction
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.problem import class_given
from lure.analysis.verdict import Evidence
from lure.arrays import NDArray, in_doubles, np
from lure.classes import Diagonal
from lure.errors import InputError
from lure.exact import exact_number
from lure.files.system import LoopSystem
from lure.nonlinearities import DeadZone, MovedNonlinearity, PiecewiseLinear, Tanh
from lure.nonlinearities.base import LocalSector
from lure.nonlinearities.reading import as_nonlinearity
from lure.plants.multivariable import MultivariablePlant
from lure.record import described, quantity

Exactly = tuple[tuple[Fraction, ...], ...]
Ends = tuple[Fraction | float, Fraction | float]
_BITS = 40
_TINY = Fraction(1, 2**100)
_NARROW = 24  # bits: the width of a sector for what is left over of moved limits
MOST_PIECES = 3000
_GRID = np.concatenate([np.linspace(-1, -0.005, 200), np.linspace(0.005, 1, 200)])
_FIXED = np.geomspace(1e-7, 1e7, 1400)


@described(frozen=True, kw_only=True, slots=True)
class Shape:
    """What is known of one nonlinearity: polynomials between cuts, or a sector on an interval, or bounds on demand."""

    nonlinearity: Any = quantity("The nonlinearity, or a class with a reach")
    cuts: tuple[Fraction, ...] = quantity("Where the pieces of the graph meet", default=())
    pieces: tuple[fmpq_poly, ...] = quantity(
        "The graph, exactly; no pieces where it is none of polynomials", default=()
    )
    sector: tuple[Fraction, Fraction] | None = quantity(
        "A class that holds for ``|sigma| <= reach`` alone", default=None
    )
    reach: Fraction | None = None

    @property
    def clip(self) -> tuple[Fraction, Fraction, Fraction] | None:
        """``e, u`` and the smaller limit of a line with limits on both sides; None for others."""
        if len(self.pieces) != 3 or max(p.degree() for p in self.pieces) > 1 or not self.cuts[0] < 0 < self.cuts[1]:
            return None
        left, middle, right = self.pieces
        low, high = sorted((to_fraction(left[0]), to_fraction(right[0])))
        if left[1] != right[1] or not low < 0 < high:
            return None
        return to_fraction(left[1]), to_fraction(middle[1]), min(-low, high)

    @property
    def kind(self) -> Any:  # noqa: ANN401  (a nonlinearity)
        """The nonlinearity, or that which it is around another point."""
        return self.nonlinearity.nonlinearity if isinstance(self.nonlinearity, MovedNonlinearity) else self.nonlinearity

    @property
    def steepest(self) -> Fraction:
        """The largest slope of the lines among the pieces, 0 without any."""
        return max((abs(to_fraction(p[1])) for p in self.pieces if p.degree() == 1), default=Fraction(0))

    def parts(self) -> Iterator[tuple[Any, Any, fmpq_poly]]:
        """The pieces with their ends."""
        ends: list[Any] = [-math.inf, *self.cuts, math.inf]
        return ((low, high, p) for (low, high), p in zip(pairwise(ends), self.pieces, strict=False))

    def entry(self, bounds: tuple[Fraction, Fraction, Fraction] | None) -> dict[str, Any]:
        """The nonlinearity as it stands in a certificate; of one that is no polynomial its bounds on an interval."""
        if self.pieces:
            return {
                "kind": "piecewise-polynomial",
                "cuts": [str(cut) for cut in self.cuts],
                "pieces": [[str(to_fraction(c)) for c in piece.coeffs()] or ["0"] for piece in self.pieces],
            }
        if self.sector is not None:
            low, high, reach = *self.sector, self.reach
        else:
            assert bounds is not None, "nothing else is known of it"
            low, high, reach = bounds
        return {"kind": "sector", "sector": [str(low), str(high)], "reach": str(reach)}

    def primitive(self, sigma: NDArray[np.float64]) -> NDArray[np.float64]:
        """``int_0^sigma phi`` of polynomials between cuts, elementwise, in floating point."""
        parts = [np.polynomial.Polynomial([float(to_fraction(c)) for c in p.coeffs()] or [0.0]) for p in self.pieces]
        whole = [part.integ() for part in parts]
        cuts = [float(cut) for cut in self.cuts]
        steps = np.cumsum(
            [0.0, *(left(cut) - right(cut) for cut, (left, right) in zip(cuts, pairwise(whole), strict=True))]
        )
        place = np.searchsorted(cuts, sigma)
        values = np.stack([part(sigma) + step for part, step in zip(whole, steps, strict=True)])
        zero = int(np.searchsorted(cuts, 0.0))
        found = np.take_along_axis(values, np.atleast_1d(place)[None], axis=0)[0]
        return np.asarray(found - (whole[zero](0.0) + steps[zero])).reshape(np.shape(sigma))

    def exact_primitive(self, sigma: Fraction) -> Fraction:
        """The same at an exact point, exactly."""
        side, total, at = (1 if sigma >= 0 else -1), Fraction(0), Fraction(0)
        cuts = sorted((cut for cut in self.cuts if 0 < side * cut < side * sigma), key=abs)
        for end in (*cuts, sigma):
            middle = (at + end) / 2
            whole = self.pieces[sum(cut < middle for cut in self.cuts)].integral()
            total += to_fraction(whole(to_fmpq(end)) - whole(to_fmpq(at)))
            at = end
        return total

    def sampled(self, reach: float) -> tuple[float, float] | None:
        """About the sector on ``|sigma| <= reach``, from values."""
        if self.sector is not None:
            assert self.reach is not None, "they go together"
            return (float(self.sector[0]), float(self.sector[1])) if reach <= self.reach else None
        own = _FIXED[reach > _FIXED]
        sigma = np.concatenate([reach * _GRID, own, -own])
        chords = np.asarray(self.nonlinearity(sigma)) / sigma
        return (float(chords.min()), float(chords.max())) if np.isfinite(chords).all() else None

    def bounds(self, reach: Fraction) -> tuple[Fraction, Fraction] | None:
        """The sector on ``|sigma| <= reach``, certified; None where there is none."""
        if self.sector is not None:
            return self.sector
        own = self.nonlinearity
        if type(own) is Tanh:  # in closed form
            own = MovedNonlinearity(own, Fraction(0), _TINY)
        found = nonlinearity_bounds(own, on=(-reach, reach))
        low, high = found.sector_lower.outer, found.sector_upper.outer
        if found.evidence is not Evidence.CERTIFIED or not (math.isfinite(low) and math.isfinite(high)):
            return None
        return -_above(-Fraction(low)), _above(Fraction(high))


def shape_given(entry: Mapping[str, Any]) -> Shape:
    """Polynomials between cuts, as they stand in a certificate; ``entry``: of a kind ``piecewise-polynomial``."""
    pieces = tuple(fmpq_poly([to_fmpq(Fraction(c)) for c in piece]) for piece in entry["pieces"])
    return Shape(nonlinearity=None, cuts=tuple(Fraction(cut) for cut in entry["cuts"]), pieces=pieces)


def shape_of(nonlinearity: object) -> Shape:
    """What is known of a nonlinearity exactly; ``nonlinearity``: a nonlinearity of the library, or a ``LocalSector``.

    Raises
    ------
    InputError
        It is known by its values alone.
    """
    if isinstance(nonlinearity, LocalSector):
        own = nonlinearity
        return Shape(nonlinearity=own, sector=(own.lower, own.upper), reach=own.radius)
    if isinstance(nonlinearity, MovedNonlinearity):
        return Shape(nonlinearity=nonlinearity)
    known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
    if known is None:
        raise InputError(
            f"{nonlinearity!s:.60} is known by its values alone, which bound nothing; give a formula, or one of the "
            "library"
        )
    ratios = [piece.ratio for piece in known.pieces]
    if any(r is None or r.bottom.degree() > 0 or r.poles.degree() > 0 for r in ratios):
        return Shape(nonlinearity=nonlinearity)
    polynomials = [r.top / r.bottom[0] for r in ratios if r is not None]
    cuts, kept = list[Fraction](), [polynomials[0]]
    for piece, polynomial in zip(known.pieces[1:], polynomials[1:], strict=True):
        if polynomial != kept[-1]:
            if kept[-1](to_fmpq(Fraction(piece.low))) != polynomial(to_fmpq(Fraction(piece.low))):
                return Shape(nonlinearity=nonlinearity)
            cuts.append(Fraction(piece.low))
            kept.append(polynomial)
    return Shape(nonlinearity=nonlinearity, cuts=tuple(cuts), pieces=tuple(kept))


def loop_asked(plant: object, nonlinearities: object) -> tuple[MultivariablePlant, list[Shape]]:
    """The plant, and what is known of the nonlinearity of each channel.

    ``plant``, ``nonlinearities``: as for :func:`lure.analysis.region`.

    Raises
    ------
    InputError
        A nonlinearity is missing, or is not known, or the sizes do not fit.
    """
    if isinstance(plant, LoopSystem) and nonlinearities is None:
        nonlinearities = list(plant.local or plant.nonlinearities) or plant.nonlinearity
    found = channel_plant(plant)
    listed = nonlinearities if isinstance(nonlinearities, list | tuple) else [nonlinearities]
    if listed == [None]:
        raise InputError(
            "a region of attraction is about nonlinearities that are known, and none is given; give [nonlinearity], or "
            "one for each channel"
        )
    if len(listed) != found.inputs or found.inputs != found.outputs:
        raise InputError(
            f"the nonlinearities are {len(listed)}, and the plant has {found.size}; give one for each channel"
        )
    if isinstance(nonlinearities, Diagonal) or any(class_given(one) is not None for one in listed):
        raise InputError(
            "a region of attraction is asked of a known nonlinearity in each channel, such as Saturation(1) or "
            "'tanh(sigma)', or of a class that holds on an interval, and a class is given; lure certify asks of all "
            "its members"
        )
    known = [one if isinstance(one, LocalSector) else as_nonlinearity(one) for one in listed]
    for i, one in enumerate(known, 1):
        if not getattr(one, "locally_lipschitz", True):
            raise InputError(
                f"the nonlinearity of channel {i}, {one}, is not known to be locally Lipschitz; give another"
            )
    return found, list(map(shape_of, known))


def parted(plant: MultivariablePlant, given: Sequence[Shape]) -> tuple[MultivariablePlant, list[Shape]]:
    """The loop in which a line with limits that is moved to within a radius acts in two channels that see the same.

    The first has limits that are near enough to be reached wherever it is counted from, exactly; what is left over is 0
    between them and bounded beyond, and so lies in a narrow sector.  The second is this sector.

    ``given``: what is known of the nonlinearity of each channel.
    """
    shapes, order = list[Shape](), list[int]()
    for i, one in enumerate(given):
        moved = one.nonlinearity
        parts = _clip_and_rest(moved) if isinstance(moved, MovedNonlinearity) else None
        shapes += [one] if parts is None else parts
        order += [i] * (1 if parts is None else 2)
    if len(order) == len(given):
        return plant, shapes
    B, D = (tuple(tuple(row[i] for i in order) for row in side) for side in (plant.B, plant.D))
    return replace(plant, B=B, C=tuple(plant.C[i] for i in order), D=tuple(D[i] for i in order), names=()), shapes


def _clip_and_rest(moved: MovedNonlinearity) -> list[Shape] | None:
    """The two parts; None where it is no line with limits that holds 0 between them."""
    around = None if moved.centre is None else shape_of(moved.centre)
    if around is None or around.clip is None:
        return None
    outer, inner, _ = around.clip
    low, high = around.cuts[0] + moved.within, around.cuts[1] - moved.within
    points = [(low, inner * low), (Fraction(0), Fraction(0)), (high, inner * high)]
    clip = PiecewiseLinear(points, left_slope=outer, right_slope=outer)
    over = 2 * abs(inner - outer) * moved.within / min(-low, high)
    wide = max(over, abs(inner - outer) / 2**_NARROW)
    rest = DeadZone(width=min(-low, high), gain=wide)  # one of them, to be drawn
    return [shape_of(clip), Shape(nonlinearity=rest, sector=(-wide, wide), reach=Fraction(2**_BITS))]


def points_along(along: Sequence[Sequence[float | Fraction]], n: int) -> NDArray[np.float64]:
    """Points of the state space as an array, (k, n).

    ``along``: of numbers; ``n``: number of states.

    Raises
    ------
    InputError
        They are none, or one of them is 0.
    """
    rows = [list(point) for point in along]
    if not rows:
        raise InputError("along has no points; give one or more")
    if other := [row for row in rows if len(row) != n]:
        said = " ".join(map(str, other[0]))
        raise InputError(f"along has the point {said}, of {len(other[0])} numbers; give {n}, one for each state")
    exact = [[exact_number(v, f"along[{i}][{j}]") for j, v in enumerate(row)] for i, row in enumerate(rows)]
    if not all(map(any, exact)):
        raise InputError("along has the point 0; give points away from it")
    return in_doubles(exact)


def _above(value: Fraction) -> Fraction:
    """The number itself if it is short, else one of few digits that is not below it."""
    if value.denominator.bit_length() < 2 * _BITS:
        return value
    unit = Fraction(2) ** (math.floor(math.log2(abs(value))) - _BITS)
    return math.ceil(value / unit) * unit


def levels(D: Sequence[Sequence[Fraction]]) -> list[list[int]] | None:
    """The channels in groups, of which each is fed by the ones before alone; None where ``D`` has a cycle.

    ``D``: (m, m), ``sigma = C x - D phi``.
    """
    left, found = set(range(len(D))), list[list[int]]()
    while left:
        free = sorted(i for i in left if not any(D[i][j] for j in left))
        if not free:
            return None
        found.append(free)
        left -= set(free)
    return found


def plus(P: Sequence[Sequence[Fraction]], factor: Fraction, row: Sequence[Fraction]) -> Exactly:
    """A form with a multiple of a square added; ``P``: the form; ``factor``: of the square of ``row``."""
    return tuple(
        tuple(v + factor * a * b for v, b in zip(line, row, strict=True)) for line, a in zip(P, row, strict=True)
    )


# One state: signs.


def ends_of(shown: Proved | Refuted) -> Ends:
    """The ends of the interval of a proof or refutation by signs; ``shown``: of :func:`sign_interval`."""
    low, high = (end if end in ("inf", "-inf") else Fraction(end) for end in shown.certificate["proof"]["interval"])
    return float(low) if isinstance(low, str) else low, float(high) if isinstance(high, str) else high


def sign_interval(plant: MultivariablePlant, shapes: Sequence[Shape]) -> tuple[Proved | None, Refuted | None] | None:
    """Of a loop with one state the interval from which all solutions tend to 0, and that outside which none does.

    Returns
    -------
    tuple or None
        The proof and the refutation of what lies outside, as far as they are found; None where the loop has another
        number of states, ``D`` is not 0 or a nonlinearity is not known exactly.
    """
    if plant.order != 1 or any(map(any, plant.D)) or not all(shape.pieces for shape in shapes):
        return None
    rows = [row[0] for row in plant.C]
    cuts = sorted({Fraction(0), *(x / c for shape, c in zip(shapes, rows, strict=True) if c for x in shape.cuts)})
    whole = list[tuple[Any, Any, fmpq_poly]]()
    ends: list[Any] = [-math.inf, *cuts, math.inf]
    for low, high in pairwise(ends):
        middle = high - 1 if low == -math.inf else low + 1 if high == math.inf else (low + high) / 2
        f = to_fmpq(plant.A[0][0]) * X
        for shape, b, c in zip(shapes, plant.B[0], rows, strict=True):
            piece = shape.pieces[sum(x < c * middle for x in shape.cuts)]
            f -= to_fmpq(b) * piece(to_fmpq(c) * X)
        whole.append((low, high, f))
    discrete = plant.dt is not None
    left, right = (_first(whole, side, discrete=discrete) for side in (-1, 1))
    if left is None or right is None:
        return None, None
    (low_in, low_out), (high_in, high_out) = left, right
    if discrete:
        high_in, high_out = min(high_in, -low_in), min(high_out, -low_out)
        low_in, low_out = -high_in, -high_out
    laws = {"graphs": [shape.entry(None) for shape in shapes]}
    base = {"system": system_of(plant), "laws": laws, "multiplier": {}}

    def accepted(low: Any, high: Any, **more: str) -> Any:  # noqa: ANN401  (Proved, Refuted or None)
        """What the checker makes of an interval."""
        proof = {"method": "signs", "interval": [_end(low), _end(high)]}
        try:
            return checked({**base, **more, "proof": proof})
        except (Rejected, Malformed):
            return None

    inside = accepted(low_in, high_in, verdict="PROVED", theorem="scalar")
    outside = None
    if (low_out, high_out) != (-math.inf, math.inf):
        outside = accepted(low_out, high_out, verdict="REFUTED", theorem="counterexample")
    return inside, outside


def _end(value: Fraction | float) -> str:
    return str(value) if isinstance(value, Fraction) else "inf" if value > 0 else "-inf"


def _first(whole: Sequence[tuple[Any, Any, fmpq_poly]], side: int, *, discrete: bool) -> tuple[Any, Any] | None:
    """Where the attraction ends on one side of 0: a bound inside and one outside; None if there is none near 0."""
    parts = [part for part in whole if (part[0] >= 0 if side > 0 else part[1] <= 0)][::side]
    for low, high, f in parts:
        near = low if side > 0 else high
        for p in (X - f, X + f) if discrete else (-f,):
            if p.degree() < 0:
                return None if near == 0 else (near, near)
        functions = (X - f, X + f) if discrete else (f,)
        roots = [root for p in functions for root in roots_between(p, low, high)]
        middle = _between(low, high, roots, side)
        value = f(to_fmpq(middle))
        attracted = abs(value) < abs(to_fmpq(middle)) if discrete else value * side < 0
        if not attracted:
            return None if near == 0 else (near, near)
        found = [root if isinstance(root, Fraction) else interval_of(root) for root in roots]
        spans = [(root, root) if isinstance(root, Fraction) else root for root in found]
        if spans:
            first = min(spans) if side > 0 else max(spans)
            return (first[0], first[1]) if side > 0 else (first[1], first[0])
        far = high if side > 0 else low
        if not math.isinf(far) and any(p(to_fmpq(far)) == 0 for p in functions):
            return far, far
    return side * math.inf, side * math.inf


def _between(low: Any, high: Any, roots: Sequence[Fraction | arb], side: int) -> Fraction:  # noqa: ANN401  (ends)
    """A point of the piece before the first root."""
    near, far = (low, high) if side > 0 else (high, low)
    places: list[Any] = [
        root if isinstance(root, Fraction) else interval_of(root)[0 if side > 0 else 1] for root in roots
    ]
    if places:
        far = min(places) if side > 0 else max(places)
    return near + side if math.isinf(far) else (Fraction(near) + Fraction(far)) / 2


def equilibria(plant: MultivariablePlant, shapes: Sequence[Shape]) -> tuple[tuple[Fraction, ...], ...]:
    """Isolated equilibria other than 0 where every nonlinearity is on a line, exactly: ``D = 0``."""
    n, m = plant.order, len(shapes)
    lines = [
        [(low, high, to_fraction(p[1]), to_fraction(p[0])) for low, high, p in shape.parts() if p.degree() <= 1]
        for shape in shapes
    ]
    if any(map(any, plant.D)) or math.prod(map(len, lines)) > MOST_PIECES:
        return ()
    A, B, C = (fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for side in (plant.A, plant.B, plant.C))
    still = fmpq_mat([[int(i == j) for j in range(n)] for i in range(n)]) * int(plant.dt is not None)
    found = set[tuple[Fraction, ...]]()
    for choice in product(*lines):
        slopes = fmpq_mat([[to_fmpq(choice[i][2]) if i == j else to_fmpq(0) for j in range(m)] for i in range(m)])
        whole = A - still - B * slopes * C
        if whole.det() == 0:
            continue
        x = whole.inv() * B * fmpq_mat([[to_fmpq(line[3])] for line in choice])
        sigma = [to_fraction((C * x)[i, 0]) for i in range(m)]
        if all(low <= s <= high for s, (low, high, _, _) in zip(sigma, choice, strict=True)):
            found.add(tuple(to_fraction(x[i, 0]) for i in range(n)))
    return tuple(sorted(one for one in found if any(one)))


def rests_at_0(plant: MultivariablePlant, shapes: Sequence[Shape]) -> bool:
    r"""Whether 0 is shown to be the only equilibrium, exactly.

    At one :math:`A x = B \phi` (in discrete time ``A - I`` for ``A``), so that :math:`N B \phi = 0` for the rows
    ``N`` with ``N A = 0``.  Where ``N B`` has as many independent columns as there are channels, every ``phi_i`` is 0;
    with it ``sigma_i`` where ``phi_i`` has no other zero, and then ``A x = 0`` and ``C x = 0``.
    """
    n, m = plant.order, len(shapes)
    A, B, C = (fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for side in (plant.A, plant.B, plant.C))
    A -= fmpq_mat([[int(i == j) for j in range(n)] for i in range(n)]) * int(plant.dt is not None)
    # rank [A B] = rank A + rank N B
    beside = fmpq_mat([[*a, *b] for a, b in zip(A.tolist(), B.tolist(), strict=True)])
    below = fmpq_mat([*A.tolist(), *C.tolist()])
    if beside.rank() - A.rank() < m or below.rank() < n:
        return False
    return all(_vanishes_at_0_alone(shape) for shape in shapes)


def _vanishes_at_0_alone(shape: Shape) -> bool:
    """Whether ``phi(sigma) != 0`` is known for all ``sigma`` but 0."""
    if not shape.pieces:
        return isinstance(shape.nonlinearity, Tanh)
    for low, high, p in shape.parts():
        if p.degree() < 0 or any(root != 0 or not isinstance(root, Fraction) for root in roots_between(p, low, high)):
            return False
        if any(not math.isinf(end) and end != 0 and p(to_fmpq(end)) == 0 for end in (low, high)):
            return False
    return True


def volume_below(P: Sequence[Sequence[Fraction]]) -> float:
    """A lower bound of the length, area or volume of ``{x : x'P x <= 1}``.

    ``P``: symmetric, positive definite.
    """
    return _volume(P) * (1 - 1e-12)


def volume_above(Q: Sequence[Sequence[Fraction]]) -> float | None:
    """An upper bound of the same; None where the set has no finite one.

    ``Q``: symmetric.
    """
    return _volume(Q) * (1 + 1e-12) if positive(Q) else None


def positive(P: Sequence[Sequence[Fraction]]) -> bool:
    """Whether a symmetric matrix is positive definite, by its leading minors."""
    return all(_determinant([row[:k] for row in P[:k]]) > 0 for k in range(1, len(P) + 1))


def _determinant(P: Sequence[Sequence[Fraction]]) -> Fraction:
    return to_fraction(fmpq_mat([[to_fmpq(v) for v in row] for row in P]).det())


def _volume(P: Sequence[Sequence[Fraction]]) -> float:
    n, determinant = len(P), _determinant(P)
    bits = 128 + 2 * max(0, determinant.numerator.bit_length() - determinant.denominator.bit_length())
    root = Fraction(math.isqrt((determinant.denominator << 2 * bits) // determinant.numerator), 1 << bits)
    return float(float(root) * math.pi ** (n / 2) / math.gamma(n / 2 + 1))


def matrix_of(certificate: Mapping[str, Any], name: str = "P") -> tuple[tuple[Fraction, ...], ...]:
    """The matrix of a certificate; ``name``: ``P`` or ``Q``."""
    rows = certificate["proof"][name]
    n = len(rows)
    return tuple(tuple(Fraction(rows[max(i, j)][min(i, j)]) for j in range(n)) for i in range(n))


def strips(certificate: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """On what interval each local bound was used, one entry a channel.

    ``certificate``: the certificate of an ellipsoid.
    """
    for term in certificate["multiplier"]["terms"]:
        if "sector" in term:
            yield {
                "channel": term["channel"],
                "sector": term["sector"],
                "interval": [f"-{term['reach']}", term["reach"]],
            }
        else:
            yield {"channel": term["channel"], "row": term["row"]}
