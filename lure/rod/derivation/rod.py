"""Friedrichs form, Riemann invariants, boundary relations and the delay equation: (26)-(32), and the rod's own H."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import sympy as sp

from lure.record import described, quantity
from lure.rod.derivation.vocabulary import E, Form, T, a, area, b, c, checked_form, d, g, gap, k, laplace, p, rho, t, x

# Hamilton's principle for the rod: from the Lagrangian density to the equations of motion and the weak form.

strain, velocity = sp.symbols("u_x u_t", real=True)
strain_left, velocity_left, strain_right, virtual_left, virtual_right = (
    sp.Symbol(name, real=True) for name in ("u_x(t,0)", "u_t(t,0)", "u_x(t,L)", "v(0)", "v(L)")
)
u, virtual, f = sp.Function("u")(t, x), sp.Function("v")(t, x), sp.Function("f")(t, x)
area_at, density_at = sp.Function("A")(x), sp.Function("rho")(x)


@described(frozen=True, kw_only=True, slots=True)
class Hamilton:
    """What stationary action says about the rod; every expression vanishes along a motion."""

    nonuniform: sp.Expr = quantity("``-rho(x) A(x) u_tt + (A(x) E u_x)_x + f``, the first line of (5) [N/m]")
    equation: sp.Expr = quantity("``rho A u_tt - A E u_xx - f``, the first line of (7) [N/m]")
    left: sp.Expr = quantity("``A E u_x(t,0) - k u_t(t,0) + g``, the second line of (7)", "N")
    right: sp.Expr = quantity("``E u_x(t,L) + p``, the third line of (7)", "Pa")
    by_parts: sp.Expr = quantity("First variation minus (equation times variation plus a divergence); zero identically")


@described(frozen=True, kw_only=True, slots=True)
class WeakForm:
    """The equations tested with ``v``: ``int interior dx + left + right = 0`` for every ``v`` in H1(0, L)."""

    interior: sp.Expr = quantity("``rho A u_tt v + A E u_x v_x - f v`` [N v/m]")
    left: sp.Expr = quantity("``(k u_t(t,0) - g) v(0)`` [N v]")
    right: sp.Expr = quantity("``A p v(L)`` [N v]")


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


@cache
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


v, w = sp.Function("v")(t, x), sp.Function("w")(t, x)
r1, r2 = sp.symbols("r1 r2", real=True)


@described(frozen=True, kw_only=True, slots=True)
class Riemann:
    """The rod as two transport equations."""

    matrix: sp.ImmutableMatrix = quantity("``M`` in ``(v, w)_t + M (v, w)_x = (f/(rho A), 0)``, shape (2, 2)")
    symmetriser: sp.ImmutableMatrix = quantity("``diag(1, c^2)``: makes ``M`` symmetric (Friedrichs)")
    invariants: tuple[sp.Expr, sp.Expr] = quantity(
        "``r1 = v - c w`` and ``r2 = v + c w`` (29) [m/s]: left eigenvectors of ``M`` applied to ``(v, w)``"
    )
    sources: tuple[sp.Expr, sp.Expr] = quantity("Right-hand sides of (31), ``f/(rho A)`` in both [m/s^2]")
    transport: tuple[sp.Expr, sp.Expr] = quantity(
        "``r_t + speed r_x - source`` minus the same combination of the equations (26); zero identically"
    )
    inverse: tuple[sp.Expr, sp.Expr] = quantity("``v`` and ``w`` in terms of ``r1, r2`` (30)")
    friedrichs: tuple[sp.Expr, sp.Expr] = quantity(
        "Equation (26) with ``v = u_t, w = u_x`` minus the wave equation over ``rho A``, and minus ``u_xt = "
        "u_tx``; zero"
    )


@described(frozen=True, kw_only=True, slots=True)
class BoundaryRelations:
    """``r1(t,0) = -a r2(t,0) + 2 b g``, ``r2(t,L) = r1(t,L) - 2 d p``, ``z' = r1(t,L) - d p``, solved from (8)."""

    a: sp.Expr = quantity("``(k - Z)/(k + Z)`` [-], in terms of ``E, rho, A, k``")
    b: sp.Expr = quantity("``1/(k + Z)`` [m/(N s)]")
    d: sp.Expr = quantity("``1/sqrt(rho E)`` [m/(s Pa)]")
    left: sp.Expr = quantity("``r1(t,0)`` in terms of ``r2, g`` and the rod's constants [m/s]")
    right: sp.Expr = quantity("``r2(t,L)`` in terms of ``r1, p`` and the rod's constants [m/s]")
    tip: sp.Expr = quantity("``z' = (r1 + r2)/2`` at ``x = L`` in terms of ``r1, p`` [m/s]")


@described(frozen=True, kw_only=True, slots=True)
class DelayEquation:
    """``W(t) = -a V(t - 2T) + 2 b g(t - T)`` with ``W = r1(t,L)``, ``V = r2(t,L)``, for ``f = 0``."""

    incoming: sp.Expr = quantity(
        "``W(t)`` as the boundary relations and d'Alembert's solution give it, in terms of ``V`` and ``g`` [m/s]"
    )
    outgoing: sp.Expr = quantity("The backward wave at ``x = L``; ``V(t)`` [m/s]")
    left_velocity: sp.Expr = quantity("``u_t(t,0)`` in terms of ``V`` and ``g`` [m/s]")
    transport: tuple[sp.Expr, sp.Expr] = quantity("Equation (31) with ``f = 0`` applied to both waves; zero")


@cache
def riemann() -> Riemann:
    """Diagonalise the first-order system: (26), (29), (30), (31).

    The eigenvectors are computed from the matrix, not typed in; each is scaled so that ``v`` has coefficient one.

    Examples
    --------
    >>> print(riemann().invariants)
    (-c*w(t, x) + v(t, x), c*w(t, x) + v(t, x))
    """
    matrix = sp.ImmutableMatrix([[0, -(c**2)], [-1, 0]])
    state, force = sp.Matrix([v, w]), sp.Matrix([f / (rho * area), 0])
    system = state.diff(t) + matrix * state.diff(x) - force
    left_vectors = {value: vectors[0] / vectors[0][0] for value, _, vectors in matrix.T.eigenvects()}
    waves = [(speed, left_vectors[speed]) for speed in (c, -c)]
    invariants, sources = ([vector.dot(column) for _, vector in waves] for column in (state, force))
    transport = [
        r.diff(t) + speed * r.diff(x) - source - vector.dot(system)
        for (speed, vector), r, source in zip(waves, invariants, sources, strict=True)
    ]
    unknown = sp.symbols("v w")
    pair = [r.subs({v: unknown[0], w: unknown[1]}) for r in invariants]
    inverse = sp.solve([pair[0] - r1, pair[1] - r2], unknown)
    in_u = system.subs({v: u.diff(t), w: u.diff(x)}).doit().subs(c, sp.sqrt(E / rho))
    return Riemann(
        matrix=matrix,
        symmetriser=sp.ImmutableMatrix(sp.diag(1, c**2)),
        invariants=(invariants[0], invariants[1]),
        sources=(sources[0], sources[1]),
        transport=(sp.expand(transport[0]), sp.expand(transport[1])),
        inverse=(inverse[unknown[0]], inverse[unknown[1]]),
        friedrichs=(sp.expand(in_u[0] - hamilton().equation / (rho * area)), sp.expand(in_u[1])),
    )


@cache
def boundary_relations(motion: Hamilton | None = None) -> BoundaryRelations:
    """Solve the boundary conditions for the outgoing wave at each end: (32), with ``a, b, d`` read off.

    Parameters
    ----------
    motion : Hamilton, optional
        Where the boundary conditions are taken from; by default :func:`lure.rod.derivation.rod.hamilton`.

    Examples
    --------
    >>> print(boundary_relations().b)
    1/(A*sqrt(E)*sqrt(rho) + k)
    """
    motion = motion or hamilton()
    at_end = [field.subs(c, sp.sqrt(E / rho)) for field in riemann().inverse]
    left = sp.solve(motion.left.subs({velocity_left: at_end[0], strain_left: at_end[1]}), r1)[0]
    right = sp.expand(sp.solve(motion.right.subs(strain_right, at_end[1]), r2)[0])
    return BoundaryRelations(
        a=sp.simplify(-left.diff(r2)),
        b=sp.simplify(left.diff(g) / 2),
        d=sp.simplify(-right.diff(p) / 2),
        left=left,
        right=right,
        tip=sp.expand(at_end[0].subs(r2, right)),
    )


def delay_equation() -> DelayEquation:
    """Follow the two waves along their characteristics: the rod as a scalar neutral delay equation.

    The backward wave is ``r2 = V(t + x/c - T)``; what it leaves at ``x = 0``, ``-a r2(t,0) + 2 b g(t)``, travels as
    ``r1(t - x/c)`` and reaches ``x = L = c T`` one travel time ``T`` later.

    Examples
    --------
    >>> print(delay_equation().incoming)
    -a*V(-2*T + t) + 2*b*g(-T + t)
    """
    outgoing, force = sp.Function("V"), sp.Function("g")
    backward = outgoing(t + x / c - T)  # V(t) at x = L = c T
    reflected = -a * backward.subs(x, 0) + 2 * b * force(t)
    forward = reflected.subs(t, t - x / c)
    return DelayEquation(
        incoming=sp.expand(forward.subs(x, c * T)),
        outgoing=backward.subs(x, c * T),
        left_velocity=sp.expand((reflected + backward.subs(x, 0)) / 2),
        transport=(
            sp.simplify((forward.diff(t) + c * forward.diff(x)).doit()),
            sp.simplify((backward.diff(t) - c * backward.diff(x)).doit()),
        ),
    )


def exact_transfer_function() -> sp.Expr:
    """Transfer function of the rod itself, ``H_inf(s') = (d/s') (1 - a e^{-2 s' T})/(1 + a e^{-2 s' T})`` [m/Pa].

    The delay equation turns what leaves ``x = L`` at ``t - 2T`` into what arrives at ``t``: ``round_trip`` with the
    factor ``e^{-2 s' T}``.
    """
    return round_trip(sp.exp(-2 * laplace * T))


def round_trip(factor: sp.Expr) -> sp.Expr:
    """Transfer function from ``mu = -p`` to ``z`` if the way from ``x = L`` to ``0`` and back multiplies by ``factor``.

    Solved from ``W = -a factor V``, ``V = W + 2 d mu``, ``s' z = (W + V)/2`` with ``g = 0`` and zero initial data.  The
    rod has ``e^{-2 s' T}``; the scheme, where a cell multiplies by ``q = 1/(1 + s'/s)``, has ``q^{2N}`` for any ``N``.

    ``factor``: transfer function of the round trip, without the reflection ``-a`` at ``x = 0``.
    """
    incoming, outgoing, sigma, mu = sp.symbols("W V sigma mu")
    equations = [
        incoming + a * factor * outgoing,
        outgoing - incoming - 2 * d * mu,
        laplace * sigma - (incoming + outgoing) / 2,
    ]
    solution = sp.solve(equations, [incoming, outgoing, sigma])
    return sp.factor(solution[sigma] / mu)


def rest_position() -> sp.Expr:
    """Where the free rod comes to rest, ``u0(0) + (rho A/k) int u1 dx``, for ``f = g = p = 0`` and ``k > 0`` [m].

    The momentum ``int rho A u_t dx`` changes at the rate ``A E u_x(t,L) - A E u_x(t,0)``, which the boundary conditions
    turn into ``-k u_t(t,0)``; integrate from the start to rest.  There the strain is zero, so it is the displacement
    of every point.  Whether the rod comes to rest is not shown here.
    """
    motion = hamilton()
    conditions = (motion.left, strain_left), (motion.right, strain_right)
    pull = {end: area * E * sp.solve(line, end)[0] for line, end in conditions}
    momentum_rate = sp.expand(pull[strain_right] - pull[strain_left]).subs({g: 0, p: 0})
    start, rest, initial_velocity = (sp.Symbol(name, real=True) for name in ("u0(0)", "u_rest", "int(u1)"))
    lost = momentum_rate.coeff(velocity_left) * (rest - start)
    return sp.expand(sp.solve(lost + rho * area * initial_velocity, rest)[0])
