"""Misprints of sections 4 and 5 of the paper: the scheme, its initial data and the simulation."""

from __future__ import annotations

import sympy as sp

from lure.derivation.scheme import mu, printed_input, ring, upwind_matrices
from lure.derivation.vocabulary import L, Misprint, a, b, c, d, gap, p, x
from lure.derivation.waves import r1, r2, riemann, v, w

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
