"""The files a motion is asked for as, netCDF, figures, an animation: all of them in the end, or none."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.rod.runs.methods import sampled_motion
from lure.analysis.rod.runs.request import Performed, Request
from lure.analysis.rod.runs.sampled import Along, SampledRun
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity
from lure.rod.motion.sampling import MOST_ENERGIES, along_motion, at_instants

if TYPE_CHECKING:
    import xarray


def check_netcdf_name(path: Path) -> None:
    """Refuse a name of another kind of file for netCDF; ``path``: the file to write.

    Raises
    ------
    InputError
        Its suffix is another.
    """
    if path.suffix.lower() not in (".nc", ".nc4"):
        raise InputError(f"output is {str(path)!r}, and netCDF is written; give a name that ends in .nc")


def check_netcdf() -> None:
    """Refuse to begin what ends in a netCDF file without the packages that write one.

    Raises
    ------
    InputError
        xarray or netCDF4 is not installed.
    """
    try:
        import netCDF4
        import xarray
    except ImportError as error:
        raise InputError(f'a netCDF file needs {error.name}: pip install "lure[netcdf]"') from None
    del netCDF4, xarray


def write_dataset(dataset: xarray.Dataset, path: Path) -> None:
    """Write a Dataset as netCDF 4, the same bytes for the same Dataset; tables are compressed without loss.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a motion.
    path : Path
        The file; one that exists is replaced.

    Raises
    ------
    InputError
        netCDF4 is not installed.
    OSError
        The file cannot be written.
    """
    check_netcdf()
    encoding = {
        str(name): {"_FillValue": None, **({"zlib": True, "complevel": 4} if variable.ndim > 1 else {})}
        for name, variable in dataset.variables.items()
    }
    dataset.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=encoding)


MOST_TRANSITS = 80
_USUAL_TRANSITS = 10
_PLACES = 201
_TRACE = 2001
_FEWEST = 4  # samples in a transit below which waves are no longer seen
FIGURES = (".svg", ".png")
FILMS = (".gif", ".mp4", "")
_FRAMES, _ROWS = (61, 181), 601
_IN_A_TRANSIT, _FRAMES_IN_A_TRANSIT, _ENERGIES = 40, 10, 401
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_CURVES = ("t", "z", "u_end", "stress", "v_end", "v_0", "dashpot_force", "energy")  # along the time


@described(frozen=True, kw_only=True, eq=False)
class Film:
    """A stretch of a motion, along the whole rod."""

    run: SampledRun = quantity("The motion, for its name, evidence, rod and contacts")
    t: Array = quantity("(frames,) instants", "s")
    along: Along = quantity("Fields at these instants")
    trace_t: Array = quantity("(n,) instants [s], more closely")
    trace_u: Array = quantity("(n,) ``u(t, L)`` there", "m")


def film(done: Performed, span: tuple[float, float] | None, *, frames: int, displaced: bool = True) -> Film:
    """A stretch of a motion to draw.

    ``done``: without an exact motion its samples must have fields; ``span``: first and last instant [s], by default all
    if that is at most 15 transits, else 10 transits around the contact of largest impulse, or from the start;
    ``frames``: at most so many where there are samples only; ``displaced``: whether the displacement is needed, too.

    Raises
    ------
    InputError
        The span is empty, leaves the motion or is longer than 80 transits, or the samples are too far apart.
    """
    first, last = span or usual_span(done.run)
    check_span((first, last), done.run.until, done.run.rod.travel_time)
    if done.motion is not None:
        t, trace = np.linspace(first, last, frames), np.linspace(first, last, _TRACE)
        along = along_motion(done.motion, t, _PLACES, displaced=displaced)
        return Film(run=done.run, t=t, along=along, trace_t=trace, trace_u=done.motion.end_displacement(trace))
    return _of_samples(done.run, (first, last), frames)


def usual_span(run: SampledRun) -> tuple[float, float]:
    """All of a short motion; of a long one ten transits around the contact of largest impulse, or from the start."""
    length = _USUAL_TRANSITS * run.rod.travel_time
    if run.until <= 1.5 * length * (1.0 + 1e-12):
        return 0.0, run.until
    if not run.impacts:
        return 0.0, length
    strongest = max(run.impacts, key=lambda impact: -1.0 if math.isnan(impact.impulse) else impact.impulse)
    first = min(max(0.0, strongest.start - length / 3.0), run.until - length)
    return first, first + length


def check_span(span: tuple[float, float], until: float, transit: float | None = None) -> None:
    """Refuse a stretch of time that cannot be drawn.

    ``span``: first and last instant [s]; ``until``: end of the motion [s]; ``transit``: ``T`` [s], if the whole rod is
    to be drawn.

    Raises
    ------
    InputError
        It is empty, leaves the motion or is too long for the waves to be seen.
    """
    first, last = span
    if not 0.0 <= first < last <= until:
        raise InputError(f"span is {first:g} to {last:g} s; give two instants in order in [0, {until:g}] s")
    if transit is not None and last - first > MOST_TRANSITS * transit * (1.0 + 1e-12):
        raise InputError(
            f"span is {first:g} to {last:g} s, {(last - first) / transit:.3g} transits of the rod; a picture shows the "
            f"waves of at most {MOST_TRANSITS}, give at most {MOST_TRANSITS * transit:.3g} s"
        )


def check_samples_seen(samples: int, until: float, transit: float) -> None:
    """Refuse samples too far apart for the waves to be seen in a picture made of them.

    ``samples``: number of instants from 0 to ``until``; ``until``: end of the motion [s]; ``transit``: ``T`` [s].

    Raises
    ------
    InputError
        There are fewer than four in a transit.
    """
    least = math.ceil(_FEWEST * until / transit * (1.0 - 1e-12)) + 1
    if samples < least:
        raise InputError(
            f"samples is {samples}, {(samples - 1) * transit / until:.2g} in a transit of the rod; for its waves to be "
            f"seen give at least {least}, or a shorter time"
        )


def _of_samples(run: SampledRun, span: tuple[float, float], frames: int) -> Film:
    along, T = run.along, run.rod.travel_time
    if along is None:
        raise InputError("the fields along the rod were not kept; give a number of places")
    step = float(run.t[1] - run.t[0])
    check_samples_seen(len(run.t), run.until, T)
    inside = np.flatnonzero((run.t >= span[0] - 0.5 * step) & (run.t <= span[1] + 0.5 * step))
    if len(inside) < 2:
        raise InputError(f"span is {span[0]:g} to {span[1]:g} s, less than two samples; give a longer one")
    kept = inside[:: math.ceil(len(inside) / frames)]
    fields = Along(x=along.x, v=along.v[kept], w=along.w[kept], u=along.u[kept])
    return Film(run=run, t=run.t[kept], along=fields, trace_t=run.t[inside], trace_u=run.u_end[inside])


def check_drawings(
    targets: Mapping[str, Path], request: Request, transit: float, span: tuple[float, float] | None
) -> None:
    """Refuse names and stretches of time that cannot be drawn, before anything is computed.

    ``targets``: of ``"output"``, ``"plot"``, ``"space-time"``, ``"animation"`` those asked for; ``transit``: ``T`` [s];
    ``span``: stretch of time to draw [s].

    Raises
    ------
    InputError
        A suffix is unknown, ffmpeg is missing, the span leaves the motion or has nothing to be drawn in, or waves would
        not be seen.
    """
    whole = bool({"space-time", "animation"} & set(targets))
    for kind, path in targets.items():
        suffix = path.suffix.lower()
        if kind in ("plot", "space-time") and suffix not in FIGURES:
            raise InputError(f"{kind} is {str(path)!r}; give a name that ends in {' or '.join(FIGURES)}")
        if kind == "output":
            check_netcdf_name(path)
        if kind == "animation":
            _check_film(path, suffix)
    if span is not None:
        if not set(targets) - {"output"}:
            raise InputError("span is the interval of time to draw; give plot, space-time or animation with it")
        check_span(span, request.until, transit if whole else None)
    if whole and request.method != "exact":
        check_samples_seen(request.samples, request.until, transit)


def _check_film(path: Path, suffix: str) -> None:
    if suffix not in FILMS:
        raise InputError(
            f"animation is {str(path)!r}; give a name that ends in .gif or .mp4, or one without a suffix for a folder "
            "of PNG frames"
        )
    if suffix == ".mp4":
        from lure.analysis.rod.plots.animation import has_ffmpeg

        if not has_ffmpeg():
            raise InputError(
                f"animation is {str(path)!r}, and MP4 needs ffmpeg, which is not on PATH; give a name that ends in "
                ".gif, or one without a suffix for a folder of PNG frames"
            )


@described(frozen=True, kw_only=True, slots=True)
class Wanted:
    """What is to be written of a motion."""

    places: Mapping[str, Path] = quantity(
        'Where to write ``"output"``, ``"plot"``, ``"space-time"`` and ``"animation"``, those asked for'
    )
    title: str = quantity("Name of the system in a line")
    span: tuple[float, float] | None = quantity("Stretch of time to draw", "s", default=None)
    fields: bool = quantity("Whether fields along the rod go to the file, too", default=True)


def write_results(done: Performed, wanted: Wanted, *, tell: Callable[..., None] | None = None) -> None:
    """Write what was asked for.

    ``tell``: progress, ``tell(stage, done)``.

    Raises
    ------
    InputError
        A picture cannot show the span.
    """
    places, title, span = wanted.places, wanted.title, wanted.span
    say = tell or (lambda _stage, _done=None: None)
    if "output" in places:
        say("netCDF")
        run = done.run if wanted.fields else replace(done.run, along=None)
        write_dataset(run.to_xarray().assign_attrs(title=title), places["output"])
    if "plot" in places:
        from lure.analysis.rod.plots.run import run_page

        say("figure")
        shown, energies = _for_plot(done, span)
        _figure(partial(run_page, shown, energies=energies, title=title), places["plot"], (6.4, 7.2))
    if "space-time" in places:
        from lure.analysis.rod.plots.run import space_time_page

        say("space-time diagram")
        diagram = film(done, span, frames=_ROWS, displaced=False)
        _figure(partial(space_time_page, diagram, title=title), places["space-time"], (6.4, 6.4))
    if "animation" in places:
        from lure.analysis.rod.plots.animation import animate

        say("frames")
        first, last = span or usual_span(done.run)
        frames = math.ceil(_FRAMES_IN_A_TRANSIT * (last - first) / done.run.rod.travel_time) + 1
        shown_film = film(done, (first, last), frames=min(max(frames, _FRAMES[0]), _FRAMES[1]))
        animate(shown_film, places["animation"], title=title, tell=tell)


def _figure(draw: Callable[..., object], path: Path, size: tuple[float, float]) -> None:
    from lure.analysis.plots import render

    suffix = path.suffix.lower()  # path has a random name here, which must not get into the file
    path.write_bytes(render(draw, name="motion", size=size, suffixes=[suffix]).file(suffix))


def _for_plot(done: Performed, span: tuple[float, float] | None) -> tuple[SampledRun, SampledRun]:
    """The samples to draw, closer than those of the file where the rod would swing unseen between them; energies."""
    run, motion = done.run, done.motion
    if motion is None:
        shown = run if span is None else _cut(run, span)
        return shown, shown
    first, last = span or (0.0, run.until)
    instants = drawn_instants((first, last), run.rod.travel_time)
    fine = SampledRun(evidence=Evidence.COMPUTED, **at_instants(motion, instants))
    enough = span is None and run.energy is not None and len(run.t) >= _ENERGIES
    return fine, run if enough else sampled_motion(motion, _ENERGIES, span=(first, last))


def drawn_instants(span: tuple[float, float], transit: float) -> Array:
    """Instants that show a stretch of a motion: forty in a transit, or 20001.

    Too few to follow each swing, they still meet it in every phase: they stand at the multiples of the golden ratio
    modulo 1, which spread evenly, in equal intervals of time.  Evenly spaced ones could all meet it in the same phase.

    ``span``: first and last instant [s]; ``transit``: ``T`` [s].

    Returns
    -------
    ndarray
        Increasing [s].
    """
    first, last = span
    enough = math.ceil(_IN_A_TRANSIT * (last - first) / transit) + 1
    if enough <= MOST_ENERGIES:
        return np.linspace(first, last, enough)
    number = np.arange(1, MOST_ENERGIES - 1)
    inside = first + (last - first) * ((number - 1 + number * _GOLDEN % 1.0) / (MOST_ENERGIES - 2))
    return np.concatenate(([first], inside, [last]))


def _cut(run: SampledRun, span: tuple[float, float]) -> SampledRun:
    inside = (run.t >= span[0]) & (run.t <= span[1])
    if inside.sum() < 2:
        raise InputError(f"span is {span[0]:g} to {span[1]:g} s, less than two samples; give more samples")
    curves: dict[str, Any] = {name: getattr(run, name) for name in _CURVES}
    kept: dict[str, Any] = {name: None if values is None else values[inside] for name, values in curves.items()}
    return replace(run, **kept, along=None)
