"""The conclusion on the rod: verdict, class and first sentence from the certificates, and nothing said beyond them."""

from fractions import Fraction

import pytest

from lure import NonlinearityClass, Sector
from lure.analysis import max_sector
from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.questions.certify import certify
from lure.analysis.questions.conclusion import MismatchError
from lure.analysis.rod.certificates import energy_theorem_draft
from lure.analysis.rod.conclusion import concluded as concluded_of
from lure.analysis.rod.conclusion import conclusion, offered
from lure.analysis.rod.popov import rod_circle_criterion
from lure.analysis.rod.report.build import checked_criteria
from lure.analysis.verdict import Evidence, Verdict
from lure.rod import Scenario, builtin_system, upwind
from lure.rod.systems import rod_from_exact
from lure.rod.transfer import RodPlant


def scheme_of(**changes):
    rod = builtin_system("paper-rod").rod
    return upwind(rod_from_exact({**rod.exact, **{name: Fraction(value) for name, value in changes.items()}}), 10)


def concluded(scenario=None, **changes):
    return conclusion(scheme_of(**changes), scenario or Scenario())


def test_a_certificate_of_a_driven_rod_is_printed_as_what_it_is():
    # figure 8 is driven by 2 sin 4t and never rests
    assert str(certify(builtin_system("paper-rod-figure-8"))).startswith("PROVED: without load, every motion")


# the circle criterion covers (E/L) Z^2/(k^2 - Z^2) = 288e6/3 at k = 2 Z; at k = Z, H = d/s has Re H = 0 on the axis,
# and every finite sector [0, K] the margin 1/K
@pytest.mark.parametrize(("damping", "upper"), [("2.4", 95 * 10**6), ("1.2", 10**9)])
def test_functions_that_depend_on_time_are_proved_around_a_rod_as_far_as_the_circle_criterion_serves(damping, upper):
    block = RodPlant(scheme_of(damping=damping).rod)
    found = certify(block, NonlinearityClass(sector=Sector(0, upper), time_varying=True))
    assert str(found).startswith("PROVED")
    assert "time-varying" in str(found)
    assert max_sector(block, time_varying=True).largest.low >= upper


@pytest.mark.parametrize(
    ("damping", "verdict"),
    [
        ("2e-4", Verdict.PROVED),
        ("1.2", Verdict.PROVED),
        ("1e9", Verdict.PROVED),
        ("0", Verdict.INCONCLUSIVE),
        ("-2e-4", Verdict.REFUTED),
        ("-5", Verdict.REFUTED),
    ],
)
def test_the_sign_of_the_damping_decides(damping, verdict):
    result = concluded(damping=damping)
    assert result.verdict is verdict
    assert (result.proofs != ()) == (verdict is Verdict.PROVED)


def test_it_says_what_the_certificates_say_of_their_class():
    result = concluded()
    scheme = scheme_of()
    rod, discrete = (
        complete_and_check(energy_theorem_draft(block)).certificate for block in (RodPlant(scheme.rod), scheme)
    )
    assert rod["conclusion"] == discrete["conclusion"]
    named = rod["conclusion"].replace("motion", "motion of the rod", 1).replace("law", "nonlinearity")
    assert result.headline == f"Without load, {named}."
    assert rod["laws"]["sector"] == ["0", "inf"]
    assert result.found.nonlinearity_class == "phi, time-invariant, in the sector [0, inf]"
    assert [(proof.model, proof.sector, proof.evidence) for proof in result.proofs] == [
        (model, "[0, inf]", Evidence.CERTIFIED) for model in ("rod", "scheme")
    ]
    assert result.proofs[0].meaning.lower() == named
    assert all(said in result.statement for said in ("[0, inf]", "rod-energy (certified)", "the scheme with 10 cells"))
    assert result.found.membership == "checked"


def test_a_certificate_about_another_rod_is_no_answer():
    scheme, other = scheme_of(), scheme_of(damping="1")
    with pytest.raises(MismatchError):
        concluded_of(RodPlant(scheme.rod), offered(RodPlant(other.rod)))
    with pytest.raises(MismatchError):
        concluded_of(RodPlant(scheme.rod), offered(scheme))  # the scheme is not the rod


@pytest.mark.parametrize("missing", ["rod", "rod-scheme"])
def test_nothing_is_decided_unless_both_certificates_are_accepted(missing, monkeypatch):
    def refusing(draft):
        if draft["system"]["kind"] == missing:
            raise ArithmeticError("too large")
        return complete_and_check(draft)

    monkeypatch.setattr("lure.analysis.rod.conclusion.complete_and_check", refusing)
    result = concluded()
    assert result.verdict is Verdict.INCONCLUSIVE
    assert result.proofs == ()
    assert [one.certificate["system"]["kind"] for one in result.certificates] == [
        kind for kind in ("rod", "rod-scheme") if kind != missing
    ]
    assert "too large" in result.statement
    assert result.headline.startswith("Nothing is decided for phi")
    assert result.resting_place == "none is claimed"


@pytest.mark.parametrize("exponent", ["1", "3/2", "3"])
def test_locally_lipschitz_laws_have_the_half_line_of_equilibria(exponent):
    result = concluded(exponent=exponent)
    assert result.verdict is Verdict.PROVED
    assert "half-line" in result.stationary_set
    assert any("locally Lipschitz" in row for row in result.assumptions)


# p = sqrt(max(z, 0)) has an infinite slope at 0: it is none of the locally Lipschitz nonlinearities of the certificate,
# as `lure certify` says too
def test_a_law_outside_the_class_of_the_certificate_is_not_proved():
    result = concluded(exponent="1/2")
    assert result.verdict is Verdict.INCONCLUSIVE
    assert result.found.code is codes.NOT_LIPSCHITZ
    assert result.assumptions == ("p locally Lipschitz (m >= 1): fails, m = 0.5",)
    assert "note 5" in result.not_shown[0]


def test_without_damping_the_reason_is_that():
    result = concluded(damping="0")
    assert result.found.code is codes.UNDAMPED
    assert "zero eigenvalue is double" in result.statement
    assert result.assumptions == ("k > 0: fails, k = 0 exactly",)
    assert "note 5" not in result.not_shown[0]


@pytest.mark.parametrize("damping", ["2e-4", "0", "-1"])
def test_asymptotic_stability_is_never_claimed(damping):
    result = concluded(damping=damping)
    claimed = " ".join((result.statement, result.stationary_set, result.resting_place))
    assert "asymptotically stable" not in claimed
    assert not result.found.attracts


@pytest.mark.parametrize("load", [{"force": "sin(t)"}, {"body_force": "x"}])
def test_nothing_is_claimed_about_a_forced_motion(load):
    free, forced = concluded(), concluded(Scenario.parse(**load))
    assert "nothing is claimed" in forced.statement
    assert "nothing is claimed" not in free.statement
    assert any("forced motion" in row for row in forced.not_shown)
    assert not any("forced motion" in row for row in free.not_shown)


# a steady push g > 0 holds the rod against the obstacle at p(z) = g/A > 0, and zeta' = g/k - (A/k) p: neither the
# half-line nor a resting place at zeta(0) is right under load
@pytest.mark.parametrize("damping", ["2e-4", "0", "-1"])
@pytest.mark.parametrize("load", [{"force": 1}, {"body_force": "x"}])
def test_equilibria_and_resting_place_are_those_without_load(load, damping):
    free, forced = concluded(damping=damping), concluded(Scenario.parse(**load), damping=damping)
    assert forced.stationary_set == f"without load, {free.stationary_set}"
    assert forced.resting_place.startswith("none is claimed")
    assert (free.resting_place == "none is claimed") == (damping != "2e-4")


# k < -Z and m = 2: the linear gain that destabilises the sector is not the law of this rod, which E' = -k v(t,0)^2 >= 0
# is about
@pytest.mark.parametrize("exponent", ["1/2", "1", "2"])
@pytest.mark.parametrize("damping", ["-2e-4", "-5"])
def test_what_is_refuted_is_refuted_for_the_law_of_this_rod_too(damping, exponent):
    result = concluded(damping=damping, exponent=exponent)
    assert "no motion that starts with energy comes to rest" in result.statement
    assert result.headline.startswith("Some phi, time-invariant, in the sector [0, ")
    assert result.assumptions == ("k > 0: fails, decided from the exact value of k",)


def test_a_conclusion_has_no_truth_value():
    with pytest.raises(TypeError, match="three answers"):
        bool(concluded())


# The circle criterion of a rod with k = 10^12 Z, Z = 1.2 N s/m: in balls it holds for this scheme in [0, 1], as waves
# of 10 cells lose energy; the checker's bound (E/L) Z^2/(k^2 - Z^2) = 2.88e8/(10^24 - 1) serves any number of cells.
def test_a_circle_row_that_no_certificate_covers_says_where_certificates_end():
    scheme = scheme_of(damping=12 * 10**11)
    (row,) = checked_criteria(scheme, [rod_circle_criterion(scheme, Sector(0, 1))])
    assert row.verdict is Verdict.INCONCLUSIVE
    assert row.margin.low > 0.99
    assert "ends at the sector [0, 2.88e-16]; ask Popov's for more" in row.reason


def test_one_cell_is_not_called_one_cells():
    assert upwind(builtin_system("paper-rod").rod, 1).name == "the scheme with 1 cell"
