"""The closed loop as a nonlinear system of python-control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lure.block import LinearBlock
from lure.delay import DelayBlock
from lure.errors import InputError
from lure.inputs import as_block
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme

if TYPE_CHECKING:
    from collections.abc import Callable

    import control

    from lure.loop import Loop

Floats = NDArray[np.float64]


def closed_loop(loop: Loop, *, pade: int | None = None) -> control.NonlinearIOSystem:
    """The loop with a load ``r``: ``mu = r - phi(sigma)``; see :meth:`lure.Loop.to_control`.

    Parameters
    ----------
    loop : Loop
        The loop.
    pade : int, optional
        Order of the approximation of a dead time.

    Raises
    ------
    InputError
        The block has a direct term, or no states.
    """
    import control

    A, B, C, dt = _realised(loop.block, pade)
    law = loop.nonlinearity

    def rate(_t: float, x: Floats, r: Floats, _params: dict[str, Any]) -> Floats:
        """``A x + B (r - phi(C x))``: the derivative, or the next state."""
        return np.asarray(A @ x + B * (r[0] - float(law(C @ x))))

    def output(_t: float, x: Floats, _r: Floats, _params: dict[str, Any]) -> Floats:
        """``sigma = C x``."""
        return np.atleast_1d(C @ x)

    make: Callable[..., control.NonlinearIOSystem] = control.nlsys
    return make(rate, output, inputs=["r"], outputs=["sigma"], states=len(B), dt=dt, name="lure")


def _realised(block: object, pade: int | None) -> tuple[Floats, Floats, Floats, float]:
    """``A, B, C`` and the sampling time (0 for continuous time)."""
    if isinstance(block, UpwindScheme):
        block = block.block
    if isinstance(block, LinearBlock):
        return block.dense(), block.b1, block.c, 0.0
    if isinstance(block, DelayBlock):
        block = as_block(block.to_control(pade=pade))
    if isinstance(block, StateSpaceBlock):
        if block.D:
            raise _algebraic(block.D)
        return block.A, block.B, block.C, float(block.dt or 0)
    if not isinstance(block, RationalBlock):
        raise InputError(
            f"a {type(block).__name__} has no states to simulate; give coefficients, matrices or a formula in s or z"
        )
    if block.feedthrough:
        raise _algebraic(float(block.feedthrough))
    n = block.order
    if n == 0:
        raise InputError("the block is 0: there is no loop to simulate")
    A = np.eye(n, k=1)
    A[-1] = [-float(c) for c in reversed(block.denominator[1:])]
    C = np.zeros(n)
    top = [float(c) for c in reversed(block.numerator)]
    C[: len(top)] = top
    return A, np.eye(n)[-1], C, float(block.dt or 0)


def _algebraic(direct: float) -> InputError:
    return InputError(
        f"the block has the direct term D = {direct:g}: sigma + D phi(sigma) = C x is an algebraic loop, which "
        "python-control does not solve; put a fast lag in series with the block"
    )
