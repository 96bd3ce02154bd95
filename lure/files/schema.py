"""What a file with a ``[plant]`` may hold: one pydantic model for each table, strict, numbers exact.

``[nonlinearity]`` takes the parameters of its kind of nonlinearity, which
:func:`lure.nonlinearities.nonlinearity_from_table` checks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from lure.classes import OPERATORS
from lure.errors import InputError
from lure.files.values import STRICT, array_of_tables, field_key, number_of, one_line, shown
from lure.plants import coefficients
from lure.plants.multivariable import MOST_CHANNELS
from lure.plants.text import exact_coefficient

QUESTIONS = ("gain", "rate", "region", "steady", "tolerances")
_INFINITE = {"inf": math.inf, "+inf": math.inf, "-inf": -math.inf}


def _exact(value: object, name: str) -> Fraction:
    """A number, or a text of one such as ``"1/3"``."""
    if isinstance(value, str):
        if len(value.replace(",", " ").split()) > 1:
            raise InputError(f"{name} is {shown(value)}; give one number")
        return exact_coefficient(value, name)
    return number_of(value, name)


def _parameters(value: object, info: ValidationInfo) -> dict[str, Fraction | tuple[Fraction | float, ...]]:
    """Bounds of each parameter, or its value."""
    name = field_key(info)
    if not isinstance(value, dict) or not value:
        raise InputError(f"{name} is {shown(value)}; give a table of parameters such as a = [2.5, 3.5]")
    found = dict[str, Fraction | tuple[Fraction | float, ...]]()
    for key, entry in value.items():
        called = f"{name}.{shown(key)[1:-1]}"
        if isinstance(entry, dict):
            found[key] = _changing(entry, called)
        elif not isinstance(entry, list):
            found[key] = _exact(entry, called)
        elif len(entry) == 2:
            low, high = (_exact(end, f"{called}[{i}]") for i, end in enumerate(entry))
            if low > high:
                raise InputError(f"{called} is [{float(low):g}, {float(high):g}]; the first must not be the larger")
            found[key] = low if low == high else (low, high)
        else:
            raise InputError(f"{called} has {len(entry)} entries; give two numbers such as [2.5, 3.5], or one")
    return found


def _changing(entry: dict[str, object], called: str) -> tuple[Fraction | float, ...]:
    """Bounds of a parameter that changes with time, and how fast."""
    between, others = entry.get("between"), set(entry) - {"between"}
    if not isinstance(between, list) or len(between) != 2 or others not in ({"varying"}, {"rate"}):
        raise InputError(
            f"{called} is {shown(entry)}; give {{ between = [2, 3], varying = true }} for a parameter that changes at "
            "any speed, or rate = r in place of varying for one that changes by at most r in a unit of time"
        )
    low, high = (_exact(end, f"{called}.between[{i}]") for i, end in enumerate(between))
    if low >= high:
        raise InputError(f"{called}.between is [{float(low):g}, {float(high):g}]; the first must be the smaller")
    if "varying" in entry and entry["varying"] is not True:
        raise InputError(f"{called}.varying is {shown(entry['varying'])}; give true, or the two bounds alone")
    rate = math.inf if "varying" in entry else _exact(entry["rate"], f"{called}.rate")
    if rate <= 0:
        raise InputError(f"{called}.rate is {float(rate):g}; give a positive number, or the two bounds alone")
    return low, high, rate


def _formulas(info: ValidationInfo) -> bool:
    """Whether the entry is of a plant with parameters, in which it may be a formula."""
    return field_key(info).startswith("plant.") and bool(info.data.get("parameters", "refused"))


def _list(value: object, info: ValidationInfo) -> tuple[Fraction | str, ...]:
    name = field_key(info)
    if _formulas(info) and isinstance(value, list):
        return tuple(_entry(entry, f"{name}[{i}]") for i, entry in enumerate(value))
    if isinstance(value, str):
        return coefficients(value, name)
    if not isinstance(value, list | tuple):
        raise InputError(f"{name} is {shown(value)}; give a list such as [1, 3, 2, 0] or a text such as '1 3 2 0'")
    return coefficients([_exact(entry, f"{name}[{i}]") for i, entry in enumerate(value)], name)


def _matrix(value: object, info: ValidationInfo) -> list[Any]:
    key = field_key(info)
    if key.startswith("performance.") and not isinstance(value, list):
        return [_either(value, key)]
    return _rows(value, key, 2, _either if key.startswith("performance.") else _entry if _formulas(info) else _exact)


def _either(value: object, name: str) -> str | Fraction:
    """A number, or a text that may be a formula in parameters: the plant tells."""
    try:
        return _exact(value, name)
    except InputError:
        if isinstance(value, str):
            return value
        raise


def _rows(value: object, name: str, depth: int, exact: Callable[[object, str], str | Fraction]) -> list[Any]:
    """Nested lists of exact numbers, or formulas; their shapes are checked with the others'."""
    if not isinstance(value, list):
        raise InputError(f"{name} is {shown(value)}; give a list of rows such as [[0, 1], [-2, -3]]")
    if depth == 0:
        raise InputError(f"{name} is nested too deeply; give a list of rows")
    return [
        _rows(entry, f"{name}[{i}]", depth - 1, exact) if isinstance(entry, list) else exact(entry, f"{name}[{i}]")
        for i, entry in enumerate(value)
    ]


def _numbers(value: object, info: ValidationInfo) -> tuple[Fraction, ...]:
    """A number, or a list of them."""
    name = field_key(info)
    if not isinstance(value, list):
        return (_exact(value, name),)
    if not value:
        raise InputError(f"{name} is an empty list; give numbers, or leave it out")
    return tuple(_exact(entry, f"{name}[{i}]") for i, entry in enumerate(value))


def _direct(value: object, info: ValidationInfo) -> Fraction | str | list[Any]:
    name, formulas = field_key(info), _formulas(info)
    while isinstance(value, list) and len(value) == 1:
        value = value[0]
    if isinstance(value, list):
        return _rows(value, name, 2, _entry if formulas else _exact)
    return _entry(value, name) if formulas else _exact(value, name)


def _formula(value: object, info: ValidationInfo) -> str | list[Any]:
    name = field_key(info)
    if isinstance(value, list) and value and all(isinstance(row, list) and row for row in value):
        rows = [[_entry(entry, f"{name}[{i}][{j}]") for j, entry in enumerate(row)] for i, row in enumerate(value)]
        if len({len(row) for row in rows}) > 1:
            raise InputError(f"{name} has rows of different lengths; give as many formulas in each row as H has inputs")
        return rows
    if not isinstance(value, str):
        raise InputError(
            f"{name} is {shown(value)}; give a formula in quotes, such as '1/(s*(s+1))', or rows of them for several "
            "channels"
        )
    return value


def _entry(value: object, name: str) -> str | Fraction:
    """An entry of a transfer matrix: a formula, or a gain."""
    return value if isinstance(value, str) else _exact(value, name)


def _positive(wanted: str) -> BeforeValidator:
    """What takes a positive number; ``wanted`` stands in the sentence of a refusal."""

    def found(value: object, info: ValidationInfo) -> Fraction:
        """The exact number, refused unless it is positive."""
        number = _exact(value, field_key(info))
        if number <= 0:
            raise InputError(f"{field_key(info)} is {float(number):g}; give {wanted}")
        return number

    return BeforeValidator(found)


def _given(accepts: Callable[[Any], bool], wanted: str) -> BeforeValidator:
    """What takes a value as it is, if it is accepted; ``wanted`` stands in the sentence of a refusal."""

    def found(value: object, info: ValidationInfo) -> object:
        """The value, refused unless it is accepted."""
        if not accepts(value):
            raise InputError(f"{field_key(info)} is {shown(value)}; give {wanted}")
        return value

    return BeforeValidator(found)


def _is_place(value: object) -> bool:
    """Whether it is a number of channels, or of one of them."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value <= MOST_CHANNELS


def _pair(value: object, info: ValidationInfo) -> tuple[float | Fraction, float | Fraction]:
    name = field_key(info)
    parts: object = value.strip().strip("[]").replace(",", " ").split() if isinstance(value, str) else value
    if not isinstance(parts, list | tuple) or len(parts) != 2:
        raise InputError(f"{name} is {shown(value)}; give two numbers such as [0, 5.9] or [0, inf]")
    low, high = (_bound(part, f"{name}[{i}]") for i, part in enumerate(parts))
    if not low < high:
        raise InputError(f"{name} is [{float(low):g}, {float(high):g}]; the first must be smaller than the second")
    return low, high


def _bound(value: object, name: str) -> float | Fraction:
    if isinstance(value, str) and value.strip().lower() in _INFINITE:
        return _INFINITE[value.strip().lower()]
    if isinstance(value, Decimal | float) and abs(value) == math.inf:
        return math.inf if value > 0 else -math.inf
    return _exact(value, name)


def _size(value: object, info: ValidationInfo) -> tuple[int, int]:
    pair = [value, value] if isinstance(value, int) else value
    plain = isinstance(pair, list) and all(type(v) is int and 0 < v <= MOST_CHANNELS for v in pair)
    if isinstance(value, bool) or not plain or not isinstance(pair, list) or len(pair) != 2:
        raise InputError(f"{field_key(info)} is {shown(value)}; give the rows and columns of the operator, as [2, 3]")
    return pair[0], pair[1]


def _number(value: object, info: ValidationInfo) -> Fraction:
    return _exact(value, field_key(info))


def _questions(value: object, info: ValidationInfo) -> tuple[str, ...]:
    listed = value if isinstance(value, list) else [value]
    wrong = [one for i, one in enumerate(listed) if one not in QUESTIONS or one in listed[:i]]
    if wrong:
        raise InputError(f"{field_key(info)} has {shown(wrong[0])}; give a list of {', '.join(QUESTIONS)}, each once")
    return tuple(map(str, listed))


Coefficients: TypeAlias = Annotated[tuple[Fraction | str, ...] | None, BeforeValidator(_list)]
Parameters: TypeAlias = Annotated[dict[str, Any] | None, BeforeValidator(_parameters)]
Matrix: TypeAlias = Annotated[list[Any] | None, BeforeValidator(_matrix)]
Pair: TypeAlias = Annotated[tuple[float | Fraction, float | Fraction] | None, BeforeValidator(_pair)]
Truth: TypeAlias = Annotated[bool, _given(lambda one: isinstance(one, bool), "true or false")]
Count: TypeAlias = Annotated[int, _given(_is_place, "in how many channels in turn it acts, 1 or more")]
Channel: TypeAlias = Annotated[int | None, _given(_is_place, "the number of the first channel it acts in, from 1")]
Bound: TypeAlias = Annotated[Fraction | None, _positive("a positive bound")]
Rate: TypeAlias = Annotated[
    Fraction | None,
    _positive("how fast the gain may change, a positive number, or leave rate out for constant ones"),
]
Step: TypeAlias = Annotated[Fraction | None, _positive("a positive time, or leave dt out")]
Size: TypeAlias = Annotated[tuple[int, int] | None, BeforeValidator(_size)]
Dynamics: TypeAlias = Annotated[
    str | None, _given(lambda one: one in OPERATORS[:2], "'any' or 'linear time-invariant'")
]
Memory: TypeAlias = Annotated[str | None, _given(lambda one: one in ("play", "stop"), "'play' or 'stop'")]
Kind: TypeAlias = Annotated[
    str, _given(lambda one: isinstance(one, str), "the kind of a nonlinearity in quotes, such as 'saturation'")
]
File: TypeAlias = Annotated[
    str, _given(lambda one: isinstance(one, str) and bool(one.strip()), "the path of a file in quotes")
]
Numbers: TypeAlias = Annotated[tuple[Fraction, ...], BeforeValidator(_numbers)]
Line: TypeAlias = Annotated[str | None, BeforeValidator(one_line)]


class PlantTable(BaseModel):
    """``[plant]``: the linear part, in one of three forms."""

    model_config = ConfigDict(**STRICT, title="plant")
    parameters: Parameters = Field(
        default=None, description="a table: bounds of constants that are not known, such as a = [2.5, 3.5], or values"
    )
    num: Coefficients = Field(default=None, description="numerator, highest power first")
    den: Coefficients = Field(default=None, description="denominator, highest power first")
    A: Matrix = Field(default=None, description="state matrix, a list of rows")
    B: Matrix = Field(default=None, description="input, an entry for each state, or a row for several inputs")
    C: Matrix = Field(default=None, description="output, one entry for each state; for several outputs a list of rows")
    D: Annotated[Fraction | str | list[Any] | None, BeforeValidator(_direct)] = Field(
        default=None, description="feedthrough, a number or for several channels a list of rows"
    )
    transfer: Annotated[str | list[Any] | None, BeforeValidator(_formula)] = Field(
        default=None, description="H as a formula, or a list of rows of formulas"
    )
    dt: Step = Field(default=None, description="sampling time [s]")


class NonlinearityTable(BaseModel):
    """``[nonlinearity]``: a kind of nonlinearity; its parameters are checked by the nonlinearity.

    With several channels ``[[nonlinearity]]``, in their order.
    """

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, title="nonlinearity")
    kind: Kind = Field(description="the kind of nonlinearity, such as saturation or expression")
    repeated: Count = Field(default=1, description="in how many channels in turn this one acts")
    channel: Channel = Field(
        default=None, description="the first of these, where [[class]] tables are about the others"
    )

    def nonlinearity_table(self) -> dict[str, object]:
        """Kind and parameters, numbers exact.

        Raises
        ------
        InputError
            A parameter is neither a number, a truth value, a text nor a list of these.
        """
        extra = {} if self.model_extra is None else self.model_extra
        return {"kind": self.kind, **{key: _parameter(value, f"nonlinearity.{key}") for key, value in extra.items()}}


class ClassTable(BaseModel):
    """``[class]``: what is assumed of the nonlinearity; with several channels ``[[class]]``, in their order."""

    model_config = ConfigDict(**STRICT, title="class")
    sector: Pair = Field(default=None, description="bounds of phi(sigma)/sigma")
    slope: Pair = Field(default=None, description="bounds of every difference quotient")
    on: Pair = Field(default=None, description="interval around 0 of sigma on which sector holds alone, for a region")
    odd: Truth = Field(default=False, description="whether phi(-sigma) = -phi(sigma)")
    time_varying: Truth = Field(default=False, description="whether phi may depend on time")
    gain: Pair = Field(default=None, description="bounds of a constant gain, phi(sigma) = g sigma, instead of these")
    rate: Rate = Field(
        default=None, description="beside gain: it varies in time, by at most this [1/s, or in a sample]"
    )
    relu: Truth = Field(
        default=False,
        description="whether phi(sigma) = max(sigma, 0), with slope = [l, k] k max(sigma, 0) + l min(sigma, 0)",
    )
    repeated: Count = Field(default=1, description="in how many channels in turn one such nonlinearity acts")
    norm: Bound = Field(default=None, description="bound of the norm of an operator mu_b = -Delta sigma_b, instead")
    size: Size = Field(
        default=None,
        description="rows and columns of that operator, or one number for both; beside sector: of one function",
    )
    dynamics: Dynamics = Field(default=None, description="its kind: 'any', or 'linear time-invariant'")
    memory: Memory = Field(default=None, description="'play' or 'stop' of a slope in the bounds of slope, from 0 on")
    delay: Bound = Field(default=None, description="bound of an unknown delay, phi = sigma(t - tau), instead [s]")


class PerformanceTable(BaseModel):
    """``[performance]``: a disturbance ``w`` and an output ``z``; what is left out is 0."""

    model_config = ConfigDict(**STRICT, title="performance")
    Bw: Matrix = Field(default=None, description="how w moves the state, a row for each state; one list for one w")
    Cz: Matrix = Field(default=None, description="how z sees the state, a row for each output; one list for one z")
    Dzw: Matrix = Field(default=None, description="from w to z")
    Dzmu: Matrix = Field(default=None, description="from mu = -phi(sigma) to z, a column for each channel")
    Dsigmaw: Matrix = Field(default=None, description="from w to sigma, a row for each channel")


class ForcingTable(BaseModel):
    """``[forcing]``: an input ``w(t) = constant + amplitude sin(omega t)``, to which the steady response is asked."""

    model_config = ConfigDict(**STRICT, title="forcing")
    amplitude: Numbers = Field(default=(), description="of the sine, a number for each entry of w")
    omega: Numbers = Field(default=(), description="its frequency, or a list of frequencies [rad/s]")
    constant: Numbers = Field(default=(), description="what is constant in w, a number for each entry")
    unit: Line = Field(default=None, description="the unit of z, for figures")


class ControllerTable(BaseModel):
    """``[controller]``: a network ``u = N(y)`` that closes the plant, ``y = Cy x``, beside the nonlinearities."""

    model_config = ConfigDict(**STRICT, title="controller")
    network: File = Field(description="file of its weights, in quotes")
    activation: Line = Field(default=None, description="of its neurons, such as 'tanh', if the file does not say it")
    negative_slope: Annotated[Fraction | None, BeforeValidator(_number)] = Field(
        default=None, description="of a leaky ReLU"
    )
    saturation: Bound = Field(default=None, description="limit of every output")
    Bu: Matrix = Field(default=None, description="how u moves the state, a row for each state")
    Cy: Matrix = Field(default=None, description="what it measures, a row for each of its inputs; the states without")
    origin: Line = Field(default=None, description="'equilibrium': x is counted from that of a network with biases")


class ReportTable(BaseModel):
    """``[report]``: what the report is asked beside stability."""

    model_config = ConfigDict(**STRICT, title="report")
    ask: Annotated[tuple[str, ...], BeforeValidator(_questions)] = Field(
        default=(), description="a list of 'gain', 'rate', 'region', 'steady' and 'tolerances'"
    )


class PlantTables(BaseModel):
    """A whole file."""

    model_config = ConfigDict(**STRICT)
    name: Line = Field(default=None, description="name for the report")
    title: Line = Field(default=None, description="one line that says what it is")
    plant: PlantTable
    nonlinearity: Annotated[list[NonlinearityTable], BeforeValidator(array_of_tables)] = Field(default_factory=list)
    nonlinearity_class: Annotated[list[ClassTable], BeforeValidator(array_of_tables)] = Field(
        default_factory=list, alias="class"
    )
    performance: PerformanceTable | None = None
    forcing: ForcingTable | None = None
    controller: ControllerTable | None = None
    report: ReportTable | None = None

    def first_of(self, *keys: str) -> str:
        """The first of some keys that a class has, with its channel; empty if none has one."""
        channel = 1
        for table in self.nonlinearity_class:
            for key in keys:
                if getattr(table, key) not in (None, False):
                    return f"{key} in channel {channel}"
            channel += max(table.size or (table.repeated,))
        return ""


PLANT_TABLES: dict[str, type[BaseModel]] = {
    "plant": PlantTable,
    "nonlinearity": NonlinearityTable,
    "class": ClassTable,
    "performance": PerformanceTable,
    "forcing": ForcingTable,
    "controller": ControllerTable,
    "report": ReportTable,
}
LAW_TEXTS = ("text", "expression", "formula", "law", "kind", "file")


def _parameter(value: object, name: str) -> object:
    """A parameter of a nonlinearity: numbers exact, infinity as a float, a text of a number as that number."""
    if isinstance(value, bool):
        return value
    if isinstance(value, list | tuple):
        return [_parameter(entry, f"{name}[{i}]") for i, entry in enumerate(value)]
    if isinstance(value, str):
        try:
            return value if name.rpartition(".")[2] in LAW_TEXTS else _bound(value, name)
        except InputError:
            return value  # for the nonlinearity to take or to refuse
    if not isinstance(value, int | float | Decimal | Fraction):
        raise InputError(f"{name} is {shown(value)}; give a number, a text, true or false, or a list")
    return _bound(value, name)
