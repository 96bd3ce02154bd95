"""A motion as samples: of which object, on which evidence, every quantity with unit and sign; as data, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from lure.analysis.drawing import drawn
from lure.analysis.verdict import Evidence
from lure.record import Page, finite, plain, quantity
from lure.rod import datasets
from lure.rod.datasets import what_it_shows
from lure.rod.motion.sampling import Along as Along
from lure.rod.motion.sampling import Samples
from lure.rod.motion.sampling import check_places as check_places
from lure.rod.motion.sampling import check_samples as check_samples
from lure.rod.parameters import Rod

if TYPE_CHECKING:
    import control

_APART = 0.5  # transits L/c
_REST = 1e-28  # of the largest energy: velocities below 1e-14 of the largest


class SampledRun(Samples):
    """One motion at increasing instants, with its contacts; it shows this motion and proves nothing of others.

    ``to_xarray`` gives the same bytes for the same motion, since no clock time is in it: dimensions ``t`` (samples),
    ``impact`` and, if fields were kept, ``x``.  Each variable has ``units`` and a ``long_name`` with its sign.
    ``impacts`` is the number of contacts; ``impact_*`` describe each, nan where the method does not tell.  The
    attributes name the object that moved, the evidence, the method with its error, the rod (doubles, and exact
    fractions as text), the formulas of loads and data, and the version of lure.
    """

    evidence: Evidence = quantity("``COMPUTED`` with an error estimate, else ``OBSERVED``")

    @property
    def until(self) -> float:
        """The last sample [s]."""
        return float(self.t[-1])

    @property
    def largest_stress(self) -> tuple[float, str]:
        """Largest contact stress [Pa], and whether over all instants or at the samples only."""
        peaks = [impact.peak_stress for impact in self.impacts]
        if any(math.isnan(peak) for peak in peaks):
            return float(self.stress.max()), "at the samples"
        return max(peaks, default=0.0), "over all instants"

    @property
    def impulse(self) -> float:
        """Sum of the impulses of all contacts, ``A int p dt`` [N s]; nan where one is not known."""
        return math.fsum(impact.impulse for impact in self.impacts)

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        found: Any = plain(summary_dict(self, self.about))
        return {"subject": self.subject, "evidence": str(self.evidence), **found}

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        return datasets.loop_response(self.about, self.t, self.z, self.stress, self.scenario.force(t=self.t))

    plot = drawn("The end of the rod and its contacts; see :func:`lure.analysis.rod.plots.plot_run_end`.")

    def _page(self) -> Page:

        return summary_page(self)


def sparse(until: float, samples: int, rod: Rod) -> str:
    """A warning where waves pass the end unseen between two samples: more than half a transit apart; else nothing.

    ``until``: end of the motion [s]; ``samples``: number of instants, evenly spaced.
    """
    apart = until / (samples - 1) / rod.travel_time
    if apart <= _APART:
        return ""
    return f"the samples are {apart:.3g} transits L/c apart, and what the waves do between them is not in the samples"


def summary_lines(run: SampledRun, name: str) -> list[str]:
    """What moved, what touched, how energy and errors stand, and what this shows; ``name``: name of the system."""
    said = [f"{name} up to {run.until:g} s: {run.about}.", *_ends(run), _contact(run), _end(run)]
    if run.energy is not None:
        said.append(f"Energy: {run.energy[0]:.6g} J at the start, {run.energy[-1]:.6g} J at the end.")
    if run.energy_residual is not None:
        said.append(f"Energy balance: relative residual {run.energy_residual:.1g}.")
    if run.error is not None:
        said.append(f"Error of z: {run.error:.1g} m ({run.error_is}).")
    else:
        said.append("Error of z: not estimated.")
    said.append(f"Method: {run.method.removesuffix('.')}.")
    if run.note:
        said.append(f"Note: {run.note}.")
    other = "" if run.subject == "rod" else ", and it is not a motion of the rod"
    said.append(f"One motion, {run.evidence}: it proves nothing of others{other}.")
    return said


def _ends(run: SampledRun) -> list[str]:
    """How the ends differ from those of the system."""
    found = []
    at_0, end_damping = run.details.get("boundary_at_0"), run.details.get("boundary_end_damping")
    if at_0 not in (None, "the dashpot of the system", "dashpot"):
        found.append(f"x = 0 is {at_0}")
    if run.details.get("boundary_obstacle") == "rigid":
        found.append("the obstacle is rigid")
    if end_damping:
        found.append(f"x = L has a dashpot of {end_damping:g} N s/m")
    return [f"Ends: {', '.join(found)}."] if found else []


def _contact(run: SampledRun) -> str:
    if not run.impacts:
        return f"Contact: none; largest z {float(run.z.max()):.6g} m at the samples."
    number, first = len(run.impacts), run.impacts[0].start
    stress, where = run.largest_stress
    impulse = "" if math.isnan(run.impulse) else f", impulse {run.impulse:.6g} N s in all"
    times = "once" if number == 1 else f"{number} times"
    return f"Contact: {times}, first at {first:.6g} s; largest stress {stress:.6g} Pa {where}{impulse}."


def _end(run: SampledRun) -> str:
    touching = bool(run.impacts) and not run.impacts[-1].closed
    state = "in contact" if touching else "in flight" if moving(run) else "at rest to rounding"
    return f"At the end: {state}, u(t, L) = {run.u_end[-1]:.9g} m, z = {run.z[-1]:.9g} m."


def moving(run: SampledRun) -> bool:
    """Whether energy above rounding is left at the end; true where the method gives no energy."""
    return run.energy is None or float(run.energy[-1]) > _REST * float(run.energy.max())


def summary_dict(run: SampledRun, name: str) -> dict[str, Any]:
    """The same as plain data, with every impact; numbers that are not known are None.

    ``name``: name of the system.
    """
    stress, where = run.largest_stress
    return {
        "system": name,
        "until": run.until,
        "samples": len(run.t),
        "end": {
            "u_end": float(run.u_end[-1]),
            "z": float(run.z[-1]),
            "energy": None if run.energy is None else float(run.energy[-1]),
        },
        "largest_stress": stress,
        "largest_stress_is": where,
        "impulse": finite(run.impulse),
        "impacts": plain(run.impacts),
        "energy_residual": run.energy_residual,
        "error": run.error,
        "attributes": run._attributes() | {"title": f"Motion of {name}"},
    }


def summary_page(run: SampledRun) -> Page:
    """A table for notebooks: the same lines."""
    said = [("what moved", run.about), ("time", f"{run.t[0]:g} s to {run.until:g} s, {run.t.size} samples")]
    said += [("force g(t) [N]", str(run.scenario.force))]
    lines = [line.partition(": ") for line in summary_lines(run, run.subject)[1:-1]]
    said += [(name, text) for name, _, text in lines]
    notes = (what_it_shows(run.subject, run.about, str(run.evidence)),)
    return Page(f"motion of the {run.subject}", said, verdict=str(run.evidence).upper(), notes=notes)
