"""A motion of a cellular network as a Dataset, plain data, a python-control response, an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure import datasets
from lure.datasets import Column
from lure.showing import html_table, plain

if TYPE_CHECKING:
    import control
    import xarray

    from lure.cellular.motion import CellularMotion

SUBJECT, EVIDENCE = "cellular network", "observed"
STATE, TIME = "unit of the states of the network", "unit of time in which the templates are rates"
_SOURCE = (
    'L. O. Chua, L. Yang, "Cellular neural networks: theory", IEEE Trans. Circuits Syst. 35 (1988) 1257-1272; '
    "as equation (40) of Danciu, Matei, Micu, Roventa has it"
)
_METHOD = "integrated by scipy, relative tolerance 1e-10 a step"


def _about(motion: CellularMotion) -> str:
    return f"the cellular network of {' x '.join(map(str, motion.x.shape[1:]))} cells"


def _rest(motion: CellularMotion) -> str:
    if motion.steady is None:
        return "not looked for: bias or input change in time"
    return "looks at rest, which does not prove convergence" if motion.steady else "still moving"


def motion_dataset(motion: CellularMotion) -> xarray.Dataset:
    """The Dataset of :meth:`lure.cellular.CellularMotion.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    cells = ("cell",) if motion.x.ndim == 2 else ("row", "column")
    of = ("t", *cells)
    variables = {
        "x": Column(of, motion.x, STATE, "state x of each cell"),
        "output": Column(of, motion.output, STATE, "output f(x) of each cell"),
        "rate": Column((), motion.rate, f"{STATE} / {TIME}", "largest |x'| at the end"),
    }
    coordinates = {"t": Column(("t",), motion.t, TIME, "time since the start")}
    for name, size in zip(cells, motion.x.shape[1:], strict=True):
        coordinates[name] = Column((name,), np.arange(size), "1", f"number of the {name}, from 0")
    words = {"subject": SUBJECT, "about": _about(motion), "evidence": EVIDENCE, "method": _METHOD}
    attributes: dict[str, object] = {**datasets.motion_attributes("Motion of a cellular network", **words)}
    return datasets.dataset(variables, coordinates, attributes | {"references": _SOURCE, "rest": _rest(motion)})


def motion_dict(motion: CellularMotion) -> dict[str, object]:
    """What is said of the motion, with the last states and without the curves, as plain JSON data."""
    return {
        "subject": SUBJECT,
        "evidence": EVIDENCE,
        "shape": list(motion.x.shape[1:]),
        "until": float(motion.t[-1]),
        "samples": motion.t.size,
        "state_end": plain(motion.x[-1]),
        "output_end": plain(motion.output[-1]),
        "rate": plain(motion.rate),
        "steady": motion.steady,
        "comment": datasets.what_it_shows(SUBJECT, _about(motion), EVIDENCE),
    }


def motion_response(motion: CellularMotion) -> control.TimeResponseData:
    """The python-control response of :meth:`lure.cellular.CellularMotion.to_control`."""
    indices = np.ndindex(motion.x.shape[1:])
    labels = [f"f(x[{', '.join(map(str, index))}])" for index in indices]
    flat = motion.output.reshape(motion.t.size, -1).T
    return datasets.time_response(_about(motion), motion.t, dict(zip(labels, flat, strict=True)), {})


def motion_html(motion: CellularMotion) -> str:
    """A table for notebooks."""
    last = motion.output[-1]
    rows = [
        ("what moved", _about(motion)),
        ("time", f"0 to {motion.t[-1]:g} ({TIME}), {motion.t.size} samples"),
        ("outputs at the end", f"{last.min():.6g} to {last.max():.6g}"),
        ("largest |x'| at the end", f"{motion.rate:.2g}"),
        ("rest", _rest(motion)),
    ]
    notes = (datasets.what_it_shows(SUBJECT, _about(motion), EVIDENCE),)
    return html_table("motion of a cellular network", rows, verdict="OBSERVED", notes=notes)
