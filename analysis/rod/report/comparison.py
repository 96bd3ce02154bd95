"""What a simulated motion is held against."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lure.analysis.rod.simulation import Trajectory


def compared(run: Trajectory) -> tuple[str, ...]:
    """What the simulated motion was held against; empty for a rod that stays at rest, which tests nothing.

    Without load and with ``k > 0`` the Popov-Lyapunov function and zeta have to fall and the resting place to follow;
    else only the energy identity is compared.
    """
    if not run.energy.any():
        return ()
    balance = "energy identity"
    return (balance,) if run.lyapunov is None else (balance, "Popov-Lyapunov function", "zeta", "resting place")
