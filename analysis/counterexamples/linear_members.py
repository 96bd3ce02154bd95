r"""Linear members of the classes of several channels with a large gain, in floating point.

After the shift by the lower bounds a member is ``mu = w - Delta sigma``: ``Delta_i`` a constant gain in ``[0, w_i]``,
or on the channels of an operator a matrix of norm ``r_b`` at each frequency.  From ``w`` to ``sigma`` on some of the
channels the response is the block of ``S = (1 + H Delta)^{-1} H``.  At a frequency an operator that enlarges ``|p^* S
q|`` fastest has rank one: ``-r l^* s^*/(|l| |s|)``, ``l = p^* S``, ``s = S q`` on its channels; what is there is
changed to the mean of both, over and over again.  Such a matrix is the value of ``u v'`` with all-passes ``u_i``,
``v_j`` in place of the phases.  A scalar operator is ``delta`` times the identity, ``delta = -r (l s)^*/|l s|``; where
it closes the loop itself the largest eigenvalue of the block of ``S`` takes the place of the singular value, its left
and right vectors those of ``p`` and ``q``.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channels import ChannelInequality
from lure.arrays import Complexes, NDArray, Reals, np, optimize
from lure.record import described, quantity

_EDGE = 1e-12
_VERTICES, _DRAWN, _REFINED, _GRID, _TURNS, _ZOOMS, _SEED, _CLIMBED = 6, 24, 3, 9, 20, 7, 20261122, 3
_POWERS, _SPINS = 16, 4
_BITS, _NEAR, _FLAT = 40, 1e-9, 1e-5


class Found(NamedTuple):
    """A member, the frequency of its largest gain (infinite: the limit), the input, and that gain."""

    gain: float
    shape: Reals  # of the functions, the share of their widths
    gains: Reals
    operators: list[
        tuple[Complexes, Complexes]
    ]  # of each: r u and v, Delta = r u v'; of a scalar one r delta, and none
    omega: float
    direction: Complexes


@described()
class MemberSearch:
    """The search for one plant.

    Raises
    ------
    AssumptionError
        The loop with the gains ``lower`` is not well posed, or not asymptotically stable.
    """

    A: Reals = quantity("(n, n) [floating point]")
    B: Reals = quantity("(n, m) [floating point]")
    C: Reals = quantity("(m, n) [floating point]")
    D: Reals = quantity("(m, m) [floating point]")
    lower: Reals = quantity("(m,) the shift")
    functions: Sequence[Sequence[int]] = quantity("The channels with one gain each")
    operators: Sequence[Sequence[int]] = quantity("The channels of each operator")
    out: Sequence[int] = quantity(
        "The channels from whose ``w`` to whose ``sigma`` the gain is asked for, in none of these"
    )
    discrete: bool = quantity("Whether in discrete time")
    scalar: Sequence[Sequence[int]] = quantity(
        "Of these blocks, or ``out``, those with one scalar operator in each channel", default=()
    )

    def __post_init__(self) -> None:
        m = len(self.D)
        given = (self.A, self.B, self.C, self.D, self.lower)
        self.loop = ChannelInequality(*given, [False] * m, popov=False, discrete=self.discrete)
        self.H, self.omega = self.loop.H, self.loop.omega

    def _stable(self, gains: Reals) -> bool:
        """Whether the loop of these gains alone is stable."""
        G, loop = np.diag(gains), self.loop
        whole = np.eye(len(G)) + loop.D @ G
        if abs(np.linalg.det(whole)) < 1e-12:
            return False
        poles = np.linalg.eigvals(loop.A - loop.B @ G @ np.linalg.solve(whole, loop.C))
        edge = np.abs(poles).max() - 1 if self.discrete else poles.real.max()
        return bool(edge < -_EDGE * (1 + np.abs(poles).max()))  # nearer to the axis a response may not exist

    def _response(self, H: Complexes, Delta: Complexes) -> tuple[Complexes, Reals, Complexes, Complexes]:
        """``S``, and the largest singular value of its block with its vectors, at each frequency.

        Where one scalar operator closes the loop: the largest modulus of an eigenvalue, ``p^* S q`` for its vectors.
        """
        S = np.linalg.solve(np.eye(len(self.D)) + H @ Delta, H)
        own = S[:, self.out][:, :, self.out]
        if self.out in self.scalar:
            values, right = np.linalg.eig(own)
            at = np.abs(values).argmax(axis=1)
            each = np.arange(len(own))
            q, value = right[each, :, at], values[each, at]
            left = np.linalg.pinv(right)[each, at]  # left q = 1
            turn = (value / np.maximum(np.abs(value), 1e-300)).conj()
            return np.asarray(S), np.abs(value), np.asarray((left * turn[:, None]).conj()), np.asarray(q)
        p, sizes, q = np.linalg.svd(own)
        return np.asarray(S), np.asarray(sizes[:, 0]), np.asarray(p[:, :, 0]), np.asarray(q[:, 0].conj())

    def gains_at(self, H: Complexes, gains: Reals, radii: Reals) -> tuple[Reals, Complexes]:
        """The largest gain found at each frequency, and ``Delta``: (frequencies,) and (frequencies, m, m).

        Parameters
        ----------
        H : ndarray
            (frequencies, m, m).
        gains : ndarray
            (m,) above the lower bounds.
        radii : ndarray
            Of the operators.
        """
        Delta = np.zeros(H.shape, dtype=complex) + np.diag(gains)
        S, best, p, q = self._response(H, Delta)
        kept, value = Delta.copy(), best.copy()
        for _ in range(_TURNS if len(self.operators) else 0):
            for block, radius in zip(self.operators, radii, strict=True):
                left = np.einsum("fi,fij->fj", p.conj(), S[:, self.out][:, :, [*block]])
                right = np.einsum("fij,fj->fi", S[:, [*block]][:, :, self.out], q)
                if block in self.scalar:
                    delta = -(left * right).sum(axis=1).conj()[:, None, None]
                    size, turned = np.abs(delta)[:, 0, 0], delta * np.eye(len(block))
                else:
                    size = np.linalg.norm(left, axis=1) * np.linalg.norm(right, axis=1)
                    turned = -left.conj()[:, :, None] * right.conj()[:, None, :]
                where = np.ix_(range(len(H)), block, block)
                mean = (
                    Delta[where] + radius * turned / np.maximum(size, 1e-300)[:, None, None]
                )  # else it may turn round
                u, _, v = np.linalg.svd(mean)
                Delta[where] = radius * (u @ v if block in self.scalar else u[:, :, :1] @ v[:, :1])
            S, best, p, q = self._response(H, Delta)
            better = best > value
            kept[better], value = Delta[better], np.maximum(best, value)
        return value, kept

    def found(self, widths: Reals, shape: Reals | None = None) -> Found | None:
        """The member of the largest gain that is found; None if the loops of all gains tried are unstable.

        ``widths``: (m,) upper bounds less lower ones, of operators the bound of the norm; ``shape``: gains over widths,
        one for each of the functions, of which alone the gain is asked for.
        """
        radii = np.array([widths[block[0]] for block in self.operators])

        def peak(shape: Reals) -> float:
            """The largest gain over the frequencies of the grid; 0 for an unstable loop."""
            checkpoint()
            gains = self._spread(shape) * widths
            return float(self.gains_at(self.H, gains, radii)[0].max()) if self._stable(gains) else 0.0

        count = len(self.functions)
        if shape is not None:
            return self._sharpened(np.array(shape), widths, radii) if peak(shape) else None
        rng = np.random.default_rng(_SEED)
        corners = [np.array(v) for v in product((0.0, 1.0), repeat=count)] if count <= _VERTICES else []
        corners += [np.round(v) for v in rng.random((_DRAWN, count))] if count > _VERTICES else [np.full(count, 0.5)]
        ranked = sorted(((peak(shape), tuple(shape)) for shape in corners), reverse=True)
        best, at = 0.0, np.zeros(count)
        for value, start in ranked[:_REFINED]:
            shape, reached = np.array(start), value
            for step in (1.0, 0.1, 0.01) if count and value else ():
                for i in range(count):
                    for part in np.linspace(-1, 1, _GRID) * step:
                        tried = shape.copy()
                        tried[i] = min(max(shape[i] + part, 0.0), 1.0)
                        if tried[i] != shape[i] and (found := peak(tried)) > reached:
                            reached, shape = found, tried
            best, at = (reached, shape) if reached > best else (best, at)
        return self._climbed(at, widths, radii) if best else None

    def _climbed(self, shape: Reals, widths: Reals, radii: Reals) -> Found:
        """A member with a larger gain nearby, whose peak may lie between the frequencies of the grid."""
        best = self._sharpened(shape, widths, radii)
        for step in (0.1, 0.01) if 0 < len(shape) <= _CLIMBED and not self.operators else ():
            for i, part in product(range(len(shape)), np.linspace(-1, 1, _GRID) * step):
                checkpoint()
                tried = best.shape.copy()
                tried[i] = min(max(shape[i] + part, 0.0), 1.0)
                if self._stable(self._spread(tried) * widths):
                    found = self._sharpened(tried, widths, radii)
                    best = found if found.gain > best.gain else best
            shape = best.shape
        return best

    def closing(self, blocks: Sequence[Sequence[int]], radii: Reals) -> Found:
        """Operators on all channels with about the largest modulus of an eigenvalue of ``H Delta``, which is ``-gain``.

        With ``l^* H Delta r = lambda`` an operator of a block enlarges ``|lambda|`` fastest if it turns ``r`` onto
        ``l^* H``: the power iteration for the structured singular value (Packard, Fan and Doyle 1988).

        ``radii``: their norms.
        """
        rng, m, best = np.random.default_rng(_SEED), len(self.D), 0.0
        shape = (m, m)
        kept, at = np.zeros(shape, dtype=complex), 0.0

        def turned(H: Complexes, Delta: Complexes) -> tuple[Reals, Complexes]:
            """The moduli, and what enlarges them, real where H is; the last is that of the moduli, times a phase."""
            still = np.abs(H.imag).max(axis=(1, 2)) <= _EDGE * np.abs(H).max(axis=(1, 2))
            Delta = np.where(still[:, None, None], Delta.real, Delta)
            for last in (*[False] * _POWERS, True):
                values, right = np.linalg.eig(H @ Delta)
                k, each = np.abs(values).argmax(axis=1), np.arange(len(H))
                value, r = values[each, k], right[each, :, k]
                turn = value / np.maximum(np.abs(value), 1e-300)
                if last:
                    break
                a = np.einsum("fi,fij->fj", np.linalg.pinv(right)[each, k], H)
                Delta = np.zeros_like(Delta)
                for block, radius in zip(blocks, radii, strict=True):
                    where = np.ix_(range(len(H)), block, block)
                    if block in self.scalar:
                        one = (a[:, block] * r[:, block]).sum(axis=1).conj()[:, None, None] * np.eye(len(block))
                        size = np.abs(one[:, 0, 0])
                    else:
                        one = a[:, block].conj()[:, :, None] * r[:, block].conj()[:, None, :]
                        size = np.linalg.norm(a[:, block], axis=1) * np.linalg.norm(r[:, block], axis=1)
                    Delta[where] = radius * one * (turn / np.maximum(size, 1e-300))[:, None, None]
            return np.abs(value), -Delta * turn.conj()[:, None, None]

        for spin in range(_SPINS):
            checkpoint()
            first = np.zeros((len(self.H), *shape), dtype=complex)
            for block, radius in zip(blocks, radii, strict=True):
                where = np.ix_(range(len(first)), block, block)
                if not spin and block not in self.scalar:  # the worst of the block alone
                    u, _, v = np.linalg.svd(self.H[where])
                    first[where] = radius * (u[:, :, :1] @ v[:, :1]).conj().swapaxes(1, 2)
                    continue
                u, v = rng.normal(size=(2, len(block), 2)) @ np.array([1, 1j])
                first[where] = (
                    radius * u[0] / abs(u[0]) * np.eye(len(block))
                    if block in self.scalar
                    else radius * np.outer(u, v) / (np.linalg.norm(u) * np.linalg.norm(v))
                )
            omega, (size, Delta) = self.omega, turned(self.H, first)
            for _ in range(_ZOOMS):
                k = int(size.argmax())
                if size[k] > best:
                    best, kept, at = float(size[k]), Delta[k], float(omega[k])
                low, high = (float(omega[max(min(j, len(omega) - 1), 0)]) for j in (k - 1, k + 1))
                if not math.isfinite(high):
                    break
                omega = np.linspace(low, high, _GRID)
                H = self.loop.response(omega)[1]
                size, Delta = turned(H, np.repeat(Delta[None, k], _GRID, axis=0))
        operators: list[tuple[Complexes, Complexes]] = []
        for block in blocks:
            if block in self.scalar:
                operators.append((kept[block[0], [block[0]]], np.zeros(0, dtype=complex)))
                continue
            u, size, v = np.linalg.svd(kept[np.ix_(block, block)])
            operators.append((size[0] * u[:, 0], v[0]))
        return Found(best, np.zeros(0), np.zeros(m), operators, at, np.zeros(0, dtype=complex))

    def _spread(self, shape: Reals) -> Reals:
        found = np.zeros(len(self.D))
        for block, value in zip(self.functions, shape, strict=True):
            found[[*block]] = value
        return found

    def _sharpened(self, shape: Reals, widths: Reals, radii: Reals) -> Found:
        """The frequency of the largest gain, more exactly, and what is there."""
        gains = self._spread(shape) * widths
        values, _ = self.gains_at(self.H, gains, radii)
        i = int(values.argmax())
        low, omega, high = (float(self.omega[max(min(k, len(values) - 1), 0)]) for k in (i - 1, i, i + 1))
        best = float(values[i])
        for _ in range(_ZOOMS if math.isfinite(high) else 0):
            points = np.linspace(low, high, _GRID)
            inner = self.gains_at(self.loop.response(points)[1], gains, radii)[0]
            k = int(inner.argmax())
            if inner[k] > best:
                best, omega = float(inner[k]), float(points[k])
            low, high = float(points[max(k - 1, 0)]), float(points[min(k + 1, _GRID - 1)])
        for end in (0.0, np.pi) if self.discrete else (0.0,):  # where H is real, and the gain flat about it
            near = abs(omega - end) < _FLAT * (1.0 if self.discrete else self.loop.unit**-1)
            if near and self.gains_at(self.loop.response(np.array([end]))[1], gains, radii)[0][0] > best * (1 - _NEAR):
                omega = end
        H = self.loop.response(np.array([omega]))[1]
        value, Delta = self.gains_at(H, gains, radii)
        _, _, _, q = self._response(H, Delta)
        operators = []
        for block in self.operators:
            if block in self.scalar:
                operators.append((Delta[0][block[0], [block[0]]], np.zeros(0, dtype=complex)))
                continue
            u, size, v = np.linalg.svd(Delta[0][np.ix_(block, block)])
            operators.append((size[0] * u[:, 0], v[0]))
        return Found(float(value[0]), shape, gains, operators, omega, q[0])

    def exact_gains(self, found: Found, lower: Sequence[Fraction], upper: Sequence[Fraction]) -> list[Fraction]:
        """The gains of a member, at the ends of the classes exactly; the lower ones for operators.

        ``lower``, ``upper``: bounds of the classes.
        """
        gains = list(lower)
        for block in self.functions:
            low, high = lower[block[0]], upper[block[0]]
            share = found.gains[block[0]] / float(high - low)
            inside = min(max(low + Fraction(f"{share:.9g}") * (high - low), low), high)
            for i in block:
                gains[i] = low if share < _NEAR else high if share > 1 - _NEAR else inside
        return gains

    def realised(self, found: Found, radii: Sequence[Fraction]) -> Iterator[dict[str, Any]]:
        """The operators of a certificate, of norms up to the radii.

        ``found``: the member; ``radii``: largest norms.
        """
        for (left, right), radius in zip(found.operators, radii, strict=True):
            if not len(right):
                c, rate = allpass(complex(left[0] / (abs(left[0]) or 1.0)), found.omega, discrete=self.discrete)
                yield {"delta": [str(c * radius * (1 - Fraction(1, 2 ** (_BITS - 4)))), rate]}
                continue
            sides, turn = [], right[np.abs(right).argmax()]
            turn = turn / abs(turn) if turn else 1.0  # real where H is
            for values, size in (
                (left * turn, radius * (1 - Fraction(1, 2 ** (_BITS - 4)))),
                (right / turn, Fraction(1)),
            ):
                unit = values / (np.linalg.norm(values) or 1.0)
                passes = [allpass(complex(v), found.omega, discrete=self.discrete) for v in unit]
                sides.append([[str(c * size), rate] for c, rate in passes])
            yield {"left": sides[0], "right": sides[1]}


def allpass(value: complex, omega: float, *, discrete: bool) -> tuple[Fraction, str | None]:
    """``c`` and the rate of an all-pass that has about this value at a frequency; None for a constant.

    ``c (s - a)/(s + a)`` at ``s = i omega`` has the angle ``pi - 2 arctan(omega/a)``, ``c (1 - a z)/(z - a)`` at ``z =
    e^(i omega)`` the angle ``-omega - 2 psi``, ``tan psi = a sin(omega)/(1 - a cos(omega))``.

    ``omega``: the frequency [rad/s], in discrete time the angle.
    """
    size = Fraction(round(abs(value) * 2**_BITS), 2**_BITS)
    angle = cmath.phase(value) if value else 0.0
    real = (
        abs(math.sin(angle)) < _NEAR or not math.isfinite(omega) or abs(math.sin(omega) if discrete else omega) < 1e-12
    )
    if real:
        return (size if math.cos(angle) >= 0 else -size), None
    if discrete:
        turned = angle if angle < 0 else angle - math.pi  # in (-pi, 0)
        psi = -(turned + omega) / 2
        rate = math.sin(psi) / math.sin(omega + psi)
    else:
        turned = angle if angle > 0 else angle + math.pi  # in (0, pi)
        rate = omega / math.tan((math.pi - turned) / 2)
    return (size if turned == angle else -size), str(Fraction(f"{rate:.15g}"))


# Constant gains and constant delays with a large gain from w to z.

_LATE_GRID, _STEPS, _CORNERS, _LATE_REFINED, _BELOW, _ABOVE = 400, 9, 64, 3, 3e3, 30.0


def _solved(left: NDArray[Any], right: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """``left^-1 right`` for each matrix; 0 where floating point has no finite inverse."""
    singular = ~(np.abs(np.linalg.det(left)) > 0)
    found = np.linalg.solve(np.where(singular[:, None, None], np.eye(left.shape[-1]), left), right)
    finite = np.isfinite(found).all(axis=(1, 2)) & ~singular
    return np.asarray(np.where(finite[:, None, None], found, 0))


class Delayed(NamedTuple):
    """The gain, of which gains and delays (one a block), at which frequency [rad/s] and for which input."""

    gain: float
    gains: NDArray[np.float64]
    delays: NDArray[np.float64]
    omega: float
    direction: NDArray[np.complex128]


@described()
class DelayedMembers:
    """The search for one plant ``(A, B, C, D)`` in continuous time."""

    sides: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] = quantity(
        "``A``, ``B``, ``C`` and ``D``"
    )
    own: Sequence[int] = quantity("The channels from ``z`` to ``w``")
    functions: Sequence[Sequence[int]] = quantity("The channels of each gain")
    late: Sequence[Sequence[int]] = quantity("The channels of each delay")
    bounds: NDArray[np.float64] = quantity("(len(functions), 2), between which the gains lie")
    longest: NDArray[np.float64] = quantity("Bounds of the delays", "s")
    transfer: Callable[[Complexes], Complexes] | None = quantity(
        "The plant at complex ``s``, where it has dead times; None for that of the matrices", default=None
    )
    waits: Sequence[float] = quantity("Its dead times", "s", default=())

    def _response(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        if self.transfer is not None:
            return self.transfer(np.asarray(1j * omega, dtype=complex))
        A, B, C, D = self.sides
        states = _solved(1j * omega[:, None, None] * np.eye(len(A)) - A, B.astype(complex))
        return np.asarray(C @ states + D)

    def _through(
        self,
        gains: NDArray[np.float64],
        delays: NDArray[np.float64],
        omega: NDArray[np.float64],
        H: NDArray[np.complex128],
    ) -> NDArray[np.complex128]:
        """``T`` at the frequencies; 0 where the loop is singular in floating point, which shows no gain."""
        G = np.zeros((len(omega), H.shape[-1]), dtype=complex)
        for block, gain in zip(self.functions, gains, strict=True):
            G[:, [*block]] = gain
        for block, delay in zip(self.late, delays, strict=True):
            G[:, [*block]] = np.exp(-1j * omega * delay)[:, None]
        closed = np.eye(H.shape[-1]) + H * G[:, None, :]
        own = [*self.own]
        return _solved(closed, H[:, :, own])[:, own]

    def best(self) -> Delayed | None:
        """The largest gain found, between the ends of a grid of frequencies: from corners of the gains on."""
        size = np.abs(np.linalg.eigvals(self.sides[0]))
        rates = [*size[size > 0], *(1 / self.longest), *(1 / wait for wait in self.waits)]
        slow, fast = min(rates), max(rates)
        omega = np.geomspace(slow / _BELOW, fast * _ABOVE, _LATE_GRID)
        H = self._response(omega)
        found: list[tuple[float, NDArray[np.float64]]] = []
        corners = [np.array(v) for v in product(*self.bounds)][:_CORNERS]
        shares = np.linspace(0, 1, _STEPS)
        some = [np.full(len(self.late), s) for s in shares] + [np.eye(len(self.late))[k] for k in range(len(self.late))]
        for gains, share in product(corners, some):
            checkpoint()
            sizes = np.linalg.norm(self._through(gains, share * self.longest, omega, H), 2, axis=(1, 2))
            at = int(sizes.argmax())
            found.append((float(sizes[at]), np.concatenate([gains, share * self.longest, [math.log(omega[at])]])))
        found.sort(key=lambda one: -one[0])
        low = np.concatenate([self.bounds[:, 0], 0 * self.longest, np.log(omega[:1])])
        high = np.concatenate([self.bounds[:, 1], self.longest, np.log(omega[-1:])])
        best: Delayed | None = None

        def member(point: NDArray[np.float64]) -> Delayed:
            """The member at a point, with the least singular value of ``1 + H G``: 0 for a root on the axis."""
            checkpoint()
            point, count = np.clip(point, low, high), len(self.functions)
            where = np.exp(point[-1:])
            T = self._through(point[:count], point[count:-1], where, self._response(where))[0]
            _, sizes, right = np.linalg.svd(T)
            return Delayed(float(sizes[0]), point[:count], point[count:-1], float(where[0]), right[0].conj())

        for _, start in found[:_LATE_REFINED]:
            done = optimize.minimize(lambda point: -member(point).gain, start, method="Nelder-Mead")
            one = member(done.x)
            best = one if best is None or one.gain > best.gain else best
        return best
