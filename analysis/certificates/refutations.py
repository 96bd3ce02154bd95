"""Certificates for counterexamples: a law of the class and a motion that does not come to rest, from a witness."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any, Literal, cast

from analysis.certificates.balls import Ball, ball, exponential, product
from analysis.certificates.blocks import realised
from analysis.certificates.crossings import crossing_proof
from analysis.certificates.flow_orbits import flow_orbit_proof
from analysis.certificates.growth import growth_proof
from analysis.certificates.states import gained
from analysis.certificates.systems import system_of, text
from analysis.criteria.hurwitz import is_stable_gain
from analysis.evidence import Evidence
from analysis.plant import Plant
from analysis.witness import Witness
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock

Block = RationalBlock | DelayBlock | StateSpaceBlock
Laws = Mapping[str, Any]

LADDER = (192, 320, 640, 1280, 2560, 4096)
SQUARINGS = 64


def refutation_draft(
    block: Block,
    witness: Witness,
    laws: Laws | None = None,
    *,
    numbers: Literal["rationals", "decimals as written", "doubles, exactly"] = "rationals",
) -> dict[str, Any]:
    r"""The certificate for a witness, without what :func:`analysis.certificates.drafts.completed` fills in.

    Parameters
    ----------
    block : RationalBlock, DelayBlock or StateSpaceBlock
        The block for which the witness was found.
    witness : Witness
        CERTIFIED, of any kind.
    laws : Mapping, optional
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
    asked = smallest_class(block, witness) if laws is None else laws
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
    """The smallest class of the witness, as in a certificate: from its lower bound to the largest gain of its law.

    Parameters
    ----------
    block : RationalBlock, DelayBlock or StateSpaceBlock
        The block.
    witness : Witness
        The witness; its ``k`` is rounded up, and the exact one is taken from its data where they hold it.
    """
    data = witness.data
    if "pieces" in data:
        points = sorted((Fraction(x), Fraction(w)) for x, w in cast("list[list[str]]", data["points"]))
        inner = [(w - v) / (x - y) for (y, v), (x, w) in pairwise(points)]
        slopes = [*inner, _number(data["left_slope"]), _number(data["right_slope"])]
        low, high = min(slopes), max(slopes)
    elif witness.kind == "linear gain":
        low = _number(data.get("lower", "0"))
        single = isinstance(data.get("gain"), str)
        high = _gain(block, data, None) if single and isinstance(block, RationalBlock) else Fraction(witness.k)
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


def _proof(block: Block, witness: Witness, system: Mapping[str, Any], laws: Laws) -> dict[str, Any]:
    data = witness.data
    if witness.kind == "switched gain":
        return _switched(system, data)
    if "pieces" in data:
        return flow_orbit_proof(system, laws, data)
    if "sigma" in data:
        lower = str(data["lower"])
        return {
            "method": "orbit",
            "left": lower,
            "right": lower,
            **{key: data[key] for key in ("points", "u", "sigma")},
        }
    top = _upper(laws)
    if isinstance(block, DelayBlock):
        low, high = (Fraction(end) for end in cast("list[float]", data["gain"]))
        at_zero = _static(block)
        if at_zero is not None and low <= at_zero <= high:
            return {"method": "linear-gain", "gain": text(at_zero)}
        return crossing_proof(block, (low, high if top is None else min(high, top)))
    if isinstance(block, StateSpaceBlock):
        return growth_proof(system, _number(data["gain"]))
    if "gain_low" in data:
        low, high = _number(data["gain_low"]), _number(data["gain_high"])
        return crossing_proof(block, (max(low, _number(data["lower"])), high if top is None else min(high, top)))
    return {"method": "linear-gain", "gain": text(_gain(block, data, top))}


def _gain(block: RationalBlock, data: Mapping[str, object], top: Fraction | None) -> Fraction:
    """The unstable gain; a larger one where it is a lower bound with a simple root at 0 besides stable ones.

    At an end of the class such a root refutes nothing.
    """
    gain, lower, plant = _number(data["gain"]), _number(data["lower"]), Plant.of(block)
    if gain != lower or plant.shifted(lower).case != "critical":
        return gain
    width = Fraction(1) if top is None or top - lower > 1 else top - lower
    inner = (lower + width / 2**j for j in range(64))
    worse = (g for g in inner if g > lower and not is_stable_gain(block, g))
    return next((g for g in worse if plant.shifted(g).case != "critical"), gain)


def _static(block: DelayBlock) -> Fraction | None:
    """The gain with a root at 0, ``-1/H(0)``."""
    top = sum((numerator[-1] for _, numerator in block.terms), Fraction(0))
    return -block.denominator[-1] / top if top else None


def _switched(system: Mapping[str, Any], data: Mapping[str, object]) -> dict[str, Any]:
    """The pattern of gains with as few bits and squarings as show its growth."""
    A, b, c, d, discrete = realised(system, Fraction(0))
    gains, times = (cast("list[str]", data.get(name, [])) for name in ("gains", "times"))
    if any(1 + Fraction(g) * d == 0 for g in gains):
        raise AssumptionError("1 + g H(inf) = 0 for one of the gains: the loop has no solution there")
    for bits in LADDER:
        M: Ball | None = None
        for i, gain in enumerate(map(Fraction, gains)):
            G = gained(A, b, [gain * v / (1 + gain * d) for v in c])
            step = ball(G, bits) if discrete else exponential(G, Fraction(times[i]), bits)
            M = step if M is None else product(step, M)
        m = None if M is None else _squarings(M)
        if m is not None:
            pattern = {"gains": list(gains)} if discrete else {"gains": list(gains), "times": list(times)}
            return {"method": "switched-gain", **pattern, "squarings": m, "bits": bits}
    raise AssumptionError(f"the growth over one period of the gains is not shown with {LADDER[-1]} bits")


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


def _upper(laws: Laws) -> Fraction | None:
    """The upper end of a class, None if it has none."""
    ends = [bounds[1] for bounds in (laws["sector"], laws["slope"]) if bounds is not None]
    finite = [Fraction(end) for end in ends if end not in ("inf", "finite")]
    return min(finite, default=None)


def _number(value: object) -> Fraction:
    return Fraction(cast("str", value))
