"""The rod as it moves: displaced, coloured by its stress, against its obstacle; with the path of its end below."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, VERMILLION, finish_axes, number, padded
from lure.analysis.rod.plots.run import COLOURS, colour_top, head, shade_contacts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lure.analysis.rod.runs.drawing import Film

PER_SECOND = 18
_DPI = 110
_SIZE = (7.2, 4.6)
_SHARE = 0.16  # of its length that the rod seems to move
_FAR = 6.0
_TICKS = 11


def has_ffmpeg() -> bool:
    """Whether matplotlib finds ffmpeg, which MP4 needs."""
    from matplotlib.animation import FFMpegWriter

    return bool(FFMpegWriter.isAvailable())


def animate(film: Film, path: Path, *, title: str, tell: Callable[..., None] | None = None) -> None:
    """Write an animation: ``.gif``, ``.mp4`` (with ffmpeg), or a folder of PNG frames for a name without suffix.

    Parameters
    ----------
    film : Film
        A stretch of a motion.
    path : Path
        The file to write, or an existing folder.
    title : str
        Name of the system in a line.
    tell : callable, optional
        Progress, ``tell(stage, done)``.

    Notes
    -----
    Deterministic for GIF and PNG: matplotlib's own defaults instead of the user's, and no date.
    """
    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.style import context

    from lure.analysis.plots.style import INK

    ink = {key: INK for key in ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")}
    settings: dict[str, object] = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, **ink}
    with rc_context(), context(["default", settings]):
        figure = Figure(figsize=_SIZE)
        canvas = FigureCanvasAgg(figure)
        picture = Picture(film, figure, title)
        if not path.suffix:
            digits = len(str(len(film.t) - 1))
            for i in range(len(film.t)):
                picture.show(i)
                figure.dpi = _DPI
                with (path / f"frame-{i:0{digits}d}.png").open("wb") as file:
                    canvas.print_png(file, metadata={"Software": None})
                _tell(tell, i, len(film.t))
            return
        writer: Any = (PillowWriter if path.suffix.lower() == ".gif" else FFMpegWriter)(fps=PER_SECOND)
        with writer.saving(figure, str(path), _DPI):
            for i in range(len(film.t)):
                picture.show(i)
                writer.grab_frame()
                _tell(tell, i, len(film.t))


def exaggeration(film: Film) -> tuple[float, float]:
    """How displacements are drawn: by which factor, 1, 2 or 5 times a power of ten, and counted from where [m].

    From zero, unless the rod as a whole has moved much farther than it moves in the film.  The obstacle is in view if
    it is not far beyond the motion.

    ``film``: a stretch of a motion.
    """
    u, gap = film.along.u, film.run.rod.gap
    low, high = float(u.min()), float(u.max())
    middle = 0.5 * (low + high)
    origin = 0.0 if abs(middle) <= 1.5 * (high - low) else middle
    size = max(high - origin, origin - low)
    if 0.0 < gap - origin <= _FAR * size:
        size = max(size, gap - origin)
    if size == 0.0:
        return 1.0, origin
    wanted = _SHARE * film.run.rod.length / size
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= wanted)), origin


class Picture:
    """The artists of a frame on an empty figure, moved from one to the next."""

    def __init__(self, film: Film, figure: Figure, title: str) -> None:
        self.film = film
        self.scale, self.origin = exaggeration(film)
        self.stress = film.run.rod.youngs_modulus * film.along.w
        head(figure, title, film.run)
        grid = figure.add_gridspec(
            2, 1, height_ratios=(1.0, 1.15), hspace=0.5, left=0.1, right=0.93, bottom=0.1, top=0.8
        )
        self.axes, self.trace = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
        self._draw_rod()
        self._draw_trace()

    def _draw_rod(self) -> None:
        from matplotlib.collections import PolyCollection

        film, axes, L = self.film, self.axes, self.film.run.rod.length
        moved = film.along.x + self.scale * (film.along.u - self.origin)
        wall, left, right = L + self.scale * (film.run.rod.gap - self.origin), moved[:, 0], float(moved.max())
        in_view = wall <= right + 0.5 * L
        self.stem = float(np.ptp(left)) + 0.04 * L  # from the end of the rod to the piston, which stays in its cylinder
        low = float(left.min()) - self.stem - 0.08 * L
        high = max(L, right, wall if in_view else L) + 0.05 * L
        axes.set(xlim=(low, high), ylim=(-0.3, 1.3), xticks=np.linspace(0.0, L, 6), yticks=[])
        axes.spines["left"].set_visible(False)
        top = colour_top(self.stress)
        self.bodies = PolyCollection([], cmap=COLOURS["stress"], edgecolors="face", linewidths=0.3, zorder=2)
        self.bodies.set_clim(-top, top)
        axes.add_collection(self.bodies, autolim=False)
        bar = axes.figure.colorbar(self.bodies, ax=axes, pad=0.015, fraction=0.04, aspect=12)
        bar.set_label("E ∂u/∂x [Pa]", fontsize="small")
        finish_axes(bar.ax)
        self.marks = axes.vlines([], 0.0, 1.0, color="black", lw=0.6, alpha=0.45, zorder=3)
        (self.outline,) = axes.plot([], [], color="black", lw=0.9, zorder=4)
        (self.dashpot,) = axes.plot([], [], color=GREY, lw=1.6, zorder=1)
        self._draw_left_end(low, float(left.min()))
        if in_view:
            axes.axvspan(wall, high, facecolor="none", edgecolor=VERMILLION, hatch="////", lw=0, alpha=0.6)
            axes.axvline(wall, color=VERMILLION, lw=1.6)
        gap, factor = number(film.run.rod.gap), number(self.scale)
        unseen = "" if in_view else f"; obstacle at u = {gap} m, outside this view"
        moved_by = f"(u(t, x) − {number(self.origin)} m)" if self.origin else "u(t, x)"
        axes.set_xlabel(f"x + {factor} {moved_by} [m]: displacements ×{factor}{unseen}".replace("− −", "+ "))
        self.clock = axes.text(0.0, 1.06, "", transform=axes.transAxes, va="bottom", fontsize=9.5)

    def _draw_left_end(self, low: float, least: float) -> None:
        """What holds ``x = 0``: a cylinder for the piston of the dashpot, a wall, or nothing."""
        run, axes = self.film.run, self.axes
        if run.dashpot_force is None and run.subject == "rod":
            axes.axvspan(low, 0.0, facecolor="none", edgecolor=GREY, hatch="////", lw=0, alpha=0.6)
        elif run.rod.damping:
            back, mouth = least - self.stem - 0.03 * run.rod.length, least - 0.015 * run.rod.length
            axes.plot([low, back], [0.5, 0.5], color=GREY, lw=1.6)
            axes.plot([mouth, back, back, mouth], [0.3, 0.3, 0.7, 0.7], color=GREY, lw=1.6)

    def _draw_trace(self) -> None:
        film, axes = self.film, self.trace
        axes.plot(film.trace_t, film.trace_u, color=BLUE, lw=1.1)
        gap, low, high = film.run.rod.gap, float(film.trace_u.min()), float(film.trace_u.max())
        if gap - high <= _FAR * (high - low):
            axes.axhline(gap, color=VERMILLION, lw=1.1, ls="--")
            low, high = min(low, gap), max(high, gap)
        axes.set_ylim(*padded(low, high, 0.08))
        axes.set_xlim(float(film.trace_t[0]), float(film.trace_t[-1]))
        shade_contacts(film.run, axes)
        axes.set_xlim(float(film.trace_t[0]), float(film.trace_t[-1]))
        finish_axes(axes, "t [s]", "u(t, L) [m]")
        self.now = axes.axvline(film.t[0], color=GREY, lw=0.8)
        (self.marker,) = axes.plot([], [], "o", color=BLUE, ms=6)

    def show(self, i: int) -> None:
        """Move everything to frame ``i``."""
        film, x, t = self.film, self.film.along.x, float(self.film.t[i])
        moved = x + self.scale * (film.along.u[i] - self.origin)
        left, right = moved[:-1], moved[1:]
        self.bodies.set_verts([np.array([[a, 0], [b, 0], [b, 1], [a, 1]]) for a, b in zip(left, right, strict=True)])
        self.bodies.set_array(0.5 * (self.stress[i, :-1] + self.stress[i, 1:]))
        places = np.interp(np.linspace(0.0, x[-1], _TICKS)[1:-1], x, moved)
        self.marks.set_segments([np.array([[p, 0.0], [p, 1.0]]) for p in places])
        a, b = float(moved[0]), float(moved[-1])
        self.outline.set_data([a, b, b, a, a], [0.0, 0.0, 1.0, 1.0, 0.0])
        if self.film.run.dashpot_force is not None and self.film.run.rod.damping:
            piston = a - self.stem
            self.dashpot.set_data([a, piston, piston, piston], [0.5, 0.5, 0.36, 0.64])
        touching = any(impact.start <= t <= impact.end for impact in film.run.impacts)
        self.clock.set_text(f"t = {t:.6g} s   {'contact' if touching else 'flight'}")
        self.clock.set_color(VERMILLION if touching else "black")
        end = float(np.interp(t, film.trace_t, film.trace_u))
        self.marker.set_data([t], [end])
        self.now.set_xdata([t, t])


def _tell(tell: Callable[..., None] | None, i: int, count: int) -> None:
    if tell:
        tell("frames", (i + 1) / count)
