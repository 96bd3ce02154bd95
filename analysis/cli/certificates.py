"""The commands about certificates: ``verify``, ``certify``, ``explain``, ``export``."""

from __future__ import annotations

import json
import math
import shlex
import stat
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.cli import texts
from lure.analysis.cli.loops import Criterion, Den, Dt, Num, Transfer, block_of, number_of
from lure.analysis.cli.options import (
    Force,
    Json,
    Output,
    Quiet,
    Seconds,
    Settings,
    Verbose,
    app,
    check_target,
    exit_status,
    option,
    print_json,
)
from lure.analysis.cli.texts import wrapped
from lure.analysis.wording import loop_words, plain
from lure.errors import InputError, did_you_mean
from lure.record import described, quantity

if TYPE_CHECKING:
    from fractions import Fraction

    from lure.analysis.certificates.codes import Code
    from lure.analysis.certificates.proposals import Numbers
    from lure.analysis.questions.certify import Certification, Method
    from lure.classes import NonlinearityClass

# What ``lure verify`` does with one file: read it, have it checked, say what came of it.
#
# Nothing here imports numpy, a solver or the package ``lure``: the checker needs Python's standard library only.

ACCEPTED, REJECTED, NO_CERTIFICATE = "ACCEPTED", "REJECTED", "NO CERTIFICATE"
LONGEST = 600.0  # [s] for the second checker, as for the first
MOST_BYTES = 1 << 26  # more than any certificate has: the checker refuses what is cut off here by its size
STATUS = {ACCEPTED: 0, NO_CERTIFICATE: 2, REJECTED: 11}
_SECOND = "the second checker, on python-flint, agrees"


@described(frozen=True, kw_only=True, slots=True)
class Verified:
    """What came of one file."""

    file: str = quantity("Its name as given; ``-`` is standard input")
    result: str = quantity("``ACCEPTED``, ``REJECTED`` or ``NO CERTIFICATE``")
    reason: str = quantity("The claim that was accepted, or why it was not")
    shown: Proved | Refuted | None = quantity("What the checker made of an accepted certificate", default=None)
    second: bool | None = quantity("Whether the second checker agreed; None if it was not asked", default=None)

    @property
    def status(self) -> int:
        """Exit status for this file alone."""
        return STATUS[self.result]

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        data: dict[str, Any] = {"file": self.file, "result": self.result}
        if self.shown is None:
            return {**data, "reason": self.reason, "second": self.second}
        found = self.shown
        return {
            **data,
            "verdict": "PROVED" if isinstance(found, Proved) else "REFUTED",
            "claim": found.claim,
            "theorem": found.theorem,
            "system": found.certificate["system"],
            "facts": dict(found.facts),
            "assumed": [found.assumed] if found.assumed else [],
            "second": self.second,
        }

    def lines(self) -> list[str]:
        """The same in lines of 80 columns, exact numbers unbroken."""
        said = wrapped(f"{self.result}: {self.reason if self.shown is None else plain(self.reason)}", indent=2)
        if self.shown is not None:
            said += accepted_lines(self.shown, [self.shown.assumed] if self.shown.assumed else [])
        if self.second:
            said.append(f"  {_SECOND}")
        return said


def accepted_lines(shown: Proved | Refuted, assumed: Sequence[str]) -> list[str]:
    """The loop, the theorem, the hypotheses found to hold and what is assumed beside them, in lines of 80 columns.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted.
    assumed : sequence of str
        What nothing shows, in clauses.
    """
    facts = [("nonlinearity" if name == "law" else name, text) for name, text in shown.facts.items()]
    said = [
        ("loop", loop_words(shown.certificate)),
        ("theorem", shown.theorem),
        *facts,
        *(("assumed", clause) for clause in assumed),
    ]
    return [line for name, text in said for line in wrapped(f"  {name}: {plain(text)}", indent=4)]


def verified(file: str, *, second: bool, seconds: float | None) -> Verified:
    """Read and check one file; every outcome is a value and no exception.

    Parameters
    ----------
    file : str
        A path, or ``-`` for standard input.
    second : bool
        Whether the second checker is asked too; a disagreement is a rejection.
    seconds : float or None
        Time allowed to each checker, ten minutes by default; a file that takes longer is rejected.
    """
    data = _read(file)
    if isinstance(data, str):
        return Verified(file=file, result=NO_CERTIFICATE, reason=data)
    try:
        shown = check(data) if seconds is None else check(data, seconds=seconds)
    except Malformed as refusal:
        told = f"{_label(file)} is no certificate: {refusal}; give a file that lure certify wrote"
        return Verified(file=file, result=NO_CERTIFICATE, reason=_report(file, data) or told)
    except Rejected as refusal:
        return Verified(file=file, result=REJECTED, reason=str(refusal))
    except (MemoryError, RecursionError):
        return Verified(file=file, result=REJECTED, reason="checking it needs more memory than there is")
    except Exception as error:  # a fault of the checker accepts nothing
        fault = f"{type(error).__name__}: {error}"
        return Verified(file=file, result=REJECTED, reason=f"the checker stopped with {fault:.200}; please report it")
    if not second:
        return Verified(file=file, result=ACCEPTED, reason=shown.claim, shown=shown)
    against = _against(shown, LONGEST if seconds is None else seconds)
    if against:
        return Verified(file=file, result=REJECTED, reason=against, second=False)
    return Verified(file=file, result=ACCEPTED, reason=shown.claim, shown=shown, second=True)


def _against(shown: Proved | Refuted, seconds: float) -> str:
    """What the second checker says against a certificate that the first accepted; empty if it agrees."""
    from lure.analysis.certificates.second import recheck_apart
    from lure.analysis.certificates.second.reading import OUT_OF_TIME

    opinion = recheck_apart(shown.certificate, seconds=seconds)
    if opinion.accepted:
        return ""
    if opinion.reason == OUT_OF_TIME:
        return f"the second checker has not decided: {OUT_OF_TIME}"
    return f"the second checker disagrees: {opinion.reason or 'it gives no reason'}"


def _report(file: str, data: bytes) -> str | None:
    """What a ``report.json`` is, and where the certificates beside it are; None for any other file."""
    try:
        found = json.loads(data)
        if not str(found["schema"]).startswith("lure-report/"):
            return None
        names = [str(entry["file"]) for entry in found["certificates"]]
    except (ValueError, TypeError, LookupError, RecursionError):
        return None
    if not names:
        return f"{_label(file)} is a report and no certificate, and nothing in it was certified"
    folder = Path("." if file == "-" else file).parent
    where = " ".join(shlex.quote(str(folder / name)) for name in names)
    return f"{_label(file)} is a report and no certificate; its certificates are beside it: lure verify {where}"


def _read(file: str) -> bytes | str:
    """The content, cut off far beyond the size of any certificate, or a sentence on why there is none."""
    label = _label(file)
    if file == "-":
        return sys.stdin.buffer.read(MOST_BYTES)
    try:
        kind = Path(file).stat().st_mode
        if stat.S_ISDIR(kind):
            return f"{label} is a directory; give a certificate file, such as cert.json"
        if not stat.S_ISREG(kind):
            return f"{label} is not an ordinary file; give a certificate file, or - for standard input"
        with Path(file).open("rb") as content:
            return content.read(MOST_BYTES)
    except FileNotFoundError:
        return f"{label} does not exist; write a certificate with: lure certify plant.toml -o cert.json"
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        return f"{label} cannot be read ({reason}); give a readable file"


def _label(file: str) -> str:
    return "standard input" if file == "-" else f"{file!r:.200}"


Pair = tuple[str, str]
METHODS = ("best", "polynomial", "matrix", "cover", "structure")


@app.command(help=texts.VERIFY)
def verify(
    files: Annotated[list[str], typer.Argument(metavar="FILE", help="Certificates; - is standard input.")],
    second: Annotated[bool, typer.Option("--second", help="Ask the second checker too.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
) -> int:
    """Check certificates; 11 if one is rejected, else 2 if one is no certificate, else 0."""
    found = [verified(file, second=second, seconds=seconds) for file in files]
    if as_json:
        print_json([each.to_dict() for each in found])
    for each in found:
        if each.result == NO_CERTIFICATE:
            print(f"lure: {each.reason}", file=sys.stderr)
        elif not as_json:
            if len(found) > 1:
                print(f"{each.file}:")
            print("\n".join(each.lines()))
    return max(each.status for each in found)


@app.command(help=texts.CERTIFY)
def certify(
    system: Annotated[
        str | None, typer.Argument(metavar="PLANT", help="A TOML file or a built-in system.", show_default=False)
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write; - for standard output.")
    ] = Path("certificate.json"),
    force: Force = False,
    num: Num = None,
    den: Den = None,
    transfer: Transfer = None,
    dt: Dt = None,
    sector: Annotated[Pair | None, option("--sector", "K1 K2", "The class: phi(sigma)/sigma in [K1, K2].")] = None,
    slope: Annotated[Pair | None, option("--slope", "K1 K2", "The class: slopes in [K1, K2].")] = None,
    odd: Annotated[bool, typer.Option("--odd", help="Assume that phi is odd.")] = False,
    time_varying: Annotated[bool, typer.Option("--time-varying", help="Let phi depend on time.")] = False,
    criterion: Criterion = "best",
    method: Annotated[
        str, typer.Option("--method", metavar="KIND", help="The kind of proof: polynomial, matrix, cover, structure.")
    ] = "best",
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Find a proof or a refutation of one class, have it checked, and write it."""
    _check_options(method, seconds)
    asked, finite = _asked(sector, slope, odd=odd, time_varying=time_varying)
    loop = _loop(system, (num, den, transfer, dt), set_ or [])
    if asked is None and not _has_class(loop):
        raise InputError("no class of nonlinearities is given; give one, such as --sector 0 5.9 or --slope 0 1")
    if str(output) != "-":
        check_target(output, force=force)
    from lure.analysis.questions.certify import ProofOptions, text_of
    from lure.analysis.questions.certify import certify as run
    from lure.files.system import LoopSystem

    given: object = asked
    if isinstance(loop, LoopSystem) and loop.channels > 1:
        given = None if asked is None else [asked] * loop.channels
        if method not in ("best", "matrix"):
            raise InputError(f"--method is {method!r}; several nonlinearities are proved by a matrix, so leave it out")
        if given is not None:
            loop = loop.block
    kind = cast("Method", method)  # one of them: _check_options
    ways = ProofOptions(criterion=criterion, method=kind, finite=finite, seconds=seconds, numbers=_numbers(loop))
    with Output(quiet=quiet, verbose=verbose).progress() as tell:
        found = run(loop, given, ways=ways, progress=tell)
    if found.certificate is not None:
        text = text_of(found.certificate)
        if str(output) == "-":
            print(text, end="")
        else:
            from lure.analysis.output import write_new

            write_new(output, text, force=force)
    _told(found, output, _about(loop, found.certificate), as_json=as_json, quiet=quiet)
    return exit_status(found.verdict)


def _check_options(method: str, seconds: float | None) -> None:
    if method not in METHODS:
        raise InputError(f"--method is {method!r:.40}; {did_you_mean(method, METHODS)}choose from {', '.join(METHODS)}")


def _asked(
    sector: Pair | None, slope: Pair | None, *, odd: bool, time_varying: bool
) -> tuple[NonlinearityClass | None, bool]:
    """The class of the options, None without any; and whether an upper bound is just finite."""
    from lure.classes import NonlinearityClass, Sector, SlopeBounds

    if sector is None and slope is None:
        if odd or time_varying:
            option = "--odd" if odd else "--time-varying"
            raise InputError(f"{option} belongs to a class; give --sector or --slope too")
        return None, False
    inner = _interval(sector or slope or ("0", "inf"), "--sector" if sector else "--slope")
    outer = None if slope is None else _interval(slope, "--slope")
    finite = "finite" in {*(sector or ()), *(slope or ())}
    bounds = None if outer is None else SlopeBounds(*outer)
    return NonlinearityClass(sector=Sector(*inner), slope=bounds, odd=odd, time_varying=time_varying), finite


def _interval(pair: Pair, name: str) -> tuple[Fraction | float, Fraction | float]:
    low, high = pair
    first = -math.inf if low in ("-inf", "-infinity") else number_of(low, name)
    second = math.inf if high in ("inf", "+inf", "finite") else number_of(high, name)
    if not first < second:
        raise InputError(f"{name} is {low:.40} {high:.40}; the first number must be smaller than the second")
    return first, second


def _loop(system: str | None, parts: tuple[str | None, ...], settings: list[str]) -> object:
    num, den, transfer, dt = parts
    if system is None:
        if settings:
            raise InputError("--set changes a system; give a TOML file or a built-in system with it")
        return block_of(num, den, transfer, dt, None)
    if any(part is not None for part in parts):
        raise InputError(f"give the block once: by the system {system} or by --num and --den, --transfer and --dt")
    from lure.files import find_system

    return find_system(system, settings)


def _has_class(loop: object) -> bool:
    from lure.files.system import LoopSystem

    if isinstance(loop, LoopSystem):
        return not loop.open
    from lure.rod.systems import RodSystem

    return isinstance(loop, RodSystem)


def _about(loop: object, certificate: Mapping[str, Any] | None) -> str:
    """What of a system an answer is about, where that is not all of it; empty otherwise."""
    from lure.files.system import LoopSystem
    from lure.rod.systems import RodSystem

    if isinstance(loop, RodSystem):
        scheme = certificate is not None and str(certificate["system"]["kind"]).startswith("rod-scheme")
        return (
            "the upwind scheme, without load, and not the rod that it approximates"
            if scheme
            else "the rod without load"
        )
    if not isinstance(loop, LoopSystem):
        return ""
    if loop.approximates is not None:
        return f"{loop.title}, without load, and not what it approximates"
    return "the loop without input, w = 0" if loop.performance is not None or loop.forcing is not None else ""


def _numbers(loop: object) -> Numbers:
    from lure.plants.state_space import StateSpace

    block = getattr(loop, "block", loop)
    return "doubles, exactly" if isinstance(block, StateSpace) else "decimals as written"


def _told(found: Certification, output: Path, about: str, *, as_json: bool, quiet: bool) -> None:
    """What was found, and of what: on stdout, or on stderr where that is for the certificate."""
    from lure.analysis.cli.texts import wrapped

    to_stdout = str(output) == "-"
    if as_json and not to_stdout:
        print_json(_outcome(found, output, about))
        return
    said = wrapped(f"{found.verdict}: {found.detail if found.shown is None else plain(found.detail)}", indent=2)
    if about:
        said += wrapped(f"  about: {about}", indent=4)
    if found.shown is not None:
        said += accepted_lines(found.shown, found.assumed)
        if not to_stdout and not quiet:
            said += ["", f"The certificate is {output}; check it: {shlex.join(['lure', 'verify', str(output)])}"]
    elif found.code is not None:
        said += [f"  {found.code}", "", f"What it means, and what to try: lure explain {found.code.identifier}"]
    if not (to_stdout and quiet):
        print("\n".join(said), file=sys.stderr if to_stdout else sys.stdout)


def _outcome(found: Certification, output: Path, about: str) -> dict[str, Any]:
    shown = found.shown
    return {
        "verdict": str(found.verdict),
        "about": about or None,
        "claim": None if shown is None else shown.claim,
        "theorem": None if shown is None else shown.theorem,
        "facts": None if shown is None else dict(shown.facts),
        "assumed": list(found.assumed),
        "file": None if shown is None else str(output),
        "code": None if found.code is None else found.code.identifier,
        "detail": found.detail,
        "searches": [
            {"search": each.search, "code": each.code.identifier, "detail": each.detail} for each in found.failures
        ],
    }


@app.command(help=texts.EXPLAIN)
def explain(
    code: Annotated[
        str | None, typer.Argument(metavar="CODE", help="The code, such as LURE-I001.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Explain a code, or list them all."""
    from lure.analysis.certificates.codes import CODES, find, nearest

    if code is None:
        if as_json:
            print_json(list(map(_plain, CODES)))
        else:
            print("\n".join(map(str, CODES)))
        return
    found = find(code)
    if found is None:
        near = nearest(code)
        meant = "" if near is None else f"did you mean {near}? "
        raise InputError(f"there is no code {code!r:.40}; {meant}lure explain lists them")
    if as_json:
        print_json(_plain(found))
    else:
        print("\n".join(_explained(found)))


def _plain(code: Code) -> dict[str, Any]:
    return {
        "code": code.identifier,
        "title": code.title,
        "happened": code.happened,
        "means": code.means,
        "tries": list(code.tries),
    }


def _explained(code: Code) -> list[str]:
    said = [str(code)]
    for title, text in (("What happened", code.happened), ("What it means", code.means)):
        said += ["", title, *wrapped(f"  {text}", indent=2)]
    said += ["", "What to try"]
    for text in code.tries:
        said += wrapped(f"  - {text}", indent=4)
    return said


@app.command(help=texts.EXPORT)
def export(
    certificate: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A certificate; - is standard input.")],
    coq: Annotated[
        bool, typer.Option("--coq", show_default=False, help="For Coq, 8.16 or later, as without it.")
    ] = True,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write; - for standard output.")
    ] = Path("loop.v"),
    force: Force = False,
    seconds: Seconds = None,
    quiet: Quiet = False,
) -> None:
    """Write what a certificate shows for a proof assistant."""
    if str(output) != "-":
        _check_name(output)
    found = verified(certificate, second=False, seconds=seconds)
    if found.shown is None:
        raise InputError(
            found.reason
            if found.result != "REJECTED"
            else f"the certificate is rejected: {found.reason}; export one that lure verify accepts"
        )
    assert found.result == ACCEPTED
    if str(output) != "-":
        check_target(output, force=force)
    from lure.analysis.export import coq_text

    text = coq_text(found.shown)
    if str(output) == "-":
        sys.stdout.write(text)
        return
    from lure.analysis.output import write_new

    write_new(output, text, force=force)
    Output(quiet=quiet).note(f"The proof is {output}; check it: {shlex.join(['coqc', str(output)])}")


def _check_name(path: Path) -> None:
    """What ``coqc`` takes as the name of a file."""
    stem = path.stem
    plain = stem.isascii() and stem.isidentifier()
    if path.suffix != ".v" or not plain:
        raise InputError(
            f"--output is {str(path)!r}; coqc takes names of letters, digits and _ that end in .v, such as 'loop.v'"
        )
