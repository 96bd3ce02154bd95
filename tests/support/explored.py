"""Loops for the page in the browser, and what is asked of each."""

import json
from random import Random

WITHOUT = ("numpy", "scipy", "matplotlib", "sympy", "pydantic", "control", "rich", "typer", "jinja2", "numba", "xarray")


def loops(count, seed=20):
    """Random blocks, numerator and denominator as texts: stable ones with poles of all sizes, some with one at 0."""
    draw = Random(seed)
    found = []
    for _ in range(count):
        den = [1]
        for _ in range(draw.randint(1, 3)):
            if draw.random() < 0.5:
                factor = [1, draw.randint(1, 9)]
            else:
                factor = [1, draw.choice([0.1, 0.5, 1, 3]), draw.randint(1, 12)]
            den = product(den, factor)
        if draw.random() < 0.4:
            den = [*den, 0]
        if draw.random() < 0.05:
            den = product(den, [1, -1])
        num = [draw.randint(-5, 9) for _ in range(draw.randint(1, len(den) - 1))]
        num[-1] = num[-1] or 1
        found.append((" ".join(map(str, num)), " ".join(f"{c:.12g}" for c in den)))
    return found


def product(p, q):
    result = [0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return result


LOOPS = loops(200)


def answers(some):
    """The report of the page on the largest sector of each loop."""
    from lure.analysis.explore.served import respond

    return [json.loads(respond(json.dumps({"ask": "largest", "num": num, "den": den})))["report"] for num, den in some]
