"""Popov's inequality and the linear gains of a plant with dead time, decided in balls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from flint import acb, arb, arb_series, fmpq_poly

from lure.analysis.certificates.arithmetic import Form, Rejected, S, homogeneous, real
from lure.analysis.certificates.balls import right_zeros
from lure.analysis.inequality.protocol import Best, Grounds
from lure.analysis.numerics.doubles import double_above, double_below, text_above
from lure.analysis.numerics.minimum import Minimum, at, minimum, sinc
from lure.analysis.numerics.polynomial import X, even_odd, from_descending, root_counts, root_sizes
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Bracket
from lure.arrays import np
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant
from lure.record import described, quantity

# ``Re H`` and ``-w Im H`` of a block with dead time, on balls and power series, with a bound for high frequencies.
#
# With ``n_j conj(d) = a_j + i w b_j`` on the axis, ``c_j = cos w T_j`` and ``s_j = sin w T_j``,
#
# .. math:: \mathrm{Re} H = \sum_j (a_j c_j + \omega b_j s_j)/|d|^2, \qquad
#           -\omega \mathrm{Im} H = \sum_j (\omega a_j s_j - \omega^2 b_j c_j)/|d|^2 .
#
# For a simple pole at 0, ``d = s d_1``, both are finite at 0: with ``a_j``, ``b_j`` those of ``d_1``,
#
# .. math:: \mathrm{Re} H = \sum_j (b_j c_j - a_j s_j/\omega)/|d_1|^2, \qquad
#           -\omega \mathrm{Im} H = \sum_j (a_j c_j + \omega b_j s_j)/|d_1|^2 .
#
# With dead time below ``H = N/chi`` is computed as it stands, and for ``chi = s chi_1`` as ``N/chi_1/(i w)``.

Number = TypeVar("Number", arb, arb_series)
Parts = Sequence[tuple[Fraction, fmpq_poly]]  # dead times and polynomials


@dataclass(frozen=True, slots=True)
class _Term:
    delay: Fraction
    a: fmpq_poly
    b: fmpq_poly
    top: fmpq_poly


@described(frozen=True, slots=True)
class DelayResponse:
    """The response on the axis of a strictly proper block that is stable or has one simple pole at 0 besides."""

    terms: tuple[_Term, ...] = quantity("One for each delay")
    size: fmpq_poly = quantity("``|d|^2`` (or ``|d_1|^2``) in ``x = w^2``, positive for ``x >= 0``")
    bottom: fmpq_poly = quantity("``d``")
    critical: bool = quantity("Whether ``d`` has the root 0, or ``chi``")
    back: Parts = quantity("What is added to ``d`` with dead time, in ``chi``", default=())

    @classmethod
    def of(cls, block: DelayPlant) -> DelayResponse:
        """The response of a block.

        Raises
        ------
        AssumptionError
            A pole is unstable or a multiple or other root on the axis, or a term with dead time is not strictly proper.
        """
        bottom, back = from_descending(block.denominator), [(T, from_descending(q)) for T, q in block.feedback]
        if not block.strictly_proper:
            raise AssumptionError(
                f"the block {block} is a neutral equation, one of its terms with dead time having the degree of the "
                "denominator; there classes with two finite bounds are covered, by the circle criterion and Popov's; "
                "give such a class",
                code=Reason.DEAD_TIME,
            )
        if back:
            return cls._with_back(block, bottom, tuple(back))
        counts = root_counts(bottom)
        critical = counts.axis == 1 and bottom[0] == 0
        if counts.right or (counts.axis and not critical):
            raise AssumptionError(
                f"the block {block} has poles that are not stable ({counts.right} to the right of the axis, "
                f"{counts.axis} on it); with dead time only stable blocks, "
                "or a simple pole at 0 besides, are covered: stabilise it by a loop around it first",
                code=Reason.DEAD_TIME,
            )
        reduced = bottom // X if critical else bottom
        de, do = even_odd(reduced)
        terms = []
        for delay, top in block.terms:
            n = from_descending(top)
            ne, no = even_odd(n)
            terms.append(_Term(delay, ne * de + X * no * do, no * de - ne * do, n))
        return cls(tuple(terms), de * de + X * do * do, bottom, critical)

    @classmethod
    def _with_back(cls, block: DelayPlant, bottom: fmpq_poly, back: Parts) -> DelayResponse:
        """The response of a block with dead time in its denominator, whose zeros are counted in balls."""
        critical = sum((q[0] for _, q in back), bottom[0]) == 0
        turned = Form()
        for delay, p in ((Fraction(0), block.denominator), *block.feedback):
            wait = Form({(delay, 0): (Fraction(1), Fraction(0))})
            turned = turned + homogeneous([*p], S, real(1), bottom.degree()) * wait
        try:
            zeros, _ = right_zeros(turned, bottom.degree(), critical)
        except Rejected as refused:
            raise AssumptionError(f"the poles of the block {block}: {refused}", code=Reason.PRECISION) from None
        if zeros:
            raise AssumptionError(
                f"the block {block} has {zeros} poles to the right of the axis; with dead time only stable blocks, or "
                "a simple pole at 0 besides, are covered: stabilise it by a loop around it first",
                code=Reason.DEAD_TIME,
            )
        terms = [_Term(delay, bottom, bottom, from_descending(top)) for delay, top in block.terms]
        return cls(tuple(terms), bottom, bottom, critical, back)

    @property
    def _sides(self) -> tuple[Parts, Parts]:
        """``N`` and ``chi``."""
        return tuple((term.delay, term.top) for term in self.terms), ((Fraction(0), self.bottom), *self.back)

    @property
    def residue(self) -> arb:
        """Residue at the pole 0."""
        if self.back:
            N, chi = self._sides
            return sum((arb(p[0]) for _, p in N), arb(0)) / _over_s(chi, arb(0))[0]
        return sum((arb(term.a[0]) for term in self.terms), arb(0)) / arb(self.size[0])

    def parts(self, omega: Number) -> tuple[Number, Number]:
        """``Re H`` and ``-w Im H`` at ``omega >= 0``."""
        if self.back:
            return self._with_dead_time_below(omega)
        x = omega * omega
        real: Number = 0 * omega
        slope: Number = 0 * omega
        for term in self.terms:
            a, b = at(term.a, x), at(term.b, x)
            angle = omega * ball(term.delay)
            c, s = angle.cos(), angle.sin()
            if self.critical:
                real += b * c - (a * ball(term.delay) * sinc(angle) if term.delay else 0 * a)
                slope += a * c + omega * b * s
            else:
                real += a * c + omega * b * s
                slope += omega * a * s - x * b * c
        size = at(self.size, x)
        return real / size, slope / size

    def _with_dead_time_below(self, omega: Number) -> tuple[Number, Number]:
        N, chi = self._sides
        (a, b), (c, d) = _on_axis(N, omega), _over_s(chi, omega) if self.critical else _on_axis(chi, omega)
        size = c * c + d * d
        across, along = (b * c - a * d) / size, (a * c + b * d) / size
        if not self.critical:
            return along, -omega * across
        if not (isinstance(omega, arb) and omega.contains(0)):
            return across / omega, along
        n0, c0 = _on_axis(N, arb(0))[0], _over_s(chi, arb(0))[0]
        (p, q), (u, v) = _over_s(N, omega), _twice_over_s(chi, omega)  # N = n_0 + s N_1, chi_1 = c_0 + s chi_2
        return (c0 * p - n0 * u + omega * (q * u - p * v)) / size, along

    def _below(self, degree: int, v: arb) -> acb:
        """``chi/s^n`` from ``1/v`` on, whatever phases the dead times give."""
        any_phase = acb(arb(0, 1), arb(0, 1))
        own = _reversed_at(self.bottom, degree, v)
        return own + sum((_reversed_at(q, degree, v) * any_phase for _, q in self.back), acb(0))

    def tail(self, start: arb, theta: arb) -> arb:
        """A lower bound on ``Re[(1 + i w theta) H]`` for all ``w >= start``."""
        v = arb(0).union(1 / start)
        total = arb(0)
        degree = self.bottom.degree()
        below = self._below(degree, v)
        for term in self.terms:
            value = _reversed_at(term.top, degree, v) / below
            slope = _reversed_at(term.top * X, degree, v) / below  # s n/d is proper: H is strictly so
            both = value + acb(theta) * slope
            total += both.real if term.delay == 0 else -both.abs_upper()
        return total.lower() if total.is_finite() else arb("-inf")  # the denominator may vanish on so wide a ball

    def magnitude(self, start: arb) -> arb:
        """An upper bound on ``|H|`` for all ``w >= start``."""
        v = arb(0).union(1 / start)
        degree = self.bottom.degree()
        below = self._below(degree, v)
        return sum(((_reversed_at(term.top, degree, v) / below).abs_upper() for term in self.terms), arb(0)).upper()


def _on_axis(parts: Parts, omega: Number) -> tuple[Number, Number]:
    """Real and imaginary part of ``sum p e^(-s T)``."""
    x = omega * omega
    real_part: Number = 0 * omega
    imaginary: Number = 0 * omega
    for delay, p in parts:
        even, odd = even_odd(p)
        e, o, angle = at(even, x), omega * at(odd, x), omega * ball(delay)
        c, s = angle.cos(), angle.sin()
        real_part += e * c + o * s
        imaginary += o * c - e * s
    return real_part, imaginary


def _over_s(parts: Parts, omega: Number) -> tuple[Number, Number]:
    """The same of ``(F - F(0))/s``: ``(e^(-i x) - 1)/(i w) = -T (sinc x - i sin(x/2) sinc(x/2))``, ``x = w T``."""
    real_part, imaginary = _on_axis([(delay, p // X) for delay, p in parts], omega)
    for delay, p in parts:
        if delay and p[0] != 0:
            angle, weight = omega * ball(delay), arb(p[0]) * ball(delay)
            real_part -= sinc(angle) * weight
            imaginary += (angle / 2).sin() * sinc(angle / 2) * weight
    return real_part, imaginary


def _twice_over_s(parts: Parts, omega: arb) -> tuple[arb, arb]:
    """The same of ``(F - F(0) - s F'(0))/s^2``: ``(e^(-s T) - 1 + s T)/s^2`` is ``T^2/2``, off by ``w T^3/6``."""
    real_part, imaginary = _over_s([(delay, p // X) for delay, p in parts], omega)
    for delay, p in parts:
        T, most = ball(delay), (omega * ball(delay) ** 3 / 6).abs_upper()
        real_part += arb(p[0]) * (T * T / 2 + arb(0, most))
        imaginary += arb(p[0]) * arb(0, most)
    return real_part, imaginary


def _reversed_at(p: fmpq_poly, degree: int, v: arb) -> acb:
    """``p(s)/s^degree`` at ``s = i/v``: ``1/s = -i v``."""
    turn, total = acb(0, -1) * v, acb(0)
    for power in range(degree + 1):
        total = total * turn + (acb(arb(p[power])) if power <= p.degree() else acb(0))
    return total


# The infimum of the Popov expression of a block with dead time: branch and bound, and a tail.

RELATIVE_WIDTH = "1e-9"
MAX_QUADRUPLINGS = 8


def popov_infimum(response: DelayResponse, theta: arb, start: float) -> Minimum:
    """Bracket on ``inf Re[(1 + i w theta) H]`` over ``w >= 0``, where it is finite.

    ``theta``: multiplier [s].  ``start``: a frequency beyond all features [rad/s]; doubled until the tail lies above
    the minimum found before it.
    """

    def value(omega: Number) -> Number:
        """The Popov expression at one frequency."""
        real, slope = response.parts(omega)
        return real + theta * slope

    quadruplings, before = 0, arb("-inf")
    while True:
        found = minimum(value, arb(0), arb(start), width=lambda best: abs(best) * arb(RELATIVE_WIDTH) + arb("1e-11"))
        tail = response.tail(arb(start), theta)
        near = found.high >= 0 and tail > -abs(found.high) * arb("1e-3") - arb("5e-7")
        stuck = before.is_finite() and not tail > before + abs(before) * arb("1e-2")  # it tends to less
        if tail >= found.high or near or stuck or quadruplings == MAX_QUADRUPLINGS:
            break
        start, quadruplings, before = 4 * start, quadruplings + 1, tail
    low = found.low if tail >= found.low else tail
    if not low.is_finite():
        low = arb("-inf")
    return Minimum(low=low, high=found.high, where=found.where, closed=found.closed and bool(low == found.low))


SLACK = "1e-10"
MAX_BOXES = 200_000
SAMPLES = 20_001
FARTHEST = 2**30


def gain_limit(block: DelayPlant, response: DelayResponse, start: float, slowest: float) -> Bracket:
    r"""Bracket on the supremum of ``k`` such that ``1 + kappa H`` has all roots in ``Re s < 0`` for ``0 < kappa <= k``.

    The equation is of retarded type: its roots in ``Re s >= 0`` stay bounded and move continuously with the gain, and
    for small gains there are none.  The first ones arrive on the axis, where ``Im H = 0`` and ``kappa = -1/Re H``.

    Parameters
    ----------
    block : DelayPlant
        The block, for a first guess in floating point.
    response : DelayResponse
        Its response.
    start : float
        A frequency beyond all features [rad/s].
    slowest : float
        The frequency of the slowest of them [rad/s].
    """
    best = _largest_crossing(block, response, start, slowest)
    limit = best * (1 + arb(SLACK))
    end = start
    while not response.magnitude(arb(end)) < (limit if best > 0 else arb("1e-6")):
        end *= 2
        if end > start * FARTHEST:
            return Bracket(0.0, math.inf)
    if end > start and (farther := _largest_crossing(block, response, end, slowest)) > best:
        best, limit = farther, farther * (1 + arb(SLACK))
    if not best > 0:
        limit = arb("1e-6")
    if not _none_beyond(response, limit, end):
        return Bracket(0.0, outward(1 / best, 1 / best).high if best > 0 else math.inf)
    return outward(1 / limit, 1 / best if best > 0 else arb("inf"))


def _largest_crossing(block: DelayPlant, response: DelayResponse, start: float, slowest: float) -> arb:
    """A lower bound, attained at a crossing, on ``-Re H`` over the crossings; 0 if none was found."""
    best = arb(0)
    if not response.critical:
        at_zero = -response.parts(arb(0))[0]
        best = at_zero.lower() if at_zero > 0 else best
    low = min(slowest * 1e-2, start * 1e-6)
    omega = np.concatenate([np.geomspace(low, start, SAMPLES), np.linspace(start / SAMPLES, start, SAMPLES)])
    omega.sort()
    values = block.transfer(1j * omega)
    turns = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    order = sorted(turns.tolist(), key=lambda i: float(values.real[i]))
    for i in order[:3]:
        left, right = arb(float(omega[i])), arb(float(omega[i + 1]))
        sign = response.parts(left)[1] > 0
        if not response.parts(left)[1] * response.parts(right)[1] < 0:
            continue
        for _ in range(60):
            middle = ((left + right) / 2).mid()
            slope = response.parts(middle)[1]
            if not (slope > 0 or slope < 0):
                break
            left, right = (middle, right) if (slope > 0) == sign else (left, middle)
        value = (-response.parts(left.union(right))[0]).lower()
        best = value if value > best else best
    return best


def _none_beyond(response: DelayResponse, limit: arb, end: float) -> bool:
    """Whether every crossing on ``(0, end]`` has ``-Re H <= limit``."""
    stack = [(arb(0), arb(end))]
    for _ in range(MAX_BOXES):
        if not stack:
            return True
        left, right = stack.pop()
        real, slope = response.parts(left.union(right))
        at_origin = left == 0 and not response.critical  # w Im H has a root at 0 that is a crossing only if H(0) < 0
        if -real <= limit or (slope > 0 or slope < 0):
            continue
        if at_origin and right < arb("1e-12"):
            return False
        middle = ((left + right) / 2).mid()
        stack += [(left, middle), (middle, right)]
    return False


# The plant, its linear gains, and the largest class.

BITS = 128
STEPS = 48


@dataclass(frozen=True, slots=True)
class Delayed:
    """A block with dead time, its response, a frequency beyond its features, and that of the slowest."""

    block: DelayPlant
    response: DelayResponse
    start: float
    slowest: float

    @classmethod
    def of(cls, block: DelayPlant, lower: Fraction = Fraction(0)) -> Delayed:
        """The plant of a block, for ``phi - lower sigma``.

        Raises
        ------
        AssumptionError
            The block is not covered (see :class:`DelayResponse`), or its residue at 0 is not positive.
        """
        block = block.closed(lower) if lower and block.strictly_proper else block
        with working_precision(BITS):
            response = DelayResponse.of(block)
            if response.critical and not sum(top[-1] for _, top in block.terms):
                raise AssumptionError(
                    f"the block {block} has a mode at s = 0 that cancels: no feedback moves it; leave it out if the "
                    "system does not have it",
                    code=Reason.HIDDEN_MODE,
                )
            if response.critical and not response.residue > 0:
                raise AssumptionError(
                    f"the block {block} has the residue {float(response.residue):.6g} at its pole 0: not positive, so "
                    "that small gains destabilise; turn the sign of the feedback",
                    code=Reason.RESIDUE,
                )
            features = [1 / float(delay) for delay, _ in (*block.terms, *block.feedback) if delay > 0]
            for p in (response.bottom, *(term.top for term in response.terms), *(q for _, q in response.back)):
                features += root_sizes(p)
            return cls(
                block, response, 8 * max([1e-3, *features]), min((size for size in features if size > 0), default=1.0)
            )

    def gains(self) -> Bracket:
        """Supremum of the ``k`` such that every linear gain in ``(0, k]`` is stable."""
        with working_precision(BITS):
            return gain_limit(self.block, self.response, self.start, self.slowest)


def raised(gains: Bracket, lower: Fraction) -> Bracket:
    """Gains above a lower one, rounded outwards; ``gains``: in ``phi - lower sigma``."""
    if not lower:
        return gains
    high = math.inf if gains.high == math.inf else double_above(Fraction(gains.high) + lower)
    low = math.inf if gains.low == math.inf else double_below(Fraction(gains.low) + lower)
    return Bracket(low, high)


@described(frozen=True, kw_only=True, slots=True)
class DelayInequality:
    """``1/k + Re[(1 + i omega theta) H(i omega)] > 0`` on ``[0, inf]``, by branch and bound in balls.

    With a pole at 0 ``theta >= 0``.

    The infimum over frequency is concave in ``theta``; its maximum is enclosed between two multipliers whose worst
    frequencies pull to opposite sides, and the two together bound what any multiplier can reach.
    """

    plant: Delayed = quantity("The plant")
    weighted: bool = quantity("Whether there is a ``theta``; else it is 0, as in the circle criterion")
    lower: Fraction = quantity(
        "The lower end of the classes; ``plant`` is that of ``phi - lower sigma``", default=Fraction(0)
    )

    @classmethod
    def of(cls, block: DelayPlant, lower: Fraction, *, weighted: bool) -> DelayInequality:
        """The inequality of a plant; without ``theta`` only of a stable one.

        Raises
        ------
        AssumptionError
            The plant is not covered.
        """
        plant = Delayed.of(block, lower)
        if plant.response.critical and not weighted:
            raise AssumptionError(
                f"the block {block} has a pole at 0, where the circle criterion for dead time is not used; ask popov, "
                "if phi does not depend on time, or begin the class above 0",
                code=Reason.DEAD_TIME,
            )
        return cls(plant=plant, weighted=weighted, lower=lower)

    @property
    def grounds(self) -> Grounds:
        """The poles are those of the denominator: dead time adds none."""
        return Grounds(
            lower=self.lower,
            critical=self.plant.response.critical,
            poles="poles: counted exactly; every term with dead time strictly proper: checked",
            means="branch and bound in ball arithmetic, and a bound on the tail",
        )

    def best(self, enough: Fraction | None = None) -> Best:
        """The best multiplier, and how far it goes; not beyond the stable linear gains."""
        plant = self.plant
        with working_precision(BITS):
            theta, ceiling = _best_theta(plant) if self.weighted else (Fraction(0), None)
            found = popov_infimum(plant.response, ball(theta), plant.start)
            end = outward(
                _upper_end(found.low, arb(0)), _upper_end(found.high if ceiling is None else ceiling, arb("inf"))
            )
        limit = plant.gains()
        low = max(0.0, min(math.nextafter(end.low, 0), math.nextafter(limit.low, 0)))
        return Best(
            multiplier={"theta": theta} if self.weighted else {},
            largest=raised(Bracket(low, max(low, min(end.high, limit.high))), self.lower),
            worst_frequency=float(found.where),
            formula=f"1 + {float(theta):.6g} s" if self.weighted else "1",
            limit=f"linear gains are stable only below {text_above(raised(limit, self.lower).high)}"
            if limit.high < end.high
            else "",
            search_limited=limit.low < end.low and limit.high == math.inf,
        )


def _best_theta(plant: Delayed) -> tuple[Fraction, arb]:
    """A nearly best ``theta``, and an upper bound on the infimum for every one; with a pole at 0 for those ``>= 0``."""

    def worst(theta: Fraction) -> tuple[arb, arb, arb]:
        """Lower bound of the infimum for one multiplier, and both parts where it is attained, the second turned."""
        found = popov_infimum(plant.response, ball(sign * theta), plant.start)
        along, slope = plant.response.parts(found.where)
        return found.low, along, sign * slope

    sign = 1
    low, left_real, left_slope = worst(Fraction(0))
    if left_slope < 0 and not plant.response.critical:
        sign, left_slope = -1, -left_slope
    if not left_slope > 0:
        return Fraction(0), left_real.upper() if left_slope <= 0 else arb("inf")
    right = Fraction(1) / Fraction(plant.start)
    right_low, right_real, right_slope = worst(right)
    for _ in range(40):
        if not right_slope > 0:
            break
        left_real, left_slope = right_real, right_slope
        right *= 4
        right_low, right_real, right_slope = worst(right)
    best = (low, Fraction(0)) if low > right_low else (right_low, right)
    left = Fraction(0)
    for _ in range(STEPS):
        middle = (left + right) / 2
        value, along, slope = worst(middle)
        if value > best[0]:
            best = (value, middle)
        if slope > 0:
            left, left_real, left_slope = middle, along, slope
        elif slope < 0:
            right, right_real, right_slope = middle, along, slope
        else:
            break
    if not (left_slope > 0 and right_slope < 0):
        return sign * best[1], arb("inf")
    ceiling = (left_real * -right_slope + right_real * left_slope) / (left_slope - right_slope)
    return sign * best[1], ceiling.upper()


def _upper_end(infimum: arb, unknown: arb) -> arb:
    if infimum >= 0:
        return arb("inf")
    return -1 / infimum if infimum < 0 else unknown
