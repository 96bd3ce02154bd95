r"""Play and stop, checked again: the loop of the derivatives, the gain from rest, and storage functions.

``y = A x - B phi`` is ``x'`` without ``w``.  With ``v = A^{-1} y``, the distance of ``x`` from where the loop rests
with this ``phi``, and ``u = phi'``,

.. math:: \dot v = A v - A^{-1} B u + B_w w, \quad \dot\sigma = C \dot v - (D - C A^{-1} B) u, \quad \eta = C v,
    \quad z = C_z v + D_{zw} w

where ``H(0) = 0`` from ``mu`` to ``z``.  ``V = y'P y`` and what ``sum theta_i u_i eta_i`` stores in ``phi``.  In
discrete time ``y = (A - 1) x - B phi``, ``v+ = A v - (A - 1)^{-1} B u`` and ``u = phi+ - phi``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from flint import arb_mat, fmpq, fmpq_mat

from lure.analysis.certificates.second.channels import Asked, acyclic, diagonal, joined, require_uniform
from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.reading import Document, NotShown, count, numbers, record, require


def remembering(asked: Asked) -> bool:
    """Whether a channel has play or stop."""
    return any(one.memory is not None for one in asked.nonlinearities)


def increments(asked: Asked) -> Asked:
    """The loop of the derivatives, in discrete time of the differences, where a channel has memory: sectors.

    Raises
    ------
    NotShown
        There are operators, or a cycle in ``D``; or of a gain, and of a function without slope bounds or with its own
        time: its ``z`` does not vanish at rest, or its ``w`` enters ``sigma`` at once.
    """
    if not remembering(asked):
        return asked
    alone = len(asked.operators) == bool(asked.performance)
    require(alone and acyclic(asked), "beside memory there are operators, or D has a cycle")
    classes, own = list[Nonlinearities](), _by_increments(asked)
    for i, one in enumerate(asked.nonlinearities):
        if one.operator:
            classes.append(one)
            continue
        require(not one.rough, "beside memory a function is not locally Lipschitz")
        slope = (Fraction(0), one.memory[1]) if one.memory is not None else one.slope
        low, high = slope if slope is not None and i in own else one.ends
        if not isinstance(low, Fraction) or not isinstance(high, Fraction):
            raise NotShown("beside memory a class has neither slope bounds nor a finite sector")
        varying = i in own or one.time_varying
        classes.append(Nonlinearities(lower=low, upper=high, slope=None, odd=False, time_varying=varying, linear=False))
    firsts = tuple(first if i in asked.performance else i for i, first in enumerate(asked.repeated))
    found = replace(asked, nonlinearities=tuple(classes), repeated=firsts)
    return from_rest(found, own) if len(own) < len(classes) else found


def _by_increments(asked: Asked) -> list[int]:
    """The channels of play and stop, and of functions with finite slope bounds that do not depend on time."""
    found = list[int]()
    for i, one in enumerate(asked.nonlinearities):
        bounded = one.slope is not None and all(isinstance(end, Fraction) for end in one.slope)
        if one.memory is not None or (bounded and not one.time_varying and not one.operator):
            found.append(i)
    return found


def from_rest(asked: Asked, own: list[int]) -> Asked:
    """The plant from ``(phi', w)`` to ``(sigma', z)``, discrete: of differences.

    Parameters
    ----------
    asked : Asked
        The plant from ``(phi, w)`` to ``(sigma, z)``.
    own : list of int
        The channels of ``phi``; in the others are ``z`` and ``w``: of a gain, and of functions that stay as they are.

    Raises
    ------
    NotShown
        There is none.
    """
    n, m = asked.A.nrows(), asked.D.nrows()
    T = asked.A - diagonal([Fraction(int(asked.discrete))] * n)
    functions, through = _chosen(m, own), _chosen(m, [i for i in range(m) if i not in own])
    require(bool(functions * asked.D * through == fmpq_mat(m, m)), "w enters sigma at once")
    # z = G (T x - B phi) where the loop rests with w = 0, whatever x and phi are
    G = _of_y(T, asked.B * functions, through * asked.C, through * asked.D * functions)
    B = asked.B * functions + T * asked.B * through
    C = functions * asked.C + G
    D = functions * (asked.D * functions + asked.C * asked.B * through) + through * asked.D * through
    return replace(asked, B=B, C=C, D=D)


def require_storage(document: Document, asked: Asked) -> None:
    """Check the circle criterion with storage functions of play and stop.

    Raises
    ------
    NotShown
        A hypothesis fails, or a matrix is not shown to be positive definite.
    """
    require(remembering(asked), "storage functions are those of memory")
    given, proof = record(document.multiplier, "lambda", "theta"), record(document.proof, "method", "P", "exponent")
    require(proof["method"] == "matrix", "the method does not fit the theorem")
    weights, theta, m, n = numbers(given["lambda"]), numbers(given["theta"]), asked.D.nrows(), asked.A.nrows()
    require(len(theta) == m, "there is not one storage function for each channel")
    moved, own, out = increments(asked), _by_increments(asked), asked.performance
    require_uniform(weights, moved)
    apart = [i for i in range(m) if i not in (*own, *out)]
    _require_popov(moved, [t if i in apart else Fraction(0) for i, t in enumerate(theta)])
    theta, popov = ([t if i in kept else Fraction(0) for i, t in enumerate(theta)] for kept in (own, apart))
    steep = [_require_sign(asked, i, t) for i, t in enumerate(theta)]
    known = [(theta[i], asked.nonlinearities[i].memory) for i in own]
    bounded = all(memory is not None and memory[0] == "stop" for t, memory in known if not t)
    one_function = any(memory is None for _, memory in known)
    require(bounded or not one_function, "solutions are not shown to be bounded")
    T = asked.A - diagonal([Fraction(int(asked.discrete))] * n)
    if T.det() == 0:
        require(not (one_function or asked.discrete), "an eigenvalue 0 beside functions and memory, or an eigenvalue 1")
        _require_moved_by_stops(asked, moved, (weights, popov), (theta, steep), proof)
        return
    require(not (asked.discrete and out), "in discrete time there are no storage functions beside a gain")
    back = T.inv()
    still = asked.D - asked.C * back * asked.B
    functions, kept, through = _chosen(m, own), _chosen(m, apart), _chosen(m, out)
    turn = diagonal(theta)
    S = turn * still * functions
    require(bool(S.transpose() == S), "Theta H(0) is not symmetric")
    # in v = A^-1 y, u = phi' (phi itself of functions that stay as they are) and w
    states, inputs = _unit_rows(n + m, 0, n), _unit_rows(n + m, n, m)
    beside = (through - kept) * inputs
    rate = T * states + asked.B * beside - back * asked.B * functions * inputs
    eta = asked.C * states
    seen = eta + asked.D * beside
    sigma, z = functions * (asked.C * rate - still * functions * inputs) + kept * seen, through * seen
    ends = moved.bounds
    low, high = (diagonal([pair[k] for pair in ends]) for k in (0, 1))
    u, w, share = (functions + kept) * inputs, through * inputs, diagonal(weights)
    products = (u - low * sigma).transpose() * share * (functions + kept) * (high * sigma - u)
    gain = z.transpose() * share * high * high * z - w.transpose() * share * w
    stored = u.transpose() * turn * eta + u.transpose() * diagonal(popov) * asked.C * rate
    Q = T.transpose() * _read_matrix(proof, n) * T
    change = states.transpose() * Q * rate
    if asked.discrete:
        after = states + rate
        change = (after.transpose() * Q * after - states.transpose() * Q * states) / 2
        stored = _stored_in_samples(u, (eta, asked.C * after), (turn, S), steep)
    half = change + products + gain + stored
    falls = -(half + half.transpose())
    negative = diagonal([min(t, Fraction(0)) for t in theta])
    edge = negative * asked.C  # of 2 theta phi sigma, sigma = eta - H(0) phi
    corner = S - negative * still * functions - (negative * still * functions).transpose()
    corner += diagonal([abs(t) / k for t, k in zip(theta, steep, strict=True)])
    Q += asked.C.transpose() * _least(popov, moved) * asked.C
    V = _without(joined(Q, edge.transpose(), corner), [n + i for i in range(m) if not theta[i]])
    _require_definite(V, falls)


def _require_popov(moved: Asked, theta: list[Fraction]) -> None:
    """Check that Popov's terms are of functions that do not depend on time, ``sigma`` a function of the state alone."""
    for one, t, row in zip(moved.nonlinearities, theta, moved.D.tolist(), strict=True):
        fits = not moved.discrete and not one.time_varying and not any(row)
        require(t == 0 or fits, "Popov's term does not fit its channel")


def _least(theta: list[Fraction], moved: Asked) -> fmpq_mat:
    """What ``2 sum theta_i int phi_i`` is at least, as a form in ``sigma``."""
    return diagonal([min(t * low, t * high) for t, (low, high) in zip(theta, moved.bounds, strict=True)])


def _stored_in_samples(
    u: fmpq_mat, eta: tuple[fmpq_mat, fmpq_mat], turned: tuple[fmpq_mat, fmpq_mat], steep: list[Fraction]
) -> fmpq_mat:
    """Half of what is at least the difference of what is stored, ``u`` being ``phi+ - phi``.

    ``2 theta u sigma+ >= theta ((phi^2)+ - phi^2 + u^2)/k`` for ``theta > 0``, else ``2 theta u sigma - 2 theta ((phi
    sigma)+ - phi sigma) >= |theta| (the same)``; with ``eta = sigma + H(1) phi`` of these samples ``2 u'S phi`` is
    ``(phi'S phi)+ - phi'S phi - u'S u``, and what is above that for the next sample ``2 u_i (S u)_i``.
    """
    (turn, S), m = turned, u.nrows()
    up = diagonal([Fraction(int(turn[i, i] > 0)) for i in range(m)])
    lost = diagonal([abs(Fraction(int(turn[i, i].p), int(turn[i, i].q))) / k for i, k in enumerate(steep)])
    rest = turn * eta[0] + up * turn * (eta[1] - eta[0])
    return u.transpose() * (rest + (S / 2 - up * S) * u - lost / 2 * u)


def _require_moved_by_stops(
    asked: Asked,
    moved: Asked,
    given: tuple[list[Fraction], list[Fraction]],
    stored: tuple[list[Fraction], list[Fraction]],
    proof: Mapping[str, object],
) -> None:
    """The same with an eigenvalue 0: ``phi_i = f_i y`` of stops, in the states ``y`` of the loop of the derivatives."""
    (weights, popov), (theta, steep), m, n = given, stored, asked.D.nrows(), asked.A.nrows()
    own = [i for i, t in enumerate(theta) if t]
    require(bool(own), "no storage function moves the eigenvalue 0")
    require(all(theta[i] < 0 for i in own), "with an eigenvalue 0 there are storage functions of stops alone")
    chosen, functions = _chosen(m, own), _chosen(m, _by_increments(asked))
    F = _of_y(asked.A, asked.B * functions, fmpq_mat(m, n), -1 * chosen)
    states, inputs = _unit_rows(n + m, 0, n), _unit_rows(n + m, n, m)  # inputs are (psi, phi, -w)
    rate = moved.A * states - moved.B * inputs
    seen = moved.C * states - moved.D * inputs
    share, ends = diagonal(weights), moved.bounds
    low, high = (diagonal([pair[k] for pair in ends]) for k in (0, 1))
    half = states.transpose() * _read_matrix(proof, n) * rate
    half += (inputs - low * seen).transpose() * share * (high * seen - inputs)
    half += (diagonal([-t for t in theta]) * F * states).transpose() * (chosen * seen)
    half += inputs.transpose() * diagonal(popov) * moved.C * rate
    kept = F.transpose() * diagonal([abs(t) / k for t, k in zip(theta, steep, strict=True)]) * F
    kept += moved.C.transpose() * _least(popov, moved) * moved.C
    _require_definite(_read_matrix(proof, n) + kept, -(half + half.transpose()))


def _of_y(T: fmpq_mat, B: fmpq_mat, rows: fmpq_mat, direct: fmpq_mat) -> fmpq_mat:
    """``G`` with ``G T = rows`` and ``G B = direct``."""
    both = fmpq_mat([[*a, *b] for a, b in zip(T.tolist(), B.tolist(), strict=True)])
    right = fmpq_mat([[*a, *b] for a, b in zip(rows.tolist(), direct.tolist(), strict=True)])
    gram = both * both.transpose()
    require(bool(gram.det() != 0), "the inputs do not move every state")
    G = right * both.transpose() * gram.inv()
    require(bool(G * both == right), "z does not vanish at rest, or an eigenvalue 0 is not moved by the stops")
    return G


def _read_matrix(proof: Mapping[str, object], n: int) -> fmpq_mat:
    rows = triangle(proof["P"], n)
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    unit = fmpq(2) ** -exponent
    return fmpq_mat([[rows[max(i, j)][min(i, j)] * unit for j in range(n)] for i in range(n)])


def _require_definite(*matrices: fmpq_mat) -> None:
    for bits in BITS:
        with working_precision(bits):
            if all(positive_definite(arb_mat(M)) for M in matrices):
                return
    raise NotShown("V, or the matrix of the inequality, is not shown to be positive definite")


def _require_sign(asked: Asked, i: int, theta: Fraction) -> Fraction:
    """The steepest slope of a channel, after a check that its storage function may have this weight."""
    one = asked.nonlinearities[i]
    if theta == 0:
        return Fraction(1)
    require(all(asked.D[i, j] == 0 for j in range(asked.D.nrows())), "sigma is no function of the state alone")
    if one.memory is not None:
        require((theta > 0) is (one.memory[0] == "play"), "the storage function has the wrong sign")
        return one.memory[1]
    if one.slope is None or not isinstance(one.slope[0], Fraction) or not isinstance(one.slope[1], Fraction):
        raise NotShown("a function without slope bounds has no storage function here")
    require(one.slope[0] >= 0 and one.slope[1] > 0, "a function that falls has no storage function here")
    return one.slope[1]


def _chosen(m: int, own: list[int]) -> fmpq_mat:
    return diagonal([Fraction(int(i in own)) for i in range(m)])


def _unit_rows(width: int, first: int, rows: int) -> fmpq_mat:
    return fmpq_mat([[fmpq(int(j == first + i)) for j in range(width)] for i in range(rows)])


def _without(M: fmpq_mat, left_out: list[int]) -> fmpq_mat:
    kept = [i for i in range(M.nrows()) if i not in left_out]
    return fmpq_mat([[M[i, j] for j in kept] for i in kept])
