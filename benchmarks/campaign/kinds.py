"""All kinds of loops of the campaign, and how many of each are drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from campaign.draws import PLANTS, SMALL
from campaign.known_nonlinearities import box, formulas, regions
from campaign.late import late_gain, late_rate
from campaign.several import gain, memory, rate, several
from campaign.single import single

Attack = Callable[[str, np.random.Generator], tuple[Counter[str], list[str], object]]


@dataclass(frozen=True)
class Kind:
    """What attacks the loops of a kind, and how many there are for one of the first."""

    attack: Attack
    share: float = 1.0


# The random numbers of a kind follow from its place: new kinds come last.
KINDS = {name: Kind(single, 0.15 if name == "dead time" else 1.0) for name in PLANTS} | {
    "channels": Kind(several, 0.1),
    "memory": Kind(memory, 0.1),
    "gains": Kind(gain, 0.1),
    "rates": Kind(rate, 0.1),
    "boxes": Kind(box, 0.1),
    "formulas": Kind(formulas, 0.1),
    "regions": Kind(regions, 0.1),
}
KINDS |= {name: Kind(single, 80.0) for name in SMALL}
KINDS |= {"late rates": Kind(late_rate, 0.1), "late gains": Kind(late_gain, 0.1)}


def attack(kind: str, rng: np.random.Generator) -> tuple[Counter[str], list[str], object]:
    """A loop of the kind, asked about and attacked."""
    return KINDS[kind].attack(kind, rng)
