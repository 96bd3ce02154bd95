"""Nonlinearities made so that their sector and slope bounds are known before anything is computed."""

import random
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

INF = float("inf")


@dataclass(frozen=True, kw_only=True)
class Made:
    """A formula and what is true of it; None where it is not known in advance."""

    text: str
    on: tuple | None = None
    sector: tuple | None = None
    slope: tuple | None = None
    exact: bool = False


def numbers(source, count, *, among=24):
    """Different decimals with at most two digits behind the point, in ascending order."""
    return sorted(Fraction(n, 4) for n in source.sample(range(-among, among + 1), count))


def piecewise_linear(source):
    """``s0 x + sum d_i (max(x - k_i, 0) - max(-k_i, 0))``: the slopes are the partial sums of ``s0, d_1, ...``."""
    knots = numbers(source, source.randint(1, 5))
    slopes = [Fraction(source.randint(-12, 12), 4) for _ in range(len(knots) + 1)]
    text = f"({slopes[0]})*x"
    for knot, (before, after) in zip(knots, pairwise(slopes), strict=True):
        text += f" + ({after - before})*(max(x - ({knot}), 0) - {max(-knot, Fraction(0))})"

    def value(x):
        return slopes[0] * x + sum(
            (b - a) * (max(x - k, 0) - max(-k, Fraction(0))) for k, (a, b) in zip(knots, pairwise(slopes), strict=True)
        )

    on = None if source.random() < 0.5 else (Fraction(-source.randint(1, 8)), Fraction(source.randint(1, 8)))
    low, high = on or (-INF, INF)
    inside = [k for k in knots if low < k < high]
    # phi(x)/x is monotone between kinks, 0 and the ends, where it is read off; slopes count where the domain is
    used = [s for s, (a, b) in zip(slopes, pairwise([-INF, *knots, INF]), strict=True) if a < high and b > low]
    ends = [slopes[0], slopes[-1]] if on is None else [value(x) / x for x in on]
    tiny = Fraction(1, 10**6)
    chords = [value(x) / x for x in (*(k for k in inside if k != 0), tiny, -tiny)] + ends
    return Made(text=text, on=on, sector=(min(chords), max(chords)), slope=(min(used), max(used)), exact=True)


def expanded(roots, lead):
    """Ascending coefficients of ``lead prod (x - r)``."""
    coefficients = [lead]
    for root in roots:
        coefficients = [
            (coefficients[i - 1] if i else 0) - (root * coefficients[i] if i < len(coefficients) else 0)
            for i in range(len(coefficients) + 1)
        ]
    return coefficients


def integral(coefficients):
    """Ascending coefficients of the primitive that vanishes at 0."""
    return [Fraction(0), *(c / (i + 1) for i, c in enumerate(coefficients))]


def at(coefficients, x):
    return sum(c * x**i for i, c in enumerate(coefficients))


def written(coefficients):
    return " + ".join(f"({c})*x**{i}" for i, c in enumerate(coefficients) if c) or "0*x"


def polynomial(source):
    """The chord, or the slope, is a polynomial with chosen turning points, and is read off there and at the ends."""
    roots = numbers(source, source.randint(1, 4), among=8)
    lead = Fraction(source.choice([-3, -1, 1, 2]), source.choice([1, 2, 4]))
    chosen = integral(expanded(roots, lead))
    chosen[0] = Fraction(source.randint(-8, 8), 2)
    on = (Fraction(-source.randint(1, 12), 4), Fraction(source.randint(1, 12), 4))
    values = [at(chosen, x) for x in (*on, *(r for r in roots if on[0] < r < on[1]))]
    bounds = (min(values), max(values))
    if source.random() < 0.5:  # phi = x chord
        return Made(text=written([Fraction(0), *chosen]), on=on, sector=bounds, exact=True)
    return Made(text=written(integral(chosen)), on=on, slope=bounds, exact=True)


def rational(source):
    """``x (m + c/(1 + d (x - r)^2))``: the chord runs from ``m``, at infinity only, to ``m + c`` at ``r``."""
    m, c = (Fraction(source.randint(1, 16), 4) for _ in range(2))
    m, d = source.choice([m, -m, Fraction(0)]), Fraction(source.randint(1, 40), 8)
    r, sign = Fraction(source.randint(-12, 12), 4), source.choice([1, -1])
    text = f"x*(({m}) + ({sign * c})/(1 + ({d})*(x - ({r}))**2))"
    return Made(text=text, sector=(min(m, m + sign * c), max(m, m + sign * c)), exact=True)


def saturating(source):
    """``g x + sum a_i f_i(b_i x)``, each ``f_i`` with its largest slope 1 at 0 and its least, 0, at infinity."""
    g = Fraction(source.randint(-8, 8), 4)
    text, total = f"({g})*x", Fraction(0)
    for _ in range(source.randint(1, 2)):
        a, b = Fraction(source.randint(1, 12), 4), Fraction(source.randint(1, 20), 4)
        f = source.choice(["tanh({})", "atan({})", "({0})/sqrt(1 + ({0})**2)", "min(max({}, -1), 1)"])
        text, total = f"{text} + ({a})*{f.format(f'({b})*x')}", total + a * b
    return Made(text=text, sector=(g, g + total), slope=(g, g + total))


def sine(source):
    """``g x + a sin(b x)``: slopes ``g +- a b``; the chord is largest at 0."""
    g, a, b = (Fraction(source.randint(1, 12), 4) for _ in range(3))
    least = Fraction("-0.217233628211221657408279325562")  # of sin(u)/u, where tan(u) = u = 4.49340945790906...
    sector = (g + a * b * least, g + a * b)
    return Made(text=f"({g})*x + ({a})*sin(({b})*x)", sector=sector, slope=(g - a * b, g + a * b))


def scaled(made, source):
    """``p phi(q x) + g x``: the bounds are multiplied by ``p q`` and moved by ``g``, the interval divided by ``q``."""
    p, q = (Fraction(source.choice([-3, -1, 1, 2]), source.choice([1, 2])) for _ in range(2))
    g = Fraction(source.randint(-4, 4))

    def moved(bounds):
        return None if bounds is None else tuple(sorted(p * q * x + g for x in bounds))

    return Made(
        text=f"({p})*({made.text.replace('x', f'(({q})*x)').replace(f'ma(({q})*x)', 'max')}) + ({g})*x",
        on=None if made.on is None else tuple(sorted(x / q for x in made.on)),
        sector=moved(made.sector),
        slope=moved(made.slope),
        exact=made.exact,
    )


def nonlinearities(seed, **counts):
    """Nonlinearities of each kind, as many as asked for, a third of them scaled and shifted."""
    source = random.Random(seed)
    for kind, count in counts.items():
        for _ in range(count):
            made = globals()[kind](source)
            yield scaled(made, source) if source.random() < 0.3 and len(made.text) < 250 else made
