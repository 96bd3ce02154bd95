"""What the describing function suggests for the law of a report: a hint, never a verdict."""

from __future__ import annotations

from lure.analysis.describing import describing_hint
from lure.analysis.questions.problem import Subject
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalBlock


def balance_hints(about: Subject) -> tuple[str, ...]:
    """One sentence on harmonic balance; empty for blocks with dead time, in discrete time, or without a law.

    Parameters
    ----------
    about : Subject
        The loop.
    """
    block, law = about.block, about.law
    if law is None or not isinstance(block, RationalBlock) or block.dt is not None:
        return ()
    if not getattr(law, "odd", False):
        return ("there is no describing function to look at: it is for odd laws, and this one is not known to be odd",)
    try:
        hint = describing_hint(block, law)
    except (AssumptionError, InputError) as refused:
        return (f"no describing function: {refused}",)
    if not hint.balances:
        return ("the describing function shows no harmonic balance, which does not exclude an oscillation",)
    listed = "; ".join(map(str, hint.balances[:4]))
    more = f"; and {len(hint.balances) - 4} more" if len(hint.balances) > 4 else ""
    return (f"the describing function suggests an oscillation of {listed}{more}; it neglects all harmonics",)
