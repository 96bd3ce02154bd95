"""The motion of the rod to 40 digits by other means than lure's: sums of powers times exponentials, event by event.

Every function of time is kept in closed form on its pieces, ``f(s) = sum c_{mu, j} s^j e^{mu s}`` with complex ``mu``
and ``s`` counted from the start of the piece.  This set is closed under what the motion needs: shifts, the integral of
free flight, and ``z' = w - lam z``.  Events are bracketed on a fine net of each piece and bisected.
"""

from dataclasses import dataclass
from fractions import Fraction

import mpmath
from mpmath import mp, mpc, mpf

DIGITS = 40
NET = [mpf(i) / 48 for i in range(1, 49)] + [mpf(10) ** -k for k in range(2, 26)]


def term(coefficient, power=0, rate=0):
    """``coefficient s^power e^(rate s)``."""
    return {mpc(rate): [mpc(0)] * power + [mpc(coefficient)]}


def sine(amplitude, omega, phase=0):
    """``amplitude sin(omega s + phase)``."""
    half = mpf(amplitude) / 2
    return total(
        term(-1j * half * mpmath.expj(phase), 0, 1j * mpf(omega)),
        term(1j * half * mpmath.expj(-mpf(phase)), 0, -1j * mpf(omega)),
    )


def total(*functions, weights=None):
    """Weighted sum."""
    result = {}
    for f, weight in zip(functions, weights or [1] * len(functions), strict=True):
        for mu, c in f.items():
            old = result.setdefault(mu, [])
            old += [mpc(0)] * (len(c) - len(old))
            for j, value in enumerate(c):
                old[j] += weight * value
    return result


def moved(f, scale, shift):
    """``f(scale s + shift)``."""
    result = {}
    for mu, c in f.items():
        new = [mpc(0)] * len(c)
        for j, value in enumerate(c):
            for i in range(j + 1):
                new[i] += value * mpmath.binomial(j, i) * mpf(scale) ** i * mpf(shift) ** (j - i)
        gain = mpmath.exp(mu * shift)
        result = total(result, {mu * scale: [gain * value for value in new]})
    return result


def value(f, s):
    """A real value."""
    return mpmath.fsum(mpmath.exp(mu * s) * mpmath.polyval(c[::-1], s) for mu, c in f.items()).real


def derivative(f):
    """The derivative."""
    result = {}
    for mu, c in f.items():
        result[mu] = [mu * c[j] + ((j + 1) * c[j + 1] if j + 1 < len(c) else 0) for j in range(len(c))]
    return result


def relaxed(w, lam, start):
    """``z' = w - lam z``, ``z(0) = start``; ``lam = 0`` is the integral."""
    result = {}
    for mu, c in w.items():
        if mu == -lam:
            result = total(result, {mu: [mpc(0)] + [value / (j + 1) for j, value in enumerate(c)]})
            continue
        part = [mpc(0)] * len(c)
        for j in range(len(c) - 1, -1, -1):  # (mu + lam) b_j + (j+1) b_{j+1} = c_j
            part[j] = (c[j] - ((j + 1) * part[j + 1] if j + 1 < len(c) else 0)) / (mu + lam)
        result = total(result, {mu: part})
    return total(result, term(mpf(start) - value(result, mpf(0)), 0, -lam))


@dataclass
class Reference:
    """``z``, ``push = d p`` and ``V`` on pieces ``(start, stop, z, push, V)`` [s], and the events."""

    pieces: list
    events: list
    mobility: object
    area: object

    def __call__(self, t, which=2):
        """``z`` (2), push (3) or ``V`` (4) at an instant, as mpf."""
        t = mpf(t)
        for piece in self.pieces:
            if piece[0] <= t <= piece[1]:
                return value(piece[which], t - piece[0])
        raise ValueError(t)

    def impulse(self):
        """``A int p dt`` over all of the motion."""
        whole = mpf(0)
        for low, high, _, push, _ in self.pieces:
            if push:
                primitive = relaxed(push, mpc(0), 0)
                whole += value(primitive, high - low)
        return self.area / self.mobility * whole


def reference(rod, until, *, forward, backward, force=(), boundary):
    """The motion of a rod with ``m = 1`` or a rigid obstacle.

    ``forward`` and ``backward`` are the initial ``r1`` and ``r2`` as ``[(x_low, x_high, f)]`` in x itself, ``force`` is
    ``[(t_low, t_high, f)]`` in t itself (the last to beyond ``until``), and ``z(0)`` is ``boundary["z"]``.
    """
    mp.dps = DIGITS
    E, rho, L, A, k, eps = (
        _mp(rod.exact[name]) for name in ("youngs_modulus", "density", "length", "area", "damping", "compliance")
    )
    c, Z, d = mpmath.sqrt(E / rho), A * mpmath.sqrt(rho * E), 1 / mpmath.sqrt(rho * E)
    T = L / c
    share = 1 / (1 + mpf(boundary.get("end_damping", 0)) / Z)
    a, b = (mpf(1), mpf(0)) if boundary.get("clamped") else ((k - Z) / (k + Z), 1 / (k + Z))
    until = mpf(until)
    # incoming wave: initial data and force as (start, stop, f of t itself)
    incoming = [((L - hi) / c, (L - lo) / c, moved(f, -c, L)) for lo, hi, f in forward]
    echoes = [(T + lo / c, T + hi / c, total(moved(f, c, -L), weights=[-a])) for lo, hi, f in backward]
    incoming += echoes
    incoming += [(lo + T, hi + T, total(moved(f, 1, -T), weights=[2 * b])) for lo, hi, f in force]
    result = Reference([], [], d * share, A)
    t, z = mpf(0), _mp(Fraction(boundary["z"]))
    touching = z > 0
    returned = []  # (start, stop, V with s from start), already shifted by 2T and echoed
    while t < until:
        edges = {until}
        for lo, hi, *_ in (*incoming, *returned):
            edges |= {lo, hi}
        stop = min(edge for edge in edges if edge > t * (1 + mpf(10) ** -30) + T * mpf(10) ** -30)
        middle = (t + stop) / 2
        wave = total(*[moved(f, 1, t) for lo, hi, f in incoming if lo <= middle < hi])
        wave = total(wave, *[moved(f, 1, t - lo) for lo, hi, f in returned if lo <= middle < hi])
        t, z, touching = _piece(result, (t, stop, wave), (z, touching), (share, d / eps, boundary.get("rigid"), T))
        lo, hi, _, _, V = result.pieces[-1]
        returned.append((lo + 2 * T, hi + 2 * T, total(V, weights=[-a])))
    return result


def _mp(fraction):
    return mpf(fraction.numerator) / fraction.denominator


def _piece(result, span, state, nonlinearity):
    t, stop, wave = span
    z, touching = state
    share, stiffness, rigid, T = nonlinearity
    lam, w = (0 if not touching else stiffness * share), total(wave, weights=[share])
    if touching and rigid:
        place, push = term(0), w
        watched = total(w, weights=[-1])
    else:
        place = relaxed(w, mpc(lam), z)
        push = total(place, weights=[lam]) if touching else {}
        watched = total(place, weights=[-1 if touching else 1])
    end = _crossing(watched, stop - t, T)
    reached = stop if end is None else t + end
    V = total(w, push, wave, weights=[2, -2, -1])
    result.pieces.append((t, reached, place, push, V))
    if end is None:
        return reached, value(place, stop - t), touching
    result.events.append((reached, not touching))
    return reached, mpf(0), not touching


def _crossing(f, width, T):
    """First place at which ``f`` passes from at most zero to above it."""
    tiny = mpf(10) ** (8 - DIGITS) * max(abs(value(f, width * s)) for s in NET)
    below = mpf(0)
    for share in sorted(NET):
        s = width * share
        if value(f, s) > tiny:
            low, high = below, s
            for _ in range(130):
                middle = (low + high) / 2
                low, high = (low, middle) if value(f, middle) > 0 else (middle, high)
            return high
        below = s
    return None
