"""The steps about the scheme: matrices, spectrum, limit, energy and the Popov expression."""

from __future__ import annotations

import sympy as sp

from lure.derivation.energy import Balance, conserved_mean, energy_identity, popov_lyapunov
from lure.derivation.popov import least_multiplier, low_frequency_limit, popov_expression, scheme_delay
from lure.derivation.scheme import Scheme, ring, stated_matrices, upwind_matrices
from lure.derivation.transfer import (
    characteristic_polynomial,
    delay_limit,
    numerical_damping,
    residue_at_zero,
    stated_characteristic_polynomial,
    stated_transfer_function,
    transfer_function,
    value_at_zero,
)
from lure.derivation.vocabulary import (
    IMPEDANCE,
    E,
    Form,
    Step,
    T,
    a,
    area,
    c,
    d,
    k,
    laplace,
    p,
    primitive,
    residual,
    rho,
    s,
    theta,
)
from lure.derivation.waves import boundary_relations, r1, r2, riemann, round_trip


def scheme_steps(cells: int, form: Form) -> tuple[Step, ...]:
    """Steps about the schemes with 1 to ``cells`` cells."""
    schemes = tuple(upwind_matrices(count, form=form) for count in range(1, cells + 1))
    return (*_matrices(schemes), *_limits(), *_balances(schemes), *_popov())


def _matrices(schemes: tuple[Scheme, ...]) -> tuple[Step, ...]:
    upto = f"N = 1..{len(schemes)}"
    return (
        Step(
            title=f"Boundary relations put into the upwind equations, {upto}",
            statement="y1' = -s y1 - s a y_2N + 2 s b g, yi' = s y_i-1 - s y_i, "
            "y_N+1' = s y_N - s y_N+1 + 2 s d mu, z' = y_N + d mu (36)",
            residual=residual(*(entry for scheme in schemes for entry in _entries(scheme))),
        ),
        Step(
            title=f"Transfer function, {upto}",
            statement="c^T (s' I - A)^-1 b1 = (d/s') (1 - a q^2N)/(1 + a q^2N), q = 1/(1 + s'/s)",
            residual=residual(
                *(sp.cancel(transfer_function(one) - stated_transfer_function(one.cells)) for one in schemes)
            ),
        ),
        _any_number_of_cells(),
        Step(
            title=f"Characteristic polynomial, {upto}",
            statement="det(s' I - A) = s' ((s' + s)^2N + a s^2N)",
            residual=residual(
                *(characteristic_polynomial(one) - stated_characteristic_polynomial(one.cells) for one in schemes)
            ),
        ),
        _zero_eigenvalue(schemes),
        Step(
            title=f"CNN matrix of (42), {upto}",
            statement="f-circulant with f = -a: s (K_f - I), K_f the cyclic shift with corner f",
            residual=residual(*(entry for one in schemes for entry in _ring_entries(one.cells))),
        ),
    )


def _any_number_of_cells() -> Step:
    before, cell, delayed = sp.symbols("y_i-1 y_i Q")
    passed = sp.solve(laplace * cell - s * (before - cell), cell)[0]
    return Step(
        title="Transfer function, every N",
        statement="s' y_i = s (y_i-1 - y_i) gives y_i = q y_i-1; with Q = q^2N around the ring "
        "H_N = (d/s') (1 - a Q)/(1 + a Q)",
        residual=residual(
            passed - before / (1 + laplace / s),
            round_trip(delayed) - d / laplace * (1 - a * delayed) / (1 + a * delayed),
        ),
    )


def _entries(scheme: Scheme) -> list[sp.Expr]:
    stated = stated_matrices(scheme.cells)
    pairs = ((scheme.A, stated.A), (scheme.b1, stated.b1), (scheme.b2, stated.b2), (scheme.c, stated.c))
    return [entry for derived, claimed in pairs for entry in derived - claimed]


def _ring_entries(cells: int) -> list[sp.Expr]:
    matrix, shift = ring(cells)
    claimed = s * (shift.subs(sp.Symbol("f", real=True), -a) - sp.eye(2 * cells))
    return list(matrix - claimed)


def _zero_eigenvalue(schemes: tuple[Scheme, ...]) -> Step:
    relations = boundary_relations()
    rho_0 = d * (1 - a) / (1 + a)
    cofactors = (sp.cancel(characteristic_polynomial(one) / laplace).subs(laplace, 0) for one in schemes)
    return Step(
        title="Zero eigenvalue",
        statement="residue d (1 - a)/(1 + a) = A/k; det(s' I - A)/s' at zero is s^2N (1 + a), 1 + a = 2 k/(k + Z): "
        "simple unless k = 0",
        residual=residual(
            *(residue_at_zero(one) - rho_0 for one in schemes),
            rho_0.subs({a: relations.a, d: relations.d}) - area / k,
            *(found - s ** (2 * one.cells) * (1 + a) for found, one in zip(cofactors, schemes, strict=True)),
            1 + relations.a - 2 * k / (k + IMPEDANCE),
        ),
    )


def _limits() -> tuple[Step, ...]:
    size = sp.Symbol("1/N", positive=True)
    return (
        Step(
            title="Infinitely many cells",
            statement="q^2N -> exp(-2 s' T) as N -> inf, s' fixed, s = N/T: H_N -> H_inf",
            residual=residual(delay_limit() - sp.exp(-2 * laplace * T)),
        ),
        Step(
            title="Numerical damping",
            statement="ln q^2N = -2 s' T + (s' T)^2/N + O(1/N^2); at s' = i omega it is -(omega T)^2/N, "
            "which the rod lacks",
            residual=residual(numerical_damping() - (laplace * T) ** 2 * size),
        ),
    )


def _balances(schemes: tuple[Scheme, ...]) -> tuple[Step, ...]:
    upto = f"N = 1..{len(schemes)}"
    y, before = sp.symbols("y prev", real=True)
    pair = riemann().inverse
    cell, speed = c / s, sp.sqrt(E / rho)
    density = area * (rho * pair[0] ** 2 + E * pair[1] ** 2) / 2  # [J/m], in terms of r1 and r2

    def claims(balances: tuple[Balance, ...]) -> sp.Expr:
        """The residual of some balances together."""
        return residual(*(balance.residual for balance in balances))

    return (
        Step(
            title=f"Energy identity of the scheme, {upto}",
            statement="d/dt [sum y_i^2/(2 s) + 2 d P(z)] = -sum (prev_i - y_i)^2/2 + [(2 b g - a y_2N)^2 - y_2N^2]/2",
            residual=claims(tuple(energy_identity(one) for one in schemes)),
        ),
        Step(
            title="Energy identity, every N",
            statement="y_i (prev - y_i) = [prev^2 - y_i^2 - (prev - y_i)^2]/2; the sum telescopes but for both "
            "ends, where (y_N - 2 d p)^2 - y_N^2 = -4 d p z'",
            residual=residual(
                y * (before - y) - (before**2 - y**2 - (before - y) ** 2) / 2,
                (y - 2 * d * p) ** 2
                - y**2
                + 4 * d * p * boundary_relations().tip.subs(r1, y).subs(rho, 1 / (E * d**2)),
            ),
        ),
        Step(
            title="Energy identity in joules",
            statement="A (rho v^2 + E w^2)/2 = rho A (r1^2 + r2^2)/4; Z/2 [sum y_i^2/(2 s) + 2 d P] = "
            "h sum rho A y_i^2/4 + A P, h = c/s",
            residual=residual(
                density.subs(c, speed) - rho * area * (r1**2 + r2**2) / 4,
                (IMPEDANCE / 2 * y**2 / (2 * s) - cell * rho * area * y**2 / 4).subs(c, speed),
                IMPEDANCE / 2 * 2 * boundary_relations().d * primitive - area * primitive,
            ),
        ),
        Step(
            title=f"Conserved mean, {upto}",
            statement="zeta = z + (sum_{i<=N} y_i - a sum_{i>N} y_i)/(s (1 + a)): zeta' = -rho_0 p + g/k",
            residual=claims(tuple(conserved_mean(one) for one in schemes)),
        ),
        Step(
            title=f"Popov-Lyapunov function, {upto}",
            statement="V = theta/(2 s d) sum y_i^2 + 2 theta P(z) + zeta^2/rho_0: V' = -(theta/d) D - 2 zeta p, g = 0",
            residual=claims(tuple(popov_lyapunov(one) for one in schemes)),
        ),
    )


def _popov() -> tuple[Step, ...]:
    limit = 4 * a * d * T / (1 + a) ** 2 + theta * d * (1 - a) / (1 + a)
    return (
        Step(
            title="Popov expression",
            statement="Re[(1 + i w theta) H(i w)] = "
            "d [2 a r sin(psi)/w + theta (1 - a^2 r^2)]/(1 + a^2 r^2 + 2 a r cos(psi)), q^2N = r exp(-i psi)",
            residual=residual(popov_expression().residual),
        ),
        Step(
            title="r and psi of the scheme",
            statement="q = cos(chi) exp(-i chi), tan(chi) = w/s: r = (1 + w^2/s^2)^-N, psi = 2 N atan(w/s)",
            residual=residual(scheme_delay().residual),
        ),
        Step(
            title="Frequency zero",
            statement="the limit is 4 a d T/(1 + a)^2 + theta d (1 - a)/(1 + a), for N = 1, 2 and the rod; zero at "
            "theta = -4 a T/(1 - a^2)",
            residual=residual(
                low_frequency_limit() - limit,
                *(value_at_zero(cells) - limit.subs(theta, 0) for cells in (1, 2)),
                least_multiplier() + 4 * a * T / (1 - a**2),
            ),
        ),
    )
