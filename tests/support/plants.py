"""What the tests of criteria and certificates ask about: published plants, random ones, and their exact values."""

from fractions import Fraction

from hypothesis import strategies as st

from lure.plants.rational import RationalPlant


def block(numerator, denominator, dt=None):
    """The block of exact coefficients, given as a list or as one text with spaces between them."""
    sides = (side.split() if isinstance(side, str) else side for side in (numerator, denominator))
    return RationalPlant(*([Fraction(str(c)) for c in side] for side in sides), dt=dt)


def discrete(numerator, denominator):
    return block(numerator, denominator, dt=1)


# J. Carrasco, W. P. Heath, J. Zhang, N. S. Ahmad, S. Wang, Convex searches for discrete-time Zames-Falb multipliers
# (2019), by the number of the example
DISCRETE = {
    1: discrete("0.1 0", "1 -1.8 0.81"),
    2: discrete("1 -1.95 0.9 0.05", "1 -2.8 3.5 -2.412 0.7209"),
    3: discrete("-1 1.95 -0.9 -0.05", "1 -2.8 3.5 -2.412 0.7209"),
    5: discrete("-0.5 0.1", "1 -0.9 0.79 0.089"),
    6: discrete("2 0.92", "1 -0.5 0"),
}
CIRCLE = {1: 0.7934, 2: 0.1984, 3: 0.1379, 5: 1.0273, 6: 0.6510}  # there, the reach of the circle criterion
# the set of Chen and Wen, Park, Turner, Chang, Carrasco and others
CONTINUOUS = {
    1: block("1 -0.2 -0.1", "1 2 1 1"),
    3: block("1 0 0", "1 0.2 6 0.1 1"),
    4: block("-1 0 0", "1 0.2 6 0.1 1"),
    5: block("1 0 0", "1 0.0003 10 0.0021 9"),
    6: block("-1 0 0", "1 0.0003 10 0.0021 9"),
    7: block("1 0 0", "1 2 2 1"),
}


def value(block, s):
    """``H(s)`` at a rational point, exactly."""
    top, bottom = (
        sum((c * s**n for n, c in enumerate(reversed(side))), Fraction(0))
        for side in (block.numerator, block.denominator)
    )
    return top / bottom


def product(*factors):
    result = [Fraction(1)]
    for factor in factors:
        longer = [Fraction(0)] * (len(result) + len(factor) - 1)
        for i, a in enumerate(result):
            for j, b in enumerate(factor):
                longer[i + j] += a * Fraction(b)
        result = longer
    return result


@st.composite
def stable_plants(draw, *, critical=True):
    """Stable blocks of order 1 to 12, from well damped to nearly on the axis, some with near cancellations."""
    size = st.fractions(Fraction(1, 20), 20, max_denominator=40)
    damping = st.sampled_from([Fraction(1), Fraction(1, 2), Fraction(1, 10), Fraction(1, 1000), Fraction(1, 10**6)])
    bottom, top = [], []
    for _ in range(draw(st.integers(0, 5))):
        w, ratio = draw(size), draw(damping)
        bottom.append([1, 2 * ratio * w, w * w])
        near = draw(st.sampled_from([None, Fraction(1, 10**6), Fraction(1, 10), Fraction(1)]))
        if near is not None:
            top.append([1, 2 * ratio * w * draw(st.sampled_from([1, -1, 2])), w * w * (1 + near)])
    for _ in range(draw(st.integers(0 if bottom else 1, 2))):
        bottom.append([1, draw(size)])
        if draw(st.booleans()):
            top.append([draw(st.sampled_from([1, -1])), draw(size)])
    if critical and draw(st.integers(0, 3)) == 0:
        bottom.append([1, 0])
    gain = draw(st.fractions(-10, 10, max_denominator=20))
    return RationalPlant([gain * c for c in product(*top)], product(*bottom))


# Forms found by the search, with few digits; `taps` of the Zames-Falb multiplier 1.
SIXTH = """79833/10
68373/10 40147/5
66543/10 35344/5 14633/2
40018/5 -40147/5 20349/10 21557/5
3677 12047/2 -31266/5 -10909/2 7911
-32129/10 17092/5 46987/10 30517/10 -57791/10 29028/5"""
ODD = """259
-314 653
249 -556 483
302 209 97 380
-294 59 677 474 604
105 -620 530 432 574 590"""
TURNED = discrete("-1.6 -0.1 0.3", "1 1 0.5 -0.3")
