"""A confirmation as a Dataset, plain data and an HTML table."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from lure.record import html_table, plain
from lure.rod import datasets
from lure.rod.datasets import Column

if TYPE_CHECKING:
    import xarray

    from lure.analysis.rod.confirmation.result import Confirmation, Rest, Side

_COMMENT = (
    "One motion of the rod itself and one of its N-cell scheme, from the same data; they can contradict a verdict and "
    "prove nothing of other motions."
)
_CURVES = {
    "z": ("m", "contact coordinate u(t, L) - gap"),
    "zeta": ("m", "deflated coordinate, which must not rise"),
    "energy": ("J", "energy"),
    "lyapunov": ("Pa s", "Lyapunov function"),
}


def _sides(found: Confirmation) -> list[tuple[str, Side]]:
    return [(name, side) for name, side in (("rod", found.rod), ("scheme", found.scheme)) if side is not None]


def confirmation_dataset(found: Confirmation) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.confirmation.Confirmation.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    variables, coordinates = {}, {}
    for name, side in _sides(found):
        of = (f"t_{name}",)
        coordinates[of[0]] = Column(of, side.curves.t, "s", f"{datasets.TIME} of the {name}")
        for key, (unit, text) in _CURVES.items():
            values = getattr(side.curves, key)
            if values is not None:
                variables[f"{key}_{name}"] = Column(of, values, unit, f"{text}, {side.model}")
    attributes: dict[str, object] = {"subject": "rod and scheme", "evidence": "observed", "comment": _COMMENT}
    attributes |= {"kind": found.kind, "contradictions": "; ".join(found.contradictions)}
    return datasets.dataset(variables, coordinates, attributes)


def confirmation_dict(found: Confirmation) -> dict[str, object]:
    """What is said of the two motions, without the curves, as plain JSON data."""
    return {
        "evidence": "observed",
        "kind": found.kind,
        "rod": None if found.rod is None else _side_dict(found.rod),
        "scheme": None if found.scheme is None else _side_dict(found.scheme),
        "rod_skipped": found.rod_skipped,
        "scheme_skipped": found.scheme_skipped,
        "agrees": found.agrees,
        "compared": list(found.compared),
        "contradictions": list(found.contradictions),
        "comment": _COMMENT,
    }


def _side_dict(side: Side) -> dict[str, object]:
    names = ("model", "until", "contacts", "highest", "energy_residual", "lyapunov_theta", "momentum", "open_end")
    quantities = {name: getattr(side, name) for name in ("energy", "lyapunov", "zeta")}
    return {
        **{name: plain(getattr(side, name)) for name in names},
        **{
            name: None if value is None else {**_plain_fields(value), "holds": value.holds}
            for name, value in quantities.items()
        },
        "rest": None if side.rest is None else {**_plain_fields(side.rest), "agrees": side.rest.agrees},
    }


def _plain_fields(value: object) -> dict[str, object]:
    return {name: plain(item) for name, item in asdict(value).items()}  # type: ignore[call-overload]  # a dataclass


def confirmation_html(found: Confirmation) -> str:
    """A table for notebooks: the two motions side by side."""
    sides = _sides(found)
    rows: list[tuple[object, ...]] = [
        ("followed up to", *(f"{side.until:g} s" for _, side in sides)),
        ("contacts", *(side.contacts for _, side in sides)),
        ("largest z", *(f"{side.highest:.6g} m" for _, side in sides)),
        ("energy balance", *(f"to {side.energy_residual:.1g}" for _, side in sides)),
    ]
    names = (("energy", "energy"), ("lyapunov", "Lyapunov function"), ("zeta", "zeta"))
    for name, text in names:
        said = []
        for _, side in sides:
            quantity = getattr(side, name)
            said.append("not claimed" if quantity is None else "as claimed" if quantity.holds else "AGAINST the claim")
        rows.append((text, *said))
    rows.append(("resting place", *(_rest(side.rest, side.open_end) for _, side in sides)))
    skipped = [f"The {name} was not followed: {why}" for name, why in _skipped(found)]
    against = [f"Contradiction: {text}" for text in found.contradictions] or ["No contradiction was seen."]
    head = ("", *(side.model for _, side in sides))
    title = f"motions beside what was shown, {found.kind}"
    return html_table(title, rows, head=head, verdict="OBSERVED", notes=(*skipped, *against, _COMMENT))


def _skipped(found: Confirmation) -> list[tuple[str, str]]:
    return [(name, why) for name, why in (("rod", found.rod_skipped), ("scheme", found.scheme_skipped)) if why]


def _rest(rest: Rest | None, open_end: str | None) -> str:
    if rest is None:
        return open_end or "not claimed"
    return f"predicted {rest.predicted:.9g} m, shown {rest.shown:.9g} m" + ("" if rest.agrees else ": DIFFERENT")
