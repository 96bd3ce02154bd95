r"""Linear members of classes with operators, checked again: an unstable loop, or a gain that is larger.

A scalar operator is one all-pass times ``c``.  Another, ``Delta = u v'``, has ``u_i = c_i a_i`` with stable all-passes
``a_i``, likewise ``v``, so that its norm is ``|c| |c'|`` at every frequency.  It is realised beside the plant:
``sigma_j`` drives ``v_j``, their sum drives all ``u_i``, and ``mu_i = -u_i``.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import fmpq, fmpq_mat

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channel_gains import unstable
from lure.analysis.certificates.second.channels import Asked, half_plane_stable, member, nearby_member
from lure.analysis.certificates.second.numerics import half_plane_counts, to_fmpq
from lure.analysis.certificates.second.reading import Document, listed, number, numbers, record, require

Pairs = list[tuple[Fraction, Fraction | None]]


def refuted_by_members(document: Document, asked: Asked) -> str:
    """What linear members do.

    Raises
    ------
    NotShown
        They are not of the class, or do nothing of the kind.
    """
    gain = "omega" in document.proof
    proof = record(document.proof, "method", "gains", "operators", *(("omega", "input") if gain else ()))
    gains, blocks = (
        (nearby_member if gain else member)(proof["gains"], asked),
        [b for b in asked.operators if b[0] not in asked.performance],
    )
    gained = (*claims.DELAYS, claims.FULL_BLOCK)  # which have members among the gains
    blocks = [b for b in blocks if asked.nonlinearities[b[0]].operator not in gained]
    given = listed(proof["operators"])
    require(len(given) == len(blocks), "there is not one member for each operator")
    parts = list[tuple[list[int], Pairs, Pairs]]()
    for block, one in zip(blocks, given, strict=True):
        norm = asked.nonlinearities[block[0]].ends[1] or Fraction(0)
        if block in asked.scalar:
            ((c, rate),) = _pairs([record(one, "delta")["delta"]], 1, discrete=asked.discrete)
            require(abs(c) <= norm, "the norm of a member is too large")
            require(all(gains[i] == 0 for i in block), "a channel has a gain and an operator")
            parts += [([i], [(c, None)], [(Fraction(1), rate)]) for i in block]
            continue
        sides = record(one, "left", "right")
        left, right = (_pairs(sides[name], len(block), discrete=asked.discrete) for name in ("left", "right"))
        size = sum(c * c for c, _ in left) * sum(c * c for c, _ in right)
        require(size <= norm**2, "the norm of a member is too large")
        require(all(gains[i] == 0 for i in block), "a channel has a gain and an operator")
        parts.append((block, left, right))
    A, B, C, D, own = _closed(asked, gains, parts)
    if not gain:
        n = asked.A.nrows()
        alone = fmpq_mat([[A[i, j] for j in range(n, A.nrows())] for i in range(n, A.nrows())])
        require(alone.nrows() == 0 or _stable(alone, discrete=asked.discrete), "the members are unstable by themselves")
        return unstable(A, discrete=asked.discrete)
    require(bool(own), "there is no performance channel")
    stable = not parts or _stable(A, discrete=asked.discrete)  # of gains a pole that z does not see may be anywhere
    require(stable, "the loop of the members is not stable")
    w = [numbers(pair) for pair in listed(proof["input"])]
    require(len(w) == len(own) and all(len(pair) == 2 for pair in w), "the input does not fit")
    z = _response((A, B, C, D), w, None if proof["omega"] is None else number(proof["omega"]), discrete=asked.discrete)
    r = asked.nonlinearities[asked.performance[0]].ends[1]
    least = to_fmpq(sum(v * v for pair in w for v in pair)) / to_fmpq(r or Fraction(0)) ** 2
    require(bool(sum((v * v for v in z), fmpq(0)) > least), "the gain is not shown to be above gamma")
    return claims.EXCEEDED


def _pairs(value: object, size: int, *, discrete: bool) -> Pairs:
    found: Pairs = []
    for one in listed(value):
        pair = listed(one)
        require(len(pair) == 2, "an all-pass is not a pair")
        rate = None if pair[1] is None else number(pair[1])
        require(rate is None or (-1 < rate < 1 if discrete else rate > 0), "an all-pass is not stable")
        found.append((number(pair[0]), rate))
    require(len(found) == size, "a member has another number of channels")
    return found


def _stable(A: fmpq_mat, *, discrete: bool) -> bool:
    return half_plane_stable(A) if discrete else half_plane_counts(A.charpoly()).left == A.nrows()


def _closed(
    asked: Asked, gains: Sequence[Fraction], parts: Sequence[tuple[list[int], Pairs, Pairs]]
) -> tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat, list[int]]:
    """The loop from ``w`` to ``z``: ``M (x', mu, sigma, q) = ...`` solved for all signals from ``(x, q, w)``.

    Unknown are ``mu`` and ``sigma``; the states ``q`` are those of the all-passes, right ones before left ones in each
    operator.
    """
    n, m, own = asked.A.nrows(), asked.D.nrows(), asked.performance
    filters = [
        (i, c, rate, side)
        for block, left, right in parts
        for side, pairs in ((1, right), (0, left))
        for i, (c, rate) in zip(block, pairs, strict=True)
    ]
    order = {(i, side): n + k for k, (i, _, _, side) in enumerate(f for f in filters if f[2] is not None)}
    size = n + len(order)
    width = size + len(own)

    # each signal is a row: coefficients of (x, q, w), and of the unknowns sigma
    def blank() -> list[fmpq]:
        """A signal that is 0."""
        return [fmpq(0)] * (width + m)

    def passed(signal: list[fmpq], i: int, rate: Fraction | None, side: int) -> list[fmpq]:
        """What an all-pass makes of a signal; its state is driven by it."""
        if rate is None:
            return signal
        at, a = order[i, side], to_fmpq(rate)
        pole, gain, direct = (a, 1 - a * a, -a) if asked.discrete else (-a, -2 * a, fmpq(1))
        driven[at] = [v + pole * (k == at) for k, v in enumerate(signal)]
        return [direct * v + gain * (k == at) for k, v in enumerate(signal)]

    driven = dict[int, list[fmpq]]()
    mu = [blank() for _ in range(m)]
    for i, g in enumerate(gains):
        mu[i][width + i] = -to_fmpq(g)
    for k, i in enumerate(own):
        mu[i] = blank()
        mu[i][size + k] = fmpq(1)
    for block, left, right in parts:
        total = blank()
        for j, (c, rate) in zip(block, right, strict=True):
            unit = blank()
            unit[width + j] = fmpq(1)
            total = [s + to_fmpq(c) * v for s, v in zip(total, passed(unit, j, rate, 1), strict=True)]
        for i, (c, rate) in zip(block, left, strict=True):
            mu[i] = [-to_fmpq(c) * v for v in passed(total, i, rate, 0)]
    rows = fmpq_mat(mu)
    both = asked.D * rows  # sigma = C x + D mu
    known = fmpq_mat([[both[i, k] + (asked.C[i, k] if k < n else 0) for k in range(width)] for i in range(m)])
    whole = fmpq_mat([[fmpq(int(i == j)) - both[i, width + j] for j in range(m)] for i in range(m)])
    require(bool(whole.det() != 0), "the loop of the members has no solution")
    sigma = whole.inv() * known

    def solved(signals: fmpq_mat) -> fmpq_mat:
        """Signals without the unknowns."""
        cut = fmpq_mat([[signals[i, k] for k in range(width)] for i in range(signals.nrows())])
        rest = fmpq_mat([[signals[i, width + k] for k in range(m)] for i in range(signals.nrows())])
        return cut + rest * sigma

    inner = asked.B * rows
    plain = [[inner[i, k] + (asked.A[i, k] if k < n else 0) for k in range(width + m)] for i in range(n)]
    moved = solved(fmpq_mat([*plain, *(driven[n + k] for k in range(size - n))]))
    A = fmpq_mat([[moved[i, k] for k in range(size)] for i in range(size)])
    B = fmpq_mat([[moved[i, size + k] for k in range(len(own))] for i in range(size)])
    C = fmpq_mat([[sigma[i, k] for k in range(size)] for i in own])
    D = fmpq_mat([[sigma[i, size + k] for k in range(len(own))] for i in own])
    return A, B, C, D, own


def _response(
    loop: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    w: Sequence[Sequence[Fraction]],
    omega: Fraction | None,
    *,
    discrete: bool,
) -> list[fmpq]:
    """Real and imaginary parts of ``z`` for ``w``, by the matrix ``(c - A)^2 + d^2``."""
    A, B, C, D = loop
    re, im = (fmpq_mat([[to_fmpq(pair[k])] for pair in w]) for k in (0, 1))
    straight = [D * re, D * im]
    if omega is None and not discrete:
        return [v for side in straight for v in side.entries()]
    t = fmpq(0) if omega is None else to_fmpq(omega)
    c, d = fmpq(0), t
    if discrete:
        c, d = (fmpq(-1), fmpq(0)) if omega is None else ((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))
    n = A.nrows()
    one = fmpq_mat([[int(i == j) for j in range(n)] for i in range(n)])
    K = c * one - A
    p, q = B * re, B * im
    # K x - d y = p, d x + K y = q: (K^2 + d^2) x = K p + d q
    square = K * K + d * d * one
    require(bool(square.det() != 0), "the frequency is that of a pole")
    x, y = square.solve(K * p + d * q), square.solve(K * q - d * p)
    return [v for state, side in ((x, straight[0]), (y, straight[1])) for v in (C * state + side).entries()]
