"""One question, one certificate: the proof or the refutation of exactly the class asked about, or a code."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, cast, get_args

from lure.analysis.certificates.checker import ORIGINS
from lure.analysis.certificates.proposals import Numbers
from lure.analysis.questions.answers import answer
from lure.analysis.questions.channel_kinds import has_channels
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.conclusion import Certification as Certification
from lure.analysis.questions.problem import class_given, loop_given, posed
from lure.errors import InputError
from lure.record import described, quantity

Method = Literal["best", "polynomial", "matrix", "cover", "structure"]
METHODS: tuple[str, ...] = get_args(Method)
_ORDER = (
    *("format", "verdict", "convention", "numbers", "system", "laws", "law", "theorem", "multiplier", "rate"),
    *("conclusion", "hypotheses", "proof"),
)


@described(frozen=True, kw_only=True, slots=True)
class ProofOptions:
    """How to look for a proof.

    Raises
    ------
    InputError
        There is no such method or origin, or no time at all is allowed.
    """

    criterion: str = quantity(
        "A criterion by name, or ``best``: all that apply, cheapest first.  ``hurwitz`` is about linear gains alone",
        default="best",
    )
    method: Method = quantity("The kind of proof", default="best")
    finite: bool = quantity(
        "Whether an infinite upper end means every nonlinearity with some finite bound, whichever", default=False
    )
    seconds: float | None = quantity("Time allowed; None for no limit", default=None)
    numbers: Numbers = quantity("Where the numbers came from, for the file", default="rationals")

    def __post_init__(self) -> None:
        for name, value, known in (("method", self.method, METHODS), ("numbers", self.numbers, ORIGINS)):
            if value not in known:
                raise InputError(f"Ways.{name} is {value!r:.40}; choose from {', '.join(known)}")
        if self.seconds is not None and not 0 < self.seconds < math.inf:
            raise InputError(f"Ways.seconds is {self.seconds}; give a positive number, or None for no limit")


def certify(
    loop: object,
    nonlinearity: object = None,
    *,
    ways: ProofOptions | None = None,
    progress: Callable[[str], None] | None = None,
) -> Certification:
    r"""A certificate for one loop and one class of nonlinearities, ``sigma = H mu``, ``mu = -phi(sigma)``.

    A search proposes, the checker decides.  Whatever happens inside a search, an exception of a solver, NaN, too few
    digits, the end of the time allowed, ends INCONCLUSIVE with a code and never as a proof.

    Parameters
    ----------
    loop : LoopSystem, LoopModel, Loop, or anything :func:`lure.plants.as_plant` takes
        The loop.
    nonlinearity : object
        The class of nonlinearities, as a ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``; by default that of the
        loop, or the smallest that its nonlinearity is known to belong to.  Or, around a block, a nonlinearity: an
        object, a formula as text, ``control.saturation_nonlinearity``.  For several channels: a list of classes, in
        order, or a ``Diagonal``.
    ways : Ways, optional
        Which criterion, which kind of proof, how long.
    progress : callable, optional
        Told the name of each search as it begins.

    Returns
    -------
    Certification
        PROVED or REFUTED with a certificate about exactly this class, or a larger one that contains it; else
        INCONCLUSIVE with a code.

    Raises
    ------
    InputError
        The loop or the class is no good, no class is given, or there is no such criterion.

    Notes
    -----
    Linear gains are tried first, then the criteria, cheapest first, then the searches for counterexamples.

    Examples
    --------
    >>> from lure import Sector
    >>> print(certify(([1], [1, 3, 2, 0]), Sector(0, 5)).verdict)
    PROVED
    """
    chosen = ways or ProofOptions()
    told = None if progress is None else lambda step, _done: progress(step)
    if has_channels(loop, nonlinearity):
        problem = channel_problem(loop, nonlinearity, criterion=chosen.criterion, late=True)
        if problem.kind != "class":
            raise InputError("no class of nonlinearities is given; give one for each channel, in order")
        return cast("Certification", answer(problem, seconds=chosen.seconds, numbers=chosen.numbers, progress=told))
    nonlinearity_class = class_given(nonlinearity)
    if nonlinearity_class is None:
        loop = loop_given(loop, nonlinearity)
    problem = posed(loop, nonlinearity_class, criterion=chosen.criterion, finite=chosen.finite, method=chosen.method)
    return cast("Certification", answer(problem, seconds=chosen.seconds, numbers=chosen.numbers, progress=told))


def text_of(certificate: Mapping[str, Any]) -> str:
    """A certificate as the text of a file, ASCII, a key a line, in the order of the format.

    Parameters
    ----------
    certificate : Mapping
        A certificate.
    """
    ordered = sorted(certificate.items(), key=lambda item: _ORDER.index(item[0]) if item[0] in _ORDER else len(_ORDER))
    entries = (f"{json.dumps(key)}: {_value(value)}" for key, value in ordered)
    return "{\n" + ",\n".join(entries) + "\n}\n"


def _value(value: object) -> str:
    if isinstance(value, Mapping) and len(value) > 1:
        return "{\n" + ",\n".join(f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in value.items()) + "\n}"
    return json.dumps(value)
