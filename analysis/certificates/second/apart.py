"""The second checker in a process of its own: it can be ended in the middle of an operation on large polynomials."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Mapping
from multiprocessing.connection import Connection

from analysis.certificates.second.opinion import SecondOpinion, recheck
from analysis.certificates.second.reading import OUT_OF_TIME

SMALL = 8_000  # [characters]: nothing in such a file takes long enough for a process
ENDED = "the process of the second checker ended before it had decided, for lack of memory perhaps"


def recheck_apart(certificate: Mapping[str, object], *, seconds: float) -> SecondOpinion:
    """What :func:`~analysis.certificates.second.opinion.recheck` says, or that it did not finish in time.

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
