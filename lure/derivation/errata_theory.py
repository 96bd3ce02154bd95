"""Misprints of sections 2 and 3 of the paper: the model and the existence proof."""

from __future__ import annotations

import sympy as sp

from lure.derivation.variation import (
    elastic_energy,
    hamilton,
    strain,
    u,
    velocity,
    velocity_left,
    virtual,
    virtual_left,
    weak_form,
)
from lure.derivation.vocabulary import E, L, Misprint, area, g, gap, k, rho, t, x
from lure.derivation.waves import rest_position

UNIT = ((E, 1), (rho, 1), (k, 1), (area, 1))  # section 3 of the paper says E = k = rho = 1 and uses A = 1


def theory_misprints() -> tuple[Misprint, ...]:
    """The rows (1) to (28): potential energy, sign of the force, Galerkin system, bound, stationary solution."""
    return (_potential_energy(), *_weak_form(), *_galerkin(), *_bounds(), _stationary())


def _potential_energy() -> Misprint:
    modulus = sp.Symbol("kappa")
    # the stiffness kappa of a density kappa u_x^2/2 whose Euler-Lagrange equation is the first line of (7)
    wanted = hamilton().equation.coeff(u.diff(x, 2))
    stiffness = sp.solve(wanted + modulus, modulus)[0]
    return Misprint(
        where="(1)",
        printed=elastic_energy("as-printed"),
        corrected=stiffness * strain**2 / 2,
        explanation="A sigma^2/2 with sigma = E u_x is not an energy per length; (7) is the Euler-Lagrange equation of "
        "A E u_x^2/2 only.",
    )


def _weak_form() -> tuple[Misprint, ...]:
    printed, corrected = (weak_form(form).left.subs(UNIT) for form in ("as-printed", "corrected"))
    with_area = weak_form().left.subs(UNIT[:3]) / area  # divided by rho A, as (10) is
    force, y = sp.Function("g"), sp.Symbol("y", real=True)
    impulse = sp.Integral(force(y), (y, 0, t))

    def in_time(rate: sp.Expr) -> sp.Expr:
        """The rate as it acts in time."""
        displacement = sp.Symbol("u(t,0)", real=True) - sp.Symbol("u0(0)", real=True)
        return rate.diff(velocity_left) * displacement + rate.diff(g) * impulse

    return (
        Misprint(
            where="(10), (20)",
            printed=printed,
            corrected=corrected,
            explanation="(8) gives A E u_x(t,0) = k u_t(t,0) - g, so the force has the opposite sign of the dashpot; "
            "(15) has it right.",
        ),
        Misprint(
            where="(10), constants",
            printed=corrected,
            corrected=with_area,
            explanation="E = k = rho = 1 leaves 1/A beside the dashpot, g and f. The text does not set A = 1; with it "
            "k equals Z, that is a = 0: one rod, not all of them. The existence proof does not depend on it.",
        ),
        Misprint(
            where="(11)",
            printed=in_time(printed),
            corrected=in_time(corrected),
            explanation="The sign of g in (10), integrated in time.",
        ),
        Misprint(
            where="(25)",
            printed=in_time(printed).subs(impulse, force(t)),
            corrected=in_time(corrected),
            explanation="(25) should be (11) with v = w_j: besides the sign, g(t) stands where its integral belongs.",
        ),
    )


def _galerkin() -> tuple[Misprint, ...]:
    first, second = sp.Function("a_m1")(t), sp.Function("a_m2")(t)
    w1, w2 = sp.Function("w1")(x), sp.Function("w2")(x)
    stiffness, end = sp.Symbol("<w2_x,w1_x>"), sp.Symbol("w1(0)")
    interior = weak_form().interior.subs(UNIT).subs({u: first * w1 + second * w2, virtual: w1}).doit()
    amplitude = sp.expand(interior).coeff(w2.diff(x) * w1.diff(x))
    return (
        Misprint(
            where="(14), second sum",
            printed=second.diff(t) * stiffness,
            corrected=amplitude * stiffness,
            explanation="<u_x, v_x> is linear in a_mj, not in its derivative; (15) has it right. Written for one "
            "pair j, i.",
        ),
        Misprint(
            where="(14), force",
            printed=g * end,
            corrected=weak_form().left.subs({velocity_left: 0, virtual_left: end}),
            explanation="The sign of g in (10).",
        ),
    )


def _bounds() -> tuple[Misprint, Misprint]:
    kinetic, bound = sp.symbols("int(u_t^2) E_m", positive=True)
    motion = sp.Function("u_m")(t, x)
    density = (rho * area * velocity**2 / 2 + elastic_energy()).subs(UNIT)  # of E_m, without the obstacle
    moving = (2 * density.subs(strain, 0)).subs(velocity, motion.diff(t))
    return (
        Misprint(
            where="end of the proof of Lemma 3.2",
            printed=bound,
            corrected=sp.solve(kinetic / 2 - bound, kinetic)[0],
            explanation="E_m contains half the integral of u_t^2, so the bound on the integral itself is twice the "
            "bound on E_m, and the same for u_x^2. The lemma survives.",
        ),
        Misprint(
            where="end of the proof of Lemma 3.2, first integral",
            printed=sp.Integral(motion**2, (x, 0, L)),
            corrected=sp.Integral(moving, (x, 0, L)),
            explanation="A dot is missing: E_m knows the velocity and the strain and not the displacement. A rod at "
            "rest at u = C, short of the obstacle, has E_m = 0, and the integral of u^2 is C^2 L. A bound on u itself "
            "follows by integrating u_t in time.",
        ),
    )


def _stationary() -> Misprint:
    return Misprint(
        where="below (28)",
        printed=sp.Symbol("u0(L)", real=True) - gap,
        corrected=rest_position() - gap,
        explanation="With f = g = p = 0 every constant z is stationary; the one the motion reaches for k > 0 follows "
        "from the conserved momentum, and is not the initial one.",
    )
