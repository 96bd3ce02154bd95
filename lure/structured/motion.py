"""The scheme with its contacts, event to event, for very many cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.scenario import Scenario, initial_state
from lure.structured.flight import free_flight
from lure.structured.force import force_of
from lure.structured.run import Run
from lure.structured.stretch import fewest_cells
from lure.upwind import UpwindScheme

if TYPE_CHECKING:
    import control
    import xarray

Array: TypeAlias = NDArray[np.float64]

_MOST = 20_000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class StructuredMotion:
    """A motion of the scheme with contact, known at samples; OBSERVED evidence.

    Attributes
    ----------
    scheme : UpwindScheme
        What moved.
    scenario : Scenario or None
        Force and initial data; None where a state was given, without a force.
    t : ndarray
        (k,) samples [s].
    z, wave : ndarray
        (k,) contact coordinate [m] and last forward wave ``y_N`` [m/s].
    contacts : tuple of (float, float)
        Beginning and end of every contact [s]; the last may end with the run.
    state : ndarray
        (2N+1,) at the end, in the ordering of the scheme.
    """

    scheme: UpwindScheme
    scenario: Scenario | None
    t: Array
    z: Array
    wave: Array
    contacts: tuple[tuple[float, float], ...]
    state: Array

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.structured.export import run_dict

        return run_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The motion of the end ``x = L`` as an ``xarray.Dataset`` with units and every parameter.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s] and ``contact``; the attributes say that it is OBSERVED and of the scheme, not the rod.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.structured.export import run_dataset

        return run_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        from lure.structured.export import run_response

        return run_response(self)

    def _repr_html_(self) -> str:
        from lure.structured.export import run_html

        return run_html(self)


def structured_motion(
    scheme: UpwindScheme, start: Scenario | ArrayLike, until: float, *, samples: int = 2001
) -> StructuredMotion:
    """Motion of the scheme against its obstacle, with a force or without: jumps from event to event.

    Without a force, a jump of any length by :class:`FreeFlight` between contacts; in contact, and with a force in
    flight, the Poisson average of a shift register with the law and the force in it, up to 64 round trips at a time.
    Beginning and end of contact are located as by :func:`first_contact`.  There is no time step and no error but
    rounding, which the events amplify as the motion itself does.

    It is a motion of the scheme, whose waves lose more energy than the rod's: for the rod see
    :func:`lure.motion.exact_motion`.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme: linear law (``m = 1``), ``k >= 0``, and a few more cells than ``d c_n L/c``.
    start : Scenario or array_like
        Initial data with a force: piece by piece, between rational instants, sums and products of numbers, ``t`` (up to
        ``t**8``), and ``exp``, ``sin`` and ``cos`` of straight lines in ``t``.  Or a state in the ordering of the
        scheme, without a force.
    until : float
        End [s].
    samples : int
        Number of instants kept, evenly spaced from 0 to ``until``.

    Raises
    ------
    InputError
        One of these does not hold, there is a body force, there are more than 20 000 flights and stretches, or contact
        can neither be excluded nor found.

    Notes
    -----
    Memory does not depend on the time.  An event costs ``O(N log N)``, and so does a round trip in contact or under a
    force.

    Examples
    --------
    >>> from lure import Rod, builtin_system, upwind
    >>> rod = Rod(
    ...     youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=0.3, compliance=3e-10, gap=1e-5
    ... )
    >>> run = structured_motion(upwind(rod, 2000), builtin_system("paper-rod").scenario, 1e-3)
    >>> len(run.contacts), bool(run.z[-1] < 0)
    (1, True)
    """
    _check(scheme, until, samples)
    force, scenario = None, start if isinstance(start, Scenario) else None
    if isinstance(start, Scenario):
        if not start.body_force.is_zero:
            raise InputError(
                f"force.f is {str(start.body_force)[:60]}; structured_motion takes no body force; "
                "analysis.simulation.simulate takes any load, up to 1000 cells"
            )
        force, start = force_of(scheme, start.force, until), initial_state(scheme, start)
    ring = free_flight(scheme, start).ring
    times = np.linspace(0.0, until, samples)
    rate = Fraction(scheme.rate)
    run = Run(rate=rate, times=times, stop=rate * Fraction(until), force=force, contact=ring.gap > 0.0)
    for _ in range(_MOST):
        if run.clock >= run.stop:
            break
        ring = run.moved(ring)
    else:
        reached = float(run.clock / run.rate)
        raise InputError(
            f"until is {until:g} s, and {_MOST} flights and stretches of contact end at {reached:.6g} s; give an "
            "earlier end"
        )
    state = np.append(ring.waves, ring.gap / scheme.rate)[scheme.permutation]
    return StructuredMotion(
        scheme=scheme,
        scenario=scenario,
        t=times,
        z=run.gaps / scheme.rate,
        wave=run.waves,
        contacts=run.closed(),
        state=np.asarray(state),
    )


def _check(scheme: UpwindScheme, until: float, samples: int) -> None:
    rod = scheme.rod
    if not 0.0 < until < math.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 2:
        raise InputError(f"samples is {samples!r}; give a whole number of at least 2")
    if rod.exponent != 1.0:
        raise InputError(f"rod.exponent is {rod.exponent:g}; structured_motion takes the linear law, give 1")
    if rod.damping < 0.0:
        raise InputError(f"rod.damping is {rod.damping:g}; structured_motion takes no negative one")
    least = fewest_cells(rod.mobility * rod.law.stiffness * rod.travel_time)
    if scheme.cells < least:
        raise InputError(f"the contact is too stiff for {scheme.cells} cells; give at least {least}")
