"""What may be asked of ``lure simulate``, checked before anything is computed, and who does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import cast

from lure.analysis.rod.runs.methods import sampled_galerkin, sampled_motion, sampled_scheme
from lure.analysis.rod.runs.sampled import SampledRun, check_places, check_samples, sparse
from lure.analysis.rod.simulation.simulate import LARGEST_CELLS
from lure.errors import InputError, demand_seconds
from lure.record import described, quantity
from lure.rod.discretisation import upwind
from lure.rod.galerkin.spaces import SpaceName
from lure.rod.motion import Boundary, Motion, Numerics, exact_motion
from lure.rod.parameters import Rod
from lure.rod.systems import RodSystem, rod_from_exact

INTEGRATORS = ("LSODA", "RK45", "DOP853", "Radau", "BDF", "CVODE")
METHODS = ("exact", "scheme", "galerkin", *INTEGRATORS)
BOUNDARIES = {
    "dashpot": "the dashpot of the system",
    "free": "free, k = 0",
    "matched": "matched, k = Z",
    "clamped": "clamped",
}
SPACES = ("P1", "P2", "cosine")
_DRAWN_PLACES = 101


@described(frozen=True, kw_only=True, slots=True)
class Request:
    """One motion asked for."""

    until: float = quantity("End of the motion", "s")
    method: str = quantity(
        '``"exact"`` (the rod itself), ``"scheme"`` (event-exact), ``"galerkin"``, or an integrator of the scheme',
        default="exact",
    )
    samples: int = quantity("Number of instants kept", default=2001)
    places: int = quantity("Number of places along the rod at which fields are kept; 0 for none", default=0)
    boundary: str = quantity(
        'End ``x = 0``: ``"dashpot"``, the rod\'s own ``k``, ``"free"``, ``k = 0``, ``"matched"``, ``k = Z`` (to '
        'the nearest double), or ``"clamped"``, ``k = inf``',
        default="dashpot",
    )
    end_damping: float = quantity("``k_L``, a dashpot at ``x = L`` [N s/m]", default=0.0)
    rigid: bool = quantity("Whether the obstacle is rigid", default=False)
    cells: int | None = quantity("``N`` of the scheme; None for that of the system", default=None)
    space: str | None = quantity("Galerkin elements; None for P1", default=None)
    order: int | None = quantity("Dimension of the Galerkin space; None for 51", default=None)

    def __post_init__(self) -> None:
        """Refuse what no method can do.

        Raises
        ------
        InputError
            A field is out of range, or two of them do not go together.
        """
        demand_seconds("until", self.until)
        check_samples(self.samples)
        if self.places:
            check_places(self.places, self.samples)
        _among("method", self.method, METHODS)
        _among("boundary", self.boundary, tuple(BOUNDARIES))
        if self.space is not None:
            _among("space", self.space, SPACES)
        if self.method != "exact":
            beyond = {"boundary clamped": self.boundary == "clamped", "rigid": self.rigid}
            beyond["end-damping"] = self.end_damping != 0.0
            for name, asked in beyond.items():
                if asked:
                    raise InputError(f"{name} is for the rod itself; leave it out, or give method exact")
        scheme = self.method not in ("exact", "galerkin")
        if self.cells is not None and not scheme:
            raise InputError(f"cells is {self.cells}, and method {self.method} has none; give method scheme")
        if self.method != "galerkin" and (self.space, self.order) != (None, None):
            raise InputError(f"space and order are for method galerkin; leave them out with method {self.method}")

    def rod(self, rod: Rod) -> Rod:
        """The rod with the dashpot that the boundary asks for."""
        if self.boundary in ("dashpot", "clamped"):
            return rod
        damping = Fraction(rod.impedance) if self.boundary == "matched" else Fraction(0)
        return rod_from_exact({**rod.exact, "damping": damping})


def for_drawing(request: Request, system: RodSystem) -> Request:
    """The request with the fields that a picture of the whole rod needs, where no exact motion is kept to draw from.

    ``system``: the system, whose cells count if the request names none.

    Raises
    ------
    InputError
        The method keeps the end of the rod only.
    """
    if request.method == "exact" or request.places:
        return request
    if request.method == "galerkin":
        return replace(request, places=_DRAWN_PLACES)
    cells = _cells(request, system)
    if request.method != "scheme" or cells > LARGEST_CELLS:
        raise InputError(
            f"method {request.method} with {cells} cells keeps the end of the rod only; draw the whole rod with method "
            f"exact, galerkin, or scheme of at most {LARGEST_CELLS} cells"
        )
    return replace(request, places=cells + 1)


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Performed:
    """A motion and its samples."""

    run: SampledRun = quantity("The samples")
    motion: Motion | None = quantity(
        "The exact motion behind them, which knows every instant and place; None if a scheme or a space moved",
        default=None,
    )


def perform(
    system: RodSystem,
    request: Request,
    *,
    energy: bool = True,
    progress: Callable[..., None] | None = None,
) -> Performed:
    """Compute the motion of a system.

    Parameters
    ----------
    system : RodSystem
        The rod, its loads and initial data, and the scheme to analyse.
    request : Request
        What is asked for.
    energy : bool
        Whether the energy of an exact motion is wanted, too.
    progress : callable, optional
        Called as ``progress(stage, done)``, with the share done or None.

    Raises
    ------
    InputError
        The method refuses the data.
    AssumptionError
        The motion leaves what the method can follow.
    """
    changed = replace(system, rod=request.rod(system.rod))
    if progress:
        progress(f"motion by {request.method}")
    if request.method == "exact":
        done = _exact(changed, request, energy=energy, progress=progress)
    elif request.method == "galerkin":
        done = Performed(run=_in_space(changed, request))
    else:
        done = Performed(run=_of_scheme(changed, request))
    ends: dict[str, str | int | float] = {
        "boundary_at_0": BOUNDARIES[request.boundary],
        "boundary_end_damping": request.end_damping,
        "boundary_obstacle": "rigid" if request.rigid else "compliant",
    }
    note = "; ".join(filter(None, (done.run.note, sparse(request.until, request.samples, changed.rod))))
    return replace(done, run=replace(done.run, details={**done.run.details, **ends}, note=note))


def _in_space(system: RodSystem, request: Request) -> SampledRun:
    return sampled_galerkin(
        system.rod,
        system.scenario,
        request.until,
        space=cast("SpaceName", request.space or "P1"),
        order=51 if request.order is None else request.order,
        samples=request.samples,
        places=request.places,
    )


def _cells(request: Request, system: RodSystem) -> int:
    return request.cells if request.cells is not None else system.simulation_cells or system.cells


def _of_scheme(system: RodSystem, request: Request) -> SampledRun:
    scheme = upwind(system.rod, _cells(request, system), form=system.form)
    return sampled_scheme(
        scheme,
        system.scenario,
        request.until,
        method=request.method,
        samples=request.samples,
        places=request.places,
    )


def _exact(system: RodSystem, request: Request, *, energy: bool, progress: Callable[..., None] | None) -> Performed:
    def tell(reached: float) -> None:
        """The share of the time that is done."""
        if progress:
            progress("the motion of the rod", min(1.0, reached / request.until))

    boundary = Boundary(clamped=request.boundary == "clamped", end_damping=request.end_damping, rigid=request.rigid)
    numerics = Numerics(on_progress=tell if progress else None)
    motion = exact_motion(system.rod, system.scenario, request.until, boundary=boundary, numerics=numerics)
    if progress:
        progress("samples")
    run = sampled_motion(motion, request.samples, places=request.places, energy=energy)
    if system.form == "as-printed":
        said = "the scheme as printed answers the force divided by c N/L; the rod here answers the force as it stands"
        run = replace(run, note="; ".join(filter(None, (run.note, said))))
    return Performed(run=run, motion=motion)


def _among(name: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise InputError(f"{name} is {value!r:.40}; give one of {', '.join(allowed)}")
