"""What the second checker says of a certificate, as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from analysis.certificates.second import counterexamples, structure, theorems
from analysis.certificates.second.classes import read_laws, require_member
from analysis.certificates.second.reading import LONGEST, NotShown, limited, read, require
from analysis.certificates.second.systems import RodData, read_system


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
        :func:`analysis.certificates.second.apart.recheck_apart` for a limit that ends those too.

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
    except Exception as error:  # whatever goes wrong shows nothing
        return SecondOpinion(accepted=False, reason=f"{type(error).__name__}: {error}"[:500])


def _shown(certificate: Mapping[str, object] | str | bytes) -> str:
    document = read(certificate)
    laws, system = read_laws(document.laws), read_system(document.system)
    if document.law is not None:
        require_member(document.law, laws)
    if document.verdict == "PROVED":
        if isinstance(system, RodData) and document.proof.get("method") == "matrix":
            system = system.states()
        if isinstance(system, RodData):
            shown = structure.proved(document, system, laws)
        else:
            shown = theorems.proved(document, system, laws)
    else:
        require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
        shown = counterexamples.refuted(document, system, laws)
    require(document.conclusion == shown, f"what follows is: {shown}")
    return shown
