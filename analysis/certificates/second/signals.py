r"""What a disturbance gets through a loop from rest, checked again: samples exactly, steps of constant ``w`` in balls.

In continuous time, with ``phi_i = a_i sigma`` below 0 and ``b_i sigma`` above, the loop is linear as long as no
``sigma_i`` changes its side.  Where one is on the other side, by ``e`` at most, what enters the linear loop is ``|b_i -
a_i| e`` at most, and Gronwall's lemma bounds how far the solution is from the linear one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from flint import arb, arb_mat, ctx, fmpq, fmpq_mat

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channels import Asked
from lure.analysis.certificates.second.numerics import ball, to_fmpq, working_precision
from lure.analysis.certificates.second.reading import Document, count, listed, number, numbers, record, require, tick

LONGEST, ORDER, DEEPEST, MOST_BITS, LOST = 2000, 24, 12, 8192, 1e-6
Line = tuple[Fraction, Fraction]


def refuted_by_signal(document: Document, asked: Asked) -> str:
    """What comes through of a disturbance, from rest and with lines that have a kink at 0.

    Raises
    ------
    NotShown
        The lines are not of the class, or no more comes through than ``gamma`` says.
    """
    steady = () if asked.discrete else ("times", "sides", "scale", "bits")
    proof, own = record(document.proof, "method", "slopes", "inputs", *steady), asked.performance
    kinds = [i for i in range(len(asked.nonlinearities)) if i not in own]
    require(bool(own), "a performance channel is needed")
    require(
        not any(asked.nonlinearities[i].operator or asked.nonlinearities[i].memory for i in kinds),
        "a channel has no function of sigma",
    )
    ahead = [(i, j) for i in kinds for j in kinds if i <= j]
    require(all(asked.D[i, j] == 0 for i, j in ahead), "one function of sigma sees a later one, or itself, at once")
    samples = [numbers(row) for row in listed(proof["inputs"])]
    fits = 0 < len(samples) <= LONGEST and all(len(row) == len(own) for row in samples)
    require(fits, "the signal is no such")
    given = listed(proof["slopes"])
    require(len(given) == len(kinds), "there are not slopes for each function")
    lines = {i: _lines(one, i, asked, len(samples)) for i, one in zip(kinds, given, strict=True)}
    require(all(lines[i] == lines[asked.repeated[i]] for i in kinds), "one nonlinearity has one line")
    if asked.discrete:
        balance = _in_samples(asked, lines, samples)
        require(bool(balance > 0), "no more comes through than gamma says")
        return claims.EXCEEDED
    still = all(len(set(lines[i])) == 1 or asked.nonlinearities[i].time_varying for i in kinds)
    require(still, "a nonlinearity does not depend on time")
    times, bits = numbers(proof["times"]), count(proof["bits"], least=128)
    require(number(proof["scale"]) > 0 and bits <= MOST_BITS, "the scale or the bits are none")
    require(len(times) == len(samples) and min(times) > 0, "there is not a duration for each step")
    sides = [[count(k) for k in listed(at)] for at in listed(proof["sides"])]
    whole = len(sides) == len(samples) and all(len(at) == len(kinds) and max(at, default=0) < 2 for at in sides)
    require(whole, "there is not a side for each function in each step")
    with working_precision(bits):
        require(_Steps(asked, lines).balance(samples, times, sides) > 0, "no more comes through than gamma says")
    return claims.EXCEEDED


def _lines(value: object, i: int, asked: Asked, steps: int) -> list[Line]:
    """The slopes below and above 0 in each step."""
    rows = listed(value)
    each = bool(rows) and not isinstance(rows[0], str | int)
    found = list[Line]()
    for pair in map(numbers, rows) if each else [numbers(rows)]:
        require(len(pair) == 2, "there are not two slopes")
        found.append((pair[0], pair[1]))
    require(len(found) == (steps if each else 1), "there is not a pair of slopes for each step")
    one, (low, high) = asked.nonlinearities[i], asked.bounds[i]
    require(all(low <= slope <= high for line in found for slope in line), "a slope is outside its class")
    require(not (one.odd or one.linear) or all(a == b for a, b in found), "a line with a kink is not odd")
    require(not one.relu or all(line == (low, high) for line in found), "another ReLU is asked about")
    moves = len(set(found)) > 1
    require(not moves or not (one.linear or one.rate is not None), "the gain does not change, or not so fast")
    return found if each else found * steps


def _in_samples(asked: Asked, lines: dict[int, list[Line]], samples: Sequence[Sequence[Fraction]]) -> fmpq:
    """``sum |z|^2 - gamma^2 |w|^2``, in discrete time."""
    own, moving = asked.performance, [i for i, steps in lines.items() if len(set(steps)) > 1]
    for i in moving:
        one = asked.nonlinearities[i]
        require(one.time_varying or one.slope is None, "a slope is known, and the nonlinearity does not depend on time")
    x, balance = fmpq_mat(asked.A.nrows(), 1), fmpq(0)
    gain, graphs = 1 / to_fmpq(asked.bounds[own[0]][1]) ** 2, dict[tuple[int, fmpq], fmpq]()
    for t, row in enumerate(samples):
        tick()
        inputs = fmpq_mat(asked.D.nrows(), 1)
        for i, w in zip(own, row, strict=True):
            inputs[i, 0] = to_fmpq(w)
        for i, steps in lines.items():
            sigma = (asked.C * x + asked.D * inputs)[i, 0]
            inputs[i, 0] = -to_fmpq(steps[t][1 if sigma > 0 else 0]) * sigma
            if i in moving and not asked.nonlinearities[i].time_varying:
                for sign in (1, -1) if asked.nonlinearities[i].odd else (1,):
                    at = (asked.repeated[i], sign * sigma)
                    value = graphs.setdefault(at, sign * inputs[i, 0])
                    require(bool(value == sign * inputs[i, 0]), "phi would have two values at one sigma")
        z = asked.C * x + asked.D * inputs
        balance += sum((z[i, 0] ** 2 - gain * inputs[i, 0] ** 2 for i in own), fmpq(0))
        x = asked.A * x + asked.B * inputs
    return balance


class _Steps:
    """A loop of lines in continuous time, step after step, at the working precision."""

    def __init__(self, asked: Asked, lines: dict[int, list[Line]]) -> None:
        self.asked, self.lines, self.own = asked, lines, asked.performance
        self.known = dict[tuple[tuple[Fraction, ...], Fraction], tuple[arb_mat, arb_mat, arb_mat, arb_mat]]()
        n = asked.A.nrows()
        self.steep = {i: max(abs(ball(v)) for line in steps for v in line) for i, steps in lines.items()}
        self.reach = dict[int, arb]()  # |mu_i - mu_i(y)| over |x - y|, both in Euclid's length
        for i, most in self.steep.items():
            seen = _length([arb(asked.C[i, k]) for k in range(n)])
            self.reach[i] = most * (seen + self.weighed(asked.D, i, self.reach))
        self.columns = {i: _length([arb(asked.B[k, i]) for k in range(n)]) for i in lines}
        size = _length([arb(asked.A[k, h]) for k in range(n) for h in range(n)])
        self.growth = size + sum((self.columns[i] * v for i, v in self.reach.items()), arb(0))

    @staticmethod
    def weighed(side: fmpq_mat, i: int, parts: dict[int, arb]) -> arb:
        """``sum |D_ij| part_j``."""
        return sum((abs(arb(side[i, j])) * part for j, part in parts.items()), arb(0))

    def rows(self, gains: Sequence[Fraction]) -> tuple[arb_mat, arb_mat]:
        """``G`` of ``(x, w)`` with these gains, and the rows of every ``sigma`` and ``z`` from it."""
        asked, n, p = self.asked, self.asked.A.nrows(), len(self.own)
        held = fmpq_mat(asked.D.nrows(), n + p)  # mu from (x, w)
        for k, j in enumerate(self.own):
            held[j, n + k] = fmpq(1)
        C = fmpq_mat([[*(asked.C[i, k] for k in range(n)), *[fmpq(0)] * p] for i in range(asked.C.nrows())])
        A = fmpq_mat([[*(asked.A[i, k] for k in range(n)), *[fmpq(0)] * p] for i in range(n)])
        for i, g in zip(self.lines, gains, strict=True):
            seen = C + asked.D * held
            for k in range(n + p):
                held[i, k] = -to_fmpq(g) * seen[i, k]
        moved = (A + asked.B * held).tolist() + fmpq_mat(p, n + p).tolist()
        return arb_mat(moved), arb_mat((C + asked.D * held).tolist())

    def flow(self, gains: tuple[Fraction, ...], h: Fraction) -> tuple[arb_mat, arb_mat, arb_mat, arb_mat]:
        """``G h``, the rows of ``sigma`` and ``z``, ``W`` of ``int |z|^2 = X' W X`` over the step, and ``exp(G h)``.

        ``exp(h (-G', Q; 0, G))`` has ``exp(G h)`` and its transpose's inverse times ``W`` on the right (Van Loan 1978).
        """
        if (gains, h) not in self.known:
            G, rows = self.rows(gains)
            n, z = G.nrows(), arb_mat([[rows[j, k] for k in range(G.nrows())] for j in self.own])
            Q, turned = z.transpose() * z, -G.transpose()
            whole = arb_mat(
                [[*(turned[i, k] for k in range(n)), *(Q[i, k] for k in range(n))] for i in range(n)]
                + [[*[arb(0)] * n, *(G[i, k] for k in range(n))] for i in range(n)]
            )
            E = (whole * ball(h)).exp()
            right = [[E[n * part + i, n + k] for k in range(n)] for part in (0, 1) for i in range(n)]
            over, last = arb_mat(right[:n]), arb_mat(right[n:])
            self.known[gains, h] = G * ball(h), rows, last.transpose() * over, last
        return self.known[gains, h]

    def balance(
        self, samples: Sequence[Sequence[Fraction]], times: Sequence[Fraction], sides: Sequence[Sequence[int]]
    ) -> arb:
        """``int |z|^2 - gamma^2 |w|^2``, at least."""
        asked, total, n = self.asked, arb(0), self.asked.A.nrows()
        gain = 1 / ball(asked.bounds[self.own[0]][1]) ** 2
        x = [arb(0)] * n
        for t, (w, h, at) in enumerate(zip(samples, times, sides, strict=True)):
            tick()
            long, X = ball(h), arb_mat([[v] for v in [*x, *map(ball, w)]])
            pairs = {i: steps[t] for i, steps in self.lines.items()}
            step, rows, W, E = self.flow(tuple(pair[k] for pair, k in zip(pairs.values(), at, strict=True)), h)
            after = E * X
            slips = dict[int, arb]()
            for (i, (a, b)), k in zip(pairs.items(), at, strict=True):
                row = arb_mat([[rows[i, c] for c in range(len(w) + n)]])
                wrong = arb(0) if a == b else _wrong(row if k else -row, step, X, after)
                slips[i] = abs(ball(b - a)) * wrong + self.steep[i] * self.weighed(asked.D, i, slips)
            pushed = sum((self.columns[i] * v for i, v in slips.items()), arb(0))
            apart = (long * (self.growth * long).exp() * pushed).upper()
            require(bool(apart < LOST), "it is not known on which side sigma is")
            off = arb(0)
            for j in self.own:
                seen = _length([arb(asked.C[j, c]) for c in range(n)]) + self.weighed(asked.D, j, self.reach)
                off += (seen * apart + self.weighed(asked.D, j, slips)) ** 2
            through = (X.transpose() * W * X)[0, 0].nonnegative_part()
            slip = (off.nonnegative_part() * long).sqrt()  # of the norm of z over the step
            kept = (through.sqrt() - slip).lower()
            total += (kept * kept if kept > 0 else arb(0)) - gain * long * sum((ball(v) ** 2 for v in w), arb(0))
            x = [after[i, 0] + arb(0, 1) * apart for i in range(n)]
        return total


def _length(entries: Sequence[arb]) -> arb:
    return sum((v * v for v in entries), arb(0)).sqrt()


def _largest(values: Iterable[arb]) -> arb:
    found = arb(0)
    for value in values:
        found = found.max(value)
    return found.upper()


def _wrong(row: arb_mat, step: arb_mat, X: arb_mat, after: arb_mat, depth: int = 0) -> arb:
    """By how much ``row X`` is below 0 in a step, at most: by the series from either end, or those of both halves."""
    low = max(_lowest(row, step, X), _lowest(row, -step, after), key=lambda one: float(one.lower()))
    least = (-low).upper().nonnegative_part()
    ends = (-(row * X)[0, 0]).max(-(row * after)[0, 0]).lower()
    if depth == DEEPEST or bool(least < arb(2) ** (-(ctx.prec // 4))) or bool(least < 4 * ends):
        return least
    half = step / 2
    middle = half.exp() * X
    parts = [_wrong(row, half, X, middle, depth + 1), _wrong(row, half, middle, after, depth + 1)]
    return parts[0].max(parts[1])


def _lowest(row: arb_mat, step: arb_mat, X: arb_mat) -> arb:
    """What ``sum c_j q^j``, ``c_j = row step^j X/j!``, is on ``[0, 1]`` at least: all below 0 counted at ``q = 1``.

    Or up to one that is above 0, with those after it: ``q^k (c_k + ...)``.
    """
    c, size = list[arb](), _largest(sum((abs(v) for v in line), arb(0)) for line in step.tolist())
    for k in range(1, ORDER + 1):
        c.append((row * X)[0, 0])
        row = row * step / k
    rest = sum((abs(v) for v in row.tolist()[0]), arb(0)) * size.exp() * _largest(abs(v[0]) for v in X.tolist())
    below, found = [v.min(arb(0)) for v in c], list[arb]()
    for k in range(4):
        inner = c[k] + sum(below[k + 1 :], arb(0))
        found.append((sum(below[:k], arb(0)) + inner.min(arb(0)) - rest).lower())
    return max(found, key=float)
