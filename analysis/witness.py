"""Destabilising members of a class of laws: the other side of every answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from analysis.evidence import Evidence

if TYPE_CHECKING:
    from analysis.certificates.checker import Refuted

Kind = Literal["linear gain", "switched gain", "periodic orbit", "simulated orbit"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Witness:
    r"""A law in a class ``[lower, k]`` with which ``sigma = H mu``, ``mu = -phi(sigma)`` does not come to rest at 0.

    Attributes
    ----------
    kind : {"linear gain", "switched gain", "periodic orbit", "simulated orbit"}
        ``simulated orbit`` is never more than observed.
    k : float
        Upper bound of the smallest class ``[lower, k]`` that contains the law, rounded up where it is not exact.
    evidence : Evidence
        CERTIFIED: an exact or interval argument; COMPUTED: floats with an error estimate; OBSERVED: a simulation.
    slope_restricted : bool
        Whether the law has slope in ``[lower, k]``; else it only lies in the sector.
    odd, time_varying : bool
        Properties of the law.
    description : str
        One sentence: the law and what the loop does with it.
    data : Mapping
        What is needed to check it again: points of the law, orbit, gains and times; exact numbers as ``p/q``.
    refutation : Refuted or None
        What the checker accepted of it, with its certificate; None where it was not asked.
    """

    kind: Kind
    k: float
    evidence: Evidence
    slope_restricted: bool
    odd: bool
    time_varying: bool = False
    description: str
    data: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    refutation: Refuted | None = None

    def __str__(self) -> str:
        return f"{self.description} ({self.evidence})"
