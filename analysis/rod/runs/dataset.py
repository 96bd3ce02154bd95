"""A sampled motion as an xarray Dataset with the attributes of the CF conventions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lure.analysis.rod.runs.sampled import SampledRun
from lure.rod import datasets
from lure.rod.datasets import Column
from lure.rod.motion import Motion

if TYPE_CHECKING:
    import xarray


def motion_dataset(motion: Motion, samples: int = 2001, *, places: int = 0) -> xarray.Dataset:
    """The exact motion of a rod as a Dataset, evenly sampled.

    Parameters
    ----------
    motion : Motion
        From :func:`lure.rod.motion.exact_motion`.
    samples : int
        Number of instants.
    places : int
        Number of places along the rod at which velocity, strain and displacement are kept; 0 for none.

    Returns
    -------
    xarray.Dataset
        As :func:`run_dataset` has it.

    Raises
    ------
    InputError
        ``samples`` or ``places`` is out of range, or xarray is not installed.

    Examples
    --------
    >>> from lure import builtin_system
    >>> from lure.rod.motion import exact_motion
    >>> system = builtin_system("paper-rod")
    >>> found = motion_dataset(exact_motion(system.rod, system.scenario, 1e-3), samples=5)
    >>> found.u_end.attrs["units"], dict(found.sizes), found.attrs["evidence"]
    ('m', {'t': 5, 'impact': 0}, 'computed')
    """
    return motion.to_xarray(samples, places=places)


def run_dataset(run: SampledRun, *, title: str = "Motion of a rod against an obstacle") -> xarray.Dataset:
    """A sampled motion as a Dataset: the same bytes for the same motion, since no clock time is in it.

    Parameters
    ----------
    run : SampledRun
        The motion.
    title : str
        Attribute ``title``.

    Returns
    -------
    xarray.Dataset
        Dimensions ``t`` (samples), ``impact`` and, if fields were kept, ``x``.  Each variable has ``units`` and a
        ``long_name`` with its sign.  ``impacts`` is the number of contacts; ``impact_*`` describe each, nan where the
        method does not tell.  The attributes name the object that moved, the evidence, the method with its error, the
        rod (doubles, and exact fractions as text), the formulas of loads and data, and the version of lure.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    variables = datasets.series({name: getattr(run, name) for name in datasets.SERIES})
    variables |= datasets.impact_columns(run.impacts)
    coordinates = {
        "t": Column(("t",), run.t, "s", datasets.TIME),
        "impact": datasets.numbered("impact", len(run.impacts)),
    }
    if run.along is not None:
        coordinates["x"] = Column(("x",), run.along.x, "m", datasets.PLACE)
        variables |= datasets.fields({name: getattr(run.along, name) for name in ("v", "w", "u")})
    return datasets.dataset(variables, coordinates, attributes(run, title))


def attributes(run: SampledRun, title: str) -> dict[str, str | int | float]:
    """Global attributes: what moved, how that is known, and every number that went in.

    Parameters
    ----------
    run : SampledRun
        The motion.
    title : str
        Its title.
    """
    found: dict[str, str | int | float] = {
        **datasets.motion_attributes(
            title, subject=run.subject, about=run.about, evidence=str(run.evidence), method=run.method
        ),
        **datasets.rod_attributes(run.rod),
        **datasets.scenario_attributes(run.scenario),
    }
    if run.energy_residual is not None:
        found["energy_residual"] = run.energy_residual
    if run.error is not None:
        found |= {"error_estimate": run.error, "error_estimate_units": "m", "error_estimate_of": run.error_is}
    if run.note:
        found["note"] = run.note
    return found | {f"method_{name}": value for name, value in run.details.items()}
