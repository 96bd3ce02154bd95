"""Linear members with operators, members with a large gain, rays of ReLUs: what they refute, as checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import islice, product
from typing import Any

from lure.analysis.certificates.checker import Refuted
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.channel_gains import GainSearch
from lure.analysis.counterexamples.gain_signals import MOST_CHANNELS, Cut, Loop, best_signals, followed, moving, signals
from lure.analysis.counterexamples.linear_members import DelayedMembers, Found, MemberSearch
from lure.analysis.counterexamples.relu_rays import ReluRays
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import double_above
from lure.analysis.questions.channel_delays import delays_of, delays_refuting, wide_channels, without_delays
from lure.analysis.questions.channel_hypotheses import is_critical
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.channel_refutations import (
    as_members,
    constant_gains,
    ends_of,
    gains_refuting,
    late_gains_refuting,
    matrices_refuting,
    narrowed,
    refutation,
    unlimited,
)
from lure.analysis.questions.problem import Problem
from lure.arrays import Reals, np, optimize
from lure.classes import SCALAR
from lure.errors import AssumptionError
from lure.plants.delay_matrix import DelayMatrix

_STEPS = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
_FAR = (0.5, 0.9, 0.99, 0.999, 1 - 1e-4, 1 - 1e-6)
_FACTORS = (1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0)  # of ReLUs, beyond what is proved: where a ray is looked for
_SHAPES, _CORNERS, _LARGEST = 3, 4, 1e6
_TRIED, _RADII = 20, (Fraction(1, 10**10), Fraction(1, 10**7))
_NEAR, _SAMPLES, _LONG = 1e-4, 200, 1200
_SHORT, _FEW = 60, 12  # samples and signals with which slopes are compared
_INSIDE = 128  # the share of a class by which gains are above its lower end
_MOST_OF_RAY = 30  # states and channels: beyond them the exact eigenvector of a ray takes the checker minutes


def members_refuting(asked: Problem, *, most: float) -> tuple[Fraction, Refuted] | None:
    """The smallest factor that linear members refute; of a gain, members with a larger one, or that are unstable.

    ``most``: the largest factor of interest.
    """
    if isinstance(asked.plant, DelayMatrix) and wide_channels(asked):
        return as_members(asked, members_refuting(narrowed(asked), most=most))
    if isinstance(asked.plant, DelayMatrix) and asked.classes.performance is not None:
        return _largest_delayed(asked, most)
    if isinstance(asked.plant, DelayMatrix):
        ways = [late_gains_refuting(asked, most=most), _by_delays(asked, most) if delays_of(asked) else None]
        return min((one for one in ways if one is not None), key=lambda one: one[0], default=None)
    if asked.classes.rectified and most == 1 and not asked.classes.operators:  # of other factors the ReLUs are others
        return _by_rays(asked)
    if not asked.classes.operators:
        return gains_refuting(asked, most=most)
    if wide := wide_channels(asked):
        if len(wide) == sum(map(len, asked.classes.operators)):
            return matrices_refuting(asked, most)
        return as_members(asked, members_refuting(narrowed(asked), most=most))
    if asked.classes.performance is not None and asked.classes.rectified:
        return _by_signal(asked, most)
    if asked.classes.performance is not None:
        members = [_unstable(asked) or _largest_gain(asked, most), _largest_delayed(asked, most)]
        members += [_largest_at_ends(asked, most)] if members[0] is None or members[0][0] else []
        best = min((one for one in members if one is not None), key=lambda one: one[0], default=None)
        moved = _by_moving(asked, most if best is None else float(best[0])) if asked.worst else None
        return moved or best
    others = _by_delays if delays_of(asked) else _by_operators
    moving = _from_rest(asked, most)
    if moving is not None:
        return moving
    found = [one for one in (_by_gains(asked, most), others(asked, most)) if one is not None]
    best = min(found, key=lambda one: one[0], default=None)
    if best is None or math.isinf(most):
        return best
    given = refutation(
        asked, Fraction(most), best[1].certificate["proof"]
    )  # of the classes as they are, not of smaller
    return best if given is None else (Fraction(most), given)


def _from_rest(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """Operators that are constant gains, small ones of either sign: an eigenvalue 0 (z = 1) moves out with one."""
    blocks = asked.classes.operators
    if delays_of(asked) or len(blocks) > _CORNERS or not is_critical(asked):
        return None
    alpha = Fraction(most) if math.isfinite(most) else Fraction(1 / _LARGEST)
    scaled = asked.scaled(alpha).classes
    for signs in product((-1, 1), repeat=len(blocks)):
        whole = list(scaled.lower)
        for sign, block in zip(signs, blocks, strict=True):
            for i in block:
                whole[i] = sign * scaled.upper[i]
        shown = refutation(asked, alpha, constant_gains(whole))
        if shown is not None:
            return alpha, shown
    return None


def _by_delays(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The smallest factor of a constant delay in one channel, beside constant gains, with a root on the axis."""
    for alpha, proof in delays_refuting(asked, most):
        shown = refutation(asked, alpha, proof)
        if shown is not None:
            return alpha, shown
    return None


def rays_refuting(asked: Problem, known: Fraction) -> tuple[Fraction, Refuted] | None:
    """A factor above what is known with a solution that grows along a ray, the first tried; about no other factor.

    ``asked``: the question, ReLUs among its classes.  ``known``: a factor that is proved; 0 where nothing is.
    """
    if asked.classes.operators or isinstance(asked.plant, DelayMatrix):
        return None
    for step in _FACTORS:
        alpha = Fraction(double_above(known * Fraction(1 + step))) if known else Fraction(step)
        found = _by_rays(asked.scaled(alpha))
        if found is not None:
            return alpha, found[1]
    return None


def _by_rays(asked: Problem) -> tuple[Fraction, Refuted] | None:
    """A solution of the loop with ReLUs that grows along a ray."""
    H, classes = channel_plant(asked.plant), asked.classes
    if max(H.order, H.inputs) > _MOST_OF_RAY:
        return None
    ends = [[Fraction(end) for end in one.gains] for one in classes.classes]
    lower, upper = (np.array([float(pair[k]) for pair in ends]) for k in range(2))
    relus = [one.rectifier for one in classes.classes]
    search = ReluRays(*H.doubles(), lower, upper, relus, classes.blocks, H.dt is not None)
    for found in islice(search.found(), _TRIED):
        rows = [
            [high if g == float(high) else low if g == float(low) else Fraction(g) for g, (low, high) in pairs]
            for pairs in (list(zip(map(float, row), ends, strict=True)) for row in found.gains)
        ]
        for radius in _RADII:
            proof = {"method": "relu-ray", "gains": [texts(row) for row in rows], "radius": str(radius)}
            proof |= {"state": texts([Fraction(v) for v in found.state]), "value": str(Fraction(found.value))}
            shown = refutation(asked, Fraction(1), proof)
            if shown is not None:
                return Fraction(1), shown
    return None


def _exceeding(
    asked: Problem, gain: float, proof: dict[str, Any], most: float, steps: Sequence[float] = _STEPS
) -> tuple[Fraction, Refuted] | None:
    """The inverse of a gain that was computed, as little less as is accepted."""
    own = asked.classes.performance
    assert own is not None, "of a gain"
    for step in steps if gain > 0 else ():
        checkpoint()
        alpha = Fraction(double_above(1 / (Fraction(gain * (1 - step)) * asked.classes.upper[own[0]])))
        shown = refutation(asked, alpha, proof) if alpha < most else None
        if shown is not None:
            return alpha, shown
    return None


def _by_signal(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The inverse of the gain that a disturbance of some steps shows; of ReLUs no linear gain is a member."""
    own, H = list(asked.classes.performance or ()), channel_plant(asked.plant)
    functions = [i for i in range(len(H.D)) if i not in own]
    later = any(H.D[i][j] for i in functions for j in functions if j >= i)
    if later or any(asked.classes.classes[i].operator or asked.classes.classes[i].memory for i in functions):
        return None
    ends = _lines_beside(asked, Loop(H.doubles(), own), functions)
    found = list[tuple[float, dict[str, Any]]]()
    if H.dt is None:
        one = followed(H, ends, own)
        found = [(one.gain, one.proof)] if one is not None else []
    else:
        for gain, inputs in best_signals(Loop(H.doubles(), own), _doubles(ends)):
            found.append((gain, {"inputs": [texts(row) for row in inputs]}))
    for gain, steps in found:
        proof = {"method": "signal", "slopes": [texts(pair) for pair in ends], **steps}
        if (exceeding := _exceeding(asked, gain, proof, most)) is not None:
            return exceeding
    return None


def _doubles(ends: Sequence[tuple[Fraction, Fraction]]) -> Reals:
    return np.array([[float(v) for v in pair] for pair in ends]).reshape(-1, 2)


def _lines_beside(asked: Problem, loop: Loop, functions: Sequence[int]) -> list[tuple[Fraction, Fraction]]:
    """Slopes below and above 0: those of the ReLUs, and of the functions beside them ends of the class, one by one."""
    lower, upper, classes = asked.classes.lower, asked.classes.upper, asked.classes.classes
    chosen = {i: (lower[i], upper[i]) if classes[i].rectifier else (lower[i], lower[i]) for i in functions}

    def reached(trial: Mapping[int, tuple[Fraction, Fraction]]) -> float:
        """The gain that a short search finds."""
        lines, held = _doubles([trial[i] for i in functions]), loop
        if asked.plant.dt is None:
            cut = Cut.of(loop, lines)
            if cut is None:
                return 0.0
            held = loop.held(float(cut.step))
        return signals(held, lines, _SHORT, _FEW)[0]

    beside = [block for block in asked.classes.blocks if block[0] in chosen and not classes[block[0]].rectifier]
    best = reached(chosen) if beside else 0.0
    for block in beside:
        low, high = lower[block[0]], upper[block[0]]
        straight = classes[block[0]].odd or classes[block[0]].linear
        for pair in [(high, high)] if straight else [(high, high), (low, high), (high, low)]:
            trial = chosen | dict.fromkeys(block, pair)
            if (gain := reached(trial)) > best:
                best, chosen = gain, trial
    return [chosen[i] for i in functions]


def _by_moving(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The inverse of the gain that a disturbance shows whose gains jump with it, where those of the classes may.

    In samples those of a sector may too: ``phi`` may have any value in it where ``sigma`` comes once.
    """
    own, H = list(asked.classes.performance or ()), channel_plant(asked.plant)
    functions = [i for i in range(len(H.D)) if i not in own]
    kinds = [asked.classes.classes[i] for i in functions]
    free = all((one.time_varying and one.rate is None) or (H.dt is not None and one.slope is None) for one in kinds)
    plain = (
        not any(one.operator or one.memory or one.linear for one in kinds)
        and asked.classes.lower != asked.classes.upper
    )
    later = any(H.D[i][j] for i in functions for j in functions if j >= i)
    alone = len(functions) + 1 == len(asked.classes.blocks)
    if later or not (free and plain and alone and 0 < len(functions) <= MOST_CHANNELS) or not most > 0:
        return None
    loop, ends = Loop(H.doubles(), own), [(asked.classes.lower[i], asked.classes.upper[i]) for i in functions]
    count, step_of, rest = _SAMPLES, Fraction(0), dict[str, Any]()
    if H.dt is None:
        cut = Cut.of(loop, _doubles(ends), most=_LONG)
        if cut is None:
            return None
        count, step_of = cut.steps, cut.step
        rest = {"times": [str(cut.step)] * cut.steps, "sides": [[0] * len(functions)] * cut.steps}
        rest |= {"scale": str(cut.scale), "bits": cut.digits + 128}
    found = moving(loop, ends, count, step_of or None)
    if found is None or not found.gain * float(asked.classes.upper[own[0]]) * most > 1 + _STEPS[-1]:
        return None
    chosen = [[texts([pair[row[k]]] * 2) for row in found.ends] for k, pair in enumerate(ends)]
    proof = {"method": "signal", "slopes": chosen, "inputs": [texts(row) for row in found.inputs], **rest}
    return _exceeding(asked, found.gain, proof, math.inf, _STEPS[1::3])


def _functions(asked: Problem) -> list[range]:
    return [block for block in asked.classes.blocks if block not in asked.classes.operators]


def _gain_search(asked: Problem) -> tuple[GainSearch, list[int]]:
    """The search over gains of the channels without operators, and which these are."""
    blocks = _functions(asked)
    asked = without_delays(asked)
    own, H = [i for block in blocks for i in block], channel_plant(asked.plant)
    A, B, C, D = H.doubles()
    lower, upper = (np.array([float(side[i]) for i in own]) for side in (asked.classes.lower, asked.classes.upper))
    places = [[own.index(i) for i in block] for block in blocks]
    return GainSearch(A, B[:, own], C[own], D[np.ix_(own, own)], lower, upper, places, H.dt is not None), own


def _by_gains(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """Constant gains of the channels without operators."""
    if not _functions(asked):
        return None
    (search, own), one = _gain_search(asked), asked.classes.upper
    found = search.found(double_above(asked.classes.least), most)
    for gains in search.proposals(*found, most=most) if found is not None else ():
        whole = list(asked.classes.lower)  # 0 of operators, 1 of delays
        for i, gain in zip(own, gains, strict=True):
            whole[i] = gain
        least = max((whole[i] / one[i] for i in own if one[i] > 0), default=Fraction(0))
        alpha = Fraction(double_above(least)) if math.isinf(most) else Fraction(most)
        shown = refutation(asked, alpha, constant_gains(whole)) if alpha > 0 else None
        if shown is not None:
            return alpha, shown
    return None


def _unstable(asked: Problem) -> tuple[Fraction, Refuted] | None:
    """Gains of the class with which the loop is unstable: then no gain is finite, and the factor is 0."""
    if not _functions(asked) or any(one.memory for one in asked.classes.classes):
        return None
    search, own = _gain_search(asked)
    found = search.found(double_above(Fraction(0)), 1.0)
    for gains in search.proposals(*found, most=1.0) if found is not None else ():
        whole = list(asked.classes.lower)
        for i, gain in zip(own, gains, strict=True):
            whole[i] = gain
        shown = unlimited(asked, [whole]) or refutation(asked, Fraction(1), constant_gains(whole))
        if shown is not None:
            return Fraction(0), shown
    return None


def _members(asked: Problem, out: range) -> tuple[MemberSearch, list[range]]:
    """The search for members with a large gain from ``w`` to ``sigma`` on some channels, and its operators."""
    own = delays_of(asked)
    H, operators = channel_plant(asked.plant), [b for b in asked.classes.operators if b != out and b[0] not in own]
    lower = np.array([float(v) for v in _starts(asked)])
    scalar = [block for block in asked.classes.operators if asked.classes.classes[block[0]].operator == SCALAR]
    return MemberSearch(*H.doubles(), lower, _functions(asked), operators, out, H.dt is not None, scalar), operators


def _starts(asked: Problem) -> tuple[Fraction, ...]:
    """Gains with which the loop is stable, to begin with: the lower bounds, with an eigenvalue 0 more."""
    lower, upper, operators = asked.classes.lower, asked.classes.upper, asked.classes.operators
    still = {i for block in operators for i in block} if operators and is_critical(asked) else range(len(lower))
    return tuple(low if i in still else low + (upper[i] - low) / _INSIDE for i, low in enumerate(lower))


def _proof(asked: Problem, search: MemberSearch, found: Found, operators: list[dict[str, Any]]) -> dict[str, Any]:
    gains = search.exact_gains(found, _starts(asked), asked.classes.upper)
    return {"method": "linear-members", "gains": texts(gains), "operators": operators}


def _largest_gain(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The inverse of the gain of a member; 0 where that member is unstable."""
    out = asked.classes.performance
    assert out is not None, "of a gain"
    try:
        search, operators = _members(asked, out)
    except AssumptionError:  # the criteria say why
        return None
    widths = np.array([float(v) for v in asked.classes.upper]) - search.lower
    found = search.found(widths)
    if found is None or not found.gain > 0:
        return None
    radii = [asked.classes.upper[block[0]] for block in operators]
    proof = _proof(asked, search, found, list(search.realised(found, radii)))
    omega = None if not math.isfinite(found.omega) else Fraction(f"{found.omega:.12g}")
    if search.discrete and omega is not None:
        omega = None if math.pi - found.omega < 1e-9 else Fraction(f"{math.tan(found.omega / 2):.12g}")
    units = [[str(Fraction(round(part * 2**40), 2**40)) for part in (v.real, v.imag)] for v in found.direction]
    at = {"omega": None if omega is None else str(omega), "input": units}
    if (exceeding := _exceeding(asked, found.gain, proof | at, most)) is not None:
        return exceeding
    shown = refutation(asked, Fraction(1), proof) if operators else None
    return None if shown is None else (Fraction(0), shown)


def _largest_at_ends(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The same of gains at the ends of the classes, with which an eigenvalue may be 0 that ``z`` does not see."""
    out, H = asked.classes.performance, channel_plant(asked.plant)
    if out is None or len(asked.classes.operators) > 1 or not H.order or not is_critical(asked):
        return None
    A, B, C, D = H.doubles()
    poles = np.abs(np.linalg.eigvals(A))
    poles = poles[poles > _NEAR * poles.max(initial=0)]
    omega = np.geomspace(poles.min(initial=1) / 1e5, 1e3 * poles.max(initial=1), _SAMPLES)
    points = 1j * omega if H.dt is None else np.exp(2j * np.arctan(omega := np.geomspace(1e-5, 1e3, _SAMPLES)))
    best = list[tuple[float, Fraction, list[Fraction], Reals]]()
    for gains in ends_of(asked):
        checkpoint()
        G, one = np.diag([*map(float, gains)]), np.eye(len(D))
        if abs(np.linalg.det(one + D @ G)) < _NEAR:
            continue
        E = np.linalg.inv(one + D @ G)
        seen, entering = (E @ C)[[*out]], (B @ (one - G @ E @ D))[:, [*out]]
        state = np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A + B @ G @ E @ C, entering.astype(complex))
        values = np.linalg.svd(seen @ state + (E @ D)[np.ix_(out, out)])
        k = int(values[1][:, 0].argmax())
        best.append((float(values[1][k, 0]), Fraction(f"{omega[k]:.12g}"), gains, values[2][k, 0].conj()))
    if not best:
        return None
    gain, at, gains, direction = max(best, key=lambda one: one[0])
    units = [[str(Fraction(round(part * 2**40), 2**40)) for part in (v.real, v.imag)] for v in direction]
    proof = {"method": "linear-members", "gains": texts(gains), "operators": [], "omega": str(at), "input": units}
    return _exceeding(asked, gain, proof, most)


def _largest_delayed(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The inverse of the gain of members with constant delays, where there are such in continuous time."""
    plant, classes, late = asked.plant, asked.classes, delays_of(asked)
    own, blocks = list(classes.performance or ()), _functions(asked)
    delays = [block for block in classes.operators if block[0] in late]
    others = len(classes.blocks) - len(blocks) - len(delays) - 1
    if plant.dt is not None or not (late or isinstance(plant, DelayMatrix)) or others:
        return None
    if any(classes.classes[block[0]].memory or classes.classes[block[0]].rectifier for block in blocks):
        return None
    ends = [(float(classes.lower[block[0]]), float(classes.upper[block[0]])) for block in blocks]
    bounds = [Fraction(classes.classes[block[0]].sector.upper) for block in delays]
    given = own, blocks, delays, np.array(ends).reshape(-1, 2), np.array([float(bound) for bound in bounds])
    found = (
        DelayedMembers(plant.base.doubles(), *given, plant.transfer, [float(delay) for delay, _ in plant.late])
        if isinstance(plant, DelayMatrix)
        else DelayedMembers(channel_plant(plant).doubles(), *given)
    ).best()
    if found is None or not found.gain > 0:
        return None
    gains = [Fraction(0) if i in own else Fraction(1) for i in range(len(classes.classes))]
    for block, gain in zip(blocks, found.gains, strict=True):
        for i in block:
            gains[i] = min(max(Fraction(gain), classes.lower[i]), classes.upper[i])
    taus = {i: min(Fraction(tau), h) for block, tau, h in zip(delays, found.delays, bounds, strict=True) for i in block}
    units = [[str(Fraction(round(part * 2**40), 2**40)) for part in (v.real, v.imag)] for v in found.direction]
    proof: dict[str, Any] = {"method": "delayed-members", "gains": texts(gains), "omega": str(Fraction(found.omega))}
    proof |= {"delays": texts(taus[i] for i in sorted(taus)), "input": units}
    steps = (*_STEPS, *_FAR)  # near a pole on the axis the gain is known roughly
    return _exceeding(asked, found.gain, proof, most, steps)


def _by_operators(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """The smallest factor of operators with which the loop is unstable: one of them closes the loop of the others."""
    out = asked.classes.operators[0]
    search, operators = _members(asked, out)
    upper, top = np.array([float(v) for v in asked.classes.upper]), min(most, _LARGEST)
    if not search.functions and (closing := _by_eigenvalue(asked, search, top)) is not None:
        return closing

    def excess(logarithm: float, shape: Reals | None) -> float:
        """The logarithm of what the gain of the loop is times the operator; large for an unstable loop."""
        alpha = math.exp(logarithm)
        found = search.found(alpha * upper - search.lower, shape)
        return 50.0 if found is None else math.log(max(found.gain * alpha * upper[out[0]], 1e-30))

    first = search.found(min(1.0, top) * upper - search.lower)
    if first is None:
        return None
    least, end, shape = (
        max(math.log(double_above(asked.classes.least) or 1e-9), math.log(1e-9)),
        math.log(top),
        first.shape,
    )
    count = len(shape)
    corners = [np.array(v) for v in product((0.0, 1.0), repeat=count)] if 0 < count <= _CORNERS else []
    tried, at = [shape, *corners], list[Reals]()
    for _ in range(_SHAPES):
        for one in tried:
            checkpoint()
            if excess(end, one) > 0 > excess(least, one):
                end, at = float(optimize.brentq(excess, least, end, args=(one,), xtol=1e-12, rtol=1e-12)), [one]
        if not at:
            return None
        better = search.found(math.exp(end) * upper - search.lower)
        if better is None or not count or np.allclose(better.shape, at[0]):
            break
        tried = [better.shape]
    shape = at[0]
    for step in _STEPS:
        alpha = Fraction(double_above(Fraction(math.exp(end) * (1 + step))))
        found = search.found(float(alpha) * upper - search.lower, shape) if alpha <= top else None
        if found is None:
            return None
        # the operator on these channels: 1 + S Delta = 0 on the direction of the largest gain
        H = search.loop.response(np.array([found.omega]))[1]
        Delta = np.diag(found.gains).astype(complex)
        for block, (left, right) in zip(operators, found.operators, strict=True):
            Delta[np.ix_(block, block)] = np.outer(left, right) if len(right) else left[0] * np.eye(len(block))
        S = np.linalg.solve(np.eye(len(Delta)) + H[0] @ Delta, H[0])[np.ix_(out, out)]
        if out in search.scalar:  # delta is -1 by the largest eigenvalue
            values = np.linalg.eigvals(S)
            last = np.array([-1 / values[np.abs(values).argmax()]]), np.zeros(0, dtype=complex)
        else:
            u, _, v = np.linalg.svd(S)
            last = -v[0].conj(), u[:, 0].conj()
        whole = found._replace(operators=[last, *found.operators])
        scaled = asked.scaled(alpha)
        listed = list(search.realised(whole, [scaled.classes.upper[block[0]] for block in asked.classes.operators]))
        shown = refutation(asked, alpha, _proof(scaled, search, whole, listed))
        if shown is not None:
            return alpha, shown
    return None


def _by_eigenvalue(asked: Problem, search: MemberSearch, top: float) -> tuple[Fraction, Refuted] | None:
    """The same of operators alone: with the largest eigenvalue of ``H Delta`` in modulus."""
    blocks, upper = asked.classes.operators, asked.classes.upper
    found = search.closing(blocks, np.array([float(upper[block[0]]) for block in blocks]))
    for step in _STEPS if found.gain * top > 1 else ():
        checkpoint()
        alpha = Fraction(double_above(Fraction((1 + step) / found.gain)))
        scaled = asked.scaled(alpha)
        listed = list(search.realised(found, [scaled.classes.upper[block[0]] for block in blocks]))
        shown = refutation(asked, alpha, _proof(scaled, search, found, listed))
        if shown is not None:
            return alpha, shown
    return None
