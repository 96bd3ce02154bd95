"""The steps about the rod itself: from the action to the delay equation."""

from __future__ import annotations

import sympy as sp

from lure.derivation.energy import local_energy_balance, rod_energy
from lure.derivation.variation import (
    area_at,
    density_at,
    f,
    hamilton,
    strain_left,
    strain_right,
    u,
    velocity_left,
    virtual,
    virtual_left,
    virtual_right,
    weak_form,
)
from lure.derivation.vocabulary import (
    IMPEDANCE,
    E,
    Form,
    Step,
    T,
    a,
    area,
    b,
    c,
    d,
    g,
    k,
    laplace,
    p,
    residual,
    rho,
    t,
    x,
)
from lure.derivation.waves import (
    boundary_relations,
    delay_equation,
    exact_transfer_function,
    r1,
    r2,
    rest_position,
    riemann,
    v,
    w,
)


def rod_steps(form: Form) -> tuple[Step, ...]:
    """Steps from Hamilton's principle to the rod's own transfer function."""
    return (*_motion(form), *_invariants(), *_boundary(), *_exact())


def _motion(form: Form) -> tuple[Step, ...]:
    motion, weak, energy = hamilton(form), weak_form(form), rod_energy()
    acceleration, curvature = u.diff(t, 2), u.diff(x, 2)
    return (
        Step(
            title="First variation of the action",
            statement="d/dzeta L(u + zeta v) = (Euler-Lagrange) v + (L_ut v)_t + (L_ux v)_x (4)",
            residual=residual(motion.by_parts),
        ),
        Step(
            title="Euler-Lagrange equation, non-uniform rod",
            statement="-rho(x) A(x) u_tt + (A(x) E u_x)_x + f = 0 (5)",
            residual=residual(
                motion.nonuniform - (-density_at * area_at * acceleration + (area_at * E * u.diff(x)).diff(x) + f)
            ),
        ),
        Step(
            title="Uniform rod with its natural boundary conditions",
            statement="rho A u_tt - A E u_xx = f, A E u_x(t,0) = k u_t(t,0) - g, E u_x(t,L) = -p (7), (8)",
            residual=residual(
                motion.equation - (rho * area * acceleration - area * E * curvature - f),
                motion.left - (area * E * strain_left - k * velocity_left + g),
                motion.right - (E * strain_right + p),
            ),
        ),
        Step(
            title="Weak form",
            statement="<rho A u_tt, v> + <A E u_x, v_x> + (k u_t(t,0) - g) v(0) + A p v(L) = <f, v> (10)",
            residual=residual(
                weak.interior
                - (rho * area * acceleration * virtual + area * E * u.diff(x) * virtual.diff(x))
                + f * virtual,
                weak.left - (k * velocity_left - g) * virtual_left,
                weak.right - area * p * virtual_right,
            ),
        ),
        Step(
            title="Energy of the rod",
            statement="d/dt [int (rho A u_t^2 + A E u_x^2)/2 dx + A P(z)] = -k u_t(t,0)^2 + g u_t(t,0) + int f u_t dx",
            residual=residual(local_energy_balance(), energy.residual),
        ),
    )


def _invariants() -> tuple[Step, ...]:
    waves = riemann()
    symmetric = waves.symmetriser * waves.matrix
    eigenvalue = sp.Symbol("x")
    source = f / (rho * area)
    return (
        Step(
            title="Friedrichs form",
            statement="v_t - c^2 w_x = f/(rho A), w_t - v_x = 0; diag(1, c^2) M symmetric, eigenvalues c and -c (26)",
            residual=residual(
                *waves.friedrichs,
                *(symmetric - symmetric.T),
                waves.matrix.charpoly(eigenvalue).as_expr() - (eigenvalue - c) * (eigenvalue + c),
            ),
        ),
        Step(
            title="Riemann invariants",
            statement="r1 = v - c w, r2 = v + c w; v = (r1 + r2)/2, w = (-r1 + r2)/(2 c) (29), (30)",
            residual=residual(
                waves.invariants[0] - (v - c * w),
                waves.invariants[1] - (v + c * w),
                waves.inverse[0] - (r1 + r2) / 2,
                waves.inverse[1] - (r2 - r1) / (2 * c),
            ),
        ),
        Step(
            title="Decoupled transport equations",
            statement="r1_t + c r1_x = f/(rho A), r2_t - c r2_x = f/(rho A) (31)",
            residual=residual(*waves.transport, *(found - source for found in waves.sources)),
        ),
    )


def _boundary() -> tuple[Step, ...]:
    relations = boundary_relations()
    return (
        Step(
            title="Boundary relations",
            statement="r1(t,0) = -a r2(t,0) + 2 b g, r2(t,L) = r1(t,L) - 2 d p, z' = r1(t,L) - d p (32)",
            residual=residual(
                relations.left - (-relations.a * r2 + 2 * relations.b * g),
                relations.right - (r1 - 2 * relations.d * p),
                relations.tip - (r1 - relations.d * p),
            ),
        ),
        Step(
            title="Their constants",
            statement="a = (k - Z)/(k + Z), b = 1/(k + Z), d = 1/sqrt(rho E), Z = A sqrt(rho E) (below (33))",
            residual=residual(
                relations.a - (k - IMPEDANCE) / (k + IMPEDANCE),
                relations.b - 1 / (k + IMPEDANCE),
                relations.d - 1 / sp.sqrt(rho * E),
            ),
        ),
        _resting_place(),
    )


def _resting_place() -> Step:
    relations, waves = boundary_relations(), riemann()
    initial_velocity = sp.Symbol("int(u1)", real=True)
    stretch = sp.Symbol("u0(L)", real=True) - sp.Symbol("u0(0)", real=True)
    forward, backward = (  # integrals of r1 and r2 at t = 0 over the rod
        wave.coeff(v) * initial_velocity + wave.coeff(w) * stretch for wave in waves.invariants
    )
    speed = sp.sqrt(E / rho)
    mean = (forward - relations.a * backward).subs(c, speed) / (speed * (1 + relations.a))
    return Step(
        title="Where the free rod comes to rest",
        statement="u0(L) + int (r1 - a r2)/(c (1 + a)) dx at t = 0 = u0(0) + (rho A/k) int u1 dx",
        residual=residual(sp.Symbol("u0(L)", real=True) + mean - rest_position()),
    )


def _exact() -> tuple[Step, ...]:
    delay = delay_equation()
    outgoing, force = sp.Function("V"), sp.Function("g")
    delayed = a * sp.exp(-2 * laplace * T)
    return (
        Step(
            title="The rod as a delay equation",
            statement="r1(t,L) = -a V(t - 2T) + 2 b g(t - T), u_t(t,0) = (1 - a)/2 V(t - T) + b g, V = r2(t,L), f = 0",
            residual=residual(
                *delay.transport,
                delay.outgoing - outgoing(t),
                delay.incoming - (-a * outgoing(t - 2 * T) + 2 * b * force(t - T)),
                delay.left_velocity - ((1 - a) / 2 * outgoing(t - T) + b * force(t)),
            ),
        ),
        Step(
            title="Transfer function of the rod",
            statement="H_inf(s') = (d/s') (1 - a exp(-2 s' T))/(1 + a exp(-2 s' T))",
            residual=residual(exact_transfer_function() - d / laplace * (1 - delayed) / (1 + delayed)),
        ),
    )
