"""The paper's figures and claims: settling, contact, variants as printed and corrected, and what the page says."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from depth import rarely
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from lure import AssumptionError
from lure.analysis.rod.paper import paper_figures, paper_runs, paper_table
from lure.analysis.rod.paper.figures import write_paper
from lure.analysis.rod.paper.runs import AMPLITUDES, OMEGA, HarmonicForce, ModalBasis, modal_run
from lure.analysis.rod.paper.settling import rod_settling, scheme_settling
from lure.analysis.rod.simulation import simulate
from lure.analysis.verdict import Evidence
from lure.rod import Scenario, builtin_system, initial_state, upwind
from lure.rod.systems import paper_rod

NOTEBOOK = Path(__file__).parents[2] / "notebooks/10-the-paper.py"
PAPER = builtin_system("paper-rod")
SURVIVE = {"simple-zero", "popov", "start", "free-release", "contact-8", "contact-9"}
FAIL = {"rest", "matched", "circulant", "same-for-n", "settling-time", "force", "contact-10"}


@pytest.fixture(scope="module")
def progress():
    return []


@pytest.fixture(scope="module")
def runs(progress):
    return paper_runs(progress=lambda stage, done: progress.append((stage, done)))


@pytest.fixture(scope="module")
def table(runs):
    return paper_table(runs)


# --- settling ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cells", rarely([10, 40], 40))
def test_the_ringing_of_the_scheme_leaves_the_band_just_before_its_settling_time_and_never_after(cells):
    # independent: matrix exponential of the block, the ringing by projecting rest and drift out of dense samples
    scheme = upwind(PAPER.rod, cells)
    found = scheme_settling(PAPER.rod, PAPER.scenario, cells)
    A, start = scheme.block.dense(), initial_state(scheme, PAPER.scenario)

    def ringing(t):
        u = (expm(A * t) @ start)[-1] + PAPER.rod.gap
        return u - found.rest - found.drift * math.exp(-t / found.slow)

    size = abs(ringing(0.0))
    for band, settled in ((0.05, found.band_5), (0.02, found.band_2)):
        assert abs(ringing(settled * (1 - 1e-6))) > band * size
        later = [abs(ringing(t)) for t in settled * (1 + 1e-6) + np.linspace(0, 6 * found.fast, 400)]
        assert max(later) <= band * size


def test_rest_and_drift_are_those_of_the_motion_itself():
    scheme = upwind(PAPER.rod, 10)
    found = scheme_settling(PAPER.rod, PAPER.scenario, 10)
    late = 20 * found.fast
    end = (expm(scheme.block.dense() * late) @ initial_state(scheme, PAPER.scenario))[-1] + PAPER.rod.gap
    assert end == pytest.approx(found.rest + found.drift * math.exp(-late / found.slow), abs=1e-11)
    assert end == pytest.approx(0, abs=1e-6)  # where the paper's figure seems to settle


def test_the_rod_settles_with_the_time_constant_of_its_mass_and_dashpot():
    # k << Z: the ringing is a triangle wave of size e^{-t/tau}, tau = rho A L/k = 1 s, with peaks at multiples of T
    found = rod_settling(PAPER.rod, PAPER.scenario)
    T = PAPER.rod.travel_time
    assert found.slow == pytest.approx(1.0, rel=1e-6)
    assert math.log(20) - 2 * T < found.band_5 < math.log(20) + T
    assert math.log(50) - 2 * T < found.band_2 < math.log(50) + T
    assert found.left == pytest.approx(math.exp(-1.11e-3), abs=2 * T)


@pytest.mark.parametrize("settling", [lambda rod, g: scheme_settling(rod, g, 10), rod_settling])
def test_every_model_rests_where_momentum_wants_it(settling):
    # k (u(inf) - u0(0)) = rho A int u1: 8 * 0.25e-4 * 0.02 / 0.05 = 8e-5
    release = Scenario.parse(displacement="0.0003 - 0.0002*x", velocity="0.02")
    assert settling(paper_rod("0.05"), release).rest == pytest.approx(3e-4 + 8e-5, abs=1e-12)


def test_a_rod_that_touches_the_obstacle_does_not_settle_freely():
    # u0 = e/2 - e x swings between -1e-4 and 1e-4 m
    with pytest.raises(AssumptionError, match=r"its end reaches the obstacle at t = 0\.0001"):
        rod_settling(PAPER.rod.replace(gap="0.00005"), PAPER.scenario)


@pytest.mark.parametrize("settling", [lambda rod, g: scheme_settling(rod, g, 10), rod_settling])
@pytest.mark.parametrize(
    ("damping", "scenario", "message"),
    [
        ("2e-4", Scenario.parse(force="sin(t)"), "the scenario has a load"),
        ("0", PAPER.scenario, "needs 0 < k < Z"),
        ("2", PAPER.scenario, "needs 0 < k < Z"),
    ],
)
def test_settling_is_refused_where_it_means_nothing(settling, damping, scenario, message):
    with pytest.raises(AssumptionError, match=message):
        settling(paper_rod(damping), scenario)


# --- the scheme under a harmonic force --------------------------------------------------------------------------------


@pytest.mark.slow
def test_eigenvectors_and_simulation_agree_on_the_motion_and_its_contacts():
    scheme = upwind(paper_rod("8e-4"), 10, form="as-printed")
    forced = Scenario.parse(force="5*sin(4*t)", displacement=PAPER.scenario.displacement.source)
    force = HarmonicForce(amplitude=5.0, omega=4.0)
    found = modal_run(ModalBasis(scheme.rod, 10), PAPER.scenario, force, form="as-printed", until=1.6)
    other = simulate(scheme, forced, until=1.6, samples=1601)
    assert found.z == pytest.approx(other.z, abs=1e-11)
    assert found.contacts == tuple(
        (pytest.approx(c.start, abs=1e-9), pytest.approx(c.end, abs=1e-9)) for c in other.contacts
    )
    assert len(found.contacts) == 1
    assert found.peak[1] == pytest.approx(other.max_gap_coordinate, abs=1e-10)


def test_the_forces_of_the_figures_are_those_of_the_built_in_systems():
    t = np.linspace(0, 5, 100)
    for figure, amplitude in AMPLITUDES.items():
        force = builtin_system(f"paper-rod-figure-{figure}").scenario.force
        assert np.allclose(force(t=t), amplitude * np.sin(OMEGA * t), atol=1e-14)


def test_the_eigenvectors_of_free_flight_in_closed_form_are_eigenvectors():
    basis, A = ModalBasis(PAPER.rod, 7), upwind(PAPER.rod, 7).block.dense()
    for modes, matrix in ((basis.free, A), (basis.contact, A - np.outer(upwind(PAPER.rod, 7).b1, np.eye(15)[-1]))):
        assert np.allclose(matrix @ modes.vectors, modes.vectors * modes.values, atol=1e-9 * 42000)
        assert np.allclose(modes.inverse @ modes.vectors, np.eye(15), atol=1e-9)


def test_eigenvectors_are_refused_where_there_is_no_basis_of_them_or_another_load():
    force = HarmonicForce(amplitude=1.0, omega=4.0)
    with pytest.raises(AssumptionError, match="need the linear contact law and k other than Z"):
        ModalBasis(paper_rod("1.2"), 4)
    with pytest.raises(AssumptionError, match="release has loads, g = 1"):
        modal_run(ModalBasis(PAPER.rod, 4), Scenario.parse(force=1), force, form="corrected", until=1.0)


# --- figures 8 to 10 --------------------------------------------------------------------------------------------------


def rigid_peak(damping, force):
    """Largest z of a rigid rod: rho A L u'' = force sin 4t - k u' - A p(u - gap)."""
    mass, area, gap = 2e-4, 0.25e-4, 0.02

    def motion(t, y):
        return [y[1], (force * math.sin(4 * t) - damping * y[1] - area * max(y[0] - gap, 0)) / mass]

    return float(solve_ivp(motion, (0, 5), [0, 0], rtol=1e-9, atol=1e-12, max_step=0.01).y[0].max()) - gap


@pytest.mark.slow_for("8-0.0002-2.0")
@pytest.mark.parametrize(("figure", "damping", "force"), [(8, 2e-4, 2.0), (9, 8e-4, 5.0), (10, 8e-4, 2.0)])
def test_every_variant_moves_like_a_rigid_rod_under_the_force_it_really_feels(table, figure, damping, force):
    # 4 rad/s against a first elastic mode at 18850 rad/s: rigid, up to the swing of 1e-4 m after the release
    felt = {
        "as-printed": force / 60_000,
        "as-printed-200": force / 1_200_000,
        "corrected": force,
        "corrected-200": force,
        "corrected-rescaled": force / 60_000,
        "corrected-rescaled-200": force / 60_000,
        "rod": force,
        "rod-rescaled": force / 60_000,
    }
    for variant, amplitude in felt.items():
        peak = table.peak(figure, variant)
        assert peak.largest_z == pytest.approx(rigid_peak(damping, amplitude), abs=1.1e-4, rel=2e-4), variant
        assert peak.contact == (peak.largest_z > 0) == (peak.contacts > 0), variant
        assert peak.evidence is (Evidence.COMPUTED if variant.startswith("rod") else Evidence.OBSERVED)


def test_the_printed_figures_have_contact_in_8_and_9_and_none_in_10(table):
    assert [table.peak(figure, "as-printed").contact for figure in (8, 9, 10)] == [True, True, False]


def test_dropping_the_factor_s_is_dividing_the_force_by_it(table):
    # the two systems are the same differential equation
    for figure in (8, 9, 10):
        printed, rescaled = table.peak(figure, "as-printed"), table.peak(figure, "corrected-rescaled")
        assert printed.largest_z == pytest.approx(rescaled.largest_z, rel=1e-9)


def test_the_forced_motion_of_the_corrected_scheme_tends_to_that_of_the_rod(table):
    for figure in (8, 9, 10):
        coarse, fine, rod = (
            table.peak(figure, variant).largest_z
            for variant in ("corrected-rescaled", "corrected-rescaled-200", "rod-rescaled")
        )
        assert abs(fine - rod) < abs(coarse - rod) < 1e-5


# --- the claims -------------------------------------------------------------------------------------------------------


def test_claims_that_fail_are_said_to_fail_and_no_others(table):
    assert {claim.key for claim in table.claims if claim.survives} == SURVIVE
    assert {claim.key for claim in table.claims if not claim.survives} == FAIL
    text = str(table)
    for claim in table.claims:
        mark = "survives" if claim.survives else "FAILS"
        assert re.search(rf"(?m)^{mark} +{re.escape(claim.claim)} \(", text)
        assert claim.sentence.split()[-1] in text


def test_every_failing_claim_carries_its_number(table):
    expected = {
        "rest": "+0.0001 m and not at u0(L) = -0.0001 m",
        "matched": "1.44 N at x = 0 and 5.76e+04 Pa",  # A E e = 1.44, E e = 57600
        "circulant": "f = -a = 0.999667",  # (1.2 - 0.0002)/(1.2 + 0.0002)
        "settling-time": "time constant 0.34 ms",  # 1/(60000 (1 - cos pi/10)) = 0.3405 ms
        "force": "60000 1/s: figure 8 belongs to 3.33e-05 N",
        "contact-10": "z = 1053 m",
        "same-for-n": "% of the initial displacement",
    }
    assert set(expected) == FAIL
    for key, number in expected.items():
        assert number in table.claim(key).sentence


def test_with_the_printed_sign_of_b1_contact_grows(table):
    # rigid rod, contact pulling: 2e-4 r^2 + 2e-4 r - 0.25e-4 = 0
    growth = (-1 + math.sqrt(1.5)) / 2
    assert f"grow at {growth:.3g} 1/s" in table.claim("popov").as_printed


def test_figure_6_on_10_and_on_200_cells_is_not_the_same_curve(table, runs):
    apart = np.abs(runs.coarse.u_end - runs.fine.u_end).max()
    assert 6e-5 < apart < 8e-5
    assert f"{apart:.3g} m" in table.claim("same-for-n").sentence


def test_the_settling_claim_gives_both_bands_of_all_three_models(table):
    claim = table.claim("settling-time")
    for text, numbers in (
        (claim.as_printed, ("0.881 ms", "1.21 ms", "3.3 time constants")),
        (claim.corrected, ("18.7 ms", "24.8 ms", "70%")),
        (claim.rod, (f"{math.log(20):.2f} s", f"{math.log(50):.2f} s", "99.9%")),
    ):
        assert all(number in text for number in numbers), text


def test_an_unknown_claim_or_peak_is_a_key_error(table):
    with pytest.raises(KeyError):
        table.claim("settling")
    with pytest.raises(KeyError):
        table.peak(7, "rod")


# --- as data, as files, in the notebook -------------------------------------------------------------------------------


def test_the_json_has_the_largest_z_of_every_figure_and_variant(table):
    data = json.loads(json.dumps(table.to_dict(), allow_nan=False))
    assert data["schema"] == "lure-paper/1"
    assert set(data["figures"]) == {"8", "9", "10"}
    for figure, variants in data["figures"].items():
        assert {"as-printed", "corrected", "corrected-rescaled", "rod"} <= set(variants)
        for variant, found in variants.items():
            assert found["largest_z"] == table.peak(int(figure), variant).largest_z
            assert found["contact"] is (found["largest_z"] > 0)
    assert [row["cells"] for row in data["settling"]] == [10, 200, None]
    assert len(data["claims"]) == len(table.claims)


@pytest.mark.slow
def test_the_files_are_a_page_its_data_and_every_figure_twice(table, runs, tmp_path):
    write_paper(table, runs, tmp_path / "out")
    page = (tmp_path / "out/paper.html").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "out/paper.json").read_text(encoding="utf-8")) == table.to_dict()
    names = [figure.name for figure in paper_figures(runs)]
    kinds = sorted(f"{name}.{kind}" for name in names for kind in ("png", "svg"))
    assert sorted(path.name for path in (tmp_path / "out/figures").iterdir()) == kinds
    assert {figure.number for figure in paper_figures(runs)} == set(range(3, 11))
    assert len(page) < 2_000_000
    assert "<script" not in page
    assert "max-width: 66rem" in page  # the style sheet of the report
    assert not re.search(r'(src|href)="(?!data:)', page)
    assert page.count("<img ") == len(names)
    for claim in table.claims:
        assert f'id="{claim.key}"' in page


def test_progress_is_told_from_nothing_to_all(runs, progress):
    shares = [done for _, done in progress]
    assert runs.forced
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)


def test_the_numbers_in_the_prose_of_the_notebook_are_those_of_the_table(table):
    prose = " ".join(
        line.lstrip("# ") for line in NOTEBOOK.read_text(encoding="utf-8").split("\n") if line.startswith("#")
    )
    coarse, fine, rod = table.settling
    quoted = [
        *(f"{1000 * found.band_5:.3g} ms" for found in (coarse, fine)),
        *(f"{1000 * found.band_2:.3g} ms" for found in (coarse, fine)),
        f"{rod.band_5:.2f} s and {rod.band_2:.2f} s",
        f"{100 * fine.left:.0f} %",
        f"{1.11e-3 / coarse.fast:.1f} time constants",
        f"by a factor of {fine.band_5 / coarse.band_5:.0f}",
        f"{table.peak(8, 'rod').largest_z / 1000:.2f} km",
        f"{table.peak(10, 'rod').largest_z / 1000:.2f} km",
        f"{-PAPER.rod.reflection:.5f}",
    ]
    assert [number for number in quoted if number not in prose] == []
