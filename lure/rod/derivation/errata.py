"""The misprint table: every formula of the paper that its own premises contradict, as a difference that is not zero."""

from __future__ import annotations

import sympy as sp

from lure.rod.derivation.rod import (
    elastic_energy,
    hamilton,
    r1,
    r2,
    rest_position,
    riemann,
    strain,
    u,
    v,
    velocity,
    velocity_left,
    virtual,
    virtual_left,
    w,
    weak_form,
)
from lure.rod.derivation.scheme import mu, printed_input, ring, upwind_matrices
from lure.rod.derivation.vocabulary import E, L, Misprint, a, area, b, c, d, g, gap, k, p, rho, t, x

# Misprints of sections 2 and 3 of the paper: the model and the existence proof.

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


# Misprints of sections 4 and 5 of the paper: the scheme, its initial data and the simulation.

CELLS = 2  # the rows are written for N = 2, so that y_N = xi1^2 and y_{N+1} = xi2^1


def numerics_misprints() -> tuple[Misprint, ...]:
    """The rows (36) to (50): force, contact input, initial data, tip equation, circulant, initial displacement."""
    return (*_inputs(), *_initial_data(), _tip(), _circulant(), *_compressed_rod())


def _inputs() -> tuple[Misprint, ...]:
    scheme = upwind_matrices(CELLS)
    free = scheme.A * sp.Matrix(scheme.state)
    pulled = free + printed_input(CELLS) * -p
    right = scheme.rates()
    return (
        Misprint(
            where="(36) row 1, (38) b2, (47) I_1",
            printed=upwind_matrices(CELLS, form="as-printed").rates()[0],
            corrected=right[0],
            explanation="xi1^0 of (35) enters (34) multiplied by s: the force comes in as 2 s b g.",
        ),
        Misprint(
            where="(38) b1, row N+1",
            printed=pulled[CELLS],
            corrected=right[CELLS],
            explanation="mu = -p already carries the minus sign; with b1 = [-2sd -d] contact pulls. (36) has it right.",
        ),
        Misprint(
            where="(38) b1, row 2N+1",
            printed=pulled[2 * CELLS],
            corrected=right[2 * CELLS],
            explanation="As in row N+1.",
        ),
    )


def _initial_data() -> tuple[Misprint, ...]:
    v0, v_tip, w0, w_tip = (sp.Symbol(name, real=True) for name in ("u1(0)", "u1(L)", "u0_x(0)", "u0_x(L)"))
    force, contact = sp.Symbol("g(0)", real=True), sp.Symbol("p(z(0))", real=True)
    names = sp.symbols("v w")
    forward, backward = (
        sp.Add(*(r.coeff(field) * name for field, name in zip((v, w), names, strict=True)))
        for r in riemann().invariants
    )
    at_tip = forward.subs({names[0]: v_tip, names[1]: w_tip})
    at_left = forward.subs({names[0]: v0, names[1]: w0})
    reflected = sp.solve(r1 + a * r2 - 2 * b * force, r2)[0].subs(r1, at_left)  # first line of (35)
    return (
        Misprint(
            where="(37) xi1^N",
            printed=v_tip - c * w_tip + 2 * d * contact,
            corrected=at_tip,
            explanation="(33) gives r1(0,L) with no extra term. For matched data (35) gives the same as "
            "u1(L) + c u0_x(L) + 2 d p, of which the printed line has the wrong sign before c.",
        ),
        Misprint(
            where="(37) xi2^0",
            printed=-v0 + c * w0 + 2 * b / a * force,
            corrected=sp.expand(reflected),
            explanation="Solving (35) for xi2^0 divides all of it by a; for matched data simply "
            f"{backward.subs({names[0]: v0, names[1]: w0})}.",
        ),
    )


def _tip() -> Misprint:
    scheme = upwind_matrices(CELLS)
    return Misprint(
        where="(43)",
        printed=scheme.state[CELLS - 1] + p,
        corrected=scheme.rates(mu)[-1].subs(mu, -p),
        explanation="The last line of (36): contact slows the tip down, with the factor d that makes p a velocity.",
    )


def _circulant() -> Misprint:
    matrix, _ = ring(CELLS)
    return Misprint(
        where="end of section 4.2, 'circulant'",
        printed=matrix[1, 0],
        corrected=matrix[0, 2 * CELLS - 1],
        explanation="Entry (1, 2N) of the CNN matrix for (42): the circulant with the same first column has s there, "
        "the matrix has -s a. They agree only for a = -1, that is k = 0; in general it is f-circulant with f = -a.",
    )


def _compressed_rod() -> tuple[Misprint, ...]:
    e, offset = sp.symbols("e C", real=True)
    at_tip = {x: L, L: 1}
    printed = 1 + e / 2 - e * x
    # uniform strain -e, released at rest; the middle of the rod stays where it is
    symmetric = sp.integrate(-e, x) + offset
    displacement = symmetric.subs(offset, sp.solve(symmetric.subs(x, L / 2), offset)[0]).subs(L, 1)
    shift = sp.expand(printed - displacement)
    forward_at_tip = -c * displacement.diff(x)
    return (
        Misprint(
            where="(50)",
            printed=printed,
            corrected=sp.expand(displacement),
            explanation="The printed line adds the position x = 1: u is a displacement, and figure 6 starts at -e/2, "
            "not at 1 - e/2.",
        ),
        Misprint(
            where="(50), gap",
            printed=gap,
            corrected=gap - shift,
            explanation="The obstacle is measured from the same origin: l = 1.02 m means a gap of 0.02 m. "
            "z, and so the motion, is the same; the pair must be corrected together.",
        ),
        Misprint(
            where="section 5, u0(1) = xi1^N(0)",
            printed=forward_at_tip,
            corrected=displacement.subs(at_tip).subs(L, 1),
            explanation="xi1^N(0) is a velocity, c e = 1.2 m/s for the printed values, not the displacement "
            "-e/2 = -1e-4 m.",
        ),
    )


def misprints() -> tuple[Misprint, ...]:
    """Misprints of the paper in the order of its equations.

    Each ``corrected`` comes out of the derivation, each ``printed`` is copied from the paper, and ``difference`` is
    computed from the two.  A statement about numbers (such as the same results for ``h = 1/10`` and ``h = 1/200``) has
    no symbolic difference and is not here.

    Returns
    -------
    tuple of Misprint
        Sections 2 and 3 of the paper, then 4 and 5.

    Examples
    --------
    >>> print(misprints()[0].difference)
    A*E*u_x**2*(E - 1)/2
    """
    return theory_misprints() + numerics_misprints()
