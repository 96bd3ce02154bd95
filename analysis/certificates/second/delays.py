r"""Delays of several channels, checked again: the loop with operators in place of them, and roots on the axis.

``mu = -sigma(t - tau)``, ``0 <= tau <= h``, is ``-(sigma + w)``.  For a constant delay ``w`` is ``m(h s) sigma``
through an operator of norm up to 1, where ``|m(i x)|`` is at least ``2 sin(x/2)`` up to ``pi`` and 2 beyond.  For
others ``w`` is ``sigma'`` through one of norm up to ``h``.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import factorial

from flint import acb, acb_mat, arb, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channel_gains import positive_between, unstable
from lure.analysis.certificates.second.channels import Asked, acyclic, centred, closed_by, diagonal, joined, member
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import X, ball, even_odd, to_fmpq, working_precision
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    number,
    numbers,
    record,
    require,
)

_TOP, _BOTTOM = fmpq_poly([0, 10041, 4751, 1133]), fmpq_poly([10000, 8563, 3183, 561])  # m
_CROSSING_BITS, _MOST_SAMPLES = 256, 50


def without_delays(asked: Asked, *, constant: bool = True) -> Asked:
    """The loop with the gain 1 in place of delays, and operators that are bounded beside it.

    ``constant``: whether constant delays are taken out too.

    Raises
    ------
    NotShown
        The theorem on delays is not for this plant.
    """
    own = [i for i, one in enumerate(asked.nonlinearities) if one.operator in claims.DELAYS]
    require(not own or acyclic(asked), "D has a cycle of channels beside delays")
    asked = centred(asked)
    if not own:
        return asked
    fixed = [i for i in own if asked.nonlinearities[i].operator == "delay"]
    slow = [i for i in own if asked.nonlinearities[i].rate is not None]
    own = [i for i in own if constant or i not in (*fixed, *slow)]
    if asked.discrete:
        fixed = []
    if constant and fixed:
        _require_majorant()
    m = asked.D.nrows()
    unit, gain = diagonal([Fraction(1)] * m), diagonal([Fraction(int(i in own)) for i in range(m)])
    whole = unit + asked.D * gain
    require(bool(whole.det() != 0), "the loop without delay is not well posed")
    C, D = whole.inv() * asked.C, whole.inv() * asked.D
    A, B, classes = asked.A - asked.B * gain * C, asked.B * (unit - gain * D), list(asked.nonlinearities)
    for i in own:
        h, lasting = classes[i].upper, i in fixed
        if not isinstance(h, Fraction):
            raise NotShown("a delay has no bound")
        radius = Fraction(1) if lasting else h
        kind = claims.SCALAR if lasting else "any"
        classes[i] = replace(
            classes[i], operator=kind, lower=-radius, upper=radius, time_varying=not lasting, rate=None
        )
        pick = fmpq_mat([[int(j == i == k) for k in range(m)] for j in range(m)])
        if lasting:
            state, into, out, direct = _realised(h)
            row = fmpq_mat([[int(k == i) for k in range(m)]])
            n = A.nrows()
            A = joined(A, fmpq_mat(n, 3), state, lower_left=into * row * C)
            B = fmpq_mat([*B.tolist(), *(into * row * D).tolist()])
            seen = (unit - pick + direct * pick) * C
            side = row.transpose() * out
            C = fmpq_mat([[*a, *b] for a, b in zip(seen.tolist(), side.tolist(), strict=True)])
            D = (unit - pick + direct * pick) * D
        elif asked.discrete:  # sigma(t) - sigma(t - 1)
            row = fmpq_mat([[int(k == i) for k in range(m)]])
            n = A.nrows()
            A = joined(A, fmpq_mat(n, 1), fmpq_mat(1, 1), lower_left=row * C)
            B = fmpq_mat([*B.tolist(), *(row * D).tolist()])
            C = fmpq_mat([[*line, -int(k == i)] for k, line in enumerate(C.tolist())])
        else:
            require(all(asked.D[i, j] == 0 for j in range(m)), "sigma of a varying delay jumps with mu")
            C, D = (unit - pick) * C + pick * C * A, (unit - pick) * D + pick * C * B
    return replace(asked, A=A, B=B, C=C, D=D, nonlinearities=tuple(classes), delayed=True)


def _realised(h: Fraction) -> tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq]:
    """``m(h s)`` as states, the coefficients of its denominator in the last row."""
    last = _BOTTOM[3]
    rows = [[fmpq(0), fmpq(1), fmpq(0)], [fmpq(0), fmpq(0), fmpq(1)], [-_BOTTOM[k] / last for k in range(3)]]
    direct = _TOP[3] / last
    rest = _TOP - direct * _BOTTOM
    slow = 1 / to_fmpq(h)
    return fmpq_mat(rows) * slow, fmpq_mat([[0], [0], [slow]]), fmpq_mat([[rest[k] / last for k in range(3)]]), direct


def _require_majorant() -> None:
    """Check ``|m(i x)|^2`` against ``2 - 2 cos x``, whose Taylor polynomials lie above and below it in turn."""
    squares = []
    for p in (_TOP, _BOTTOM):
        even, odd = even_odd(p)
        squares.append(even * even + X * odd * odd)
    taylor = fmpq_poly([0, *(fmpq(-2 * (-1) ** k, factorial(2 * k)) for k in range(1, 12))])
    near, far = squares[0] - taylor * squares[1], squares[0] - 4 * squares[1]
    require(near[0] == 0, "the majorant is not 0 at 0")
    require(positive_between(near // X, Fraction(0), Fraction(10)), "the majorant fails up to pi")
    require(positive_between(far, Fraction(98, 10), None), "the majorant fails beyond pi")


def refuted_by_delay(document: Document, asked: Asked) -> str:
    """What a constant delay in one channel does, beside constant gains: a root on the imaginary axis.

    With ``h`` from ``mu_i`` to ``sigma_i`` and ``g = h exp(-i omega tau)`` the angle of ``-g`` is above 0 for the
    first delay and below for the second at all frequencies between the two, and so 0 for one between, continuous in the
    frequency; and ``|h|`` passes through 1.

    Raises
    ------
    NotShown
        No such root is shown.
    """
    if asked.discrete:
        return _refuted_in_samples(document, asked)
    proof = record(document.proof, "method", "gains", "channel", "delays", "frequencies")
    gains, i = member(proof["gains"], asked), count(proof["channel"], least=1) - 1
    require(i < len(gains) and asked.repeated.count(asked.repeated[i]) == 1, "there is no such channel")
    one = asked.nonlinearities[i]
    if one.operator not in claims.DELAYS or not isinstance(one.upper, Fraction):
        raise NotShown("the channel has no delay")
    delays, band = numbers(proof["delays"]), numbers(proof["frequencies"])
    require(
        len(delays) == len(band) == 2 and 0 <= delays[0] < delays[1] <= one.upper, "the delays are not in the class"
    )
    require(0 < band[0] < band[1], "the frequencies are not in order")
    rest = [g * (k != i) for k, g in enumerate(gains)]
    require(bool((diagonal([Fraction(1)] * len(gains)) + asked.D * diagonal(rest)).det() != 0), "there is no solution")
    loop = LateLoop.of(asked, rest)
    with working_precision(_CROSSING_BITS):

        def response(omega: arb) -> acb:
            """``h(i omega)``."""
            return loop.at(omega)[i, i]

        wide = ball(band[0]).union(ball(band[1]))
        before, after = (response(wide) * (acb(0, -wide) * ball(tau)).exp() for tau in delays)
        turned = before.real < 0 and before.imag < 0 and after.real < 0 and after.imag > 0
        sizes = [abs(response(ball(omega))) - 1 for omega in band]
        require(bool(turned and sizes[0] * sizes[1] < 0), "no delay of the class is shown to have a root on the axis")
    return claims.NO_REST


def refuted_by_delayed_members(document: Document, asked: Asked) -> str:
    """A gain above ``gamma`` at one frequency, with constant gains and constant delays: ``(1 + H G) sigma = H w``.

    Whether the loop is stable does not matter: with a gain of at most ``gamma`` its ``T`` would be so on the axis.

    Raises
    ------
    NotShown
        It is not shown.
    """
    proof = record(document.proof, "method", "gains", "delays", "omega", "input")
    gains, taus, omega = member(proof["gains"], asked), numbers(proof["delays"]), number(proof["omega"])
    own, m = asked.performance, len(asked.nonlinearities)
    late = [i for i, one in enumerate(asked.nonlinearities) if one.operator in claims.DELAYS]
    others = [one for i, one in enumerate(asked.nonlinearities) if i not in (*late, *own)]
    require(not asked.discrete and bool(own) and omega > 0, "a gain in continuous time and a frequency are needed")
    require(not any(one.operator or one.memory or one.relu for one in others), "there are other operators")
    require(acyclic(asked) and len(taus) == len(late), "D has a cycle, or there is not one delay a channel")
    of = dict(zip(late, taus, strict=True))
    for i, tau in of.items():
        most = asked.nonlinearities[i].upper
        require(isinstance(most, Fraction) and 0 <= tau <= most, "a delay is not in its class")
        require(tau == of[asked.repeated[i]], "one operator has two delays")
    w = [numbers(pair) for pair in listed(proof["input"])]
    require(len(w) == len(own) and all(len(pair) == 2 for pair in w), "the input does not fit")
    bound = asked.nonlinearities[own[0]].ends[1]
    if bound is None:
        raise NotShown("the gain has no bound")
    with working_precision(_CROSSING_BITS):
        s, H = acb(0, ball(omega)), LateLoop.of(asked, [Fraction(0)] * m).at(ball(omega))
        G = [(-s * ball(of[j])).exp() if j in of else acb(ball(gains[j])) for j in range(m)]
        entering = acb_mat(
            [
                [sum((H[i, j] * acb(ball(x), ball(y)) for j, (x, y) in zip(own, w, strict=True)), acb(0))]
                for i in range(m)
            ]
        )
        closed = acb_mat([[H[i, j] * G[j] + int(i == j) for j in range(m)] for i in range(m)])
        sigma = closed.solve(entering)
        through = sum((abs(sigma[i, 0]) ** 2 for i in own), arb(0))
        size = sum((ball(x) ** 2 + ball(y) ** 2 for x, y in w), arb(0))
        require(bool(through * ball(bound) ** 2 > size), "the gain is not shown to be above gamma")
    return claims.EXCEEDED


def _refuted_in_samples(document: Document, asked: Asked) -> str:
    """What a constant delay of some samples does in one channel: ``q_1+ = sigma``, ``q_(k+1)+ = q_k``."""
    proof = record(document.proof, "method", "gains", "channel", "samples")
    gains, i, k = member(proof["gains"], asked), count(proof["channel"], least=1) - 1, count(proof["samples"], least=1)
    require(i < len(gains) and asked.repeated.count(asked.repeated[i]) == 1, "there is no such channel")
    one = asked.nonlinearities[i]
    if one.operator not in claims.DELAYS or not isinstance(one.upper, Fraction):
        raise NotShown("the channel has no delay")
    require(k <= one.upper and k <= _MOST_SAMPLES, "the delay is not in the class")
    n, m = asked.A.nrows(), len(gains)
    row = fmpq_mat([[int(j == i) for j in range(m)]])
    shift = fmpq_mat([[int(g == h + 1) for h in range(k)] for g in range(k)])
    first = fmpq_mat([[int(g == 0)] for g in range(k)])
    late = fmpq_mat([[int(j == i and h == k - 1) for h in range(k)] for j in range(m)])
    keep = diagonal([Fraction(int(j != i)) for j in range(m)])
    own = keep * asked.C
    A = joined(asked.A, fmpq_mat(n, k), shift, lower_left=first * row * asked.C)
    B = fmpq_mat([*asked.B.tolist(), *(first * row * asked.D).tolist()])
    C = fmpq_mat([[*a, *b] for a, b in zip(own.tolist(), late.tolist(), strict=True)])
    closed = closed_by(replace(asked, A=A, B=B, C=C, D=keep * asked.D), gains)
    return claims.NO_SOLUTION if closed is None else unstable(closed, discrete=True)
