"""The describing function: a hint where a loop might oscillate, and never a verdict."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.drawing import drawn
from lure.analysis.inequality.plant import TransferPolynomials, closed_loop_poles
from lure.analysis.numerics.polynomial import exact_midpoint, real_roots, to_fmpq, to_fraction
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.nonlinearities import Cubic, ExpressionNonlinearity, GraphNonlinearity, Quantiser, ShiftedNonlinearity
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.reading import as_nonlinearity, control_saturation, is_control_nonlinearity
from lure.plants.conversion import exact_block
from lure.record import Page, Record, quantity

if TYPE_CHECKING:
    from lure.plants.rational import RationalPlant

# The gain of a nonlinearity for the first harmonic of a sinusoid.

_MAX_LEVELS = 2000
_ROUNDING = 1e-12


def describing_function(nonlinearity: object, amplitude: ArrayLike) -> NDArray[np.float64] | NDArray[np.complex128]:
    r"""Gain of a nonlinearity for the first harmonic of a sinusoid: a hint, from which nothing may be concluded.

    .. math:: N(A) = \frac{2}{\pi A} \int_0^{\pi} \phi(A \sin t)\, \sin t \, dt,

    real for an odd nonlinearity without memory, of which it lies in the sector; complex for one with memory.

    Parameters
    ----------
    nonlinearity : Nonlinearity, text, callable, or control.DescribingFunctionNonlinearity
        An odd nonlinearity, or its formula.  Closed form for piecewise linear ones, the cubic and the quantiser; for
        others, functions of arrays among them, Gauss quadrature on intervals that halve towards ``t = 0``, so that a
        steep slope at 0 is resolved, and beside jumps.  Of one that does not say whether it is odd, and of a formula, a
        sample is taken.  For the nonlinearities with memory of python-control (relay with hysteresis, backlash) what
        their own ``describing_function`` returns.
    amplitude : array_like
        ``A > 0`` [unit of sigma].

    Returns
    -------
    NDArray[np.float64], of complex numbers for a nonlinearity with memory
        ``N``, of the shape of ``amplitude`` [unit of phi / unit of sigma].

    Raises
    ------
    AssumptionError
        The nonlinearity is not odd, or not known to be: a constant term would take part in the balance.
    InputError
        An amplitude is not a positive finite number, or the nonlinearity cannot be called.

    References
    ----------
    A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
    """
    sizes = np.asarray(amplitude, dtype=float)
    if not (np.isfinite(sizes) & (sizes > 0)).all():
        raise InputError("describing_function: an amplitude is not a positive finite number")
    nonlinearity = ExpressionNonlinearity(nonlinearity) if isinstance(nonlinearity, str) else nonlinearity
    nonlinearity = control_saturation(nonlinearity) or nonlinearity
    if is_control_nonlinearity(nonlinearity):
        values = [complex(nonlinearity.describing_function(float(size))) for size in sizes.ravel()]  # type: ignore[attr-defined]  # of python-control
        return np.array(values, dtype=complex).reshape(sizes.shape)
    if not callable(nonlinearity):
        raise InputError(
            f"describing_function: the nonlinearity is {nonlinearity!r:.60}; give a nonlinearity, or a function of "
            f"sigma"
        )
    return real_describing_function(cast("Nonlinearity", nonlinearity), sizes)


def real_describing_function(nonlinearity: Nonlinearity, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The describing function of an odd nonlinearity without memory; ``sizes``: positive amplitudes.

    Raises
    ------
    AssumptionError
        As for :func:`describing_function`.
    """
    said = hasattr(nonlinearity, "odd") and not isinstance(nonlinearity, ExpressionNonlinearity)
    if not getattr(nonlinearity, "odd", False) and (said or not _seems_odd(nonlinearity, sizes)):
        raise AssumptionError(
            f"the describing function needs an odd nonlinearity, and {nonlinearity} is not known to be odd: a constant "
            f"term would take "
            "part in the balance"
        )
    if isinstance(nonlinearity, GraphNonlinearity):
        return _of_graph(nonlinearity, sizes)
    if type(nonlinearity) is ShiftedNonlinearity:
        return np.asarray(real_describing_function(nonlinearity.nonlinearity, sizes) - float(nonlinearity.gain))
    if type(nonlinearity) is Cubic:
        return np.asarray(float(nonlinearity.linear) + 0.75 * float(nonlinearity.cubic) * sizes**2)
    if type(nonlinearity) is Quantiser:
        return _of_quantiser(nonlinearity, sizes)
    return np.array([_by_quadrature(nonlinearity, float(size)) for size in sizes.ravel()], dtype=float).reshape(
        sizes.shape
    )


def _seems_odd(nonlinearity: Nonlinearity, sizes: NDArray[np.float64]) -> bool:
    """Whether a sample up to the largest amplitude shows no more than rounding between both sides."""
    x = float(sizes.max(initial=1.0)) * np.linspace(0.0, 1.0, 257)[1:]
    right, left = np.asarray(nonlinearity(x), dtype=float), np.asarray(nonlinearity(-x), dtype=float)
    return bool((np.abs(right + left) <= _ROUNDING * (np.abs(right) + np.abs(left))).all())


def _of_graph(nonlinearity: GraphNonlinearity, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """An odd polygon is a line and saturations.

    With the slopes ``s_i`` between the corners ``x_i > 0``,
    ``N = s_last + sum (s_(i-1) - s_i) f(x_i/A)``, ``f(r) = (2/pi)(asin r + r sqrt(1 - r^2))`` up to ``r = 1``, then 1.
    """
    right = nonlinearity.graph.knots.index(Fraction(0))
    corners, slopes = nonlinearity.graph.knots[right + 1 :], nonlinearity.graph.slopes[right + 1 :]
    total = np.full(sizes.shape, float(slopes[-1]))
    for corner, (before, after) in zip(corners, pairwise(slopes), strict=True):
        r = np.minimum(float(corner) / sizes, 1.0)
        total = total + float(before - after) * (2 / math.pi) * (np.arcsin(r) + r * np.sqrt((1 - r) * (1 + r)))
    return np.asarray(total)


def _of_quantiser(nonlinearity: Quantiser, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(4 step / (pi A)) sum sqrt(1 - (c/A)^2)`` over the jumps ``c < A``; 1 from so many on that it is 1 to 1e-6."""
    step = float(nonlinearity.step)
    result = np.ones(sizes.shape)
    for place in np.ndindex(sizes.shape):
        size = float(sizes[place]) / step
        if size <= _MAX_LEVELS:
            ratio = (np.arange(math.floor(size + 0.5)) + 0.5) / size
            result[place] = 4 / (math.pi * size) * np.sqrt((1 - ratio) * (1 + ratio)).sum()
    return result


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


_HALVINGS, _MOST_CELLS, _CLOSE = 50, 4000, 1e-13


def _by_quadrature(nonlinearity: Nonlinearity, size: float) -> float:
    """Gauss quadrature between 0, the dyadic fractions of a quarter period, and the corners of the nonlinearity.

    Where halves of an interval give another value, as beside a jump of a formula, they are halved again.
    """
    corners = [math.asin(float(x) / size) for x in getattr(nonlinearity, "breakpoints", ()) if 0 < x < size]
    cuts = np.unique([0.0, *(math.pi / 2 * 2.0**-j for j in range(60)), *corners])

    def over(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
        """The integrals over intervals."""
        half = (high - low)[:, None] / 2
        sine = np.sin(low[:, None] + half * (_NODES + 1))
        return np.asarray((half * _WEIGHTS * nonlinearity(size * sine) * sine).sum(axis=1))

    low, high, total = cuts[:-1], cuts[1:], 0.0
    whole = over(low, high)
    close = _CLOSE * float(np.abs(whole).sum())
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        left, right = over(low, middle), over(middle, high)
        far = np.abs(left + right - whole) > close
        total += float((left + right)[~far].sum())
        low, high = np.concatenate([low[far], middle[far]]), np.concatenate([middle[far], high[far]])
        whole = np.concatenate([left[far], right[far]])
        if not far.any() or low.size > _MOST_CELLS:
            break
    return 4 / (math.pi * size) * (total + float(whole.sum()))


AMPLITUDE_DECADES = (-9, 9)
_PER_DECADE = 40


class HarmonicBalance(Record):
    r"""A solution of ``1 + N(A) H(i omega) = 0``: a sinusoid that would sustain itself if harmonics were absent."""

    amplitude: float = quantity("``A`` of ``sigma = A sin(omega t)``", "unit of sigma", dims="")
    frequency: float = quantity("``omega``", "rad/s", dims="")
    gain: float = quantity("``N(A) = -1/H(i omega)``", "unit of phi / unit of sigma", dims="")
    stable_guess: bool | None = quantity(
        "Whether the linear loop decays for the gain at a slightly larger and grows for that at a slightly "
        "smaller amplitude (Loeb's rule, itself a heuristic); None where the gain does not change with the "
        "amplitude"
    )

    def __str__(self) -> str:
        words = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
        return f"amplitude {self.amplitude:.6g} at {self.frequency:.6g} rad/s, {words[self.stable_guess]}"


class DescribingHint(Record):
    r"""Where harmonic balance suggests a periodic solution: a hint, not a verdict.

    It has no verdict on purpose.  Harmonics are neglected without a bound on them: a loop may oscillate although no
    balance exists (Fitts' counterexample to the conjecture of Kalman), and a balance may belong to no oscillation.
    """

    balances: tuple[HarmonicBalance, ...] = quantity(
        "The balances found, by frequency, then amplitude. None found does not mean that there is none",
        dims="balance",
        each=HarmonicBalance,
    )
    crossings: tuple[tuple[float, float], ...] = quantity(
        "Frequencies at which ``H(i omega)`` is real and not 0, with its value there; all of them"
    )
    evidence: Evidence = quantity("Never more than OBSERVED", default=Evidence.OBSERVED)
    block: RationalPlant | None = quantity("The block it is about", hidden=True, default=None)
    nonlinearity: Nonlinearity | None = quantity("The nonlinearity it is about", hidden=True, default=None)
    _kind, _said = "hint, not a verdict", "sentence"
    _no_truth = "a describing function is a hint, not a verdict; look at hint.balances"

    def __post_init__(self) -> None:
        if self.evidence is not Evidence.OBSERVED:
            raise ValueError("a describing function is never more than observed")

    def __str__(self) -> str:
        if not self.balances:
            return "hint, not a verdict: no harmonic balance was found, which does not exclude an oscillation"
        listed = "; ".join(map(str, self.balances))
        return f"hint, not a verdict: harmonic balance at {listed}"

    def _attributes(self) -> dict[str, object]:
        return {"evidence": str(self.evidence), "comment": str(self)}

    plot = drawn("The locus ``-1/N(A)`` and ``H(i omega)``, which meet at the balances, by :func:`.plot_hint`.")

    def _page(self) -> Page:
        words = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
        rows = [
            (f"{b.amplitude:.6g}", f"{b.frequency:.6g}", f"{b.gain:.6g}", words[b.stable_guess]) for b in self.balances
        ]
        head = ("amplitude of sigma", "rad/s", "gain N(A)", "Loeb's rule") if rows else ()
        notes = ["Harmonics are neglected: a loop may oscillate without a balance, or not oscillate with one."]
        found = "harmonic balance" if rows else "no harmonic balance was found, which excludes no oscillation"
        return Page(f"Hint, not a verdict: {found}", rows, head, "OBSERVED", notes)


def describing_hint(block: object, nonlinearity: Nonlinearity) -> DescribingHint:
    r"""Harmonic balances ``1 + N(A) H(i omega) = 0`` of ``sigma = H mu``, ``mu = -phi(sigma)``: a hint, not a verdict.

    Nothing about stability may be concluded, neither from a balance nor from its absence.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        ``H`` in continuous time.
    nonlinearity : Nonlinearity
        An odd nonlinearity.

    Returns
    -------
    DescribingHint
        Balances with amplitudes between 1e-9 and 1e9 times the scale of the nonlinearity (its first breakpoint,
        ``scale`` or ``step``, else 1).  The frequencies come from exact root isolation; the amplitudes from sign
        changes of ``N(A) + 1/H`` between 40 samples a decade, more where the nonlinearity has breakpoints.

    Raises
    ------
    AssumptionError
        The nonlinearity is not known to be odd, or ``H`` is real on the whole axis, so that no frequency is singled
        out.
    InputError
        The block is in discrete time.

    Examples
    --------
    >>> from lure import Saturation
    >>> print(describing_hint("1/(s*(s+1)*(s+2))", Saturation(gain=10)))
    hint, not a verdict: harmonic balance at amplitude 0.203309 at 1.41421 rad/s, perhaps attracting
    """
    exact, nonlinearity = exact_block(block, "describing_hint"), as_nonlinearity(nonlinearity)
    if exact.dt is not None:
        raise InputError("describing_hint is stated for continuous time; give a block with dt = None")
    plant = TransferPolynomials.of(exact)
    crossings = _real_crossings(plant)
    grid = amplitudes(nonlinearity)
    gains = real_describing_function(nonlinearity, grid)
    balances: list[HarmonicBalance] = []
    for omega, value in crossings:
        needed = -1 / float(value)
        for size in _solutions(nonlinearity, grid, gains - needed, needed):
            guess = _loeb(plant, nonlinearity, size, -1 / value)
            balances.append(HarmonicBalance(amplitude=size, frequency=omega, gain=needed, stable_guess=guess))
    return DescribingHint(
        balances=tuple(balances),
        crossings=tuple((omega, float(value)) for omega, value in crossings),
        block=exact,
        nonlinearity=nonlinearity,
    )


def _real_crossings(plant: TransferPolynomials) -> list[tuple[float, Fraction]]:
    """Frequencies ``omega > 0`` at which ``H`` is real, finite and not zero, with a rational near its value."""
    response = plant.response
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


def amplitudes(nonlinearity: Nonlinearity) -> NDArray[np.float64]:
    """Where to look: evenly in the logarithm, and just beyond each place where ``N`` has a corner."""
    corners = [float(x) for x in getattr(nonlinearity, "breakpoints", ()) if x > 0]
    if type(nonlinearity) is Quantiser:
        corners = [(n + 0.5) * float(nonlinearity.step) for n in range(200)]
    scale = corners[0] if corners else float(getattr(nonlinearity, "scale", 1))
    decades = AMPLITUDE_DECADES[1] - AMPLITUDE_DECADES[0]
    even = scale * np.logspace(*AMPLITUDE_DECADES, decades * _PER_DECADE + 1)
    beyond = np.outer(corners, 1 + np.array([0.0, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 0.01, 0.02])).ravel()
    return np.unique(np.concatenate([even, beyond]))


def _solutions(
    nonlinearity: Nonlinearity, grid: NDArray[np.float64], excess: NDArray[np.float64], needed: float
) -> list[float]:
    """Amplitudes between grid points at which ``N(A)`` passes through the gain needed."""
    from scipy.optimize import brentq

    def difference(size: float) -> float:
        """What vanishes at a balance."""
        return float(real_describing_function(nonlinearity, np.asarray(size))) - needed

    return [
        float(brentq(difference, grid[i], grid[i + 1], rtol=1e-13, xtol=1e-300))
        for i, (left, right) in enumerate(pairwise(excess))
        if left * right < 0 or (right == 0 and left != 0)
    ]


def _loeb(plant: TransferPolynomials, nonlinearity: Nonlinearity, size: float, gain: Fraction) -> bool | None:
    """Loeb's rule, with the poles of the linear loop counted exactly on both sides of the gain."""
    inner, outer = real_describing_function(nonlinearity, size * np.array([1 - 1e-6, 1 + 1e-6]))
    if inner == outer:
        return None
    step = abs(gain) / 10**9 * (1 if outer > inner else -1)
    above, below = closed_loop_poles(plant, gain + step), closed_loop_poles(plant, gain - step)
    if above.right == below.right:
        return None
    return above.right < below.right
