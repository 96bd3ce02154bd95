"""From where a loop recovers: sets inside its region of attraction, and sets that lie outside of it."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lure.analysis.certificates.checker import CONVERGES, Proved, Refuted
from lure.analysis.deadline import check_seconds, time_limit
from lure.analysis.drawing import drawn
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.numerics.doubles import double_above, double_below, text_above, text_below
from lure.analysis.questions.region_areas import (
    area,
    end_said,
    form_said,
    level_polygon,
    polygon_within,
    union_below,
    union_volume,
    unseen_said,
)
from lure.analysis.questions.region_curves import PlanarSets, gauge, planar_sets, points_of, within
from lure.analysis.questions.region_disturbances import ReachableSet, disturbance_of, reachable_set, unanswered
from lure.analysis.questions.region_everywhere import proved_everywhere
from lure.analysis.questions.region_proofs import (
    ellipsoids_along,
    nothing_found,
    proved_ellipsoid,
    proved_growth,
    proved_level_set,
    unstable_near_0,
)
from lure.analysis.questions.region_sets import (
    Ends,
    Shape,
    ends_of,
    equilibria,
    loop_asked,
    matrix_of,
    parted,
    plus,
    points_along,
    positive,
    shape_given,
    sign_interval,
    strips,
    volume_above,
    volume_below,
)
from lure.analysis.questions.two_sided import TwoSided
from lure.analysis.verdict import Evidence, Verdict
from lure.arrays import Reals, np
from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.multivariable import MultivariablePlant
from lure.record import Record, derived, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked

_UNITED = 3  # states, up to which several ellipsoids are looked for
_UNSTABLE = "near 0 the loop is linear and not asymptotically stable"
_ADDS = 1 + Fraction(1, 10**5)  # by which a curve makes a union larger, to be kept


def _sentence(shown: Proved | Refuted) -> str:
    conclusion = str(shown.certificate["conclusion"]).replace("motion", "solution", 1)
    return f"{conclusion[0].upper()}{conclusion[1:]}."


class AttractedSet(Record):
    """A set from which every solution tends to 0: ``V <= level``, or an open interval.

    ``V = x'P x`` of an ellipsoid, with integrals ``2 theta_i int_0^{sigma_i} phi_i`` of a level set.
    """

    kind: str = quantity("``ellipsoid``, ``level set``, ``curve``, ``interval`` or ``everything``")
    P: tuple[tuple[Fraction, ...], ...] | None = quantity("(n, n), of an ellipsoid, exactly", label="", default=None)
    level: Fraction | None = quantity("of an ellipsoid or a level set", default=None)
    integrals: tuple[Mapping[str, Any], ...] = quantity(
        "Of a level set ``x'P x + 2 sum theta_i int_0^{sigma_i} phi_i <= 1``: channel, theta, and the interval "
        "``|sigma_i| <= reach`` on which it counts",
        label="",
        default=(),
    )
    convex: bool = quantity("Whether it is known to be convex", label="", key="", default=False)
    interval: Ends | None = quantity("of a loop with one state, its ends not included", default=None)
    points: tuple[tuple[Fraction, ...], ...] | None = quantity(
        "Of a closed curve in the plane its start, then the end of each arc, before it the control point of a parabola",
        label="",
        default=None,
    )
    corners: tuple[tuple[Fraction, Fraction], ...] = quantity(
        "Of a level set in the plane, of a polygon within it", hidden=True, default=()
    )
    bounds: tuple[Mapping[str, Any], ...] = quantity(
        "What is used of each nonlinearity there: its sector on an interval of sigma; or, of a line with limits, a row "
        "``h`` with ``|h x|`` up to the limit on the set",
        label="",
        default=(),
    )
    volume: float = quantity("its length, area or volume, rounded down", form="below")
    proof: Proved = quantity("what the checker accepted", key="certificate", label="", plainly=lambda p: p.certificate)

    @property
    def bounded(self) -> bool:
        """Whether it is a bounded set of more than one state: an ellipsoid, a level set or within a closed curve."""
        return self.P is not None or self.points is not None

    def contains(self, state: Sequence[float | Fraction]) -> bool:
        """Whether a state lies in the set; a float means the double it is.

        Parameters
        ----------
        state : sequence of float or Fraction
            (n,).

        Raises
        ------
        InputError
            It is not one finite number for each state.
        """
        n = 1 if self.interval is not None else 2 if self.points else len(state) if self.P is None else len(self.P)
        if len(state) != n:
            raise InputError(f"state has {len(state)} entries, and the set has {n}; give one for each")
        x = [exact_number(v, f"state[{i}]") for i, v in enumerate(state)]
        if self.points is not None:
            return within(self.points, (x[0], x[1]))
        if self.P is None:
            return self.interval is None or self.interval[0] < x[0] < self.interval[1]
        return self.exactly(x) <= 1

    def exactly(self, x: Sequence[Fraction]) -> Fraction:
        """``V`` at a point; 2 where an interval is left.

        Parameters
        ----------
        x : sequence of Fraction
            (n,), of an ellipsoid or a level set.
        """
        value = sum((x[i] * v * x[j] for i, row in enumerate(self.P or ()) for j, v in enumerate(row)), Fraction(0))
        for row, entry, shape in self._parts():
            sigma = sum((c * v for c, v in zip(row, x, strict=True)), Fraction(0))
            if abs(sigma) > Fraction(entry["reach"]):
                return Fraction(2)
            value += 2 * Fraction(entry["theta"]) * shape.exact_primitive(sigma)
        return value

    def values(self, points: Reals) -> Reals:
        """``V`` at points, (k, n), in floating point; at most 1 on the set, ``inf`` where an interval is left.

        Of a closed curve it is the factor by which it would have to grow to reach a point.

        Parameters
        ----------
        points : ndarray
            (k, n) states.
        """
        if self.points is not None:
            return gauge(self.points)(points)
        found = np.einsum("ki,ij,kj->k", points, np.array(self.P, dtype=float), points)
        for row, entry, shape in self._parts():
            sigma = points @ np.array([float(c) for c in row])
            found = found + 2 * float(Fraction(entry["theta"])) * shape.primitive(sigma)
            found = np.where(np.abs(sigma) <= float(Fraction(entry["reach"])), found, np.inf)
        return np.asarray(found)

    def least(self) -> Reals:
        """A matrix whose form is not above ``V`` on the set."""
        found = np.array(self.P, dtype=float)
        for row, entry, _ in self._parts():
            c = np.array([float(v) for v in row])
            found = found + float(Fraction(entry["theta"]) * Fraction(entry["least"])) * np.outer(c, c)
        return found

    def _parts(self) -> Iterator[tuple[list[Fraction], Mapping[str, Any], Shape]]:
        """For each integral the row of ``sigma``, its entry and the nonlinearity, from the certificate."""
        certificate = self.proof.certificate
        for entry in self.integrals:
            i = entry["channel"] - 1
            yield (
                [Fraction(v) for v in certificate["system"]["C"][i]],
                entry,
                shape_given(certificate["laws"]["graphs"][i]),
            )

    def __str__(self) -> str:
        return _sentence(self.proof)


class OutsideSet(Record):
    """Starts from which no solution tends to 0."""

    kind: str = quantity(
        "``ellipsoid``: ``x'Q x > 1``; ``curve``: on it or outside; ``interval``: at or beyond its ends"
    )
    Q: tuple[tuple[Fraction, ...], ...] | None = quantity(
        "(n, n), exactly; it is indefinite where the plant has stable modes", label="", default=None
    )
    interval: Ends | None = quantity("of a loop with one state", default=None)
    points: tuple[tuple[Fraction, ...], ...] | None = quantity("of a closed curve, as inside", label="", default=None)
    proof: Refuted = quantity("what the checker accepted", key="certificate", label="", plainly=lambda p: p.certificate)

    def __str__(self) -> str:
        return _sentence(self.proof)


class RegionOfAttraction(TwoSided):
    """Sets inside the region of attraction of 0, and sets outside of it; ``sigma = H mu``, ``mu = -phi(sigma)``.

    PROVED: there is a set of positive volume from which every solution tends to 0.  REFUTED: there is none; the starts
    whose solutions do have volume 0.  Nothing else is said of a start that lies in none of the sets.
    """

    verdict: Verdict = quantity("PROVED: some set is; REFUTED: none is", label="")
    evidence: Evidence = quantity("of the sets", default=Evidence.CERTIFIED)
    states: int = quantity("number of states")
    sets: tuple[AttractedSet, ...] = quantity("inside the region, first the largest or what holds the points", label="")
    outside: tuple[OutsideSet, ...] = quantity("outside of it", label="", default=())
    linear: Refuted | None = quantity("of the linear loop near 0, where REFUTED", hidden=True, default=None)
    equilibria: tuple[tuple[Fraction, ...], ...] = quantity(
        "other than 0, exactly, where every nonlinearity is on a line: they are not attracted", label="", default=()
    )
    area: tuple[float, float | None] = quantity(
        "of the region: its length with one state, its area with two, else its volume; above the second no region is, "
        "None where nothing is known"
    )
    reach: float | None = quantity(
        "the largest factor of the points asked about for which they lie in the first set", default=None, form="below"
    )
    reachable: ReachableSet | None = quantity(
        "With a disturbance that moves the state: what is survived; None where nothing is proved", default=None
    )
    reason: str = quantity("why nothing is proved, or nothing of a disturbance", default="")
    stopped: str | None = quantity("``time`` where that ended the search before it was complete", default=None)
    plant: MultivariablePlant | None = quantity("the linear part, for the drawing", hidden=True, default=None)
    nonlinearities: tuple[Any, ...] = quantity("of each channel, for the drawing", hidden=True, default=())
    _schema, _kind, _said = "lure-region/1", "region of attraction", "sentence"

    @property
    def _verdict(self) -> str:
        return str(self.verdict)

    @property
    @derived()
    def criterion(self) -> str:
        """The theorem behind the first set; empty if there is none."""
        return "" if self.proof is None else self.proof.theorem

    @property
    @derived(key="nonlinearities", label="")
    def channels(self) -> tuple[str, ...]:
        """The nonlinearity of each channel, in words."""
        return tuple(map(str, self.nonlinearities))

    @property
    def discrete(self) -> bool:
        """Whether time is discrete."""
        return self.plant is not None and self.plant.dt is not None

    @property
    def proof(self) -> Proved | None:
        """Of the first set, what the checker accepted."""
        return self.sets[0].proof if self.sets else None

    @property
    def refutation(self) -> Refuted | None:
        """Of the linear loop near 0, or of the first set outside, what the checker accepted."""
        return self.linear or (self.outside[0].proof if self.outside else None)

    @property
    def _sides(self) -> tuple[Checked | None, Checked | None]:
        return self.proof, self.refutation

    plot = drawn("The sets in the plane of the first two states.")

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """What was found, a sentence each."""
        word = {1: "length", 2: "area"}.get(self.states, "volume")
        if self.linear is not None:
            said = [f"REFUTED: {self.reason}, so that almost no solution tends to 0."]
        elif not self.sets:
            said = [f"INCONCLUSIVE: no set of starts is proved to be attracted by 0: {self.reason}."]
        else:
            first = self.sets[0]
            if first.kind == "everything" and first.proof.certificate["conclusion"] == CONVERGES:
                said = [
                    "PROVED: every solution tends to 0, wherever it starts: it converges to the set of equilibria, and "
                    "0 is the only one."
                ]
            elif first.kind == "everything" or first.interval == (-math.inf, math.inf):
                said = ["PROVED: every solution tends to 0, wherever it starts."]
            elif first.interval is not None:
                low, high = map(end_said, first.interval, ("above", "below"))
                said = [f"PROVED: every solution that starts between {low} and {high} tends to 0."]
            elif first.kind == "curve":
                said = [
                    f"PROVED: every solution that starts within a closed curve of {len(first.points or ())} points "
                    f"tends to 0; its {word} is at least {text_below(first.volume, 7)}."
                ]
            else:
                size = text_below(first.volume, 7)
                where = (
                    "the ellipsoid x^T P x <= 1"
                    if first.kind == "ellipsoid"
                    else "the level set x^T P x + 2 sum theta_i int phi_i <= 1"
                )
                said = [f"PROVED: every solution that starts in {where} tends to 0; its {word} is at least {size}."]
                weights = (f", theta_{row['channel']} = {float(Fraction(row['theta'])):.7g}" for row in first.integrals)
                said += form_said("P", first.P, weights="".join(weights))
            if first.volume < self.area[0]:
                said.append(
                    f"Together with {len(self.sets) - 1} more the {word} is at least {text_below(self.area[0], 7)}."
                )
            if math.isfinite(self.area[0]):
                said += unseen_said(self.plant, word)
            if self.reach is not None:
                said.append(f"It holds the points asked about times {text_below(self.reach, 7)}.")
        for i, one in enumerate(self.outside):
            if one.interval is not None:
                low, high = map(end_said, one.interval, ("below", "above"))
                where = " or ".join([f"from {high} on"] * (high != "inf") + [f"up to {low}"] * (low != "-inf"))
                said.append(f"No solution that starts {where} tends to 0.")
            elif one.points is not None:
                inner = bool(self.sets and self.sets[0].points)
                place, ends = ("another one", "does") if inner else ("a closed curve", "tends to 0")
                said.append(f"No solution that starts on or outside {place}, of {len(one.points)} points, {ends}.")
                if "orbit" in one.proof.certificate["proof"]:
                    said[-1] += f" A periodic solution {'runs between them' if inner else 'lies within'}."
            else:
                said += ["No solution that starts where x^T Q x > 1 tends to 0.", *form_said("Q", one.Q, i)]
        if self.area[1] is not None and math.isfinite(self.area[1]):
            said.append(f"The {word} of the region is at most {text_above(self.area[1], 7)}.")
        if self.reachable is not None:
            said.append(str(self.reachable))
        elif self.sets and self.reason:
            said.append(f"{self.reason[0].upper()}{self.reason[1:]}.")
        return said


def region(
    plant: object,
    nonlinearities: object = None,
    *,
    along: Sequence[Sequence[float | Fraction]] | None = None,
    disturbance: Sequence[Sequence[float | Fraction]] | None = None,
    seconds: float | None = None,
) -> RegionOfAttraction:
    r"""Sets from which every solution of a loop tends to 0, and sets from which none does.

    For ``x' = A x + B mu``, ``sigma = C x + D mu`` (in discrete time ``x+``), ``mu_i = -phi_i(sigma_i)``, with
    nonlinearities that are known.  An ellipsoid ``V = x'P x <= 1`` is attracted by 0 if ``V`` falls on it, where each
    ``phi_i`` may be bounded by what holds on the ellipsoid alone: a sector on the interval ``|sigma_i| <= c``; or, of a
    line with limits ``phi = e sigma + p``, ``(p_0 - p)(p - h x) >= 0`` where ``|h x| <= limit``, ``p_0`` without the
    limits (the generalised sector condition) [1]_ [2]_.  In continuous time larger sets are looked for with ``V = x'P x
    + 2 sum theta_i int_0^{sigma_i} phi_i``.  With one state and polynomials between cuts the signs of ``x'`` decide.

    Parameters
    ----------
    plant : object
        Anything :func:`lure.as_plant` takes, rational and without dead time, or the system of a file.  A transfer
        function is realised in companion form, whose states are then meant.
    nonlinearities : object
        One nonlinearity, or a list of one for each channel: objects, or formulas as text; by default that of the
        system.  Or a :class:`~lure.nonlinearities.base.LocalSector`, a class known on an interval only.
    along : sequence of sequences, optional
        Points of the state space: the largest multiple of them that an ellipsoid holds is asked for, instead of the
        largest volume.
    disturbance : sequence of sequences, optional
        ``Bw``, (n, p), ``x' = .. + Bw w``: which energy of ``w`` is survived from rest, and an ellipsoid that is not
        left, are asked too.  By default the system's ``[performance]``, with its ``Dsigmaw``.
    seconds : float or None
        Time allowed.

    Returns
    -------
    RegionOfAttraction
        Its sets are certified.  What lies in none of them may be attracted or not.

    Raises
    ------
    InputError
        The plant is not rational, no nonlinearity is given, or the points are not states.

    References
    ----------
    .. [1] T. Hu, Z. Lin, Control Systems with Actuator Saturation, Birkhauser, 2001.
    .. [2] S. Tarbouriech, G. Garcia, J. M. Gomes da Silva Jr., I. Queinnec, Stability and Stabilization of Linear
       Systems with Saturating Actuators, Springer, 2011.

    Examples
    --------
    ``x' = x - sat(2 x)``: to the right of 1, ``x' = x - 1 >= 0``.

    >>> from lure import Saturation
    >>> print(region(([1], [1, -1]), Saturation(gain=2, limit=1)))
    PROVED: every solution that starts between -1 and 1 tends to 0.
    No solution that starts from 1 on or up to -1 tends to 0.
    The length of the region is at most 2.
    """
    check_seconds(seconds)
    found, shapes = parted(*(given := loop_asked(plant, nonlinearities)))
    moved = disturbance_of(plant, disturbance, (found.order, found.inputs))
    points = None if along is None else points_along(along, found.order)
    if not found.order:
        raise InputError("the plant has no states; a region of attraction needs one at least")
    began = time.monotonic()
    answer = _answered(given, (found, shapes), points, seconds)
    if moved is not None and answer.stopped is None and math.isfinite(answer.area[0]):
        try:
            with time_limit(None if seconds is None else max(1e-3, seconds - (time.monotonic() - began))):
                asked = reachable_set(found, shapes, moved)
            answer = dataclasses.replace(
                answer, reachable=asked, reason=answer.reason or unanswered(asked, shapes, moved)
            )
        except TimeoutError:
            answer = dataclasses.replace(answer, stopped="time")
    laws = tuple(shape.nonlinearity for shape in shapes)
    return dataclasses.replace(answer, equilibria=equilibria(found, shapes), plant=found, nonlinearities=laws)


def _answered(
    given: tuple[MultivariablePlant, list[Shape]],
    parts: tuple[MultivariablePlant, list[Shape]],
    points: Reals | None,
    seconds: float | None,
) -> RegionOfAttraction:
    began, (found, shapes) = time.monotonic(), parts
    proof, beyond, linear, reason = None, None, None, ""
    with suppress(TimeoutError), time_limit(seconds):
        signs = sign_interval(found, shapes)
        if signs is not None:
            return _of_signs(*signs, found, unstable_near_0(found, shapes) if signs[0] is None else None)
        beyond = proved_growth(found, shapes)
        local = beyond is not None or any(shape.reach is not None for shape in given[1])
        whole = None if local else proved_everywhere(*given)
        if whole is not None:
            one = AttractedSet(kind="everything", volume=math.inf, proof=whole)
            ends = (math.inf, math.inf)
            return RegionOfAttraction(verdict=Verdict.PROVED, states=found.order, sets=(one,), area=ends)
        proof = proved_ellipsoid(found, shapes, points)
        linear = None if proof else unstable_near_0(found, shapes)
        reason = nothing_found(found)
    outside, high = tuple[OutsideSet, ...](), None
    if beyond is not None:
        Q = matrix_of(beyond.certificate, "Q")
        outside = (OutsideSet(kind="ellipsoid", Q=Q, proof=beyond),)
        high = volume_above(Q) if found.order == 2 else None
    if proof is None:
        return _without_sets(found, linear, outside, high, reason)
    more, planar, along = None, PlanarSets((), None), list[Proved]()
    with suppress(TimeoutError), time_limit(None if seconds is None else max(1e-3, seconds + began - time.monotonic())):
        more = proved_level_set(found, shapes, proof, points)
    with suppress(TimeoutError), time_limit(None if seconds is None else max(1e-3, seconds + began - time.monotonic())):
        planar = planar_sets(found, shapes, proof)
    with suppress(TimeoutError), time_limit(None if seconds is None else max(1e-3, seconds + began - time.monotonic())):
        wanted = 1 < found.order <= _UNITED and points is None and planar.outside is None
        for longer in ellipsoids_along(found, shapes, proof) if wanted else ():
            along.append(longer)
    sets = [_set_of(one, shapes) for one in (proof, more, *along, *planar.inside) if one is not None]
    sets.sort(key=lambda one: -(one.volume if points is None else _reach(one, points)))
    if planar.outside is not None:
        around = points_of(planar.outside)
        high = min(double_above(area(around)), math.inf if high is None else high)
        outside = (OutsideSet(kind="curve", points=around, proof=planar.outside), *outside)
    low = max(one.volume for one in sets)
    if planar.inside or any(one.corners and not one.convex for one in sets):
        sets, union = _needed(sets)
        low = max(low, union)
    elif 1 < found.order <= _UNITED and len(convex := [one for one in sets if one.convex]) > 1:
        low = max(low, union_volume([one.values for one in convex], _ball(sets[0])))
    return RegionOfAttraction(
        verdict=Verdict.PROVED,
        states=found.order,
        sets=tuple(sets),
        outside=outside,
        area=(low, high),
        reach=None if points is None else _reach(sets[0], points),
    )


def _set_of(proof: Proved, shapes: Sequence[Shape]) -> AttractedSet:
    """An ellipsoid or a level set with integrals, and how large it is at least."""
    P, data = matrix_of(proof.certificate), proof.certificate["proof"]
    settings: dict[str, Any] = {
        "P": P,
        "level": Fraction(1),
        "proof": proof,
        "bounds": tuple(strips(proof.certificate)),
    }
    if data["method"] == "spiral":
        settings |= {"P": None, "level": None, "points": points_of(proof)}
        return AttractedSet(kind="curve", volume=double_below(area(settings["points"])), **settings)
    if data["method"] == "ellipsoid":
        return AttractedSet(kind="ellipsoid", volume=volume_below(P), convex=True, **settings)
    integrals = tuple(data["integrals"])
    inner, flat, known = P, P, True  # above V; below its second derivative
    rows = proof.certificate["system"]["C"]
    for entry in integrals:
        i, theta, reach = entry["channel"] - 1, Fraction(entry["theta"]), Fraction(entry["reach"])
        found = nonlinearity_bounds(shapes[i].nonlinearity, on=(-reach, reach))
        chord = (found.sector_upper if theta >= 0 else found.sector_lower).outer
        slope = found.slope_lower if theta >= 0 else found.slope_upper
        row = [Fraction(v) for v in rows[i]]
        inner = plus(inner, theta * Fraction(chord), row)
        known = known and slope is not None
        flat = flat if slope is None else plus(flat, theta * Fraction(slope.outer), row)
    convex = known and positive(flat)
    one = AttractedSet(kind="level set", integrals=integrals, convex=convex, volume=volume_below(inner), **settings)
    if known and len(P) == 2:
        corners = level_polygon(one.values, one.exactly, flat, _ball(one), convex=convex)
        volume = max(one.volume, double_below(union_below([corners]))) if corners else one.volume
        return dataclasses.replace(one, corners=tuple(corners), volume=volume)
    return one


def _needed(sets: list[AttractedSet]) -> tuple[list[AttractedSet], float]:
    """The sets without closed curves that add nothing to the others, and the area of the union, from below."""
    known = [one for one in sets if one.kind != "level set" or one.corners]
    polygons = [one.corners or polygon_within(one.points or one.P or ()) for one in known]
    whole, first = union_below(polygons), sets[0]
    kept = [polygon for one, polygon in zip(known, polygons, strict=True) if one is first or one.kind != "curve"]
    if union_below(kept) * _ADDS > whole:
        sets = [one for one in sets if one is first or one.kind != "curve"]
    return sets, double_below(whole)


def _ball(one: AttractedSet) -> Reals:
    """What makes of the unit ball about the set."""
    return np.asarray(np.linalg.cholesky(np.linalg.inv(one.least())))


def _reach(one: AttractedSet, points: Reals) -> float:
    """The largest factor, rounded down: by halving, decided exactly."""
    exact = [[Fraction(v) for v in point] for point in points.tolist()]
    low, high = Fraction(0), Fraction(1)

    def inside(factor: Fraction) -> bool:
        """Whether the set holds all points times the factor."""
        return all(one.contains([factor * v for v in point]) for point in exact)

    while inside(high):
        low, high = high, 2 * high
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if inside(middle) else (low, middle)
    return double_below(low)


def _without_sets(
    plant: MultivariablePlant, linear: Refuted | None, outside: tuple[OutsideSet, ...], high: float | None, reason: str
) -> RegionOfAttraction:
    """No set is proved.  In continuous time there is none where the loop near 0 is linear and not stable.

    The solutions that tend to 0 end in its stable subspace, and back in time a set of volume 0 stays one; in discrete
    time it need not.
    """
    never = linear is not None and plant.dt is None
    return RegionOfAttraction(
        verdict=Verdict.REFUTED if never else Verdict.INCONCLUSIVE,
        states=plant.order,
        sets=(),
        outside=outside,
        linear=linear if never else None,
        area=(0.0, 0.0 if never else high),
        reason=_UNSTABLE if linear is not None else reason or "the time allowed is over",
        stopped=None if reason else "time",
    )


def _of_signs(
    inside: Proved | None, outside: Refuted | None, plant: MultivariablePlant, linear: Refuted | None
) -> RegionOfAttraction:
    beyond, high = tuple[OutsideSet, ...](), None
    if outside is not None:
        low, top = ends = ends_of(outside)
        beyond = (OutsideSet(kind="interval", interval=ends, proof=outside),)
        high = double_above(length) if isinstance(length := top - low, Fraction) else math.inf
    if inside is None:
        return _without_sets(plant, linear, beyond, high, "no interval around 0 was found on which |x| falls")
    low, top = ends = ends_of(inside)
    volume = double_below(length) if isinstance(length := top - low, Fraction) else math.inf
    own = AttractedSet(kind="interval", interval=ends, volume=volume, proof=inside)
    return RegionOfAttraction(
        verdict=Verdict.PROVED,
        states=1,
        sets=(own,),
        outside=beyond,
        area=(volume, math.inf if volume == math.inf else high),
    )
