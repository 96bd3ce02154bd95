"""Motions as samples: contacts, what they show, names, units and meanings as Datasets, plain data and responses."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from lure.arrays import ArrayLike, Reals, np
from lure.record import Column as Column
from lure.record import Record, derived, quantity
from lure.record import numbered as numbered
from lure.rod.parameters import PARAMETERS, Rod

if TYPE_CHECKING:
    import control

    from lure.rod.scenario import Scenario

UNITS = {
    "youngs_modulus": "Pa",
    "density": "kg m-3",
    "length": "m",
    "area": "m2",
    "damping": "N s m-1",
    "compliance": "m Pa-1",
    "exponent": "1",
    "gap": "m",
}
# a curve of a motion: meaning with its sign, unit; its name in a Dataset is the key, but for the stress
SERIES = {
    "u_end": ("displacement u(t, L) of the end x = L, positive along x", "m"),
    "z": ("contact coordinate u(t, L) - gap, positive in contact with a compliant obstacle", "m"),
    "v_end": ("velocity of the end x = L, positive along x; at a jump the value after it", "m s-1"),
    "stress": ("contact stress p(z) of the obstacle, positive in compression: E u_x(t, L) = -p", "Pa"),
    "dashpot_force": ("k u_t(t, 0), what the dashpot at x = 0 holds back", "N"),
    "v_0": ("velocity of the end x = 0, positive along x; at a jump the value after it", "m s-1"),
    "energy": ("kinetic, elastic and contact energy of the object that moves", "J"),
}
STRESS = "contact_stress"
_IMPACTS = {
    "start": ("impact_start", "s", "instant of contact"),
    "end": ("impact_end", "s", "instant of release, or the end of the motion if impact_closed is 0"),
    "impulse": ("impact_impulse", "N s", "impulse A int p dt given to the obstacle"),
    "peak_stress": ("impact_peak_stress", "Pa", "largest contact stress over all instants of the contact"),
}
_IDLE = 3  # phases in succession without duration
TIME = "time since the start of the motion"
PLACE = "place along the unstrained rod"
_PAPER = (
    "Danciu, Matei, Micu, Roventa: Nonlinear Feedback Control and Artificial Intelligence Computational Methods "
    "applied to a Dissipative Dynamic Contact Problem, equations (8) and (9)"
)


def series(values: Mapping[str, ArrayLike | None]) -> dict[str, Column]:
    """Quantities of :data:`SERIES` along the time ``t``; those that are None are left out.

    ``values``: (samples,) each, by the keys of :data:`SERIES`.
    """
    given = {key: found for key in SERIES if (found := values.get(key)) is not None}
    return {
        STRESS if key == "stress" else key: Column(("t",), found, SERIES[key][1], SERIES[key][0])
        for key, found in given.items()
    }


def impact_columns(impacts: Iterable[Contact]) -> dict[str, Column]:
    """Number of the contacts, and the instants, impulse and largest stress of each, along the dimension ``impact``.

    ``impacts``: in order; nan where the method does not tell.
    """
    hits = tuple(impacts)
    found = {"impacts": Column((), np.int32(len(hits)), "1", "number of contacts with the obstacle")}
    for key, (name, unit, text) in _IMPACTS.items():
        found[name] = Column(("impact",), np.array([getattr(hit, key) for hit in hits], dtype=float), unit, text)
    closed = np.array([hit.closed for hit in hits], dtype=np.int8)
    flags = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "in_contact_at_the_end released"}
    found["impact_closed"] = Column(("impact",), closed, "1", "whether the contact ended", flags)
    return found


def rod_attributes(rod: Rod) -> dict[str, str | float]:
    """Every parameter of a rod with its exact value and unit, and the constants that follow, for ``attrs``."""
    found: dict[str, str | float] = {}
    for name in PARAMETERS:
        found[f"rod_{name}"] = getattr(rod, name)
        found[f"rod_{name}_exact"] = str(rod.exact[name])
        found[f"rod_{name}_units"] = UNITS[name]
    if rod.exponent != 1.0:
        found["rod_compliance_units"] = f"m{rod.exponent:g} Pa-1"
    return found | {
        "rod_wave_speed": rod.wave_speed,
        "rod_impedance": rod.impedance,
        "rod_travel_time": rod.travel_time,
        "rod_reflection": rod.reflection,
    }


def scenario_attributes(scenario: Scenario) -> dict[str, str]:
    """The formulas of loads and initial data, for ``attrs``."""
    return {
        "force_g": str(scenario.force),
        "force_f": str(scenario.body_force),
        "initial_u0": str(scenario.displacement),
        "initial_u1": str(scenario.velocity),
    }


def motion_attributes(title: str, *, subject: str, about: str, evidence: str, method: str) -> dict[str, str]:
    """What moved, how that is known, and what it does not show, for ``attrs``.

    ``title``: of the Dataset; ``subject``: ``rod``, ``scheme``, ``Galerkin space`` or ``cellular network``; ``about``:
    the object in words; ``evidence``: ``observed`` or ``computed``; ``method``: how the motion was computed.
    """
    from lure import __version__

    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"lure {__version__}: {method}",
        "references": _PAPER,
        "comment": what_it_shows(subject, about, evidence),
        "subject": subject,
        "evidence": evidence,
        "lure_version": __version__,
    }


def what_it_shows(subject: str, about: str, evidence: str) -> str:
    """What a motion shows and what it does not, in a sentence or two.

    ``subject``, ``about``, ``evidence``: as for :func:`motion_attributes`.
    """
    other = "" if subject in ("rod", "cellular network") else " It is not a motion of the rod."
    return f"A motion of {about}; {evidence} evidence of this one motion, which proves nothing of others.{other}"


def rod_dict(rod: Rod) -> dict[str, float]:
    """The parameters of a rod as plain data."""
    return {name: getattr(rod, name) for name in PARAMETERS}


def scenario_dict(scenario: Scenario) -> dict[str, str]:
    """The formulas of loads and initial data as plain data."""
    names = ("force", "body_force", "displacement", "velocity")
    return {name: getattr(scenario, name).source for name in names}


def loop_response(name: str, t: Reals, z: Reals, stress: Reals, force: ArrayLike | None) -> control.TimeResponseData:
    """A motion as python-control has it: the output ``sigma = z`` and the inputs ``mu = -p(z)`` and ``g`` of the block.

    ``name``: what moved; ``t``, ``z``, ``stress``: (samples,) instants [s], contact coordinate [m], contact stress ``p
    >= 0`` [Pa]; ``force``: (samples,) the force ``g`` [N], None where it is not known.
    """
    inputs = {"mu = -p [Pa]": 0.0 - np.asarray(stress)}  # no minus before a zero
    if force is not None:
        inputs["g [N]"] = np.broadcast_to(np.asarray(force, dtype=float), np.shape(t))
    return time_response(name, t, {"z [m]": np.asarray(z)}, inputs)


def time_response(
    name: str, t: Reals, outputs: Mapping[str, Reals], inputs: Mapping[str, Reals]
) -> control.TimeResponseData:
    """A motion as ``control.TimeResponseData``; labels carry the units.

    ``name``: what moved; ``t``: (samples,) instants; ``outputs``, ``inputs``: (samples,) each, by label; no inputs are
    fine.
    """
    import control

    return control.TimeResponseData(
        np.array(t),
        np.array(list(outputs.values())),
        inputs=np.array(list(inputs.values())) if inputs else None,
        output_labels=list(outputs),
        input_labels=list(inputs) or None,
        title=f"Motion of {name}",
        sysname=name,
        issiso=False,
    )


# What every motion has, whatever moved and however that was computed: samples, contacts, and what it shows.


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

    t: Reals = quantity(TIME, "s", dims="t")

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
        return what_it_shows(self._subject, self.about, self._evidence)

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        found = {"subject": self._subject, "evidence": self._evidence, "until": float(self.t[-1])}
        return {**found, "samples": self.t.size, **super().to_dict()}

    def _attributes(self) -> dict[str, object]:
        words = {"subject": self._subject, "about": self.about, "evidence": self._evidence, "method": self.how}
        return {**motion_attributes(self._heading, **words)}


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

    ``values``: at the points of :func:`step_points`; ``noise``: what rounding may have put below zero.
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


Advance = Callable[[float, tuple[float, float], bool, bool], tuple[float, bool]]


def in_phases(edges: Sequence[float], advance: Advance, *, touching: bool) -> tuple[Contact, ...]:
    """Contacts of a motion that an integrator advances from edge to edge, and on each piece from phase to phase.

    Parameters
    ----------
    edges : sequence of float
        Beginning and end, and the instants between at which a load changes its formula [s].
    advance : callable
        Called as ``advance(t, span, touching, watch)``: goes on from ``t`` until the phase or the piece ``span`` ends,
        and returns when that is and whether the phase ended.  Without ``watch`` it takes its first step as it is:
        rounding has just ended several phases at one instant.
    touching : bool
        Whether the motion begins in contact.

    Returns
    -------
    tuple of Contact
        In order; one that begins where the last ended goes on, and one without duration is none.
    """
    found: list[Contact] = []
    since = edges[0]

    def enter(end: float, *, closed: bool) -> None:
        """A contact from ``since`` on."""
        start = found.pop().start if found and found[-1].end == since else since
        if end > start:
            found.append(Contact(start=start, end=end, closed=closed))

    for span in pairwise(edges):
        t, idle = span[0], 0
        while t < span[1]:
            before = t
            t, ended = advance(t, span, touching, idle < _IDLE)
            idle = idle + 1 if t == before else 0
            if ended:
                if touching:
                    enter(t, closed=True)
                touching, since = not touching, t
    if touching:
        enter(edges[-1], closed=False)
    return tuple(found)
