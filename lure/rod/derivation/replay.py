"""The derivation from beginning to end, as steps whose residuals must be zero."""

from __future__ import annotations

import sympy as sp

from lure.rod.derivation import scheme as discrete
from lure.rod.derivation.rod import (
    area_at,
    boundary_relations,
    delay_equation,
    density_at,
    exact_transfer_function,
    f,
    hamilton,
    r1,
    r2,
    rest_position,
    riemann,
    round_trip,
    strain_left,
    strain_right,
    u,
    v,
    velocity_left,
    virtual,
    virtual_left,
    virtual_right,
    w,
    weak_form,
)
from lure.rod.derivation.scheme import Scheme
from lure.rod.derivation.vocabulary import (
    IMPEDANCE,
    E,
    Form,
    Step,
    T,
    a,
    area,
    b,
    c,
    checked_cells,
    checked_form,
    d,
    g,
    k,
    laplace,
    p,
    primitive,
    residual,
    rho,
    s,
    t,
    theta,
    x,
)


def _step(title: str, statement: str, *differences: sp.Expr) -> Step:
    """The step that claims that some differences are zero."""
    return Step(title=title, statement=statement, residual=residual(*differences))


# The steps about the rod itself: from the action to the delay equation.


def rod_steps(form: Form) -> tuple[Step, ...]:
    """Steps from Hamilton's principle to the rod's own transfer function."""
    return (*_motion(form), *_invariants(), *_boundary(), *_exact())


def _motion(form: Form) -> tuple[Step, ...]:
    motion, weak, energy = hamilton(form), weak_form(form), discrete.rod_energy()
    acceleration, curvature = u.diff(t, 2), u.diff(x, 2)
    return (
        _step(
            "First variation of the action",
            "d/dzeta L(u + zeta v) = (Euler-Lagrange) v + (L_ut v)_t + (L_ux v)_x (4)",
            motion.by_parts,
        ),
        _step(
            "Euler-Lagrange equation, non-uniform rod",
            "-rho(x) A(x) u_tt + (A(x) E u_x)_x + f = 0 (5)",
            motion.nonuniform - (-density_at * area_at * acceleration + (area_at * E * u.diff(x)).diff(x) + f),
        ),
        _step(
            "Uniform rod with its natural boundary conditions",
            "rho A u_tt - A E u_xx = f, A E u_x(t,0) = k u_t(t,0) - g, E u_x(t,L) = -p (7), (8)",
            motion.equation - (rho * area * acceleration - area * E * curvature - f),
            motion.left - (area * E * strain_left - k * velocity_left + g),
            motion.right - (E * strain_right + p),
        ),
        _step(
            "Weak form",
            "<rho A u_tt, v> + <A E u_x, v_x> + (k u_t(t,0) - g) v(0) + A p v(L) = <f, v> (10)",
            weak.interior
            - (rho * area * acceleration * virtual + area * E * u.diff(x) * virtual.diff(x))
            + f * virtual,
            weak.left - (k * velocity_left - g) * virtual_left,
            weak.right - area * p * virtual_right,
        ),
        _step(
            "Energy of the rod",
            "d/dt [int (rho A u_t^2 + A E u_x^2)/2 dx + A P(z)] = -k u_t(t,0)^2 + g u_t(t,0) + int f u_t dx",
            discrete.local_energy_balance(),
            energy.residual,
        ),
    )


def _invariants() -> tuple[Step, ...]:
    waves = riemann()
    symmetric = waves.symmetriser * waves.matrix
    eigenvalue = sp.Symbol("x")
    source = f / (rho * area)
    return (
        _step(
            "Friedrichs form",
            "v_t - c^2 w_x = f/(rho A), w_t - v_x = 0; diag(1, c^2) M symmetric, eigenvalues c and -c (26)",
            *waves.friedrichs,
            *(symmetric - symmetric.T),
            waves.matrix.charpoly(eigenvalue).as_expr() - (eigenvalue - c) * (eigenvalue + c),
        ),
        _step(
            "Riemann invariants",
            "r1 = v - c w, r2 = v + c w; v = (r1 + r2)/2, w = (-r1 + r2)/(2 c) (29), (30)",
            waves.invariants[0] - (v - c * w),
            waves.invariants[1] - (v + c * w),
            waves.inverse[0] - (r1 + r2) / 2,
            waves.inverse[1] - (r2 - r1) / (2 * c),
        ),
        _step(
            "Decoupled transport equations",
            "r1_t + c r1_x = f/(rho A), r2_t - c r2_x = f/(rho A) (31)",
            *waves.transport,
            *(found - source for found in waves.sources),
        ),
    )


def _boundary() -> tuple[Step, ...]:
    relations = boundary_relations()
    return (
        _step(
            "Boundary relations",
            "r1(t,0) = -a r2(t,0) + 2 b g, r2(t,L) = r1(t,L) - 2 d p, z' = r1(t,L) - d p (32)",
            relations.left - (-relations.a * r2 + 2 * relations.b * g),
            relations.right - (r1 - 2 * relations.d * p),
            relations.tip - (r1 - relations.d * p),
        ),
        _step(
            "Their constants",
            "a = (k - Z)/(k + Z), b = 1/(k + Z), d = 1/sqrt(rho E), Z = A sqrt(rho E) (below (33))",
            relations.a - (k - IMPEDANCE) / (k + IMPEDANCE),
            relations.b - 1 / (k + IMPEDANCE),
            relations.d - 1 / sp.sqrt(rho * E),
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
    return _step(
        "Where the free rod comes to rest",
        "u0(L) + int (r1 - a r2)/(c (1 + a)) dx at t = 0 = u0(0) + (rho A/k) int u1 dx",
        sp.Symbol("u0(L)", real=True) + mean - rest_position(),
    )


def _exact() -> tuple[Step, ...]:
    delay = delay_equation()
    outgoing, force = sp.Function("V"), sp.Function("g")
    delayed = a * sp.exp(-2 * laplace * T)
    return (
        _step(
            "The rod as a delay equation",
            "r1(t,L) = -a V(t - 2T) + 2 b g(t - T), u_t(t,0) = (1 - a)/2 V(t - T) + b g, V = r2(t,L), f = 0",
            *delay.transport,
            delay.outgoing - outgoing(t),
            delay.incoming - (-a * outgoing(t - 2 * T) + 2 * b * force(t - T)),
            delay.left_velocity - ((1 - a) / 2 * outgoing(t - T) + b * force(t)),
        ),
        _step(
            "Transfer function of the rod",
            "H_inf(s') = (d/s') (1 - a exp(-2 s' T))/(1 + a exp(-2 s' T))",
            exact_transfer_function() - d / laplace * (1 - delayed) / (1 + delayed),
        ),
    )


# The steps about the scheme: matrices, spectrum, limit, energy and the Popov expression.


def scheme_steps(cells: int, form: Form) -> tuple[Step, ...]:
    """Steps about the schemes with 1 to ``cells`` cells."""
    schemes = tuple(discrete.upwind_matrices(count, form=form) for count in range(1, cells + 1))
    return (*_matrices(schemes), *_limits(), *_balances(schemes), *_popov())


def _matrices(schemes: tuple[Scheme, ...]) -> tuple[Step, ...]:
    upto = f"N = 1..{len(schemes)}"
    return (
        _step(
            f"Boundary relations put into the upwind equations, {upto}",
            "y1' = -s y1 - s a y_2N + 2 s b g, yi' = s y_i-1 - s y_i, "
            "y_N+1' = s y_N - s y_N+1 + 2 s d mu, z' = y_N + d mu (36)",
            *(entry for scheme in schemes for entry in _entries(scheme)),
        ),
        _step(
            f"Transfer function, {upto}",
            "c^T (s' I - A)^-1 b1 = (d/s') (1 - a q^2N)/(1 + a q^2N), q = 1/(1 + s'/s)",
            *(
                sp.cancel(discrete.transfer_function(one) - discrete.stated_transfer_function(one.cells))
                for one in schemes
            ),
        ),
        _any_number_of_cells(),
        _step(
            f"Characteristic polynomial, {upto}",
            "det(s' I - A) = s' ((s' + s)^2N + a s^2N)",
            *(
                discrete.characteristic_polynomial(one) - discrete.stated_characteristic_polynomial(one.cells)
                for one in schemes
            ),
        ),
        _zero_eigenvalue(schemes),
        _step(
            f"CNN matrix of (42), {upto}",
            "f-circulant with f = -a: s (K_f - I), K_f the cyclic shift with corner f",
            *(entry for one in schemes for entry in _ring_entries(one.cells)),
        ),
    )


def _any_number_of_cells() -> Step:
    before, cell, delayed = sp.symbols("y_i-1 y_i Q")
    passed = sp.solve(laplace * cell - s * (before - cell), cell)[0]
    return _step(
        "Transfer function, every N",
        "s' y_i = s (y_i-1 - y_i) gives y_i = q y_i-1; with Q = q^2N around the ring H_N = (d/s') (1 - a Q)/(1 + a Q)",
        passed - before / (1 + laplace / s),
        round_trip(delayed) - d / laplace * (1 - a * delayed) / (1 + a * delayed),
    )


def _entries(scheme: Scheme) -> list[sp.Expr]:
    stated = discrete.stated_matrices(scheme.cells)
    pairs = ((scheme.A, stated.A), (scheme.b1, stated.b1), (scheme.b2, stated.b2), (scheme.c, stated.c))
    return [entry for derived, claimed in pairs for entry in derived - claimed]


def _ring_entries(cells: int) -> list[sp.Expr]:
    matrix, shift = discrete.ring(cells)
    claimed = s * (shift.subs(sp.Symbol("f", real=True), -a) - sp.eye(2 * cells))
    return list(matrix - claimed)


def _zero_eigenvalue(schemes: tuple[Scheme, ...]) -> Step:
    relations = boundary_relations()
    rho_0 = d * (1 - a) / (1 + a)
    cofactors = (sp.cancel(discrete.characteristic_polynomial(one) / laplace).subs(laplace, 0) for one in schemes)
    return _step(
        "Zero eigenvalue",
        "residue d (1 - a)/(1 + a) = A/k; det(s' I - A)/s' at zero is s^2N (1 + a), 1 + a = 2 k/(k + Z): "
        "simple unless k = 0",
        *(discrete.residue_at_zero(one) - rho_0 for one in schemes),
        rho_0.subs({a: relations.a, d: relations.d}) - area / k,
        *(found - s ** (2 * one.cells) * (1 + a) for found, one in zip(cofactors, schemes, strict=True)),
        1 + relations.a - 2 * k / (k + IMPEDANCE),
    )


def _limits() -> tuple[Step, ...]:
    size = sp.Symbol("1/N", positive=True)
    return (
        _step(
            "Infinitely many cells",
            "q^2N -> exp(-2 s' T) as N -> inf, s' fixed, s = N/T: H_N -> H_inf",
            discrete.delay_limit() - sp.exp(-2 * laplace * T),
        ),
        _step(
            "Numerical damping",
            "ln q^2N = -2 s' T + (s' T)^2/N + O(1/N^2); at s' = i omega it is -(omega T)^2/N, which the rod lacks",
            discrete.numerical_damping() - (laplace * T) ** 2 * size,
        ),
    )


def _balances(schemes: tuple[Scheme, ...]) -> tuple[Step, ...]:
    upto = f"N = 1..{len(schemes)}"
    y, before = sp.symbols("y prev", real=True)
    pair = riemann().inverse
    cell, speed = c / s, sp.sqrt(E / rho)
    density = area * (rho * pair[0] ** 2 + E * pair[1] ** 2) / 2  # [J/m], in terms of r1 and r2
    return (
        _step(
            f"Energy identity of the scheme, {upto}",
            "d/dt [sum y_i^2/(2 s) + 2 d P(z)] = -sum (prev_i - y_i)^2/2 + [(2 b g - a y_2N)^2 - y_2N^2]/2",
            *(discrete.energy_identity(one).residual for one in schemes),
        ),
        _step(
            "Energy identity, every N",
            "y_i (prev - y_i) = [prev^2 - y_i^2 - (prev - y_i)^2]/2; the sum telescopes but for both "
            "ends, where (y_N - 2 d p)^2 - y_N^2 = -4 d p z'",
            y * (before - y) - (before**2 - y**2 - (before - y) ** 2) / 2,
            (y - 2 * d * p) ** 2 - y**2 + 4 * d * p * boundary_relations().tip.subs(r1, y).subs(rho, 1 / (E * d**2)),
        ),
        _step(
            "Energy identity in joules",
            "A (rho v^2 + E w^2)/2 = rho A (r1^2 + r2^2)/4; Z/2 [sum y_i^2/(2 s) + 2 d P] = "
            "h sum rho A y_i^2/4 + A P, h = c/s",
            density.subs(c, speed) - rho * area * (r1**2 + r2**2) / 4,
            (IMPEDANCE / 2 * y**2 / (2 * s) - cell * rho * area * y**2 / 4).subs(c, speed),
            IMPEDANCE / 2 * 2 * boundary_relations().d * primitive - area * primitive,
        ),
        _step(
            f"Conserved mean, {upto}",
            "zeta = z + (sum_{i<=N} y_i - a sum_{i>N} y_i)/(s (1 + a)): zeta' = -rho_0 p + g/k",
            *(discrete.conserved_mean(one).residual for one in schemes),
        ),
        _step(
            f"Popov-Lyapunov function, {upto}",
            "V = theta/(2 s d) sum y_i^2 + 2 theta P(z) + zeta^2/rho_0: V' = -(theta/d) D - 2 zeta p, g = 0",
            *(discrete.popov_lyapunov(one).residual for one in schemes),
        ),
    )


def _popov() -> tuple[Step, ...]:
    limit = 4 * a * d * T / (1 + a) ** 2 + theta * d * (1 - a) / (1 + a)
    return (
        _step(
            "Popov expression",
            "Re[(1 + i w theta) H(i w)] = "
            "d [2 a r sin(psi)/w + theta (1 - a^2 r^2)]/(1 + a^2 r^2 + 2 a r cos(psi)), q^2N = r exp(-i psi)",
            discrete.popov_expression().residual,
        ),
        _step(
            "r and psi of the scheme",
            "q = cos(chi) exp(-i chi), tan(chi) = w/s: r = (1 + w^2/s^2)^-N, psi = 2 N atan(w/s)",
            discrete.scheme_delay().residual,
        ),
        _step(
            "Frequency zero",
            "the limit is 4 a d T/(1 + a)^2 + theta d (1 - a)/(1 + a), for N = 1, 2 and the rod; zero at "
            "theta = -4 a T/(1 - a^2)",
            discrete.low_frequency_limit() - limit,
            *(discrete.value_at_zero(cells) - limit.subs(theta, 0) for cells in (1, 2)),
            discrete.least_multiplier() + 4 * a * T / (1 - a**2),
        ),
    )


def derivation(cells: int = 4, *, form: Form = "corrected") -> tuple[Step, ...]:
    """Replay the paper's derivation, Hamilton's principle to the Popov expression.

    Parameters
    ----------
    cells : int
        Largest number of cells for which the matrices are worked out, from 1 to 12; cost grows like ``N^3``.
    form : {"corrected", "as-printed"}
        ``"as-printed"`` takes the potential energy (1), the weak form (10) and the force in (36) as printed; the steps
        that rest on them then do not hold.  Other misprints are in :func:`lure.rod.derivation.misprints`.

    Returns
    -------
    tuple of Step
        In the order of the paper.  ``step.holds`` for all of them in the corrected form.

    Raises
    ------
    InputError
        ``cells`` is not an integer from 1 to 12, or ``form`` is unknown.

    Notes
    -----
    Exact algebra, no floating point: a zero residual shows the step for the ``N`` named in its title and no other.  For
    every ``N`` at once: multiply row ``i`` by ``y_i`` and telescope (energy), diagonalise the f-circulant matrix (H_N).

    Examples
    --------
    >>> steps = derivation(1)
    >>> steps[9].statement
    'a = (k - Z)/(k + Z), b = 1/(k + Z), d = 1/sqrt(rho E), Z = A sqrt(rho E) (below (33))'
    >>> steps[9].residual
    0
    """
    checked_cells(cells)
    checked_form(form)
    return rod_steps(form) + scheme_steps(cells, form)
