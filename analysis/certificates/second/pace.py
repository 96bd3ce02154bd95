"""Rates: the loop of the solutions times ``r^-t`` (``e^(a t)``), and what its multipliers weigh.

In discrete time ``xi(t) = x(t) r^-t`` is a solution of the loop with ``H(r z)``, that is with ``A/r`` and ``B/r``, and
the nonlinearity ``r^-t phi(r^t .)`` at the time ``t``; in continuous time ``x(t) e^(a t)`` one with ``H(s - a)``, ``A +
a``.  Sectors, bounds of slopes, oddness and constant gains stay; that ``phi`` is the same at all times does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from flint import fmpq_poly

from lure.analysis.certificates.second.classes import DELAYED, FULL_BLOCK, NO_SOLUTION
from lure.analysis.certificates.second.numerics import from_descending, to_fmpq, to_fraction
from lure.analysis.certificates.second.reading import Document, NotShown, listed, mapping, number, numbers, require

THEOREMS = ("circle", "zames-falb", "hurwitz")
OF_CHANNELS = (
    "constant-gains",
    *(f"{kind}-{theorem}" for kind in ("diagonal", "coupled", "full-block") for theorem in ("circle", "popov")),
    *("matrix-zames-falb", "coupled-windows", "piecewise-circle", "piecewise-popov"),
)
LINEAR = ("linear-gain", "crossing", "matrix-gain", "switched-gain", "linear-gains", "switched-gains", "ramped-gains")
LATE = "multivariable delay"


def weighted(document: Document, rate: Fraction) -> Document:
    """The document of the solutions times ``r^-t``, of which all but the conclusion is to be shown.

    Raises
    ------
    NotShown
        Rates do not go with this system, class or theorem.
    """
    flow = document.system.get("time") == "continuous"
    require(rate > 0 or flow, "in discrete time a rate is not positive")
    require(document.nonlinearity is None, "a rate is not one of a given nonlinearity")
    several = "channels" in document.nonlinearities
    if several:
        channels = [mapping(one) for one in listed(document.nonlinearities["channels"])]
        kinds = [one["operator"] for one in channels if "operator" in one]
        lasting = all(kind == FULL_BLOCK for kind in kinds) and not (kinds and document.theorem == "coupled-windows")
        require(lasting, "the norm of an operator changes with a rate")
        require(not any("memory" in one for one in channels), "play and stop have other limits than 0")
    if document.verdict == "PROVED":
        require(document.theorem in (OF_CHANNELS if several else THEOREMS), "the theorem does not cover a rate")
        if not several:
            ends = document.nonlinearities["slope" if document.theorem == "zames-falb" else "sector"]
            require(not {"inf", "-inf", "finite"} & set(map(str, listed(ends))), "a rate needs finite bounds")
    else:
        proof = document.proof
        proof = mapping(proof["proof"]) if proof.get("method") == "member" else proof
        if proof.get("method") == "orbit":  # of the loop itself
            require(document.system.get("kind") == "transfer" and not flow, "such a solution is one in samples")
            return document
        require(proof.get("method") in (*LINEAR, "late-turns"), "a refutation of a rate is linear")
    return replace(document, system=_system(document.system, rate))


def conclusion(document: Document, rate: Fraction, shown: str, stable: Sequence[str]) -> str:
    """The sentence of the loop itself that follows from one of the weighted loop.

    ``document``: the certificate; ``shown``: what was shown of the weighted loop; ``stable``: the sentences by which
    its solutions are bounded by a quadratic function of their start.
    """
    discrete = document.system.get("time") == "discrete"
    if document.verdict != "PROVED":
        if shown == NO_SOLUTION:
            return shown
        grown = f"x(t)/({rate})^t" if discrete else f"x(t) exp({rate} t)"
        return f"a loop of the class has a motion for which {grown} does not tend to 0"
    late = document.system.get("kind") == LATE
    require(shown in ((DELAYED,) if late else stable), "the solutions of the weighted loop are not bounded")
    falls = f"({rate})^t" if discrete else f"exp({-rate} t)"
    if late:
        every = f"|x(t)| <= c m {falls} for every motion of every loop of the class"
        return f"{every}, m the greatest |x| before t = 0, with one c"
    return f"|x(t)| <= c |x(0)| {falls} for every motion of every loop of the class, with one c"


def _system(system: Mapping[str, object], rate: Fraction) -> Mapping[str, object]:
    kind, discrete = system.get("kind"), system.get("time") == "discrete"
    if kind == "family":  # whose n and d are sums of such terms
        own = {"kind": "transfer", "time": system.get("time")}
        terms = [mapping(term) for term in listed(system["terms"])]
        turned = [_same_length(term, _system({**term, **own}, rate)) for term in terms]
        return {**system, "terms": turned}
    if kind == "transfer":
        inner = fmpq_poly([0, to_fmpq(rate)]) if discrete else fmpq_poly([-to_fmpq(rate), 1])
        both = {name: from_descending(numbers(system[name])) for name in ("numerator", "denominator")}
        return {**system, **{name: _descending(p(inner)) for name, p in both.items()}}
    if kind in ("channel-family", "varying-family"):  # A over a common denominator, of which each term has a share
        return {**system, "terms": [_part(mapping(term), rate, discrete=discrete) for term in listed(system["terms"])]}
    if kind not in ("state-space", "multivariable", LATE):  # with dead times C_T and A_T are weighted in balls
        raise NotShown("rates are not shown of such plants")
    rows = [numbers(row) for row in listed(system["A"])]
    if not discrete:
        moved = [[v + rate if i == j else v for j, v in enumerate(row)] for i, row in enumerate(rows)]
        return {**system, "A": _texts(moved)}
    inputs = "b" if kind == "state-space" else "B"
    given = [numbers(system["b"])] if inputs == "b" else [numbers(row) for row in listed(system["B"])]
    slower, driven = (_texts([[v / rate for v in row] for row in side]) for side in (rows, given))
    return {**system, "A": slower, inputs: driven[0] if inputs == "b" else driven}


def _part(term: Mapping[str, object], rate: Fraction, *, discrete: bool) -> Mapping[str, object]:
    """A term of plants with parameters, of the weighted loop."""
    A, B = ([numbers(row) for row in listed(term[side])] for side in "AB")
    if discrete:
        return {
            **term,
            "A": _texts([[v / rate for v in row] for row in A]),
            "B": _texts([[v / rate for v in row] for row in B]),
        }
    moved, shift = [list(row) for row in A], rate * number(term["common"])
    for i, row in enumerate(moved):
        row[i] += shift
    return {**term, "A": _texts(moved)}


def _same_length(term: Mapping[str, object], turned: Mapping[str, object]) -> dict[str, object]:
    """The term of a sum with its turned sides, with zeros in front as before."""
    sides = {name: (listed(term[name]), listed(turned[name])) for name in ("numerator", "denominator")}
    return {**term, **{name: ["0"] * (len(was) - len(now)) + [*now] for name, (was, now) in sides.items()}}


def _descending(p: fmpq_poly) -> list[str]:
    return [str(to_fraction(c)) for c in reversed(p.coeffs())] or ["0"]


def _texts(rows: Sequence[Sequence[Fraction]]) -> list[list[str]]:
    return [[str(v) for v in row] for row in rows]


def tap_weights(taps: Mapping[int, Fraction], rate: Fraction) -> list[Fraction]:
    """``sum |h_i| z^-i`` at ``z = 1/r`` and at ``z = r``.

    With ``a = s - m/w``, ``b = m`` of the weighted signals and ``W(t)`` their ``r^-2t F``, ``F`` the primitive of ``b``
    over ``a``: ``b(t) a(t - i) <= r^i (b a - W)(t) + r^-i W(t - i)``, for either sign of ``i``, as ``F`` is convex.
    """
    return [sum((abs(h) * z**-i for i, h in taps.items()), Fraction(0)) for z in (1 / rate, rate)]


def kernel_weights(theta: Fraction, kernels: Sequence[tuple[Fraction, object]], rate: Fraction) -> list[Fraction]:
    """``-theta s + sum |c_j| h_j(s)`` at ``s = a`` and at ``s = -a``.

    As for taps, with an integral over the distance; the term ``theta a'`` gives ``theta a`` times the integral of ``b a
    - W``, less that of ``W``.

    Raises
    ------
    NotShown
        A kernel has no such integral.
    """
    found = [-theta * rate, theta * rate]
    for c, kernel in kernels:
        if not isinstance(kernel, tuple):
            raise NotShown("a delay has no rational weight")
        decay, order, side = kernel
        require(decay > abs(rate), "a kernel does not decay faster than the rate")
        found = [v + abs(c) * (decay / (decay + side * s)) ** order for v, s in zip(found, (rate, -rate), strict=True)]
    return found


def popov_terms(turn: Fraction, width: Fraction, *, sloped: bool) -> tuple[Fraction, Fraction, Fraction]:
    """Numbers ``p, q, r`` for which ``2 turn (2 int psi - psi sigma) <= p sigma^2 + 2 q psi sigma + r psi^2``.

    ``V = 2 theta int_0^sigma psi`` of the loop, times ``e^(2 a t)``, grows by the left side beside ``2 theta psi
    sigma'`` of the weighted signals; ``turn = theta a``, ``psi`` in ``[0, w]``.  With slopes in ``[0, w]`` the area on
    either side of the graph within the rectangle is at least a triangle: ``|2 int psi - psi sigma| <= psi (sigma -
    psi/w)``.

    ``turn``, ``width``: ``theta a`` and ``w``; ``sloped``: whether the slopes are in ``[0, w]``, too.
    """
    if sloped:
        return Fraction(0), abs(turn), -2 * abs(turn) / width
    return (Fraction(0), -turn, Fraction(0)) if turn <= 0 else (2 * turn * width, -turn, Fraction(0))


def kernel_masses(c: Fraction, decay: Fraction, order: int, *, causal: bool, rate: Fraction) -> list[Fraction]:
    """What a kernel of mass ``c`` takes of ``a b - Phi`` in its row and of ``Phi`` in its column, at a rate.

    Raises
    ------
    NotShown
        It does not decay faster than the rate.
    """
    require(decay > abs(rate), "a kernel does not decay faster than the rate")
    later = rate if causal else -rate
    return [abs(c) / (1 + s / decay) ** order for s in (later, -later)]
