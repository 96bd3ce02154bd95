"""A multiplier ``M = Gamma - sum c_k h_k`` with kernels, and Popov's terms, in floating point.

That of a certificate is made from one in floating point: rational, and doubly dominant exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from lure.arrays import NDArray, np

_DIGITS = 15
_STRICT = Fraction(1, 10**9)  # of the kernels: what M(0) has more than they take


class Kernel(NamedTuple):
    """``sign (rate/(rate + side s))^order`` in a row and a column; rate 0: ``sign`` alone, beside the diagonal.

    Side 0: the mean of both sides, on the diagonal of ``row`` and of the other channels of an operator, ``also``.
    ``mirrored``: its conjugate stands in the row ``column`` and the column ``row``.
    """

    row: int
    column: int
    sign: int
    rate: Fraction
    order: int
    side: int
    also: tuple[int, ...] = ()
    mirrored: bool = False

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The value at ``i omega`` without the sign, 0 at infinity; in floating point.

        ``omega``: (k,) frequencies [rad/s].
        """
        if not self.rate:
            return np.ones(len(omega), dtype=complex)
        finite = np.isfinite(omega)
        lag = (self.side or 1) * np.where(finite, omega, 0.0) / float(self.rate)
        found = np.where(finite, (1 + 1j * lag) ** -float(self.order), 0)
        return np.asarray(found if self.side else found.real + 0j)

    def masses(self, rate: float) -> tuple[float, float]:
        """What it takes in its row and in its column at a rate: ``h(rate)`` and ``h(-rate)``.

        ``rate``: the rate [1/s], less than that of the kernel.
        """
        lag = self.side * rate / float(self.rate) if self.rate else 0.0
        return (1 + lag) ** -self.order, (1 - lag) ** -self.order

    def integrated(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """``(h - 1)/(i omega)``, likewise: ``h`` of a kernel with a side, less its value at 0, after an integrator."""
        rate = self.side * float(self.rate) if self.rate else np.inf
        lag = 1 / (1 + 1j * np.where(np.isfinite(omega), omega, 0.0) / rate)
        return np.asarray(np.where(np.isfinite(omega), -sum(lag**k for k in range(1, self.order + 1)) / rate, 0) + 0j)


class Found(NamedTuple):
    """A multiplier, and the factor up to which it serves."""

    factor: float
    gamma: NDArray[np.float64]
    theta: NDArray[np.float64]
    kernels: list[Kernel]
    masses: NDArray[np.float64]

    @classmethod
    def none(cls, m: int) -> Found:
        """The multiplier 1, which serves for nothing; ``m``: channels."""
        return cls(0.0, np.ones(m), np.zeros(m), [], np.zeros(0))

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """``M`` at ``i omega``: (k, m, m).

        ``omega``: (k,) frequencies [rad/s].
        """
        m = len(self.gamma)
        M = np.zeros((len(omega), m, m), dtype=complex)
        M[:, range(m), range(m)] = self.gamma
        for mass, kernel in zip(self.masses, self.kernels, strict=True):
            value = mass * kernel.sign * kernel.at(omega)
            for i in (kernel.row, *kernel.also):
                M[:, i, kernel.column if i == kernel.row else i] -= value
            if kernel.mirrored:
                M[:, kernel.column, kernel.row] -= value.conj()
        return M

    def integrated(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The diagonal of ``(M(i omega) - M(0))/(i omega)``: (k, m)."""
        N = np.zeros((len(omega), len(self.gamma)), dtype=complex)
        for mass, kernel in zip(self.masses, self.kernels, strict=True):
            N[:, kernel.row] -= mass * kernel.sign * kernel.integrated(omega)
        return N

    def without(self, share: float) -> Found:
        """The multiplier without its small kernels; those without rate stay.

        ``share``: of the greatest ``gamma``: the least mass that is kept.
        """
        least = share * float(self.gamma.max())
        kept = [
            k
            for k, (one, mass) in enumerate(zip(self.kernels, self.masses, strict=True))
            if mass > least or not one.rate
        ]
        return self._replace(kernels=[self.kernels[k] for k in kept], masses=np.maximum(self.masses[kept], 0.0))


def multiplier(  # noqa: PLR0913  (a multiplier, and what is known of its channels)
    found: Found,
    widths: Sequence[Fraction],
    gains: Sequence[int] = (),
    ratios: Sequence[tuple[int, Fraction]] = (),
    wide: Sequence[Sequence[int]] = (),
    rate: Fraction = Fraction(0),
) -> dict[str, Any]:
    """The multiplier of a certificate: rational, and doubly dominant exactly.

    Parameters
    ----------
    found : Found
        A multiplier for ``(w_i sigma_i - psi_i)/w_i``.
    widths : sequence of Fraction
        ``w_i``, equal ones where kernels stand between two channels.
    gains : sequence of int
        The channels with a constant gain each, whose ``gamma`` makes ``Re M_ii > 0``.
    ratios : sequence of (int, Fraction)
        For each channel: ``M(0)`` is exactly the ratio times that of the channel, counted from 0; none: any.
    wide : sequence of sequence of int
        Blocks of channels on which ``gamma`` makes ``He M > 0``.
    rate : Fraction
        The rate by which rows and columns are weighed.
    """
    m = len(widths)

    def near(value: float, j: int) -> Fraction:
        """A mass in units of a width, of few decimal digits."""
        return Fraction(f"{value / float(widths[j]):.{_DIGITS}g}")

    gamma, rows, columns = [[Fraction(0)] * m for _ in range(m)], [Fraction(0)] * m, [Fraction(0)] * m
    kernels, where = list[dict[str, Any]](), dict[str, Any]()
    theta = [Fraction(f"{value:.{_DIGITS}g}") for value in found.theta]
    for mass, (i, j, sign, decay, order, side, also, mirrored) in zip(found.masses, found.kernels, strict=True):
        c = near(float(mass), j)
        if decay and not side:  # of an operator: the mean of both sides
            for k in (i, *also):
                where = {"channels": [k + 1, k + 1], "coefficient": str(sign * c / 2), "rate": str(decay)}
                kernels += [{**where, "order": order, "side": word} for word in ("causal", "anticausal")]
                rows[k] += c if sign > 0 else 0
            continue
        lag = side * rate / decay if decay else Fraction(0)
        rows[i], columns[j] = rows[i] + c / (1 + lag) ** order, columns[j] + c / (1 - lag) ** order
        for a, b, turn in [(i, j, side), *[(j, i, -side)] * mirrored]:
            if decay:
                where = {"channels": [a + 1, b + 1], "coefficient": str(sign * c), "rate": str(decay)}
                kernels.append({**where, "order": order, "side": "causal" if turn > 0 else "anticausal"})
            else:
                gamma[a][b] -= sign * c
    rates = [float(one.rate) for one in found.kernels if one.rate]
    points = np.geomspace(min(rates, default=1.0) / 1e2, max(rates, default=1.0) * 1e2, 2000)
    blocks = [*([i] for i in gains), *map(list, wide)]
    M = found.at(np.array([0.0, *points, np.inf])) if blocks else np.zeros((1, m, m))
    for block in blocks:
        own = M[:, block][:, :, block]
        least = np.linalg.eigvalsh(own + own.conj().swapaxes(1, 2))[:, 0].min() / 2
        lacking = max(0.0, 1e-9 * float(found.gamma[block].max()) - float(least))
        for i in block:
            gamma[i][i] = near(float(found.gamma[i]) + 2 * lacking, i)
    own_way = {i for block in blocks for i in block}
    for i in (i for i in range(m) if i not in own_way):
        paid = theta[i] * rate / widths[i]
        gamma[i][i] = max(near(float(found.gamma[i]), i), rows[i] - paid, columns[i] + paid)
    still = [Fraction(0)] * m  # what the kernels take from gamma at 0
    for one in kernels if ratios else ():
        still[one["channels"][0] - 1] += Fraction(one["coefficient"])
    for i, (first, ratio) in enumerate(ratios):
        if i == first:
            gamma[i][i] = max(gamma[i][i], rows[i] * (1 + _STRICT))
        else:
            gamma[i][i] = ratio * widths[first] * (gamma[first][first] - still[first]) / widths[i] + still[i]
    return {"gamma": [[*map(str, row)] for row in gamma], "theta": [*map(str, theta)], "kernels": kernels}
