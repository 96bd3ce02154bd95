"""Loops from the literature, by name: plants on which criteria differ, and loops that no criterion may certify."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from lure.classes import Diagonal, NonlinearityClass, Sector
from lure.errors import InputError, did_you_mean
from lure.files.system import LoopSystem, channel_system, loop_system
from lure.plants import as_plant, parse_transfer
from lure.plants.multivariable import MultivariablePlant

_ZAMES_FALB = (
    "J. Carrasco, W. P. Heath, J. Zhang, N. S. Ahmad, S. Wang, Convex searches for discrete-time Zames-Falb "
    "multipliers, 2019"
)
_SLOPES = "the test set of Chen and Wen, Park, Turner, Chang and Carrasco for slope-restricted nonlinearities"
_LURE = "A. I. Lur'e, indirect control: x' = -x + xi, xi' = mu, sigma = r xi - c x"
_FITTS = "R. E. Fitts, Two counterexamples to Aizerman's conjecture, IEEE Trans. Automatic Control 11 (1966) 553-556"
_HIDDEN = "G. A. Leonov, V. O. Bragin, N. V. Kuznetsov, Dokl. Math. 82 (2010) 540-542"
_CLOSED = "a plant whose limits have a closed form"
_IQC = "an example shipped with the toolbox IQCbeta"
_EVERY = NonlinearityClass(sector=Sector(0, math.inf))

Entry = tuple[str, str, str]  # title, formula, source
_PLANTS: dict[str, Entry] = {
    "dt-1": ("discrete example 1: a double pole at 0.9", "0.1*z/(z^2 - 1.8*z + 0.81)", _ZAMES_FALB),
    "dt-2": (
        "discrete example 2: two lightly damped modes",
        "(z^3 - 1.95*z^2 + 0.9*z + 0.05)/(z^4 - 2.8*z^3 + 3.5*z^2 - 2.412*z + 0.7209)",
        _ZAMES_FALB,
    ),
    "dt-3": (
        "discrete example 3: example 2 with its sign reversed",
        "-(z^3 - 1.95*z^2 + 0.9*z + 0.05)/(z^4 - 2.8*z^3 + 3.5*z^2 - 2.412*z + 0.7209)",
        _ZAMES_FALB,
    ),
    "dt-5": ("discrete example 5", "(-0.5*z + 0.1)/(z^3 - 0.9*z^2 + 0.79*z + 0.089)", _ZAMES_FALB),
    "dt-6": (
        "discrete example 6: more is proved of odd nonlinearities than of monotone ones",
        "(2*z + 0.92)/(z^2 - 0.5*z)",
        _ZAMES_FALB,
    ),
    "ct-1": ("continuous example 1: a zero to the right", "(s^2 - 0.2*s - 0.1)/(s^3 + 2*s^2 + s + 1)", _SLOPES),
    "ct-3": ("continuous example 3: two modes", "s^2/(s^4 + 0.2*s^3 + 6*s^2 + 0.1*s + 1)", _SLOPES),
    "ct-4": ("continuous example 4: example 3, sign reversed", "-s^2/(s^4 + 0.2*s^3 + 6*s^2 + 0.1*s + 1)", _SLOPES),
    "ct-5": ("continuous example 5: two sharp modes", "s^2/(s^4 + 0.0003*s^3 + 10*s^2 + 0.0021*s + 9)", _SLOPES),
    "ct-6": (
        "continuous example 6: example 5, sign reversed",
        "-s^2/(s^4 + 0.0003*s^3 + 10*s^2 + 0.0021*s + 9)",
        _SLOPES,
    ),
    "ct-7": ("continuous example 7: stable for every linear gain", "s^2/(s^3 + 2*s^2 + 2*s + 1)", _SLOPES),
    "third-order": ("an integrator and two lags: Popov reaches 6, the circle 4/3", "1/(s*(s+1)*(s+2))", _CLOSED),
    "integrator-oscillator": ("an integrator and a damped mode", "1/(s*(s^2 + s + 1))", _CLOSED),
    "integrator-resonance": ("an integrator and a lightly damped mode", "1/(s*(s^2 + 0.1*s + 1))", _CLOSED),
    "triple-lag": ("three equal lags: Popov reaches the Hurwitz limit 8", "1/(s+1)^3", _CLOSED),
    "three-lags": ("three lags: Popov reaches the Hurwitz limit 5/2", "4/((s+1)*(s/2+1)*(s/3+1))", _CLOSED),
    "biproper": ("a feedthrough, and a multiplier of negative sign", "(s^2 - s + 10)/(s^2 + s + 25)", _CLOSED),
    "unstable-lag": ("an unstable pole: stable for gains above 1/4 only", "4/((s-1)*(s/3+1))", _CLOSED),
    "lurie-negative-residue": (
        "indirect control with r = 1, c = 2: the residue at zero is negative",
        "1/s - 2/(s*(s+1))",
        _LURE,
    ),
    "lurie-hidden-zero": ("indirect control with r = c = 1: the zero eigenvalue is hidden", "s/(s*(s+1))", _LURE),
}
_VEENMAN = (
    "J. Veenman, C. W. Scherer, H. Koroglu, Robust stability and performance analysis based on integral quadratic "
)
_VEENMAN += "constraints, European J. Control 31 (2016) 1-32; IQClab, Demo_006, there with positive feedback"
_SECANT = "M. Arcak, E. D. Sontag, Diagonal stability of a class of cyclic systems and its connection with the secant "
_SECANT += "criterion, Automatica 42 (2006) 1531-1537"
_FETZER = (
    "M. Fetzer, C. W. Scherer, Full-block multipliers for repeated, slope-restricted scalar nonlinearities, Int. J. "
)
_FETZER += "Robust Nonlinear Control 27 (2017) 3376-3411, example 4.9"
_CLASSES: dict[str, tuple[Entry, NonlinearityClass]] = {
    "lurie-indirect-control": (
        ("indirect control with r = 2, c = 1: a simple zero eigenvalue", "2/s - 1/(s*(s+1))", _LURE),
        _EVERY,
    ),
    "second-order": (("an integrator and a lag", "1/(s*(s+1))", _CLOSED), _EVERY),
    "integrator-lead": (("an integrator, a lag and a zero beyond it", "(s+2)/(s*(s+1))", _CLOSED), _EVERY),
    "positive-real": (("an integrator, a lag and a zero before it", "(s+1)/(s*(s+2))", _CLOSED), _EVERY),
    "iqc-resonance": (
        ("a resonance under a nonlinearity in the sector [0, 1]", "(s+1)/(s^2 + 0.2*s + 1)", _IQC),
        NonlinearityClass(sector=Sector(0, 1)),
    ),
    "iqc-odd-slope": (
        (
            "three lags and two zeros to the right under an odd nonlinearity of slope at most 1",
            "400*(s^2 - 0.5*s + 1)/((s+10)*(s+20)*(s+30))",
            _IQC,
        ),
        NonlinearityClass.slope_restricted(0, 1, odd=True),
    ),
}
_NONLINEARITIES: dict[str, tuple[Entry, dict[str, object]]] = {
    "kalman-fitts": (
        (
            "a limit cycle, although every linear gain is stable",
            "s^2/(((s+0.03)^2 + 0.81)*((s+0.03)^2 + 1.21))",
            _FITTS,
        ),
        {"kind": "tanh", "scale": Fraction(1, 100), "gain": Fraction(1)},
    ),
    "leonov-bragin-kuznetsov": (
        (
            "a hidden oscillation under saturation, although every linear gain up to 1000/101 is stable",
            "s^2*(10.1*s + 10)/((s^2+1)*(s^2+s+1))",
            _HIDDEN,
        ),
        {"kind": "saturation", "gain": Fraction(1), "limit": Fraction(1)},
    ),
    "double-zero": (
        ("a double zero eigenvalue: every linear gain is stable, this nonlinearity escapes", "(s+1)/s^2", _CLOSED),
        {
            "kind": "expression",
            "text": "sigma*exp(-abs(sigma))",
            "sector": (Fraction(0), Fraction(1)),
            "odd": True,
            "locally_lipschitz": True,
        },
    ),
    "contact": (
        ("an integrator before an obstacle: every sigma below the gap is an equilibrium", "1/s", _CLOSED),
        {
            "kind": "piecewise linear",
            "points": ((Fraction(0), Fraction(0)), (Fraction(1, 50), Fraction(0))),
            "left_slope": Fraction(0),
            "right_slope": Fraction(1),
        },
    ),
    "dead-zone": (
        ("an integrator under a dead zone: a segment of equilibria", "1/s", _CLOSED),
        {"kind": "dead zone", "width": Fraction(1), "gain": Fraction(1)},
    ),
}
_SLOPE = NonlinearityClass.slope_restricted(0, 1)
_DIRECT = [[0, 0, 0], [0, 0, 0], [0, -1, 0]]
_FETZER_IN = [[0, -4, -1, -3], [-2, 0, -3, -1], [-1, 0, -3, -1]]
_FETZER_OUT = [["-0.1", "-0.2", 1], [-1, "-0.3", "0.1"], ["-0.2", "0.1", 1], ["0.1", "-0.2", "0.2"]]
_CHANNELS: dict[str, tuple[tuple[str, object, str], Diagonal]] = {
    "secant-ring": (
        (
            "three lags in a ring with two nonlinearities: stable for bounds of a product below 8",
            [["0", "1/(s+1)"], ["-1/(s+1)^2", "0"]],
            _SECANT,
        ),
        Diagonal((NonlinearityClass(sector=Sector(0, 2)),) * 2),
    ),
    "veenman-scherer-koroglu": (
        (
            "three odd nonlinearities of slope at most 1 on two states",
            ([["-0.4", -1], [1, 0]], [["0.2", 1, "0.25"], [0, 0, 0]], [[1, 0], [0, 1], [0, 0]], _DIRECT),
            _VEENMAN,
        ),
        Diagonal((replace(_SLOPE, odd=True),) * 3),
    ),
    "fetzer-scherer": (
        (
            "one nonlinearity of slope at most 1/2 in four channels",
            ([[-4, -3, 0], [2, 0, 0], [-1, -1, -2]], _FETZER_IN, _FETZER_OUT),
            _FETZER,
        ),
        Diagonal((NonlinearityClass.slope_restricted(0, Fraction(1, 2)),) * 4, repeated=True),
    ),
}


def builtin_loops() -> Mapping[str, LoopSystem]:
    """The named loops: plants alone, with a class of nonlinearities, with a nonlinearity, with several channels."""
    return MappingProxyType({name: builtin_loop(name) for name in loop_names()})


def loop_names() -> tuple[str, ...]:
    """Names of the built-in loops."""
    return (*_PLANTS, *_CLASSES, *_NONLINEARITIES, *_CHANNELS)


def builtin_loop(name: str) -> LoopSystem:
    """The named loop.

    Parameters
    ----------
    name : str
        One of :func:`loop_names`.

    Raises
    ------
    InputError
        There is no such name; the message offers the nearest.

    Examples
    --------
    >>> print(builtin_loop("third-order").block)
    1 / (s^3 + 3 s^2 + 2 s)
    """
    if name not in loop_names():
        hint = did_you_mean(name, loop_names())
        raise InputError(f"there is no built-in loop {name!r}; {hint}choose from {', '.join(loop_names())}")
    if name in _CHANNELS:
        (title, plant, source), classes = _CHANNELS[name]
        found = as_plant(plant)
        assert isinstance(found, MultivariablePlant), "these have several channels"
        return channel_system((name, title, source), found, classes=classes)
    table = asked = None
    if name in _PLANTS:
        title, formula, source = _PLANTS[name]
    elif name in _CLASSES:
        (title, formula, source), asked = _CLASSES[name]
    else:
        (title, formula, source), table = _NONLINEARITIES[name]
    return loop_system(
        (name, title, source), parse_transfer(formula), nonlinearity_table=table, nonlinearity_class=asked
    )
