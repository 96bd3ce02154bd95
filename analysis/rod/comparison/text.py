"""A comparison as text: tables within 80 columns, and sentences."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lure.analysis.rod.comparison.result import ENERGIES, EVIDENCE

if TYPE_CHECKING:
    from lure.analysis.rod.comparison.result import Comparison, Row

WIDTH = 80
_APART = 0.125


def text(found: Comparison) -> str:
    """The tables of a comparison and what may be read from them.

    Parameters
    ----------
    found : Comparison
        The comparison.
    """
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
