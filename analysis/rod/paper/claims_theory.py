"""The paper's claims about its model and its linear block."""

from __future__ import annotations

import numpy as np

from lure.analysis.rod.criteria import rod_criteria
from lure.analysis.rod.paper.model import PaperClaim
from lure.analysis.rod.paper.runs import COARSE, PaperRuns
from lure.analysis.rod.spectrum import rod_spectrum
from lure.analysis.verdict import Evidence, Verdict
from lure.rod.discretisation import upwind
from lure.rod.scenario import matching


def theory_claims(runs: PaperRuns) -> tuple[PaperClaim, ...]:
    """Claims of section 4 with what becomes of each, in the order of the paper.

    Parameters
    ----------
    runs : PaperRuns
        The motions behind the figures.
    """
    return (_rest(runs), _matched(runs), _simple_zero(runs), _popov(runs), _circulant(runs))


def _rest(runs: PaperRuns) -> PaperClaim:
    coarse, fine, rod = runs.settling
    start = float(runs.exact.end_displacement(0.0))
    return PaperClaim(
        key="rest",
        where="below (28), figure 6",
        claim="without force the rod comes to rest at its stationary solution u(L) = u0(L)",
        as_printed=f"N = 10: rests at {coarse.rest:+.4g} m, time constant {coarse.slow:.4g} s (no force: as corrected)",
        corrected=f"N = 200: rests at {fine.rest:+.4g} m, time constant {fine.slow:.4g} s",
        rod=f"rests at u0(0) = {rod.rest:+.4g} m, time constant rho A L/k = {rod.slow:.4g} s",
        survives=False,
        sentence=(
            f"Momentum decides: the rod rests where its dashpot end began, at {rod.rest:+.4g} m and not at u0(L) = "
            f"{start:+.4g} m, and drifts there with a time constant of {rod.slow:.3g} s, which the 2.5e-3 s shown hide."
        ),
        evidence=Evidence.COMPUTED,
    )


def _matched(runs: PaperRuns) -> PaperClaim:
    found = matching(runs.release.rod, runs.release.scenario)
    off = f"off by {abs(found.dashpot):.4g} N at x = 0 and {abs(found.contact):.4g} Pa at x = L"
    step = abs(float(runs.exact.end_wave(0.0))) * 2
    return PaperClaim(
        key="matched",
        where="below (37), (50)",
        claim="initial and boundary data have to be matched (and (50) is used)",
        as_printed=f"not matched: {off}",
        corrected=f"the same data, {off}; the scheme smears the jump",
        rod=f"a step of {step:.4g} m/s in both waves runs along the characteristics and stays a step",
        survives=found.matched,
        sentence=f"A rod released from compression starts with strain at its free ends: (50) is {off}.",
        evidence=Evidence.COMPUTED,
    )


def _simple_zero(runs: PaperRuns) -> PaperClaim:
    found = rod_spectrum(upwind(runs.release.rod, COARSE))
    return PaperClaim(
        key="simple-zero",
        where="end of section 4.1",
        claim="the linear block has a simple zero eigenvalue, all others in the open left half-plane",
        as_printed="simple; the matrix A is that of the corrected form",
        corrected=f"simple for every N; the slowest other one is {-found.decay_scheme:.6g} 1/s for N = 10",
        rod=f"simple pole; all others have the real part {-found.decay_rod:.6g} 1/s",
        survives=found.zero_multiplicity == 1 and found.decay_rod > 0,
        sentence="Survives because k > 0, decided from the exact value of k; for k = 0 the zero is double.",
        evidence=Evidence.CERTIFIED,
    )


def _popov(runs: PaperRuns) -> PaperClaim:
    block = upwind(runs.release.rod, COARSE)
    found = {(row.name, row.model): row for row in rod_criteria(block)}
    pulled = block.block.dense() + np.outer(block.b1, block.c) / runs.release.rod.compliance
    growth = float(np.linalg.eigvals(pulled).real.max())
    scheme, rod = found["popov", "scheme"], found["popov", "rod"]
    return PaperClaim(
        key="popov",
        where="end of section 4.1",
        claim="Popov's inequality for the critical case of a simple zero root can be used",
        as_printed=(
            f"with the b1 of (38) contact pulls, and motions in contact grow at {growth:.3g} 1/s; with the signs of "
            "(36) as corrected"
        ),
        corrected=f"{scheme.verdict} for the sector {scheme.sector}, N = 10, theta = {_theta(scheme.theta)}",
        rod=f"{rod.verdict} for the sector {rod.sector}, theta = {_theta(rod.theta)}",
        survives=scheme.verdict is Verdict.PROVED and rod.verdict is Verdict.PROVED,
        sentence=(
            "Survives with the signs of (36): every unloaded motion comes to rest at some z <= 0, one of a half-line "
            "of equilibria, none of which is asymptotically stable on its own."
        ),
        evidence=min(scheme.evidence, rod.evidence),
    )


def _theta(theta: float | None) -> str:
    return "none" if theta is None else f"{theta:.4g} s"


def _circulant(runs: PaperRuns) -> PaperClaim:
    scheme = upwind(runs.release.rod, COARSE, ordering="eq42")
    corner, factor = float(scheme.A[0, 2 * COARSE - 1]), -runs.release.rod.reflection
    return PaperClaim(
        key="circulant",
        where="end of section 4.2",
        claim="the CNN matrix of the ordering (42) is circulant",
        as_printed=f"its corner entry is -s a = {corner:.7g} 1/s; a circulant has s = {scheme.rate:.7g} 1/s there",
        corrected=f"f-circulant with f = -a = {factor:.7f}, for every N",
        rod=f"a wave returns from the dashpot as -a = {factor:.7f} times itself",
        survives=factor == 1.0,
        sentence=(
            f"It is f-circulant with f = -a = {factor:.6f}; a circulant, f = 1, is the rod with k = 0, whose zero "
            "eigenvalue is double and which nothing damps."
        ),
        evidence=Evidence.CERTIFIED,
    )
