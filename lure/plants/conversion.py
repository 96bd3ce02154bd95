"""One door for linear blocks: whatever describes a system becomes one of the block types."""

from __future__ import annotations

import re
import reprlib
import sys
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from types import ModuleType
from typing import Literal, cast

from lure.errors import InputError
from lure.plants.block import LinearBlock
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.matrices import MAX_EXACT_STATES, float_block, rational_block
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Names, names_of
from lure.plants.state_space import MAX_STATES, StateSpace
from lure.plants.text import coefficients, parse_transfer, polynomial_of_roots, sampling_time

# The exact block behind whatever a user has, for what can only be done exactly.


def exact_block(source: object, what: str) -> RationalPlant:
    """The rational block that ``source`` describes.

    Parameters
    ----------
    source : object
        Whatever :func:`lure.as_plant` takes.
    what : str
        What needs it, for the error.

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
    found = as_plant(source)
    if not isinstance(found, RationalPlant):
        raise InputError(
            f"{what} needs exact coefficients, and a {type(found).__name__} has none; give coefficients, matrices of "
            "up to 60 states, or a formula without dead time"
        )
    return found


AnyBlock = RationalPlant | StateSpace | DelayPlant | FrequencyData
"""Every kind of block that :func:`lure.as_plant` returns."""

Step = Fraction | Literal[True] | None
_EXPONENTIAL = re.compile(r"\bexp\s*\(")
_WANTED = (
    "give coefficients (num, den), matrices (A, B, C), a text such as '1/(s*(s+1))', a system of python-control or "
    "scipy.signal, or a RationalPlant"
)
_PAIR = "a block has one input and one output; choose a pair, e.g. sys[0, 0]"


def as_plant(source: object, *, dt: object = None) -> AnyBlock:
    """The linear block that ``source`` describes, exact wherever it can be.

    Parameters
    ----------
    source : object
        - a ``RationalPlant``, ``StateSpace``, ``FrequencyData`` or ``DelayPlant``: returned as it is;
        - ``(num, den)``: lists or texts of coefficients, highest power first;
        - ``(A, B, C)`` or ``(A, B, C, D)``: ints, Fractions, floats, texts; nested lists or arrays;
        - a formula: ``"1/(s*(s+1))"``, ``"z/(z-0.5)"``; with ``exp(-T*s)`` it becomes a ``DelayPlant``;
        - ``control.TransferFunction``, ``StateSpace``, ``FrequencyResponseData``; ``scipy.signal`` ``lti``, ``dlti``;
        - a ``LinearPlant``, from ``mu`` to ``sigma``.

        A float is the double it is.
    dt : None, 0, True or number
        Sampling time [s] in python-control's convention: None leaves it to the source (continuous time if that says
        nothing), 0 is continuous, True discrete of unspecified period, which counts as 1.

    Returns
    -------
    RationalPlant, StateSpace, DelayPlant or FrequencyData
        Matrices of up to 60 states become an exact ``RationalPlant``, which keeps them and their names in ``matrices``,
        larger ones a ``StateSpace`` in floating point.  ``FrequencyData`` can never carry a certificate.

    Raises
    ------
    InputError
        One sentence: the system is nonlinear, improper, empty, too large, has several inputs or outputs, complex,
        infinite or nan entries, matrices that do not fit, or a sampling time that contradicts ``dt``.

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
    if isinstance(source, RationalPlant | StateSpace | DelayPlant | FrequencyData):
        own = None if isinstance(source, DelayPlant) else source.dt
        sampling_time(dt, 0 if own is None else own, name="the block")
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
        return _from_parts(source, dt)
    if callable(source):
        raise InputError(
            "a function H(s) is known only where it is called, so that nothing can be shown with it; "
            f"{_WANTED}, 'exp(-s)/(s+1)' for a dead time, or control.FrequencyResponseData for samples"
        )
    if hasattr(source, "block"):
        raise InputError(f"a {type(source).__name__} is a block and what closes the loop; give its block, loop.block")
    raise InputError(f"{reprlib.repr(source)} is no linear block; {_WANTED}")


def _from_text(text: str, dt: object) -> RationalPlant | DelayPlant:
    if not _EXPONENTIAL.search(text):
        return parse_transfer(text, dt=dt)
    if sampling_time(dt) is not None:
        raise InputError("transfer: exp(-T*s) is a dead time in continuous time; write z**-n in discrete time")
    found = DelayPlant.parse(text.replace("^", "**"))
    return found.delayless or found


def _from_parts(parts: Sequence[object], dt: object) -> RationalPlant | StateSpace:
    """``(num, den)`` or ``(A, B, C[, D])``."""
    if len(parts) == 2:
        top, bottom = (coefficients(part, name) for part, name in zip(parts, ("numerator", "denominator"), strict=True))
        return RationalPlant(top, bottom, sampling_time(dt))
    if len(parts) not in (3, 4):
        raise InputError(f"a system of {len(parts)} parts is unknown; give (num, den) or (A, B, C) or (A, B, C, D)")
    if isinstance(parts[0], str):
        raise InputError("three or four parts are the matrices (A, B, C) or (A, B, C, D); give A as a list of rows")
    return _from_matrices(parts, sampling_time(dt))


def _from_matrices(parts: Sequence[object], dt: Step, names: Names | None = None) -> RationalPlant | StateSpace:
    A, B, C = parts[:3]
    D = parts[3] if len(parts) == 4 else None
    states = A.shape[0] if hasattr(A, "shape") and A.shape else len(A) if isinstance(A, Sequence) else 1
    if states > MAX_STATES:
        raise InputError(f"the system has {states} states; dense matrices stop at {MAX_STATES}")
    if states > MAX_EXACT_STATES:
        return replace(float_block(A, B, C, D, dt=dt), dt=cast("Fraction | None", dt), names=names)
    found = rational_block(A, B, C, D, dt=dt)
    if names is None or found.matrices is None:
        return found
    return RationalPlant(found.numerator, found.denominator, dt, matrices=replace(found.matrices, names=names))


def _from_control(control: ModuleType, source: object, dt: object) -> RationalPlant | StateSpace | FrequencyData | None:
    if not isinstance(source, control.InputOutputSystem):
        return None
    if not isinstance(source, control.FrequencyResponseData | control.TransferFunction | control.StateSpace):
        raise InputError(
            f"{source.name} is a nonlinear system of python-control; linearise it where it is to run: "
            "control.linearize(system, x, u) with a state x and an input u of equilibrium"
        )
    if (source.ninputs, source.noutputs) != (1, 1):
        raise InputError(f"the system has {source.ninputs} inputs and {source.noutputs} outputs: {_PAIR}")
    if isinstance(source, control.FrequencyResponseData):
        step, order = sampling_time(dt, source.dt, name="the data"), source.omega.argsort()
        return FrequencyData(source.omega[order], source.frdata[0, 0, order], None if step is None else Fraction(step))
    if isinstance(source, control.TransferFunction):
        step = sampling_time(dt, source.dt, name="the system")
        top, bottom = source.num_list[0][0], source.den_list[0][0]
        return RationalPlant(coefficients(top, "numerator"), coefficients(bottom, "denominator"), step)
    step = sampling_time(dt, source.dt, name="the system")
    return _from_matrices((source.A, source.B, source.C, source.D), step, names_of(source))


def _from_scipy(signal: ModuleType, source: object, dt: object) -> RationalPlant | StateSpace | None:
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
        raise InputError(f"the system has {len(source.num)} outputs: {_PAIR}")
    return RationalPlant(coefficients(source.num, "numerator"), coefficients(source.den, "denominator"), step)
