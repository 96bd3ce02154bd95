"""The Popov expression of the rod and of the scheme in closed form, and where its numbers come from."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from lure.derivation.vocabulary import T, a, d, omega, theta

modulus = sp.Symbol("r", positive=True)  # |q^{2N}|; 1 for the rod itself
phase = sp.Symbol("psi", real=True)  # minus the argument of q^{2N}; 2 omega T for the rod itself


@dataclass(frozen=True, kw_only=True, slots=True)
class ClosedForm:
    """A frequency function taken two ways.

    Attributes
    ----------
    computed : sympy.Expr
        By the definition.
    closed : sympy.Expr
        In the closed form claimed.
    angle : sympy.Symbol
        The only angle in both.
    """

    computed: sp.Expr
    closed: sp.Expr
    angle: sp.Symbol

    @property
    def residual(self) -> sp.Expr:
        """Numerator of ``computed - closed``, reduced by ``sin^2 + cos^2 = 1``: a normal form, zero if they agree."""
        cosine, sine = sp.symbols("C S")
        on_circle = {sp.tan(self.angle): sine / cosine, sp.cos(self.angle): cosine, sp.sin(self.angle): sine}
        numerator, _ = sp.fraction(sp.together((self.computed - self.closed).subs(on_circle)))
        return sp.factor(sp.reduced(sp.expand(numerator), [sine**2 + cosine**2 - 1], sine, cosine)[1])


def popov_expression() -> ClosedForm:
    r"""Popov's expression with ``q^{2N} = r exp(-i psi)``, for the scheme and (``r = 1``) the rod [m/Pa].

    .. math::

        \mathrm{Re}\,[(1 + i\omega\theta) H(i\omega)]
        &= d\,\frac{2 a r \sin(\psi)/\omega + \theta (1 - a^2 r^2)}{1 + a^2 r^2 + 2 a r \cos\psi}, \\
        H &= \frac{d}{i\omega}\,\frac{1 - a r e^{-i\psi}}{1 + a r e^{-i\psi}}.

    Examples
    --------
    >>> print(popov_expression().residual)
    0
    """
    delayed = a * modulus * (sp.cos(phase) - sp.I * sp.sin(phase))
    response = d / (sp.I * omega) * (1 - delayed) / (1 + delayed)
    value = (1 + sp.I * omega * theta) * response
    closed_numerator = 2 * a * modulus * sp.sin(phase) / omega + theta * (1 - a**2 * modulus**2)
    return ClosedForm(
        computed=(value + sp.conjugate(value)) / 2,
        closed=d * closed_numerator / (1 + a**2 * modulus**2 + 2 * a * modulus * sp.cos(phase)),
        angle=phase,
    )


def scheme_delay() -> ClosedForm:
    """``q = 1/(1 + s'/s)`` at ``s' = i omega``, ``omega = s tan(chi)``: it is ``cos(chi) exp(-i chi)``.

    So ``q^{2N}`` has ``r = (1 + omega^2/s^2)^{-N}`` and ``psi = 2 N atan(omega/s)``, for every ``N``.
    """
    chi = sp.Symbol("chi", real=True)
    return ClosedForm(
        computed=1 / (1 + sp.I * sp.tan(chi)),
        closed=sp.cos(chi) * (sp.cos(chi) - sp.I * sp.sin(chi)),
        angle=chi,
    )


def low_frequency_limit() -> sp.Expr:
    """Limit of the rod's Popov expression at frequency zero, ``4 a d T/(1 + a)^2 + theta d (1 - a)/(1 + a)`` [m/Pa].

    For ``0 < k < Z`` (``-1 < a < 0``) it is negative unless ``theta >= -4 a T/(1 - a^2)``: with ``theta = 0``, the
    circle criterion, only small sectors are left.
    """
    closed = popov_expression().closed.subs({modulus: 1, phase: 2 * omega * T})
    return sp.factor(sp.limit(closed, omega, 0))


def least_multiplier() -> sp.Expr:
    """The multiplier that makes the low-frequency limit zero, ``theta = -4 a T/(1 - a^2)`` [s].

    It is positive when ``0 < k < Z``.  For an infinite sector no smaller ``theta`` can work; that it works at every
    frequency is not shown here.
    """
    return sp.factor(sp.solve(low_frequency_limit(), theta)[0])
