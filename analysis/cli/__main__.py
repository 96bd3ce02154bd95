"""From the arguments to an exit status: every failure becomes one sentence on stderr.

``python -m lure.analysis.cli`` is ``lure``.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import cast

import typer
from typer.core import TyperGroup

from lure.analysis.cli.options import app

# as ``lure --help`` lists them
for _commands in ("commands", "loops", "certificates", "performance", "sweeps", "sectors", "rods"):
    import_module(f"lure.analysis.cli.{_commands}")  # puts its commands on the one app
BUG, BAD_INPUT, INTERRUPTED, CLOSED_PIPE = 1, 2, 130, 141
LONGEST = 500  # signs of a refusal of arguments
USAGE_ERROR = cast(
    "type[Exception]", typer.BadParameter.__base__
)  # its module is typer's in one version, click's in another


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows ``lure``; from the command line by default.

    Returns
    -------
    int
        0 proved (or done), 10 inconclusive, 11 refuted; 2 bad input, 130 interrupted, 141 nobody reads the output,
        1 any other failure, which is a bug.  ``LURE_DEBUG=1`` in the environment adds the traceback to a 1.
    """
    # Matrices are small here: with a second thread a command takes up to twice the processor time, and ends no sooner.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is loaded, which is not yet
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # an old terminal must not turn a report into a bug
    try:
        status = _run(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # so that Python's own last flush succeeds
        return CLOSED_PIPE
    if status == INTERRUPTED:
        _say("interrupted")
    return status


@cache
def _command() -> TyperGroup:
    """The command and its options, which typer reads from the signatures: a tenth of a second."""
    return cast(TyperGroup, typer.main.get_command(app))


def _run(arguments: Sequence[str] | None) -> int:
    try:
        result = _command().main(arguments, prog_name="lure", standalone_mode=False)
        return result if isinstance(result, int) else 0
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        raise
    except SystemExit as error:  # typer's own: completion is done, or nobody reads the output
        if error.code in (0, None):
            return 0
        raise BrokenPipeError from error
    except USAGE_ERROR as error:
        wrong = cast("typer.BadParameter", error)
        sentence = wrong.format_message().rstrip().removesuffix(".")
        if len(sentence) > LONGEST:  # a value that the sentence quotes
            sentence = f"{sentence[: LONGEST - 100]} ... {sentence[-80:]}"
        command = wrong.ctx.command_path if wrong.ctx else "lure"
        stop = "" if sentence.endswith("?") else "."  # Did you mean ...?
        return _say(f"{sentence}{stop} See {command} --help.", status=BAD_INPUT)
    except MemoryError:
        return _say("not enough memory for this many cells; give fewer", status=BAD_INPUT)
    except (
        Exception
    ) as error:  # the outermost frame: whatever is left is a bug, said in a sentence and not as a traceback
        from lure.errors import AssumptionError, InputError

        if isinstance(error, InputError | AssumptionError):
            return _say(str(error), status=BAD_INPUT)
        if os.environ.get("LURE_DEBUG") == "1":
            traceback.print_exc()
        return _say(
            f"{type(error).__name__}: {error}\nThis is a bug in lure, not in your input: please report it with the "
            "command you ran and what it prints with LURE_DEBUG=1 in the environment.",
            status=BUG,
        )


def _say(message: str, *, status: int = 0) -> int:
    safe = "".join(sign if sign.isprintable() or sign == "\n" else ascii(sign)[1:-1] for sign in message)
    print(f"lure: {safe}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
