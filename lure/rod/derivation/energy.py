"""Energy of the rod and of the scheme, the conserved mean, and the Popov-Lyapunov function along the scheme."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from lure.rod.derivation.rod import f, hamilton, strain_left, strain_right, u, velocity_left
from lure.rod.derivation.scheme import Scheme, as_scheme, z
from lure.rod.derivation.vocabulary import E, a, area, b, d, g, k, p, primitive, rho, s, t, theta, x


@dataclass(frozen=True, kw_only=True, slots=True)
class Balance:
    """``d/dt function = rate`` claimed along every solution, for any locally Lipschitz law ``p`` with ``P' = p``.

    Attributes
    ----------
    function : sympy.Expr
        The function of the state; ``P(z)`` is the primitive of the law.
    derivative : sympy.Expr
        Its derivative, by the chain rule along the matrices.
    rate : sympy.Expr
        What the derivative is claimed to be.
    """

    function: sp.Expr
    derivative: sp.Expr
    rate: sp.Expr

    @property
    def residual(self) -> sp.Expr:
        """``derivative - rate``, expanded or simplified; zero if the claim is true."""
        difference = sp.expand(self.derivative - self.rate)
        return difference if difference == 0 else sp.cancel(difference)


def energy_identity(system: int | Scheme) -> Balance:
    r"""Energy balance of the scheme, exact in time and for every ``N``.

    .. math::

        \frac{d}{dt}\Bigl[\frac{1}{2s}\sum_i y_i^2 + 2 d P(z)\Bigr]
        = -\tfrac12 \sum_{i=1}^{2N} (\mathrm{prev}_i - y_i)^2
        + \tfrac12 \bigl[(2 b g - a y_{2N})^2 - y_{2N}^2\bigr],

    with ``prev_1 = -a y_{2N} + 2 b g``, ``prev_{N+1} = y_N - 2 d p``, ``prev_i = y_{i-1}`` otherwise.  For ``g = 0``
    and ``|a| <= 1`` it never grows, whatever the law; that it bounds the waves needs ``P`` bounded below besides.
    The energy in joules is ``Z/2`` times it.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Examples
    --------
    >>> print(energy_identity(2).residual)
    0
    """
    scheme = as_scheme(system)
    cells = scheme.state[:-1]
    function = sum(y**2 for y in cells) / (2 * s) + 2 * d * primitive
    jumps = sum((before - y) ** 2 for before, y in zip(_previous(scheme), cells, strict=True))
    rate = -jumps / 2 + ((2 * b * g - a * cells[-1]) ** 2 - cells[-1] ** 2) / 2
    return Balance(function=function, derivative=_along(function, scheme), rate=rate)


def conserved_mean(system: int | Scheme) -> Balance:
    r"""The deflated coordinate ``zeta``, which only the law and the force move.

    ``zeta = z + (sum_{i<=N} y_i - a sum_{i>N} y_i)/(s (1 + a))`` and ``zeta' = -rho_0 p + g/k``, where
    ``rho_0 = d (1 - a)/(1 + a)`` and ``1/k = 2 b/(1 + a)``.  Its gradient is the left null vector of ``A``.
    There is no such coordinate for ``a = -1``.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    forward, backward = scheme.state[: scheme.cells], scheme.state[scheme.cells : -1]
    function = z + (sum(forward) - a * sum(backward)) / (s * (1 + a))
    return Balance(function=function, derivative=_along(function, scheme), rate=-_residue() * p + 2 * b / (1 + a) * g)


def popov_lyapunov(system: int | Scheme) -> Balance:
    r"""Lyapunov function of Popov's type along the free scheme (``g = 0``).

    .. math::

        V &= \frac{\theta}{2 s d} \sum_i y_i^2 + 2\theta P(z) + \frac{\zeta^2}{\rho_0}, \qquad
        V' = -\frac{\theta}{d} D - 2 \zeta p, \\
        D &= \tfrac12 \sum_i (\mathrm{prev}_i - y_i)^2 + \tfrac12 (1 - a^2) y_{2N}^2.

    The identity alone does not say that ``V`` falls: ``zeta p`` has no sign of its own; that is what Popov's inequality
    is for.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    energy, mean = energy_identity(scheme), conserved_mean(scheme)
    function = theta / d * energy.function + mean.function**2 / _residue()
    dissipation = -energy.rate.subs(g, 0)  # D: the rate of the energy identity with its sign turned
    return Balance(
        function=function,
        derivative=_along(function, scheme).subs(g, 0),
        rate=-theta / d * dissipation - 2 * mean.function * p,
    )


def rod_energy() -> Balance:
    """Energy of the rod itself: power through the ends, ``E' = -k u_t(t,0)^2 + g u_t(t,0) + int f u_t dx``.

    ``function`` is the density ``(rho A u_t^2 + A E u_x^2)/2`` [J/m]; ``derivative`` is the power that flows in through
    the ends plus that of the contact, ``A p z'``, with the boundary conditions put in; ``rate`` is the claim without
    ``f`` [W].  That energy flows as used here is ``local_energy_balance``.
    """
    motion = hamilton()
    tip = sp.Symbol("u_t(t,L)", real=True)
    end_left, end_right = sp.solve(motion.left, strain_left)[0], sp.solve(motion.right, strain_right)[0]
    power = area * E * (end_right * tip - end_left * velocity_left)
    return Balance(
        function=(rho * area * u.diff(t) ** 2 + area * E * u.diff(x) ** 2) / 2,
        derivative=sp.expand(power + area * p * tip),
        rate=-k * velocity_left**2 + g * velocity_left,
    )


def local_energy_balance() -> sp.Expr:
    """``e_t - (A E u_x u_t)_x - f u_t - u_t (rho A u_tt - A E u_xx - f)``, zero identically [W/m]."""
    flux = area * E * u.diff(x) * u.diff(t)
    return sp.expand(rod_energy().function.diff(t) - flux.diff(x) - f * u.diff(t) - u.diff(t) * hamilton().equation)


def _previous(scheme: Scheme) -> list[sp.Expr]:
    cells = scheme.state[:-1]
    previous = [-a * cells[-1] + 2 * b * g, *cells[:-1]]
    previous[scheme.cells] -= 2 * d * p
    return previous


def _along(function: sp.Expr, scheme: Scheme) -> sp.Expr:
    rates = scheme.rates()
    chain = sum(function.diff(y) * rate for y, rate in zip(scheme.state, rates, strict=True))
    return chain + function.diff(primitive) * p * rates[-1]


def _residue() -> sp.Expr:
    return d * (1 - a) / (1 + a)
