"""What ``sigma`` does along a periodic orbit of a witness, for figures."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import cast

import numpy as np

from analysis.refutation.realisation import companion, doubles
from analysis.refutation.simulated import Block, Reals, simulate_loop
from analysis.witness import Witness
from lure.errors import InputError
from lure.laws.graph import Graph
from lure.rational import RationalBlock

SAMPLES = 1201


def orbit_of(block: Block, witness: Witness) -> tuple[Reals, Reals]:
    """One period of the orbit of a witness: times and ``sigma``, in doubles.

    Parameters
    ----------
    block : RationalBlock or (A, b, c)
        The block that the witness was found for.
    witness : Witness
        Of kind ``periodic orbit``.

    Returns
    -------
    t, sigma : ndarray
        In continuous time [s], from the first state of the record over one period; in discrete time the numbers of the
        samples, with the first sample once more at the end.

    Raises
    ------
    InputError
        The witness is no periodic orbit, or the block is not the one it was found for.
    """
    if witness.kind != "periodic orbit":
        raise InputError(f"there is no orbit to draw: the witness is a {witness.kind}; give one of a periodic orbit")
    data, discrete = witness.data, isinstance(block, RationalBlock) and block.dt is not None
    if discrete != ("sigma" in data):
        kind = "discrete" if "sigma" in data else "continuous"
        raise InputError(f"the orbit of the witness is in {kind} time; give the block that it was found for")
    if discrete:
        visited = [float(Fraction(value)) for value in cast("Sequence[str]", data["sigma"])]
        return np.arange(len(visited) + 1, dtype=float), np.array([*visited, visited[0]])
    state, period = cast("Sequence[float]", data["state"]), cast("float", data["period"])
    motion = simulate_loop(block, law_of(witness), state, period, samples=SAMPLES)
    miss = float(np.abs(motion.states[-1] - motion.states[0]).max() / np.abs(motion.states[0]).max())
    if not miss < 1e-3:  # far above what rounding does in one period, far below what another block does
        raise InputError("the motion does not close after the period of the witness; give the block it was found for")
    return motion.t, motion.sigma


def orbit_start(block: RationalBlock, witness: Witness) -> tuple[Reals, float]:
    """(n,) a state on the orbit of a witness, in the companion form of the block, and the period [s].

    Parameters
    ----------
    block : RationalBlock
        The block that the witness was found for.
    witness : Witness
        Of kind ``periodic orbit``.
    """
    data = witness.data
    if block.dt is None:
        return np.array(cast("Sequence[float]", data["state"]), dtype=float), cast("float", data["period"])
    system, law = companion(block), law_of(witness)
    A, b = doubles(system.A), np.array([float(v) for v in system.b])
    driven, period = np.zeros(block.order), np.eye(block.order)
    visited = cast("Sequence[str]", data["sigma"])
    for value in visited:
        driven, period = A @ driven - b * float(law.exact(Fraction(value))), A @ period
    state = np.asarray(np.linalg.lstsq(np.eye(block.order) - period, driven, rcond=None)[0])
    return state, len(visited) * float(block.dt)


def law_of(witness: Witness) -> Graph:
    """The piecewise-linear law of a periodic orbit.

    Parameters
    ----------
    witness : Witness
        With ``points`` in its data, and the slopes beyond them where they are not 0.
    """
    points = [(Fraction(x), Fraction(y)) for x, y in cast("Sequence[Sequence[str]]", witness.data["points"])]
    return Graph.through(points, *(Fraction(str(witness.data.get(side, 0))) for side in ("left_slope", "right_slope")))
