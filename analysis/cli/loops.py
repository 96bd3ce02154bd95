"""The commands about any Lur'e loop: ``analyse``, ``max-sector``, ``max-slope``."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.options import (
    Figure,
    Json,
    Output,
    Quiet,
    Replace,
    Seconds,
    Settings,
    Verbose,
    app,
    check_figure,
    exit_status,
    loop_named,
    option,
    print_json,
)
from lure.errors import InputError

if TYPE_CHECKING:
    from lure.analysis.inequality.gains import GainInterval
    from lure.analysis.questions import StabilityBound
    from lure.analysis.theorems.kernel_limit import MultiplierLimit
    from lure.analysis.verdict import Bracket, Witness
    from lure.classes import NonlinearityClass
    from lure.files.system import LoopSystem
    from lure.plants.rational import RationalPlant

# The answers of ``lure max-sector`` and ``lure max-slope`` in a few lines to quote.

WIDTH = 80


def lines(found: StabilityBound, *, stable: Sequence[GainInterval] | None) -> list[str]:
    """What is proved, what is refuted, the linear limit, the multiplier and, where nothing is proved, why.

    Parameters
    ----------
    found : StabilityBound
        The answer.
    stable : sequence of GainInterval or None
        The intervals of stable linear gains, None if they were not computed.
    """
    from lure.analysis.verdict import Verdict

    if found.classes is not None:
        return _factors(found)
    proved, refuted = found.verdict is Verdict.PROVED, found.verdict is Verdict.REFUTED
    said = [_claim(found)]
    if found.witness is not None:
        if refuted:
            said = [f"{said[0][:-1]}: {refutation(found.trivial or found.witness)}."]
            if found.trivial is not None:
                said.append(f"From k = {found.witness_text} on also {refutation(found.witness)}.")
        else:
            said.append(f"Refuted from {found.refuted_text} on: {refutation(found.witness)}.")
        if proved and not found.closed:
            said.append("Nothing was shown in between.")
    if stable is not None and not stable:
        said.append("No linear gain makes the loop stable.")
    elif not refuted and (gains := linear(found.hurwitz, found.lower)):
        said.append(gains)
    if proved and found.multiplier and found.multiplier != "1":
        theta = "" if found.theta is None or "theta" not in found.multiplier else f", theta = {found.theta:.7g}"
        kind = "Lyapunov function" if found.multiplier.startswith("V ") else "Multiplier"
        said.append(f"{kind}: {found.multiplier}{theta}.")
    if found.unfinished:
        said.append(found.unfinished)
    if not proved and found.reason:
        said.append(f"Reason: {found.reason}.")
    if refuted and stable:
        where = " and ".join(map(str, stable))
        said.append(f"Linear gains in {where} are stable; begin the class there, as with --lower={stable[0].sample}.")
    return _wrapped(said)


def _wrapped(said: Sequence[str]) -> list[str]:
    joined = [text.replace("phi = ", "phi\xa0=\xa0").replace("k = ", "k\xa0=\xa0") for text in said]
    joined = [re.sub(r"(\[[^,\]\s]+), ", "\\1,\xa0", text) for text in joined]
    wrapped = [line for text in joined for line in textwrap.wrap(text, WIDTH, break_on_hyphens=False)]
    return [line.replace("\xa0", " ") for line in wrapped]


def _factors(found: StabilityBound) -> list[str]:
    """The same of several channels, whose upper bounds are multiplied by one factor."""
    from lure.analysis.verdict import Verdict

    proved, refuted = found.verdict is Verdict.PROVED, found.verdict is Verdict.REFUTED
    tried = ", the largest tried" if found.search_limited else ""
    said = [f"Classes: {found.classes}; every upper bound times k."]
    alone = found.classes is not None and found.classes.rectified
    if proved:
        span = f"for k = {found.proved_text} alone" if alone else f"up to k = {found.proved_text}{tried}"
        said.append(f"Proved {span}, by {found.criterion} ({found.evidence}).")
        said.append(found.conclusion.headline)
    else:
        said.append("Not stable whatever k." if refuted else f"Nothing is proved: {found.reason}.")
    if found.witness is not None:
        at = f"at k = {found.refuted_text}" if alone else f"from k = {found.refuted_text} on"
        where = "" if refuted else f"Refuted {at}: "
        text = f"{where}{found.witness.description} ({found.witness.evidence})."
        said.append(f"{text[0].upper()}{text[1:]}")
    elif proved:
        said.append("No destabilising member was found, which proves nothing.")
    if proved and found.witness is not None and not found.closed:
        said.append("Nothing was shown in between.")
    if found.unfinished:
        said.append(found.unfinished)
    return _wrapped(said)


def _claim(found: StabilityBound) -> str:
    from lure.analysis.numerics.doubles import bound_above, bound_below
    from lure.analysis.verdict import Verdict

    low, outwards = found.largest.low, found.verdict is Verdict.REFUTED
    classes = f"{found.about} [{(bound_below if outwards else bound_above)(found.lower)}, k]"
    if found.verdict is Verdict.PROVED:
        tried = ", the largest k tried" if found.search_limited else ""
        return f"{found.conclusion.headline[:-1]}{tried}, by {found.criterion} ({found.evidence})."
    if found.verdict is Verdict.REFUTED:
        return f"Not stable for every {classes}, {found.refuted_ends.partition(' > ')[0]}."
    if low > found.lower:
        reached = f"{found.criterion} holds up to {bound_below(low)}, {found.evidence} only"
        return f"Nothing is proved for {classes}; {reached}."
    return f"Nothing is proved for {classes}."


def refutation(witness: Witness) -> str:
    """What a destabilising nonlinearity is and does, linear ones in short."""
    nonlinearity, colon, rest = witness.description.partition(": ")
    gain = witness.data.get("gain")
    if witness.kind == "linear gain" and isinstance(gain, str) and colon:
        factor = {"1": "", "-1": "-"}.get(gain, f"{gain} ")
        nonlinearity = "without feedback (phi = 0)" if Fraction(gain) == 0 else f"with phi = {factor}sigma"
        if isinstance(values := witness.data.get("parameters"), Mapping):
            nonlinearity += f", {', '.join(f'{name} = {value}' for name, value in values.items())},"
        return f"{nonlinearity} {rest} ({witness.evidence})"
    return f"{witness.description} ({witness.evidence})"


def linear(limit: Bracket, lower: Fraction) -> str:
    """For which linear gains above ``lower`` the loop is stable.

    Parameters
    ----------
    limit : Bracket
        Of the largest.
    lower : Fraction
        Where the classes begin.
    """
    from lure.analysis.numerics.doubles import bound_above, bound_below

    if limit.high <= lower:
        return "Linear gains at the lower end of the class are not stable."
    if limit.low == math.inf:
        return "Every larger linear gain is stable." if lower else "Every positive linear gain is stable."
    said = f"Linear gains are stable up to {bound_below(limit.low)}"
    if limit.high == math.inf:
        return f"{said} at least." if limit.low > lower else ""
    if limit.high - limit.low > 1e-4 * abs(limit.high):
        return f"{said} at least, and not beyond {bound_above(limit.high)}."
    return f"{said}."


Num = Annotated[str | None, option("--num", "COEFFS", "Numerator of H, highest power first.")]
Den = Annotated[
    str | None,
    option("--den", "COEFFS", "Denominator of H, highest power first."),
]
Transfer = Annotated[
    str | None,
    option("--transfer", "FORMULA", 'H as a formula, e.g. "1/(s*(s+1))".'),
]
Dt = Annotated[
    str | None,
    option("--dt", "SECONDS", "Sampling time; without it time is continuous."),
]
System = Annotated[
    str | None,
    option("--system", "SYSTEM", "The same as SYSTEM."),
]
Named = Annotated[
    str | None,
    typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.", show_default=False),
]
Criterion = Annotated[
    str, typer.Option("--criterion", metavar="NAME", help="A criterion by name, or best: all that apply.")
]
Lower = Annotated[str, typer.Option("--lower", metavar="K1", help="Lower end of the classes [K1, k].")]


@app.command(help=texts.ANALYSE)
def analyse(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.")],
    set_: Settings = None,
    seconds: Seconds = None,
    plot: Figure = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Run every criterion and every search for a counterexample on a loop."""
    check_figure(plot, replace=replace)
    chosen = loop_named(system, set_)
    from lure.analysis.questions import analyse as run

    out = Output(as_json=as_json, quiet=quiet, verbose=verbose, replace=replace)
    with out.progress() as tell:
        found = run(chosen, seconds=seconds, progress=tell)
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)
    size = (6.4, 4.0) if found.map is None else (4.8, 4.2)
    out.figure(plot, (found if found.map is None else found.map).plot, size)
    return exit_status(found.verdict)


def _one_system(named: str | None, system: str | None) -> str | None:
    """The system that is named, as an argument or by ``--system``."""
    if named is not None and system is not None:
        raise InputError(f"the system is given twice, {named} and --system {system}; give one of them")
    return named if system is None else system


@app.command("max-sector", help=texts.MAX_SECTOR)
def max_sector(
    named: Named = None,
    num: Num = None,
    den: Den = None,
    transfer: Transfer = None,
    dt: Dt = None,
    system: System = None,
    criterion: Criterion = "best",
    lower: Lower = "0",
    time_varying: Annotated[bool, typer.Option("--time-varying", help="Let phi depend on time.")] = False,
    full: Annotated[bool, typer.Option("--full", help="Search for nonlinear counterexamples too.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the largest sector."""
    system = _one_system(named, system)
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose)
    given = {"--lower": lower != "0", "--time-varying": time_varying, "--full": full}
    several = _several(system, (num, den, transfer, dt), given)
    if several is not None:
        return _largest_factor(several, "sector", criterion, seconds, out)
    block, own = block_of(num, den, transfer, dt, system), _class_of(system)
    from lure.analysis.questions import max_sector as run

    with out.progress() as tell:
        found = run(
            block,
            criterion=criterion,
            lower=_lower(lower, None if own is None else own.gains[0]),
            time_varying=time_varying or (own is not None and own.time_varying),
            search="full" if full else "linear",
            seconds=seconds,
            progress=tell,
        )
    return _print(found, block, as_json=as_json)


@app.command("max-slope", help=texts.MAX_SLOPE)
def max_slope(
    named: Named = None,
    num: Num = None,
    den: Den = None,
    transfer: Transfer = None,
    dt: Dt = None,
    system: System = None,
    odd: Annotated[bool, typer.Option("--odd", help="Assume that phi is odd.")] = False,
    criterion: Criterion = "best",
    lower: Lower = "0",
    limits: Annotated[bool, typer.Option("--limits", help="Say what no multiplier proves.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the largest slope."""
    system = _one_system(named, system)
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose)
    given = {"--lower": lower != "0", "--odd": odd, "--limits": limits}
    several = _several(system, (num, den, transfer, dt), given)
    if several is not None:
        return _largest_factor(several, "slope", criterion, seconds, out)
    block, own = block_of(num, den, transfer, dt, system), _class_of(system)
    slope = None if own is None else own.slope
    odd, least = odd or (own is not None and own.odd), _lower(lower, None if slope is None else slope.lower)
    if limits:
        _check_limits(block)
    from lure.analysis.questions import max_slope as run

    with out.progress() as tell:
        found = run(block, odd=odd, criterion=criterion, lower=least, seconds=seconds, progress=tell)
    if not limits:
        return _print(found, block, as_json=as_json)
    limit = _limit(found, block)
    if as_json:
        print_json(found.to_dict() | {"multiplier_limit": None if limit is None else limit.to_dict()})
        return exit_status(found.verdict)
    status = _print(found, block, as_json=False)
    print("\n".join(_wrapped([_NO_LIMIT if limit is None else str(limit)])))
    return status


_NO_LIMIT = "No slope was found from which on no multiplier of Zames and Falb proves anything."


def _check_limits(block: object) -> None:
    from lure.plants.rational import RationalPlant

    if not isinstance(block, RationalPlant) or block.dt is not None:
        raise InputError(
            "--limits is for rational blocks in continuous time; in discrete time --criterion zames-falb tells it"
        )


def _limit(found: StabilityBound, block: object) -> MultiplierLimit | None:
    """The slope from which no multiplier proves anything, where there may be one."""
    from lure.analysis.theorems.kernel_limit import multiplier_limit
    from lure.analysis.verdict import Verdict

    if found.closed or found.verdict is not Verdict.PROVED:
        return None
    return multiplier_limit(
        cast("RationalPlant", block),
        odd=found.odd,
        lower=found.lower,
        above=found.largest.low,
        below=min(found.hurwitz.high, math.inf if found.refuted_at is None else found.refuted_at),
    )


def _several(system: str | None, parts: Sequence[str | None], given: Mapping[str, bool]) -> LoopSystem | None:
    """The system if it has several channels; else None.

    Raises
    ------
    InputError
        What the classes of its channels say is given by an option as well.
    """
    if system is None or any(part is not None for part in parts):
        return None
    found = loop_named(system, None)
    own = found.nonlinearity_class
    alone = own is not None and (own.linear or (own.time_varying and own.slope is not None))  # as for several channels
    if not alone and not found.several:
        return None
    for name, said in given.items():
        if said:
            whose = f"says of its own that it is {own}" if alone else f"has {found.channels} channels"
            raise InputError(f"{name} is for one nonlinearity, and {system} {whose}; say it in the [[class]] of each")
    return found


def _class_of(system: str | None) -> NonlinearityClass | None:
    """The class of a system with one channel, which says what the options leave out; None if it has none."""
    return None if system is None else loop_named(system, None).nonlinearity_class


def _lower(text: str, own: Fraction | float | None) -> Fraction:
    """The option ``--lower``; where it is 0, as by default, the finite lower bound of the class of the system."""
    given = number_of(text)
    return given if given or own is None or not math.isfinite(own) else Fraction(own)


def _largest_factor(
    system: LoopSystem,
    kind: Literal["sector", "slope"],
    criterion: str,
    seconds: float | None,
    out: Output,
) -> int:
    """Print the largest factor of the classes of a system with several channels."""
    from lure.analysis.questions.answers import answer
    from lure.analysis.questions.channel_problem import channel_problem
    from lure.analysis.questions.largest import StabilityBound

    own = system.nonlinearity_class
    plant, given = (system, None) if own is None else (system.block, [own])
    problem = channel_problem(plant, given, kind=kind, criterion=criterion, late=True)
    with out.progress() as tell:
        found = answer(problem, seconds=seconds, progress=tell)
    assert isinstance(found, StabilityBound), "a largest factor was asked for"
    return _print(found, None, as_json=out.as_json)


def block_of(
    num: str | None,
    den: str | None,
    transfer: str | None,
    dt: str | None,
    system: str | None,
) -> object:
    """The block that the options describe.

    Parameters
    ----------
    num, den, transfer, dt, system : str or None
        The options of these names.

    Raises
    ------
    InputError
        The block is given more than once or not at all, or an option is no good.
    """
    from lure.plants.conversion import one_channel

    given = [
        name
        for name, value in (("--num and --den", num or den), ("--transfer", transfer), ("the system", system))
        if value is not None
    ]
    if len(given) != 1:
        raise InputError(
            "give the block once, by --num and --den, by --transfer or by a TOML file or a built-in system"
            + (f"; got {' and '.join(given)}" if given else "")
        )
    step = None if dt is None else _step(dt)
    if system is not None:
        if step is not None:
            raise InputError("--dt belongs to --num and --den or --transfer; a system has its own sampling time")
        return loop_named(system, None).block
    if transfer is not None:
        return one_channel(transfer, dt=step)
    if num is None or den is None:
        raise InputError(f"--num and --den go together; give --{'den' if den is None else 'num'} too")
    return one_channel((num, den), dt=step)


def number_of(text: str, name: str = "--lower") -> Fraction:
    """The one exact number an option holds.

    Parameters
    ----------
    text : str
        Its value.
    name : str
        The option, for the sentence of a refusal.

    Raises
    ------
    InputError
        It is not one number.
    """
    from lure.plants import coefficients

    try:
        values = coefficients(text)
    except InputError:
        values = ()  # the sentence below names the option
    if len(values) != 1:
        raise InputError(f"{name} is {text!r:.60}; give one number such as 2, -0.5, 1e-3 or 2/3")
    return values[0]


def _step(text: str) -> Fraction:
    step = number_of(text, "--dt")
    if step <= 0:
        raise InputError(f"--dt is {text!r:.60}; give a positive sampling time, or leave it out for continuous time")
    return step


def _print(found: StabilityBound, block: object, *, as_json: bool) -> int:
    if as_json:
        print_json(found.to_dict())
        return exit_status(found.verdict)
    from lure.analysis.inequality.gains import gain_intervals
    from lure.plants.rational import RationalPlant

    stable = gain_intervals(block) if isinstance(block, RationalPlant) else None
    print("\n".join(lines(found, stable=stable)))
    return exit_status(found.verdict)
