"""The spectrum of the rod's block: zero eigenvalue, residue, decay, and how much of the damping is numerical."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from lure.errors import AssumptionError
from lure.plants.multivariable import counted
from lure.record import Column, Page, Record, quantity
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant

LISTED_MODES = 10
DRAWN_MODES = 24


class ModePair(Record):
    """One wave mode in the scheme and in the rod."""

    number: int = quantity("0 is the non-oscillating mode (``k < Z`` only), then 1, 2, .. by frequency")
    scheme: complex = quantity("Eigenvalue of the scheme", "s-1")
    rod: complex = quantity("Pole of the rod", "s-1")

    @property
    def numerical_share(self) -> float:
        """Share of the scheme's damping that the rod lacks, ``1 - Re rod / Re scheme`` [-]; nan for no damping."""
        return 1.0 - self.rod.real / self.scheme.real if self.scheme.real else math.nan


class RodSpectrum(Record):
    """Spectrum of the rod's block, from closed forms (no eigenvalue solver)."""

    zero_multiplicity: int = quantity(
        "Algebraic multiplicity of the eigenvalue 0, the same for scheme and rod: 1 for ``k != 0``, 2 for ``k = "
        "0``. Decided from the exact value of ``k``"
    )
    residue_at_zero: float | None = quantity("``rho_0 = A/k`` [m/(Pa s)]; None where the zero is double")
    decay_scheme: float = quantity(
        "``-max Re`` over the wave eigenvalues of the scheme [1/s]: negative if one grows, zero for ``k = 0``"
    )
    decay_rod: float = quantity(
        "The same of the rod [1/s]; ``inf`` for the matched one.  For ``k < -Z`` the few cells of a scheme may "
        "damp what grows in the rod"
    )
    elastic_scheme: complex = quantity(
        "First oscillating mode of the scheme [1/s]; real where the scheme has none, as ``-s`` for ``k = Z``"
    )
    elastic_rod: complex | None = quantity("First oscillating mode of the rod [1/s]; None for ``k = Z``")
    modes: tuple[ModePair, ...] = quantity("The lowest modes, one of each conjugate pair; empty for ``k = Z``")
    jordan_size: int = quantity("Size of the Jordan block at ``-s``: ``2N`` for ``k = Z``, else 1")

    @property
    def unstable(self) -> bool:
        """Whether the wave modes of the rod grow (``k < 0``)."""
        return self.decay_rod < 0

    @property
    def _zero(self) -> str:
        return {1: "simple", 2: "double"}[self.zero_multiplicity]

    def __str__(self) -> str:
        zero = f"zero eigenvalue {self._zero}"
        if not self.modes:
            return f"{zero}; the rod has no wave modes, those of the scheme decay at {self.decay_scheme:.6g} 1/s"
        slowest = f"in the scheme the slowest decays at {self.decay_scheme:.6g} 1/s"
        if self.modes[0].number == 0:
            slowest += f" and does not oscillate, the first that oscillates at {0.0 - self.elastic_scheme.real:.6g} 1/s"
        return f"{zero}; every wave mode of the rod decays at {self.decay_rod:.6g} 1/s, {slowest}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; a complex eigenvalue is the pair of its parts [1/s]."""
        return {"kind": "spectrum of the rod", "evidence": "computed", **super().to_dict(), "sentence": str(self)}

    def _columns(self) -> dict[str, Column]:
        return {
            f"{name}_{part}": Column(("mode",), [getattr(getattr(m, name), part) for m in self.modes], "1/s", text)
            for name, text in (("scheme", "eigenvalue of the scheme"), ("rod", "pole of the rod"))
            for part in ("real", "imag")
        } | {"mode": Column(("mode",), [m.number for m in self.modes], "1", "number of the mode")}

    def _attributes(self) -> dict[str, object]:
        return {"decay_scheme": self.decay_scheme, "decay_rod": self.decay_rod, "comment": str(self)}

    def _page(self) -> Page:
        rows = [(m.number, f"{m.scheme:.6g}", f"{m.rod:.6g}", f"{100 * m.numerical_share:.3g} %") for m in self.modes]
        note = f"{self}. The zero eigenvalue is exact, in both. A mode of the scheme is not one of the rod."
        head = ("mode", "scheme [1/s]", "rod [1/s]", "damping that the rod lacks")
        return Page("Spectrum of the rod's block, scheme against rod", rows, head=head, notes=[note])


def wave_mode(rod: Rod, number: int, cells: int | None) -> complex:
    """Wave mode ``number`` of the rod (``cells=None``) or of its ``N``-cell scheme [1/s], ``k != Z``.

    Parameters
    ----------
    rod : Rod
        The rod.
    number : int
        Counts frequencies from 0 (``|k| < Z``: the non-oscillating mode) or from 1 (``|k| > Z`` has none), and up to
        ``N`` in a scheme.
    cells : int or None
        ``N``; None for the rod itself.

    Raises
    ------
    AssumptionError
        ``k = Z``, which has no wave modes, or ``N`` cells have no mode of that number.
    """
    turn = number if rod.reflection < 0 else number - 0.5
    if rod.reflection == 0.0 or turn < 0 or (cells is not None and number > cells):
        what = "the rod" if cells is None else f"the scheme with {counted(cells, 'cell')}"
        raise AssumptionError(f"{what} has no wave mode {number} for a = {rod.reflection:g}")
    if cells is None:
        return complex(RodPlant(rod).log_reflection, 2.0 * math.pi * turn) / (2.0 * rod.travel_time)
    return complex(upwind(rod, cells).wave_eigenvalues(turn))


def rod_spectrum(scheme: UpwindScheme) -> RodSpectrum:
    r"""Spectrum of a scheme against that of its rod.

    Eigenvalues of the scheme: 0 and ``s((-a)^{1/2N} e^{i pi m/N} - 1)``; poles of the rod: 0 and
    ``(ln(-a) + 2 pi i m)/(2T)``.  The zero is simple iff ``k != 0``; it comes from ``z``, and ``-a = 1`` (``k = 0``) is
    the only case in which a wave mode joins it.  For ``k = Z`` the waves of the scheme form one Jordan block of size
    ``2N`` at ``-s``: eigenvalue solvers return a circle of radius about ``s eps^{1/2N}`` there, which is noise.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme; cost does not depend on its size.

    Notes
    -----
    The rod's modes all decay at the same rate ``-ln|a|/(2T)``; amplitudes fall at that rate, the energy at twice it.

    Examples
    --------
    >>> from lure.rod import builtin_system, upwind
    >>> print(rod_spectrum(upwind(builtin_system("paper-rod").rod, 10)))  # doctest: +NORMALIZE_WHITESPACE
    zero eigenvalue simple; every wave mode of the rod decays at 1 1/s, in the scheme the slowest decays at 0.999992
    1/s and does not oscillate, the first that oscillates at 2937.56 1/s
    """
    rod, N = scheme.rod, scheme.cells
    double = rod.exact["damping"] == 0
    a = rod.reflection
    residue = None if double else rod.residue_at_zero
    if a == 0.0:
        return RodSpectrum(
            zero_multiplicity=1,
            residue_at_zero=residue,
            decay_scheme=scheme.rate,
            decay_rod=math.inf,
            elastic_scheme=complex(-scheme.rate),
            elastic_rod=None,
            modes=(),
            jordan_size=2 * N,
        )
    first = 0 if a < 0 else 1
    last = min(N, LISTED_MODES)
    modes = tuple(
        ModePair(number=m, scheme=wave_mode(rod, m, N), rod=wave_mode(rod, m, None)) for m in range(first, last + 1)
    )
    slowest = slowest_decays(scheme)
    return RodSpectrum(
        zero_multiplicity=2 if double else 1,
        residue_at_zero=residue,
        decay_scheme=slowest.scheme,
        decay_rod=slowest.rod,
        elastic_scheme=wave_mode(rod, 1, N),
        elastic_rod=wave_mode(rod, 1, None),
        modes=modes,
        jordan_size=1,
    )


class SlowestDecays(NamedTuple):
    """Decay of the slowest wave mode [1/s]: of the rod, and of its scheme."""

    rod: float
    scheme: float


def slowest_decays(scheme: UpwindScheme) -> SlowestDecays:
    """How fast the slowest wave mode of a rod decays, and that of its scheme; part of :func:`rod_spectrum`."""
    rod = scheme.rod
    if rod.reflection == 0.0:  # k = Z: the rod comes to rest in finite time
        return SlowestDecays(math.inf, scheme.rate)
    first = 0 if rod.reflection < 0 else 1
    return SlowestDecays(0.0 - wave_mode(rod, first, None).real, 0.0 - wave_mode(rod, first, scheme.cells).real)


def drawn_resonances(block: UpwindScheme | RodPlant) -> tuple[list[complex], float, float]:
    """The resonances of a drawing, and the slowest and fastest rates [1/s] that it spans.

    ``block``: the scheme, or the rod, of whose infinitely many resonances 24 are drawn.
    """
    rod = block.rod
    cells = block.cells if isinstance(block, UpwindScheme) else None
    turn = math.pi / rod.travel_time
    drawn = min(DRAWN_MODES, cells or DRAWN_MODES)
    poles = [] if rod.reflection == 0.0 else [wave_mode(rod, m, cells) for m in range(1, drawn + 1)]
    slow = abs(wave_mode(rod, 0, cells)) if rod.reflection < 0.0 else 0.0
    all_drawn = cells is not None and cells <= drawn
    return poles, min(slow or turn, turn), turn * (20.0 * drawn if all_drawn else drawn + 0.5)
