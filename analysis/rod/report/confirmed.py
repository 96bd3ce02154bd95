"""The confirmation of a report as plain data and in words."""

from __future__ import annotations

import math

from lure.analysis.numerics.doubles import json_number
from lure.analysis.report.parts import Json
from lure.analysis.rod.confirmation import Confirmation, Side
from lure.analysis.rod.confirmation.result import Quantity, Rest

_UNDER_LOAD = (
    "under load nothing is claimed of energy, Lyapunov function or zeta, since the load feeds energy in; what is "
    "checked is the balance of the energy"
)


def confirmation_data(found: Confirmation) -> Json:
    """The ``confirmation`` part of ``report.json``.

    Parameters
    ----------
    found : Confirmation
        The two motions.
    """
    return {
        "kind": found.kind,
        "sentence": confirmation_sentence(found),
        "rod": None if found.rod is None else _side(found.rod),
        "scheme": None if found.scheme is None else _side(found.scheme),
        "rod_skipped": found.rod_skipped,
        "scheme_skipped": found.scheme_skipped,
        "agrees": found.agrees,
        "compared": list(found.compared),
    }


def _side(side: Side) -> Json:
    return {
        "model": side.model,
        "until": json_number(side.until),
        "contact_count": side.contacts,
        "max_gap_coordinate": json_number(side.highest),
        "energy_residual": json_number(side.energy_residual),
        "energy": _quantity(side.energy),
        "lyapunov": _quantity(side.lyapunov),
        "lyapunov_theta": json_number(side.lyapunov_theta),
        "zeta": _quantity(side.zeta),
        "momentum_residual": json_number(side.momentum),
        "rest": _rest(side.rest),
        "open_end": side.open_end,
    }


def _quantity(quantity: Quantity | None) -> Json | None:
    if quantity is None:
        return None
    return {
        "start": json_number(quantity.start),
        "end": json_number(quantity.end),
        "residual": json_number(quantity.against),
        "rounding": json_number(quantity.allowance),
    }


def _rest(rest: Rest | None) -> Json | None:
    if rest is None:
        return None
    return {
        "predicted": json_number(rest.predicted),
        "shown": json_number(rest.shown),
        "at": json_number(rest.at),
        "way": rest.way,
        "difference": json_number(rest.difference),
        "rounding": json_number(rest.allowance),
        "agrees": rest.agrees,
    }


def confirmation_sentence(found: Confirmation) -> str:
    """What the two motions show, without a full stop.

    Parameters
    ----------
    found : Confirmation
        The two motions.
    """
    if found.rod is None:
        return f"the rod was not followed: {found.rod_skipped}"
    rod, scheme = found.rod, found.scheme
    models = "exact motions of the rod and of its scheme" if scheme is not None else "exact motion of the rod"
    if not found.compared:
        return f"{models}: at rest throughout, which tests nothing"
    followed = f"{models}, the rod up to {rod.until:.4g} s ({_contacts(rod)})"
    if found.kind == "load":
        return f"{followed}; {_UNDER_LOAD} ({_residuals(found)})"
    assert rod.energy is not None
    if found.kind == "growth":
        return (
            f"{followed}; the energy of the rod does not fall from sample to sample, and grows from "
            f"{rod.energy.start:.3g} J{_growth(rod.energy)}"
        )
    if found.kind == "undamped":
        kept = f"the energy of the rod stays {rod.energy.start:.3g} J within {_order(rod.energy.against)}"
        return f"{followed}; {kept}{_scheme_loss(scheme)}"
    return f"{followed}; energy, Lyapunov function and zeta do not rise from sample to sample; {_rests(found)}"


def _growth(energy: Quantity) -> str:
    """By how much, or to what: two numbers that look alike show no growth."""
    share = energy.end / energy.start - 1.0 if energy.start > 0.0 else 1.0
    return f" by {100.0 * share:.3g} %" if share < 1.0 else f" to {energy.end:.3g} J"


def _contacts(side: Side) -> str:
    return "no contact" if not side.contacts else f"{side.contacts} contact{'s' if side.contacts > 1 else ''}"


def _residuals(found: Confirmation) -> str:
    sides = [side for side in (found.rod, found.scheme) if side is not None]
    return ", ".join(f"{side.model.split(',')[0]} within {_order(side.energy_residual)}" for side in sides)


def _order(value: float) -> str:
    """A relative error as a power of ten that is not exceeded, no finer than rounding."""
    for exponent in range(-14, 0):
        if value <= 10.0**exponent:
            return f"1e{exponent}"
    return f"{math.ceil(10.0 * value) / 10.0:.2g}"


def _scheme_loss(scheme: Side | None) -> str:
    if scheme is None or scheme.energy is None or scheme.energy.start <= 0.0:
        return ""
    left = scheme.energy.end / scheme.energy.start
    return f", its waves persist; the scheme keeps {left:.2g} of it, since its damping is numerical"


def _rests(found: Confirmation) -> str:
    sides = [side for side in (found.rod, found.scheme) if side is not None]
    settled = [(side.model.split(",")[0], side.rest) for side in sides if side.rest is not None]
    if not settled:
        of = "neither was" if len(sides) > 1 else "it was not"
        return f"{of} followed to a resting place: contact is going on or can still come"
    places = ", ".join(f"{name} at z = {rest.predicted:.9g} m" for name, rest in settled)
    if all(rest.agrees for _, rest in settled):
        return f"the resting place predicted from momentum ({places}) is the one shown, to 1e-9 of the largest |z|"
    worst = max(rest.difference for _, rest in settled)
    return f"the resting place predicted from momentum ({places}) is shown to {worst:.1g} of the largest |z| only"
