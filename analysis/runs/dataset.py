"""A sampled motion as an xarray Dataset with the attributes of the CF conventions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.runs.exact import sampled_motion
from analysis.runs.sampled import SampledRun
from lure.errors import InputError
from lure.motion import Motion
from lure.rod import PARAMETERS

if TYPE_CHECKING:
    from types import ModuleType

    import xarray

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
# field of SampledRun: name in the file, unit, meaning with its sign
_SERIES = {
    "u_end": ("u_end", "m", "displacement u(t, L) of the end x = L, positive along x"),
    "z": ("z", "m", "contact coordinate u(t, L) - gap, positive in contact with a compliant obstacle"),
    "v_end": ("v_end", "m s-1", "velocity of the end x = L, positive along x; at a jump the value after it"),
    "stress": (
        "contact_stress",
        "Pa",
        "contact stress p(z) of the obstacle, positive in compression: E u_x(t, L) = -p",
    ),
    "dashpot_force": ("dashpot_force", "N", "k u_t(t, 0), what the dashpot at x = 0 holds back"),
    "v_0": ("v_0", "m s-1", "velocity of the end x = 0, positive along x; at a jump the value after it"),
    "energy": ("energy", "J", "kinetic, elastic and contact energy of the object that moves"),
}
_IMPACTS = {
    "start": ("impact_start", "s", "instant of contact"),
    "end": ("impact_end", "s", "instant of release, or the end of the motion if impact_closed is 0"),
    "impulse": ("impact_impulse", "N s", "impulse A int p dt given to the obstacle"),
    "peak_stress": ("impact_peak_stress", "Pa", "largest contact stress over all instants of the contact"),
}
_ALONG = {
    "v": ("v", "m s-1", "velocity, positive along x"),
    "w": ("w", "1", "strain u_x, positive in tension"),
    "u": ("u", "m", "displacement, positive along x"),
}
_PAPER = (
    "Danciu, Matei, Micu, Roventa: Nonlinear Feedback Control and Artificial Intelligence Computational Methods "
    "applied to a Dissipative Dynamic Contact Problem, equations (8) and (9)"
)


def motion_dataset(motion: Motion, samples: int = 2001, *, places: int = 0) -> xarray.Dataset:
    """The exact motion of a rod as a Dataset, evenly sampled.

    Parameters
    ----------
    motion : Motion
        From :func:`lure.motion.exact_motion`.
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
    >>> from lure.motion import exact_motion
    >>> system = builtin_system("paper-rod")
    >>> found = motion_dataset(exact_motion(system.rod, system.scenario, 1e-3), samples=5)
    >>> found.u_end.attrs["units"], dict(found.sizes), found.attrs["evidence"]
    ('m', {'t': 5, 'impact': 0}, 'computed')
    """
    _xarray()
    return run_dataset(sampled_motion(motion, samples, places=places))


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
    dataset = _xarray().Dataset
    variables: dict[str, Any] = {}
    for name, (label, unit, meaning) in _SERIES.items():
        values = getattr(run, name)
        if values is not None:
            variables[label] = (("t",), np.array(values), {"units": unit, "long_name": meaning})
    variables |= _impact_variables(run)
    coordinates: dict[str, Any] = {
        "t": (("t",), np.array(run.t), {"units": "s", "long_name": "time since the start of the motion"})
    }
    coordinates["impact"] = (
        ("impact",),
        np.arange(1, len(run.impacts) + 1),
        {"units": "1", "long_name": "number of the contact, in order"},
    )
    if run.along is not None:
        coordinates["x"] = (
            ("x",),
            np.array(run.along.x),
            {"units": "m", "long_name": "place along the unstrained rod"},
        )
        for name, (label, unit, meaning) in _ALONG.items():
            values = np.array(getattr(run.along, name))
            variables[label] = (("t", "x"), values, {"units": unit, "long_name": meaning})
    made: xarray.Dataset = dataset(variables, coords=coordinates, attrs=attributes(run, title))
    return made


def _impact_variables(run: SampledRun) -> dict[str, Any]:
    counted = {"units": "1", "long_name": "number of contacts with the obstacle"}
    found: dict[str, Any] = {"impacts": ((), np.int32(len(run.impacts)), counted)}
    for name, (label, unit, meaning) in _IMPACTS.items():
        values = np.array([getattr(impact, name) for impact in run.impacts], dtype=float)
        found[label] = (("impact",), values, {"units": unit, "long_name": meaning})
    flags = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "in_contact_at_the_end released"}
    closed = np.array([impact.closed for impact in run.impacts], dtype=np.int8)
    found["impact_closed"] = (("impact",), closed, {"long_name": "whether the contact ended", **flags})
    return found


def attributes(run: SampledRun, title: str) -> dict[str, str | int | float]:
    """Global attributes: what moved, how that is known, and every number that went in.

    Parameters
    ----------
    run : SampledRun
        The motion.
    title : str
        Its title.
    """
    from lure import __version__

    rod, scenario = run.rod, run.scenario
    found: dict[str, str | int | float] = {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"lure {__version__}: {run.method}",
        "references": _PAPER,
        "comment": comment(run),
        "subject": run.subject,
        "evidence": str(run.evidence),
        "lure_version": __version__,
    }
    for name in PARAMETERS:
        found[f"rod_{name}"] = getattr(rod, name)
        found[f"rod_{name}_exact"] = str(rod.exact[name])
        found[f"rod_{name}_units"] = UNITS[name]
    if rod.exponent != 1.0:
        found["rod_compliance_units"] = f"m{rod.exponent:g} Pa-1"
    found |= {
        "rod_wave_speed": rod.wave_speed,
        "rod_impedance": rod.impedance,
        "rod_travel_time": rod.travel_time,
        "rod_reflection": rod.reflection,
        "force_g": str(scenario.force),
        "force_f": str(scenario.body_force),
        "initial_u0": str(scenario.displacement),
        "initial_u1": str(scenario.velocity),
    }
    if run.energy_residual is not None:
        found["energy_residual"] = run.energy_residual
    if run.error is not None:
        found |= {"error_estimate": run.error, "error_estimate_units": "m", "error_estimate_of": run.error_is}
    if run.note:
        found["note"] = run.note
    return found | {f"method_{name}": value for name, value in run.details.items()}


def comment(run: SampledRun) -> str:
    """What the motion shows and what it does not.

    Parameters
    ----------
    run : SampledRun
        The motion.
    """
    other = "" if run.subject == "rod" else " It is not a motion of the rod."
    return (
        f"A motion of {run.about}; {run.evidence} evidence of this one motion, which proves nothing of others.{other}"
    )


def _xarray() -> ModuleType:
    try:
        import xarray
    except ImportError:
        raise InputError('a Dataset needs xarray: pip install "lure[netcdf]"') from None
    return xarray
