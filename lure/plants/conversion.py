"""One door for linear blocks: whatever describes a system becomes one of the block types."""

from __future__ import annotations

import re
import reprlib
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from types import ModuleType
from typing import Literal, cast

from lure.errors import InputError
from lure.plants.block import LinearBlock
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, plant_of_delays
from lure.plants.family import PlantFamily
from lure.plants.frequency_data import FrequencyData
from lure.plants.matrices import MAX_EXACT_STATES, ONE_PAIR, float_block, rational_block
from lure.plants.multivariable import MultivariablePlant, plant_of_matrices, plant_of_transfers
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Names, names_of
from lure.plants.state_space import MAX_STATES, StateSpace
from lure.plants.text import coefficients, exact_coefficient, parse_transfer, polynomial_of_roots, sampling_time

# The exact block behind whatever a user has, for what can only be done exactly.


def exact_block(source: object, what: str) -> RationalPlant:
    """The rational block that ``source`` describes.

    ``source``: whatever :func:`lure.as_plant` takes; ``what``: what needs it, for the error.

    Raises
    ------
    InputError
        It has a dead time, is measured, or is too large for exact coefficients.

    Examples
    --------
    >>> import control
    >>> print(exact_block(control.tf([1], [1, 1]), "this"))
    1 / (s + 1)
    """
    found = rational_if_moderate(one_channel(source))
    if not isinstance(found, RationalPlant):
        raise InputError(
            f"{what} needs exact coefficients, and a {type(found).__name__} has none; give coefficients, matrices of "
            "up to 60 states, or a formula without dead time"
        )
    return found


def rational_if_moderate(block: object) -> object:
    """A ``StateSpace`` of up to 60 states as the rational plant with the same doubles, anything else as it is.

    ``block``: what :func:`lure.as_plant` returns.
    """
    if not isinstance(block, StateSpace) or block.order > MAX_EXACT_STATES:
        return block
    step: Step = True if block.any_period else block.dt
    return _from_matrices((block.A, block.B, block.C, block.D), step, block.names)


AnyBlock = RationalPlant | PlantFamily | StateSpace | DelayPlant | FrequencyData
"""Every kind of block with one input and one output that :func:`lure.as_plant` returns."""

Step = Fraction | Literal[True] | None
_VARIABLE = re.compile(r"\b[sz]\b|[0-9][sz]\b")
_EXPONENTIAL = re.compile(r"\bexp\s*\(")
_WANTED = (
    "give coefficients (num, den), matrices (A, B, C), a text such as '1/(s*(s+1))', a system of python-control or "
    "scipy.signal, or a RationalPlant"
)


def one_channel(source: object, *, dt: object = None) -> AnyBlock:
    """The linear block with one input and one output that ``source`` describes, for what is about one nonlinearity.

    ``source``, ``dt``: as for :func:`as_plant`.

    Raises
    ------
    InputError
        As for :func:`as_plant`; or there are several inputs or outputs.
    """
    found = as_plant(source, dt=dt)
    if isinstance(found, MultivariablePlant | ChannelFamily | DelayMatrix):
        sides = (
            f"{n} {side}{'s' if n > 1 else ''}" for n, side in ((found.inputs, "input"), (found.outputs, "output"))
        )
        raise InputError(
            f"the system has {' and '.join(sides)}: a block has one input and one output; where a question takes "
            f"classes, give one for each channel, such as [SlopeBounds(0, 1)] * {found.inputs}, else choose a pair, "
            "e.g. sys[0, 0] in python-control"
        )
    return found


def as_plant(source: object, *, dt: object = None) -> AnyBlock | MultivariablePlant | ChannelFamily | DelayMatrix:
    """The linear plant that ``source`` describes, exact wherever it can be.

    Parameters
    ----------
    source : object
        - a ``RationalPlant``, ``StateSpace``, ``FrequencyData``, ``DelayPlant``, ``PlantFamily`` or ``ChannelFamily``:
          returned as it is;
        - ``(num, den)``: lists or texts of coefficients, highest power first, or arrays, of one row too;
        - ``(A, B, C)`` or ``(A, B, C, D)``: ints, Fractions, floats, texts; nested lists or arrays, of any shapes;
        - what ``scipy.signal.cont2discrete`` returns, ``(num, den, dt)`` with a row ``num``, or ``(A, B, C, D, dt)``;
        - a list of rows of formulas or blocks, ``[["1/(s+1)", "0"], ["1/s", "1/(s+2)"]]``: a transfer matrix, outputs
          down; with ``exp(-T*s)`` in one it becomes a ``DelayMatrix``; also of numbers alone where they can be nothing
          else; of two lists of one or two numbers each ``(num, den)`` in round brackets is a pair;
        - a formula: ``"1/(s*(s+1))"``, ``"z/(z-0.5)"``; with ``exp(-T*s)`` it becomes a ``DelayPlant``;
        - ``control.TransferFunction``, ``StateSpace``, ``FrequencyResponseData``; ``scipy.signal`` ``lti``, ``dlti``;
        - a ``LinearPlant``, from ``mu`` to ``sigma``.

        A float is the double it is.
    dt : None, 0, True or number
        Sampling time [s] in python-control's convention: None leaves it to the source (continuous time if that says
        nothing), 0 is continuous, True discrete of unspecified period, which counts as 1.

    Returns
    -------
    RationalPlant, StateSpace, DelayPlant, FrequencyData, MultivariablePlant or DelayMatrix
        The last two where there are several inputs or outputs, of up to 200 states.  Else matrices of up to 60 states
        become an exact ``RationalPlant``, which keeps them and their names in ``matrices``, larger ones a
        ``StateSpace`` in floating point.  ``FrequencyData`` can never carry a certificate.

    Raises
    ------
    InputError
        One sentence: the system is nonlinear, improper, empty, too large, has complex, infinite or nan entries,
        matrices that do not fit, or a sampling time that contradicts ``dt``.

    Notes
    -----
    No realisation is reduced: a factor common to numerator and denominator, or a mode that the input does not reach or
    the output does not see, stays in the ``RationalPlant``.  Poles and zeros given as numbers (``ZerosPolesGain``) are
    multiplied out exactly; complex ones must come in conjugate pairs.

    Examples
    --------
    >>> print(as_plant(("1", "1 3 2 0")))
    1 / (s^3 + 3 s^2 + 2 s)
    >>> print(as_plant(([[0, 1], [-2, -3]], [0, 1], [1, 0])))
    1 / (s^2 + 3 s + 2)
    """
    if isinstance(source, AnyBlock | ChannelFamily | MultivariablePlant | DelayMatrix):
        sampling_time(dt, 0 if source.dt is None else source.dt, name="the block")
        return source
    if isinstance(source, LinearBlock):
        return _from_matrices((source.A, source.b1, source.c, 0), sampling_time(dt, 0, name="the block"))
    if isinstance(source, str):
        return _from_text(source, dt)
    for module, convert in (("control", _from_control), ("scipy.signal", _from_scipy)):
        package = sys.modules.get(module)
        if package is not None:  # an object of a package that is not loaded cannot exist
            found = convert(package, source, dt)
            if found is not None:
                return found
    if isinstance(source, tuple | list):
        rows = _is_transfers(source) or _is_gains(source)
        return transfer_matrix(source, dt=dt) if rows else _from_parts(source, dt)
    if callable(source):
        raise InputError(
            "a function H(s) is known only where it is called, so that nothing can be shown with it; "
            f"{_WANTED}, 'exp(-s)/(s+1)' for a dead time, or control.FrequencyResponseData for samples"
        )
    if isinstance(source, Mapping):
        keys = next((keys for keys in ("ABCD", "ABC", ("num", "den")) if all(key in source for key in keys)), "ABCD")
        entries = ", ".join(f"m[{key!r}]" for key in keys)
        raise InputError(
            f"a dictionary m, such as scipy.io.loadmat reads, is no block; give what it holds, ({entries})"
        )
    if hasattr(source, "block"):
        raise InputError(f"a {type(source).__name__} is a block and what closes the loop; give its block, loop.block")
    raise InputError(f"{reprlib.repr(source)} is no linear block; {_WANTED}")


def _from_text(text: str, dt: object) -> RationalPlant | DelayPlant:
    if text.endswith((".toml", ".mat", ".csv")):
        raise InputError(
            f"{reprlib.repr(text)} is the name of a file, and a text is a formula; lure.files.find_system(name)"
            ".block is the block of a system file, and as_plant takes the matrices that scipy.io.loadmat reads"
        )
    if not _EXPONENTIAL.search(text):
        return parse_transfer(text, dt=dt)
    if sampling_time(dt) is not None:
        raise InputError("transfer: exp(-T*s) is a dead time in continuous time; write z**-n in discrete time")
    found = DelayPlant.parse(text.replace("^", "**"))
    return found.delayless or found


def _is_transfers(rows: Sequence[object]) -> bool:
    """Whether these are rows of a transfer matrix, formulas or blocks, rather than coefficients or matrices."""
    lists = bool(rows) and all(isinstance(row, list | tuple) for row in rows)
    entries = [entry for row in rows for entry in cast("Sequence[object]", row)] if lists else []
    return any(
        isinstance(entry, RationalPlant) or (isinstance(entry, str) and _VARIABLE.search(entry)) for entry in entries
    )


def _is_gains(rows: Sequence[object]) -> bool:
    """Whether these can only be rows of gains, as three rows of three numbers: no coefficients, and no matrices.

    Raises
    ------
    InputError
        They may be both: two lists in a list, each of two numbers, or of one.
    """
    lists = [cast("Sequence[object]", row) for row in rows if isinstance(row, list | tuple) and row and _is_flat(row)]
    if not isinstance(rows, list) or len(lists) < len(rows) or len({len(row) for row in lists}) != 1:
        return False
    if len(lists) == 2 >= len(lists[0]):
        raise InputError(
            f"{reprlib.repr(rows)} may be numerator and denominator, or rows of gains; give a pair "
            "(num, den) in round brackets, or the gains as D of a plant without states, ([], [], [], D)"
        )
    return len(lists) != 2 and (len(lists) not in (3, 4) or len(lists[0]) > 1)


def transfer_matrix(
    rows: Sequence[object], *, dt: object = None
) -> RationalPlant | DelayPlant | MultivariablePlant | DelayMatrix:
    """The plant of rows of formulas, blocks and gains, outputs down.

    ``rows``: ``H``, row by row; ``dt``: as for :func:`as_plant`.

    Raises
    ------
    InputError
        An entry is no block, or :func:`lure.plants.delay_matrix.plant_of_delays` refuses them.
    """
    listed = [
        [_transfer_entry(entry, dt, f"transfer[{i}][{j}]") for j, entry in enumerate(cast("Sequence[object]", row))]
        for i, row in enumerate(rows)
    ]
    if len(listed) == len(listed[0]) == 1:
        return listed[0][0]
    rational = [[one for one in row if isinstance(one, RationalPlant)] for row in listed]
    return plant_of_transfers(rational) if rational == listed else plant_of_delays(listed)


def _transfer_entry(entry: object, dt: object, name: str) -> RationalPlant | DelayPlant:
    """An entry of a transfer matrix; a number, or the text of one, is a gain in continuous and in discrete time."""
    if isinstance(entry, int | float | Fraction) or (isinstance(entry, str) and not _VARIABLE.search(entry)):
        return RationalPlant([exact_coefficient(entry, name)], [1])
    try:
        found = one_channel(entry, dt=dt)
    except InputError as error:
        raise InputError(f"{name}: {str(error).removeprefix('transfer: ')}") from None
    if not isinstance(found, RationalPlant | DelayPlant):
        raise InputError(f"{name} is a {type(found).__name__}; give a transfer function, with dead time or without")
    return found


def _from_parts(parts: Sequence[object], dt: object) -> RationalPlant | StateSpace | MultivariablePlant:
    """``(num, den)``, ``(A, B, C[, D])``, or scipy's ``cont2discrete``: ``([num], den, dt)``, ``(A, B, C, D, dt)``."""
    if len(parts) == 5:
        return _from_matrices(parts[:4], sampling_time(dt, parts[4], name="the system"))
    shape: tuple[int, ...] = getattr(parts[0], "shape", ())
    if len(parts) == 3 and isinstance(parts[2], int | float) and len(shape) == 2 and shape[0] == 1 < shape[1]:
        # a numerator as scipy writes it: it is no A, which is square
        return _ratio(_row(parts[0]), parts[1], sampling_time(dt, parts[2], name="the system"))
    if len(parts) == 2:
        return _ratio(_row(parts[0]), _row(parts[1]), sampling_time(dt))
    if len(parts) == 3 and isinstance(parts[2], int | float | Fraction) and all(map(_is_flat, parts[:2])):
        raise InputError(
            "numerator, denominator and sampling time may be meant, or the matrices of one state; give (num, den) and "
            "dt= beside it, or A as a list of rows"
        )
    flat = len(parts) == 4 and len(shape) == 1 == getattr(parts[1], "ndim", 0)
    if flat and all(isinstance(one, int | float) for one in parts[2:]) and cast("float", parts[3]) > 0:
        raise InputError(
            "zeros, poles, gain and period may be meant, or the matrices of one state; give "
            "scipy.signal.ZerosPolesGain(z, p, k, dt=dt), or A as a list of rows"
        )
    if len(parts) not in (3, 4):
        raise InputError(f"a system of {len(parts)} parts is unknown; give (num, den) or (A, B, C) or (A, B, C, D)")
    if isinstance(parts[0], str):
        raise InputError("three or four parts are the matrices (A, B, C) or (A, B, C, D); give A as a list of rows")
    return _from_matrices(parts, sampling_time(dt))


def _is_flat(part: object) -> bool:
    """Whether these are coefficients in a row, or a matrix written like them: a list or an array of numbers."""
    if isinstance(part, list | tuple):
        return not any(isinstance(one, list | tuple) for one in part)
    return getattr(part, "ndim", 0) == 1


def _row(part: object) -> object:
    """The entries of an array of one row, as scipy and MATLAB write coefficients."""
    shape: tuple[int, ...] = getattr(part, "shape", ())
    return cast("Sequence[object]", part)[0] if len(shape) == 2 and shape[0] == 1 else part


def _from_matrices(
    parts: Sequence[object], dt: Step, names: Names | None = None
) -> RationalPlant | StateSpace | MultivariablePlant:
    A, B, C = parts[:3]
    D = parts[3] if len(parts) == 4 else None
    several = plant_of_matrices(A, B, C, D, dt=dt)
    if several is not None:
        return several
    states = A.shape[0] if hasattr(A, "shape") and A.shape else len(A) if isinstance(A, Sequence) else 1
    if states > MAX_STATES:
        raise InputError(f"the system has {states} states; dense matrices stop at {MAX_STATES}")
    if states > MAX_EXACT_STATES:
        return replace(float_block(A, B, C, D, dt=dt), dt=cast("Fraction | None", dt), names=names)
    found = rational_block(A, B, C, D, dt=dt)
    if names is None or found.matrices is None:
        return found
    return RationalPlant(found.numerator, found.denominator, dt, matrices=replace(found.matrices, names=names))


def _from_control(control: ModuleType, source: object, dt: object) -> AnyBlock | MultivariablePlant | None:
    if not isinstance(source, control.InputOutputSystem):
        return None
    if not isinstance(source, control.FrequencyResponseData | control.TransferFunction | control.StateSpace):
        raise InputError(
            f"{source.name} is a nonlinear system of python-control; linearise it where it is to run: "
            "control.linearize(system, x, u) with a state x and an input u of equilibrium"
        )
    several = (source.ninputs, source.noutputs) != (1, 1)
    if isinstance(source, control.FrequencyResponseData):
        if several:
            raise InputError(f"the data have {source.ninputs} inputs and {source.noutputs} outputs: {ONE_PAIR}")
        step, order = sampling_time(dt, source.dt, name="the data"), source.omega.argsort()
        return FrequencyData(source.omega[order], source.frdata[0, 0, order], None if step is None else Fraction(step))
    if isinstance(source, control.TransferFunction):
        step = sampling_time(dt, source.dt, name="the system")
        pairs = [list(zip(*row, strict=True)) for row in zip(source.num_list, source.den_list, strict=True)]
        found = [[_ratio(*pair, step) for pair in row] for row in pairs]
        return plant_of_transfers(found) if several else found[0][0]
    step = sampling_time(dt, source.dt, name="the system")
    return _from_matrices((source.A, source.B, source.C, source.D), step, names_of(source))


def _ratio(top: object, bottom: object, step: Step) -> RationalPlant:
    return RationalPlant(coefficients(top, "numerator"), coefficients(bottom, "denominator"), step)


def _from_scipy(signal: ModuleType, source: object, dt: object) -> AnyBlock | MultivariablePlant | None:
    if not isinstance(source, signal.lti | signal.dlti):
        return None
    own = 0 if isinstance(source, signal.lti) else source.dt
    step = sampling_time(dt, own, name="the system")
    if isinstance(source, signal.StateSpace):
        return _from_matrices((source.A, source.B, source.C, source.D), step)
    if isinstance(source, signal.ZerosPolesGain):
        top = polynomial_of_roots(source.zeros, "zeros")
        gain = coefficients([source.gain], "gain")[0]
        return RationalPlant([gain * c for c in top], polynomial_of_roots(source.poles, "poles"), step)
    if getattr(source.num, "ndim", 1) > 1:
        return plant_of_transfers([[_ratio(top, source.den, step)] for top in source.num])
    return _ratio(source.num, source.den, step)
