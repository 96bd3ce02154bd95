"""Certificates for counterexamples: a member of the class and a solution that does not come to rest, from a witness."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache, partial
from itertools import chain, pairwise
from typing import Any, Literal, cast

from flint import arb, fmpq_poly

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.balls import Ball, exponential, product
from lure.analysis.certificates.balls import ball as ball_refutations
from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import Failure, complete_and_check, guarded
from lure.analysis.certificates.growth import growth_proof
from lure.analysis.certificates.states import classes, flow_orbit, gained
from lure.analysis.certificates.systems import system_of, text, texts
from lure.analysis.counterexamples.channel_orbits import LADDER, SHARES, Course
from lure.analysis.counterexamples.linear import Realisation, growing_gains
from lure.analysis.counterexamples.piecewise import Itinerary, PiecewiseLoop, refined
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.delay import Delayed
from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_above
from lure.analysis.numerics.polynomial import exact_midpoint, real_roots
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import Evidence, Witness
from lure.analysis.wording import linear_gain
from lure.arrays import np
from lure.errors import AssumptionError, InputError, Reason
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record.values import exact_text

# Proofs for certificates that a linear gain between two others puts a root on the imaginary axis.

BITS = 384
WIDTH = 96
SAMPLES = 20_001


@dataclass(frozen=True, slots=True)
class _Curve:
    """``H`` on the axis: ``(Re H, -w Im H)`` at an exact ``w``, and guesses of where it is real."""

    parts: Callable[[Fraction], tuple[arb, arb]]
    guesses: tuple[tuple[Fraction, Fraction], ...]


def crossing_proof(
    block: RationalPlant | DelayPlant, gains: tuple[Fraction, Fraction], lower: Fraction = Fraction(0)
) -> dict[str, Any]:
    r"""The proof by ``crossing``: ``Im H`` changes sign between two frequencies, there ``-1/Re H`` is between gains.

    ``1 + g H(i omega) = 0`` at the frequency where ``Im H = 0``, for ``g = -1/Re H`` there.  In discrete time
    ``z = (1 + i omega)/(1 - i omega)``.

    ``gains``: two gains with such a one strictly between them; ``lower``: with dead time a gain with which the loop is
    stable, or has a simple root 0 besides.

    Returns
    -------
    dict
        ``proof`` of the certificate, the frequencies so close to each other that the gain stays between the two.

    Raises
    ------
    AssumptionError
        No such frequency was found.

    Notes
    -----
    Where the curve ``H`` only touches the real axis, ``Im H`` has a double root between the frequencies and changes
    no sign; a polynomial is then decided by Sturm's theorem.
    """
    with working_precision(BITS):
        curve = _delayed(block.closed(lower)) if isinstance(block, DelayPlant) else _rational(block)
        for a, b in curve.guesses:
            for low, high in _narrowed(curve, a, b):
                ends = [ball(lower) - 1 / curve.parts(omega)[0] for omega in (low, high)]
                if all(ball(gains[0]) < end < ball(gains[1]) for end in ends):
                    return {"method": "crossing", "gains": texts(gains), "frequencies": texts((low, high))}
    raise AssumptionError(f"no root on the axis was found for gains between {float(gains[0])} and {float(gains[1])}")


def _narrowed(curve: _Curve, a: Fraction, b: Fraction) -> Iterator[tuple[Fraction, Fraction]]:
    """The interval after bisection, if ``Im H`` changes sign on it; else as it is."""
    sign = curve.parts(a)[1] > 0
    if not curve.parts(a)[1] * curve.parts(b)[1] < 0:
        yield a, b
        return
    while (b - a) * 2**WIDTH > b:
        middle = (a + b) / 2
        slope = curve.parts(middle)[1]
        if not (slope > 0 or slope < 0):
            break
        a, b = (middle, b) if (slope > 0) == sign else (a, middle)
    yield a, b


def _rational(block: RationalPlant) -> _Curve:
    plant = TransferPolynomials.of(block)
    response = plant.response

    def at(p: fmpq_poly, x: arb) -> arb:
        """``p(x)``."""
        value = arb(0)
        for c in reversed(p.coeffs()):
            value = value * x + arb(c)
        return value

    def parts(omega: Fraction) -> tuple[arb, arb]:
        """``Re H`` and ``-omega Im H``."""
        x = ball(omega * omega)
        return at(response.U, x) / at(response.D, x), at(response.W, x) / at(response.D, x)

    roots = [exact_midpoint(x.sqrt()) for x in real_roots(response.W) if x > 0] if response.W.degree() > 0 else []
    return _Curve(parts, tuple((_short(w * (1 - e)), _short(w * (1 + e))) for w in roots for e in _MARGINS))


_MARGINS = (Fraction(1, 2**WIDTH), Fraction(1, 2**40), Fraction(1, 2**20))


def _delayed(block: DelayPlant) -> _Curve:
    plant = Delayed.of(block)
    start = plant.start
    omega = np.union1d(
        np.geomspace(start * 1e-6, 64 * start, 4 * SAMPLES), np.linspace(start / SAMPLES, start, SAMPLES)
    )
    values = block.transfer(1j * omega)
    turns = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    ordered = sorted((i for i in turns.tolist() if values.real[i] < 0), key=lambda i: float(values.real[i]))
    guesses = tuple((Fraction(float(omega[i])), Fraction(float(omega[i + 1]))) for i in ordered[:8])
    return _Curve(lambda w: plant.response.parts(ball(w)), guesses)


def _short(value: Fraction) -> Fraction:
    """A rational near a positive one, of little more than ``WIDTH`` binary digits."""
    shift = WIDTH + 24 - math.frexp(float(value))[1]
    return Fraction(round(value * Fraction(2) ** shift)) / Fraction(2) ** shift


# Proofs for certificates that a loop with a piecewise-linear nonlinearity oscillates, from the record of an orbit.


def flow_orbit_proof(
    system: Mapping[str, Any], nonlinearities: Mapping[str, Any], record: Mapping[str, object]
) -> dict[str, Any]:
    r"""The proof by ``flow-orbit`` for the record of a periodic orbit in continuous time.

    The record holds doubles.  Newton's method refines first state and durations to as many bits as the checker's balls
    have; the approximate inverse of the Jacobian is rounded; the radius is a power of two well above what the refined
    orbit misses by and far below where the Jacobian has changed.  More bits and other radii are tried until the
    checker's own test passes.

    Parameters
    ----------
    system, nonlinearities : Mapping
        As in the certificate.
    record : Mapping
        ``Witness.data`` of an orbit in continuous time: ``points``, ``left_slope``, ``right_slope``, ``pieces``,
        ``durations`` [s], ``state`` (in the coordinates of the checker's realisation) and ``half``.

    Returns
    -------
    dict
        ``proof`` of the certificate.

    Raises
    ------
    Rejected
        The checker's test passes at no number of bits; its last reason.
    AssumptionError
        Newton's method does not converge from the record.
    """
    A, b, c, d, _ = realised(system, Fraction(0))
    points = [(Fraction(x), Fraction(w)) for x, w in cast("list[list[str]]", record["points"])]
    left, right = (Fraction(cast("str", record[side])) for side in ("left_slope", "right_slope"))
    graph = Graph.through(points, left, right)
    linear = Realisation(tuple(tuple(row) for row in A), tuple(b), tuple(c), d)
    loop = PiecewiseLoop.of(linear, graph)
    orbit = refined(loop, _itinerary(record))
    if orbit is None:
        raise AssumptionError("Newton's method does not lead from the record to a periodic orbit; search for it anew")
    nonlinearity = {
        "method": "flow-orbit",
        "points": [texts(point) for point in zip(graph.knots, graph.values, strict=True)],
        "left": text(left),
        "right": text(right),
        "pieces": list(orbit.pieces),
    }
    path = [*orbit.pieces, loop.mirrored(orbit.pieces[0]) if orbit.half else orbit.pieces[0]]
    exits = [loop.levels[min(p, q)] for p, q in pairwise(path)]
    entries = [-exits[-1] if orbit.half else exits[-1], *exits[:-1]]
    stays = [(loop.generators[p], (*linear.c, -y)) for p, y in zip(orbit.pieces, entries, strict=True)]
    course = Course(stays, orbit.state, orbit.durations, orbit.half)
    last = Rejected("no number of bits was tried")
    for bits in LADDER:
        numbers = course.numbers(bits)
        for share in SHARES:
            proof = {**nonlinearity, **numbers, "radius": text(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            try:
                flow_orbit((A, b, c, d), classes(nonlinearities), proof)
            except Rejected as refusal:
                last = refusal
            else:
                return proof
    raise last


def _itinerary(record: Mapping[str, object]) -> Itinerary:
    durations, state = (tuple(map(Fraction, cast("list[float]", record[name]))) for name in ("durations", "state"))
    pieces = tuple(cast("list[int]", record["pieces"]))
    return Itinerary(pieces=pieces, durations=durations, state=state, half=bool(record["half"]))


Block = RationalPlant | DelayPlant | StateSpace
Nonlinearities = Mapping[str, Any]

_JUST_ABOVE = Fraction(1, 1000)
REFUTATIONS_LADDER = (192, 320, 640, 1280, 2560, 4096)
SQUARINGS = 64
LATE = "gains", "times", "multiplier", "bits"


def refutation_draft(
    block: Block,
    witness: Witness,
    nonlinearities: Nonlinearities | None = None,
    *,
    numbers: Literal["rationals", "decimals as written", "doubles, exactly"] = "rationals",
) -> dict[str, Any]:
    r"""The certificate for a witness, without what :func:`lure.analysis.certificates.drafts.completed` fills in.

    Parameters
    ----------
    block : RationalPlant, DelayPlant or StateSpace
        The block for which the witness was found.
    witness : Witness
        CERTIFIED, of any kind.
    nonlinearities : Mapping, optional
        The class refuted, as in the certificate; by default the smallest with the lower bound of the witness.
    numbers : str
        Where the numbers of the block came from.

    Returns
    -------
    dict
        The certificate.  Nothing is claimed by it before the checker has accepted it.

    Raises
    ------
    AssumptionError
        The witness is not CERTIFIED, or its numbers do not lead to a proof.
    Rejected
        The checker's own test of an orbit fails.
    """
    if witness.evidence is not Evidence.CERTIFIED:
        raise AssumptionError(f"only a certified witness becomes a certificate; this one is {witness.evidence}")
    system = system_of(block)
    asked = smallest_class(block, witness) if nonlinearities is None else nonlinearities
    return {
        "format": "lure-certificate/1",
        "verdict": "REFUTED",
        "convention": "sigma = H mu, mu = -phi(sigma)",
        "numbers": numbers,
        "system": system,
        "laws": dict(asked),
        "law": None,
        "theorem": "counterexample",
        "multiplier": {},
        "proof": _proof(block, witness, system, asked),
    }


def smallest_class(block: Block, witness: Witness) -> dict[str, Any]:
    """The smallest class of the witness, as in a certificate: from its lower bound to its largest gain.

    ``witness``: the witness; its ``k`` is rounded up, and the exact one is taken from its data where they hold it.
    """
    data = witness.data
    if "pieces" in data:
        points = sorted((Fraction(x), Fraction(w)) for x, w in cast("list[list[str]]", data["points"]))
        inner = [(w - v) / (x - y) for (y, v), (x, w) in pairwise(points)]
        slopes = [*inner, _number(data["left_slope"]), _number(data["right_slope"])]
        if not witness.slope_restricted:
            slopes = [*(w / x for x, w in points if x), *slopes[-2:]]
        low, high = min(slopes), max(slopes)
    elif witness.kind == "linear gain":
        low = _number(data.get("lower", "0"))
        single = isinstance(data.get("gain"), str)
        high = _gain(block, data, None) if single and isinstance(block, RationalPlant) else Fraction(witness.k)
        high = high if high > low else low + 1
    else:
        low, high = _number(data["lower"]), _number(data.get("upper", data.get("k")))
    bounds = [text(low), text(high)]
    return {
        "sector": bounds,
        "slope": list(bounds) if witness.slope_restricted else None,
        "odd": witness.odd,
        "time_varying": witness.time_varying,
        "linear": witness.kind == "linear gain",
    }


def _proof(block: Block, witness: Witness, system: Mapping[str, Any], nonlinearities: Nonlinearities) -> dict[str, Any]:
    data = witness.data
    if witness.kind == "switched gain":
        late = isinstance(block, DelayPlant)
        return {"method": "switched-gain", **{key: data[key] for key in LATE}} if late else _switched(system, data)
    if "pieces" in data:
        return flow_orbit_proof(system, nonlinearities, data)
    if "sigma" in data:
        lower = str(data["lower"])
        return {
            "method": "orbit",
            "left": lower,
            "right": lower,
            **{key: data[key] for key in ("points", "u", "sigma")},
        }
    top = _upper(nonlinearities)
    if isinstance(block, DelayPlant):
        low, high = (Fraction(end) for end in cast("list[float]", data["gain"]))
        at_zero = _static(block)
        if at_zero is not None and low <= at_zero <= high:
            return {"method": "linear-gain", "gain": text(at_zero)}
        return crossing_proof(block, (low, high if top is None else min(high, top)), _number(data["lower"]))
    if isinstance(block, StateSpace):
        return growth_proof(system, _number(data["gain"]))
    if "gain_low" in data:
        low, high = _number(data["gain_low"]), _number(data["gain_high"])
        return crossing_proof(block, (max(low, _number(data["lower"])), high if top is None else min(high, top)))
    return {"method": "linear-gain", "gain": text(_gain(block, data, top))}


def _gain(block: RationalPlant, data: Mapping[str, object], top: Fraction | None) -> Fraction:
    """The unstable gain; one a little larger where it is a lower bound with a simple root at 0 besides stable ones.

    At an end of the class such a root refutes nothing.
    """
    gain, lower, plant = _number(data["gain"]), _number(data["lower"]), TransferPolynomials.of(block)
    if gain != lower or plant.shifted(lower).case != "critical":
        return gain
    width = _JUST_ABOVE if top is None or top - lower > _JUST_ABOVE else top - lower
    inner = (lower + width / 2**j for j in range(64))
    worse = (g for g in inner if g > lower and not is_stable_gain(block, g))
    return next((g for g in worse if plant.shifted(g).case != "critical"), gain)


def _static(block: DelayPlant) -> Fraction | None:
    """The gain with a root at 0, ``-1/H(0)``."""
    top = sum((numerator[-1] for _, numerator in block.terms), Fraction(0))
    return -sum((q[-1] for _, q in block.feedback), block.denominator[-1]) / top if top else None


def _switched(system: Mapping[str, Any], data: Mapping[str, object]) -> dict[str, Any]:
    """The pattern of gains with as few bits and squarings as show its growth."""
    A, b, c, d, discrete = realised(system, Fraction(0))
    gains, times = (cast("list[str]", data.get(name, [])) for name in ("gains", "times"))
    if any(1 + Fraction(g) * d == 0 for g in gains):
        raise AssumptionError(
            "1 + g H(inf) = 0 for one of the gains: the loop has no solution there", code=Reason.ILL_POSED
        )
    for bits in REFUTATIONS_LADDER:
        M: Ball | None = None
        for i, gain in enumerate(map(Fraction, gains)):
            G = gained(A, b, [gain * v / (1 + gain * d) for v in c])
            step = ball_refutations(G, bits) if discrete else exponential(G, Fraction(times[i]), bits)
            M = step if M is None else product(step, M)
        m = None if M is None else _squarings(M)
        if m is not None:
            pattern = {"gains": list(gains)} if discrete else {"gains": list(gains), "times": list(times)}
            return {"method": "switched-gain", **pattern, "squarings": m, "bits": bits}
    raise AssumptionError(f"the growth over one period of the gains is not shown with {REFUTATIONS_LADDER[-1]} bits")


def _squarings(M: Ball) -> int | None:
    """How often to square the matrix of a period until its trace shows growth; None if rounding hides it."""
    n = len(M.rows)
    for m in range(SQUARINGS + 1):
        trace = abs(sum(row[i] for i, row in enumerate(M.rows))) - n * M.error
        if trace > n << M.bits:
            return m
        if M.error >> M.bits:
            return None
        M = product(M, M)
    return None


def _upper(nonlinearities: Nonlinearities) -> Fraction | None:
    """The upper end of a class, None if it has none."""
    ends = [bounds[1] for bounds in (nonlinearities["sector"], nonlinearities["slope"]) if bounds is not None]
    finite = [Fraction(end) for end in ends if end not in ("inf", "finite")]
    return min(finite, default=None)


def _number(value: object) -> Fraction:
    return Fraction(cast("str", value))


# Witnesses before the checker.

_PASSING = (AssumptionError, InputError, OverflowError, ModuleNotFoundError, TimeoutError)


def accepted_witness(plant: object, witness: Witness) -> Witness:
    """The witness with what the checker accepted of it; COMPUTED where it accepted nothing.

    ``plant``: the plant; of others the witness stays as it is.  ``witness``: a destabilising member.
    """
    if witness.evidence is not Evidence.CERTIFIED or not isinstance(plant, RationalPlant | DelayPlant):
        return witness
    for candidate in chain((witness,), _just_above(plant, witness)):
        found = _accepted(plant, candidate)
        if found is not None:
            return _as_accepted(candidate, found)
    return replace(witness, evidence=Evidence.COMPUTED)


def _accepted(plant: RationalPlant | DelayPlant | StateSpace, witness: Witness) -> Refuted | None:
    """What the checker accepts of the smallest class of a witness."""
    found = guarded(witness.kind, partial(_settled, plant, witness), passing=(TimeoutError,))
    return found if isinstance(found, Refuted) else None


def _settled(plant: RationalPlant | DelayPlant | StateSpace, witness: Witness) -> Proved | Refuted:
    numbers: Literal["doubles, exactly", "rationals"] = (
        "doubles, exactly" if isinstance(plant, StateSpace) else "rationals"
    )
    return complete_and_check(refutation_draft(plant, witness, numbers=numbers))


def _as_accepted(witness: Witness, found: Refuted) -> Witness:
    """The witness with the gain of its certificate: a larger one where the gain at a critical end refutes nothing."""
    gain = found.certificate["proof"].get("gain")
    if gain is None or gain == witness.data.get("gain"):
        return replace(witness, refutation=found)
    return replace(
        witness,
        k=double_above(Fraction(gain)),
        description=f"{linear_gain(Fraction(gain))}: the loop is not asymptotically stable",
        data={**witness.data, "gain": gain},
        refutation=found,
    )


def _just_above(plant: RationalPlant | DelayPlant, witness: Witness) -> Iterator[Witness]:
    """Gains just above a linear one that only makes other equilibria: at the end of a class they refute nothing."""
    if witness.kind != "linear gain" or not isinstance(witness.data.get("gain"), str):
        return
    gain = Fraction(str(witness.data["gain"]))
    for exponent in (40, 30, 20):
        above = gain + max(abs(gain), Fraction(1, 2**exponent)) / 2**exponent
        if isinstance(plant, RationalPlant) and not is_stable_gain(plant, above):
            yield replace(
                witness,
                k=double_above(above),
                description=f"phi = k sigma, k just above {exact_text(gain, 10)}: the loop is not asymptotically "
                "stable",
                data={**witness.data, "gain": str(above)},
            )


@lru_cache(maxsize=4)
def growing_gain(block: StateSpace, lower: Fraction) -> Witness | None:
    """The smallest linear gain for which the checker accepts that a solution grows; None where none is found.

    ``lower``: least gain.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    found = guarded("linear gains", partial(_growing, block, lower), passing=_PASSING)
    return None if isinstance(found, Failure) else found


def _growing(block: StateSpace, lower: Fraction) -> Witness | None:
    for witness in growing_gains(block, lower=lower):
        checkpoint()
        found = _accepted(block, witness)
        if found is not None:
            return replace(witness, refutation=found)
    return None
