"""The paper's claims, about its model and its linear block and about its simulations, figures 3 to 10."""

from __future__ import annotations

import numpy as np

from lure.analysis.rod.paper.model import PaperClaim
from lure.analysis.rod.paper.runs import COARSE, PaperRuns
from lure.analysis.rod.paper.settling import PAPER_SETTLING
from lure.analysis.rod.popov import rod_criteria
from lure.analysis.rod.spectrum import rod_spectrum
from lure.analysis.verdict import Evidence, Verdict
from lure.rod.discretisation import upwind
from lure.rod.scenario import initial_state, matching

# The paper's claims about its model and its linear block.


def theory_claims(runs: PaperRuns) -> tuple[PaperClaim, ...]:
    """Claims of section 4 with what becomes of each, in the order of the paper.

    ``runs``: the motions behind the figures.
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
    step = abs(float(runs.exact.end_velocity(0.0))) * 2
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
    found = {(row.criterion, row.model): row for row in rod_criteria(block)}
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


def figure_claims(runs: PaperRuns) -> tuple[PaperClaim, ...]:
    """Claims of section 5 with what becomes of each, in the order of the paper.

    ``runs``: the motions behind the figures.
    """
    forced = (_contact(runs, figure) for figure in (8, 9, 10))
    return (_same_for_n(runs), _start(runs), _settling(runs), _free_release(runs), _force(runs), *forced)


def _same_for_n(runs: PaperRuns) -> PaperClaim:
    apart = float(np.abs(runs.coarse.u_end - runs.fine.u_end).max())
    share = apart / abs(float(runs.exact.end_displacement(0.0)))
    ten, fine, small, smaller, rod = (
        runs.run(8, variant).peak
        for variant in (
            "as-printed",
            "as-printed-200",
            "corrected-rescaled",
            "corrected-rescaled-200",
            "rod-rescaled",
        )
    )
    return PaperClaim(
        key="same-for-n",
        where="section 5",
        claim="h = 1/10 is small enough; h = 1/200 leads to the same results",
        as_printed=(
            f"figure 8: largest z {ten.largest_z:.4g} m for N = 10, {fine.largest_z:.4g} m for N = 200 "
            f"({'contact' if fine.contact else 'no contact'})"
        ),
        corrected=(
            f"figure 6: u(t, L) differs by up to {apart:.3g} m; figure 8 with force / 60000: largest z "
            f"{small.largest_z:.6g} m for N = 10, {smaller.largest_z:.6g} m for N = 200"
        ),
        rod=f"figure 8 with force / 60000: largest z {rod.largest_z:.6g} m",
        survives=False,
        sentence=(
            f"In figure 6 the two differ by up to {apart:.3g} m, {share:.0%} of the initial displacement, and as "
            "printed the force acts as g L/(cN), so that N = 200 shows no contact in figures 8 and 9; of the corrected "
            "scheme only the slow forced motion hardly depends on N."
        ),
        evidence=Evidence.OBSERVED,
    )


def _start(runs: PaperRuns) -> PaperClaim:
    start = float(runs.exact.end_displacement(0.0))
    first = float(initial_state(upwind(runs.release.rod, COARSE), runs.release.scenario)[COARSE - 1])
    return PaperClaim(
        key="start",
        where="section 5, figure 6",
        claim="figure 6 starts at u = -1e-4 = u0(1)",
        as_printed=f"(50) gives u0(1) = {1 + start:.4f}: it adds the position x = 1",
        corrected=f"u0(1) = {start:.4g} m, with the gap 0.02 m for l = 1.02; xi_1^N(0) = {first:.4g} m/s",
        rod=f"u(0, L) = {start:.4g} m",
        survives=abs(start + 1e-4) < 1e-15,
        sentence=f"Survives for the displacement e/2 - e x; xi_1^N(0), said to be the same, is {first:.4g} m/s.",
        evidence=Evidence.COMPUTED,
    )


def _settling(runs: PaperRuns) -> PaperClaim:
    coarse, fine, rod = runs.settling
    return PaperClaim(
        key="settling-time",
        where="section 5, figures 6 and 7",
        claim="the settling time is 1.11e-3 s, 7 time constants",
        as_printed=(
            "N = 10: the ringing (u without its resting place and the drift there) stays within 5 % of its start "
            f"after {_ms(coarse.band_5)}, within 2 % after {_ms(coarse.band_2)}; 1.11 ms are "
            f"{PAPER_SETTLING / coarse.fast:.2g} time constants of its first elastic mode (no force: as corrected)"
        ),
        corrected=(
            f"N = 200: within 5 % after {_ms(fine.band_5)}, 2 % after {_ms(fine.band_2)}; at 1.11 ms {fine.left:.0%} "
            f"are left; time constant {_ms(fine.fast)}"
        ),
        rod=(
            f"within 5 % after {rod.band_5:.2f} s, 2 % after {rod.band_2:.2f} s; at 1.11 ms {rod.left:.1%} are left; "
            f"time constant {rod.fast:.3g} s"
        ),
        survives=False,
        sentence=(
            f"The 1.11 ms are the numerical damping of ten cells, time constant {_ms(coarse.fast)}: the rod rings for "
            f"{rod.band_5:.2f} s before 5 % are left, {rod.band_5 / PAPER_SETTLING:.0f} times as long."
        ),
        evidence=Evidence.COMPUTED,
    )


def _ms(seconds: float) -> str:
    return f"{1000 * seconds:.3g} ms"


def _free_release(runs: PaperRuns) -> PaperClaim:
    coarse, fine = float(runs.coarse.max_gap_coordinate), float(runs.fine.max_gap_coordinate)
    exact, step = runs.exact, runs.exact.rod.travel_time / 16
    t = np.arange(0.0, exact.until, step)
    largest = float(exact.z(t).max()) + 0.5 * step * float(np.abs(exact.end_velocity(t)).max())
    return PaperClaim(
        key="free-release",
        where="section 5, figures 6 and 7",
        claim="without force the rod does not reach the obstacle",
        as_printed=f"N = 10: largest z {coarse:.6g} m up to 2.5e-3 s (no force: as corrected)",
        corrected=f"N = 200: largest z {fine:.6g} m",
        rod=f"largest z at most {largest:.6g} m up to {exact.until:g} s",
        survives=max(coarse, fine, largest) < 0,
        sentence="Survives: the end swings between -1e-4 and 1e-4 m, and the gap is 0.02 m.",
        evidence=Evidence.COMPUTED,
    )


def _force(runs: PaperRuns) -> PaperClaim:
    printed, given, small, rod, rod_small = (
        runs.run(8, variant).peak
        for variant in ("as-printed", "corrected", "corrected-rescaled", "rod", "rod-rescaled")
    )
    return PaperClaim(
        key="force",
        where="section 5, figures 8 to 10",
        claim="the curves belong to the forces 2 sin 4t and 5 sin 4t newton",
        as_printed=f"figure 8: largest z {printed.largest_z:.4g} m for 2 N, with b2 = [2b 0 ..] and N = 10",
        corrected=f"2 N: {given.largest_z:.4g} m; {small.amplitude:.4g} N: {small.largest_z:.4g} m",
        rod=f"2 N: {rod.largest_z:.4g} m; {rod_small.amplitude:.4g} N: {rod_small.largest_z:.4g} m",
        survives=False,
        sentence=(
            f"The printed b2 lacks the factor s = cN/L = {given.amplitude / small.amplitude:.6g} 1/s: figure 8 belongs "
            f"to {small.amplitude:.3g} N, and 2 N would push this rod of 0.2 g {rod.largest_z / 1000:.3g} km into the "
            "obstacle."
        ),
        evidence=Evidence.COMPUTED,
    )


def _contact(runs: PaperRuns, figure: int) -> PaperClaim:
    printed, fine, given, small, rod, drawn = (
        runs.run(figure, variant).peak
        for variant in ("as-printed", "as-printed-200", "corrected", "corrected-rescaled", "rod", "rod-rescaled")
    )
    wanted = figure != 10
    survives = given.contact == rod.contact == wanted
    finding = "Survives" if survives else "Does not survive"
    return PaperClaim(
        key=f"contact-{figure}",
        where=f"section 5, figure {figure}",
        claim=f"{'contact' if wanted else 'no contact'} in figure {figure}",
        as_printed=f"largest z {printed.largest_z:.4g} m for N = 10, {fine.largest_z:.4g} m for N = 200",
        corrected=f"{given.amplitude:g} N: {given.largest_z:.4g} m; {small.amplitude:.3g} N: {small.largest_z:.4g} m",
        rod=(
            f"{rod.amplitude:g} N: {rod.largest_z:.4g} m; {drawn.amplitude:.3g} N: {drawn.largest_z:.4g} m, "
            f"{drawn.contacts or 'no'} contact interval{'s' if drawn.contacts != 1 else ''}"
        ),
        survives=survives,
        sentence=(
            f"{finding} for {rod.amplitude:g} N, which take the rod to z = {rod.largest_z:.4g} m; the curve drawn "
            f"belongs to {drawn.amplitude:.3g} N, where the rod has {'contact' if drawn.contact else 'no contact'} "
            f"(largest z {drawn.largest_z:.4g} m), and as printed N = 200 has {'contact' if fine.contact else 'none'}."
        ),
        evidence=Evidence.COMPUTED,
    )
