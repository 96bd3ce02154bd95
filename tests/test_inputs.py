"""Whatever describes a linear system becomes a block, exactly; whatever does not is refused in one sentence."""

import math
from decimal import Decimal
from fractions import Fraction

import control
import numpy as np
import pytest
import scipy.signal
from flint import fmpq, fmpq_mat
from hypothesis import given
from hypothesis import strategies as st

from lure import LinearBlock, builtin_system, upwind
from lure.delay import DelayBlock
from lure.errors import InputError
from lure.expressions import Expression
from lure.frequency_data import FrequencyData
from lure.inputs import as_block, coefficients, parse_transfer, rational_block, sampling_time
from lure.inputs.roots import polynomial_of_roots
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock

F = Fraction
COMPANION = ([[0, 1], [-2, -3]], [0, 1], [1, 0])  # 1/(s^2 + 3 s + 2)


def refusal(make, *arguments, **options):
    """The sentence, after the checks that hold for every refusal: one line, printable, of a readable length."""
    with pytest.raises(InputError) as caught:
        make(*arguments, **options)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 420
    return message


def value(block, s):
    """``H(s)`` at a rational point, exactly."""
    top, bottom = (
        sum((c * s**n for n, c in enumerate(reversed(side))), F(0)) for side in (block.numerator, block.denominator)
    )
    return top / bottom


# coefficients


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1 3 2 0", [1, 3, 2, 0]),
        ("[1, 3,2 ,0]", [1, 3, 2, 0]),
        ("(1,-.5)", [1, F(-1, 2)]),
        ("1/3 -2/7", [F(1, 3), F(-2, 7)]),
        ("0.1 1e-3 +2.", [F(1, 10), F(1, 1000), 2]),
        ("0.5/0.3", [F(5, 3)]),
        ("  7\t8\n9 ", [7, 8, 9]),
    ],
)
def test_coefficients_are_read_exactly(text, values):
    assert coefficients(text) == tuple(values)


def test_a_list_may_mix_numbers_and_texts_and_a_float_is_the_double_it_is():
    assert coefficients([1, 0.1, F(1, 3), Decimal("0.1"), "2/3", np.int64(4), 2 + 0j]) == (
        1,
        F(3602879701896397, 2**55),
        F(1, 3),
        F(1, 10),
        F(2, 3),
        4,
        2,
    )


@pytest.mark.parametrize(
    ("given_", "said"),
    [
        ("", "is empty"),
        ("[]", "is empty"),
        ([], "is empty"),
        ("1,,2", "nothing before or after a comma"),
        ("[1 2", "close the bracket '\\['"),
        ("1 x", r"\[1\] is 'x'; give a number such as 2"),
        ("1;2", "give a number such as 2"),
        ("1/0", "division by zero"),
        ("nan", "give a number such as 2"),
        ("1e400", "outside the range of double precision"),
        ("1e99999999999", "exponent beyond 400"),
        ("-- 1", "give a number such as 2"),
        ([1, math.nan], r"\[1\] is nan; give a finite number"),
        ([math.inf], r"\[0\] is inf; give a finite number"),
        ([1, 1j], "complex coefficient"),
        ([[1, 2]], "one input and one output"),
        ([True], "give a number"),
        ([None], "give a number"),
        (3, "give a list of numbers"),
        (np.array(3.0), "give a list of numbers"),
        ("1 " * 1002, "stop at degree 1000"),
        ("1" * 70000, "at most 65536"),
    ],
)
def test_what_is_no_list_of_coefficients_is_refused(given_, said):
    with pytest.raises(InputError, match=said):
        coefficients(given_)


@given(st.lists(st.fractions(), min_size=1, max_size=8))
def test_fractions_survive_the_way_through_text(values):
    kept = [v for v in values if v == 0 or 1e-300 < abs(v) < 1e300]
    if kept:
        assert coefficients(" ".join(str(v) for v in kept)) == tuple(kept)


# formulas


@pytest.mark.parametrize(
    ("text", "top", "bottom"),
    [
        ("1/(s*(s+1)*(s+2))", [1], [1, 3, 2, 0]),
        ("(s+2)/(s^2+s)", [1, 2], [1, 1, 0]),
        ("2 s (s+1)/(3s^3 + 0.5)", [2, 2, 0], [3, 0, 0, F(1, 2)]),
        ("-s^2/(s+1)**2", [-1, 0, 0], [1, 2, 1]),
        ("3", [3], [1]),
        ("(s^2 + 1)/(s^2 + 0.1 s + 1)", [1, 0, 1], [1, F(1, 10), 1]),
        ("2 - 1/(s+1)", [2, 1], [1, 1]),
        ("s^-1", [1], [1, 0]),
        ("1e-3/(s+1/3)", [F(1, 1000)], [1, F(1, 3)]),
        ("1/(s+1)^(2)", [1], [1, 2, 1]),
        ("1/-s", [-1], [1, 0]),
    ],
)
def test_a_formula_is_the_block_it_says(text, top, bottom):
    assert parse_transfer(text) == RationalBlock(top, bottom)


# Factors written in one fraction are modes of the system described; the denominators of a sum are common ground.
@pytest.mark.parametrize(
    ("text", "top", "bottom"),
    [
        ("(s-1)/((s-1)*(s+2))", [1, -1], [1, 1, -2]),
        ("(s-1)/(s+2) * 1/(s-1)", [1, -1], [1, 1, -2]),
        ("s/(s*(s+1))", [1, 0], [1, 1, 0]),
        ("1/(s-1) - 1/(s-1)", [0], [1, -1]),
        ("0*1/(s-1)", [0], [1, -1]),
        ("1/s + 1/s", [2], [1, 0]),
        ("1/s + 1/(s*(s+1))", [1, 2], [1, 1, 0]),
        ("(1/s)/(1 + 1/s)", [1], [1, 1]),
    ],
)
def test_a_mode_written_out_is_kept_and_none_is_invented(text, top, bottom):
    assert parse_transfer(text) == RationalBlock(top, bottom)


def test_negative_powers_of_z_are_delays_and_bring_no_mode_of_their_own():
    assert parse_transfer("0.1/(1 - 1.8 z^-1 + 0.81 z^-2)") == RationalBlock(
        [F(1, 10), 0, 0], [1, F("-1.8"), F("0.81")], 1
    )


def test_z_means_discrete_time_and_a_period_may_be_given():
    assert parse_transfer("z/(z-0.5)").dt == 1
    assert parse_transfer("z/(z-0.5)", dt=F(1, 10)).dt == F(1, 10)
    assert parse_transfer("z/(z-0.5)", dt=True).dt == 1
    assert parse_transfer("2", dt=True).dt == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the text is empty"),
        ("  ", "the text is empty"),
        ("s^2", "improper"),
        ("1/0", "division by zero at column 2"),
        ("1/(s-s)", "division by zero at column 2"),
        ("(s-s)^-1", "division by zero"),
        ("1/(s+1)(s+2)", "needs \\* and brackets .* at column 8"),
        ("1/2 s", "needs \\* and brackets"),
        ("s+z", "both s and z"),
        ("1/(s+pi)", "pi is irrational"),
        ("1/(s+2j)", "coefficients are real"),
        ("1/(x+1)", "unknown name 'x'"),
        ("1/(p+1)", "write s"),
        ("sin(s)", "unknown name 'sin'"),
        ("(s+1", "to close '\\(' of column 1"),
        ("s+1)", "expected an operator but found '\\)'"),
        ("1 3", "expected an operator but found '3'"),
        ("1/s^1.5", "whole number"),
        ("1/s^s", "whole number"),
        ("1/s^2^3", "power of a power"),
        ("1/(s+1)^1001", "too large"),
        ("1/((s+1)^999*(s+1)^2)", "too large"),
        ("1/(s+12345678)^9999", "too large"),
        ("1/s; 2", "character ';' at column 4"),
        ("1/s \N{MULTIPLICATION SIGN} 2", "is not allowed"),
        ("__import__('os')", "unknown name|not allowed"),
        ("(" * 40 + "s" + ")" * 40, "nested"),
        ("s+" * 5000 + "1", "at most 8192"),
        ("1e999/s", "exponent|outside the range"),
    ],
)
def test_what_is_no_transfer_function_is_refused_with_its_column(text, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_transfer(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(("text", "dt"), [("1/s", 1), ("1/s", True), ("1/z", 0)])
def test_a_variable_that_contradicts_the_sampling_time_is_refused(text, dt):
    assert "the formula is in" in refusal(parse_transfer, text, dt=dt)


FORMULAS = st.recursive(
    st.sampled_from(["s", "1", "2", "0.5", "3", "(s+1)"]),
    lambda inner: st.one_of(
        st.builds("({}+{})".format, inner, inner),
        st.builds("({}-{})".format, inner, inner),
        st.builds("{}*{}".format, inner, inner),
        st.builds("{}/({})".format, inner, inner),
        st.builds("({})^{}".format, inner, st.sampled_from(["2", "3", "-1", "-2"])),
        st.builds("(-{})".format, inner),
    ),
    max_leaves=8,
)


# The other parser of the package, for laws, evaluates the same text as a number; it knows nothing of polynomials.
@given(FORMULAS, st.fractions(-3, 3, max_denominator=7))
def test_a_block_has_the_value_of_its_formula(text, point):
    try:
        block, number = parse_transfer(text), Expression.parse(text.replace("^", "**"), variables=("s",)).exact(s=point)
    except InputError:
        return
    bottom = sum(c * point**n for n, c in enumerate(reversed(block.denominator)))
    if bottom != 0:
        assert value(block, point) == number


@given(
    st.lists(st.fractions(-9, 9, max_denominator=9), min_size=1, max_size=4),
    st.lists(st.fractions(-9, 9, max_denominator=9), min_size=4, max_size=6).filter(lambda d: d[0] != 0),
)
def test_a_block_survives_the_way_through_a_formula(top, bottom):
    def text(side):
        return "+".join(f"({c})*s^{n}" for n, c in enumerate(reversed(side)))

    assert as_block(f"({text(top)})/({text(bottom)})") == RationalBlock(top, bottom)


def test_a_dead_time_makes_a_delay_block_and_one_that_cancels_does_not():
    block = as_block("exp(-0.2*s)/(s*(s+1))")
    assert isinstance(block, DelayBlock)
    assert block.terms[0][0] == F(1, 5)
    assert as_block("exp(0*s)/(s+1)^2") == RationalBlock([1], [1, 2, 1])
    assert "dead time in continuous time" in refusal(as_block, "exp(-s)/(s+1)", dt=1)


# matrices


def test_matrices_become_the_exact_transfer_function():
    assert as_block(COMPANION) == RationalBlock([1], [1, 3, 2])
    assert as_block((*COMPANION, 2)) == RationalBlock([2, 6, 5], [1, 3, 2])
    assert as_block(([["-1/3"]], ["1"], [F(2, 7)])) == RationalBlock([F(2, 7)], [1, F(1, 3)])
    assert as_block((-1, 1, 1)) == RationalBlock([1], [1, 1])
    assert as_block(([], [], [], 2)) == RationalBlock([2], [1])


# Indirect control with r = c = 1: the zero eigenvalue does not reach sigma = xi - x.
def test_a_mode_that_the_output_does_not_see_stays_in_the_block():
    assert as_block(([[-1, 1], [0, 0]], [0, 1], [-1, 1])) == RationalBlock([1, 0], [1, 1, 0])
    assert as_block(([[-1, 0], [0, 5]], [1, 0], [1, 1])) == RationalBlock([1, -5], [1, -4, -5])


ENTRIES = st.integers(-3, 3)


@st.composite
def systems(draw, largest=5):
    n = draw(st.integers(1, largest))
    vector = st.lists(ENTRIES, min_size=n, max_size=n)
    return draw(st.lists(vector, min_size=n, max_size=n)), draw(vector), draw(vector), draw(ENTRIES)


@given(systems(), st.fractions(-5, 5, max_denominator=11))
def test_the_block_of_matrices_has_the_value_of_the_resolvent(system, point):
    A, b, c, d = system
    n = len(A)
    q = fmpq(point.numerator, point.denominator)
    resolvent = fmpq_mat(n, n, [q * (i == j) - A[i][j] for i in range(n) for j in range(n)])
    if resolvent.det() == 0:
        return
    x = resolvent.solve(fmpq_mat(n, 1, b))
    expected = sum((c[i] * x[i, 0] for i in range(n)), fmpq(d))
    found = value(rational_block(A, b, c, d), point)
    assert (found.numerator, found.denominator) == (int(expected.p), int(expected.q))


@given(systems(4), st.integers(-4, 4), st.integers(1, 5))
def test_a_change_of_basis_changes_nothing(system, shear, scale):
    A, b, c, d = (np.array(part, dtype=object) for part in system)
    n = len(b)
    T, inverse = (np.array([[F(int(i == j)) for j in range(n)] for i in range(n)], dtype=object) for _ in range(2))
    T[0, 0], inverse[0, 0] = F(scale), F(1, scale)
    if n > 1:  # T = diag(scale, 1, ...) with shear in the corner, and its inverse
        T[0, n - 1], inverse[0, n - 1] = F(shear), -F(shear, scale)
    assert (T.dot(inverse) == np.eye(n, dtype=int)).all()
    assert rational_block(T.dot(A).dot(inverse), T.dot(b), c.dot(inverse), d.item()) == rational_block(*system)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (([[0, 1]], [0, 1], [1, 0]), "A is not square: it has 1 rows, and A\\[0\\] has 2 entries"),
        (([[0, 1], [2]], [0, 1], [1, 0]), "A\\[1\\] has 1 entries"),
        (([[0, 1], 2], [0, 1], [1, 0]), "mixes numbers and lists"),
        (([[0, 1], [-2, -3]], [0, 1, 2], [1, 0]), "B is 1 x 3 and A is 2 x 2; give 2 entries"),
        (([[0, 1], [-2, -3]], [[0, 1], [1, 0]], [1, 0]), "B has 2 inputs: .* choose a pair, e.g. sys\\[0, 0\\]"),
        (([[0, 1], [-2, -3]], [0, 1], [[1, 0], [0, 1]]), "C has 2 outputs"),
        (([[0, 1], [-2, -3]], [0, 1], [1, 0], [0, 0]), "D has 2 entries"),
        (([[0, math.nan], [-2, -3]], [0, 1], [1, 0]), "A\\[0\\]\\[1\\] is nan; give a finite number"),
        (([[0, 1], [-2, -3]], [0, math.inf], [1, 0]), "B\\[1\\] is inf"),
        (([[0, 1j], [-2, -3]], [0, 1], [1, 0]), "complex coefficient"),
        (([], [], []), "the system is empty"),
        (("1", "1", "1"), "give A as a list of rows"),
        ((1, 2, 3, 4, 5), "a system of 5 parts is unknown"),
        ((1,), "a system of 1 parts is unknown"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(parts, said):
    with pytest.raises(InputError, match=said):
        as_block(parts)


def test_sixty_states_are_exact_and_sixty_one_are_not():
    rng = np.random.default_rng(1)
    for n, kind in ((60, RationalBlock), (61, StateSpaceBlock)):
        A, b, c = rng.standard_normal((n, n)) - 20 * np.eye(n), rng.standard_normal(n), rng.standard_normal(n)
        block = as_block((A, b, c, 0.5))
        assert isinstance(block, kind)
        assert block.order == n
        direct = c @ np.linalg.solve(1j * np.eye(n) - A, b) + 0.5
        assert block.transfer(1j) == pytest.approx(direct, rel=1e-9)


def test_large_matrices_may_be_lists_or_sparse_and_a_limit_is_named():
    A = [[F(-1) * (i == j) for j in range(61)] for i in range(61)]
    assert as_block((A, [1] * 61, [1] * 61)).transfer(0) == pytest.approx(61)
    assert "5001 states" in refusal(as_block, (np.zeros((5001, 1)), [1], [1]))
    assert "not square" in refusal(as_block, (np.zeros((70, 71)), np.ones(70), np.ones(70)))
    scheme = upwind(builtin_system("paper-rod").rod, 40)
    large = as_block(scheme.block)
    assert isinstance(large, StateSpaceBlock)
    assert large.transfer(100j) == pytest.approx(scheme.transfer(100j), rel=1e-9)


# python-control and scipy.signal


def test_objects_of_python_control_are_taken_exactly():
    tenth = F(0.1)
    assert as_block(control.tf([0.1], [1, 3, 2])) == RationalBlock([tenth], [1, 3, 2])
    assert as_block(control.tf([1], [1, 0.5], 0.1)) == RationalBlock([1], [1, F(1, 2)], tenth)
    assert as_block(control.tf([1], [1, 0.5], True)).dt == 1
    assert as_block(control.ss(*map(np.array, ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]], [[2]])))) == RationalBlock(
        [2, 6, 5], [1, 3, 2]
    )
    assert as_block(control.ss([], [], [], [[3]])) == RationalBlock([3], [1])
    assert as_block(control.rss(2, 2, 2)[0, 1]).order == 2


def test_measured_data_stay_data():
    data = as_block(control.frd([1, 2, 3j], [3, 1, 2]))
    assert isinstance(data, FrequencyData)
    assert data.omega.tolist() == [1, 2, 3]
    assert data.response.tolist() == [2, 3j, 1]
    assert not hasattr(data, "transfer")
    assert data.to_control().frdata.ravel().tolist() == [2, 3j, 1]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (lambda: control.rss(2, 2, 2), "2 inputs and 2 outputs: .* choose a pair, e.g. sys\\[0, 0\\]"),
        (lambda: control.rss(2, 1, 2), "2 inputs and 1 outputs"),
        (lambda: control.tf([1, 0, 0], [1, 1]), "improper"),
        (lambda: control.ss([], [], [], [[0]]), "empty"),
        (lambda: control.frd(np.ones((2, 2, 1)), [1]), "2 inputs"),
        (lambda: scipy.signal.StateSpace([[1.0]], [[1.0, 2.0]], [[1.0]], [[0.0, 0.0]]), "B has 2 inputs"),
        (lambda: scipy.signal.ZerosPolesGain([], [-1 + 1j], 1), "without its conjugate"),
        (lambda: scipy.signal.TransferFunction([1, 2, 3], [1, 2]), "improper"),
        (lambda: lambda s: 1 / s, "nothing can be shown with it; give coefficients"),
        (lambda: 3, "3 is no linear block; give coefficients"),
        (lambda: None, "None is no linear block"),
        (lambda: np.array([1, 2]), "is no linear block"),
        (lambda: ([1, 2, 3], [1, 2]), "improper"),
        (lambda: ([1], [0, 0]), "denominator is zero"),
        (lambda: ([[1], [2]], [1, 2]), "one input and one output"),
    ],
)
def test_systems_that_are_no_single_proper_block_are_refused(system, said):
    with pytest.raises(InputError, match=said):
        as_block(system())


def test_objects_of_scipy_are_taken_exactly():
    assert as_block(scipy.signal.lti([1], [1, 2, 3])) == RationalBlock([1], [1, 2, 3])
    assert as_block(scipy.signal.dlti([1], [1, 0.5])) == RationalBlock([1], [1, F(1, 2)], 1)
    assert as_block(scipy.signal.dlti([1], [1, 0.5], dt=0.25)).dt == F(1, 4)
    assert as_block(scipy.signal.lti([], [-1, -2 + 1j, -2 - 1j], 2)) == RationalBlock([2], [1, 5, 9, 5])
    assert as_block(scipy.signal.StateSpace(*map(np.array, ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]], [[0]])))) == (
        RationalBlock([1], [1, 3, 2])
    )
    poles = scipy.signal.butter(5, [0.1, 0.2], "bandpass", output="zpk")
    assert as_block(scipy.signal.ZerosPolesGain(*poles, dt=True)).order == 10


@given(st.lists(st.complex_numbers(max_magnitude=9, allow_nan=False, min_magnitude=1e-3), max_size=4))
def test_roots_multiply_out_to_a_polynomial_that_vanishes_at_them(half):
    roots = [root for one in half for root in ((one, one.conjugate()) if one.imag else (one,))]
    p = polynomial_of_roots(roots)
    assert len(p) == len(roots) + 1
    for root in roots:
        x, y = F(root.real), F(root.imag)
        real, imaginary = F(0), F(0)
        for c in p:  # Horner's rule in exact complex numbers
            real, imaginary = real * x - imaginary * y + c, real * y + imaginary * x
        assert (real, imaginary) == (0, 0)


def test_a_linear_block_goes_from_the_law_to_the_output():
    block = LinearBlock(
        np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([0.0, 1.0]), np.array([5.0, 5.0]), np.array([1.0, 0.0])
    )
    assert as_block(block) == RationalBlock([1], [1, 3, 2])
    # dispersion adds no error here: the scheme with 10 cells has 21 states and its response is known in closed form
    scheme = upwind(builtin_system("paper-rod").rod, 10)
    exact = as_block(scheme.block)
    assert exact.order == 21
    assert exact.transfer(50j) == pytest.approx(scheme.transfer(50j), rel=1e-9)


def test_a_block_passes_through_unchanged():
    for block in (RationalBlock([1], [1, 1]), FrequencyData([1.0], [1.0]), as_block("exp(-s)/(s+1)")):
        assert as_block(block) is block


# sampling times


@pytest.mark.parametrize(
    ("caller", "own", "agreed"),
    [
        (None, None, None),
        (None, 0, None),
        (0, None, None),
        (0, 0, None),
        (None, True, 1),
        (True, None, 1),
        (True, True, 1),
        (F(1, 2), True, F(1, 2)),
        (True, 0.5, F(1, 2)),
        (F(1, 10), 0.1, F(1, 10)),
        (2, None, 2),
        (np.float64(0.5), None, F(1, 2)),
    ],
)
def test_sampling_times_follow_python_control(caller, own, agreed):
    assert sampling_time(caller, own) == agreed


@pytest.mark.parametrize(
    ("caller", "own", "said"),
    [
        (0.2, 0.1, "dt is discrete time of period 0.2 but dt is in discrete time of period 0.1"),
        (1, 0, "dt is discrete time of period 1 but dt is in continuous time"),
        (True, 0, "but dt is in continuous time"),
        (0, True, "dt is continuous time but dt is in discrete time"),
        (0, 1, "dt is continuous time"),
        (-1, None, "dt is -1; give a positive period"),
        (False, None, "dt is False; give 0 or None"),
        (math.nan, None, "dt is nan; give a finite number"),
        (math.inf, None, "dt is inf"),
        ("1", None, "give a number"),
        (None, -1, "dt.dt is -1"),
    ],
)
def test_sampling_times_that_contradict_or_mean_nothing_are_refused(caller, own, said):
    assert said in refusal(sampling_time, caller, own)


@pytest.mark.parametrize(
    ("source", "dt"),
    [
        (RationalBlock([1], [1, 1]), 1),
        (RationalBlock([1], [1, 1], 1), 0),
        (control.tf([1], [1, 1], 0.1), 0.2),
        (scipy.signal.lti([1], [1, 1]), 1),
        (DelayBlock.parse("exp(-s)/(s+1)"), 1),
    ],
)
def test_mixed_sampling_times_are_refused_for_every_source(source, dt):
    assert "leave dt out or convert the system" in refusal(as_block, source, dt=dt)
