"""What several tests compare with: random rods, and the closed forms evaluated in 300-bit balls."""

from fractions import Fraction

from flint import acb, arb, ctx, fmpq
from hypothesis import strategies as st

from lure.rod import Rod
from lure.rod.systems import rod_from_exact

BITS = 300


def decades(low, high):
    """Numbers spread evenly over the decades from 10**low to 10**high."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def ratios():
    """Dampings in units of the impedance, from 1e-6 to 1e3."""
    return decades(-6, 3)


@st.composite
def rods(draw, ratio=None):
    """Rods of any material and size; the damping is ``ratio`` impedances."""
    material = {
        "youngs_modulus": draw(decades(3, 12)),
        "density": draw(decades(-1, 5)),
        "length": draw(decades(-3, 3)),
        "area": draw(decades(-8, 1)),
        "compliance": draw(decades(-9, 3)),
    }
    impedance = Rod(damping=0.0, **material).impedance
    return Rod(damping=(draw(ratios()) if ratio is None else ratio) * impedance, **material)


def with_damping(rod, damping):
    """The same rod with another damping, all other parameters kept exact."""
    return rod_from_exact({**rod.exact, "damping": Fraction(damping)})


def real(value):
    value = Fraction(value)
    return arb(fmpq(value.numerator, value.denominator))


def point(s):
    """The complex double as a ball of radius zero."""
    s = complex(s)
    return acb(real(s.real), real(s.imag))


class Exact:
    """Constants of a rod and its transfer functions in balls; make and use it inside ``at_high_precision``."""

    def __init__(self, rod):
        exact = {name: real(value) for name, value in rod.exact.items()}
        root = (exact["density"] * exact["youngs_modulus"]).sqrt()
        self.k, self.Z = exact["damping"], exact["area"] * root
        self.c = (exact["youngs_modulus"] / exact["density"]).sqrt()
        self.T = exact["length"] / self.c
        self.a = (self.k - self.Z) / (self.k + self.Z)
        self.b = 1 / (self.k + self.Z)
        self.d = 1 / root

    def ring(self, s, cells):
        """``q^{2N}``, or ``e^{-2sT}`` for the rod (``cells=None``)."""
        if cells is None:
            return (-2 * point(s) * self.T).exp()
        return (1 + point(s) * self.T / cells) ** (-2 * cells)

    def transfer(self, s, cells):
        turn = self.a * self.ring(s, cells)
        return self.d / point(s) * (1 - turn) / (1 + turn)

    def sensitivity(self, s, cells):
        """Relative change of H for a change of 1 of the phase (relative) or of k/Z: what rounding the inputs costs."""
        ring = self.ring(s, cells)
        turn = self.a * ring
        phase = 1 + 2 * abs(complex(point(s) * self.T))
        slope = abs(complex(2 / (1 - turn * turn)))
        return phase * (1 + slope * abs(complex(turn))) + slope * abs(complex(ring * (1 - self.a * self.a)))


def at_high_precision(function, *arguments):
    before = ctx.prec
    ctx.prec = BITS
    try:
        return function(*arguments)
    finally:
        ctx.prec = before


def relative_error(value, exact):
    """Distance of a double from an exact ball, relative to the ball."""
    return float(abs(point(value) - exact) / abs(exact))


def real_part_error(value, exact):
    """Distance of the real part of a double from that of a ball, relative to the latter alone."""
    return float(abs(real(complex(value).real) - exact.real) / abs(exact.real))
