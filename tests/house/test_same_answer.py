"""The same plant has the same answer in whatever form it is given: verdict, bracket and sentence."""

import random
from fractions import Fraction

import control
import numpy as np
import pytest
from depth import sampled
from scipy import signal

from lure import RationalPlant, as_plant
from lure.analysis import analyse, max_sector, max_slope
from lure.files import parse_system
from lure.files.builtin import builtin_loop, loop_names
from lure.plants.realisation import companion


def listed(values):
    return [str(value) for value in values]


def formula(coefficients, letter):
    degree = len(coefficients) - 1
    return " + ".join(f"({value})*{letter}^{degree - i}" for i, value in enumerate(coefficients))


def matrices(block, *, mixed):
    """The companion form, or the same in coordinates ``T x`` with ``T = I + N`` of integers, ``N^2 = 0``."""
    form, n = companion(block), block.order
    A, B, C = np.array(form.A, dtype=object), np.array(form.b, dtype=object), np.array(form.c, dtype=object)
    if mixed:
        N = np.zeros((n, n), dtype=object)
        N[n // 2 :, : n // 2] = [[(i - j) % 3 - 1 for j in range(n // 2)] for i in range(n - n // 2)]
        one = np.array([[int(i == j) for j in range(n)] for i in range(n)], dtype=object)
        A, B, C = (one + N) @ A @ (one - N), (one + N) @ B, C @ (one - N)
    return A.tolist(), B.tolist(), C.tolist(), form.d


def toml(block, **keys):
    step = [] if block.dt is None else [f"dt = {float(block.dt)}"]
    lines = ["[plant]", *(f"{key} = {value}" for key, value in keys.items()), *step]
    return parse_system("\n".join(lines), name="loop", source="a file").block


def exact_forms(block):
    """Forms that hold every rational number."""
    top, bottom, dt = block.numerator, block.denominator, block.dt
    text = f"({formula(top, block.variable)})/({formula(bottom, block.variable)})"
    yield "coefficients", as_plant((top, bottom), dt=dt)
    yield "texts of coefficients", as_plant((" ".join(listed(top)), " ".join(listed(bottom))), dt=dt)
    yield "formula", as_plant(text, dt=dt)
    yield "file with a formula", toml(block, transfer=f'"{text}"')
    yield "file with coefficients", toml(block, num=listed(top), den=listed(bottom))
    if block.order:
        for mixed in (False, True):
            A, B, C, D = matrices(block, mixed=mixed)
            yield f"matrices, mixed {mixed}", as_plant((A, B, C, D), dt=dt)
            rows = [listed(row) for row in A]
            yield f"file, mixed {mixed}", toml(block, A=rows, B=listed(B), C=listed(C), D=f'"{D}"')


def float_forms(block):
    """Objects of python-control and scipy, which hold doubles."""
    top, bottom = ([float(c) for c in side] for side in (block.numerator, block.denominator))
    step = {} if block.dt is None else {"dt": float(block.dt)}
    yield "control.tf", as_plant(control.tf(top, bottom, *step.values()))
    yield "scipy.signal.TransferFunction", as_plant(signal.TransferFunction(top, bottom, **step))
    if block.order:
        for mixed in (False, True):
            A, B, C, D = (np.array(part, dtype=float) for part in matrices(block, mixed=mixed))
            parts = (A, B[:, None], C[None, :], [[float(D)]])
            yield f"control.ss, mixed {mixed}", as_plant(control.ss(*parts, *step.values()))
            yield f"scipy.signal.StateSpace, mixed {mixed}", as_plant(signal.StateSpace(*parts, **step))


def random_block(seed):
    """Integer and dyadic coefficients, order 1 to 5; poles at 0 and common factors happen."""
    draw = random.Random(seed)
    n = draw.randint(1, 5)
    bottom = [Fraction(1)]
    for _ in range(n):  # real poles, most of them stable; some at 0, hidden or not
        pole = Fraction(draw.choice([-4, -3, -2, -2, -1, -1, -1, 0, 1]), draw.choice([1, 2]))
        bottom = [a - pole * b for a, b in zip([*bottom, 0], [0, *bottom], strict=True)]
    top = [Fraction(draw.randint(-3, 6), draw.choice([1, 1, 4])) for _ in range(draw.randint(1, n + 1))]
    return RationalPlant(top if any(top) else [1], bottom, draw.choice([None, None, Fraction(1, 4)]))


def assert_one_answer(block, forms, question):
    wanted = question(block)
    for name, form in forms:
        assert form == block, name
        found = question(form)
        assert str(found) == str(wanted), name
        assert found.to_dict() == wanted.to_dict(), name


@pytest.mark.parametrize("name", loop_names())
def test_built_in_loops(name):
    block = builtin_loop(name).block
    if isinstance(block, RationalPlant):
        forms = list(exact_forms(block))
        assert [name for name, form in forms if form != block] == []
        assert_one_answer(block, forms[-1:], max_sector)  # the others' answers: for random plants, below


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [range(12), pytest.param(range(12, sampled(24, of=200)), marks=pytest.mark.slow)])
def test_random_plants(seeds):
    for seed in seeds:
        block = random_block(seed)
        assert_one_answer(block, [*exact_forms(block), *float_forms(block)], max_sector)


# phi = 0 leaves solutions that grow, whatever the numerator
@pytest.mark.parametrize("top", [[1], [1, 1]])
def test_a_double_pole_has_one_answer(top):
    block = RationalPlant(top, [1, 0, 0])
    assert_one_answer(block, [*exact_forms(block), *float_forms(block)], max_sector)
    assert max_sector(block).refuted_at == 0


@pytest.mark.slow
def test_the_other_questions_too():
    block = RationalPlant([1], [1, 2, 2, 1])
    forms = [(name, form) for name, form in [*exact_forms(block), *float_forms(block)] if "True" in name]
    assert [name for name, form in forms if form != block] == []
    # equal blocks: of the matrices, of a file of them and of both objects one each in the quick run
    assert_one_answer(block, forms[:: sampled(2, of=1)], lambda it: max_slope(it, search="linear"))
    found = [analyse(form) for _, form in forms[: sampled(1, of=2)]]
    assert {str(each.statement) for each in found} == {str(analyse(block).statement)}
