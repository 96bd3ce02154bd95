"""Long harmonic runs of the scheme by its eigenvectors: time stepping would take billions of updates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError
from lure.rod.discretisation import Form, upwind
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario, initial_state

Complex = NDArray[np.complex128]

_STEP = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalRun:
    """A motion of the scheme under ``g = amplitude sin(omega t)``.

    Attributes
    ----------
    t, z : ndarray
        (n,) times [s] and contact coordinate [m].
    contacts : tuple of (float, float)
        Intervals with ``z > 0`` [s]; one still open at the end is closed there.
    """

    t: NDArray[np.float64]
    z: NDArray[np.float64]
    contacts: tuple[tuple[float, float], ...]

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


@dataclass(frozen=True, eq=False)
class ModalBasis:
    """The eigenvectors of a scheme in free flight and in contact; they do not depend on its form.

    Attributes
    ----------
    rod : Rod
        The rod, with the linear law and ``k != Z`` (at ``k = Z`` there is no basis of eigenvectors).
    cells : int
        ``N``.

    Raises
    ------
    AssumptionError
        ``m`` is not 1, or ``k = Z``.
    """

    rod: Rod
    cells: int

    def __post_init__(self) -> None:
        """Refuse what has no basis."""
        if self.rod.exponent != 1 or self.rod.reflection == 0:
            raise AssumptionError(
                f"eigenvectors need the linear law and k other than Z; got m = {self.rod.exponent:g}, "
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
        """The last state, ``z``, at several times."""
        growth = np.exp(np.multiply.outer(t - self.start, self.modes.values))
        free = growth @ (self.modes.vectors[-1] * self.weights)
        return np.asarray(free.real + (self.response[-1] * np.exp(1j * self.omega * t)).imag)


@dataclass(frozen=True, kw_only=True, slots=True)
class HarmonicForce:
    """``g(t) = amplitude sin(omega t)``.

    Attributes
    ----------
    amplitude : float
        [N].
    omega : float
        [rad/s].
    """

    amplitude: float
    omega: float


def modal_run(basis: ModalBasis, release: Scenario, force: HarmonicForce, *, form: Form, until: float) -> ModalRun:
    """Motion of the scheme under a harmonic force, exact between contact events.

    Free flight and contact with the linear law are two linear systems; each is solved with its eigenvectors and its
    response to ``e^{i omega t}``, and contact and release are located between samples 1 ms apart.

    Parameters
    ----------
    basis : ModalBasis
        The eigenvectors.
    release : Scenario
        Initial data; no loads of its own.
    force : HarmonicForce
        The force.
    form : {"corrected", "as-printed"}
        Form of the scheme.
    until : float
        End of the span [s].

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
