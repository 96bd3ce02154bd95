"""The multiplier of a certificate from one with kernels in floating point: rational, and doubly dominant exactly."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from lure.analysis.inequality.kernels import Found
from lure.arrays import np

_DIGITS = 15
_STRICT = Fraction(1, 10**9)  # of the kernels: what M(0) has more than they take


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
