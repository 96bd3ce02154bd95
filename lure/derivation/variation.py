"""Hamilton's principle for the rod: from the Lagrangian density to the equations of motion and the weak form."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from lure.derivation.vocabulary import E, Form, area, checked_form, g, gap, k, p, rho, t, x

strain, velocity = sp.symbols("u_x u_t", real=True)
strain_left, velocity_left, strain_right, virtual_left, virtual_right = (
    sp.Symbol(name, real=True) for name in ("u_x(t,0)", "u_t(t,0)", "u_x(t,L)", "v(0)", "v(L)")
)
u, virtual, f = sp.Function("u")(t, x), sp.Function("v")(t, x), sp.Function("f")(t, x)
area_at, density_at = sp.Function("A")(x), sp.Function("rho")(x)


@dataclass(frozen=True, kw_only=True, slots=True)
class Hamilton:
    """What stationary action says about the rod; every expression vanishes along a motion.

    Attributes
    ----------
    nonuniform : sympy.Expr
        ``-rho(x) A(x) u_tt + (A(x) E u_x)_x + f``, the first line of (5) [N/m].
    equation : sympy.Expr
        ``rho A u_tt - A E u_xx - f``, the first line of (7) [N/m].
    left : sympy.Expr
        ``A E u_x(t,0) - k u_t(t,0) + g``, the second line of (7) [N].
    right : sympy.Expr
        ``E u_x(t,L) + p``, the third line of (7) [Pa].
    by_parts : sympy.Expr
        First variation minus (equation times variation plus a divergence); zero identically.
    """

    nonuniform: sp.Expr
    equation: sp.Expr
    left: sp.Expr
    right: sp.Expr
    by_parts: sp.Expr


@dataclass(frozen=True, kw_only=True, slots=True)
class WeakForm:
    """The equations tested with ``v``: ``int interior dx + left + right = 0`` for every ``v`` in H1(0, L).

    Attributes
    ----------
    interior : sympy.Expr
        ``rho A u_tt v + A E u_x v_x - f v`` [N v/m].
    left : sympy.Expr
        ``(k u_t(t,0) - g) v(0)`` [N v].
    right : sympy.Expr
        ``A p v(L)`` [N v].
    """

    interior: sp.Expr
    left: sp.Expr
    right: sp.Expr


@dataclass(frozen=True, kw_only=True, slots=True)
class _Variation:
    """Coefficients of ``v_t``, ``v_x`` and ``v`` in the first variation of the Lagrangian density."""

    momentum: sp.Expr
    flux: sp.Expr
    body: sp.Expr
    by_parts: sp.Expr

    @property
    def euler_lagrange(self) -> sp.Expr:
        """Left-hand side of the Euler-Lagrange equation."""
        return self.body - self.momentum.diff(t) - self.flux.diff(x)


def elastic_energy(form: Form = "corrected") -> sp.Expr:
    """Potential energy per length, ``A E u_x^2/2`` [N]; as printed in (1) it is ``A (E u_x)^2/2``."""
    stress = E * strain
    return area * stress**2 / 2 if checked_form(form) == "as-printed" else area * stress * strain / 2


def hamilton(form: Form = "corrected") -> Hamilton:
    r"""Vary the action (3) and integrate by parts.

    The density ``rho A u_t^2/2 - A E u_x^2/2 + f u`` is varied along ``u + zeta v`` as in (4); the coefficients of
    ``v_t``, ``v_x``, ``v`` give the Euler-Lagrange equation and the flux through the ends, where the virtual work
    of ``h0 + g`` at ``x = 0`` and ``h1`` at ``x = L`` is added (2).  Then ``h0 = -k u_t(t,0)``, and ``h1 = -A p``:
    ``p`` is a stress [Pa], positive in compression.

    Parameters
    ----------
    form : {"corrected", "as-printed"}
        ``"as-printed"`` takes the potential energy of (1); (7) does not follow from it unless ``E = 1``.

    Returns
    -------
    Hamilton
        The equation of motion and both natural boundary conditions, signs included.

    Examples
    --------
    >>> print(hamilton().left)
    A*E*u_x(t,0) + g - k*u_t(t,0)
    """
    potential = elastic_energy(form)
    general = _vary(density_at * area_at * velocity**2 / 2, potential.subs(area, area_at))
    uniform = _vary(rho * area * velocity**2 / 2, potential)
    at_left, at_right = _end_forces(uniform)
    h0, h1 = sp.symbols("h0 h1", real=True)
    return Hamilton(
        nonuniform=sp.expand(general.euler_lagrange),
        equation=sp.expand(-uniform.euler_lagrange),
        left=at_left.subs(h0, -k * velocity_left),
        right=sp.expand(at_right.subs(h1, -area * p) / -area),
        by_parts=sp.expand(general.by_parts),
    )


def weak_form(form: Form = "corrected") -> WeakForm:
    r"""Test the equations of motion: (10), with every constant kept.

    The paper sets ``E = k = rho = 1`` in (10); the printed formula has ``A = 1`` as well.

    Parameters
    ----------
    form : {"corrected", "as-printed"}
        ``"as-printed"`` returns the left end of (10), ``(k u_t(t,0) + g) v(0)``, whose sign contradicts (8).

    Examples
    --------
    >>> print(weak_form().left.diff(g))
    -v(0)
    """
    variation = _vary(rho * area * velocity**2 / 2, elastic_energy())
    natural = hamilton()
    flux_left = -area * E * sp.solve(natural.left, strain_left)[0]
    flux_right = -area * E * sp.solve(natural.right, strain_right)[0]
    left = sp.factor(-flux_left * virtual_left)
    if checked_form(form) == "as-printed":
        left = (k * velocity_left + g) * virtual_left
    interior = variation.momentum.diff(t) * virtual - variation.flux * virtual.diff(x) - variation.body * virtual
    return WeakForm(interior=sp.expand(interior), left=left, right=flux_right * virtual_right)


def _vary(kinetic: sp.Expr, potential: sp.Expr) -> _Variation:
    zeta = sp.Symbol("zeta")
    moved = u + zeta * virtual
    density = kinetic.subs(velocity, moved.diff(t)) - potential.subs(strain, moved.diff(x)) + f * moved
    first = sp.expand(density.diff(zeta).subs(zeta, 0).doit())
    momentum, flux, body = (first.coeff(direction) for direction in (virtual.diff(t), virtual.diff(x), virtual))
    by_parts = (
        first
        - (body - momentum.diff(t) - flux.diff(x)) * virtual
        - (momentum * virtual).diff(t)
        - (flux * virtual).diff(x)
    )
    return _Variation(momentum=momentum, flux=flux, body=body, by_parts=by_parts)


def _end_forces(variation: _Variation) -> tuple[sp.Expr, sp.Expr]:
    """Coefficients of ``v(0)`` and ``v(L)`` in the variation of the action: flux out of the rod plus outside work."""
    h0, h1, left, right = sp.symbols("h0 h1 u_0 u_L", real=True)
    work = h0 * left + g * left + h1 * (right - gap)  # (2) without the body force
    flux_left, flux_right = (variation.flux.subs(u.diff(x), end) for end in (strain_left, strain_right))
    return sp.expand(-flux_left + work.diff(left)), sp.expand(flux_right + work.diff(right))
