"""One stretch of contact of the end ``x = L`` with the obstacle, whatever moved and however that was computed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from lure.record import Record, derived, quantity


class Contact(Record):
    """One stretch of contact.

    What a method does not tell is nan: a rigid obstacle is not penetrated, and what is known at samples only has no
    impulse.
    """

    start: float = quantity("instant of contact; 0 if the motion began in it", "s", dims="")
    end: float = quantity(
        "instant of release, or the end of the motion if it goes on; in a window of a motion, the end of the window",
        "s",
        dims="",
    )
    impulse: float = quantity("impulse ``A int p dt`` given to the obstacle", "N s", dims="", default=math.nan)
    peak_stress: float = quantity(
        "largest contact stress over all instants of the contact", "Pa", dims="", default=math.nan
    )
    peak_penetration: float = quantity("largest ``z`` over all instants of the contact", "m", dims="", default=math.nan)
    closed: bool = quantity("whether the end has left the obstacle", "1", dims="")

    @property
    @derived("1", dims="")
    def open(self) -> bool:
        """Whether the motion began or ended in this contact, so that it is seen in part only."""
        return not self.closed or self.start == 0.0

    _title = "contact with the obstacle"
    _notes = ("One contact of one motion.",)

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "from", f"{self.start:.9g} s"
        yield "to", f"{self.end:.9g} s" + ("" if self.closed else " (still in contact)")
        known = (("impulse", self.impulse, "N s"), ("largest stress", self.peak_stress, "Pa"))
        for name, value, unit in (*known, ("largest penetration", self.peak_penetration, "m")):
            if not math.isnan(value):
                yield name, f"{value:.6g} {unit}"
