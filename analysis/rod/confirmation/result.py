"""What two motions, that of the rod and that of its scheme, say of what was shown."""

from __future__ import annotations

from typing import Literal

from lure.analysis.drawing import drawn
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.record import Column, Page, Record, derived, quantity

Kind = Literal["decay", "undamped", "growth", "load"]

AGREEMENT = 1e-9


class Quantity(Record):
    """Something that must not rise (or, for the energy of a rod with ``k < 0``, not fall) along a motion."""

    start: float = quantity("Its first value")
    end: float = quantity("Its last value")
    against: float = quantity(
        "Largest step between two samples in the direction in which it must not go, zero if there is none, "
        "relative to ``scale``"
    )
    allowance: float = quantity("What the arithmetic may be expected to add to that, relative to ``scale``")
    scale: float = quantity("Its largest size")

    @classmethod
    def of(cls, values: Array, rise: float, allowance: float, scale: float) -> Quantity:
        """From its values, the largest step and the allowance in their unit, and their largest size."""
        unit, (start, end) = scale if scale > 0.0 else 1.0, (float(values[0]), float(values[-1]))
        return cls(start=start, end=end, against=rise / unit, allowance=allowance / unit, scale=scale)

    @property
    @derived()
    def holds(self) -> bool:
        """Whether it goes nowhere it must not, up to rounding."""
        return self.against <= self.allowance


class Rest(Record):
    """A resting place that was predicted, and what the motion shows."""

    predicted: float = quantity(
        "From the initial data and the impulses of the contacts alone, ``zeta(0) - (1/k) sum of impulses`` [m]"
    )
    shown: float = quantity("``z`` of the motion when its ringing has decayed", "m")
    at: float = quantity("When", "s")
    way: str = quantity("How the motion was continued to then")
    difference: float = quantity("``|predicted - shown|``, relative to the scale")
    allowance: float = quantity("What the arithmetic may be expected to add to that, relative to the scale")
    scale: float = quantity("Largest ``|z|`` along the motion or at rest", "m")

    @classmethod
    def of(cls, places: tuple[float, float], at: float, way: str, allowance: float, largest: float) -> Rest:
        """From the places predicted and shown, what the arithmetic may add and the largest ``|z|`` met [m]."""
        predicted, shown = places
        scale = max(largest, abs(predicted), abs(shown))
        difference, rounding = (size / scale if scale > 0.0 else 0.0 for size in (abs(predicted - shown), allowance))
        return cls(
            predicted=predicted,
            shown=shown,
            at=at,
            way=way,
            difference=difference,
            allowance=rounding,
            scale=scale,
        )

    @property
    @derived()
    def agrees(self) -> bool:
        """Whether the two agree to 1e-9."""
        return self.difference <= AGREEMENT


class Curves(Record):
    """One motion, sampled, for figures: instants [s] and values; None for what is not defined."""

    t: Array = quantity("time since the start of the motion", "s", dims="t")
    z: Array = quantity("contact coordinate ``u(t, L) - gap``", "m", dims="t")
    zeta: Array | None = quantity("deflated coordinate, which must not rise", "m", dims="t")
    energy: Array | None = quantity("energy", "J", dims="t")
    lyapunov: Array | None = quantity("Lyapunov function", "Pa s", dims="t")


class Side(Record):
    """One of the two motions."""

    model: str = quantity('``"rod"`` or ``"scheme, N = .."``')
    until: float = quantity("How far it was followed", "s")
    contacts: int = quantity("Number of contacts until then")
    highest: float = quantity("Largest ``z`` over all instants until then", "m")
    energy_residual: float = quantity("Largest error of the energy balance, relative to the largest energy that passed")
    energy: Quantity | None = quantity("Energy, which must not rise; None where nothing is claimed")
    lyapunov: Quantity | None = quantity("Lyapunov function, which must not rise; None where nothing is claimed")
    lyapunov_theta: float | None = quantity("Multiplier of the Lyapunov function", "s")
    zeta: Quantity | None = quantity("``zeta``, which must not rise; None where nothing is claimed")
    momentum: float | None = quantity(
        "Largest ``|zeta(t) - zeta(0) + (1/k) int A p|``, relative to the largest ``|z|`` or ``|zeta|``: whether "
        "``zeta`` is constant in free flight and falls by the impulse over ``k`` in a contact"
    )
    rest: Rest | None = quantity("The resting place; None if none is claimed or none was reached")
    open_end: str | None = quantity("Why there is no resting place, or why the motion was not followed to the end")
    curves: Curves = quantity("The motion, for figures", key="")

    @property
    def shown(self) -> str:
        """What is said of the resting place."""
        rest = self.rest
        if rest is None:
            return self.open_end or "not claimed"
        return f"predicted {rest.predicted:.9g} m, shown {rest.shown:.9g} m" + ("" if rest.agrees else ": DIFFERENT")


class Confirmation(Record):
    """Two motions from the same data side by side; OBSERVED, it can contradict a verdict and never proves one."""

    kind: Kind = quantity("What is confirmed: ``k > 0``, ``k = 0`` or ``k < 0`` without loads; or a motion under load")
    rod: Side | None = quantity("The motion of the rod; None if there is none")
    scheme: Side | None = quantity("The motion of the scheme; None if there is none")
    rod_skipped: str | None = quantity("Why there is none of the rod")
    scheme_skipped: str | None = quantity("Why there is none of the scheme")
    contradictions: tuple[str, ...] = quantity(
        "Ways in which the motion of the rod, or a resting place, contradicts what was shown, beyond rounding"
    )

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: two motions."""
        return Evidence.OBSERVED

    @property
    @derived()
    def comment(self) -> str:
        """What they do not show."""
        return (
            "One motion of the rod itself and one of its N-cell scheme, from the same data; they can contradict a "
            "verdict and prove nothing of other motions."
        )

    @property
    @derived()
    def compared(self) -> tuple[str, ...]:
        """What the motion of the rod was held against, and passed; empty for a rod that stays at rest."""
        if self.rod is None or not self.rod.curves.z.size or self._still:
            return ()
        found = ["energy balance"]
        watched = {"energy": self.rod.energy, "Lyapunov functional": self.rod.lyapunov, "zeta": self.rod.zeta}
        found += [name for name, claimed in watched.items() if claimed is not None]
        return (*found, "resting place") if self.rod.rest is not None else tuple(found)

    @property
    @derived()
    def agrees(self) -> bool | None:
        """Whether the motion of the rod bears out all that it was held against; None where that is nothing."""
        if self.contradictions:
            return False
        return True if self.compared else None

    @property
    def _still(self) -> bool:
        return self.rod is not None and self.rod.energy is not None and self.rod.energy.scale == 0.0

    @property
    def _sides(self) -> dict[str, Side]:
        return {name: side for name, side in (("rod", self.rod), ("scheme", self.scheme)) if side is not None}

    def _columns(self) -> dict[str, Column]:
        """The curves of both motions, each along a time of its own."""
        return {
            f"{key}_{name}": column._replace(dims=(f"t_{name}",), meaning=f"{column.meaning}, {side.model}")
            for name, side in self._sides.items()
            for key, column in side.curves._columns().items()
        }

    def _attributes(self) -> dict[str, object]:
        more = {"kind": self.kind, "contradictions": "; ".join(self.contradictions)}
        return {"subject": "rod and scheme", **super()._attributes(), **more}

    def _page(self) -> Page:
        sides = self._sides.values()
        rows: list[tuple[object, ...]] = [
            ("followed up to", *(f"{side.until:g} s" for side in sides)),
            ("contacts", *(side.contacts for side in sides)),
            ("largest z", *(f"{side.highest:.6g} m" for side in sides)),
            ("energy balance", *(f"to {side.energy_residual:.1g}" for side in sides)),
        ]
        for name, text in (("energy", "energy"), ("lyapunov", "Lyapunov function"), ("zeta", "zeta")):
            claims = [getattr(side, name) for side in sides]
            said = ("not claimed" if it is None else "as claimed" if it.holds else "AGAINST the claim" for it in claims)
            rows.append((text, *said))
        rows.append(("resting place", *(side.shown for side in sides)))
        reasons = (("rod", self.rod_skipped), ("scheme", self.scheme_skipped))
        skipped = [f"The {name} was not followed: {why}" for name, why in reasons if why]
        against = [f"Contradiction: {text}" for text in self.contradictions] or ["No contradiction was seen."]
        head, notes = ("", *(side.model for side in sides)), (*skipped, *against, self.comment)
        return Page(f"motions beside what was shown, {self.kind}", rows, head, "OBSERVED", notes)

    plot = drawn("The contact coordinate of both; see :func:`lure.analysis.rod.plots.plot_both_ends`.")
