r"""Several nonlinearities, checked again: the loop shifted by the lower bounds, and a Schur complement in balls.

With ``phi = L sigma + psi``, ``psi_i`` in ``[0, w_i]``, and ``sigma = C x + D mu`` the loop is ``x' = A~ x - B~ psi``
with ``sigma = C~ x - D~ psi``, ``E = (1 + D L)^{-1}``, ``C~ = E C``, ``D~ = E D``, ``A~ = A - B L C~``, ``B~ = B (1 - L
D~)``.  The form ``V = x'P x + 2 sum theta_i int_0^{sigma_i} phi_i`` is ``x'Q x + 2 sum theta_i int psi_i``, where ``Q =
P + C' L Theta C``.  With ``Pi`` for the form of the multiplier in ``(sigma, psi)`` and ``N = C~' (Pi_12 - Pi_11 D~) +
A~' C' Theta``, what has to be positive definite is

.. math::

    \begin{pmatrix} -(\tilde A'Q + Q\tilde A) - \tilde C'\Pi_{11}\tilde C & Q\tilde B - N \\ \cdot &
    \Pi_{21}\tilde D + \tilde D'\Pi_{12} - \Pi_{22} - \tilde D'\Pi_{11}\tilde D + \Theta C\tilde B + \tilde B'C'\Theta
    \end{pmatrix},

in discrete time, ``Theta = 0``, with ``Q - A~'Q A~``, ``A~'Q B~`` and ``- B~'Q B~`` for the terms of ``Q``.  ``V > 0``
if ``Q + C' Theta^- W C > 0``, ``Theta^-`` the negative part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product

from flint import arb_mat, fmpq, fmpq_mat, fmpz

from lure.analysis.certificates.second import channel_boxes
from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channel_gains import refuted, require_gains
from lure.analysis.certificates.second.channels import (
    Asked,
    acyclic,
    diagonal,
    joined,
    on_axis,
    read,
    require_uniform,
    stacked,
    symmetric,
)
from lure.analysis.certificates.second.dead_times import shown_late
from lure.analysis.certificates.second.delays import refuted_by_delay, refuted_by_delayed_members, without_delays
from lure.analysis.certificates.second.frequencies import (
    Multiplier,
    read_multiplier,
    require_frequencies,
    require_weights,
    still,
)
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.members import refuted_by_members
from lure.analysis.certificates.second.memory import increments, remembering, require_storage
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.pace import popov_terms
from lure.analysis.certificates.second.parametric import require_parametric
from lure.analysis.certificates.second.pieces import require_pieces
from lure.analysis.certificates.second.rays import refuted_by_ray
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    mapping,
    numbers,
    record,
    require,
)
from lure.analysis.certificates.second.signals import refuted_by_signal
from lure.analysis.certificates.second.windows import require_windows, static_form
from lure.analysis.certificates.second.zero import (
    MOST_VERTICES,
    integrators_apart,
    require_equilibria,
    require_one_solution,
    shifted_by,
    without,
)

_MULTIPLIERS = {"diagonal": "lambda", "coupled": "forms", "full-block": "Pi"}


def shown(document: Document) -> str:
    """The sentence that a certificate about several nonlinearities shows.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    require(document.nonlinearity is None, "no nonlinearity is given beside several classes")
    if document.system.get("kind") in (channel_boxes.KIND, channel_boxes.VARYING):
        if document.verdict == "PROVED":
            return claims.GAIN if channel_boxes.require_proved(document) else claims.ATTRACTS
        if document.proof.get("method") == "members":
            channel_boxes.require_growth(document)
            return claims.NO_REST
        document = channel_boxes.one_member(document)
    asked = replace(read(document), pace=document.rate)
    if asked.late:
        return shown_late(document, asked)
    if document.verdict == "PROVED":
        if document.theorem == "storage-circle":
            require_storage(document, asked)
            return claims.GAIN if asked.performance else claims.EQUILIBRIA
        if remembering(asked):
            require("semidefinite" not in document.proof, "with memory no form is semidefinite")
            require(not _proved(document, increments(asked)), "with memory an eigenvalue 0 is not covered")
            return claims.GAIN if asked.performance else claims.EQUILIBRIA
        kept = document.theorem in ("piecewise-circle", "piecewise-popov")
        if not _proved(document, without_delays(asked, constant=not kept)):
            return claims.GAIN if asked.performance else claims.ATTRACTS
        require(len(asked.operators) == bool(asked.performance), "with operators an eigenvalue 0 is not covered")
        if asked.performance:
            return claims.GAIN
        varying = any(one.time_varying for one in asked.nonlinearities)
        return claims.BOUNDED if varying else claims.EQUILIBRIA
    require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    others = {
        "linear-members": refuted_by_members,
        "signal": refuted_by_signal,
        "delayed-gains": refuted_by_delay,
        "delayed-members": refuted_by_delayed_members,
        "relu-ray": refuted_by_ray,
    }
    return others.get(str(document.proof.get("method")), refuted)(document, asked)


def _proved(document: Document, asked: Asked) -> bool:
    """Whether with an eigenvalue 0 at the lower bounds, if it is proved at all."""
    if document.theorem == "parameter-dependent":
        require(not asked.operators, "operators are not covered beside unknown gains")
        require_parametric(document, asked)
        return False
    if document.theorem in ("order-cones", "coupled-windows"):
        return require_windows(document, asked)
    if document.theorem in ("piecewise-circle", "piecewise-popov"):
        require_pieces(document, asked)
        return False
    if mapping(document.proof).get("method") == "determinant":
        return _over_frequencies(document, asked)
    if document.theorem == "constant-gains":
        require_gains(document, asked)
        return False
    m, (kind, _, theorem) = asked.D.nrows(), document.theorem.rpartition("-")
    popov, full = theorem == "popov", kind == "full-block"
    require(theorem in ("circle", "popov") and kind in _MULTIPLIERS, "the theorem is not one for channels")
    names = {_MULTIPLIERS[kind]} | ({"theta"} if popov else set()) | ({"lambda"} if asked.operators else set())
    given = record(document.multiplier, *names, *(("N",) if full and "N" in document.multiplier else ()))
    theta = numbers(given["theta"]) if popov else [Fraction(0)] * m
    require(len(theta) == m, "the multipliers are not one for each channel")
    require(
        not any(nonlinearities.rough for nonlinearities in asked.nonlinearities),
        "the theorem is for locally Lipschitz nonlinearities",
    )
    require(not (popov and asked.discrete), "Popov's criterion is for continuous time")
    _require_fitting(theta, asked)
    zero, loose = (("zero",) if "zero" in mapping(document.proof) else ()), "semidefinite" in mapping(document.proof)
    proof = record(document.proof, "method", "P", "exponent", *zero, *(("semidefinite",) if loose else ()))
    require(proof["method"] == "matrix", "the method does not fit the theorem")
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    bounds, needed = asked.bounds, list[fmpq_mat]()
    weights = numbers(given["lambda"]) if "lambda" in given else [Fraction(0)] * m
    require_uniform(weights, asked)
    Pi = _diagonal_multiplier(weights, asked)
    rest = [i for i in range(m) if not asked.nonlinearities[i].operator]
    if kind != "diagonal":
        require(bool(rest) and all(weights[i] == 0 for i in rest), "a full block and weights for the same channels")
    if kind == "coupled":
        part, bounds = static_form(given["forms"], asked)
        require_one_solution(asked, bounds)
        Pi += part
    elif full:
        part, needed = _full_block(given, [asked.bounds[i] for i in rest])
        place = fmpq_mat([[int(i == j) for i in (*rest, *(m + i for i in rest))] for j in range(2 * m)])
        Pi += place * part * place.transpose()
    if document.rate is not None:
        Pi += _with_rate(theta, document.rate, bounds, asked)
    shifted = shifted_by(asked, bounds)
    rows, left_out = triangle(proof["P"], asked.A.nrows()), list[int]()
    least, whole = _forms((asked.C, bounds, asked.discrete), shifted, (rows, exponent), Pi, theta)
    if loose:
        require(proof["semidefinite"] is True and not zero and kind == "diagonal", "no form may be semidefinite here")
        require(len(asked.operators) == 1 == bool(asked.performance) and acyclic(asked), "no gain, or D has a cycle")
        require(_nonnegative(least) and _nonnegative(whole), "V or its fall is negative somewhere")
        return False
    if zero:
        left_out = require_equilibria(asked, shifted, bounds, (rows, exponent), Pi, theta, proof["zero"])
        require(all(map(_nonnegative, needed)), "the form of the multiplier is negative for some gains")
        needed = []
    for bits in BITS:
        with working_precision(bits):
            falls = without(arb_mat(whole), left_out)
            if all(map(positive_definite, (arb_mat(least), falls, *map(arb_mat, needed)))):
                return bool(zero)
    raise NotShown("V, the multiplier or the matrix of the inequality is not shown to be positive definite")


def _require_fitting(theta: Sequence[Fraction], asked: Asked) -> None:
    """Check that Popov's terms are of functions that do not depend on time, of outputs without direct term."""
    for i, one in enumerate(asked.nonlinearities):
        state_only = all(asked.D[i, j] == 0 for j in range(asked.D.ncols()))
        fits = state_only and not one.time_varying and not one.operator
        require(theta[i] == 0 or fits, "Popov's term does not fit its channel")


def _nonnegative(form: fmpq_mat) -> bool:
    """Whether a symmetric matrix is positive semidefinite: all roots are real, and nonnegative if these signs are."""
    return all(c * (-1) ** (form.nrows() - i) >= 0 for i, c in enumerate(form.charpoly().coeffs()))


def _diagonal_multiplier(weights: Sequence[Fraction], asked: Asked) -> fmpq_mat:
    """``2 sum lambda_i psi_i (w_i sigma_i - psi_i)``."""
    side = diagonal([v * (high - low) for v, (low, high) in zip(weights, asked.bounds, strict=True)])
    return joined(side * 0, side, diagonal([-2 * v for v in weights]))


def _with_rate(
    theta: Sequence[Fraction], rate: Fraction, bounds: Sequence[tuple[Fraction, Fraction]], asked: Asked
) -> fmpq_mat:
    """A form in ``(sigma, psi)`` above what Popov's terms add with a rate."""
    nothing = Fraction(0)
    each = [
        popov_terms(turn * rate, high - low, sloped=one.slopes_within(low, high)) if turn else (nothing,) * 3
        for one, turn, (low, high) in zip(asked.nonlinearities, theta, bounds, strict=True)
    ]
    square, cross, last = (diagonal(list(side)) for side in zip(*each, strict=True))
    return joined(square, cross, last)


def _full_block(
    given: Mapping[str, object], bounds: Sequence[tuple[Fraction, Fraction]]
) -> tuple[fmpq_mat, list[fmpq_mat]]:
    """``Pi`` for ``(sigma, psi)``, and what has to be positive definite for its form to be nonnegative in the class."""
    m, one = len(bounds), diagonal([Fraction(1)] * len(bounds))
    require(m <= MOST_VERTICES, "there are too many channels for full-block multipliers")
    shift, width = diagonal([low for low, _ in bounds]), [high - low for low, high in bounds]
    move = joined(one, 0 * one, one, lower_left=shift)  # phi = psi + l sigma
    Pi = move.transpose() * symmetric(given["Pi"], 2 * m) * move
    if "N" not in given:
        require(all(Pi[i, i] <= 0 for i in range(m, 2 * m)), "the form is not concave in each gain")
        views = [stacked(one, diagonal(list(ends))) for ends in product(*((Fraction(0), w) for w in width))]
        return Pi, [view.transpose() * Pi * view for view in views]
    shares = diagonal([1 / w for w in width])
    view = joined(shares, shares, 0 * one, lower_left=one)  # (sigma, psi) of (psi, w sigma - psi)
    inner, parts = view.transpose() * Pi * view, listed(given["N"])
    patterns = [[Fraction(s) for s in (1, *rest)] for rest in product((1, -1), repeat=m - 1)]
    require(len(parts) == len(patterns), "N has not one part for each pattern of signs")
    needed = []
    for signs, part in zip(patterns, parts, strict=True):
        N, turn = symmetric(part, 2 * m), diagonal([*signs, *signs])
        require(all(v >= 0 for v in N.entries()), "an entry of N is negative")
        needed.append(turn * inner * turn - N)
    return Pi, needed


def _over_frequencies(document: Document, asked: Asked) -> bool:
    """The inequality over all frequencies, of the circle criterion, Popov's, or with kernels; whether 0 is a pole."""
    m = asked.D.nrows()
    record(document.proof, "method")
    scaled = document.theorem == "matrix-scalings"
    require(asked.discrete is scaled, "over frequencies it is not decided in this time")
    odd = [one.odd for one in asked.nonlinearities]
    gains = [one.linear and not one.time_varying for one in asked.nonlinearities]
    operators = [(block, block in asked.scalar) for block in asked.operators]
    given = read_multiplier(document.theorem, document.multiplier, odd, asked.repeated, gains, operators, document.rate)
    require_uniform([given.gamma[i][i] for i in range(m)], asked)
    bounds = list[tuple[Fraction, Fraction]]()
    for i, one in enumerate(asked.nonlinearities):
        coupled = i in given.moved
        low, high = one.slope if coupled and one.slope is not None else one.ends
        if not (isinstance(low, Fraction) and isinstance(high, Fraction) and low < high):
            raise NotShown("a channel has no finite bounds")
        bounds.append((low, high))
        require(
            not coupled or one.slope is not None or one.operator != "", "a channel with kernels has no slope bounds"
        )
        require(not one.rough, "the theorem is for locally Lipschitz nonlinearities")
        constant = given.theta[i] == 0 and not coupled
        require(constant or not one.time_varying, "a nonlinearity depends on time, its multiplier must not")
        state_only = all(asked.D[i, j] == 0 for j in range(m))
        fits = state_only and not one.operator
        require(given.theta[i] == 0 or fits, "Popov's term does not fit its channel")
    if scaled:
        _require_scalings(given, asked)
    if document.rate is not None:
        for one, turn, ends in zip(asked.nonlinearities, given.theta, bounds, strict=True):
            require(turn == 0 or one.slopes_within(*ends), "Popov's term with a rate needs slopes within the bounds")
        require_weights(given, [high - low for low, high in bounds], document.rate)
    own = on_axis(asked) if scaled else asked
    shifted, widths = shifted_by(own, bounds), [high - low for low, high in bounds]
    critical, jump = bool(shifted[0].det() == 0), asked.D * 0
    if critical:
        constant = not given.moved and not any(given.theta)
        require(document.rate is None or constant, "an eigenvalue 0, a rate, and a multiplier that is not constant")
        require(not scaled, "scalings do not cover an eigenvalue 0")
        at_zero = still(given)
        shifted, jump = integrators_apart(shifted, at_zero * diagonal(widths))
        if given.moved:
            signs = (at_zero + at_zero.transpose()).charpoly().coeffs()  # all roots are real
            require(all(c * (-1) ** (m - i) > 0 for i, c in enumerate(signs)), "He M(0) is not positive definite")
            crossing = (v for i in asked.performance for j in range(m) for v in (jump[i, j], jump[j, i]))
            require(not any(v != 0 for v in crossing), "w moves the eigenvalue 0, or z sees it, beside kernels")
            for one, (low, _) in zip(asked.nonlinearities, bounds, strict=True):
                if one.operator:
                    continue
                steepest = "inf" if one.slope is None else one.slope[1]
                rising = one.slope is not None and claims.at_least(one.slope[0], low) and not one.time_varying
                require(rising and isinstance(steepest, Fraction), "kernels, an eigenvalue 0, and no slope bounds")
    require_frequencies(shifted, own.C, widths, given, jump)
    linear = all(one.operator or one.linear for one in asked.nonlinearities)  # then F > 0 at infinity is enough
    if document.theorem.startswith("matrix") and (asked.discrete or not linear):
        require_one_solution(asked, bounds)
    return critical


def _require_scalings(given: Multiplier, asked: Asked) -> None:
    """Check that in discrete time only operators and constant gains have a function of the frequency."""
    require(not any(given.theta), "there are no Popov terms in discrete time")
    for chain in given.chains:
        one = asked.nonlinearities[chain.column]
        require(one.linear or one.operator != "", "a kernel is not one of a gain or an operator")


def _forms(
    loop: tuple[fmpq_mat, Sequence[tuple[Fraction, Fraction]], bool],
    shifted: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    scaled: tuple[list[list[fmpz]], int],
    multiplier: fmpq_mat,
    theta: Sequence[Fraction],
) -> tuple[fmpq_mat, fmpq_mat]:
    """What has to be positive definite: for ``V``, and for its fall."""
    (rows, exponent), (own, bounds, discrete), n, m = scaled, loop, shifted[0].nrows(), shifted[3].nrows()
    (A, B, C, D), unit, turn = shifted, fmpq(2) ** -exponent, diagonal(theta)
    P = fmpq_mat([[rows[max(i, j)][min(i, j)] * unit for j in range(n)] for i in range(n)])
    low, width = [low for low, _ in bounds], [high - low for low, high in bounds]
    square, cross, last = (_part(multiplier, *at, m) for at in ((0, 0), (0, m), (m, m)))
    Q = P + own.transpose() * diagonal([t * v for t, v in zip(theta, low, strict=True)]) * own
    least = Q + own.transpose() * diagonal([min(t, Fraction(0)) * v for t, v in zip(theta, width, strict=True)]) * own
    moved = A.transpose() * Q
    side, seen = C.transpose() * (cross - square * D), C.transpose() * square * C
    both = cross.transpose() * D
    corner = both + both.transpose() - last - D.transpose() * square * D
    if discrete:
        main, edge, corner = Q - moved * A - seen, moved * B - side, corner - B.transpose() * Q * B
    else:
        rate = turn * own * B
        main, edge = -(moved + moved.transpose() + seen), Q * B - side - A.transpose() * own.transpose() * turn
        corner = corner + rate + rate.transpose()
    top = [[*(main[i, j] for j in range(n)), *(edge[i, j] for j in range(m))] for i in range(n)]
    bottom = [[*(edge[j, i] for j in range(n)), *(corner[i, j] for j in range(m))] for i in range(m)]
    return least, fmpq_mat([*top, *bottom])


def _part(M: fmpq_mat, top: int, left: int, m: int) -> fmpq_mat:
    return fmpq_mat([[M[top + i, left + j] for j in range(m)] for i in range(m)])
