"""The second checker in a process of its own: it can be ended in the middle of an operation on large polynomials."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection

from lure.analysis.certificates.second import (
    boxes,
    counterexamples,
    pace,
    parts,
    regions,
    several,
    structure,
    theorems,
)
from lure.analysis.certificates.second.classes import (
    ATTRACTS,
    BOUNDED,
    EQUILIBRIA,
    GAINS,
    read_nonlinearities,
    require_member,
)
from lure.analysis.certificates.second.reading import LONGEST, OUT_OF_TIME, Document, NotShown, limited, read, require
from lure.analysis.certificates.second.systems import RodData, read_system

# What the second checker says of a certificate, as a whole.


@dataclass(frozen=True, kw_only=True, slots=True)
class SecondOpinion:
    """What the second checker says of a certificate.

    Attributes
    ----------
    accepted : bool
        True: the claim was proved, or refuted, again from the system, the class and the witness alone.
    reason : str
        The sentence shown, or why nothing was.
    """

    accepted: bool
    reason: str


def recheck(certificate: Mapping[str, object] | str | bytes, *, seconds: float = LONGEST) -> SecondOpinion:
    """Decide a certificate of the format ``lure-certificate/1`` again, with methods other than the first checker's.

    Hypotheses are recomputed and not compared with the texts of the file; the conclusion must be the sentence that
    follows.  Signs of polynomials are decided by isolated roots, covers and matrices in ball arithmetic.

    Parameters
    ----------
    certificate : Mapping, str or bytes
        The JSON text, or what was read from it.
    seconds : float
        Time allowed.  It is looked at in every loop, but not inside one operation on polynomials or matrices; see
        :func:`lure.analysis.certificates.second.opinion.recheck_apart` for a limit that ends those too.

    Returns
    -------
    SecondOpinion
        Not accepted: this says nothing about the loop.  Every error, and every comparison left undecided, ends there.
    """
    try:
        with limited(seconds):
            return SecondOpinion(accepted=True, reason=_shown(certificate))
    except NotShown as refusal:
        return SecondOpinion(accepted=False, reason=str(refusal))
    except ZeroDivisionError:
        return SecondOpinion(accepted=False, reason="a matrix or a divisor that has to be invertible is singular")
    except OverflowError:
        return SecondOpinion(accepted=False, reason="a number is too large for a double")
    except Exception as error:  # whatever goes wrong shows nothing
        return SecondOpinion(accepted=False, reason=f"{type(error).__name__}: {error}"[:500])


def _shown(certificate: Mapping[str, object] | str | bytes) -> str:
    document = read(certificate)
    if document.rate is None:
        shown = _follows(document)
    else:
        below = _follows(pace.weighted(document, document.rate))
        shown = pace.conclusion(document, document.rate, below, (ATTRACTS, GAINS, BOUNDED, EQUILIBRIA))
    require(document.conclusion == shown, f"what follows is: {shown}")
    return shown


def _follows(document: Document) -> str:
    """The sentence that is shown of the system of the document."""
    if document.proof.get("method") in (parts.ONE, parts.ALL):
        return parts.together(document, [_follows(one) for one in parts.documents(document)])
    if "channels" in document.nonlinearities:
        return (structure.rods if document.system.get("kind") == "rods" else several.shown)(document)
    if document.system.get("kind") in [*structure.FAMILIES]:  # which may be a list
        said = {_follows(one) for one in structure.within_bounds(document)}
        require(len(said) == 1, "another sentence follows for other rods")
        return said.pop()
    if "graphs" in document.nonlinearities:
        return regions.shown(document)
    nonlinearities = read_nonlinearities(document.nonlinearities)
    require(not nonlinearities.relu, "a ReLU is asked about as one of several channels")
    if document.nonlinearity is not None:
        require_member(document.nonlinearity, nonlinearities)
    if document.system.get("kind") in ("family", "delay-family"):
        if document.verdict == "PROVED":
            return boxes.proved(document, nonlinearities)
        document = boxes.member(document)
    system = read_system(document.system)
    if document.verdict == "PROVED":
        if isinstance(system, RodData) and document.proof.get("method") == "matrix":
            system = system.states()
        if isinstance(system, RodData):
            return structure.proved(document, system, nonlinearities)
        return theorems.proved(document, system, nonlinearities)
    require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    return counterexamples.refuted(document, system, nonlinearities)


SMALL = 8_000  # [characters]: nothing in such a file takes long enough for a process
ENDED = "the process of the second checker ended before it had decided, for lack of memory perhaps"


def recheck_apart(certificate: Mapping[str, object], *, seconds: float) -> SecondOpinion:
    """What :func:`~lure.analysis.certificates.second.opinion.recheck` says, or that it did not finish in time.

    Parameters
    ----------
    certificate : Mapping
        What was read from a certificate.
    seconds : float
        Time allowed; a process that is given a large certificate is ended then.
    """
    written = json.dumps(dict(certificate))
    if len(written) < SMALL:
        return recheck(written, seconds=seconds)
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_checked, args=(sender, written, seconds), daemon=True)
    process.start()
    sender.close()
    try:
        if not receiver.poll(seconds):
            return SecondOpinion(accepted=False, reason=OUT_OF_TIME)
        accepted, reason = receiver.recv()
    except EOFError:
        return SecondOpinion(accepted=False, reason=ENDED)
    finally:
        process.kill()
        process.join()
    return SecondOpinion(accepted=accepted, reason=reason)


def _checked(sender: Connection, written: str, seconds: float) -> None:
    """The work of the process."""
    opinion = recheck(written, seconds=seconds)
    sender.send((opinion.accepted, opinion.reason))
