"""Check a certificate of lure in exact arithmetic, with nothing but Python's standard library.

    python checker.py certificate.json

prints ACCEPTED and the hypotheses found to hold (status 0), REJECTED and why (11), or NOT A CERTIFICATE (2).  Format
and formulas: notebooks/notes/0008-certificates.md.  Each hypothesis is recomputed from the claim; nothing is believed.
Only this file makes a ``Proved`` or a ``Refuted``; what it imports beside it, seventeen files, computes.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

if not __package__:  # run as a script: the files beside it are its package
    sys.path.append(str(Path(__file__).resolve().parents[1]))
    __package__ = Path(__file__).resolve().parent.name

from . import arithmetic as exact
from . import boxes, channels, parts, powers, regions, several, signals, states
from .arithmetic import INF, ZERO, Form, Rejected, fields, form, integer, need, number, numbers, posed, real
from .balls import box, tail
from .blocks import (
    MINUS,
    STEPS,
    Block,
    at_zero,
    block,
    critical_end,
    identity,
    linear,
    mirrored,
    multiplier,
    over_s,
    paced,
    realised,
    rod,
    shifted,
)

FORMAT, CONVENTION = "lure-certificate/1", "sigma = H mu, mu = -phi(sigma)"
ORIGINS = ("rationals", "decimals as written", "doubles, exactly")
ATTRACTS, CONVERGES = regions.ATTRACTS, "every motion converges to the set of equilibria"
BOUNDED, OTHERS = "every motion is bounded", "a loop of the class has equilibria other than 0"
FINITE_ENERGY = "0 attracts every motion with inputs to the block and initial functions of finite energy"
RESTS = "every motion of finite energy comes to rest, its end at a zero of the law"
RESTING = "every motion of finite energy comes to rest, and the pressure of every contact tends to 0"
QUIET = "every motion of finite energy comes to rest, and the pressure of every contact is square integrable"
LINEAR = "every constant gain of the class makes the loop asymptotically stable"
GAIN = "the L2 gain from w to z is at most gamma in every loop of the class"
DECAYS = "|x(t)| <= c |x(0)| {} for every motion of every loop of the class, with one c"
LATER = "|x(t)| <= c m {} for every motion of every loop of the class, m the greatest |x| before t = 0, with one c"
SLOWER = "a loop of the class has a motion for which {} does not tend to 0"
EXCEEDED = "the L2 gain from w to z is above gamma in a loop of the class"
UNLIMITED = "no L2 gain from w to z is finite for all loops of the class"
MOVES = "a loop of the class has a motion that does not converge to an equilibrium"
UNSOLVABLE = "a loop of the class is not well posed: 1 + g H(inf) = 0"
ENDS: tuple[str, ...] = ATTRACTS, MOVES, OTHERS, UNSOLVABLE, CONVERGES, BOUNDED, RESTING, GAIN, EXCEEDED, QUIET
ENDS += FINITE_ENERGY, UNLIMITED, LINEAR
HEAD = "format verdict convention numbers system laws law theorem multiplier conclusion hypotheses proof"
PACED, METHODS = ("circle", "zames-falb", "hurwitz"), ("polynomial", "cover", "matrix", "powers", "boxes")
PACED_GAINS = "linear-gain crossing matrix-gain switched-gain linear-gains switched-gains ramped-gains late-turns orbit"
SLOPED, _SEAL = ("off-axis-circle", "park", "zames-falb", "order-cone"), object()


class Checked:
    """A claim that was checked: ``facts`` were found to hold, by name; ``assumed`` is beyond the class."""

    def __init__(self, seal: object, certificate: Mapping[str, Any], facts: Mapping[str, str], assumed: str) -> None:
        if seal is not _SEAL:
            raise TypeError(f"only the checker makes a {type(self).__name__}: give the certificate to check()")
        self.certificate, self.facts, self.assumed = certificate, facts, assumed
        more = f", for which {assumed}" if assumed and "solvable" not in facts else ""
        more += f"; {facts['parameters']}" if "parameters" in facts else ""
        self.claim, self.theorem = f"{certificate['conclusion']}: {facts['class']}{more}", str(certificate["theorem"])

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles carry the certificate alone; what arrives has been checked there."""
        return check, (self.certificate,)

    __setstate__ = __init__  # a TypeError: a state in a pickle was not checked

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Checked) and self.certificate == other.certificate

    def __hash__(self) -> int:
        return hash(self.claim)


class Proved(Checked):
    """The conclusion holds for every nonlinearity of the class."""


class Refuted(Checked):
    """With a nonlinearity of the class the loop does not do what a proof would say."""


def inequality(
    name: str, data: Any, B: Block, family: states.Family, rate: Fraction | None = None
) -> tuple[Form, int, bool, dict[str, str]]:
    """``F``, its full degree, whether the case is critical, and the hypotheses, of the frequency criterion ``name``.

    With a rate ``B`` is the block of the solutions times ``r^-t``.
    """
    slopes, mirror = name in SLOPED, name == "circle" and data == {"mirrored": True}
    (l, k), (low, high) = family.slope if slopes else family.sector, family.slope
    form(not mirror or data["mirrored"] is True, "mirrored is true or absent")
    if mirror:  # phi in [l, k] for H is -phi in [-k, -l] for -H
        B, l, k, data = mirrored(B), -k, -l, {}
    need(abs(l) != INF, "the lower bound is infinite")
    d, critical, stable = shifted(B, l)
    B = B._replace(d=d) if B.delayed else B
    D, w = B.direct / (1 + l * B.direct), None if k == INF else k - l
    posed(1 + w * D > 0 if w else D >= 0, "1 + g H(inf) vanishes for a gain g of the class")
    timed = name in ("circle", "zames-falb") or B.discrete == (name in (*STEPS, "order-cone"))
    need(timed, f"{name} is not for {'discrete' if B.discrete else 'continuous'} time")
    drifts = not B.delayed if name == "circle" else name != "order-cone" and rate is None
    need(not critical or drifts, f"{name} does not cover a pole at 0")
    need(not B.delayed or name != "off-axis-circle", f"{name} does not cover dead time")
    need(name == "circle" or not family.varying, f"{name} is about nonlinearities that do not depend on time")
    need(name[:7] != "tsypkin" or (low >= l and (D >= 0 or high <= k)), "slopes >= l are needed, <= k if H(inf) < 0")
    need(name != "jury-lee" or (high <= k and (D <= 0 or low >= l)), "slopes <= k are needed, and >= l if H(inf) > 0")
    m, p, e, r, odd = multiplier(name, data, B, k == INF, rate)
    need(rate is None or not (D and e), "theta with a rate needs H(inf) = 0")
    need(not odd or family.odd, "this multiplier needs odd nonlinearities")
    cross, square = B.n * d.conjugate(), d * d.conjugate()
    F, full = (m + e) * cross, 2 * B.order + max(n for _, n in p)
    if w:
        F = real(w) * F + m * square + real(-w * w) * r * B.n * B.n.conjugate()
    elif mirror or family.endless[slopes]:  # nonlinearities without an upper bound
        theta = m.get((ZERO, 1), (ZERO, ZERO))[1]
        common = exact.chain(exact.primitive(exact.ascending(B.n)), exact.primitive(exact.ascending(d)))[-1]
        direct = D > 0 and name == "popov"
        need(
            name in ("circle", "popov") and not B.delayed,
            f"{name} does not cover nonlinearities without an upper bound",
        )
        need(direct or (theta >= 0 and len(common) == 1), "without an upper bound: theta >= 0 and no hidden modes")
        full = full if direct or B.discrete else max(len(F.part()) - 1, full - 2)
    else:  # each finite bound adds a positive term
        full = len(F.part()) - 1
    facts = {"stable": stable, "well-posed": f"1 + g H(inf) does not vanish in the class, H(inf) = {B.direct}"}
    if name == "order-cone":
        facts["cones"] = f"w^T M w > 0 on every order cone of {len(data['window']) // 2} samples and 0"
    if mirror:
        facts = {fact: f"for -H, -phi, bounds {l} to {k}: {text}" for fact, text in facts.items()}
    return F.folded(), full, critical, facts


def unbounded(name: str, data: Any, family: states.Family) -> bool:
    """Whether the upper bound stands for every finite one."""
    which = name in SLOPED
    return (family.sector, family.slope)[which][1] == INF and not family.endless[which] and data != {"mirrored": True}


def polynomial_proof(F: Form, *, critical: bool, bounded: bool) -> dict[str, Any]:
    """``F`` as it stands in a certificate: without its roots at 0 in the critical case, and if unbounded."""
    p, skip = F.part(), at_zero(F, critical)
    need(all(tau == 0 for tau, _ in F) and not any(p[:skip]), "with delays a cover is needed")
    p = p[skip:]
    while p and p[0] == 0 and not bounded:
        p = p[1:]
    x, step = ("omega", 1) if any(p[1::2]) else ("omega^2", 2)
    ends, whole = [str(p[0]), str(p[-1])] if p else ["0", "0"], [str(c) for c in exact.primitive(p[::step])]
    return {"method": "polynomial", "variable": x, "coefficients": whole, "limits": ends}


def on_axis(F: Form, full: int, critical: bool, bounded: bool, proof: Any = None) -> dict[str, str]:
    """``F > 0`` at every frequency and at infinity; unbounded: up to the positive term that each bound adds."""
    if proof and proof["method"] == "cover":
        _, boxes, order = fields(proof, "method", "boxes", "order")
        form(isinstance(boxes, list) and 0 < len(boxes) < 10_000, "boxes are a list of pairs")
        ends, order = [numbers(x, 2) for x in boxes], integer(order, 2, 60)
        need(ends[0][0] == 0 and all(x[1] == y[0] for x, y in pairwise(ends)), "the boxes leave a gap")
        for a, b in ends:
            need(a < b and box(F, a, b, order, critical), f"F > 0 is not shown on the box [{a}, {b}]")
        need(tail(F, ends[-1][1], full), "F > 0 is not shown beyond the boxes")
        return {"inequality": f"F > 0 up to omega = {ends[-1][1]}, number of boxes: {len(ends)}, and beyond"}
    need(proof in (None, own := polynomial_proof(F, critical=critical, bounded=bounded)), "F is another polynomial")
    p, skip = [int(c) for c in own["coefficients"]], at_zero(F, critical)
    degree = max(len(p) - 1, 0) * (2 if own["variable"] == "omega^2" else 1)
    need(not bounded or degree == full - skip, "F > 0 fails in the limit of high frequencies")
    need(exact.positive(p) or not (p or bounded), "F > 0 fails at some frequency")
    return {"inequality": f"F, of degree {degree} in omega, has no root in [0, inf) and a positive leading coefficient"}


def by_matrix(name: str, data: Any, system: Any, family: states.Family, proof: Any) -> tuple[bool, dict[str, str]]:
    """Circle or Popov by a matrix inequality, or one of higher degree: whether critical, and the hypotheses."""
    if proof["method"] == "powers":
        return powers.facts(name, data, system, family, proof)
    need(name == "circle" or (name == "popov" and not family.varying), "this theorem has no matrix proof here")
    theta, (l, k) = (number(*fields(data, "theta")) if name == "popov" else ZERO * len(fields(data)), family.sector)
    need(abs(l) != INF, "the lower bound is infinite")
    A, b, c, d, discrete = realised(system, l)
    w = None if k == INF else k - l
    posed((1 + w * d > 0 if w else d >= 0) and not (discrete and name == "popov"), "1 + g H(inf) vanishes in the class")
    need(w is not None or theta >= 0 or not family.endless[0], "without an upper bound theta >= 0 is needed")
    facts = {"well-posed": f"1 + g H(inf) does not vanish in the class, H(inf) = {d} after the shift"}
    return proof["zero"] is not None, states.matrix_facts(A, b, c, d, w, theta, discrete, proof) | facts


def structure(name: str, data: Any, system: Any, family: states.Family) -> tuple[str, dict[str, str]]:
    """The rod and its scheme, from inequalities proved for every number of cells: conclusion and hypotheses."""
    (E, rho, L, area, k, N), (l, K) = rod(system), family.sector
    Z2 = area * area * rho * E
    need(k > 0 and l >= 0, "k > 0 and a sector from 0 on are needed")
    facts = {
        "dissipation": f"k = {k} > 0, so that |a| < 1: zero is a simple eigenvalue, its residue A/k = {area / k} > 0"
    }
    need(name == "rod-circle" or not family.varying, f"{name} is about nonlinearities that do not depend on time")
    if name == "rod-energy":
        fields(data)
        if N:
            identity(N)
            falls = "V' = -(1/2) sum (prev_i - y_i)^2 - (1 - a^2)/2 y_2N^2"
            facts["energy"] = f"V = (1/(2 s)) sum y_i^2 + 2 d P(z): {falls}, row by row for {2 * N} rows"
        return RESTS, facts
    if name == "rod-popov":  # |sin psi|/omega <= 2 T and 1 - a^2 R^2 >= 1 - a^2
        theta, least = number(*fields(data, "theta")), L * abs(k * k - Z2) / (k * area * E)
        need(
            theta >= least and (theta > least or K != INF or not family.endless[0]),
            f"theta is below {least}, or equal to it without an upper bound",
        )
        facts["inequality"] = f"theta = {theta} against 4 |a| T/(1 - a^2) = L |k^2 - Z^2|/(k A E) = {least}"
    else:
        need(name == "rod-circle" and fields(data) == [], f"there is no theorem {name!r:.40} for the rod")
        reach = E / L * min(k * k, Z2) / abs(k * k - Z2) if k * k != Z2 else INF
        need(reach > K or (K == INF == reach and not family.endless[0]), f"the sector must end below {reach}")
        facts["inequality"] = f"K = {K} against (1 - |a|)^2/(4 |a| d T) = (E/L) min(k, Z)^2/|k^2 - Z^2| = {reach}"
    return ((CONVERGES, BOUNDED) if N else (RESTS, QUIET))[family.varying], facts


def counterexample(system: Any, family: states.Family, proof: Any, rate: Fraction | None) -> tuple[str, dict[str, str]]:
    """A nonlinearity of the class and a solution that does not come to rest at 0: conclusion and findings.

    With a rate the solution is one of the loop with the same gains, times ``r^-t``.
    """
    method = proof["method"]
    low, high = max(family.sector[0], family.slope[0]), min(family.sector[1], family.slope[1])
    if method == "structure":
        fields(proof, "method")
        E, rho, _, area, k, _ = rod(system)
        need(k < 0 and k * k != area * area * rho * E, "the rod is refuted for k < 0, k not -Z")
        slow = k * k < area * area * rho * E
        need(low <= 0 <= high if slow else high > 0, "the nonlinearity is not in the class")
        return MOVES, {
            "growth": "phi = 0: a wave mode grows, |a| > 1" if slow else "a gain > 0: a positive real root, A/k < 0"
        }
    if method == "member":
        one, inner, point = boxes.member(system, proof)
        return (found := counterexample(one, family, inner, rate))[0], found[1] | point
    if method == "flow-orbit":
        need(realised(system, ZERO)[4] is False, "flow-orbit is about continuous time")
        return MOVES, states.flow_orbit(realised(system, ZERO)[:4], family, proof)
    if method == "switched-gain":
        return MOVES, signals.switched_gain(system, family, proof)
    if method == "matrix-gain":
        return MOVES, states.matrix_gain(lambda g: realised(system, g), family, proof)
    B = block(system)
    critical = rate is None and critical_end(B, low, high)
    if method == "orbit":
        need(B.discrete, "orbit is about discrete time")
        facts = states.orbit(system, family, proof, critical, rate)
        return (OTHERS if "equilibrium" in facts["orbit"] else MOVES), facts
    if method == "crossing":
        _, gains, frequencies = fields(proof, "method", "gains", "frequencies")
        (g, h), (a, b), cross = numbers(gains, 2), numbers(frequencies, 2), B.n * B.d.conjugate()
        need(low <= g < h <= high and 0 < a < b, "the gains are outside the class")
        lines = [B.d * B.d.conjugate() + real(x) * cross for x in (g, h)]
        turn = cross * Form({(ZERO, 0): (ZERO, Fraction(-1))})  # its real part is Im n d*
        apart = any(box(u, a, b, 24) and box(MINUS * v, a, b, 24) for u, v in (lines, lines[::-1]))
        if B.delayed:  # a change of sign
            turns = any(box(u, a, a, 24) and box(MINUS * u, b, b, 24) for u in (turn, MINUS * turn))
        else:
            turns = exact.roots(turn.part(), [1], a, b) > 0
        need(apart and turns, "no root i omega is shown for a gain between the two")
        where = f"between omega = {a} and {b}" + ", omega the tangent of half the angle" * B.discrete
        return MOVES, {"root": f"Im H has a zero {where}, and |d|^2 + g Re(n d*) one between the two gains"}
    need(method == "linear-gain", f"there is no refutation {method!r:.40} for this system")
    g = number(fields(proof, "method", "gain")[1])
    need(low <= g <= high, "the gain is outside the class")
    if 1 + g * B.direct == 0:
        return UNSOLVABLE, {"root": f"1 + g H(inf) = 0 for g = {g}"}
    d = B.d + real(g) * B.n
    if B.delayed:  # terms with dead time are strictly proper: for large s > 0 it has the sign of the first coefficient
        start = sum((u for (_, n), (u, _) in d.items() if n == 0), ZERO) * exact.primitive(exact.ascending(B.d))[-1]
        need(start <= 0 and (start < 0 or not critical), "no root s >= 0 is shown with this gain")
        return OTHERS if start == 0 else MOVES, {
            "root": f"d(0) + g n(0) has the sign of {start} against that for large s, g = {g}"
        }
    outside = max((n for _, n in d), default=-1) < B.order  # in discrete time a root at z = -1
    need(outside or not exact.hurwitz(d), "the loop with this gain is stable")
    if not outside and (ZERO, 0) not in d and exact.hurwitz(over_s(d)):
        need(not critical, "a simple root at 0 alone refutes nothing in the critical case")
        at = "z = 1" if B.discrete else "s = 0"
        return OTHERS, {"root": f"d + g n has a simple root at {at} for g = {g}, the others strictly inside"}
    return MOVES, {"root": f"d + g n, g = {g}, has a root that is not strictly inside, by Routh's array"}


def examine(certificate: Any) -> tuple[type[Proved] | type[Refuted], str, dict[str, str], str]:
    """What a certificate shows: kind, conclusion, how every hypothesis was found to hold, and what is assumed."""
    own = ["rate"] * (isinstance(certificate, dict) and "rate" in certificate)
    head = fields(certificate, *HEAD.split(), *own)
    version, verdict, convention, origin, system, given, phi, name, data, _, _, proof, *rates = head
    form((version, convention) == (FORMAT, CONVENTION), f"format or convention is not that of {FORMAT}")
    form(origin in ORIGINS and verdict in ("PROVED", "REFUTED"), "numbers or verdict is not of those there are")
    form(isinstance(name, str) and name.isascii() and name.isprintable(), "the theorem is no name")
    form(isinstance(system, dict) and isinstance(proof, dict) and "method" in proof, "system or proof is missing")
    form(phi is None or isinstance(phi, dict), "the nonlinearity is neither null nor an object")
    if rates:
        return with_rate(certificate, number(rates[0]))
    return judged(verdict, system, given, phi, name, data, proof)


def with_rate(certificate: Any, rate: Fraction) -> tuple[type[Proved] | type[Refuted], str, dict[str, str], str]:
    """What is shown of the solutions times ``r^-t``, whose nonlinearities ``r^-t phi(r^t sigma)`` depend on time.

    They lie in the same sector and are odd if ``phi`` is; gains stay what they are.  The inequality, being strict,
    bounds their energy by a constant, the same for the whole class, times ``|x(0)|^2``; in the critical case of the
    circle criterion a quadratic ``V > 0`` that does not rise bounds them.
    """
    verdict, system, given, phi = (certificate[key] for key in ("verdict", "system", "laws", "law"))
    name, data, proof = (certificate[key] for key in ("theorem", "multiplier", "proof"))
    discrete, refuted = system.get("time") == "discrete", verdict == "REFUTED"
    many = isinstance(given, dict) and "channels" in given
    need(phi is None, "with a rate no nonlinearity is given")
    method, names = proof.get("proof", proof)["method"], (PACED, several.PACED)[many]
    need(method in PACED_GAINS.split() if refuted else name in names, f"{name!r:.40} by {method!r:.40} has no rates")
    if many:
        channels.lasting(given["channels"], name)
    else:
        family = states.classes(given)
        ends = family.slope if name in SLOPED else family.sector
        need(refuted or INF not in map(abs, ends), "with a rate the bounds of the class are finite")
    own = system if method == "orbit" else paced(system, rate)  # such a solution is one of the loop itself
    kind, conclusion, facts, more = judged(verdict, own, given, phi, name, data, proof, rate)
    if conclusion != UNSOLVABLE:
        rates = (f"({rate})^t", f"x(t)/({rate})^t") if discrete else (f"exp({-rate} t)", f"x(t) exp({rate} t)")
        conclusion = SLOWER.format(rates[1]) if refuted else (DECAYS, LATER)["late" in system].format(rates[0])
    which = "itself" if method == "orbit" else "with H(r z)" if discrete else "with H(s - r)"
    return kind, conclusion, facts | {"rate": f"all of this is of the loop {which}, r = {rate}"}, more


def judged(
    verdict: Any, system: Any, given: Any, phi: Any, name: Any, data: Any, proof: Any, rate: Fraction | None = None
) -> tuple[type[Proved] | type[Refuted], str, dict[str, str], str]:
    """The same of the loop with this system, which with a rate is that of the solutions times ``r^-t``."""
    if isinstance(given, dict) and "channels" in given:
        many: Any = partial(parts.examined, judged, ENDS) if proof["method"] in parts.METHODS else several.examined
        kind, end, found, assumed = many(verdict, name, data, system, given, phi, proof, rate)
        return (Proved if kind else Refuted), ENDS[end], found, assumed
    if isinstance(given, dict) and "graphs" in given:
        kind, conclusion, found = regions.examined(verdict, name, data, system, given, phi, proof)
        return (Proved if kind else Refuted), conclusion, found, ""
    family = states.classes(given)
    form(not family.relu, "a ReLU is asked about as one of several channels")
    facts, slopes = {"class": states.described(family)}, list[Fraction]()
    if phi is not None:
        facts["law"], slopes = states.known(phi, family)
    if verdict == "REFUTED":
        need(
            (name, data, phi) == ("counterexample", {}, None),
            "a refutation is a counterexample, of no given nonlinearity",
        )
        conclusion, found = counterexample(system, family, proof, rate)
        return Refuted, conclusion, facts | found, ""
    if name.startswith("rod-"):
        fields(proof, "method")
        need(
            proof["method"] == "structure" and not family.rough,
            "the rod is proved by structure, for continuous nonlinearities",
        )
        rods, about = boxes.hardest(system)
        conclusion, found = [structure(name, data, one, family) for one in rods][-1]
        return Proved, conclusion, facts | found | about, ""
    need(proof["method"] in METHODS, f"there is no proof by {proof['method']!r:.40}")
    if name == "hurwitz":
        need(fields(data) == [] and proof == {"method": "polynomial"}, "constant gains are proved by polynomials")
        return Proved, LINEAR, facts | linear(block(system), family), ""
    if proof["method"] in ("matrix", "powers"):
        critical, found = by_matrix(name, data, system, family, proof)
        direct, discrete, delayed = *realised(system, ZERO)[3:], False
    elif proof["method"] == "boxes":
        need(fields(data) == [] and not family.endless[name in SLOPED], "each box has its multiplier, the class an end")
        gains, shows, direct = family[name in SLOPED], partial(inequality, name, family=family, rate=rate), ZERO
        critical, delayed, discrete, found = boxes.proved(system, proof, name, gains, shows, on_axis)
    else:
        B = block(system)
        F, full, critical, found = inequality(name, data, B, family, rate)
        found |= on_axis(F, full, critical, not unbounded(name, data, family), proof)
        direct, discrete, delayed = B.direct, B.discrete, B.delayed
    states.regular(family, discrete and not direct and not critical and name == "circle")
    found |= states.solvable(direct, family, slopes) if name == "popov" else {}
    if found.get("solvable") == states.SOLVABLE:
        facts["class"] += ", with sigma + H(inf) phi(sigma) increasing and its inverse locally Lipschitz"
    conclusion = (BOUNDED if family.varying else CONVERGES) if critical else FINITE_ENERGY if delayed else ATTRACTS
    return Proved, conclusion, facts | found, states.assumed(name, direct, family)


def check(data: str | bytes | Mapping[str, Any], *, seconds: float = 600, draft: bool = False) -> Proved | Refuted:
    """What ``data`` proves within so many ``seconds``, else ``Rejected`` or ``Malformed``; a ``draft`` is filled in."""
    with exact.checking(seconds):
        certificate = exact.parsed(data if isinstance(data, str | bytes) else json.dumps(dict(data)))
        kind, conclusion, facts, assumed = examine(certificate)
        certificate |= {"conclusion": conclusion, "hypotheses": facts} if draft else {}
        need(certificate["conclusion"] == conclusion, f"the conclusion is another: {conclusion}")
        need(certificate["hypotheses"] == facts, "the hypotheses are not those found to hold")
    return kind(_SEAL, certificate, facts, assumed)


def main(paths: list[str]) -> int:
    """Check files and say what was found; the worst status counts."""
    worst = 0 if paths else 2
    for path in paths:
        try:
            form(Path(path).is_file(), "it is no ordinary file")
            with Path(path).open("rb") as file:
                found = check(file.read(exact.LARGEST_FILE + 1))
            print(f"ACCEPTED: {found.claim} ({type(found).__name__}, {found.theorem})")
            told = [(name, json.dumps(found.certificate[name])) for name in ("convention", "system", "law")]
            for name, fact in [*told, *found.facts.items(), *[("assumed", found.assumed)] * bool(found.assumed)]:
                print(f"  {name}: {fact}")
        except Rejected as reason:
            print(f"REJECTED: {reason}")
            worst = max(worst, 11)
        except (exact.Malformed, OSError) as reason:
            print(f"NOT A CERTIFICATE: {reason}")
            worst = max(worst, 2)
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
