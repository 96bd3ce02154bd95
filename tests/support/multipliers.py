"""What the tests of Zames-Falb multipliers share: the inequality in doubles, and random blocks."""

from fractions import Fraction as F

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from lure.plants.rational import RationalPlant


def samples(system, extra=()):
    """Frequencies on a logarithmic grid and, closer and closer, around every pole."""
    poles = np.roots([float(c) for c in system.denominator])
    sizes = np.abs(poles)
    parts = [[0.0], np.geomspace(sizes.min() * 1e-4, sizes.max() * 1e4, 20_001), extra]
    for pole in poles:
        away = abs(pole.real) * np.geomspace(1e-3, 1e3, 600)
        parts += [abs(pole.imag) + away, abs(pole.imag) - away]
    omega = np.unique(np.concatenate(parts))
    return omega[omega >= 0]


def left_hand_side(system, k, multiplier, omega):
    """The inequality written out from the definition, in floating point."""
    H = system.transfer(1j * omega)
    return (multiplier.at(omega) * (H + 1 / float(k)) + 1j * omega * float(multiplier.theta) * H).real


@st.composite
def stable_blocks(draw, most=4):
    """Poles from well damped to nearly on the axis, zeros anywhere."""
    number = st.integers(1, 40)
    d = np.array([F(1)])
    while len(d) - 1 < draw(st.integers(1, most)):
        if draw(st.booleans()) and len(d) < most:
            damping = draw(st.sampled_from(["1/1000", "1/20", "1/2", "2"]))
            w = F(draw(number)) / 10
            d = np.convolve(d, np.array([F(1), F(damping) * w, w * w]))
        else:
            d = np.convolve(d, np.array([F(1), F(draw(number)) / 10]))
    n = [F(draw(st.integers(-30, 30))) / 10 for _ in range(draw(st.integers(1, len(d))))]
    assume(any(n))
    return RationalPlant(n, list(d))
