"""A sampled motion as an xarray Dataset with the attributes of the CF conventions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lure.analysis.rod.runs.sampled import SampledRun
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
    return run.to_xarray().assign_attrs(title=title)
