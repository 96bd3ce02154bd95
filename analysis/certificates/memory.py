"""Play and stop beside functions: the loop of the derivatives, and storage functions; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from . import arithmetic as exact
from . import states
from .arithmetic import ZERO, eliminated, need
from .balls import dot
from .channels import Channels, Plant, Rows, ordered


def remembered(asked: Channels) -> list[int]:
    """The channels of which the increments are bounded, beside play and stop: these and functions with such slopes."""
    slopes = [(ZERO, one.memory[1]) if one.memory else one.slope for one in asked.families]
    return [i for i in asked.functions if not asked.families[i].varying and exact.INF not in map(abs, slopes[i])]


def increments(H: Plant, asked: Channels) -> tuple[Plant, Channels]:
    """Beside play and stop: the loop of ``y = A x - B phi``, which is ``x'`` (``x+ - x``), with time-varying sectors.

    ``mu_i' = -g_i(t) sigma_i'`` for almost all ``t``, ``0 <= g_i <= k`` for play and stop, and within the bounds of the
    slope for functions; all are locally Lipschitz in time.  If ``y`` falls like ``e^(-c t)``, ``x`` has a limit.

    Functions ``w = phi_j`` of which the slopes are not bounded, or which depend on time, stay as they are: ``x' = y -
    B_w w``, and ``sigma_j = C_j A^-1 y - D_jj w`` if ``H(0) = 0`` from the others to ``sigma_j``, so that ``sigma_j =
    0`` wherever the loop may rest.  So it is with ``w`` and ``z`` of a gain, from ``x = 0`` and ``phi = 0``.
    """
    if not any(family.memory for family in asked.families):
        return H, asked
    out, families, free = asked.performance, list[states.Family](), (-exact.INF, exact.INF)
    covered = ordered(H.D, asked) and len(asked.operators) == (out is not None) and not H.late
    need(covered, "play and stop are covered beside functions and a gain, D without a cycle, without dead times")
    own, functions = remembered(asked), asked.functions
    for i in functions:
        family, moves = asked.families[i], i in own
        ends = ((ZERO, family.memory[1]) if family.memory else family.slope) if moves else asked.bounds(i)
        fits = not family.rough and exact.INF not in map(abs, ends)
        need(fits, f"channel {i + 1}, beside play and stop, has no finite bounds, or is not locally Lipschitz")
        families.append(states.Family(ends, free, (False, False), False, moves or family.varying, False))
    blocks, apart = [range(i, i + 1) for i in functions], [i for i in range(len(H.D)) if i not in own]
    if not apart:
        return H, Channels(families, blocks)
    T = [[v - (i == j) * H.discrete for j, v in enumerate(row)] for i, row in enumerate(H.A)]
    columns = [*zip(*H.B)]
    E = dict[int, list[Fraction]]()  # sigma_i = E_i y + D_ij w_j
    for i in apart:
        found = from_rest(T, [columns[j] for j in own], [[*H.C[i], *(H.D[i][j] for j in own)]])
        sector = f"channel {i + 1}, without slope bounds or with its own time, is moved by play and stop at rest: slope"
        sector += " bounds would serve, or H(0) = 0 from these"
        need(found is not None, sector if i in functions else "z is not 0 where play and stop may rest: H(0) is not 0")
        E[i] = (found or [])[0]
    direct = any(H.D[i][j] for i in own for j in apart)
    need(not direct, "beside play and stop w, and phi without slope bounds, may not enter sigma at once")
    B = [[dot(T[i], columns[j]) if j in apart else v for j, v in enumerate(row)] for i, row in enumerate(H.B)]
    D = [[dot(H.C[i], columns[j]) if j in apart else v for j, v in enumerate(row)] for i, row in enumerate(H.D)]
    for i in apart:
        D[i] = [v if j in apart else ZERO for j, v in enumerate(H.D[i])]
    C = [E.get(i, row) for i, row in enumerate(H.C)]
    last = [asked.families[i] for i in out or ()]
    return Plant(H.A, B, C, D, H.discrete), Channels([*families, *last], [*blocks, *([out] if out else [])])


def from_rest(T: Rows, columns: Any, rows: Any) -> Rows | None:
    """``g`` with ``g (T, b_1, b_2, ..)`` equal to each of the rows; None if there is none, or more than one."""
    W = [[*row, *(b[i] for b in columns)] for i, row in enumerate(T)]
    found = eliminated([[dot(v, w) for w in W] for v in W], [[dot(w, row) for row in rows] for w in W])
    g = None if found is None else [list(row) for row in zip(*found)]
    fits = g and all([dot(one, column) for column in zip(*W)] == list(row) for one, row in zip(g, rows))
    return g if fits else None


def apart(H: Plant, asked: Channels, theta: list[Fraction]) -> tuple[tuple[Any, Rows], list[Fraction]]:
    """What :func:`storages` makes of ``theta``, and Popov's terms: those of channels that keep their sector."""
    own = remembered(asked)
    popov = [ZERO if i in own else t for i, t in enumerate(theta)]
    need(not (H.discrete and any(popov)), "Popov's terms are for continuous time")
    return storages(H, asked, [t if i in own else ZERO for i, t in enumerate(theta)]), popov


def storages(H: Plant, asked: Channels, theta: list[Fraction]) -> tuple[Any, Rows]:
    """Pairs of rows, whose products are what storage functions add to ``V'/2``, and what they add to ``V``.

    ``sigma_i phi_i' >= (phi_i^2/(2 k))'`` for play, ``phi_i sigma_i' >= (phi_i^2/(2 k))'`` for stop, and the integrals
    of both are ``>= phi_i^2/(2 k)`` for a function with slopes in ``[0, k]``; the sum of both is ``(phi_i sigma_i)'``.
    With ``eta_i = c_i A^-1 y = sigma_i + H_i(0) phi`` and ``Theta H(0)`` symmetric ``2 sum theta_i phi_i' eta_i`` is at
    least the derivative of ``phi' Theta H(0) phi + sum |theta_i| phi_i^2/k_i + 2 sum_(theta_i < 0) theta_i phi_i
    sigma_i``.  ``V``, this and ``y'Py``, bounds ``phi_i`` where ``theta_i`` is not 0.

    With an eigenvalue 0, for stops: ``phi_i = f y`` if ``f A = 0``, ``f B = -e_i``; ``2 |theta_i| phi_i sigma_i'``.

    In discrete time, ``psi`` the difference of ``phi`` and ``A - 1`` in place of ``A`` in ``H`` and ``eta``, ``sigma_i+
    psi_i`` for play and ``phi_i+ (sigma_i+ - sigma_i)`` for stop are at least the difference of ``phi_i^2/2k`` and
    ``psi_i^2/2k``: ``eta_i`` is that of the next sample for ``theta_i > 0``, and ``psi'Theta H(1) psi - sum |theta_i|
    psi_i^2/k_i`` is added.
    """
    need(any(family.memory for family in asked.families), "storage functions are those of play and stop")
    need(not (H.discrete and asked.operators), "storage functions beside a gain are for continuous time")
    n, m, used, own = len(H.A), len(H.D), [i for i, t in enumerate(theta) if t], remembered(asked)
    stops = [i for i in own if (asked.families[i].memory or ("",))[0] == "stop"]
    memory = all(asked.families[i].memory for i in own)
    need(memory or {*used, *stops} >= {*own}, "beside functions all but stops need storage functions")
    for i in used:
        family, sign = asked.families[i], theta[i]
        right = (sign > 0) == (family.memory[0] == "play") if family.memory else family.slope[0] >= 0
        need(right, f"theta_{i + 1} has the wrong sign, or its function falls")
        need(not any(H.D[i]), f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone")
    columns, zeros, unit = [*zip(*H.B)], [ZERO] * m, [[Fraction(i == j) for j in range(m)] for i in range(m)]
    steep = {i: (asked.families[i].memory or ("", asked.families[i].slope[1]))[1] for i in used}
    T = [[v - (i == j) * H.discrete for j, v in enumerate(row)] for i, row in enumerate(H.A)]
    found = eliminated([list(column) for column in zip(*T)], [list(column) for column in zip(*H.C)])
    if found is None:
        need(not H.discrete, "storage functions do not cover an eigenvalue 1", exact.Critical)
        rows = [[*[ZERO] * n, *(Fraction(-(i == j)) for j in own)] for i in used]
        f = from_rest(H.A, [columns[j] for j in own], rows)
        need(bool(memory and f and {*used} <= {*stops}), "an eigenvalue 0 that these stops do not move", exact.Critical)
        into = [[dot(H.C[i], columns[j]) if j not in own else ZERO for j in range(m)] for i in used]
        pairs = [
            ([-theta[i] * v for v in g] + zeros, [*H.C[i], *(-v for v in b)]) for i, g, b in zip(used, f or [], into)
        ]
        scaled = [[abs(theta[i]) / steep[i] * v for v in g] for i, g in zip(used, f or [])]
        return pairs, [[dot(x, y) for y in zip(*(f or []))] for x in zip(*scaled)]
    E = [list(row) for row in zip(*found)]
    S = [[-t * dot(row, columns[j]) if j in own else ZERO for j in range(m)] for t, row in zip(theta, E)]
    need(all(S[i][j] == S[j][i] for i in range(m) for j in range(i)), "Theta H(0) is not symmetric")
    V = [
        [S[i][j] * (1 - (theta[i] < 0) - (theta[j] < 0)) + (i == j) * abs(theta[i]) / steep[i] for j in used]
        for i in used
    ]
    side = [[min(theta[i], ZERO) * v for v in E[i]] for i in used]
    top = [[*[ZERO] * n, *(row[j] for row in side)] for j in range(n)]
    pairs = [([theta[i] * v for v in E[i]] + zeros, [ZERO] * n + unit[i]) for i in used]
    for k, i in enumerate(used if H.discrete else ()):  # S = -Theta E B
        after = [dot(E[i], column) for column in zip(*H.A)] if theta[i] > 0 else E[i]
        direct = [max(theta[i], ZERO) * dot(H.C[i], column) * (j not in own) for j, column in enumerate(columns)]
        beside = [(v - (i == j) * abs(theta[i]) / steep[i]) / 2 - direct[j] for j, v in enumerate(S[i])]
        pairs[k] = [theta[i] * v for v in after] + beside, pairs[k][1]
    return pairs, top + [a + b for a, b in zip(side, V)]


def with_storage(M: Any, V: Any, unit: int, stored: Any) -> tuple[Any, Any]:
    """Lower triangles of the inequality and of ``V``, ``unit`` times, with what :func:`storages` adds to both."""
    pairs, extra = stored
    more = states.unit([*(row for pair in pairs for row in pair), *extra]) ** 2
    M = [[more * v for v in row] for row in M]
    for a, b in pairs:
        for i, row in enumerate(M):
            for j in range(i + 1):
                row[j] -= int(more * (a[i] * b[j] + a[j] * b[i])) * unit
    above = [[int(more * v) * unit for v in row[: i + 1]] for i, row in enumerate(extra)]
    for i, row in enumerate(V):
        above[i][: i + 1] = [u + more * v for u, v in zip(above[i], row)]
    return M, above
