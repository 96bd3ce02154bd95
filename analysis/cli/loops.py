"""The commands about any Lur'e loop: ``analyse``, ``max-sector``, ``max-slope``."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from analysis.cli import texts
from analysis.cli.commands import Json, Quiet, Seconds, Settings, Verbose, check_seconds
from analysis.cli.commands import app as app
from analysis.cli.refused import refused

if TYPE_CHECKING:
    from fractions import Fraction

    from analysis.answers import Largest
    from analysis.evidence import Verdict

Num = Annotated[
    str | None, typer.Option("--num", metavar="COEFFS", help="Numerator of H, highest power first.", show_default=False)
]
Den = Annotated[
    str | None,
    typer.Option("--den", metavar="COEFFS", help="Denominator of H, highest power first.", show_default=False),
]
Transfer = Annotated[
    str | None,
    typer.Option("--transfer", metavar="FORMULA", help='H as a formula, e.g. "1/(s*(s+1))".', show_default=False),
]
Dt = Annotated[
    str | None,
    typer.Option("--dt", metavar="SECONDS", help="Sampling time; without it time is continuous.", show_default=False),
]
System = Annotated[
    str | None,
    typer.Option("--system", metavar="SYSTEM", help="A TOML file or a built-in system instead.", show_default=False),
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
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Run every criterion and every search for a counterexample on a loop."""
    check_seconds(seconds)
    from lure.system_file import find_system
    from lure.systems_loop import LoopSystem

    chosen = find_system(system, set_ or [])
    if not isinstance(chosen, LoopSystem):
        raise refused(f"{system} is a rod; run: lure report {system}")
    from analysis.answers import analyse as run
    from analysis.answers.document import analysis_dict
    from analysis.cli.progress import progress
    from analysis.report.loop.plain import plain

    with progress(quiet=quiet, verbose=verbose) as tell:
        found = run(chosen, seconds=seconds, progress=tell)
    print(_json(plain(analysis_dict(found))) if as_json else f"{found}")
    return _status(found.verdict)


@app.command("max-sector", help=texts.MAX_SECTOR)
def max_sector(
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
    check_seconds(seconds)
    block = block_of(num, den, transfer, dt, system)
    from analysis.answers import max_sector as run
    from analysis.cli.progress import progress

    with progress(quiet=quiet, verbose=verbose) as tell:
        found = run(
            block,
            criterion=criterion,
            lower=number_of(lower),
            time_varying=time_varying,
            search="full" if full else "linear",
            seconds=seconds,
            progress=tell,
        )
    return _print(found, block, as_json=as_json)


@app.command("max-slope", help=texts.MAX_SLOPE)
def max_slope(
    num: Num = None,
    den: Den = None,
    transfer: Transfer = None,
    dt: Dt = None,
    system: System = None,
    odd: Annotated[bool, typer.Option("--odd", help="Assume that phi is odd.")] = False,
    criterion: Criterion = "best",
    lower: Lower = "0",
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the largest slope."""
    check_seconds(seconds)
    block = block_of(num, den, transfer, dt, system)
    from analysis.answers import max_slope as run
    from analysis.cli.progress import progress

    with progress(quiet=quiet, verbose=verbose) as tell:
        found = run(block, odd=odd, criterion=criterion, lower=number_of(lower), seconds=seconds, progress=tell)
    return _print(found, block, as_json=as_json)


def block_of(
    num: str | None,
    den: str | None,
    transfer: str | None,
    dt: str | None,
    system: str | None,
    *,
    alternative: str = "--system",
) -> object:
    """The block that the options describe.

    Parameters
    ----------
    num, den, transfer, dt, system : str or None
        The options of these names.
    alternative : str
        How a system is named, for the sentence of a refusal.

    Raises
    ------
    refused
        An ``InputError``: the block is given more than once or not at all, or an option is no good.
    """
    from lure.inputs import as_block
    from lure.system_file import find_system
    from lure.systems_loop import LoopSystem

    given = [
        name
        for name, value in (("--num and --den", num or den), ("--transfer", transfer), ("--system", system))
        if value is not None
    ]
    if len(given) != 1:
        raise refused(
            f"give the block once, by --num and --den, by --transfer or by {alternative}"
            + (f"; got {' and '.join(given)}" if given else "")
        )
    step = None if dt is None else _step(dt)
    if system is not None:
        if step is not None:
            raise refused("--dt belongs to --num and --den or --transfer; a system has its own sampling time")
        chosen = find_system(system, [])
        if not isinstance(chosen, LoopSystem):
            raise refused(f"{system} is a rod; run: lure report {system}")
        return chosen.block
    if transfer is not None:
        return as_block(transfer, dt=step)
    if num is None or den is None:
        raise refused(f"--num and --den go together; give --{'den' if den is None else 'num'} too")
    return as_block((num, den), dt=step)


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
    refused
        An ``InputError``: it is not one number.
    """
    from lure.errors import InputError
    from lure.inputs import coefficients

    try:
        values = coefficients(text)
    except InputError:
        values = ()  # the sentence below names the option
    if len(values) != 1:
        raise refused(f"{name} is {text!r:.60}; give one number such as 2, -0.5, 1e-3 or 2/3")
    return values[0]


def _step(text: str) -> Fraction:
    step = number_of(text, "--dt")
    if step <= 0:
        raise refused(f"--dt is {text!r:.60}; give a positive sampling time, or leave it out for continuous time")
    return step


def _print(found: Largest, block: object, *, as_json: bool) -> int:
    if as_json:
        from analysis.report.loop.plain import plain

        print(_json(plain(found.to_dict())))
        return _status(found.verdict)
    from analysis.cli.answers import lines
    from analysis.criteria.hurwitz import gain_intervals
    from lure.rational import RationalBlock

    stable = gain_intervals(block) if isinstance(block, RationalBlock) else None
    print("\n".join(lines(found, stable=stable)))
    return _status(found.verdict)


def _json(data: dict[str, Any]) -> str:
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)


def _status(verdict: Verdict) -> int:
    return {"PROVED": 0, "INCONCLUSIVE": 10, "REFUTED": 11}[str(verdict)]
