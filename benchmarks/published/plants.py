"""Published plants and numbers: what others reached, and how ours is asked for.

Discrete time: J. Carrasco, W. P. Heath, J. Zhang, N. S. Ahmad, S. Wang, "Convex searches for discrete-time Zames-Falb
multipliers", 2019, examples 1, 2, 3, 5, 6; 4 and 7 as https://github.com/sahelvn/ReLURNN_StaticQCs cites its table
(Nyquist's number of 4 as printed there; it is 7.907).  Continuous time: the set of Chen and Wen, Park, Turner, Chang,
Carrasco; its numbers were recomputed in floating point.  Critical case: closed forms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

INF = math.inf


@dataclass(frozen=True, kw_only=True)
class Row:
    """One published number and the question that answers it."""

    plant: str
    num: str
    den: str
    dt: int | None = None
    criterion: str
    odd: bool = False
    nonnegative: bool = False
    theirs: float
    note: str = ""
    lower: Fraction = Fraction(0)


DISCRETE = {
    "DT 1": ("0.1 0", "1 -1.8 0.81"),
    "DT 2": ("1 -1.95 0.9 0.05", "1 -2.8 3.5 -2.412 0.7209"),
    "DT 3": ("-1 1.95 -0.9 -0.05", "1 -2.8 3.5 -2.412 0.7209"),
    "DT 4": ("1 -1.5 0.5 -0.5 0.5", "4.4 -8.957 9.893 -5.671 2.207 -0.5"),
    "DT 5": ("-0.5 0.1", "1 -0.9 0.79 0.089"),
    "DT 6": ("2 0.92", "1 -0.5 0"),
    "DT 7": ("1.341 -1.221 0.6285 -0.5618 0.1993", "1 -0.935 0.7697 -1.118 0.6917 -0.1352"),
}
# circle, Tsypkin, Zames-Falb odd, Zames-Falb any, refuted odd, refuted any, Nyquist
_DISCRETE_NUMBERS = {
    "DT 1": (0.7934, 3.8000, 13.5115, 13.0283, 13.5754, 13.5754, 36.1),
    "DT 2": (0.1984, 0.2427, 1.1056, 0.80274, 1.10565, 0.80275, 2.7455),
    "DT 3": (0.1379, 0.1379, 0.3121, 0.3121, None, None, 0.312370),
    "DT 4": (1.5312, 1.6911, 3.8240, None, None, None, 7.7907),
    "DT 5": (1.0273, 1.0273, 2.4475, 2.4475, None, None, 2.4475),
    "DT 6": (0.6510, 0.6510, 1.0870, 0.91146, None, 175 / 192, 25 / 23),
    "DT 7": (0.1069, 0.1069, 0.5280, None, None, None, 1.1766),
}
CONTINUOUS = {
    "CT 1": ("1 -0.2 -0.1", "1 2 1 1"),
    "CT 3": ("1 0 0", "1 0.2 6 0.1 1"),
    "CT 4": ("-1 0 0", "1 0.2 6 0.1 1"),
    "CT 5": ("1 0 0", "1 0.0003 10 0.0021 9"),
    "CT 6": ("-1 0 0", "1 0.0003 10 0.0021 9"),
    "CT 7": ("1 0 0", "1 2 2 1"),
}
# circle, Popov theta >= 0, Popov, Park, Zames-Falb + Popov at least, the same for odd phi, Nyquist
_CONTINUOUS_NUMBERS = {
    "CT 1": (1.24307, 1.24307, 1.763614, 3.772, 4.5894, None, 4.5894542),
    "CT 3": (0.326273, 0.326273, 0.384185, 0.788, 2.08, None, INF),
    "CT 4": (0.308094, 0.364103, 0.364166, 0.708, 1.32, None, 3.5),
    "CT 5": (4.00040e-4, 0.00183159, 0.001833696, 0.0018333, 0.0056, 0.0058, INF),
    "CT 6": (3.99960e-4, 3.99960e-4, 0.001832717, 0.0018325, 0.0056, 0.0058, 1.7142857),
    "CT 7": (8.12086, 8.12086, 8.89898, 28.90, 1e4, None, INF),
}
# circle, Popov, Hurwitz
_CRITICAL = {
    "1/(s(s+1))": ("1", "1 1 0", 1.0, INF, INF),
    "1/(s(s+1)(s+2))": ("1", "1 3 2 0", 4 / 3, 6.0, 6.0),
    "1/(s(s^2+s+1))": ("1", "1 1 1 0", 0.75, 1.0, 1.0),
    "1/(s(s^2+.1s+1))": ("1", "1 0.1 1 0", 0.09975, 0.1, 0.1),
    "(s+2)/(s(s+1))": ("1 2", "1 1 0", 1.0, INF, INF),
    "(s+1)/(s(s+2))": ("1 1", "1 2 0", INF, INF, INF),
    "1/(s+1)^3": ("1", "1 3 3 1", 4.0, 8.0, 8.0),
    "4/((s+1)(s/2+1)(s/3+1))": ("4", "1/6 1 11/6 1", 1.164456, 2.5, 2.5),
    "(s^2-s+10)/(s^2+s+25)": ("1 -1 10", "1 1 25", 0.532958, 1.0, 1.0),
}


def rows() -> list[Row]:
    """Every published number, in the order of the tables."""
    found: list[Row] = []
    for plant, (num, den) in DISCRETE.items():
        circle, tsypkin, odd, monotone, odd_at, any_at, nyquist = _DISCRETE_NUMBERS[plant]

        def row(
            criterion: str, theirs: float | None, plant: str = plant, num: str = num, den: str = den, **more: bool
        ) -> None:
            """Add a number where there is one."""
            if theirs is not None:
                found.append(Row(plant=plant, num=num, den=den, dt=1, criterion=criterion, theirs=theirs, **more))

        row("circle", circle)
        row("tsypkin", tsypkin)
        row("zames-falb", odd, odd=True)
        row("zames-falb", monotone)
        row("refuted", odd_at, odd=True)
        row("refuted", any_at)
        row("hurwitz", nyquist)
    for plant, (num, den) in CONTINUOUS.items():
        circle, positive, popov, park, falb, odd_falb, nyquist = _CONTINUOUS_NUMBERS[plant]
        found += [
            Row(plant=plant, num=num, den=den, criterion="circle", theirs=circle),
            Row(plant=plant, num=num, den=den, criterion="popov", theirs=positive, nonnegative=True),
            Row(plant=plant, num=num, den=den, criterion="popov", theirs=popov),
            Row(plant=plant, num=num, den=den, criterion="park", theirs=park),
            Row(plant=plant, num=num, den=den, criterion="zames-falb", theirs=falb),
        ]
        if odd_falb is not None:
            found.append(Row(plant=plant, num=num, den=den, criterion="zames-falb", theirs=odd_falb, odd=True))
        found.append(Row(plant=plant, num=num, den=den, criterion="hurwitz", theirs=nyquist))
    for plant, (num, den, *numbers) in _CRITICAL.items():
        for criterion, theirs in zip(("circle", "popov", "hurwitz"), numbers, strict=True):
            found.append(Row(plant=plant, num=num, den=den, criterion=criterion, theirs=theirs))
    return found
