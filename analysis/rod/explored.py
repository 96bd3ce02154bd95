"""The rod on the page in the browser: what the page asks about it, and the part of the page that asks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any, cast

from lure.analysis.certificates.second import recheck
from lure.analysis.questions.answers import max_sector
from lure.analysis.questions.certify import certify, text_of
from lure.classes import Sector
from lure.errors import InputError
from lure.plants.text import exact_coefficient
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant

MOST = 2000  # cells on the page
_FIELDS = ("youngs_modulus", "density", "length", "area", "damping")
_NAMED = re.compile(r"rod\.(\w+)|(cells)")


def rod_answer(given: Mapping[str, str]) -> dict[str, Any]:
    """What is shown of the rod and of its scheme, for every nonlinearity in the sector ``[0, inf]``.

    The verdicts are those of :func:`lure.analysis.certify`, the largest sectors of the circle criterion and of Popov's
    those of :func:`lure.analysis.max_sector`.

    ``given``: the five parameters that the loop depends on, by their names in files, and ``cells``.

    Returns
    -------
    dict
        For ``rod`` and ``scheme`` the verdict with its certificate; or ``error``, one sentence, with its ``field``.
    """
    try:
        rod, cells = _given(given)
        return {"impedance": rod.impedance, "rod": _model(RodPlant(rod)), "scheme": _model(upwind(rod, cells))}
    except InputError as refusal:
        named = _NAMED.search(str(refusal))
        return {"error": str(refusal), "field": "damping" if named is None else named[1] or named[2]}


def _given(given: Mapping[str, str]) -> tuple[Rod, int]:
    values = {name: given.get(name, "").strip() for name in _FIELDS}
    rod = Rod(**cast("dict[str, float]", values | {"compliance": 1}))
    cells = exact_coefficient(given.get("cells", "").strip(), "cells")
    if cells.denominator != 1 or not 1 <= cells <= MOST:
        raise InputError(f"cells is {given['cells']}; give a whole number from 1 to {MOST}")
    return rod, int(cells)


def _model(plant: RodPlant | UpwindScheme) -> dict[str, Any]:
    shown = certify(plant, Sector(0, math.inf))
    popov, circle = (max_sector(plant, criterion=name) for name in ("popov", "circle"))
    theta = popov.theta
    return {
        "name": plant.name,
        "verdict": str(shown.verdict),
        "sentence": str(shown.conclusion),
        "second": None if shown.certificate is None else recheck(shown.certificate).accepted,
        "certificate": "" if shown.certificate is None else text_of(shown.certificate),
        "theta": theta if theta is not None and math.isfinite(theta) else None,
        "popov": str(popov),
        "circle": str(circle),
        "report": {"class": shown.to_dict(), "popov": popov.to_dict(), "circle": circle.to_dict()},
    }


ANSWERS: Mapping[str, Callable[[Mapping[str, str]], dict[str, Any]]] = {"rod": rod_answer}


def panel() -> dict[str, str]:
    """The part of the page about the rod: its HTML, and its module, whose ``open`` is given what asks."""
    here = files("lure.analysis.rod") / "page"
    texts = {kind: (here / f"rod.{kind}").read_text("utf-8") for kind in ("html", "js")}
    return {"name": "rod.js", "module": texts["js"], "html": texts["html"], "style": ""}
