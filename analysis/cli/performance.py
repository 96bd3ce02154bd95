"""The commands about what a stable loop does: ``gain``, ``rate``, ``steady``, ``region``."""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.loops import Criterion
from lure.analysis.cli.options import (
    Figure,
    Force,
    Json,
    Output,
    Quiet,
    Seconds,
    Settings,
    Verbose,
    app,
    check_figure,
    check_target,
    exit_status,
    loop_named,
    option,
)
from lure.errors import AssumptionError, InputError
from lure.record import exact_text

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.questions.decay import RateBound
    from lure.analysis.questions.energy import Overshoot
    from lure.analysis.questions.gain import GainBound
    from lure.analysis.questions.steady import SteadyResponse
    from lure.files.system import LoopSystem

_SHARES = (0.9, 0.5, 0.1)  # of the rate, at which a number c is looked for


def _certificate(text: str) -> object:
    """The option for the file of a certificate."""
    return option("-o --output --certificate", "FILE", text)


@app.command(help=texts.GAIN)
def gain(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A TOML file, with a table [performance] or without.")
    ],
    output: Annotated[Path | None, _certificate("Write the certificate of the bound, or that there is none.")] = None,
    witness: Annotated[Path | None, option("--witness", "FILE", "Write that of the member with a large gain.")] = None,
    force: Force = False,
    criterion: Criterion = "best",
    window: Annotated[int | None, option("--window", "N", "In discrete time: constraints over N samples.")] = None,
    incremental: Annotated[
        bool, typer.Option("--incremental", help="The gain of differences of two solutions.")
    ] = False,
    worst: Annotated[
        bool, typer.Option("--worst", help="Look for disturbances with gains that jump too, of classes that may.")
    ] = False,
    energy: Annotated[
        bool, typer.Option("--energy", help="Also the energy of z after a push, and its peak for an energy of w.")
    ] = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the L2 gain from w to z, from both sides."""
    chosen = loop_named(system, set_)
    check_target(output, witness, force=force)
    from lure.analysis.questions.gain import l2_gain

    out = Output(as_json=as_json, quiet=quiet, verbose=verbose, replace=force)
    with out.progress() as tell:
        ways: dict[str, Any] = {"criterion": criterion, "window": window, "incremental": incremental, "worst": worst}
        found = l2_gain(chosen, **ways, seconds=seconds, progress=tell)
        if energy:
            from lure.analysis.questions.energy import energy_bounds

            beside = energy_bounds(chosen)
    more, said = ({"energy": beside.to_dict()}, [str(beside)]) if energy else ({}, [])
    out.results(found.to_dict() | more, [str(found), *said])
    shown, begin = found.proof or found.refutation, "The" if found.proof else "No bound is proved; the"
    out.certificate(output, shown, _side(found, shown), begin=begin)
    out.certificate(witness, found.refutation, _side(found, found.refutation))
    return exit_status(found.verdict)


def _side(found: GainBound, shown: Proved | Refuted | None) -> str:
    """Which side of the gain a certificate is of."""
    from lure.analysis.numerics.doubles import bound_above, bound_below
    from lure.analysis.verdict import Verdict

    if shown is None:
        return "of this side of the gain"
    if shown is found.proof:
        return f"that the gain is at most {bound_above(found.gain.high)}"
    if found.factors.verdict is Verdict.REFUTED:
        return "that no gain is finite" if found.verdict is Verdict.REFUTED else "of the unstable member"
    return f"that a member has a gain above {bound_below(found.gain.low)}"


@app.command(help=texts.RATE)
def rate(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.")],
    output: Annotated[Path | None, _certificate("Write the certificate of the rate, or that there is none.")] = None,
    force: Force = False,
    constant: Annotated[
        bool, typer.Option("--constant", help="Also the number c, at .9 of the rate or less; needs A, B, C.")
    ] = False,
    worst: Annotated[
        bool, typer.Option("--worst", help="Look for slower solutions, in discrete time, of a phi with slope bounds.")
    ] = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the decay rate, from both sides."""
    chosen = loop_named(system, set_)
    if chosen.open:
        raise InputError(
            f"{system} has no class of nonlinearities, of which a rate could be shown; give one, such as [class] with "
            "sector = [0, 1]"
        )
    check_target(output, force=force)
    from lure.analysis.questions.decay import decay_rate
    from lure.analysis.questions.energy import require_states

    if constant:
        require_states(chosen.block)
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose, replace=force)
    with out.progress() as tell:
        found = decay_rate(chosen, worst=worst, seconds=seconds, progress=tell)
        beside, said = _constant(chosen, found) if constant else (None, "")
    more = {"constant": beside.to_dict() if beside else None} if constant else {}
    out.results(found.to_dict() | more, [str(found), *([said] if constant else [])])
    shown, what, begin = _shown(found)
    out.certificate(output, shown, what, begin=begin)
    return exit_status(found.verdict)


def _shown(found: RateBound) -> tuple[Proved | Refuted | None, str, str]:
    """The certificate of the answer, of what it is, and how a sentence about it begins."""
    from lure.analysis.verdict import Verdict

    if found.proof and found.verdict is Verdict.PROVED:
        return found.proof, "of the rate that is proved", "The"
    other = found.verdict is Verdict.REFUTED or found.proof is None
    shown, what = (
        (found.refutation, "of the member that is no faster") if other else (found.proof, "of the bound of growth")
    )
    begin = "Not every solution decays; the" if found.verdict is Verdict.REFUTED else "No decay is proved; the"
    return shown, what if shown else "of a rate", begin


def _states(block: object) -> list[str]:
    """What ``x`` is, where the file has a transfer function in place of matrices."""
    from lure.plants.rational import RationalPlant
    from lure.plants.realisation import companion

    if not isinstance(block, RationalPlant) or block.matrices is not None:
        return []
    row = ", ".join(map(exact_text, companion(block).c))
    return [f"x is the state of the companion form of the transfer function, with C = [{row}]."]


def _constant(loop: LoopSystem, found: RateBound) -> tuple[Overshoot | None, str]:
    """The number ``c`` at nine tenths of a decay that is proved, or at less of it, and a sentence about it."""
    from lure.analysis.questions.energy import overshoot
    from lure.analysis.verdict import Verdict

    if found.verdict is not Verdict.PROVED:
        return None, "No number c is given, since no decay is proved."
    if found.proof is not None and "late" in found.proof.certificate["system"]:
        return None, "No number c is given: beside dead time no quadratic function of x(0) shows the rate."
    for share in _SHARES:
        rate = found.rate.high**share if found.time == "discrete" else share * found.rate.low
        with suppress(AssumptionError):
            shown = overshoot(loop, rate=Fraction(f"{rate:.6g}"))
            return shown, str(shown)
    return None, f"No number c is given: no quadratic function shows even {_SHARES[-1]:g} of the rate."


@app.command(help=texts.STEADY)
def steady(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A TOML file, with a table [forcing] for amplitudes.")
    ],
    amplitude: Annotated[str | None, option("--amplitude", "A", "Of the sine, in place of forcing.amplitude.")] = None,
    omega: Annotated[
        str | None, option("--omega", "W", "Its frequencies [rad/s]: 2, or 0.5,1,2, or 0.1:10:40.")
    ] = None,
    output: Annotated[Path | None, _certificate("Write the certificate of the answer, if it has one.")] = None,
    plot: Figure = None,
    csv: Annotated[Path | None, option("--csv", "FILE", "Write the amplitudes as a table, a row a response.")] = None,
    force: Force = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print whether one solution attracts all others, and how large it is."""
    chosen = loop_named(system, set_, of_rods="response")
    if chosen.open:
        raise InputError(
            f"{system} has no nonlinearity and no class of them; give one, such as [class] with slope = [0, 1]"
        )
    check_figure(plot, replace=force)
    check_target(output, csv, plot, force=force)
    from lure.analysis.questions.steady import steady_response

    given: dict[str, Any] = {} if chosen.forcing is None else chosen.forcing.stated
    if amplitude is not None:
        given["amplitude"] = _numbers(amplitude, "--amplitude")
    if omega is not None:
        given["omega"] = _frequencies(omega)
    for name, path in (("--plot", plot), ("--csv", csv)):
        if path is not None and not given:
            raise InputError(f"{name} needs an input to show the response to; give [forcing], or --amplitude")
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose, replace=force)
    with out.progress() as tell:
        found = steady_response(chosen, forcing=given or None, seconds=seconds, progress=tell)
    out.results(found.to_dict(), [str(found)])
    sides = {"PROVED": found.proof, "REFUTED": found.refutation}
    shown, against = sides.get(str(found.verdict)), str(found.verdict) == "REFUTED"
    what = "of the member whose differences do not decay" if against else "of the rate of attraction"
    what = what if shown else "of the answer"
    out.certificate(output, shown, what)
    if csv is not None:
        from lure.analysis.output import write_new

        write_new(csv, _table(found, str(given.get("unit", ""))), force=force)
        out.note(f"Written: {csv}")
    out.figure(plot, found.plot, (7.2, 4.4))
    return exit_status(found.verdict)


def _table(found: SteadyResponse, unit: str) -> str:
    """The responses as comma-separated values; a bound that is not known is left empty."""
    of = f" [{unit}]".replace(",", ";").replace('"', "") if unit else ""
    lines = [f"omega [rad/s],at least{of},at most{of},computed{of},periods of the input,evidence,only bounded solution"]
    for row in found.response:
        known = row.evidence.name == "CERTIFIED"
        ends = [repr(end) if known else "" for end in (row.low, row.high)]
        cells = [repr(row.omega), *ends, repr(row.computed), str(row.periods), str(row.evidence)]
        lines.append(",".join([*cells, "yes" if row.alone and known else ""]))
    return "\n".join(lines) + "\n"


def _numbers(text: str, name: str) -> list[Fraction]:
    """Numbers separated by commas."""
    try:
        return [Fraction(part.strip()) for part in text.split(",")]
    except (ValueError, ZeroDivisionError):
        raise InputError(f"{name} is {text!r:.60}; give a number such as 2, or several, 0.5,1,2") from None


def _frequencies(text: str) -> list[Fraction]:
    """A list, or from the first to the second in so many equal ratios."""
    parts = text.split(":")
    if len(parts) == 1:
        return _numbers(text, "--omega")
    try:
        low, high, count = Fraction(parts[0]), Fraction(parts[1]), int(parts[2]) if len(parts) > 2 else 25
        if len(parts) > 3 or not 0 < low < high or not 1 < count <= 1000:
            raise ValueError
    except (ValueError, ZeroDivisionError):
        raise InputError(
            f"--omega is {text!r:.60}; give first:last:how many, such as 0.1:10:40: two frequencies above 0, the "
            "smaller one first, and a number from 2 to 1000"
        ) from None
    step = (float(high) / float(low)) ** (1 / (count - 1))
    inner = [Fraction(f"{float(low) * step**i:.4g}") for i in range(1, count - 1)]
    return [low, *inner, high]


@app.command(help=texts.REGION)
def region(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.")],
    set_: Settings = None,
    along: Annotated[
        str | None, option("--along", "POINTS", "Hold the largest multiple of these, as '1 1; 1 -1'.")
    ] = None,
    output: Annotated[Path | None, _certificate("Write the certificate of the first set.")] = None,
    plot: Figure = None,
    force: Force = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print sets inside and outside of the region of attraction."""
    points = None if along is None else _points(along)
    check_figure(plot, replace=force)
    check_target(output, plot, force=force)
    chosen = loop_named(system, set_)
    from lure.analysis.questions.regions import region as run

    out = Output(as_json=as_json, quiet=quiet, verbose=verbose, replace=force)
    with out.progress():
        found = run(chosen, along=points, seconds=seconds)
    out.results(found.to_dict(), found.lines() + (_states(chosen.block) if found.sets or found.outside else []))
    shown = found.proof or found.linear
    what = "of the first set" if found.sets else "of the loop near 0" if shown else "of a set"
    out.certificate(output, shown, what)
    out.figure(plot, found.plot, (5.2, 4.4))
    return exit_status(found.verdict)


def _points(text: str) -> list[list[Fraction]]:
    """The points of the option, separated by semicolons."""
    from lure.plants import coefficients

    try:
        return [list(coefficients(part, "--along")) for part in text.split(";")]
    except InputError:
        raise InputError(f"--along is {text!r:.60}; give points such as '1 1; 1 -1', separated by semicolons") from None
