"""What the report says of the exact motion of the rod beside that of its scheme."""

import json
import math
from dataclasses import replace
from fractions import Fraction
from importlib import resources

import jsonschema
import pytest

from lure.analysis.report import ContradictionError
from lure.analysis.report.parts import to_json
from lure.analysis.rod.confirmation import confirm
from lure.analysis.rod.confirmation.result import Quantity
from lure.analysis.rod.confirmation.rod_side import contradictions_of_rest, contradictions_of_rod
from lure.analysis.rod.report import build, build_report, document
from lure.analysis.rod.report.document import _growth, _order, confirmation_data, confirmation_sentence
from lure.analysis.rod.report.model import claims
from lure.analysis.rod.report.output import page
from lure.analysis.rod.simulation import simulate
from lure.analysis.rod.simulation.trajectory import compared
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.rod import Scenario, builtin_system, upwind
from lure.rod.systems import rod_from_exact

SCHEMA = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
CHECK = jsonschema.Draft202012Validator(SCHEMA)
PAPER = builtin_system("paper-rod")
LEAF = Fraction(1, 10**5)


def system(until=2.5e-3, scenario=PAPER.scenario, **changes):
    return replace(PAPER, rod=rod_from_exact({**PAPER.rod.exact, **changes}), scenario=scenario, until=until)


BOUNCE = system(gap=LEAF, compliance=Fraction(1, 10**9), damping=Fraction(3, 10), until=0.01)


@pytest.fixture(scope="module")
def reports():
    return {
        "free": build_report(PAPER),
        "bounce": build_report(BOUNCE),
        "undamped": build_report(system(damping=0)),
        "growing": build_report(system(damping=Fraction(-3, 10))),
        "load": build_report(system(scenario=Scenario.parse(force="0.01*sin(2000*t)"))),
        "rest": build_report(system(scenario=Scenario.parse())),
        "soft": build_report(system(gap=0, scenario=Scenario.parse(velocity=1))),
    }


@pytest.mark.slow
def test_every_kind_keeps_the_schema_and_its_numbers_come_from_the_json(reports):
    for report in reports.values():
        data = json.loads(to_json(document(report)))
        assert not list(CHECK.iter_errors(data))
        assert confirmation_sentence(report.confirmation) == data["confirmation"]["sentence"]


def test_agreement_is_what_the_json_says_and_a_contradiction_is_none(reports):
    agreed = {name: report.confirmation.agrees for name, report in reports.items()}
    assert agreed == {name: document(report)["confirmation"]["agrees"] for name, report in reports.items()}
    assert agreed == {name: report.confirmation.to_dict()["agrees"] for name, report in reports.items()}
    assert agreed["free"] is True
    assert agreed["rest"] is None  # a rod that stays at rest tests nothing
    assert replace(reports["free"].confirmation, contradictions=("zeta rises",)).agrees is False


def test_the_package_hands_out_claims_and_the_report_on_a_loop():
    import lure.analysis.report
    import lure.analysis.report.loop
    import lure.analysis.rod.report

    for name in ("build_loop_report", "write_loop_report", "LoopReport"):
        assert getattr(lure.analysis.report, name) is getattr(lure.analysis.report.loop, name)
    assert lure.analysis.rod.report.claims is claims
    claim = lure.analysis.rod.report.Claim(text="", model="rod", answer="agrees", evidence=Evidence.OBSERVED)
    assert claim.criterion is None


# u0(0) = 1e-4, no momentum: z rests at 1e-4 - 0.02 in both; the energy of the rod after 24 round trips is |a|^48 of the
# first, as every wave has met the dashpot once in each.
def test_the_papers_rod_is_confirmed_on_both_sides(reports):
    found = document(reports["free"])["confirmation"]
    assert (found["kind"], found["agrees"]) == ("decay", True)
    assert found["compared"] == ["energy balance", "energy", "Lyapunov functional", "zeta", "resting place"]
    for model in ("rod", "scheme"):
        side = found[model]
        assert side["rest"]["predicted"] == pytest.approx(-0.0199, rel=1e-12)
        assert side["rest"]["agrees"] is True
        assert side["rest"]["difference"] < 1e-9
        for name in ("energy", "lyapunov", "zeta"):
            assert side[name]["residual"] <= side[name]["rounding"] < 1e-8
        assert side["momentum_residual"] < 1e-12
    energy = found["rod"]["energy"]
    trips = found["rod"]["until"] * 3000
    assert energy["end"] / energy["start"] == pytest.approx(PAPER.rod.reflection ** (2 * round(trips)), rel=1e-9)
    assert found["scheme"]["energy"]["end"] < 1e-6 * energy["start"]  # numerical damping
    assert found["rod"]["lyapunov_theta"] == pytest.approx(6000**2 / 6000, rel=1e-12)  # T (Z/k)^2


def test_a_contact_takes_its_impulse_from_zeta_in_both(reports):
    found = document(reports["bounce"])["confirmation"]
    for model in ("rod", "scheme"):
        side = found[model]
        assert side["contact_count"] == 1
        assert side["zeta"]["start"] == pytest.approx(9e-5, rel=1e-9)  # u0(0) - gap
        assert side["zeta"]["end"] < -5e-5
        assert side["rest"]["predicted"] == pytest.approx(side["zeta"]["end"], rel=1e-9)
        assert side["rest"]["agrees"] is True
    # the numerical damping of ten cells is not the rod's: another impulse, another resting place
    assert found["rod"]["rest"]["shown"] < 1.5 * found["scheme"]["rest"]["shown"]


def test_without_damping_the_rod_rings_on_and_the_scheme_does_not(reports):
    report = reports["undamped"]
    found = document(report)["confirmation"]
    assert report.confirmation.rod.lyapunov is None
    assert found["rod"]["energy"]["end"] == pytest.approx(found["rod"]["energy"]["start"], rel=1e-12)
    assert found["scheme"]["energy"]["end"] < 1e-3 * found["rod"]["energy"]["end"]
    assert "its waves persist" in str(report).replace("\n", " ")


def test_a_refuted_rod_is_shown_growing(reports):
    report = reports["growing"]
    found = document(report)["confirmation"]
    # a wave comes back 1/|a| = 1.5/0.9 times as large: energy times (5/3)^2 in each of 8 round trips
    assert found["rod"]["energy"]["end"] / found["rod"]["energy"]["start"] == pytest.approx((5 / 3) ** 16, rel=1e-9)
    said = confirmation_sentence(report.confirmation)
    energy = report.confirmation.rod.energy
    assert said.endswith(f"grows from {energy.start:.3g} J to {energy.end:.3g} J")
    slow = replace(energy, end=energy.start * (1 + 1e-5))
    side = replace(report.confirmation.rod, energy=slow)
    assert confirmation_sentence(replace(report.confirmation, rod=side)).endswith(" J by 0.001 %")
    assert found["rod"]["rest"] is None


def test_under_load_nothing_is_claimed_but_the_balance(reports):
    report = reports["load"]
    found = document(report)["confirmation"]
    assert found["compared"] == ["energy balance"]
    for model in ("rod", "scheme"):
        assert [found[model][name] for name in ("energy", "lyapunov", "zeta", "rest")] == [None] * 4
        assert found[model]["energy_residual"] < 1e-12
    assert "the load feeds energy in" in found["sentence"]


def test_a_rod_at_rest_tests_nothing(reports):
    found = document(reports["rest"])["confirmation"]
    assert (found["agrees"], found["compared"]) == (None, [])
    row = next(row for row in claims(reports["rest"]) if row.text.startswith("exact motion"))
    assert row.answer == "not tested"


def test_contact_that_outlasts_the_report_is_said(reports):
    found = document(reports["soft"])["confirmation"]
    assert found["rod"]["rest"] is None
    assert "contact is going on or can still come" in found["rod"]["open_end"]
    assert "resting place" not in found["compared"]


def test_the_motion_of_the_rod_is_one_observation_among_the_claims(reports):
    rows = [row for row in claims(reports["free"]) if row.evidence is Evidence.OBSERVED]
    assert [row.model for row in rows] == ["rod", "scheme, N = 10"]
    assert all(row.answer == "agrees" for row in rows)


@pytest.mark.parametrize("refusal", [AssumptionError("the rod chatters"), InputError("the waves grow")])
def test_a_refusal_of_the_exact_solver_is_said_and_the_verdict_stands(monkeypatch, refusal):
    def refuse(*_):
        raise refusal

    monkeypatch.setattr(confirm, "rod_side", refuse)
    report = build_report(PAPER)
    data = json.loads(to_json(document(report)))
    assert not list(CHECK.iter_errors(data))
    assert data["confirmation"]["rod_skipped"] == str(refusal)
    assert data["confirmation"]["rod"] is None
    assert data["confirmation"]["agrees"] is None
    assert report.verdict.name == "PROVED"
    text = page(data, claims(report), ())
    assert f"refuses this rod: {str(refusal).capitalize()}." in text
    assert f"the rod was not followed: {refusal}" in str(report).replace("\n", " ")


def test_a_contradiction_is_loud(monkeypatch, reports):
    found = reports["free"].confirmation
    monkeypatch.setattr(build, "confirmation", lambda *_: replace(found, contradictions=("zeta rises", "E rises")))
    with pytest.raises(
        ContradictionError, match=r"INTERNAL CONTRADICTION: the exact motion of paper-rod.*zeta rises; E"
    ):
        build_report(PAPER)


def test_what_counts_as_a_contradiction(reports):
    side = reports["free"].confirmation.rod
    assert contradictions_of_rod(side, "decay") == ()

    def rising(quantity):
        return Quantity(start=1, end=1, against=2 * quantity.allowance, allowance=quantity.allowance, scale=1)

    for name in ("energy", "lyapunov", "zeta"):
        (sentence,) = contradictions_of_rod(replace(side, **{name: rising(getattr(side, name))}), "decay")
        assert "rises by" in sentence
        below = replace(getattr(side, name), end=-2 * getattr(side, name).allowance * getattr(side, name).scale)
        found = contradictions_of_rod(replace(side, **{name: below}), "decay")
        assert [f"falls to {below.end:.3g}" in sentence for sentence in found] == ([] if name == "zeta" else [True])
    falling = replace(side, energy=rising(side.energy), lyapunov=None, zeta=None)
    assert "energy of the rod falls" in contradictions_of_rod(falling, "growth")[0]
    assert "energy of the rod changes" in contradictions_of_rod(falling, "undamped")[0]
    assert "cannot be trusted" in contradictions_of_rod(replace(side, energy_residual=1e-6), "decay")[0]
    assert "cannot be trusted" in contradictions_of_rod(replace(side, energy_residual=math.nan), "decay")[0]
    assert "otherwise than by the impulse" in contradictions_of_rod(replace(side, momentum=2e-9), "decay")[0]
    elsewhere = replace(side.rest, difference=2e-9, shown=side.rest.shown * (1 + 2e-9))
    assert "was predicted to rest" in contradictions_of_rest(replace(side, rest=elsewhere))[0]
    inside = replace(side.rest, predicted=1e-4, shown=1e-4)
    assert "inside the obstacle" in contradictions_of_rest(replace(side, rest=inside))[0]
    assert contradictions_of_rest(replace(side, rest=replace(side.rest, difference=0.9e-9))) == ()


def test_a_force_as_printed_acts_on_the_rod_as_the_scheme_feels_it():
    # 2 N through b2 without the factor s = c N/L = 60000 1/s is 2/60000 N, and the rod of 2e-4 kg is not thrown
    system = replace(builtin_system("paper-rod-figure-8"), until=0.02)
    corrected = replace(system, form="corrected", scenario=Scenario.parse(force="(2/60000)*sin(4*t)"))
    printed, same = (
        build_report(each).confirmation.rod
        for each in (
            system,
            replace(corrected, scenario=replace(corrected.scenario, displacement=system.scenario.displacement)),
        )
    )
    assert printed.curves.z == pytest.approx(same.curves.z, rel=1e-12)
    assert confirmation_data(build_report(system).confirmation)["kind"] == "load"


# a motion of energy E1 after E0 grew by 100 (E1/E0 - 1) %, and from 0 by no share at all
@pytest.mark.parametrize(
    ("start", "end", "said"),
    [(1.0, 1.5, " by 50 %"), (1.0, 3.0, " to 3 J"), (2.0, 2.0, " by 0 %"), (0.0, 3.0, " to 3 J")],
)
def test_growth_is_a_share_or_the_last_energy(start, end, said):
    assert _growth(Quantity(start=start, end=end, against=0.0, allowance=0.0, scale=end)) == said


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (0.0, "1e-14"),
        (1e-14, "1e-14"),
        (1.1e-14, "1e-13"),
        (2e-3, "1e-2"),
        (0.05, "1e-1"),
        (0.1, "1e-1"),
        (0.14, "0.2"),
        (0.26, "0.3"),
    ],
)
def test_an_error_is_not_printed_smaller_than_it_is(error, said):
    assert _order(error) == said


@pytest.mark.parametrize(
    ("settings", "held"),
    [
        ({}, ("energy identity", "Popov-Lyapunov function", "zeta", "resting place")),
        ({"damping": 0}, ("energy identity",)),
        ({"scenario": Scenario.parse()}, ()),
    ],
)
def test_what_a_simulation_was_held_against(settings, held):
    scheme = upwind(system(**settings).rod, 10)
    assert compared(simulate(scheme, system(**settings).scenario, until=1e-3)) == held
