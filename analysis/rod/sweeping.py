"""A rod as a row of a sweep: what is proved of it and of its scheme, without a simulation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lure.analysis.rod.certificates import circle_bound, popov_theta
from lure.analysis.rod.conclusion import concluded, offered
from lure.analysis.rod.spectrum import slowest_decays
from lure.analysis.sweeps.rows import Answered, Row
from lure.analysis.verdict import Verdict
from lure.rod.discretisation import upwind
from lure.rod.transfer import RodPlant

if TYPE_CHECKING:
    from lure.analysis.questions.conclusion import Conclusion
    from lure.rod.systems import RodSystem


def rod_row(system: RodSystem, _seconds: float | None = None) -> Answered:
    """The rod and its scheme with the rod's own pressure law: the energy theorem decides both, for every sector.

    Parameters
    ----------
    system : RodSystem
        The rod with its scheme; nothing is simulated.
    """
    scheme = upwind(system.rod, system.cells, form=system.form)
    of_rod, of_scheme = (concluded(block, offered(block)) for block in (RodPlant(system.rod), scheme))
    damped = system.rod.exact["damping"] > 0
    bound = circle_bound(system.rod) if damped else None
    decays = slowest_decays(scheme)
    about_rod, about_scheme = _sector(of_rod), _sector(of_scheme)
    row: Row = {
        **about_rod,
        "refuted_at": 0.0 if of_rod.verdict is Verdict.REFUTED else math.nan,
        "criterion": "" if of_rod.shown is None else str(of_rod.shown.theorem),
        "slowest_decay": decays.rod,
        "theta": float(popov_theta(system.rod)) if damped else math.nan,
        "code": "" if of_rod.code is None else of_rod.code.identifier,
        "scheme_verdict": about_scheme["verdict"],
        "scheme_largest_low": about_scheme["largest_low"],
        "scheme_slowest_decay": decays.scheme,
        "circle": math.inf if damped and bound is None else math.nan if bound is None else float(bound),
    }
    return Answered(row, tuple(one.shown.certificate for one in (of_rod, of_scheme) if one.shown is not None))


def _sector(found: Conclusion) -> Row:
    """What was concluded of a rod with its own pressure law: for every sector, or for none."""
    low, high = {Verdict.PROVED: (math.inf, math.inf), Verdict.REFUTED: (0.0, 0.0)}.get(found.verdict, (0.0, math.inf))
    return {
        "verdict": str(found.verdict),
        "evidence": "" if found.shown is None else str(found.evidence),
        "largest_low": low,
        "largest_high": high,
    }
