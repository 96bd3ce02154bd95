"""The spectrum of the rod's block: zero eigenvalue, residue, decay, and how much of the damping is numerical."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lure.errors import AssumptionError
from lure.record import html_table, plain, xarray_or_refusal
from lure.rod.parameters import Rod
from lure.rod.transfer import RodBlock
from lure.rod.upwind import UpwindScheme, upwind

if TYPE_CHECKING:
    import xarray

LISTED_MODES = 10


@dataclass(frozen=True, kw_only=True, slots=True)
class ModePair:
    """One wave mode in the scheme and in the rod.

    Attributes
    ----------
    number : int
        0 is the non-oscillating mode (``k < Z`` only), then 1, 2, .. by frequency.
    scheme : complex
        Eigenvalue of the scheme [1/s].
    rod : complex
        Pole of the rod [1/s].
    """

    number: int
    scheme: complex
    rod: complex

    @property
    def numerical_share(self) -> float:
        """Share of the scheme's damping that the rod lacks, ``1 - Re rod / Re scheme`` [-]; nan for no damping."""
        return 1.0 - self.rod.real / self.scheme.real if self.scheme.real else math.nan


@dataclass(frozen=True, kw_only=True, slots=True)
class RodSpectrum:
    """Spectrum of the rod's block, from closed forms (no eigenvalue solver).

    Attributes
    ----------
    zero_multiplicity : int
        Algebraic multiplicity of the eigenvalue 0, the same for scheme and rod: 1 for ``k != 0``, 2 for ``k = 0``.
        Decided from the exact value of ``k``.
    residue_at_zero : float or None
        ``rho_0 = A/k`` [m/(Pa s)]; None where the zero is double.
    decay_scheme, decay_rod : float
        ``-max Re`` over the wave eigenvalues [1/s]: negative if one grows, zero for ``k = 0``, ``inf`` for the matched
        rod.  For ``k < -Z`` the few cells of a scheme may damp what grows in the rod.
    elastic_scheme : complex
        First oscillating mode of the scheme [1/s]; real where the scheme has none, as ``-s`` for ``k = Z``.
    elastic_rod : complex or None
        First oscillating mode of the rod [1/s]; None for ``k = Z``.
    modes : tuple of ModePair
        The lowest modes, one of each conjugate pair; empty for ``k = Z``.
    jordan_size : int
        Size of the Jordan block at ``-s``: ``2N`` for ``k = Z``, else 1.
    """

    zero_multiplicity: int
    residue_at_zero: float | None
    decay_scheme: float
    decay_rod: float
    elastic_scheme: complex
    elastic_rod: complex | None
    modes: tuple[ModePair, ...]
    jordan_size: int

    @property
    def unstable(self) -> bool:
        """Whether the wave modes of the rod grow (``k < 0``)."""
        return self.decay_rod < 0

    def __str__(self) -> str:
        zero = {1: "simple", 2: "double"}[self.zero_multiplicity]
        return (
            f"zero eigenvalue {zero}; slowest wave mode decays at {self.decay_scheme:.6g} 1/s in the scheme and "
            f"{self.decay_rod:.6g} 1/s in the rod"
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; a complex eigenvalue is the pair of its parts [1/s]."""
        names = ("zero_multiplicity", "residue_at_zero", "decay_scheme", "decay_rod", "elastic_scheme", "elastic_rod",
                 "jordan_size")  # fmt: skip
        modes = [{"number": m.number, "scheme": plain(m.scheme), "rod": plain(m.rod)} for m in self.modes]
        known = {name: plain(getattr(self, name)) for name in names}
        return {"kind": "spectrum of the rod", "evidence": "computed", **known, "modes": modes, "sentence": str(self)}

    def to_xarray(self) -> xarray.Dataset:
        """The lowest modes of scheme and rod over ``mode``, as real variables that netCDF can hold.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        xr = xarray_or_refusal("RodSpectrum.to_xarray")
        unit = {"units": "1/s"}
        variables = {
            f"{name}_{part}": ("mode", [getattr(getattr(m, name), part) for m in self.modes], unit)
            for name in ("scheme", "rod")
            for part in ("real", "imag")
        }
        attributes = {"decay_scheme": self.decay_scheme, "decay_rod": self.decay_rod, "comment": str(self)}
        made: xarray.Dataset = xr.Dataset(variables, coords={"mode": [m.number for m in self.modes]}, attrs=attributes)
        return made

    def _repr_html_(self) -> str:
        rows = [(m.number, f"{m.scheme:.6g}", f"{m.rod:.6g}", f"{100 * m.numerical_share:.3g} %") for m in self.modes]
        zero = {1: "simple", 2: "double"}[self.zero_multiplicity]
        note = f"The zero eigenvalue is {zero} in both (exact). A mode of the scheme is not one of the rod. {self}."
        head = ("mode", "scheme [1/s]", "rod [1/s]", "damping that the rod lacks")
        return html_table("Spectrum of the rod's block, scheme against rod", rows, head=head, notes=[note])


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
        what = "the rod" if cells is None else f"the scheme with {cells} cells"
        raise AssumptionError(f"{what} has no wave mode {number} for a = {rod.reflection:g}")
    if cells is None:
        return complex(RodBlock(rod).log_reflection, 2.0 * math.pi * turn) / (2.0 * rod.travel_time)
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
    >>> from lure import builtin_system, upwind
    >>> print(rod_spectrum(upwind(builtin_system("paper-rod").rod, 10)))
    zero eigenvalue simple; slowest wave mode decays at 0.999992 1/s in the scheme and 1 1/s in the rod
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
    slowest = wave_mode(rod, first, N)
    return RodSpectrum(
        zero_multiplicity=2 if double else 1,
        residue_at_zero=residue,
        decay_scheme=0.0 - slowest.real,
        decay_rod=0.0 - wave_mode(rod, first, None).real,
        elastic_scheme=wave_mode(rod, 1, N),
        elastic_rod=wave_mode(rod, 1, None),
        modes=modes,
        jordan_size=1,
    )
