r"""What follows from one quadratic function beside the gain: the energy of ``z`` after a push, and the peak of ``z``.

With ``V = x'Px`` and multipliers ``V' <= 2 lambda (|w|^2 - r^2 |z|^2)`` along every solution (``V+ - V`` in
discrete time).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from flint import fmpq_mat

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked, guarded
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above, places, triangle, triangle_texts
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for, searches
from lure.analysis.questions.decay_channels import SeveralChannels, accepted
from lure.analysis.questions.gain import classes_said, gain_problem, l2_gain
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.region_sets import positive
from lure.analysis.verdict import Evidence
from lure.analysis.wording import class_words, proviso, same_in
from lure.arrays import Reals, balanced, in_doubles, np
from lure.classes import OPERATORS, Diagonal, NonlinearityClass, Sector
from lure.errors import AssumptionError, InputError
from lure.exact import exact_number
from lure.files.system import LoopSystem
from lure.plants import as_plant
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import Page, Record, derived, plain, quantity

if TYPE_CHECKING:
    from lure.analysis.questions.channel_proofs import Criterion

_MARGINS, _FAR, _BITS = (1e-7, 1e-5, 1e-3), 300, 56
_ABOVE = (Fraction(1, 10**9), Fraction(1, 10**6), Fraction(1, 10**3))


class EnergyBounds(Record):
    """Bounds for every member of the classes that follow from quadratic functions; infinite where none was found."""

    initial: float = quantity(
        "``c`` with ``int |z|^2 <= c |x(0)|^2`` without disturbance, rounded up", plainly=plain, form="above"
    )
    peak: float = quantity(
        "``c`` with ``|z(t)|^2 <= c int |w|^2`` at every time, from rest, rounded up", plainly=plain, form="above"
    )
    reason: str = quantity("Why one of the two is infinite; empty if none is", default="")
    proofs: tuple[Proved, ...] = quantity(
        "What the checker accepted: gains, with the ``P`` from which the numbers follow", key="", label="", default=()
    )
    _said = "sentence"

    @property
    @derived()
    def assumed(self) -> str:
        """What the theorem assumes of the nonlinearities beyond their class; empty if nothing."""
        return " and ".join(dict.fromkeys(filter(None, map(proviso, self.proofs))))

    @property
    def _about(self) -> str:
        """The classes in words, as the certificates have them beside the channel from ``z`` to ``w``."""
        laws = self.proofs[0].certificate["laws"]
        own = [block for block in same_in(laws) if laws["channels"][block[0]].get("operator") != "performance"]
        kept = [laws["channels"][i] for block in own for i in block]
        return class_words({"channels": kept, "repeated": [len(block) for block in own]})

    def __str__(self) -> str:
        said = []
        if math.isfinite(self.initial):
            said.append(f"without disturbance the energy of z is at most {bound_above(self.initial)} |x(0)|^2")
        if math.isfinite(self.peak):
            said.append(f"from rest |z(t)|^2 is at most {bound_above(self.peak)} times the energy of w")
        text = "No quadratic function was found"
        if said:
            about = ", ".join(filter(None, (self._about, self.assumed)))
            text = f"for {about}: {'; '.join(said)} (certified)"
        return f"{text[0].upper()}{text[1:]}{f' ({self.reason})' if self.reason else ''}."

    def _page(self) -> Page:
        rows = [("energy of z over |x(0)|^2", self.initial), ("|z(t)|^2 over the energy of w", self.peak)]
        return Page("Energy and peak of z", [*rows, ("in a sentence", str(self))])


def energy_bounds(plant: object, classes: object = None, performance: object = None) -> EnergyBounds:
    r"""The energy of ``z`` after an initial state, and its peak under a disturbance of bounded energy.

    .. math:: \int |z|^2 \le c_0 |x(0)|^2 \quad (w = 0), \qquad |z(t)|^2 \le c_1 \int |w|^2 \quad (x(0) = 0),

    in discrete time with sums, for all members of the classes.  Each time the least ``c`` that the circle criterion
    with a multiplier for each channel shows: its ``P`` has ``c_0 > P`` for the one, ``c_1 > C_z P^{-1} C_z'`` for
    the other.

    Parameters
    ----------
    plant, classes, performance : object
        As for :func:`lure.analysis.l2_gain`.

    Returns
    -------
    EnergyBounds
        Both numbers.  They hold for the state that is given; in other coordinates the first is another.

    Raises
    ------
    InputError
        As there; or a class is neither a sector, nor slopes, nor a norm-bounded operator.

    Notes
    -----
    The certificates are those of an L2 gain with this ``P`` (Boyd, El Ghaoui, Feron, Balakrishnan 1994, sections 6.1
    and 6.2); the two numbers follow from it in exact arithmetic, by leading minors.

    Examples
    --------
    >>> from lure import Sector  # x' = -x - phi + w: x^2/2 falls by at most x^2 - x w
    >>> found = energy_bounds(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]})
    >>> round(found.initial, 3), round(found.peak, 3)
    (0.5, 0.5)
    """
    problem, stated, _, beside = gain_problem(plant, classes, performance)
    if beside:
        raise InputError("energy and peak are asked of w and z, which are not given; give [performance] with Bw and Cz")
    if not isinstance(problem.plant, MultivariablePlant):
        beside_what = "dead time" if isinstance(problem.plant, DelayMatrix) else "parameters"
        raise InputError(f"energy and peak are not bounded beside {beside_what}; ask for the gain alone")
    for one in problem.classes.classes:
        if one.memory or one.operator not in ("", *OPERATORS, "performance"):
            raise InputError(
                f"energy and peak are bounded for sectors, slopes and norm-bounded operators; this is {one}"
            )
    varying = tuple(
        one if one.operator else NonlinearityClass(sector=Sector(*one.gains), time_varying=True)
        for one in problem.classes.classes
    )
    loose = replace(problem, classes=Diagonal(varying, repeated=problem.classes.repeated))
    own = len(problem.classes.performance or ())
    gain = l2_gain(
        _first(problem, own), Diagonal(varying[:-own], repeated=_sizes(problem)), stated, criterion="circle"
    ).gain.high
    if math.isinf(gain):
        return EnergyBounds(initial=math.inf, peak=math.inf, reason="the circle criterion shows no gain")
    proofs, values, reason = list[Proved](), [math.inf, math.inf], ""
    straight = any(map(any, (*stated.Dzw, *stated.Dzmu)))
    for k in range(2):
        if k and straight:
            reason = "z has a direct term, Dzw or Dzmu, and no peak that energy bounds"
            continue
        for margin in _MARGINS:
            found = _bounded(loose, own, gain, margin, peak=bool(k))
            if found is not None:
                values[k] = found[0]
                proofs.append(found[1])
                break
        else:
            reason = "no quadratic function was found"
    return EnergyBounds(initial=values[0], peak=values[1], reason=reason, proofs=tuple(proofs))


def _sizes(problem: Problem) -> tuple[int, ...]:
    return tuple(len(block) for block in problem.classes.blocks[:-1])


def _first(problem: Problem, own: int) -> MultivariablePlant:
    """The plant without its performance channel."""
    H = cast("MultivariablePlant", problem.plant)
    m = H.inputs - own
    rows = [tuple(row[:m] for row in side) for side in (H.B, H.D[:m])]
    return replace(H, B=rows[0], C=H.C[:m], D=rows[1], names=())


def _bounded(problem: Problem, own: int, gain: float, margin: float, *, peak: bool) -> tuple[float, Proved] | None:
    """One of the numbers, and the certificate it follows from; None if the checker accepts none."""
    H = cast("MultivariablePlant", problem.plant)
    A, B, C, D = H.doubles()
    n, m = len(A), len(D)
    _, units = balanced(A)
    A, B, C = A * units / units[:, None], B / units[:, None], C * units
    z, w = (np.hstack([side, other]) for side, other in ((C, D), (np.zeros((m, n)), np.eye(m))))
    lower, upper = ([float(v) for v in side] for side in (problem.classes.lower, problem.classes.upper))
    groups = list[list[int]]()
    for block in problem.classes.blocks[:-1]:
        groups += [[*block]] if problem.classes.classes[block[0]].operator else [[i] for i in block]
    forms = list[Reals]()
    for group in groups:
        total = np.zeros((n + m, n + m))
        for i in group:
            if problem.classes.classes[i].operator:
                total += 2 * (upper[i] ** 2 * np.outer(z[i], z[i]) - np.outer(w[i], w[i]))
            else:  # psi = phi - l sigma = -mu - l sigma, and (u - l) sigma - psi = u sigma + mu
                product = np.outer(-w[i] - lower[i] * z[i], upper[i] * z[i] + w[i])
                total += product + product.T
            total += margin * np.outer(w[i], w[i])
        forms.append(total)
    basis = symmetric_basis(n)
    moved, x = np.hstack([A, B]), np.eye(n, n + m)
    if H.dt is None:
        rates = np.array([x.T @ e @ moved + moved.T @ e @ x for e in basis])
    else:
        rates = np.array([moved.T @ e @ moved - x.T @ e @ x for e in basis])
    last, count = slice(m - own, m), len(basis) + len(forms) + 1
    energy = {"w": w[last].T @ w[last], "z": z[last].T @ z[last]}
    scale = float(np.linalg.norm(B[:, last]) if peak else 1 / (np.linalg.norm(C[last]) or 1.0)) ** 2 or 1.0
    far = scale if peak else scale * (_FAR * gain) ** 2
    constant = far * (1 - margin) * energy["w"] - (0 if peak else scale * (1 + margin)) * energy["z"]
    slopes = np.concatenate([-rates, -np.array(forms).reshape(-1, n + m, n + m), np.zeros((1, n + m, n + m))])
    size = max(1.0, float(np.linalg.norm(A, 2))) if H.dt is None else 1.0
    slopes[: len(basis)] -= margin * size * np.array([x.T @ e @ x for e in basis])
    blocks = [Block(constant, slopes)]
    whole = np.zeros((count, n, n))
    whole[: len(basis)] = basis
    if peak:
        edge, q = np.zeros((count, n + own, n + own)), np.zeros((n + own, n + own))
        edge[: len(basis), :n, :n], edge[-1, n:, n:] = basis, np.eye(own)
        q[n:, :n], q[:n, n:] = C[last], C[last].T
        blocks += [Block(q, edge)]
    else:
        weight = np.diag(1 / units**2)
        edge = -whole
        edge[-1] = weight
        blocks += [Block(np.zeros((n, n)), whole), Block(np.zeros((n, n)), edge)]
    rows = np.zeros((len(forms), count))
    rows[:, len(basis) : -1] = -np.eye(len(forms))
    found = proposed(-np.eye(count)[-1], blocks, rows, np.zeros(len(forms)))
    if found is None:
        return None
    P = np.tensordot(found[: len(basis)], basis, 1) / units[:, None] / units
    weights = np.zeros(m)
    for group, value in zip(groups, found[len(basis) : -1], strict=True):
        weights[group] = max(float(value), 0.0)
    weights[last] = far / 2
    if not peak:
        return _accepted(problem, P, weights, Fraction(f"{1 / (_FAR * gain):.12g}"), peak=False)
    least = float(np.linalg.eigvalsh(np.tensordot(found[: len(basis)], basis, 1))[0])
    slack = margin * size * max(least, 0.0) / 2
    r = math.sqrt(slack / far) / (float(np.linalg.norm(C[last], 2)) or 1.0)
    if not r > 0:
        return None
    return _accepted(problem, P, weights, Fraction(f"{r:.12g}"), peak=True)


def _accepted(problem: Problem, P: Reals, weights: Reals, r: Fraction, *, peak: bool) -> tuple[float, Proved] | None:
    own = len(problem.classes.performance or ())
    channel = NonlinearityClass.performance(r)
    kept = problem.classes.classes[:-own]
    sizes = (*_sizes(problem), own)
    asked = replace(problem, classes=Diagonal((*kept, *[channel] * own), repeated=sizes))
    exponent = places(float(np.abs(np.diag(P)).min()), _BITS)
    rows = triangle(P, exponent)
    scaled = [Fraction(f"{v:.15g}") for v in weights]
    draft = {
        "verdict": "PROVED",
        "system": asked.system,
        "laws": asked.class_entry,
        "theorem": "diagonal-circle",
        "multiplier": {"lambda": [str(v) for v in scaled]},
        "proof": {"method": "matrix", "P": triangle_texts(rows), "exponent": exponent},
    }
    try:
        shown = checked(draft)
    except Rejected:
        return None
    n = len(rows)
    exact = [[Fraction(rows[max(i, j)][min(i, j)], 2**exponent) for j in range(n)] for i in range(n)]
    constant = _constant(problem, exact, 2 * scaled[-1], r, peak=peak)
    return None if constant is None or not isinstance(shown, Proved) else (constant, shown)


def _constant(
    problem: Problem, P: Sequence[Sequence[Fraction]], weight: Fraction, r: Fraction, *, peak: bool
) -> float | None:
    """A number that exact arithmetic shows: ``c > P/(weight r^2)``, or ``c > weight Cz P^-1 Cz'``."""
    n, H, own = len(P), cast("MultivariablePlant", problem.plant), len(problem.classes.performance or ())
    if not positive(P):
        return None
    V, Cz = in_doubles(P), H.C[-own:]
    if peak:
        C = in_doubles(Cz)
        about = float(weight) * float(np.linalg.eigvalsh(C @ np.linalg.solve(V, C.T))[-1])
    else:
        about = float(np.linalg.eigvalsh(V)[-1]) / float(weight * r * r)
    for step in _ABOVE:
        c = Fraction(double_above(Fraction(about) * (1 + step)))
        whole = [[(c * weight * r * r * (i == j)) - P[i][j] for j in range(n)] for i in range(n)]
        if peak:
            zero = Fraction(0)
            whole = [[*P[i], *(row[i] for row in Cz)] for i in range(n)]
            whole += [[*row, *(c / weight if i == j else zero for j in range(own))] for i, row in enumerate(Cz)]
        if c > 0 and positive(whole):
            return float(c)
    return None


# How far a solution may go before it decays: a number c for |x(t)| <= c |x(0)| e^(-rate t).

_QUADRATIC = ("diagonal-circle", "coupled-circle", "full-block-circle")  # V is x^T P x, and nothing beside it
_ROOM = (1e-9, 1e-6, 1e-3)  # beside eigenvalues in floating point


class Overshoot(Record):
    """``|x(t)| <= constant |x(0)| e^(-rate t)``, or ``rate^t``, for every solution of every loop of a class."""

    rate: Fraction = quantity("The rate, as for :class:`RateBound`", form="nearest")
    discrete: bool = quantity("Whether time is discrete", default=False)
    constant: float = quantity("The number ``c >= 1``: there may be smaller ones", form="above")
    evidence: Evidence = quantity("of the number", default=Evidence.CERTIFIED)
    proof: Proved = quantity(
        "What the checker accepted of the rate", key="certificate", label="", plainly=lambda p: p.certificate
    )
    _said = "sentence"

    @property
    @derived()
    def assumed(self) -> str:
        """What the theorem assumes of the nonlinearities beyond their class; empty if nothing."""
        return proviso(self.proof)

    def __str__(self) -> str:
        falls = f"{bound_above(self.rate)}^t (t in samples)" if self.discrete else f"exp({bound_above(-self.rate)} t)"
        about = ", ".join(filter(None, (class_words(self.proof.certificate["laws"]), self.assumed)))
        return f"|x(t)| <= {bound_above(self.constant)} |x(0)| {falls} for {about} ({self.proof.theorem}, certified)."


def require_states(block: object) -> None:
    """Refuse a plant of coefficients, whose states could be any, as soon as a number ``c`` is asked for.

    Raises
    ------
    InputError
        The plant is given without states.
    """
    if isinstance(block, RationalPlant) and block.matrices is None:
        raise InputError("the number c is about states, and the plant is given without; give A, B, C and D")


def overshoot(loop: object, classes: object = None, rate: float | Fraction = 0) -> Overshoot:
    r"""A number ``c`` with ``|x(t)| <= c |x(0)| e^(-rate t)`` for every solution of every loop of the classes.

    .. math:: V = \xi^\top P\,\xi, \quad \xi = e^{rate\,t} x, \quad m\,1 \le P \le M\,1, \quad c = \sqrt{M/m},

    with a ``P`` for which both checkers show that ``V`` falls; ``m`` and ``M`` are rational and exact.

    Parameters
    ----------
    loop : object
        As for :func:`decay_rate`; given by matrices, whose states are meant.
    classes : object
        A class for each channel, in a list; by default those of the loop.
    rate : float or Fraction
        A rate that is proved, and not the last one: the nearer to that, the larger ``c``.

    Raises
    ------
    InputError
        The loop has no states of its own, or ``rate`` is no number, in discrete time none above 0.
    AssumptionError
        No quadratic function was found that shows this rate.
    """
    block = loop.block if isinstance(loop, LoopSystem) else as_plant(loop)
    require_states(block)
    own = classes_said(loop) if classes is None else None
    asked = channel_problem(loop, classes) if own is None else channel_problem(block, own)
    several = SeveralChannels(asked)
    if not several.plant.order:
        raise InputError("the plant has no states; a bound of them needs one at least")
    exact = exact_number(rate, "rate")
    if several.discrete and exact <= 0:
        raise InputError(f"rate is {rate!r:.40}; give a factor above 0, such as 0.9")
    system = paced(several.base["system"], exact)
    A, B, C, D = (tuple(tuple(map(Fraction, row)) for row in system[side]) for side in "ABCD")
    scaled = replace(asked, plant=MultivariablePlant(A, B, C, D, several.plant.dt))
    best: tuple[Fraction, Proved] | None = None
    for criterion in criteria_for(scaled):
        if criterion.name in _QUADRATIC:
            work = partial(_proofs, scaled, criterion, several.base | {"rate": str(exact)})
            tried = guarded(criterion.name, work, passing=(TimeoutError,))
            for shown in tried if isinstance(tried, list) else ():
                found = _spread(shown)
                if found is not None and (best is None or found < best[0]):
                    best = found, shown
    if best is None:
        low = bound_below(exact)
        raise AssumptionError(f"no quadratic function shows the rate {low} for these classes; ask for a slower one")
    square = best[0]
    return Overshoot(rate=exact, discrete=several.discrete, constant=_root_above(square), proof=best[1])


def _proofs(scaled: Problem, criterion: Criterion, base: dict[str, Any]) -> list[Proved]:
    """What is accepted of the proposals that have a matrix."""
    classes, shown = scaled.classes, list[Proved]()
    widths = [high - low for high, low in zip(classes.upper, classes.lower, strict=True)]
    for search in searches(scaled, criterion):
        for one in search.proposals(widths, classes.lower):
            checkpoint()
            if "P" in one.proof and "zero" not in one.proof:  # else V has another term
                draft = {
                    "verdict": "PROVED",
                    "theorem": criterion.name,
                    "multiplier": one.multiplier,
                    "proof": one.proof,
                }
                found = accepted(base | draft)
                if isinstance(found, Proved):
                    shown.append(found)
                    break
    return shown


def _spread(shown: Proved) -> Fraction | None:
    """``M/m`` with ``m 1 < P < M 1``, exactly; None if rounding hides it."""
    rows = [[Fraction(v) for v in row] for row in shown.certificate["proof"]["P"]]
    n = len(rows)
    P = [[rows[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
    values = np.linalg.eigvalsh(in_doubles(P))
    for room in _ROOM:
        low, high = Fraction(float(values[0]) * (1 - room)), Fraction(float(values[-1]) * (1 + room))
        if low > 0 and _above(P, low, 1) and _above(P, high, -1):
            return high / low
    return None


def _above(P: list[list[Fraction]], end: Fraction, sign: int) -> bool:
    """Whether ``sign (P - end 1)`` is positive definite, by its leading minors."""
    turned = [[sign * (v - end * (i == j)) for j, v in enumerate(row)] for i, row in enumerate(P)]
    minors = (fmpq_mat([[to_fmpq(v) for v in row[:k]] for row in turned[:k]]).det() for k in range(1, len(P) + 1))
    return all(minor > 0 for minor in minors)


def _root_above(square: Fraction) -> float:
    """A double at or above the root."""
    root = double_above(Fraction(float(square) ** 0.5))
    while Fraction(root) ** 2 < square:
        root = float(np.nextafter(root, np.inf))
    return root
