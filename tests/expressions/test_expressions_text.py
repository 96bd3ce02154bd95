"""The whitelist parser: hostile text is refused at once, and what is understood means what Python means by it."""

import ast
import builtins
import pickle
import warnings
from contextlib import suppress
from dataclasses import FrozenInstanceError
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from counting import counted
from depth import sampled
from formulas import TX, arb, contains, of_t
from hypothesis import given, settings
from hypothesis import strategies as st

import lure.expressions
from lure.errors import InputError
from lure.expressions import Expression

# What is refused.

HOSTILE = [
    ("t.__class__", "values have no attributes"),
    ("t.real", "values have no attributes"),
    ("().__class__.__bases__[0].__subclasses__()", "values have no attributes"),
    ("__import__('os').system('true')", "text is not a value"),
    ("__import__(t)", "unknown name '__import__'"),
    ("__builtins__", "unknown name '__builtins__'"),
    ("__name__", "unknown name '__name__'"),
    ("eval(t)", "unknown name 'eval'"),
    ("getattr(t, t)", "unknown name 'getattr'"),
    ("lambda: 0", "':' is not allowed"),
    ("[s for s in t]", "no lists"),
    ("(s for s in t)", "unknown name 's'"),
    ("{t}", "no sets"),
    ("f'{t}'", "text is not a value"),
    ('"t"', "text is not a value"),
    ("b''", "text is not a value"),
    ("(t := 1)", "':' is not allowed"),
    ("*t", "found '\\*'"),
    ("max(*t)", "found '\\*'"),
    ("max(**t)", "found '\\*\\*'"),
    ("sin(x=t)", "arguments have no names"),
    ("t; t", "one expression only"),
    ("t @ t", "'@' is not allowed"),
    ("t // 2", "found '/'"),
    ("t % 2", "'%' is not allowed"),
    ("~t", "'~' is not allowed"),
    ("t[0]", "no lists"),
    ("t # note", "no comments"),
    ("t\\\n+1", "is not allowed"),
    ("await t", "unknown name 'await'"),
    ("yield t", "unknown name 'yield'"),
    ("t is t", "found 'is'"),
    ("True", "unknown name 'True'"),
    ("None", "unknown name 'None'"),
    ("...", "is not allowed"),
    ("9**9**9**9", "exponent must be"),
    ("9**t", "exponent must be"),
    ("t**33", "exponent must be"),
    ("t**-33", "exponent must be"),
    ("t**t", "exponent must be"),
    ("factorial(100000000)", "unknown name 'factorial'"),
    ("100000000!", "'!' is not allowed"),
    ("(" * 400 + "t" + ")" * 400, "parentheses or signs are nested at column 31"),
    ("(" * 1000, "parentheses or signs are nested"),
    ("sin(" * 200, "parentheses or signs are nested"),
    ("-" * 100_000 + "t", "at most 1024"),
    ("-" * 1000 + "t", "parentheses or signs are nested"),
    ("not " * 200 + "t < 1", "parentheses or signs are nested"),
    ("t if t < 1 else " * 60 + "t", "nested"),
    ("t**" * 300 + "1", "nested"),
    ("+".join(["t"] * 31), "group a long sum"),
    ("+".join(["1"] * 300), "more than 200"),
    ("(" + ",".join(["t"] * 300) + ")", "decimal separator"),
    ("max(" + ",".join(["1"] * 300) + ")", "more than 200"),
    ("1" * 5000, "at most 1024"),
    ("1" * 1000, "more than 100 digits"),
    ("1e999999999", "exponent of more than three"),
    ("1e-999999999", "exponent of more than three"),
    ("1e400", "between 1e-300 and 1e300"),
    ("0." + "0" * 90 + "1e-300", "between 1e-300 and 1e300"),
    ("t\0", "is not allowed"),
    ("\0", "is not allowed"),
    ("\N{CYRILLIC SMALL LETTER A}bs(t)", "not ASCII"),
    ("\N{FULLWIDTH LATIN SMALL LETTER T}", "not ASCII"),
    ("\N{MATHEMATICAL ITALIC SMALL T}", "not ASCII"),
    ("\N{ARABIC-INDIC DIGIT ONE}", "not ASCII"),
    ("t \N{MINUS SIGN} 1", "write the ASCII minus"),
    ("tanh(2*\N{GREEK SMALL LETTER SIGMA})", "write sigma"),  # as pages and figures write it
    ("t\N{SUPERSCRIPT THREE}", r"a power is written \*\*3"),
    ("t\N{NO-BREAK SPACE}+ 1", "not ASCII"),
    ("\ud800", "not ASCII"),
    ("t\f+1", "is not allowed"),
    ("nan", "must be finite"),
    ("NaN", "must be finite"),
    ("inf", "must be finite"),
    ("-Infinity", "must be finite"),
    ("e", "write exp\\(1\\)"),
    ("1j", "runs into 'j'"),
    ("0x10", "only plain decimal"),
    ("1_000", "only plain decimal"),
    ("exp(-0.1t)", "'0.1' runs into 't' at column 9; write 0.1\\*t for a product"),
    ("2 t", "expected an operator but found 't' at column 3"),
    ("2(t)", "write \\* for a product"),
    ("t(2)", "t is not a function"),
    ("1,5", "decimal separator is a point"),
    ("sin(1,5)", "sin takes one argument, not 2"),
    ("sin()", "sin takes one argument, not 0"),
    ("where(t < 1, t)", "three arguments"),
    ("min(t)", "two or more"),
    ("sin", "write sin\\(...\\)"),
    ("sinn(t)", "unknown name 'sinn' \\(did you mean 'sin'\\?\\) at column 1"),
    ("arctan(t)", "is atan"),
    ("sinh(t)", r"\(sinh\(u\) is written \(exp\(u\) - exp\(-u\)\)/2\)"),  # not: did you mean 'sin'?
    ("cosh(t)", r"\(cosh\(u\) is written \(exp\(u\) \+ exp\(-u\)\)/2\)"),
    ("asin(t)", "of inverses there is atan"),
    ("erf(t)", "there is no error function here"),
    ("sat(t)", r"\(a saturation of u is written min\(max\(u, -1\), 1\)\)"),
    ("relu(t)", r"\(a ReLU of u is written max\(u, 0\)\)"),
    ("x", r"\(the variable is t\)"),
    ("force", "allowed are t, pi, abs"),
    ("1/0", "division by zero at column 2"),
    ("t/(1 - 1)", "division by zero"),
    ("0**-1", "division by zero"),
    ("t < 1", "write where"),
    ("(t < 1)*t", "write where"),
    ("sin(t < 1)", "write where"),
    ("(t < 1) < 2", "write where"),
    ("-(t < 1)", "write where"),
    ("(t < 1)**2", "write where"),
    ("t if t else 1", "expected a comparison"),
    ("where(t, 1, 2)", "expected a comparison"),
    ("where(not t, 1, 2)", "expected a comparison"),
    ("where(t and t < 1, 1, 2)", "expected a comparison"),
    ("(t < 1 if t < 2 else t)", "write where"),
    ("t if t < 1", "expected 'else'"),
    ("(t", "to close '\\(' of column 1"),
    ("t)", "found '\\)'"),
    ("t +", "found the end of the text"),
    ("", "is empty"),
    (" \n\t", "is empty"),
    ("and", "found 'and'"),
]


@pytest.mark.parametrize(("text", "message"), HOSTILE, ids=lambda value: repr(value[:24]))
def test_hostile_or_mistaken_text_is_refused_quickly_in_one_sentence(text, message):
    with counted() as work, pytest.raises(InputError, match=message) as refusal:
        of_t(text)
    assert work.calls < 10**5
    sentence = str(refusal.value)
    assert sentence.startswith("force.g: ")
    assert sentence.isascii()
    assert sentence.isprintable()
    assert len(sentence) < 300


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (True, "found a bool"),
        (None, "found a NoneType"),
        ([1], "found a list"),
        (1j, "found a complex"),
        (float("nan"), "must be finite but is nan"),
        (float("-inf"), "must be finite but is -inf"),
        (Decimal("sNaN"), "must be finite"),
        (Decimal("Infinity"), "must be finite"),
        (Decimal("1e999999999"), "between 1e-300 and 1e300"),
        (Decimal("1e-999999999"), "between 1e-300 and 1e300"),
        (10**5000, "between 1e-300 and 1e300"),
        (Fraction(1, 10**5000), "between 1e-300 and 1e300"),
        (Fraction(1, 3**250), "at most 100 digits"),
        (5e-324, "between 1e-300 and 1e300"),
    ],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)
def test_a_number_that_is_not_one_or_not_usable_in_floats_is_refused(value, message):
    with pytest.raises(InputError, match=message):
        of_t(value)


@given(st.text(max_size=40))
def test_any_text_is_parsed_or_refused_and_nothing_else_happens(text):
    with suppress(InputError):
        assert isinstance(of_t(text), Expression)


WORDS = [
    "t",
    "x",
    "pi",
    "1",
    "2.5",
    ".5",
    "1e3",
    "0",
    "(",
    ")",
    ",",
    "e",
    "t.",
    "9",
    "sin",
    "where",
    "min",
    "abs",
    "log",
]
WORDS += ["+", "-", "*", "/", "**", "<", "<=", "==", "!=", "and", "or", "not", "if", "else"]


@given(st.lists(st.sampled_from(WORDS), max_size=25).map(" ".join))
@settings(max_examples=sampled(100, of=300))
def test_any_sequence_of_words_is_refused_or_is_an_expression_of_python_too(text):
    try:
        parsed = Expression.parse(text, variables=TX)
    except InputError:
        return
    assert isinstance(ast.parse(text.strip(), mode="eval"), ast.Expression)
    assert parsed(t=0.5, x=[1.0, 2.0]).shape == (2,)


def test_neither_eval_nor_exec_nor_compile_is_called_from_text_to_value(monkeypatch):
    def forbidden(*arguments, **options):
        raise AssertionError("Python's compiler was called")

    for name in ("eval", "exec", "compile"):  # flint is imported above: its own loading is not at issue
        monkeypatch.setattr(builtins, name, forbidden)
    nonlinearity = Expression.parse("where(t < 1 and x > 0, t**2/3, max(x, 1) - abs(t))", variables=TX)
    slope = nonlinearity.derivative("t")
    point = {"t": Fraction(1, 2), "x": Fraction(3)}
    values = [
        nonlinearity(t=0.5, x=3),
        nonlinearity.exact(**point),
        nonlinearity.ball(t=arb(point["t"]), x=arb(point["x"])),
        slope.exact(**point),
    ]
    monkeypatch.undo()
    assert values[0] == pytest.approx(1 / 12)
    assert values[1] == Fraction(1, 12)
    assert contains(values[2], Fraction(1, 12))
    assert values[3] == Fraction(1, 3)


def test_the_modules_never_name_what_could_run_text():
    for path in Path(lure.expressions.__file__).parent.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        assert not named & {"eval", "exec", "compile", "__import__", "globals", "getattr"}, path.name
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
        modules = {alias.name for node in imports for alias in node.names} | {
            getattr(node, "module", "") for node in imports
        }
        assert not modules & {"ast", "sympy", "importlib", "subprocess", "os", "sys"}, path.name


# What is understood.


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2**2", -4),
        ("2**-1", Fraction(1, 2)),
        ("2**3**2", 512),
        ("-t**2 + 2*t - 1", -4),
        ("8/2/2", 2),
        ("1 - 2 - 3", -4),
        ("--t", 3),
        ("0.1 + 0.2", Fraction(3, 10)),
        (" 1e-3\n* 5.", Fraction(1, 200)),
        (".5", Fraction(1, 2)),
        ("1 if t < 3 else 2 if t == 3 else 4", 2),
        ("where(0 < t <= 3 != 4, 1, 0)", 1),
        ("1 if not t < 3 and t < 4 or t > 100 else 0", 1),
        ("max(1, t, 2) + min(5, 4, 6)", 7),
        ("sign(-t)*abs(-t)", -3),
        ("1/(t - 3) if t != 3 else 7", 7),
        ("1 if t == 3 or 1/(t - 3) > 0 else 0", 1),
        ("9**32/9**32", 1),
        ("+".join(["(t + 1 - 1)"] * 12), 36),
    ],
)
def test_the_grammar_is_pythons_and_numbers_are_exact(text, value):
    assert of_t(text).exact(t=3) == value
    assert of_t(text)(t=3) == pytest.approx(float(value))


def test_a_variable_may_be_called_e_but_not_sin():
    assert Expression.parse("2*e", variables=("e",))(e=3) == 6
    for name in ("sin", "pi", "if", "a b", "", "\N{GREEK SMALL LETTER ALPHA}"):
        with pytest.raises(ValueError, match="as the name of a variable"):
            Expression.parse("1", variables=(name,))


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0.1, "0.1"),
        (-2.5e-9, "-0.0000000025"),
        (1e300, "1e300"),
        (7, "7"),
        (0, "0"),
        (-0.0, "0"),
        (np.float64(0.25), "0.25"),
        (np.int64(3), "3"),
        (Fraction(-1, 3), "-1/3"),
        (Fraction(1, 10**200), "1e-200"),
        (Decimal("1.10"), "1.1"),
        (Decimal("0e999999999"), "0"),
    ],
)
def test_a_number_is_the_constant_its_decimal_text_means(number, text):
    expression = of_t(number)
    assert str(expression) == text
    assert expression == of_t(text)
    assert expression.exact() == Fraction(repr(float(number))) or expression.exact() == Fraction(number)
    assert expression.is_constant


def test_an_expression_is_a_value():
    nonlinearity = of_t(" t + 1 ")
    assert nonlinearity == of_t("t + 1")
    assert hash(nonlinearity) == hash(of_t("t + 1"))
    assert nonlinearity != of_t("1 + t")
    assert nonlinearity != Expression.parse("t + 1", variables=TX)
    assert repr(nonlinearity) == "Expression(source='t + 1', variables=('t',))"
    with pytest.raises(FrozenInstanceError):
        nonlinearity.source = "t"
    again = pickle.loads(pickle.dumps(nonlinearity.derivative("t")))
    assert again == nonlinearity.derivative("t")
    assert again(t=[1, 2]).tolist() == [1, 1]


@pytest.mark.parametrize("text", ["0", "0.0", "1 - 1", "0*sin(t)", "exp(t)*0", "0 if t < 1 else 0", "0/3", "0**2"])
def test_what_is_visibly_zero_is_zero(text):
    assert of_t(text).is_zero
    assert of_t(text).is_constant


@pytest.mark.parametrize("text", ["t - t", "0*log(t)", "0*(1 + log(t))", "0*t**-1", "0/t", "1e-300", "1e-300*1e-300"])
def test_what_is_not_visibly_zero_or_not_everywhere_defined_is_not(text):
    assert not of_t(text).is_zero


def test_constants_with_functions_are_constant_but_not_exact():
    half_turn = of_t("sin(pi/2) + 2**0.5")
    assert half_turn.is_constant
    assert half_turn() == pytest.approx(1 + 2**0.5)
    with pytest.raises(InputError, match="sin has no exact rational value"):
        half_turn.exact()


# The numpy back-end.


def test_variables_broadcast_and_constants_take_their_shape():
    plane = Expression.parse("t + 10*x", variables=TX)
    assert plane(t=[0.0, 1.0], x=[[1.0], [2.0], [3.0]]).tolist() == [[10, 11], [20, 21], [30, 31]]
    constant = Expression.parse("2", variables=TX)
    assert constant(t=[0, 1], x=[[1], [2], [3]]).shape == (3, 2)
    assert constant(t=0).shape == constant().shape == ()
    assert constant(t=[0, 1]).dtype == np.float64


def test_the_result_is_a_new_array():
    times = np.array([1.0, 2.0])
    same = of_t("t")(t=times)
    same[0] = 5.0
    assert times[0] == 1.0


@pytest.mark.parametrize(
    "text",
    [
        "1/(t - 1)",
        "log(-t)",
        "min(log(-t), 1)",
        "max(1, log(-t))",
        "sqrt(-t)",
        "exp(1000*t)",
        "(-t)**0.5",
        "1e300*1e300*t",
        "(t-1)**-1",
    ],
)
def test_undefined_values_are_nan_or_infinite_without_a_warning(text):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not np.isfinite(of_t(text)(t=1.0))


def test_missing_and_unknown_variables_are_the_callers_mistake():
    nonlinearity = Expression.parse("t", variables=TX)
    with pytest.raises(TypeError, match=r"missing \['t'\]"):
        nonlinearity(x=1.0)
    with pytest.raises(TypeError, match=r"unknown \['y'\]"):
        nonlinearity.exact(t=1, y=2)
    with pytest.raises(TypeError, match="needs Fractions; t is a float"):
        nonlinearity.exact(t=0.1)
    with pytest.raises(ValueError, match="not 'y'"):
        nonlinearity.derivative("y")


@pytest.mark.parametrize(("caret", "text"), [("2*t^3", "2*t**3"), ("-t^2", "-t**2"), ("2^3^2*t", "2**(3**2)*t")])
def test_a_power_may_be_written_with_a_caret(caret, text):
    parsed = (Expression.parse(written, variables=("t",)) for written in (caret, text))
    assert len({str(one.derivative("t")) for one in parsed}) == 1
