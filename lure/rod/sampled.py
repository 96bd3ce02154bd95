"""What every motion has, whatever moved and however that was computed: samples, contacts, and what it shows."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any, ClassVar

from lure.arrays import Reals, np
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


# Where a step of an integrator ends a phase, contact or flight.


def step_points(degree: int) -> Reals:
    """Shares of a step, the Chebyshev points, at which :func:`turning_negative` wants a polynomial of that degree."""
    return np.asarray(0.5 * (1.0 - np.cos((np.arange(degree + 1) + 0.5) * math.pi / (degree + 1))))


@cache
def _fit(count: int) -> Reals:
    """Chebyshev coefficients from the values at so many points."""
    return np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * step_points(count - 1) - 1.0, count - 1)))


def turning_negative(values: Reals, noise: float) -> float | None:
    """Share of a step from which on a polynomial is negative by more than noise; None if it never is.

    It is looked at between its roots, so that no dip below zero is missed, however short.

    Parameters
    ----------
    values : ndarray
        At the points of :func:`step_points`.
    noise : float
        What rounding may have put below zero.
    """
    chebyshev, series = np.polynomial.chebyshev, _fit(len(values)) @ values
    size = np.abs(series)
    if series[0] > size[1:].sum():
        return None
    significant = np.flatnonzero(size > 1e-15 * size.max(initial=0.0))
    series = series[: int(significant[-1]) + 1] if significant.size else series[:1]
    roots = chebyshev.chebroots(series) if series.size > 1 else np.empty(0)
    inside = np.sort(roots.real[(np.abs(roots.imag) < 1e-7) & (np.abs(roots.real) < 1.0)])
    for low, high in pairwise([-1.0, *inside, 1.0]):
        if float(chebyshev.chebval(np.linspace(low, high, 5)[1:], series).min()) < -noise:
            return float(0.5 * (low + 1.0))
    return None
