"""Several nonlinearities, one in each channel of a plant with as many inputs as outputs: part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import lcm, prod
from typing import Any

from . import arithmetic as exact
from . import boxes, frequencies, gains, parametric, pieces, states, windows
from .arithmetic import INF, ZERO, eliminated, fields, form, integer, need, number, numbers, tick
from .balls import dot, positive_definite
from .channels import (
    MOST_VERTICES,
    RESTED,
    SCALAR,
    Channels,
    Plant,
    Rows,
    channels,
    described,
    diagonal,
    each,
    existing,
    full_block,
    moved,
    ordered,
    plant,
    seen,
    semidefinite,
    undelayed,
    uniform,
    unit_of,
    within,
)
from .memory import apart, increments, with_storage

ONE_SOLUTION = "sigma + D phi(sigma) = y has exactly one solution sigma for every y"
PIECEWISE = ("piecewise-circle", "piecewise-popov")
LATE = (*PIECEWISE, "late-zames-falb")
PACED = (  # with a rate; those of order cones hold for one sample of each time
    *("constant-gains", "diagonal-circle", "coupled-circle", "full-block-circle", *PIECEWISE),
    *("diagonal-popov", "coupled-popov", "full-block-popov", "matrix-zames-falb", "coupled-windows"),
)
THEOREMS = {  # the key of the multiplier, and whether with Popov's terms
    "diagonal-circle": ("lambda", False),
    "diagonal-popov": ("lambda", True),
    "coupled-circle": ("forms", False),
    "coupled-popov": ("forms", True),
    "full-block-circle": ("Pi", False),
    "full-block-popov": ("Pi", True),
    "storage-circle": ("lambda", True),
}


def examined(
    verdict: str, name: str, data: Any, system: Any, given: Any, phi: Any, proof: Any, rate: Fraction | None = None
) -> tuple[bool, int, dict[str, str], str]:
    """Whether it is a proof, and what follows; 0: 0 attracts, 1: one moves on, 2: other equilibria, 3: no loop.

    4: all converge to the set of equilibria, 5: they are bounded, 6: rods come to rest.  Of a gain, 7: it is at most
    that of the class, 8: one is above.  9: rods come to rest whose pressures may depend on time.
    10: 0 attracts all with inputs of finite energy.  11: no gain is finite.

    And how every hypothesis was found to hold, and what is assumed.
    """
    touching, family = system.get("kind") == "rods", system.get("kind") in boxes.CHANNELS
    size = contacts(system) if touching else len(boxes.matrices(system).pattern if family else plant(system, True).D)
    asked = channels(given, size)
    need(phi is None, "no nonlinearity is given beside several classes")
    facts = {"class": described(asked)}
    if touching:
        need(verdict == "PROVED" and proof == {"method": "structure"}, "rods are proved by their structure")
        need(name in ("rods-energy", "rods-circle"), "rods are proved by their energy or by the circle criterion")
        fields(data)
        energy = name == "rods-energy"
        return True, 6 if energy else 9, facts | (resting if energy else quiet)(system, asked), ""
    if verdict == "PROVED":
        found, assumed = (over_boxes if family else proved)(name, data, system, asked, proof, rate)
        if any(one.memory for one in asked.families):
            need("residue" not in found, "with play and stop an eigenvalue 0 is not covered")
            return True, *((4, facts | found, assumed) if asked.performance is None else (7, facts | found, RESTED))
        if "residue" in found:
            alone = len(asked.operators) == (asked.performance is not None)
            need(alone, "with operators an eigenvalue 0 is not covered")
            if asked.performance is not None:
                return True, 7, facts | found, assumed
            moving = "late" not in system and any(one.varying for one in asked.families)  # beside dead times no pole
            return True, 5 if moving else 4, facts | found, assumed
        late = "late" in system  # the past, and the inputs to the block, matter then
        return True, 7 if asked.performance is not None else 10 if late else 0, facts | found, assumed
    need((name, data) == ("counterexample", {}), "a refutation is a counterexample")
    if family and proof["method"] == "members":
        return False, 1, facts | boxes.moving_members(system, asked, proof), ""
    system, proof, point = boxes.member(system, proof) if family else (system, proof, {})
    end, found = gains.refuted(system, asked, proof, rate)
    return False, end, facts | point | found, ""


def contacts(system: Any) -> int:
    """How many contacts there are between rods with dashpots, and that their parameters are such of rods."""
    _, arrangement, rods, plate = fields(system, "kind", "arrangement", "rods", "obstacle")
    form(isinstance(rods, list) and 0 < len(rods) <= 8, "there are 1 to 8 rods")
    known = {("both-ends", 1): 2, ("across-gap", 2): 1} | {("one-obstacle", i): i for i in range(1, 9)}
    form(isinstance(arrangement, str) and (arrangement, len(rods)) in known, "there is no such arrangement of rods")
    for one in rods:
        E, rho, L, A, _ = map(number, fields(one, "E", "rho", "L", "A", "k"))
        form(min(E, rho, L, A) > 0, "E, rho, L and A are positive")
    form(plate is None or (arrangement == "one-obstacle" and number(plate) > 0), "an obstacle that moves has k_o > 0")
    return known[arrangement, len(rods)]


def resting(system: Any, asked: Channels) -> dict[str, str]:
    """The energy of rods with a dashpot each, and of their contacts: what was found; docs/theory/several-rods.md.

    It falls by ``k v(t, 0)^2`` at each dashpot, so that these ends come to rest, and with them the waves: at an end
    without contact ``r_1 = -a r_2`` and ``v = (1 - a) r_2/2``, and at one with a contact ``r_1`` and ``r_2`` tend to
    what a constant pressure holds; where all is at rest, virtual work leaves no pressure.
    """
    for i, family in each(asked):
        need(asked.bounds(i)[0] >= 0, f"the pressure of contact {i + 1} may pull: a sector from 0 on is needed")
        need(not (family.varying or family.rough), f"contact {i + 1}: locally Lipschitz and the same at all times")
    damping = [number(one["k"]) for one in system["rods"]]
    need(min(damping) > 0, "a dashpot does not damp")
    return {"dissipation": f"k = {', '.join(map(str, damping))} > 0, so that energy is lost wherever a rod moves"}


def quiet(system: Any, asked: Channels) -> dict[str, str]:
    """The circle criterion for rods themselves, the areas as weights: ``1/K_i + Re H > 0`` at all frequencies.

    At ``x = L`` alone ``Re H_j >= -l_j`` with ``l_j = (L/E) |k^2 - Z^2|/min(k, Z)^2`` as for one rod; across a gap
    these add up, and an obstacle that moves is ``1/(i w k_o)``, without a real part.  At both ends, by Gershgorin,
    ``Re H >= -(L/E) max(2 Z^2, Z^2 + |k^2 - Z^2|)/min(k, Z)^2``.  docs/theory/several-rods.md has the proofs.
    """
    lags, areas, both = [], [], system["arrangement"] == "both-ends"
    for one in system["rods"]:
        E, rho, L, A, k = (number(one[key]) for key in ("E", "rho", "L", "A", "k"))
        need(k > 0, "a dashpot does not damp")
        Z2 = A * A * rho * E
        lag = max(2 * Z2, Z2 + abs(k * k - Z2)) if both else abs(k * k - Z2)
        lags.append(L / E * lag / min(k * k, Z2))
        areas.append(A)
    if both:
        lags *= 2
    if system["arrangement"] == "across-gap":
        lags = [sum((min(areas) / A * lag for A, lag in zip(areas, lags, strict=True)), ZERO)]
    found = []
    for i, family in each(asked):
        low, K = asked.bounds(i)
        need(low >= 0, f"the pressure of contact {i + 1} may pull: a sector from 0 on is needed")
        need(not family.rough and K != INF, f"contact {i + 1}: locally Lipschitz, with an upper bound")
        need(K * lags[i] < 1, f"contact {i + 1}: {K} times {lags[i]} is not below 1")
        found.append(f"{K} * {lags[i]} < 1")
    return {"inequality": f"K_i times the least -Re H_i: {', '.join(found)}"}


def well_posed(D: Rows, asked: Channels) -> tuple[str, str]:
    """Why the loop has a solution and what is assumed for it; the inequality holds at ``x = 0``.

    There ``sum lambda_i (phi_i - l_i sigma_i)(u_i sigma_i - phi_i) < 0`` for ``sigma = -D phi != 0``.  Differences of
    two solutions of ``sigma + D phi(sigma) = y`` would satisfy the opposite if the slopes lie in ``[l_i, u_i]``; with
    ``y`` not equal too, ``|phi - phi'| <= K |y - y'|``: ``sigma`` is unique, Lipschitz in ``y``, and exists as a proper
    injective continuous map of ``R^m`` is onto (Brouwer).
    """
    more = existing(asked)
    if ordered(D, asked):
        return "sigma is given channel after channel: D has no cycle", more
    inside = (
        asked.bounds(i)[0] <= family.slope[0] and family.slope[1] <= asked.bounds(i)[1]
        for i, family in each(asked)
        if family.operator != "performance"
    )
    if all(inside):
        return "the inequality at x = 0 bounds differences of solutions, the slopes being in the same bounds", ""
    both = f"{ONE_SOLUTION} and {more}" if more else ONE_SOLUTION
    return "the inequality at x = 0 shows det(1 + D G) != 0 for the gains of the class", both


def proved(
    name: str, data: Any, system: Any, asked: Channels, proof: Any, rate: Fraction | None = None
) -> tuple[dict[str, str], str]:
    """The circle criterion, or Popov's, with diagonal or full-block multipliers: what was found, and what is assumed.

    ``V = x'Px + 2 sum theta_i int_0^sigma_i phi_i`` is positive definite, and ``V' + (sigma, phi)' Pi (sigma, phi)``
    (discrete: the difference of ``V``) negative definite in ``(x, phi)``, where the form of ``Pi`` is nonnegative.  For
    an operator it is ``lambda (r^2 |sigma_b|^2 - |mu_b|^2)``, whose integral up to any time is, and from ``z`` to ``w``
    that with ``r = 1/gamma``: with ``x(0) = 0`` the integral of ``|z|^2 - gamma^2 |w|^2`` is at most 0.
    """
    H = plant(system, name in LATE, rate)
    before, (H, asked) = asked, increments(H, asked)
    H, asked = undelayed(H, asked, name in LATE)
    if name == "constant-gains":
        fields(data)
        return gains.gain_box(H, asked, *fields(proof, "method", "tree")), ""
    if name == "parameter-dependent":
        posed, assumed = well_posed(H.D, asked)
        need(not asked.operators, "operators are not covered beside unknown gains")
        return parametric.proved(H, data, asked, proof) | {"well-posed": posed}, assumed
    if name in ("order-cones", "coupled-windows"):
        return windows.lifted(name, H, data, asked, proof, rate)
    if proof["method"] == "determinant":
        return over_frequencies(name, data, H, asked, proof, rate or ZERO)
    if name in LATE:
        return over_pieces(name, data, H, asked, proof, rate or ZERO)
    need(name in THEOREMS, f"there is no theorem {name!r:.40} for several nonlinearities")
    (key, popov), n, m = THEOREMS[name], len(H.A), len(H.D)
    parts, beside = ["N"] * (key == "Pi" and isinstance(data, dict) and "N" in data), key != "lambda"
    given, *turned = fields(data, key, *["theta"] * popov, *parts, *["lambda"] * (beside and bool(asked.operators)))
    theta = numbers(turned[0], m) if popov else [ZERO] * m
    need(not (popov and H.discrete) or name == "storage-circle", f"{name} is for continuous time")
    stored, theta = apart(plant(system), before, theta) if name == "storage-circle" else (None, theta)
    fitting(asked, theta, H.D)
    more = [key for key in ("zero", "semidefinite") if key in proof]
    method, half, exponent, *zero = fields(proof, "method", "P", "exponent", *more)
    form(method == "matrix" and len(more) < 2, "several nonlinearities are proved by a matrix")
    resting = more == ["semidefinite"]
    form(not resting or zero.pop() is True, "semidefinite is true or absent")
    P, q, rows = states.symmetric(half, [*moved(H), *seen(H)], n)
    R, Z, e = rows[:n], rows[n:], integer(exponent, 0, 10**5)  # q (A, -B) and q (C, -D)
    Pi, bounds = multiplier(key, given, turned[popov:], asked, bool(zero))
    weighed(Pi, theta, bounds, asked, rate or ZERO)
    falls, above = inequality(P, (R, Z, q, e), Pi, theta, bounds, H.discrete)
    rest = {}
    if stored:
        falls, above = with_storage(falls, above, unit_of(Pi, theta, bounds) * q * q << e, stored)
        rest["storage"] = "theta <= 0 for stop and >= 0 for play, and what is stored is a function of y and phi"
    if zero:
        falls = windows.at_rest(falls, H, [l for l, _ in bounds], zero[0])
        rest["residue"] = windows.rested(zero[0])
    if resting:
        need(not any(one.memory for one in before.families), "with play and stop no form is semidefinite")
        return unsettled(H, asked, name, falls, above)
    need(positive_definite(above), "V > 0 fails, or is undecided")
    need(positive_definite(falls), "the inequality of P fails, or is undecided")
    posed, assumed = well_posed(H.D, asked) if key != "forms" else (solvable(H, asked, bounds), "")
    V = "V = x^T P x + 2 sum theta_i int phi_i" if any(theta) else "V = x^T P x"
    V = f"V = y^T P y + what is stored, y = {'x+ - x' if H.discrete else 'A x - B phi'}," if stored else V
    return {
        "stable": f"{V} is positive definite (order {n})",
        "inequality": f"the matrix of order {len(falls)} is positive definite: V falls",
        "well-posed": posed,
    } | rest, assumed


def multiplier(key: str, given: Any, more: list[Any], asked: Channels, resting: bool) -> tuple[Rows, Any]:
    """``Pi``, whose form is nonnegative for the classes, and their bounds; ``more`` is ``N``, and ``lambda`` beside."""
    m, own, beside = len(asked.families), asked.functions, key != "lambda"
    bounds = [asked.bounds(i) for i in range(m)]
    weights = numbers(more.pop() if beside else given, m) if asked.operators or not beside else [ZERO] * m
    uniform(weights, asked)
    Pi = diagonal(weights, bounds)
    if not beside:
        return Pi, bounds
    need(bool(own) and not any(weights[i] for i in own), "lambda is of operators alone")
    if key == "forms":
        places = [*range(2 * m)]
        part, bounds = windows.static(given, asked)
    else:
        places = [*own, *(m + i for i in own)]
        part = full_block(given, more, [bounds[i] for i in own], resting)
    for i, row in zip(places, part):
        for j, v in zip(places, row):
            Pi[i][j] += v
    return Pi, bounds


def unsettled(H: Plant, asked: Channels, name: str, falls: Rows, above: Rows) -> tuple[dict[str, str], str]:
    """A gain by forms that are only semidefinite: ``V(T) >= 0 = V(0)`` bounds ``|z|^2`` up to every ``T``.

    Nothing is said without ``w``.  Solutions exist at all times, ``phi`` being bounded by ``k |sigma|``.
    """
    need(asked.performance is not None and len(asked.operators) == 1, "a form that is semidefinite bounds a gain alone")
    need(name in ("diagonal-circle", "diagonal-popov"), f"{name!r:.40} has no semidefinite form")
    need(ordered(H.D, asked), "D has a cycle of channels")
    need(semidefinite(above), "V >= 0 fails")
    need(semidefinite(falls), "the inequality of P fails")
    return {
        "storage": f"V is positive semidefinite (order {len(H.A)}), and 0 where x = 0",
        "inequality": f"the matrix of order {len(falls)} is positive semidefinite: V rises by no more than w lets it",
        "well-posed": "sigma is given channel after channel: D has no cycle",
    }, ""


def fitting(asked: Channels, theta: list[Fraction], D: Rows) -> None:
    """The classes have finite bounds, and Popov's terms suit their channels."""
    for i, family in each(asked):
        need(INF not in map(abs, asked.bounds(i)), f"channel {i + 1} has no finite bounds")
        need(not family.rough, "locally Lipschitz nonlinearities are needed")
        fixed = not (family.varying or family.operator)
        need(not theta[i] or fixed, f"theta_{i + 1} needs a nonlinearity that does not depend on time")
        need(not theta[i] or not any(D[i]), f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone")


def weighed(Pi: Rows, theta: list[Fraction], bounds: Any, asked: Channels, rate: Fraction) -> None:
    """Add to ``Pi`` what Popov's terms add to ``V'`` with a rate ``a``: ``2 theta a (2 int psi - psi sigma)`` at most.

    ``V`` of the solutions times ``e^(a t)`` has ``2 theta e^(2 a t) int phi``, and ``psi = phi - l sigma`` is in
    ``[0, w]``.  With slopes there, too, ``int psi`` is between ``psi^2/2w`` and ``psi sigma - psi^2/2w``, and this is
    at most ``2 c (psi sigma - psi^2/w)``, ``c = |theta a|``; else, by ``0 <= int psi <= w sigma^2/2``, ``2 c psi
    sigma``, or ``2 c (w sigma^2 - psi sigma)`` for ``theta a > 0``.
    """
    m = len(theta)
    for i, (turn, (l, u)) in enumerate(zip(theta, bounds)):
        (low, high), c = asked.families[i].slope, abs(turn * rate)
        if not c:
            continue
        s, t, q = (ZERO, 1, -1 / (u - l)) if l <= low and high <= u else (u - l, -1, ZERO)
        if turn * rate < 0 and not q:
            s, t = ZERO, 1
        Pi[i][i] += 2 * c * (s - t * l + q * l * l)
        Pi[i][m + i] += c * (t - 2 * q * l)
        Pi[m + i][i] += c * (t - 2 * q * l)
        Pi[m + i][m + i] += 2 * c * q


def over_boxes(
    name: str, data: Any, system: Any, asked: Channels, proof: Any, rate: Fraction | None = None
) -> tuple[dict[str, str], str]:
    """The same for all plants of a box, with a ``P`` and a diagonal multiplier for each of the boxes that cover it.

    ``P = P_0 + sum t_j P_j``, ``t_j`` from 0 to 1 over the box.  Times ``c^2``, ``c`` the common denominator, the
    matrices of :func:`proved` are polynomials in the parameters: means of their Bernstein coefficients, which are
    positive definite.  Those of ``c`` are not 0, of one sign.
    """
    H, (method, tree) = boxes.matrices(system), fields(proof, "method", "boxes")
    form(method == "boxes" and fields(data) == [], "the method is boxes, each with its multiplier")
    need(name in ("diagonal-circle", "diagonal-popov"), f"{name!r:.40} is not shown for all parameters")
    popov, n, m, count = name == "diagonal-popov", len(H.terms[0][2][0]), len(H.pattern), 0
    need(not (popov and H.time == "discrete"), f"{name} is for continuous time")
    bounds = [asked.bounds(i) for i in range(m)]
    terms = boxes.Integers.of(H)
    for box, entry in boxes.leaves(tree, H.box, H.rates):
        given, *turned, half, exponent = fields(entry, "lambda", *["theta"] * popov, "P", "exponent")
        theta, e = numbers(turned[0], m) if popov else [ZERO] * m, integer(exponent, 0, 10**5)
        fitting(asked, theta, H.pattern)
        H.still(theta)
        form(isinstance(half, list) and len(half) in (1, 1 + len(box)), "P is a list, of one more than parameters")
        weights, degrees = numbers(given, m), H.degrees(any(theta), len(half) > 1)
        uniform(weights, asked)
        need(prod(d + 1 for d in degrees) <= boxes.MOST_NODES, "the degrees in the parameters are too high")
        Pi, parts = diagonal(weights, bounds), [states.symmetric(one, [], n)[0] for one in half]
        weighed(Pi, theta, bounds, asked, rate or ZERO)
        falls, above, common = dict[Any, Rows](), dict[Any, Rows](), dict[Any, Rows]()
        L = lcm(*(max(d, 1) for d in degrees))  # all of it L times, so that t and P are of integers
        Pi, theta = [[L * v for v in row] for row in Pi], [L * v for v in theta]
        for node in product(*(range(d + 1) for d in degrees)):
            t = [i * L // max(d, 1) for i, d in zip(node, degrees)]
            point = [low + (high - low) * Fraction(share, L) for (low, high), share in zip(box, t)]
            P = [[dot([L, *t], cell) for cell in zip(*rows)] for rows in zip(*parts)]
            u, c, *rows = terms.at(point)  # c is the denominator u times
            for found, M in zip(
                (falls, above), inequality(P, (rows[:n], rows[n:], c, e), Pi, theta, bounds, H.time == "discrete")
            ):
                found[node] = [[Fraction(v, u * u) for v in row] for row in M]
            common[node] = [[Fraction(c, u)]]
        signs = [c for ((c,),) in parametric.coefficients(common, degrees)]
        need(min(signs) > 0 or max(signs) < 0, "the common denominator may vanish for some parameters")
        w = unit_of(Pi, theta, bounds)
        for found in (above, *boxes.moving(H, box, parts, falls, common, w * L)):
            for M in parametric.coefficients(found, degrees):
                parametric.definite(M)
        count += 1
    posed, assumed = well_posed(H.pattern, asked)
    V = f"V = x^T P x{' + 2 sum theta_i int phi_i' * popov} is positive definite and falls"
    return {
        "parameters": boxes.words(H.names, H.box, H.rates),
        "inequality": f"{V}: Bernstein coefficients on each of the boxes that cover these parameters, {count} of them",
        "well-posed": posed,
    }, assumed


def solvable(H: Plant, asked: Channels, bounds: Any) -> str:
    """Why there is one solution where a multiplier couples channels, whose form says nothing about differences."""
    if ordered(H.D, asked):
        return "sigma is given channel after channel: D has no cycle"
    own = [i for i in range(len(H.D)) if i not in (asked.performance or ())]
    need(len(own) <= MOST_VERTICES, f"D has a cycle, and there are more than {MOST_VERTICES} channels")
    inside = all(bounds[i][0] <= asked.families[i].slope[0] and asked.families[i].slope[1] <= bounds[i][1] for i in own)
    rows = [[H.D[i][j] for j in own] for i in own]
    return frequencies.solvable(H._replace(D=rows), inside, [bounds[i] for i in own])


def over_frequencies(
    name: str, data: Any, H: Plant, asked: Channels, proof: Any, rate: Fraction
) -> tuple[dict[str, str], str]:
    """The frequency inequality of the circle criterion, Popov's or Zames and Falb's: what was found, and is assumed.

    With ``F > 0`` and a stable loop at the lower bounds there is a ``P`` for :func:`proved` where ``M`` is diagonal and
    constant (Kalman, Yakubovich, Popov).  In general ``int a'M b >= 0`` for every ``tau phi``, ``tau`` in ``[0, 1]``,
    after the shift, and ``F > 0`` bounds the solutions from ``tau = 0`` to ``tau = 1`` (Megretski, Rantzer).
    """
    fields(proof, "method")
    need(H.discrete is (name == "matrix-scalings"), f"{name} by a determinant is for another time")
    given = frequencies.multiplier(name, data, len(H.D))
    constant_gains = [one.linear and not one.varying for one in asked.families]
    odd = [one.odd for one in asked.families]
    operators = [(block, asked.families[block[0]].operator == SCALAR) for block in asked.operators]
    bounds = [one.slope if i in given.moved and not one.operator else asked.bounds(i) for i, one in each(asked)]
    for i, one in each(asked):
        need(INF not in map(abs, bounds[i]), f"channel {i + 1} has no finite bounds")
        rising = bounds[i][0] <= one.slope[0] and one.slope[1] <= bounds[i][1]
        need(not (rate and given.theta[i]) or rising, f"theta_{i + 1} with a rate needs slopes within the bounds")
        need(not one.rough, "locally Lipschitz nonlinearities are needed")
        constant = not given.theta[i] and i not in given.moved
        need(constant or not one.varying, f"channel {i + 1} needs a nonlinearity that does not depend on time")
        need(
            not (given.theta[i] and (any(H.D[i]) or one.operator)),
            f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone",
        )
    turns = [theta * rate / (u - l) if theta else ZERO for theta, (l, u) in zip(given.theta, bounds)]
    frequencies.dominant(given, odd, asked.blocks, constant_gains, operators, rate, turns)
    outer = asked.performance or ()
    facts = frequencies.proved(on_axis(H, given, asked) if H.discrete else H, given, bounds, outer)
    need(not (H.discrete and "residue" in facts), "scalings do not cover an eigenvalue z = 1", exact.Critical)
    still = not (rate and (given.moved or any(given.theta)))
    need(still or "residue" not in facts, "with a rate multipliers that are not constant do not cover an eigenvalue 0")
    for i, one in each(asked) if "residue" in facts and given.moved else ():
        rising = i in outer or (bounds[i][0] <= one.slope[0] and one.slope[1] < INF and not one.varying)
        need(rising, f"beside kernels and an eigenvalue 0 channel {i + 1} has no slope bounds", exact.Critical)
    posed, assumed = well_posed(H.D, asked)
    bare = not H.discrete and all(one.operator or one.linear for one in asked.families)  # at infinity M is real
    if bare or not name.startswith("matrix") or ordered(H.D, asked):
        return facts | {"well-posed": posed}, assumed
    return facts | {"well-posed": solvable(H, asked, bounds)}, ""


HALVINGS = 6  # of a piece


def over_pieces(name: str, data: Any, H: Plant, asked: Channels, proof: Any, rate: Any) -> tuple[dict[str, str], str]:
    """The circle criterion or Popov's where delays, time-invariant operators and gains have multipliers by pieces.

    What :func:`over_frequencies` says of ``tau phi`` is true of ``1 + k (e^(-s tau) - 1)``, ``k`` in ``[0, 1]``, where
    ``x >= 0``; of ``e^(-s k tau)`` for each ``x``, whose differences have a norm as operators on ``sigma_i'``.  Beside
    dead times the loop is shifted by gains of the class, 1 for delays, else 0 or what is next to it.  With kernels
    ``M`` of a function in one channel is the same on all pieces.
    """
    moved, m = name == "late-zames-falb", len(H.D)
    popov = moved or name == "piecewise-popov"
    told, *turned, listed = fields(data, "lambda", *["theta"] * popov, "kernels" if moved else "pieces")
    method, where = fields(proof, "method", "ends")
    weights, theta, ends = numbers(told, m), numbers(turned[0], m) if popov else [ZERO] * m, numbers(where)
    form(method == "pieces", "the method is pieces")
    need(not (popov and H.discrete), f"{name} is for continuous time")
    need(min(weights) >= 0, "a weight lambda is negative")
    uniform(weights, asked)
    need(not (H.rates and asked.operators), "in neutral equations there are functions and constant gains alone")
    members, low = members_of(H, asked, weights, theta, rate)
    if moved:
        members, listed = [kernelled(H, asked, members, listed, rate)], [[None]] * (len(ends) + 1)
    rows = isinstance(listed, list) and all(isinstance(row, list) and len(row) == m for row in listed)
    form(rows and len(listed) == len(ends) + (not H.discrete), "there is not one multiplier for each piece")
    fit = all((pair is None) == (not one.kind) for row in listed for pair, one in zip(row, members))
    form(fit, "a channel has a multiplier by pieces where its class has one, else null")
    given = [[(ZERO, ZERO) if pair is None else tuple(numbers(pair, 2)) for pair in row] for row in listed]
    ascend = all(a < b for a, b in pairwise([ZERO, *ends])) and (not H.discrete or ends[-1] * 10**6 >= 3141593)
    need(ascend, "the pieces do not follow one another, from 0 to pi in discrete time")
    for row, end in zip(given, [*ends, None]):
        for i, ((x, y), member, one) in enumerate(zip(row, members, asked.families)):
            either = member.kind == "delay" and not H.discrete and not any(H.D[i])
            need(x >= 0 or either, f"x < 0 needs sigma_{i + 1} to be a function of the state alone")
            if member.kind == "delay":
                chord = end is not None and end * member.bound * 10**6 <= 6283185
                need(y == 0 or (y > 0 and chord), "y > 0 needs omega h <= 2 pi")
            if member.kind == "slow":
                need(y >= 0 and (x, y) == given[0][i], "a delay that varies has one multiplier at all frequencies")
                need(y == 0 or not any(H.D[i]), f"y > 0 needs sigma_{i + 1} to be a function of the state alone")
                need(x == 0 or one.rate is not None, "x > 0 needs a delay that changes at a bounded rate")
            free = not one.operator or member.kind in ("delay", "slow")
            need(y == 0 or free, "an operator has a real multiplier")
        same = all(row[i] == row[block[0]] for block in asked.operators for i in block if members[i].kind == "scaled")
        need(same, "the channels of an operator have different multipliers")
    order, zeros, rest, shifted = len(H.A), 0, dict[str, str](), bool(H.inner) or (H.late and any(low))
    stable = not shifted and within(frequencies.shifted(H, low)[0], H.discrete)
    if H.late and not stable:
        number, zeros, counted = pieces.right_roots(H, low)
        stable, rest = not number, {"stable": counted} if shifted else {}
    need(stable, "the loop at the lower bounds, and without delay, is not asymptotically stable")
    need(not (zeros and moved), "beside kernels and dead times a pole at 0 is not covered", exact.Critical)
    if zeros:
        rest |= pieces.integrators(H, low, zeros, members, asked.families)
    axis = pieces.axis_of(H, low, members)
    for piece, (a, b) in zip(given, pairwise([ZERO, *ends, *[None] * (not H.discrete)])):
        failure = pieces.on_piece(axis, piece, a or ZERO, b, zeros, HALVINGS)
        need(not failure, failure)
    found = f"F > 0 on {len(given)} pieces of the axis, by its leading minors"
    posed, assumed = well_posed(H.D, asked)  # by the last piece, which ends at infinity: there all is real
    if not ordered(H.D, asked) and (H.late or H.discrete or any(one.kind in ("delay", "slow") for one in members)):
        posed, assumed = solvable(H, asked, [asked.bounds(i) for i, _ in each(asked)]), ""
    where = "the plant" if H.late else "without delay, at the lower bounds, the loop"
    how = "has all other eigenvalues in the open left half-plane" if zeros else "is asymptotically stable"
    return {
        "stable": f"{where} {how} (order {order - zeros})",
        "inequality": found,
        "well-posed": posed,
    } | rest, assumed


def kernelled(H: Plant, asked: Channels, members: list[pieces.Member], given: Any, rate: Any) -> pieces.Member:
    """The function of a plant with dead times and one channel, with kernels in its multiplier.

    ``int (phi - l sigma) M (u sigma - phi) >= 0`` for every function with slopes in ``[l, u]`` at all times the same,
    also after ``phi`` is ``b sigma + tau (phi - b sigma)`` with a gain ``b`` of ``[l, u]``: Zames and Falb.
    """
    need(
        bool(H.late) and len(members) == 1 and not rate, "kernels beside dead times are of one channel, without a rate"
    )
    (one,), (family,), (l, u) = members, asked.families, asked.bounds(0)
    plain = not (one.kind or family.operator or family.varying)
    need(plain, "kernels are of a function that does not depend on time")
    need(l <= family.slope[0] and family.slope[1] <= u, "kernels need slopes within the bounds")
    return pieces.with_kernels(one, given, family.odd)


def members_of(
    H: Plant, asked: Channels, weights: list[Fraction], theta: list[Fraction], rate: Any
) -> tuple[list[pieces.Member], list[Fraction]]:
    """What each channel is on the axis, and the gains by which the loop is shifted."""
    members, low = list[pieces.Member](), list[Fraction]()
    alone = {block[0] for block in asked.blocks if len(block) == 1}
    for i, one in each(asked):
        free = one.operator == "linear time-invariant" or (one.linear and not one.varying and i in alone)
        kind = {"delay": "delay", "varying delay": "slow"}.get(one.operator, "scaled" if free else "")
        steep = 1 if one.rate is None or kind != "slow" else 1 + one.rate / (1 - one.rate)
        l, u = (Fraction(1), Fraction(steep)) if kind in ("delay", "slow") else asked.bounds(i)
        need(INF not in (abs(l), abs(u)), f"channel {i + 1} has no finite bounds")
        need(not one.rough, "locally Lipschitz nonlinearities are needed")
        need(not (kind == "slow" and H.discrete), "slow delays are for continuous time")
        need(not (kind and (weights[i] or theta[i])), f"channel {i + 1} has multipliers by pieces alone")
        fixed = not (one.varying or one.operator or H.direct(i))
        need(not theta[i] or fixed, f"theta_{i + 1} needs a function of the state alone that does not depend on time")
        paid = l <= one.slope[0] and one.slope[1] <= u and weights[i] * (u - l) >= abs(theta[i] * rate)
        need(paid or not (rate and theta[i]), f"theta_{i + 1} with a rate needs slopes within the bounds, and lambda")
        low.append(pieces.base(l, u) if H.late else l)
        members.append(pieces.Member(kind, u - l, weights[i], theta[i], one.sector[1] if kind else ZERO, l - low[i]))
    return members, low


def on_axis(H: Plant, given: frequencies.Multiplier, asked: Channels) -> Plant:
    """The plant of ``s``, ``z = (1 + s)/(1 - s)``, where a multiplier of the frequency means the same in both times.

    ``M`` is constant but for operators and constant gains, which it multiplies at each frequency by itself; ``|e^(i
    omega)| = 1`` is the axis.  With ``E = (1 + A)^-1``: ``E (A - 1)``, ``2 E^2 B``, ``C`` and ``D - C E B``.
    """
    need(not any(given.theta), "Popov's terms are for continuous time")
    free = {i for i, family in each(asked) if family.linear or family.operator}
    need(all(k.row in free for k in given.kernels), "a kernel is of no gain and no operator")
    n = len(H.A)
    square = [[v + (i == j) for j, v in enumerate(row)] for i, row in enumerate(H.A)]
    both = eliminated(square, [[v - (i == j) for j, v in enumerate(row)] + H.B[i] for i, row in enumerate(H.A)])
    once = None if both is None else eliminated(square, [[2 * v for v in row[n:]] for row in both])
    need(once is not None, "z = -1 is an eigenvalue of the plant")
    A, EB = [row[:n] for row in both or []], [row[n:] for row in both or []]
    D = [[v - dot(c, column) for v, column in zip(row, zip(*EB))] for row, c in zip(H.D, H.C)]
    return Plant(A, once or [], H.C, D, False)


def inequality(P: Any, scaled: Any, Pi: Rows, theta: Any, bounds: Any, discrete: bool) -> tuple[Any, Any]:
    """Lower triangles of integers: of ``-V'`` less the form of ``Pi``, times ``2^e q^2 w``, and of a bound below ``V``.

    ``int phi_i >= min(theta_i l_i, theta_i u_i) sigma_i^2/(2 theta_i)``, whatever the sign of ``theta_i``.
    """
    R, Z, q, e = scaled
    n, m = len(P), len(Z)
    least = [min(t * l, t * u) for t, (l, u) in zip(theta, bounds)]
    w, N = unit_of(Pi, theta, bounds), n + m
    t, low = [int(w * v) for v in theta], [int(w * v) for v in least]
    PR = [[dot(row, column) for column in zip(*R)] for row in P]  # q P (A, -B)
    M = [[0] * (i + 1) for i in range(N)]
    for i in range(N):
        tick()
        for j in range(i + 1):
            if discrete:
                M[i][j] = (q * q * P[i][j] if i < n else 0) - sum(R[h][i] * PR[h][j] for h in range(n))
            else:
                M[i][j] = -q * ((PR[i][j] if i < n else 0) + (PR[j][i] if j < n else 0))
            M[i][j] *= w
    Y = [*Z, *([q * (i == n + h) for i in range(N)] for h in range(m))]  # q (sigma, phi)
    for y, row in zip(Y, Pi):
        tick()
        whole = [(int(w * v), other) for v, other in zip(row, Y) if v]
        side = [sum(v * other[j] for v, other in whole) << e for j in range(N)]  # of q w Pi (sigma, phi)
        for i in (i for i in range(N) if y[i]):
            M[i] = [v - y[i] * z for v, z in zip(M[i], side)]
    for h in (h for h in range(m) if t[h]):
        rate = [sum(Z[h][g] * R[g][i] for g in range(n)) for i in range(N)]  # q^2 sigma_h'
        for i in range(N):
            for j in range(i + 1):
                M[i][j] -= t[h] * ((i == n + h) * rate[j] + (j == n + h) * rate[i]) << e
    above = [
        [w * q * q * P[i][j] + (sum(low[h] * Z[h][i] * Z[h][j] for h in range(m)) << e) for j in range(i + 1)]
        for i in range(n)
    ]
    return M, above
