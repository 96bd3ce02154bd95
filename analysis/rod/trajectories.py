"""``simulate``: a trajectory of any loop from given initial data, the rod's and its scheme's among them."""

from __future__ import annotations

from lure.analysis.counterexamples.simulated import SIMULATED_SAMPLES, Motion, solution
from lure.analysis.rod.simulation import Trajectory
from lure.analysis.rod.simulation import simulate as simulate_scheme
from lure.arrays import ArrayLike
from lure.errors import InputError
from lure.files.system import LoopSystem
from lure.loop import Loop
from lure.nonlinearities.reading import as_nonlinearity
from lure.plants import as_plant
from lure.plants.rational import RationalPlant
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.scenario import Scenario
from lure.rod.systems import RodSystem


def simulate(
    loop: object,
    nonlinearity: object = None,
    *,
    x0: ArrayLike | None = None,
    until: float | None = None,
    samples: int = SIMULATED_SAMPLES + 1,
) -> Motion | Trajectory:
    """One trajectory of ``sigma = H mu``, ``mu = -phi(sigma)``: observed, and no proof of anything.

    Parameters
    ----------
    loop : Loop, LoopSystem, RodSystem, UpwindScheme, or a plant
        What :func:`lure.as_plant` takes is a plant, closed by ``nonlinearity``.
    nonlinearity : Nonlinearity, callable or Scenario
        The nonlinearity, for a plant; for an ``UpwindScheme`` the loads and initial data.
    x0 : array_like
        (n,) first state, of the matrices the plant was given by, else of its companion form.  A rod has its own.
    until : float
        Last instant [s]; by default that of a ``RodSystem``.
    samples : int
        Number of instants recorded, in continuous time.

    Returns
    -------
    Motion or Trajectory
        Of a loop ``t``, ``sigma`` and ``states``; of the scheme of a rod the waves, contacts and energies.

    Raises
    ------
    InputError
        Something is missing, or the shapes do not fit.

    Examples
    --------
    >>> from lure import Saturation
    >>> found = simulate(([1], [1, 3, 2, 0]), Saturation(gain=3), x0=[1, 0, 0], until=40)
    >>> print(f"sigma({found.t[-1]:.0f}) = {found.sigma[-1]:.5f}")
    sigma(40) = -0.00051
    """
    if isinstance(loop, RodSystem):
        cells = loop.single.simulation_cells or loop.cells
        nonlinearity, until = loop.scenario, loop.until if until is None else until
        loop = upwind(loop.rod, cells, form=loop.form)
    if until is None:
        raise InputError("simulate.until is missing; give the last instant in seconds")
    if isinstance(loop, UpwindScheme):
        if not isinstance(nonlinearity, Scenario) or x0 is not None:
            raise InputError("a scheme is simulated with a Scenario, its loads and initial data, and without x0")
        return simulate_scheme(loop, nonlinearity, until=until, samples=samples)
    if isinstance(loop, Loop | LoopSystem):
        nonlinearity = loop.nonlinearity if nonlinearity is None else nonlinearity
        loop = loop.block
    block = as_plant(loop)
    if not isinstance(block, RationalPlant):
        raise InputError(f"a {type(block).__name__} has no finite state with exact equations; give coefficients")
    if nonlinearity is None or x0 is None:
        raise InputError("a loop is simulated with a nonlinearity and a first state x0")
    nonlinearity = nonlinearity if callable(nonlinearity) else as_nonlinearity(nonlinearity)
    dt = None if block.dt is None else float(block.dt)
    return solution(block.realisation, nonlinearity, x0, until, dt=dt, samples=samples)
