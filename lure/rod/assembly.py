"""Several contacts: a rod between two obstacles, two rods across a gap, rods against one obstacle; and their scheme."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Literal

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.conversion import as_plant
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import described, quantity
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Arrangement = Literal["both-ends", "across-gap", "one-obstacle"]
ARRANGEMENTS: tuple[Arrangement, ...] = ("both-ends", "across-gap", "one-obstacle")
MOST_RODS, MOST_CELLS = 8, 20
_WORDS = {
    "both-ends": "a rod between two obstacles",
    "across-gap": "two rods that meet across a gap",
    "one-obstacle": "rods against one obstacle",
}
Matrix = list[list[Fraction]]


@described(frozen=True, kw_only=True, slots=True)
class RodAssembly:
    r"""Elastic rods with dashpots at ``x = 0`` that touch obstacles, or each other, at ``x = L``.

    Rod ``j`` obeys ``rho u_tt = E u_xx``, ``A E u_x(t,0) = k u_t(t,0) - F_0`` and ``A E u_x(t,L) = F_L``, as
    :class:`lure.rod.Rod` does with ``F_L = -A p``; ``sigma_i`` is how far a contact has closed and ``p_i(sigma_i -
    gap_i)`` its pressure, ``mu_i = -p_i``.

    - ``both-ends``: one rod, ``sigma = (-u(t,0), u(t,L))``, ``F_0 = A p_1``, ``F_L = -A p_2``.
    - ``across-gap``: two rods whose coordinates both point to the gap, ``sigma = u_1(t,L_1) + u_2(t,L_2)``, the same
      force ``min(A_1, A_2) p`` on both.
    - ``one-obstacle``: rods side by side, ``sigma_j = u_j(t,L_j) - w``, where the obstacle ``w`` is a plate without
      mass, ``k_o w' = sum_j A_j p_j``; without ``obstacle_damping`` it does not move.

    Raises
    ------
    InputError
        There are not as many rods or contacts as the arrangement has, a compliance is not positive, a gap is negative,
        an obstacle that moves has no ``k_o > 0`` or no rods of its own, or there is not one scenario a rod.
    """

    arrangement: Arrangement = quantity("Which of them")
    rods: tuple[Rod, ...] = quantity(
        "The rods; what they say of their own contact (``compliance``, ``gap``) does not count"
    )
    compliances: tuple[Fraction, ...] = quantity("For each contact ``eps > 0`` [m/Pa] of ``p(r) = max(r, 0)/eps``")
    gaps: tuple[Fraction, ...] = quantity("For each contact its gap ``>= 0``", "m")
    obstacle_damping: Fraction | None = quantity(
        "``k_o > 0`` [N s/m]; None for an obstacle that does not move", default=None
    )
    scenarios: tuple[Scenario, ...] = quantity(
        "For each rod the force at ``x = 0`` and the initial data of a motion to follow; empty for none.  No part of "
        "what is proved",
        default=(),
    )
    until: float | None = quantity(
        "End of that motion [s]; None for 20 passages of a wave through the slowest rod", default=None
    )

    def __post_init__(self) -> None:
        if self.arrangement not in ARRANGEMENTS:
            raise InputError(f"contact.arrangement is {self.arrangement!r:.40}; give one of {', '.join(ARRANGEMENTS)}")
        least, most = {"both-ends": (1, 1), "across-gap": (2, 2), "one-obstacle": (1, MOST_RODS)}[self.arrangement]
        if not least <= len(self.rods) <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}"
            raise InputError(
                f"rod: there are {len(self.rods)} rods, and {self.arrangement} has {wanted}; give so many [[rod]]"
            )
        for name, values in (("compliance", self.compliances), ("gap", self.gaps)):
            if len(values) != self.contacts:
                raise InputError(
                    f"contact.{name} has {len(values)} values; give one, or one for each of {self.contacts} contacts"
                )
        if min(self.compliances) <= 0:
            raise InputError(f"contact.compliance is {float(min(self.compliances)):g}; give a positive number")
        if min(self.gaps) < 0:
            raise InputError(
                f"contact.gap is {float(min(self.gaps)):g}; give 0 or more: rods that are not stressed at rest"
            )
        if self.obstacle_damping is not None and (self.arrangement != "one-obstacle" or self.obstacle_damping <= 0):
            raise InputError(
                f"contact.obstacle_damping is {float(self.obstacle_damping):g}; give a positive number for "
                "one-obstacle, or leave it out for an obstacle that does not move"
            )

        if len(self.scenarios) not in (0, len(self.rods)):
            raise InputError(f"there are {len(self.scenarios)} scenarios for {len(self.rods)} rods; give one for each")

    @property
    def contacts(self) -> int:
        """How many nonlinearities there are."""
        return {"both-ends": 2, "across-gap": 1}.get(self.arrangement, len(self.rods))

    @property
    def words(self) -> str:
        """The arrangement in words."""
        return _WORDS[self.arrangement]

    @property
    def rounded(self) -> tuple[int, ...]:
        """The rods whose wave speed ``sqrt(E/rho)`` is irrational, counted from 1: their scheme has the next double."""
        return tuple(number for number, rod in enumerate(self.rods, 1) if not _wave_speed(rod)[1])

    def nonlinearity_tables(self) -> list[dict[str, object]]:
        """The pressures ``p_i(sigma_i - gap_i)`` as tables ``[[nonlinearity]]``, in the order of the contacts."""
        return [
            {
                "kind": "piecewise linear",
                "points": [[gap, Fraction(0)]],
                "left_slope": Fraction(0),
                "right_slope": 1 / eps,
            }
            for eps, gap in zip(self.compliances, self.gaps, strict=True)
        ]

    def scheme(self, cells: int) -> MultivariablePlant | RationalPlant:
        r"""The upwind scheme with ``N`` cells a rod, as a plant from ``mu`` [Pa] to ``sigma`` [m], exactly.

        With ``s_j = N/T_j`` the waves ``y`` of each rod obey ``y_i' = s (y_{i-1} - y_i)``, entering as ``-a y_2N + 2 b
        F_0`` and ``y_N + 2 F_L/Z``, as in :class:`lure.rod.UpwindScheme`.  Beside the waves there is one state for each
        contact, ``sigma_i``; for ``both-ends`` only ``sigma_2``, as ``sigma_1 + sigma_2 = sum_{i > N} y_i/(2 s) -
        sum_{i <= N} y_i/(2 s)`` is the shortening of the rod.  Everything that is shown of it is about the scheme.

        Parameters
        ----------
        cells : int
            ``N``, 1 to 20.

        Returns
        -------
        MultivariablePlant or RationalPlant
            The latter for one contact.

        Raises
        ------
        InputError
            ``cells`` is out of range.
        """
        if not 1 <= cells <= MOST_CELLS:
            raise InputError(f"discretisation.cells is {cells}; give 1 to {MOST_CELLS} for several contacts")
        parts, m = [_Bar(rod, cells) for rod in self.rods], self.contacts
        both = self.arrangement == "both-ends"
        waves, states = 2 * cells * len(parts), 2 * cells * len(parts) + (1 if both else m)
        A, B, C = (_zeros(rows, columns) for rows, columns in ((states, states), (states, m), (m, states)))
        for j, part in enumerate(parts):
            at, load = 2 * cells * j, self.loads(j)
            for i in range(2 * cells):
                A[at + i][at + i] -= part.rate
                before = i - 1 if i else 2 * cells - 1
                A[at + i][at + before] += part.rate * (1 if i else -part.reflection)
            for i in range(m):
                B[at][i] += 2 * part.rate * part.gain * load[0][i]
                B[at + cells][i] += 2 * part.rate / part.impedance * load[1][i]
            for i, share in enumerate(self.closing(j)):  # sigma_i' = share v(t, L) + ..
                row = states - 1 if both else waves + i
                if share:
                    A[row][at + cells - 1] += share
                    B[row] = [v + share * w / part.impedance for v, w in zip(B[row], load[1], strict=True)]
        for row in range(waves, states) if self.obstacle_damping is not None else ():
            B[row] = [v + w for v, w in zip(B[row], self._plate(), strict=True)]
        for i in range(m):
            C[i][waves + (0 if both else i)] = Fraction(-1 if both and not i else 1)
        for i in range(2 * cells) if both else ():
            C[0][i] = (1 if i >= cells else -1) / (2 * parts[0].rate)
        found = as_plant((A, B, C, _zeros(m, m)))
        assert isinstance(found, MultivariablePlant | RationalPlant), "exact entries"
        return found

    def transfer(self, s: ArrayLike, cells: int | None = None) -> NDArray[np.complex128]:
        r"""``H(s)`` in closed form, of the scheme or, for None, of the rods themselves.

        With ``Q`` the passage of a wave through a rod, ``(1 + s/s_j)^{-N}`` or ``e^{-s T}``, and no dashpot at ``x =
        L``, forces at the ends move them by ``v(0) = [b (1 + Q^2) F_0 + 2 b Q F_L]/(1 + a Q^2)`` and ``v(L) = [2 b Q
        F_0 + (1 - a Q^2) F_L/Z]/(1 + a Q^2)``.

        Parameters
        ----------
        s : array_like
            (..) complex frequencies [1/s], not 0.
        cells : int, optional
            ``N``.

        Returns
        -------
        ndarray
            (.., m, m) [m/Pa].
        """
        points, m = np.asarray(s, dtype=complex), self.contacts
        H = np.zeros((*points.shape, m, m), dtype=complex)
        for j, rod in enumerate(self.rods):
            a, b, Z, T = rod.reflection, rod.input_gain, rod.impedance, rod.travel_time
            Q = np.exp(-points * T) if cells is None else (1 + points * T / cells) ** -float(cells)
            below = 1 + a * Q**2
            near, across, far = b * (1 + Q**2) / below, 2 * b * Q / below, (1 - a * Q**2) / Z / below
            load = [np.array([float(v) for v in row]) for row in self.loads(j)]
            ends = (
                near[..., None] * load[0] + across[..., None] * load[1],
                across[..., None] * load[0] + far[..., None] * load[1],
            )
            if self.arrangement == "both-ends":
                H[..., 0, :] -= ends[0]
            for i, share in enumerate(self.closing(j)):
                H[..., i, :] += float(share) * ends[1]
        if self.obstacle_damping is not None:
            H += np.array([*map(float, self._plate())])
        return np.asarray(H / points[..., None, None])

    def _plate(self) -> list[Fraction]:
        """``-w'`` of the obstacle from ``mu``."""
        return [rod.exact["area"] / (self.obstacle_damping or Fraction(1)) for rod in self.rods]

    def loads(self, j: int) -> tuple[list[Fraction], list[Fraction]]:
        """``F_0`` and ``F_L`` of a rod from ``mu``: of each contact."""
        m, areas = self.contacts, [rod.exact["area"] for rod in self.rods]
        none = [Fraction(0)] * m
        if self.arrangement == "both-ends":
            return [-areas[0], Fraction(0)], [Fraction(0), areas[0]]
        if self.arrangement == "across-gap":
            return none, [min(areas)]
        return none, [areas[j] if i == j else Fraction(0) for i in range(m)]

    def closing(self, j: int) -> list[int]:
        """How far each contact closes when the end ``x = L`` of a rod moves by 1."""
        if self.arrangement == "both-ends":
            return [0, 1]
        return [int(self.arrangement == "across-gap" or i == j) for i in range(self.contacts)]


class _Bar:
    """What the scheme needs of one rod, exactly."""

    def __init__(self, rod: Rod, cells: int) -> None:
        rho, L, area, k = (rod.exact[name] for name in ("density", "length", "area", "damping"))
        speed, _ = _wave_speed(rod)
        self.rate, self.impedance = cells * speed / L, area * rho * speed
        self.reflection, self.gain = (k - self.impedance) / (k + self.impedance), 1 / (k + self.impedance)


def _wave_speed(rod: Rod) -> tuple[Fraction, bool]:
    """``sqrt(E/rho)``, and whether it is that; else the double next to it."""
    square = rod.exact["youngs_modulus"] / rod.exact["density"]
    root = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    return (root, True) if root * root == square else (Fraction(rod.wave_speed), False)


def _zeros(rows: int, columns: int) -> Matrix:
    return [[Fraction(0)] * columns for _ in range(rows)]
