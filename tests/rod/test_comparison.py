"""The comparison of all methods with the exact motion: orders, energies, modes, and the settling time of the paper."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from depth import rarely

from lure import AssumptionError, InputError
from lure.analysis.rod.comparison import compare
from lure.analysis.rod.comparison.modes import galerkin_modes, verdict, wave_decay
from lure.analysis.rod.comparison.reference import first_event
from lure.rod import Rod, Scenario, builtin_system
from lure.rod.galerkin import galerkin
from lure.rod.motion import exact_motion
from lure.rod.systems import paper_rod, rod_from_exact

PAPER = builtin_system("paper-rod")
T = PAPER.rod.travel_time


def unit_rod(**changes):
    """E = rho = A = L = 1, so that c = Z = T = d = 1."""
    values = {"youngs_modulus": 1, "density": 1, "length": 1, "area": 1, "damping": 0, "compliance": 1, "gap": 9}
    return Rod(**{**values, **changes})


STANDING = Scenario.parse(displacement="cos(pi*x)")  # with k = 0 the motion is cos(pi x) cos(pi t): no kink, no jump
SPACES = (("P1", 11), ("P1", 21), ("P1", 41), ("P2", 11), ("P2", 21), ("cosine", 6))


@pytest.fixture(scope="module")
def smooth():
    """Free: the end moves as -cos(pi t)."""
    return compare(unit_rod(), STANDING, 1.9, cells=(20, 40, 80, 160), galerkin=SPACES, samples=401)


@pytest.fixture(scope="module")
def struck():
    """The same with an obstacle that -cos(pi t) = 1/2 reaches at t = 2/3."""
    rod = unit_rod(gap=0.5, compliance=0.05)
    return compare(rod, STANDING, 2.9, cells=(20, 40, 80, 160), galerkin=SPACES, samples=401)


@pytest.fixture(scope="module")
def release():
    """The release of the paper."""
    return compare(PAPER.rod, PAPER.scenario, cells=(200, 10, 50), galerkin=(("P1", 16), ("cosine", 30)), samples=501)


def of(found, family):
    return [row for row in found.rows if row.family == family]


# errors and orders ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_errors_are_those_against_the_closed_form(smooth):
    # exact: u(t, 1) = -cos(pi t).  Scheme: r1 = pi sin(pi x), r2 = -r1 start as sampled sines; the ring turns them at
    # lambda = s(e^{i pi/N} - 1), with no other mode in them, so u(t, 1) is -cos with that lambda up to its start.
    u = -np.cos(math.pi * smooth.t)
    assert smooth.exact.u == pytest.approx(u, abs=1e-13)
    assert smooth.exact.event is None
    for row in smooth.rows:
        error = row.u - u
        assert row.largest_error == pytest.approx(np.abs(error).max(), rel=1e-9, abs=1e-13)
        assert row.l2_error == pytest.approx(math.sqrt(np.mean(error**2)), rel=0.02, abs=1e-12)
        assert smooth.relative(row.largest_error) == pytest.approx(row.largest_error, rel=1e-3)  # amplitude 1


def test_smooth_motion_is_approached_at_first_second_and_higher_order(smooth):
    scheme, p1, p2 = (of(smooth, family) for family in ("scheme", "Galerkin P1", "Galerkin P2"))
    assert [row.size for row in scheme] == [20, 40, 80, 160]
    # upwinding is of first order: the error halves with the cells, from a pre-asymptotic 0.8 on
    assert [row.order.whole for row in scheme[1:]] == sorted(row.order.whole for row in scheme[1:])
    assert scheme[-1].order.whole == pytest.approx(1.0, abs=0.1)
    assert scheme[-2].largest_error / scheme[-1].largest_error == pytest.approx(2.0, abs=0.1)
    # P1: h^2 in L2 in space, hence of u(t, L); P2: more than h^3
    assert [row.order.whole for row in p1[1:]] == pytest.approx([2.0, 2.0], abs=0.1)
    assert p2[1].order.whole > 2.8
    # cos(pi x) is itself in the space of cosines: no error but that of the time integration
    assert of(smooth, "Galerkin cosine")[0].largest_error < 1e-6
    assert scheme[0].order is None
    assert p1[0].order is None


@pytest.mark.slow
def test_the_orders_hold_up_to_contact_and_fall_after_it(struck):
    event = struck.exact.event
    assert (event.kind, event.t) == ("contact", pytest.approx(2 / 3, abs=1e-12))
    assert struck.contacts[0][0] == pytest.approx(2 / 3, abs=1e-12)
    scheme, p1 = of(struck, "scheme"), of(struck, "Galerkin P1")
    assert scheme[-1].order.before == pytest.approx(1.0, abs=0.1)
    assert scheme[-1].order.whole == pytest.approx(1.0, abs=0.2)
    assert [row.order.before for row in p1[1:]] == pytest.approx([2.0, 2.0], abs=0.1)
    # after contact v'(t, L) jumps: no longer the order of smooth motion, and less than before for P2
    p2 = of(struck, "Galerkin P2")[1].order
    assert p2.whole < p2.before - 0.3
    for row in struck.rows:
        early = row.u[struck.t <= event.t] - struck.exact.u[struck.t <= event.t]
        assert row.before_error == pytest.approx(math.sqrt(np.mean(early**2)), rel=0.05, abs=1e-9)


@pytest.mark.slow
def test_orders_of_the_papers_release_are_those_of_a_smeared_kink(release):
    # a front smeared over sqrt(h T) leaves an error of that size in u over that time: L2 of order h^(3/4) up to the
    # kink; over the run the coarse scheme has lost everything, and the order is less
    event = release.exact.event
    assert (event.kind, event.t) == ("kink", pytest.approx(T, rel=1e-12))
    ten, fifty, fine = of(release, "scheme")
    assert (ten.size, fifty.size, fine.size) == (10, 50, 200)
    assert [row.order.before for row in (fifty, fine)] == pytest.approx([0.75, 0.75], abs=0.05)
    assert fifty.order.whole < fine.order.whole < 0.75
    assert ten.largest_error > 0.95 * release.exact.amplitude
    assert release.exact.amplitude == pytest.approx(1e-4, rel=1e-3)


def test_an_order_that_is_no_rate_is_called_so():
    # uniform strain and contact before the first front comes: up to then the scheme has hardly an error
    rod = rod_from_exact({**PAPER.rod.exact, "gap": Fraction(1, 10**5), "compliance": Fraction(1, 10**9)})
    found = compare(rod, PAPER.scenario, 3e-4, cells=(20, 40), galerkin=(), samples=301)
    assert found.rows[1].order.before > 1.5
    assert "are no rate of convergence" in " ".join(str(found).split())


def test_no_order_is_given_down_at_the_error_of_the_integrator():
    found = compare(unit_rod(), STANDING, 1.0, cells=(), galerkin=(("cosine", 4), ("cosine", 8)), samples=101)
    assert found.rows[1].order.whole is None
    assert found.rows[1].order.before is None


@pytest.mark.parametrize(
    ("changes", "scenario", "kind", "t"),
    [
        ({}, Scenario.parse(displacement="x*(1 - x)/9"), "kink", 1.0),  # u0'(0) = 1/9 with no force: a jump at x = 0
        ({"damping": 1}, Scenario.parse(displacement="x*x/9"), "kink", None),  # at x = L alone; k = Z: it never returns
        ({}, Scenario.parse(displacement="x*x/9"), "kink", 2.0),
        ({}, Scenario.parse(force="where(t < 0.25, 0, 1)"), "kink", 1.25),
        ({}, Scenario.parse(velocity="where(x < 0.25, 0, 1/9)"), "kink", 0.75),
        ({"gap": 0}, Scenario.parse(velocity="x"), "contact", 0.0),
        ({}, Scenario.parse(force="sin(t)**3"), "kink", None),
    ],
)
def test_the_first_kink_is_where_characteristics_say(changes, scenario, kind, t):
    event = first_event(exact_motion(unit_rod(**changes), scenario, 2.5))
    if t is None:
        assert event is None
    else:
        assert (event.kind, event.t) == (kind, pytest.approx(t, abs=1e-12))


# energy and modes -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_scheme_keeps_less_energy_than_the_rod_and_more_with_more_cells(release):
    kept = [row.energy_end for row in of(release, "scheme")]
    assert kept == sorted(kept)
    assert kept[-1] < 0.4 * release.exact.energy[-1]
    # the energy error is the energy lost to upwinding at the end, here to the digits of the slow loss of the rod
    assert of(release, "scheme")[0].energy_error == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_the_galerkin_energy_starts_where_its_projection_does(release):
    # H1 projection on cosines of u0' = -2e-4: the share 1 - sum 8/((2j-1)^2 pi^2) of the energy is out of the space
    row = of(release, "Galerkin cosine")[0]
    missing = 1.0 - sum(8.0 / ((2 * j - 1) ** 2 * math.pi**2) for j in range(1, 16))
    assert row.energy_error == pytest.approx(missing, rel=0.05)


def test_the_modes_are_the_closed_forms(release):
    a, s = PAPER.rod.reflection, 6000.0 * 10
    ten = of(release, "scheme")[0].decay
    assert ten == pytest.approx([s * (1 - (-a) ** 0.05 * math.cos(math.pi * m / 10)) for m in (1, 2, 3)], rel=1e-9)
    assert release.decay == pytest.approx([-math.log(-a) / (2 * T)] * 3, rel=1e-9)
    assert wave_decay(unit_rod(damping=1), None) == (None, None, None)
    assert wave_decay(unit_rod(damping=1), 7) == (7.0, 7.0, 7.0)
    assert wave_decay(unit_rod(damping=0.5), 2)[2] is None


@pytest.mark.slow
@pytest.mark.parametrize(("space", "order"), rarely([("P1", 40), ("P2", 41), ("cosine", 40)], ("P1", 40), ("P2", 41)))
def test_galerkin_modes_move_the_end_as_the_integrator_does(space, order):
    rod = unit_rod(damping=0.3)
    scenario = Scenario.parse(displacement="x*x/7", velocity="cos(2*x)")
    model = galerkin(rod, space=space, order=order)
    run = model.simulate(scenario, 3.0, samples=31)
    modes = galerkin_modes(model, scenario)
    u = (modes.weights * np.exp(np.multiply.outer(run.t, modes.values))).sum(axis=-1)
    assert np.abs(u - run.u_end).max() < 1e-6
    assert modes.decay == pytest.approx(wave_decay(rod, None), rel=0.05)  # (ln(-a))/(2T) for every mode of the rod


def test_a_space_too_large_for_a_dense_solver_has_no_modes():
    assert galerkin_modes(galerkin(unit_rod(), space="P1", order=401), STANDING) is None


# the settling time ----------------------------------------------------------------------------------------------------


def test_the_settling_time_of_the_paper_is_refuted_by_numbers(release):
    left = {row.method: row.left for row in release.settling}
    assert left["scheme, N = 10"] < 0.05 < 0.65 < left["scheme, N = 200"] < 0.75
    # the rod loses 1.0 1/s: e^{-1.11e-3} to four digits
    assert left["exact"] == pytest.approx(math.exp(-1.11e-3), abs=2e-4)
    assert left["Galerkin cosine, m = 30"] > 0.98
    bands = {row.method: row.band_5 for row in release.settling}
    assert bands["scheme, N = 10"] < 1.11e-3 < 0.1 * bands["scheme, N = 200"]
    assert bands["exact"] == pytest.approx(math.log(20), rel=2e-3)
    assert release.settling_statement.startswith("The settling time of the paper is numerical dissipation: at t")
    assert "h = 1/200 gives the same as h = 1/10 is refuted" in release.settling_statement


@pytest.mark.parametrize(
    ("rod", "schemes", "said", "unsaid"),
    [
        (0.999, {10: 0.025, 200: 0.7}, "numerical dissipation", None),
        (0.999, {10: 0.025}, "numerical dissipation", "refuted"),
        (0.999, {10: 0.025, 11: 0.03}, "numerical dissipation", "refuted"),
        (0.999, {200: 0.7}, "is left", "dissipation"),
        (0.999, {11: 0.03, 200: 0.7}, "is left", "dissipation"),  # the paper's scheme has N = 10
        (0.02, {10: 0.02, 200: 0.02}, "is left", "dissipation"),
        (0.999, {10: 0.5}, "is left", "dissipation"),
        (0.999, {}, "nothing is said", "dissipation"),
    ],
)
def test_the_sentence_goes_no_further_than_the_numbers(rod, schemes, said, unsaid):
    statement = verdict(rod, schemes)
    assert said in statement
    assert unsaid is None or unsaid not in statement


@pytest.mark.slow
def test_of_another_rod_or_with_contact_nothing_is_said_about_the_paper(struck):
    assert struck.settling == ()
    assert struck.settling_statement == ""
    near = rod_from_exact({**PAPER.rod.exact, "gap": Fraction(5, 10**5)})
    assert compare(near, PAPER.scenario, 3e-4, cells=(10,), galerkin=(), samples=101).settling == ()
    pushed = Scenario.parse(force="1e-9*t", displacement="0.0001 - 0.0002*x")
    assert compare(PAPER.rod, pushed, 3e-4, cells=(10,), galerkin=(), samples=101).settling == ()


# independence, output, refusals ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("method", ["LSODA", "CVODE", "DOP853"])
def test_the_errors_do_not_depend_on_the_integrator(struck, method):
    found = compare(struck.rod, STANDING, 2.9, cells=(20, 40), galerkin=(), method=method, samples=401)
    for row, exact in zip(found.rows, struck.rows, strict=False):
        assert row.largest_error == pytest.approx(exact.largest_error, rel=1e-4)
        assert row.l2_error == pytest.approx(exact.l2_error, rel=1e-4)
        assert row.energy_error == pytest.approx(exact.energy_error, rel=1e-4)
        assert row.evaluations > 100
        assert exact.evaluations is None


def test_without_scenario_and_end_the_release_of_the_paper_is_taken():
    found = compare(PAPER.rod, cells=(10,), galerkin=(), samples=101)
    assert found.until == pytest.approx(2.5e-3, rel=1e-12)
    assert found.exact.u[0] == pytest.approx(-1e-4, rel=1e-12)
    assert found.rows[0].largest_error == pytest.approx(0.997e-4, rel=0.01)


def test_the_dictionary_is_json_and_has_the_numbers(struck):
    data = json.loads(json.dumps(struck.to_dict(), allow_nan=False))
    assert data["first_event"] == {"t": struck.exact.event.t, "kind": "contact"}
    assert data["exact"]["evidence"] == "COMPUTED"
    assert [row["size"] for row in data["rows"]] == [row.size for row in struck.rows]
    for plain, row in zip(data["rows"], struck.rows, strict=True):
        assert plain["evidence"] == "OBSERVED"
        assert plain["largest_error"] == row.largest_error
        assert plain["largest_error_relative"] == row.largest_error / struck.exact.amplitude
        assert (plain["order"] is None) == (row.order is None)


def test_the_text_fits_80_columns_and_names_what_each_row_is_about(release, struck):
    for found in (release, struck):
        lines = str(found).splitlines()
        assert max(map(len, lines)) <= 80
        flat = " ".join(" ".join(lines).split())
        assert "The exact row is about the rod (COMPUTED); every other row is one motion of a discrete model" in flat
        for row in found.rows:
            assert flat.count(row.label) >= 3
    assert "up to the first kink" in str(release)
    assert "up to the first contact" in str(struck)


def test_errors_far_below_a_percent_do_not_widen_the_table():
    # after 1e-6 s nothing has moved but as the data ask: 6e-9 of the amplitude and less
    lines = str(compare(PAPER.rod, PAPER.scenario, 1e-6, cells=(1, 40), galerkin=(("cosine", 11),), samples=64))
    assert max(map(len, lines.splitlines())) <= 80
    assert "<0.001 %" in lines


@pytest.mark.parametrize(("samples", "warned"), [(120, True), (121, False)])
def test_samples_that_miss_swings_are_said_to(samples, warned):
    # 2.5e-3 s are 15 transits: 120 steps of an eighth
    found = str(compare(PAPER.rod, PAPER.scenario, 2.5e-3 * (1 - 1e-9), cells=(), galerkin=(), samples=samples))
    flat = " ".join(found.split())
    assert ("peaks of the errors may lie between them" in flat) is warned
    assert ("121 samples see more" in flat) is warned


def test_a_model_that_cannot_be_run_says_why_and_the_others_go_on():
    # p = c_n sqrt(z) is not Lipschitz: no Galerkin motion, while the scheme has one
    found = compare(unit_rod(exponent=0.5), STANDING, 1.0, cells=(10,), galerkin=(("P1", 5),), samples=51)
    scheme, weak = found.rows
    assert scheme.refused == ""
    assert weak.u is None
    assert "Lipschitz" in weak.refused
    assert "Galerkin P1, m = 5 was not run" in " ".join(str(found).split())
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["rows"][1]["largest_error"] is None


def test_a_rod_at_rest_has_no_relative_errors():
    found = compare(unit_rod(), Scenario.parse(), 1.0, cells=(5, 10), galerkin=(("P1", 5),), samples=51)
    assert found.relative(0.0) is None
    assert max(row.largest_error for row in found.rows) < 1e-14  # u = z + gap with gap = 9
    assert found.rows[1].order.whole is None
    assert max(map(len, str(found).splitlines())) <= 80


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"cells": (10, 10)}, r"cells is \[10, 10\]; give every model once"),
        ({"cells": (0,)}, "discretisation.cells is 0"),
        ({"galerkin": (("P3", 5),)}, "galerkin.space is 'P3'"),
        ({"galerkin": (("P2", 4),)}, "give an odd number for P2"),
        ({"samples": 3}, "samples is 3; give a whole number from 16"),
        ({"method": "Heun"}, "method is 'Heun'; give one of exact"),
        ({"until": -1.0}, "until is -1.0"),
    ],
)
def test_malformed_requests_are_refused_before_anything_runs(arguments, message):
    with pytest.raises(InputError, match=message):
        compare(PAPER.rod, PAPER.scenario, **arguments)


def test_the_paper_rod_is_what_the_settling_claim_is_about():
    assert paper_rod() == PAPER.rod
    with pytest.raises(AssumptionError):
        galerkin(unit_rod(exponent=0.5), order=5)
