"""Two anti-windup plants of the literature: gains from the reference to the error from both sides, and regions.

A controller with integrators, ``x_c' = A_c x_c + B_c (r - y) + L (sat(u) - u)``, ``u = C_c x_c + D_c (r - y)``, drives
a plant ``x' = A x + B sat(u)``, ``y = C x``.  With ``sigma = u`` and ``phi(sigma) = sigma - sat(sigma)``, a dead zone
in the slopes [0, 1], ``mu = -phi(sigma)`` moves the plant by ``B`` and the controller by ``L``: the static compensator.
Plants: J. Veenman, IQClab, ``Demo_010``, a column with PI controllers; M. C. Turner, I. Postlethwaite, Int. J. Control
77 (2004) 27-44, the roll and yaw of a missile, limits 8.  Their compensators are synthesised, and no number is printed
there.  Those here: of Hanus, ``L = D_c^-1``, and of a Kalman filter, to two decimals.  Each gain is about any two
nonlinearities in the slopes [0, 1], and then about one odd one in both channels, as where both limits are the same.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

from lure import DeadZone, NonlinearityClass, as_plant
from lure.analysis import l2_gain, region
from lure.classes import Diagonal

SLOPE = NonlinearityClass.slope_restricted(0, 1, odd=True)
COLUMN = {
    "plant": (-0.01 * np.eye(2), np.array([[0.4, -0.5], [-0.3, 0.4]]), np.eye(2)),
    "controller": (
        np.zeros((2, 2)),
        np.eye(2),
        np.array([[2, 2.5], [1.5, 2]]) / 100,
        np.array([[2, 2.5], [1.5, 2]]),
    ),
}
INNER = np.array(
    [
        [-0.29, -107.8, 6.67, -2.58, -0.4],
        [107.68, -97.81, 63.95, -4.52, -5.35],
        [-6.72, 64.82, -54.19, -40.79, 5.11],
        [3.21, 2.1, 29.56, -631.15, 429.89],
        [0.36, -3.39, 3.09, -460.03, -0.74],
    ]
)
INWARD = np.array([[2.28, 0.48], [-40.75, 2.13], [18.47, -0.22], [-2.07, -44.68], [-0.98, -1.18]])
OUTWARD = np.array([[0.86, 8.54, -1.71, 43.91, 1.12], [2.17, 39.91, -18.39, -8.51, 1.03]])
MISSILE = {
    "plant": (
        np.array([[-0.818, -0.999, 0.349], [80.29, -0.579, 0.009], [-2734, 0.05621, -2.1]]),
        np.array([[0.147, 0.012], [-194.4, 37.61], [-2716, -1093]]),
        np.eye(2, 3),
    ),
    "controller": (
        np.block([[INNER, INWARD], [np.zeros((2, 7))]]),
        np.vstack([np.zeros((5, 2)), np.eye(2)]),
        np.hstack([OUTWARD, np.zeros((2, 2))]),
        np.zeros((2, 2)),
    ),
}
FILTER = np.array([[0.09, 0.16], [0.1, 0.35], [0.01, -0.43], [0.07, -0.01], [-0.05, 0.01], [0, -1], [-1, 0]])


def loop(given: dict[str, Any], L: np.ndarray) -> tuple[object, dict[str, object]]:
    """The plant in ``sigma = H mu``, decimals exact, and the performance from ``r`` to ``r - y``."""
    (A, B, C), (Ac, Bc, Cc, Dc) = given["plant"], given["controller"]
    whole = np.block([[A - B @ Dc @ C, B @ Cc], [-Bc @ C, Ac]])
    sides = [whole, np.vstack([B, L]), np.hstack([-Dc @ C, Cc]), np.zeros((2, 2))]
    performance = {
        "Bw": np.vstack([B @ Dc, Bc]),
        "Cz": np.hstack([-C, np.zeros((2, len(Ac)))]),
        "Dzw": np.eye(2),
        "Dsigmaw": Dc,
    }

    def said(M: np.ndarray) -> list[list[str]]:
        """Entries as the decimals that they are."""
        return [[f"{v:.10g}" for v in row] for row in np.asarray(M)]

    return as_plant(tuple(map(said, sides))), {key: said(M) for key, M in performance.items()}


def main() -> int:
    """Print the gains and the regions; 1 where one is not what was found before."""
    cases = (
        ("column, no compensator", COLUMN, np.zeros((2, 2)), 1, (27.5, np.inf), None),
        ("column, Hanus", COLUMN, np.array([[8, -10], [-6, 8]]), 1, (32.0, 50.7), 13.5),
        ("missile, no compensator", MISSILE, np.zeros((7, 2)), 8, (13.6, np.inf), None),
        ("missile, Kalman filter", MISSILE, FILTER, 8, (18.6, 19.3), 13.2),
    )
    fine = True
    for name, given, L, limit, (least, most), same in cases:
        plant, performance = loop(given, L)
        start = time.process_time()
        two = l2_gain(plant, [SLOPE, SLOPE], performance).gain
        one = None if same is None else l2_gain(plant, Diagonal((SLOPE, SLOPE), repeated=(2,)), performance).gain
        found = region(plant, [DeadZone(width=limit, gain=1)] * 2)
        seconds = time.process_time() - start
        both = "" if one is None else f"; the same in both {one}"
        print(f"{name}: gain {two}{both}; {found.sets[0].kind} attracted; {seconds:.0f} s")
        fine = fine and two.low >= least and two.high <= most and (one is None or same is None or one.high <= same)
        fine = fine and (found.sets[0].kind == "everything") == (same is not None)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
