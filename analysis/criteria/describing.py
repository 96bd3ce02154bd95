"""The describing function: a hint where a loop might oscillate, and never a verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.criteria.describing_function import real_describing_function
from analysis.evidence import Evidence
from analysis.plant import Plant, closed_loop_poles
from analysis.polynomial import exact_midpoint, real_roots, to_fmpq, to_fraction
from lure.errors import AssumptionError, InputError
from lure.exact_block import exact_block
from lure.laws import Quantiser
from lure.laws.accepting import as_law
from lure.nonlinearity import Nonlinearity
from lure.showing import html_table, plain, xarray_or_refusal

if TYPE_CHECKING:
    import xarray

    from analysis.plots.style import Axes
    from lure.rational import RationalBlock

AMPLITUDE_DECADES = (-9, 9)
_PER_DECADE = 40


@dataclass(frozen=True, kw_only=True, slots=True)
class HarmonicBalance:
    r"""A solution of ``1 + N(A) H(i omega) = 0``: a sinusoid that would sustain itself if harmonics were absent.

    Attributes
    ----------
    amplitude : float
        ``A`` of ``sigma = A sin(omega t)`` [unit of sigma].
    frequency : float
        ``omega`` [rad/s].
    gain : float
        ``N(A) = -1/H(i omega)``.
    stable_guess : bool or None
        Whether the linear loop decays for the gain at a slightly larger and grows for that at a slightly smaller
        amplitude (Loeb's rule, itself a heuristic); None where the gain does not change with the amplitude.
    """

    amplitude: float
    frequency: float
    gain: float
    stable_guess: bool | None

    def __str__(self) -> str:
        words = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
        return f"amplitude {self.amplitude:.6g} at {self.frequency:.6g} rad/s, {words[self.stable_guess]}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data."""
        names = ("amplitude", "frequency", "gain", "stable_guess")
        return {name: plain(getattr(self, name)) for name in names}


@dataclass(frozen=True, kw_only=True, slots=True)
class DescribingHint:
    r"""Where harmonic balance suggests a periodic motion: a hint, not a verdict.

    It has no verdict on purpose.  Harmonics are neglected without a bound on them: a loop may oscillate although no
    balance exists (Fitts' counterexample to the conjecture of Kalman), and a balance may belong to no oscillation.

    Attributes
    ----------
    balances : tuple of HarmonicBalance
        The balances found, by frequency, then amplitude.  None found does not mean that there is none.
    crossings : tuple of (float, float)
        Frequencies at which ``H(i omega)`` is real and not 0, with its value there; all of them.
    evidence : Evidence
        Never more than OBSERVED.
    block, law : RationalBlock, Nonlinearity or None
        What the hint is about, for its figure.
    """

    balances: tuple[HarmonicBalance, ...]
    crossings: tuple[tuple[float, float], ...]
    evidence: Evidence = Evidence.OBSERVED
    block: RationalBlock | None = field(default=None, repr=False, compare=False)
    law: Nonlinearity | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.evidence is not Evidence.OBSERVED:
            raise ValueError("a describing function is never more than observed")

    def __bool__(self) -> bool:
        raise TypeError("a describing function is a hint, not a verdict; look at hint.balances")

    def __str__(self) -> str:
        if not self.balances:
            return "hint, not a verdict: no harmonic balance was found, which does not exclude an oscillation"
        listed = "; ".join(map(str, self.balances))
        return f"hint, not a verdict: harmonic balance at {listed}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data, with the words ``hint, not a verdict`` in its sentence."""
        return {
            "kind": "hint, not a verdict",
            "evidence": str(self.evidence),
            "balances": plain(self.balances),
            "crossings": plain(self.crossings),
            "sentence": str(self),
        }

    def to_xarray(self) -> xarray.Dataset:
        """The balances, over the dimension ``balance``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        xr = xarray_or_refusal("DescribingHint.to_xarray")
        variables = {
            "amplitude": ("balance", [one.amplitude for one in self.balances]),
            "frequency": ("balance", [one.frequency for one in self.balances], {"units": "rad/s"}),
            "gain": ("balance", [one.gain for one in self.balances]),
        }
        made: xarray.Dataset = xr.Dataset(variables, attrs={"evidence": str(self.evidence), "comment": str(self)})
        return made

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The locus ``-1/N(A)`` and ``H(i omega)``, which meet at the balances; see :func:`analysis.plots.plot_hint`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from analysis.plots.balances import plot_hint

        return plot_hint(self, ax=ax)

    def _repr_html_(self) -> str:
        words = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
        rows = [
            (f"{b.amplitude:.6g}", f"{b.frequency:.6g}", f"{b.gain:.6g}", words[b.stable_guess]) for b in self.balances
        ]
        head = ("amplitude of sigma", "rad/s", "gain N(A)", "Loeb's rule") if rows else ()
        notes = ["Harmonics are neglected: a loop may oscillate without a balance, or not oscillate with one."]
        found = "harmonic balance" if rows else "no harmonic balance was found, which excludes no oscillation"
        return html_table(f"Hint, not a verdict: {found}", rows, head=head, verdict="OBSERVED", notes=notes)


def describing_hint(block: object, law: Nonlinearity) -> DescribingHint:
    r"""Harmonic balances ``1 + N(A) H(i omega) = 0`` of ``sigma = H mu``, ``mu = -phi(sigma)``: a hint, not a verdict.

    Nothing about stability may be concluded, neither from a balance nor from its absence.

    Parameters
    ----------
    block : RationalBlock, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        ``H`` in continuous time.
    law : Nonlinearity
        An odd law.

    Returns
    -------
    DescribingHint
        Balances with amplitudes between 1e-9 and 1e9 times the scale of the law (its first breakpoint, ``scale`` or
        ``step``, else 1).  The frequencies come from exact root isolation; the amplitudes from sign changes of
        ``N(A) + 1/H`` between 40 samples a decade, more where the law has breakpoints.

    Raises
    ------
    AssumptionError
        The law is not known to be odd, or ``H`` is real on the whole axis, so that no frequency is singled out.
    InputError
        The block is in discrete time.

    Examples
    --------
    >>> from lure import Saturation
    >>> print(describing_hint("1/(s*(s+1)*(s+2))", Saturation(gain=10)))
    hint, not a verdict: harmonic balance at amplitude 0.203309 at 1.41421 rad/s, perhaps attracting
    """
    exact, law = exact_block(block, "describing_hint"), as_law(law)
    if exact.dt is not None:
        raise InputError("describing_hint is stated for continuous time; give a block with dt = None")
    plant = Plant.of(exact)
    crossings = _real_crossings(plant)
    grid = amplitudes(law)
    gains = real_describing_function(law, grid)
    balances: list[HarmonicBalance] = []
    for omega, value in crossings:
        needed = -1 / float(value)
        for size in _solutions(law, grid, gains - needed, needed):
            guess = _loeb(plant, law, size, -1 / value)
            balances.append(HarmonicBalance(amplitude=size, frequency=omega, gain=needed, stable_guess=guess))
    return DescribingHint(
        balances=tuple(balances),
        crossings=tuple((omega, float(value)) for omega, value in crossings),
        block=exact,
        law=law,
    )


def _real_crossings(plant: Plant) -> list[tuple[float, Fraction]]:
    """Frequencies ``omega > 0`` at which ``H`` is real, finite and not zero, with a rational near its value."""
    response = plant.response()
    rest = response.W
    if rest.degree() < 0:
        raise AssumptionError("H is real on the whole axis, so that harmonic balance singles out no frequency")
    while (shared := rest.gcd(response.U)).degree() > 0:  # zeros and poles on the axis: d(i w) has a real factor there
        rest = rest // shared
    found: list[tuple[float, Fraction]] = []
    for root in real_roots(rest):
        if root > 0:
            x = exact_midpoint(root)
            found.append((math.sqrt(x), to_fraction(response.U(to_fmpq(x)) / response.D(to_fmpq(x)))))
    return found


def amplitudes(law: Nonlinearity) -> NDArray[np.float64]:
    """Where to look: evenly in the logarithm, and just beyond each place where ``N`` has a corner."""
    corners = [float(x) for x in getattr(law, "breakpoints", ()) if x > 0]
    if type(law) is Quantiser:
        corners = [(n + 0.5) * float(law.step) for n in range(200)]
    scale = corners[0] if corners else float(getattr(law, "scale", 1))
    decades = AMPLITUDE_DECADES[1] - AMPLITUDE_DECADES[0]
    even = scale * np.logspace(*AMPLITUDE_DECADES, decades * _PER_DECADE + 1)
    beyond = np.outer(corners, 1 + np.array([0.0, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 0.01, 0.02])).ravel()
    return np.unique(np.concatenate([even, beyond]))


def _solutions(law: Nonlinearity, grid: NDArray[np.float64], excess: NDArray[np.float64], needed: float) -> list[float]:
    """Amplitudes between grid points at which ``N(A)`` passes through the gain needed."""
    from scipy.optimize import brentq

    def difference(size: float) -> float:
        """What vanishes at a balance."""
        return float(real_describing_function(law, np.asarray(size))) - needed

    return [
        float(brentq(difference, grid[i], grid[i + 1], rtol=1e-13, xtol=1e-300))
        for i, (left, right) in enumerate(pairwise(excess))
        if left * right < 0 or (right == 0 and left != 0)
    ]


def _loeb(plant: Plant, law: Nonlinearity, size: float, gain: Fraction) -> bool | None:
    """Loeb's rule, with the poles of the linear loop counted exactly on both sides of the gain."""
    inner, outer = real_describing_function(law, size * np.array([1 - 1e-6, 1 + 1e-6]))
    if inner == outer:
        return None
    step = abs(gain) / 10**9 * (1 if outer > inner else -1)
    above, below = closed_loop_poles(plant, gain + step), closed_loop_poles(plant, gain - step)
    if above.right == below.right:
        return None
    return above.right < below.right
