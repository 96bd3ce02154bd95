"""A rod as a row of a sweep: what is proved of it and of its scheme, without a simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from lure.analysis.numerics.doubles import double_below
from lure.analysis.rod.certificates import circle_bound, popov_theta
from lure.analysis.rod.conclusion import concluded, offered
from lure.analysis.rod.spectrum import slowest_decays
from lure.analysis.sweeps.rows import Answered, Certificate, Row
from lure.analysis.verdict import Verdict
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.family import RodFamily
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.rod.systems import RodSystem


def rod_row(system: RodSystem, _seconds: float | None = None, *, plain: bool = False) -> Answered:
    """The rod and its scheme with the rod's own pressure law: the energy theorem decides both, for every sector.

    With intervals it is about all rods of the box: PROVED of each, REFUTED where one of them is, ``circle`` is the
    least.  Decay and multiplier, which are those of one rod, are left out.

    ``system``: the rod with its scheme, or rods with theirs; nothing is simulated.  ``plain``: whether what follows
    from the certificate is concluded anew, in words, for this very rod.
    """
    if system.intervals:
        return _of_all(system)
    scheme = upwind(system.rod, system.cells, form=system.form)
    conclude = _followed if plain else _follows
    of_rod, of_scheme = (conclude(block, offered(block)) for block in (RodPlant(system.rod), scheme))
    decays = slowest_decays(scheme)
    theta = float(popov_theta(system.rod)) if system.rod.exact["damping"] > 0 else math.nan
    more = {"slowest_decay": decays.rod, "scheme_slowest_decay": decays.scheme, "theta": theta}
    return _answered(of_rod, of_scheme, [system.rod], more)


def _of_all(system: RodSystem) -> Answered:
    """The same of all rods with parameters in intervals, and of their schemes."""
    families = [system.family(discretised=discretised) for discretised in (False, True)]
    of_rods, of_schemes = (_followed(block, offered(block)) for block in families)
    return _answered(of_rods, of_schemes, families[0].hardest, {})


def _answered(of_rod: _Found, of_scheme: _Found, hardest: Sequence[Rod], more: Row) -> Answered:
    """The row of what was found, with the rods at which the circle criterion is hardest."""
    damped = all(rod.exact["damping"] > 0 for rod in hardest)
    bounds = [bound for rod in hardest if damped and (bound := circle_bound(rod)) is not None]
    row: Row = {
        **_sector(of_rod),
        "refuted_at": 0.0 if of_rod.verdict is Verdict.REFUTED else math.nan,
        "criterion": of_rod.theorem,
        "code": of_rod.code,
        "scheme_verdict": str(of_scheme.verdict),
        "scheme_largest_low": _sector(of_scheme)["largest_low"],
        "circle": math.nan if not damped else double_below(min(bounds)) if bounds else math.inf,
        **more,
    }
    return Answered(row, tuple(one.certificate for one in (of_rod, of_scheme) if one.certificate is not None))


class _Found(NamedTuple):
    """What a row keeps of a conclusion."""

    verdict: Verdict
    evidence: str
    theorem: str
    code: str
    certificate: Certificate | None


_SAME: dict[tuple[object, ...], _Found] = {}


def _follows(block: RodPlant | UpwindScheme, shown: Proved | Refuted | str) -> _Found:
    """As :func:`_followed`, once for all rods of which the checker accepted the same.

    The energy theorem is about every nonlinearity in ``[0, inf]``.  ``c max(r, 0)^m`` lies there for every ``c > 0``,
    which a rod has by construction, and ``m`` alone says how regular it is: from the same claim the same follows.
    """
    if isinstance(shown, str):
        return _followed(block, shown)
    key = type(block), type(shown), shown.theorem, shown.facts["class"], shown.assumed, block.rod.exact["exponent"]
    if key not in _SAME:
        _SAME[key] = _followed(block, shown)
    found = _SAME[key]
    return found if found.certificate is None else found._replace(certificate=shown.certificate)


def _followed(block: RodPlant | UpwindScheme | RodFamily, shown: Proved | Refuted | str) -> _Found:
    """What follows for a block with the rod's own pressure law."""
    found = concluded(block, shown)
    code = "" if found.code is None else found.code.identifier
    if found.shown is None:
        return _Found(found.verdict, "", "", code, None)
    return _Found(found.verdict, str(found.evidence), str(found.shown.theorem), code, found.shown.certificate)


def _sector(found: _Found) -> Row:
    """What was concluded of a rod with its own pressure law: for every sector, or for none."""
    low, high = {Verdict.PROVED: (math.inf, math.inf), Verdict.REFUTED: (0.0, 0.0)}.get(found.verdict, (0.0, math.inf))
    return {"verdict": str(found.verdict), "evidence": found.evidence, "largest_low": low, "largest_high": high}
