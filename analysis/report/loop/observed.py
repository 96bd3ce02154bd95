"""The given law simulated: what was observed, and the stop if it contradicts what is proved."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.answers import LoopAnalysis
from analysis.answers.subject import Subject
from analysis.evidence import Verdict
from analysis.refutation.simulated import Motion, confirm
from analysis.report.model import ContradictionError
from lure.errors import AssumptionError, InputError
from lure.rational import RationalBlock

LONGEST = 160.0
"""Oscillations a simulation follows at most, of the fastest mode at a medium gain."""
SAMPLES = 5000
TIME_CONSTANTS = 30.0
UNDIMINISHED = 0.98
"""Share of the largest ``|sigma|`` of the third quarter of a run that swings called undiminished keep in the last."""


def observed(found: LoopAnalysis) -> tuple[str, ...]:
    """One sentence on four simulated motions of the law that was given; empty without a law or with dead time.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.

    Raises
    ------
    ContradictionError
        The motions are proved to come to rest, and a simulated one swings on with a decay ten times slower than that of
        any linear gain of the class.
    """
    about = found.subject
    block, law = about.block, about.law
    if law is None or not isinstance(block, RationalBlock) or block.order == 0:
        return ()
    if block.dt is None and not getattr(law, "locally_lipschitz", True):
        return ("the law was not simulated: it is not locally Lipschitz, and its motions need not be unique",)
    slow, fast = _rates(about)
    step = None if block.dt is None else float(block.dt)
    longest = SAMPLES * step if step else LONGEST * 2 * math.pi / fast
    until = min(TIME_CONSTANTS / slow if slow > 0 else math.inf, longest)
    try:
        seen = confirm(block, law, until=until)
    except (AssumptionError, InputError) as refused:
        return (f"the law was not simulated: {refused}",)
    rates = [_decay_of_swings(motion) for motion in seen.motions]
    if found.verdict is Verdict.PROVED and until * slow >= 0.25 and min(rates) < 0.1 * slow:
        raise ContradictionError(
            f"the motions of {about.name} are proved to come to rest, and one simulated for {until:.4g} s swings on as "
            "widely as before; one of the two is wrong: please report the loop"
        )
    lasting = [rate for rate in rates if math.exp(-rate * until / 4) >= UNDIMINISHED]
    runs = f"{len(seen.motions)} simulated motions over {until:.4g} s, started at sizes 0.01 to 10000"
    lost = sum(not np.isfinite(motion.sigma).all() for motion in seen.motions)
    if lost:
        return (f"{runs}: {lost} could not be followed to the end, because they grew too large or moved too fast",)
    if seen.settled:
        return (f"{runs}: in all of them |sigma| ended below a thousandth of its largest value",)
    if lasting:
        return (f"{runs}: {_count(len(lasting))} swinging undiminished to the end",)
    if all(_rests(motion) for motion in seen.motions):
        return (f"{runs}: in all of them sigma came to rest, not always at 0",)
    return (f"{runs}: not all settled within that time, and none kept its swings undiminished",)


def _count(number: int) -> str:
    return "one went on" if number == 1 else f"{number} went on"


def _rates(about: Subject) -> tuple[float, float]:
    """Slowest decay over linear gains of the class [1/s], 0 if one does not decay; fastest mode at a medium gain."""
    block, asked = about.block, about.law_class
    assert isinstance(block, RationalBlock), "only rational blocks are simulated"
    low = 0.0 if asked is None else float(asked.sector.lower)
    high = 1.0 if asked is None else float(asked.sector.upper)
    span = high - low if math.isfinite(high) else 1e3
    gains = [low, *(low + np.geomspace(1e-3, 1.0, 25) * span)]
    n, d = (np.array([float(c) for c in side]) for side in (block.numerator, block.denominator))
    poles = [np.roots(np.polyadd(d, gain * n)).astype(complex) for gain in gains]
    if block.dt is not None:
        with np.errstate(divide="ignore"):
            poles = [np.log(np.maximum(np.abs(each), 1e-300)) / float(block.dt) + 0j for each in poles]
    resting = [_decay(each) for gain, each in zip(gains, poles, strict=True) if gain or not _at_zero(each)]
    fastest = float(np.median([np.abs(each).max() for each in poles]))
    return max(min(resting, default=0.0), 0.0), fastest or 1.0


def _decay(poles: NDArray[np.complex128]) -> float:
    return float(-poles.real.max())


def _at_zero(poles: NDArray[np.complex128]) -> bool:
    """Whether a pole lies at 0: with gain 0 such a loop rests at any of its equilibria."""
    return bool(np.abs(poles).min() < 1e-12)


def _decay_of_swings(motion: Motion) -> float:
    """Rate [1/s] at which the largest ``|sigma|`` falls from the third quarter of the run to the last.

    Infinite where ``sigma`` does not change its sign in both: what does not swing is taken to settle.
    """
    before, last = np.array_split(motion.sigma, 4)[2:]
    if not all(len(part) > 1 and float(part.min()) < 0 < float(part.max()) for part in (before, last)):  # NaN too
        return math.inf
    return 4 * math.log(float(np.abs(before).max()) / float(np.abs(last).max())) / float(motion.t[-1])


def _rests(motion: Motion) -> bool:
    """Whether ``sigma`` varies by less than a thousandth of its largest value in the last tenth of the run."""
    end = motion.sigma[-max(1, len(motion.sigma) // 10) :]
    return float(np.ptp(end)) <= 1e-3 * float(np.abs(motion.sigma).max())
