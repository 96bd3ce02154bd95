"""What a comparison returns: the exact motion, a row for each other one, and the tables within 80 columns."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.rod.comparison.modes import ModeDecay, SettlingRow
from lure.analysis.rod.comparison.reference import Reference
from lure.arrays import Reals as Array
from lure.record import Column, Page, Record, derived, quantity
from lure.rod import datasets
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    from lure.analysis.plots.style import Axes

ENERGIES = (
    "Energies as each model has them: rod and Galerkin A int (rho v^2 + E w^2)/2 dx + A P(z), P' = p; scheme the sum "
    "A rho h/4 sum y_i^2 + A P(z), which without loads never rises for k >= 0, whatever p >= 0 is."
)
EVIDENCE = (
    "The exact row is about the rod (COMPUTED); every other row is one motion of a discrete model (OBSERVED). Errors "
    "are those of this motion and are proved for no other."
)
WIDTH = 80
_APART = 0.125


class Order(Record):
    """Observed order of the L2 error of ``u(t, L)`` against the next coarser model of the family."""

    coarser: int = quantity("Its size")
    before: float | None = quantity(
        "Up to the first kink or contact; None without samples there, or if an error is down to that of the integrator"
    )
    whole: float | None = quantity("Over the whole run")


class Row(Record):
    """One approximation of the motion."""

    family: str = quantity('``"scheme"`` or ``"Galerkin P1"``, ``"Galerkin P2"``, ``"Galerkin cosine"``')
    size: int = quantity("N cells of a scheme, or dimension of a Galerkin space", "1", dims="", name="cells")
    width: float = quantity("cell or element length", "m", dims="")
    integrator: str = quantity("What took the steps")
    u: Array | None = quantity(
        "(samples,) ``u(t, L)`` [m]; None for a model that could not be run", key="", default=None
    )
    largest_error: float = quantity(
        "largest ``|u(t, L) - exact|`` at the samples; nan if not run", "m", dims="", default=math.nan
    )
    l2_error: float = quantity(
        "root mean square of ``u(t, L) - exact`` over the time; nan if not run", "m", dims="", default=math.nan
    )
    before_error: float | None = quantity(
        "the same up to the first kink or contact", "m", dims="", key="l2_error_before_event", default=None
    )
    energy_error: float | None = quantity(
        "largest difference of the energies over the rod's largest", "1", dims="", default=None
    )
    energy_end: float | None = quantity("energy at the end", "J", dims="", default=None)
    decay: ModeDecay = quantity("Decay rates of the elastic modes 1, 2, 3 in flight", "s-1", default=())
    contacts: tuple[tuple[float, float], ...] = quantity("Contacts of this motion", "s", default=())
    cpu_seconds: float = quantity(
        "CPU time of the process, with the assembly of the model", "s", dims="", name="cpu", default=0.0
    )
    steps: int | None = quantity("time steps; None (nan) where there are none", "1", dims="", default=None)
    evaluations: int | None = quantity("Evaluations of the right-hand side; None if not counted", default=None)
    order: Order | None = quantity("Against the next coarser row; None for the coarsest", default=None)
    refused: str = quantity("Why it was not run, or nothing", plainly=lambda why: why or None, default="")

    @property
    @derived()
    def evidence(self) -> str:
        """OBSERVED: one motion of a discrete model."""
        return "OBSERVED"

    @property
    def label(self) -> str:
        """The family with the size."""
        return f"scheme, N = {self.size}" if self.family == "scheme" else f"{self.family}, m = {self.size}"


class Comparison(Record):
    """The exact motion of a rod and what approximations make of it; made by :func:`.compare`."""

    rod: Rod = quantity("The rod", plainly=datasets.rod_dict)
    scenario: Scenario = quantity("Loads and initial data", plainly=datasets.scenario_dict)
    until: float = quantity("End of the run", "s")
    exact: Reference = quantity("The motion of the rod, with its samples", key="")
    decay: ModeDecay = quantity("Decay rates of the rod's modes 1, 2, 3 in flight", "s-1", key="")
    rows: tuple[Row, ...] = quantity("Schemes by size, then Galerkin models", dims="model", each=Row)
    settling: tuple[SettlingRow, ...] = quantity(
        "How each lets the released end settle; empty unless this is the release of the paper, in free flight",
        default=(),
    )
    settling_statement: str = quantity("What this shows of the paper's settling time, or nothing", default="")

    @property
    def t(self) -> Array:
        """(samples,) instants [s]."""
        return self.exact.t

    @property
    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Contacts of the rod itself [s]."""
        return tuple((impact.start, impact.end) for impact in self.exact.motion.impacts)

    def relative(self, error: float) -> float | None:
        """An error as a share of the amplitude; None for a rod that stays at rest."""
        return error / self.exact.amplitude if self.exact.amplitude else None

    def __str__(self) -> str:
        """The tables and what may be read from them."""
        return text(self)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the curves, in types that JSON has."""
        exact, motion, found = self.exact, self.exact.motion, super().to_dict()
        for row, said in zip(self.rows, found["rows"], strict=True):
            for name in ("largest_error", "l2_error"):
                said[f"{name}_relative"] = None if row.refused else self.relative(getattr(row, name))
        return found | {
            "samples": int(exact.t.size),
            "amplitude": exact.amplitude,
            "first_event": None if exact.event is None else {"t": exact.event.t, "kind": exact.event.kind},
            "exact": {
                "evidence": "COMPUTED",
                "energy_start": float(exact.energy[0]),
                "energy_end": float(exact.energy[-1]),
                "energy_residual": motion.energy_residual,
                "error": motion.error,
                "decay": list(self.decay),
                "contacts": [list(contact) for contact in self.contacts],
                "cpu_seconds": exact.cpu_seconds,
            },
            "energies": ENERGIES,
            "evidence": EVIDENCE,
        }

    def _columns(self) -> dict[str, Column]:
        """All curves ``u(t, L)`` and numbers, along ``t`` and ``model``."""
        rows, of, t = self.rows, ("model",), self.t
        curves = np.array([np.full(t.size, np.nan) if row.u is None else row.u for row in rows]).reshape(-1, t.size)
        orders = [math.nan if row.order is None or row.order.whole is None else row.order.whole for row in rows]
        exact = "exact displacement u(t, L) of the rod itself, positive along x"
        return super()._columns() | {
            "u_exact": Column(("t",), self.exact.u, "m", exact),
            "u_end": Column(("model", "t"), curves, "m", "displacement u(t, L) of the model; nan if it was not run"),
            "contacts": Column(of, [len(row.contacts) for row in rows], "1", "number of contacts of this motion"),
            "order": Column(of, orders, "1", "observed order of l2_error against the coarser row"),
            "t": Column(("t",), t, "s", datasets.TIME),
            "model": Column(of, np.array([row.label for row in rows], dtype=object), "1", "approximation"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "title": "The exact motion of a rod and its approximations",
            "subject": "rod; every row of model is a discrete model of it",
            "evidence": "observed; u_exact computed",
            "comment": f"{EVIDENCE} {ENERGIES}",
            "amplitude": self.exact.amplitude,
            "amplitude_units": "m",
            "exact_error": self.exact.motion.error,
            "exact_error_units": "m",
            **datasets.rod_attributes(self.rod),
            **datasets.scenario_attributes(self.scenario),
        }

    def _page(self) -> Page:
        first = self.exact.energy[0]
        kept = f"{self.exact.energy[-1] / first:.4g}" if first else "-"
        rows: list[tuple[object, ...]] = [("the rod itself, exact", "-", "-", "-", kept, len(self.contacts))]
        for row in self.rows:
            order = "-" if row.order is None or row.order.whole is None else f"{row.order.whole:.2f}"
            kept = "-" if row.energy_end is None or not first else f"{row.energy_end / first:.4g}"
            cells = (f"{row.largest_error:.3g}", f"{row.l2_error:.3g}", order, kept, len(row.contacts))
            rows.append((row.label, *((row.refused, "-", "-", "-", "-") if row.refused else cells)))
        head = ("motion of", "largest error of u(t, L) [m]", "L2 error [m]", "order", "energy kept", "contacts")
        notes = [text for text in (self.settling_statement, EVIDENCE, ENERGIES) if text]
        title = f"the end of the rod up to {self.until:g} s, amplitude {self.exact.amplitude:.4g} m"
        return Page(title, rows, head, "OBSERVED", notes)

    def plot(self, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
        """The end of the rod by every method, the errors below; see :func:`lure.analysis.rod.plots.plot_comparison`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.rod.plots.comparison import plot_comparison

        return plot_comparison(self, ax=ax)


def text(found: Comparison) -> str:
    """The tables of a comparison and what may be read from them."""
    parts = [_head(found), _errors(found), *_orders(found), _modes(found), _cost(found)]
    if found.settling:
        parts.append(_settling(found))
    sentences = [
        _sparse(found),
        _remark(found),
        found.settling_statement,
        *(f"{row.label} was not run: {row.refused}." for row in _refused(found)),
    ]
    parts += [_filled(sentence) for sentence in (*sentences, ENERGIES, EVIDENCE) if sentence]
    return "\n\n".join(parts)


def _head(found: Comparison) -> str:
    exact, count = found.exact, len(found.contacts)
    contact = "no contact" if not count else "1 contact" if count == 1 else f"{count} contacts"
    event = "no kink and no contact" if exact.event is None else str(exact.event)
    return _filled(
        f"The end of the rod up to {found.until:g} s: amplitude {exact.amplitude:.4g} m, {contact}; {event}. Errors of "
        f"u(t, L) at {exact.t.size} samples against the exact motion (its own local errors about "
        f"{exact.motion.error:.1g} m), as shares of the amplitude; energies as shares of the "
        "rod's largest and of its first."
    )


def _errors(found: Comparison) -> str:
    head = ("error of u(t, L)", "largest [m]", "of ampl.", "L2", "energy error", "E at end")
    start = float(found.exact.energy[0])
    body: list[tuple[str, ...]] = [("exact", "-", "-", "-", "-", _share(float(found.exact.energy[-1]), start))]
    for row in _run(found):
        end = "-" if row.energy_end is None else _share(row.energy_end, start)
        shares = (_percent(found.relative(error)) for error in (row.largest_error, row.l2_error))
        errors = (f"{row.largest_error:.3g}", *shares)
        body.append((row.label, *errors, _percent(row.energy_error), end))
    return _table(head, body)


def _orders(found: Comparison) -> list[str]:
    rows = [row for row in _run(found) if row.order is not None]
    if not rows:
        return []
    event = found.exact.event
    head = ("order of the L2 error", "sizes", "whole run" if event is None else f"up to the first {event.kind}")
    body = []
    for row in rows:
        order = row.order
        assert order is not None, "they were chosen so"
        orders = (order.whole,) if event is None else (order.before, order.whole)
        body.append((row.family, f"{order.coarser} to {row.size}", *map(_order, orders)))
    return [_table(head if event is None else (*head, "whole run"), body)]


def _sparse(found: Comparison) -> str:
    """A warning where the samples are too far apart to see every swing."""
    apart = found.until / (found.exact.t.size - 1) / found.rod.travel_time
    if apart <= _APART:
        return ""
    return (
        f"The samples are {apart:.3g} transits apart: peaks of the errors may lie between them, and L2 errors and "
        f"orders are those of the samples; {math.ceil((found.exact.t.size - 1) * apart / _APART) + 1} samples see more."
    )


def _remark(found: Comparison) -> str:
    """What an order says that is far above the first order of the scheme."""
    orders = [row.order.before for row in found.rows if row.family == "scheme" and row.order is not None]
    if found.exact.event is None or max((order for order in orders if order is not None), default=0.0) < 1.5:
        return ""
    return (
        f"Orders of the scheme above 1 up to the first {found.exact.event.kind} are no rate of convergence: until then "
        "the end moves as the smooth data ask, and what is seen are the faint edges of fronts still under way."
    )


def _modes(found: Comparison) -> str:
    head = ("decay in flight [1/s]", "mode 1", "mode 2", "mode 3")
    body = [("exact", *map(_number, found.decay))]
    body += [(row.label, *map(_number, row.decay)) for row in found.rows if row.decay]
    return _table(head, body)


def _cost(found: Comparison) -> str:
    head = ("cost", "integrator", "CPU [s]", "steps", "evaluations", "contacts")
    body: list[tuple[str, ...]] = [
        ("exact", "events", f"{found.exact.cpu_seconds:.3g}", "-", "-", str(len(found.contacts)))
    ]
    for row in _run(found):
        counts = ("-" if count is None else str(count) for count in (row.steps, row.evaluations))
        body.append((row.label, row.integrator, f"{row.cpu_seconds:.3g}", *counts, str(len(row.contacts))))
    remark = "CPU times are of this process, with what is loaded on first use; - is none or not counted."
    return f"{_table(head, body)}\n{_filled(remark)}"


def _settling(found: Comparison) -> str:
    head = ("settling", "5 % band [s]", "mode 1 decays in [s]", "left at 1.11e-3 s")
    body = [(row.method, _number(row.band_5), _number(row.fast), f"{100.0 * row.left:.4g} %") for row in found.settling]
    return _table(head, body)


def _run(found: Comparison) -> list[Row]:
    return [row for row in found.rows if not row.refused]


def _refused(found: Comparison) -> list[Row]:
    return [row for row in found.rows if row.refused]


def _table(head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    widths = [max(len(line[i]) for line in (head, *body)) for i in range(len(head))]
    lines = [
        "  ".join((line[0].ljust(widths[0]), *(word.rjust(n) for word, n in zip(line[1:], widths[1:], strict=True))))
        for line in (head, *body)
    ]
    return "\n".join((lines[0], "-" * len(lines[0]), *lines[1:]))


def _filled(sentence: str) -> str:
    return textwrap.fill(sentence, WIDTH, break_long_words=False, break_on_hyphens=False)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _order(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _percent(value: float | None) -> str:
    if value is None:
        return "-"
    return "<0.001 %" if 0.0 < value < 1e-5 else f"{100.0 * value:.3g} %"


def _share(end: float, start: float) -> str:
    return f"{end / start:.4g}" if start else "-"
