"""What every motion has, whatever moved and however that was computed: samples, contacts, and what it shows."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar

from lure.arrays import Reals
from lure.record import Record, derived, quantity
from lure.rod import datasets


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


class SampledMotion(Record, ABC):
    """A motion known at instants ``t``; a subclass adds its signals, its contacts and what it is held against.

    A subclass says in ``_subject`` and ``_evidence`` what kind of object moved and how that is known, in ``_heading``
    the title of its Dataset, and defines :attr:`about` and :attr:`how`.
    """

    _subject: ClassVar[str]
    _evidence: ClassVar[str] = "observed"
    _heading: ClassVar[str]

    t: Reals = quantity(datasets.TIME, "s", dims="t")

    @property
    @abstractmethod
    def about(self) -> str:
        """Which object moves, in words."""

    @property
    @abstractmethod
    def how(self) -> str:
        """How the motion was computed."""

    @property
    @derived()
    def comment(self) -> str:
        """What the motion shows, and what it does not."""
        return datasets.what_it_shows(self._subject, self.about, self._evidence)

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        found = {"subject": self._subject, "evidence": self._evidence, "until": float(self.t[-1])}
        return {**found, "samples": self.t.size, **super().to_dict()}

    def _attributes(self) -> dict[str, object]:
        words = {"subject": self._subject, "about": self.about, "evidence": self._evidence, "method": self.how}
        return {**datasets.motion_attributes(self._heading, **words)}


def number_of_contacts(contacts: int) -> str:
    """``no contact``, ``1 contact``, ``2 contacts``, ..."""
    return "no contact" if not contacts else "1 contact" if contacts == 1 else f"{contacts} contacts"
