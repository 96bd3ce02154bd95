"""The motions behind the figures: the release of figures 3 to 7, the forced motions of figures 8 to 10."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.paper.model import Peak, Variant
from lure.analysis.rod.paper.settling import Settling, rod_settling, scheme_settling
from lure.analysis.rod.simulation import Trajectory, simulate
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError
from lure.record import described, quantity
from lure.rod.discretisation import Form, upwind
from lure.rod.motion import Motion, exact_motion
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario, initial_state
from lure.rod.systems import RodSystem, builtin_system

# Long harmonic runs of the scheme by its eigenvectors: time stepping would take billions of updates.

Complex = NDArray[np.complex128]

_STEP = 1e-3


@described(frozen=True, kw_only=True, eq=False)
class ModalRun:
    """A motion of the scheme under ``g = amplitude sin(omega t)``."""

    t: NDArray[np.float64] = quantity("(n,) times", "s")
    z: NDArray[np.float64] = quantity("(n,) contact coordinate", "m")
    contacts: tuple[tuple[float, float], ...] = quantity(
        "Intervals with ``z > 0`` [s]; one still open at the end is closed there"
    )

    @property
    def peak(self) -> tuple[float, float]:
        """When and how large the largest ``z`` is [s], [m]: the vertex of the parabola through the largest samples."""
        i = int(np.argmax(self.z))
        if not 0 < i < len(self.z) - 1:
            return float(self.t[i]), float(self.z[i])
        before, top, after = (float(value) for value in self.z[i - 1 : i + 2])
        tilt, bend = 0.5 * (after - before), before - 2.0 * top + after
        return float(self.t[i]) - tilt / bend * _STEP, top - 0.5 * tilt**2 / bend


@dataclass(frozen=True, kw_only=True, eq=False)
class _Modes:
    """Eigenvalues (n,), eigenvectors in columns (n, n), and the inverse of those."""

    values: Complex
    vectors: Complex
    inverse: Complex


@described(frozen=True, eq=False)
class ModalBasis:
    """The eigenvectors of a scheme in free flight and in contact; they do not depend on its form.

    Raises
    ------
    AssumptionError
        ``m`` is not 1, or ``k = Z``.
    """

    rod: Rod = quantity(
        "The rod, with the linear contact law and ``k != Z`` (at ``k = Z`` there is no basis of eigenvectors)"
    )
    cells: int = quantity("``N``")

    def __post_init__(self) -> None:
        """Refuse what has no basis."""
        if self.rod.exponent != 1 or self.rod.reflection == 0:
            raise AssumptionError(
                f"eigenvectors need the linear contact law and k other than Z; got m = {self.rod.exponent:g}, "
                f"k = {self.rod.damping:g}, Z = {self.rod.impedance:g}"
            )

    @cached_property
    def free(self) -> _Modes:
        """Closed form: the ring is f-circulant, with eigenvectors ``gamma^{-j}``."""
        scheme, N = upwind(self.rod, self.cells), self.cells
        values = scheme.eigenvalues()
        gamma = 1.0 + values / scheme.rate
        vectors, inverse = np.zeros((2, 2 * N + 1, 2 * N + 1), dtype=complex)
        powers = gamma[:, None] ** np.arange(2 * N)
        vectors[:-1, :-1], inverse[:-1, :-1] = (1.0 / powers).T, powers / (2 * N)
        vectors[-1, :-1] = 1.0 / (powers[:, N - 1] * values)
        vectors[-1, -1] = inverse[-1, -1] = 1.0
        inverse[-1, :-1] = -vectors[-1, :-1] @ inverse[:-1, :-1]
        return _Modes(values=np.append(values, 0.0), vectors=vectors, inverse=inverse)

    @cached_property
    def contact(self) -> _Modes:
        """By LAPACK."""
        scheme = upwind(self.rod, self.cells)
        values, vectors = np.linalg.eig(scheme.block.dense() - np.outer(scheme.b1, scheme.c) / self.rod.compliance)
        return _Modes(values=values, vectors=vectors, inverse=np.linalg.inv(vectors))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Phase:
    """One stretch of free flight or of contact: ``y = V e^{Lambda (t - start)} w + Im(Y e^{i omega t})``."""

    modes: _Modes
    response: Complex
    omega: float
    start: float
    weights: Complex

    def state(self, t: float) -> NDArray[np.float64]:
        """The state at ``t``."""
        free = self.modes.vectors @ (self.weights * np.exp(self.modes.values * (t - self.start)))
        return np.asarray(free.real + (self.response * np.exp(1j * self.omega * t)).imag)

    def gap(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """The last state, ``z``, at evenly spaced times: exponentials of sums are products, so that few are taken."""
        step, count = float(t[-1] - t[0]) / max(len(t) - 1, 1), math.isqrt(len(t) - 1) + 1
        early = np.exp(np.multiply.outer(step * np.arange(count), self.modes.values))
        late = np.exp(np.multiply.outer(t[::count] - self.start, self.modes.values))
        free = ((late * (self.modes.vectors[-1] * self.weights)) @ early.T).real.ravel()[: len(t)]
        return np.asarray(free + (self.response[-1] * np.exp(1j * self.omega * t)).imag)


@described(frozen=True, kw_only=True, slots=True)
class HarmonicForce:
    """``g(t) = amplitude sin(omega t)``."""

    amplitude: float = quantity("[N]")
    omega: float = quantity("[rad/s]")


def modal_run(basis: ModalBasis, release: Scenario, force: HarmonicForce, *, form: Form, until: float) -> ModalRun:
    """Motion of the scheme under a harmonic force, exact between contact events.

    Free flight and contact with the linear contact law are two linear systems; each is solved with its eigenvectors and
    its response to ``e^{i omega t}``, and contact and release are located between samples 1 ms apart.

    ``release``: initial data, no loads of its own; ``until``: end of the span [s].

    Raises
    ------
    AssumptionError
        ``release`` has loads.

    Notes
    -----
    OBSERVED: floating point, and a contact shorter than 1 ms can go unseen.  Compared with the simulation on ten cells
    in the tests.
    """
    if not release.free:
        raise AssumptionError(f"release has loads, g = {release.force}, f = {release.body_force}; give only its start")
    scheme = upwind(basis.rod, basis.cells, form=form)
    drive = force.amplitude * scheme.b2
    t: NDArray[np.float64] = np.linspace(0.0, until, round(until / _STEP) + 1)
    z, start, y = np.empty(len(t)), 0.0, initial_state(scheme, release)
    touching, entered, done, contacts = bool(y[-1] > 0), 0.0, 0, []
    while done < len(t):
        phase = _phase(basis.contact if touching else basis.free, drive, force.omega, start, y)
        z[done:] = phase.gap(t[done:])
        left = np.nonzero((z[done:] > 0) != touching)[0]
        if not left.size:
            break
        done += int(left[0])
        start = _crossing(phase, max(start, float(t[max(done - 1, 0)])), float(t[done]))
        y, touching = phase.state(start), not touching
        if touching:
            entered = start
        else:
            contacts.append((entered, start))
    if touching:
        contacts.append((entered, until))
    return ModalRun(t=t, z=z, contacts=tuple(contacts))


def _phase(modes: _Modes, drive: NDArray[np.float64], omega: float, start: float, y: NDArray[np.float64]) -> _Phase:
    """The stretch that begins in the state ``y``, under the input ``drive sin(omega t)``."""
    response = modes.vectors @ ((modes.inverse @ drive) / (1j * omega - modes.values))
    weights = modes.inverse @ (y - (response * np.exp(1j * omega * start)).imag)
    return _Phase(modes=modes, response=response, omega=omega, start=start, weights=weights)


def _crossing(phase: _Phase, low: float, high: float) -> float:
    """When ``z`` crosses zero in between; at the end if rounding hides the change of sign."""
    from scipy.optimize import brentq

    def gap(t: float) -> float:
        """Gap coordinate at one time."""
        return float(phase.gap(np.array([t]))[0])

    return float(brentq(gap, low, high, xtol=1e-15)) if gap(low) * gap(high) < 0 else high


Progress = Callable[[str, float], None]
"""What is told of progress: a few words, and the part done from 0 to 1."""
COARSE, FINE = 10, 200
RELEASE = 2.5e-3
FORCED = (8, 9, 10)
AMPLITUDES = {8: 2.0, 9: 5.0, 10: 2.0}
OMEGA = 4.0
_SAMPLES = 5000
_PER_TRANSIT = 8


@dataclass(frozen=True, kw_only=True, slots=True)
class _Case:
    """A variant of figures 8 to 10: a form and a number of cells, or the rod itself; the force divided or not."""

    variant: Variant
    form: Form | None = None
    cells: int | None = None
    rescaled: bool = False


_CASES = (
    _Case(variant="as-printed", form="as-printed", cells=COARSE),
    _Case(variant="as-printed-200", form="as-printed", cells=FINE),
    _Case(variant="corrected", form="corrected", cells=COARSE),
    _Case(variant="corrected-200", form="corrected", cells=FINE),
    _Case(variant="corrected-rescaled", form="corrected", cells=COARSE, rescaled=True),
    _Case(variant="corrected-rescaled-200", form="corrected", cells=FINE, rescaled=True),
    _Case(variant="rod"),
    _Case(variant="rod-rescaled", rescaled=True),
)


@described(frozen=True, kw_only=True, eq=False)
class ForcedRun:
    """One motion of figures 8 to 10."""

    peak: Peak = quantity("Which motion, and how far it gets")
    t: NDArray[np.float64] = quantity("(n,) times", "s")
    u: NDArray[np.float64] = quantity("(n,) displacement ``u(t, L)``", "m")
    contacts: tuple[tuple[float, float], ...] = quantity("Contact intervals", "s")


@described(frozen=True, kw_only=True, eq=False)
class PaperRuns:
    """Everything computed for the paper's figures."""

    release: RodSystem = quantity("Figures 3 to 7")
    coarse: Trajectory = quantity("Its scheme with ``N = 10``, up to 2.5e-3 s, with frames")
    fine: Trajectory = quantity("The same with ``N = 200``")
    exact: Motion = quantity("The exact motion of its rod, up to 5 s")
    settling: tuple[Settling, ...] = quantity("``N = 10``, ``N = 200``, the rod")
    forced: tuple[ForcedRun, ...] = quantity("Figures 8 to 10 in every variant")

    def run(self, figure: int, variant: Variant) -> ForcedRun:
        """The motion of a figure in a variant."""
        return {(run.peak.figure, run.peak.variant): run for run in self.forced}[figure, variant]


def paper_runs(*, progress: Progress | None = None) -> PaperRuns:
    """Compute the motions behind figures 3 to 10.

    Parameters
    ----------
    progress : callable, optional
        Called as ``progress(stage, done)``, with the share ``0 <= done <= 1`` of the work behind it.

    Notes
    -----
    The paper does not say how long figures 8 to 10 are; 5 s are three periods of ``sin 4t``.
    """
    say = progress or (lambda _stage, _done: None)
    say("figures 3 to 7", 0.0)
    release = builtin_system("paper-rod")
    rod, scenario = release.rod, release.scenario
    coarse, fine = (
        simulate(upwind(rod, cells), scenario, until=RELEASE, samples=1001, frames=121) for cells in (COARSE, FINE)
    )
    settling = (
        scheme_settling(rod, scenario, COARSE),
        scheme_settling(rod, scenario, FINE),
        rod_settling(rod, scenario),
    )
    exact = exact_motion(rod, scenario, 5.0)
    forced: list[ForcedRun] = []
    bases: dict[tuple[Rod, int], ModalBasis] = {}
    for i, figure in enumerate(FORCED):
        say(f"figure {figure}", 0.1 + 0.3 * i)
        system = builtin_system(f"paper-rod-figure-{figure}")
        for cells in (COARSE, FINE):  # figures 9 and 10 share a rod, and finding its eigenvectors is most of the work
            bases.setdefault((system.rod, cells), ModalBasis(system.rod, cells))
        forced += [_forced_run(figure, system, case, bases) for case in _CASES]
    say("done", 1.0)
    return PaperRuns(release=release, coarse=coarse, fine=fine, exact=exact, settling=settling, forced=tuple(forced))


def _forced_run(figure: int, system: RodSystem, case: _Case, bases: dict[tuple[Rod, int], ModalBasis]) -> ForcedRun:
    amplitude = AMPLITUDES[figure] / (upwind(system.rod, COARSE).rate if case.rescaled else 1.0)
    displacement = system.scenario.displacement.source
    if case.cells is None or case.form is None:
        scenario = Scenario.parse(force=f"{amplitude!r}*sin({OMEGA!r}*t)", displacement=displacement)
        motion, step = exact_motion(system.rod, scenario, system.until), system.rod.travel_time / _PER_TRANSIT
        fine: NDArray[np.float64] = step * np.arange(math.floor(system.until / step) + 1, dtype=np.float64)
        every = motion.z(fine)
        kept = slice(None, None, max(1, len(fine) // _SAMPLES))
        t, z, contacts = fine[kept], every[kept], tuple((hit.start, hit.end) for hit in motion.impacts)
        at, largest = float(fine[np.argmax(every)]), float(every.max())
    else:
        release = Scenario.parse(displacement=displacement)
        force = HarmonicForce(amplitude=amplitude, omega=OMEGA)
        found = modal_run(bases[system.rod, case.cells], release, force, form=case.form, until=system.until)
        t, z, contacts = found.t, found.z, found.contacts
        at, largest = found.peak
    peak = Peak(
        figure=figure,
        variant=case.variant,
        cells=case.cells,
        form=case.form,
        amplitude=amplitude,
        largest_z=largest,
        at=at,
        contacts=len(contacts),
        evidence=Evidence.COMPUTED if case.cells is None else Evidence.OBSERVED,
    )
    return ForcedRun(peak=peak, t=t, u=z + system.rod.gap, contacts=contacts)
