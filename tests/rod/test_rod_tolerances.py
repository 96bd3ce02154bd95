"""Rods with parameters in intervals: certificates for all of them, one rod that refutes, files and reports."""

import json
from fractions import Fraction
from importlib import resources
from itertools import product

import jsonschema
import pytest
from certificate_format import FORMAT

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.cli import main
from lure.analysis.questions.certify import certify
from lure.analysis.rod.certificates import circle_bound
from lure.analysis.rod.conclusion import conclusion
from lure.analysis.rod.theory import margins, stiffest_contact
from lure.analysis.rod.trajectories import simulate
from lure.analysis.verdict import Verdict
from lure.errors import InputError
from lure.files.reading import parse_system
from lure.rod import upwind
from lure.rod.family import RodFamily
from lure.rod.file import system_to_toml
from lure.rod.systems import paper_rod
from tests.support.tampering import assert_both_reject, edited

STEEL = """
[rod]
youngs_modulus = [200e9, 220e9]
density = 7850
length = 1
area = 1e-4
damping = [900, 1100]
compliance = [4e-14, 6e-14]
"""
WIDE = {
    "youngs_modulus": (Fraction(200 * 10**6), Fraction(300 * 10**6)),
    "area": (Fraction(2, 10**5), Fraction(3, 10**5)),
    "damping": (Fraction(1, 2), Fraction(3)),  # Z = 1.2 for the paper's rod: below and above
}


def system(text=STEEL):
    return parse_system(text, name="own", source="here")


def changed(old, new):
    return system(STEEL.replace(old, new))


@pytest.fixture(scope="module")
def proof():
    return certify(system()).certificate


def test_the_energy_theorem_is_about_every_rod_and_every_scheme(proof):
    FORMAT.validate(dict(proof))
    assert recheck(proof).accepted
    assert "E in [200000000000, 220000000000]" in check(dict(proof)).claim
    assert "k in [900, 1100]" in check(dict(proof)).claim
    found = conclusion(upwind(system().rod, 4), system().scenario, system().intervals)
    assert found.verdict is Verdict.PROVED
    assert [one.certificate["system"]["kind"] for one in found.certificates] == ["rod-family", "rod-scheme-family"]
    assert all(recheck(one.certificate).accepted for one in found.certificates)
    assert found.headline.endswith("for every E in [2e11, 2.2e11], k in [900, 1100].")


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("system", "parameters", 4, 1), "0"),
        (("system", "parameters", 4, 1), "-1"),
        (("system", "parameters", 4, 1), "1200"),
        (("system", "parameters", 0, 1), "0"),
        (("system", "parameters", 0, 0), "F"),
        (("system", "parameters", 1), ["rho", "7850"]),
        (("system", "parameters"), []),
        (("system", "kind"), "rod"),
        (("system", "kind"), "rod-scheme-family"),
        (("system", "cells"), 10),
        (("laws", "time_varying"), True),
        (("laws", "sector", 0), "-1"),
        (("theorem",), "rod-circle"),
        (("proof", "method"), "boxes"),
        (("rate",), "1"),
    ],
)
def test_neither_accepts_a_change(proof, path, value):
    assert_both_reject({**proof, path[0]: value} if len(path) == 1 else edited(proof, *path, value=value))


def test_one_rod_that_drives_refutes_and_a_damping_that_may_be_0_is_open():
    refuted = certify(changed("[900, 1100]", "[-100, 1100]"))
    assert refuted.verdict is Verdict.REFUTED
    FORMAT.validate(dict(refuted.certificate))
    assert recheck(refuted.certificate).accepted
    for at in (["210000000000", "7850", "1", "1/10000", "100"], ["210000000000", "7850", "1", "1/10000", "-101"]):
        assert_both_reject(edited(refuted.certificate, "proof", "at", value=at))
    assert certify(changed("[900, 1100]", "[0, 1100]")).verdict is Verdict.INCONCLUSIVE


# The largest time-varying stiffness, (E/L) min(k, Z)^2/|k^2 - Z^2|, of a box is the least of those of its corners, and
# that of no rod inside is smaller: by the closed form of each.
def test_the_stiffest_contact_is_that_of_the_worst_corner():
    family = RodFamily(paper_rod().replace(damping="1"), WIDE, 5)
    shown = stiffest_contact(family)
    corners = [
        family.rod.replace(**dict(zip(WIDE, ends, strict=True)))
        for ends in product(*((low, (2 * low + high) / 3, high) for low, high in WIDE.values()))
    ]
    least = min(circle_bound(rod) for rod in corners)
    K = Fraction(shown.certificate["laws"]["sector"][1])
    assert least * (1 - Fraction(1, 10**11)) < K < least
    assert recheck(shown.certificate).accepted
    FORMAT.validate(dict(shown.certificate))
    assert_both_reject(edited(shown.certificate, "laws", "sector", 1, value=str(least)))
    assert "any positive number" in margins(family)


# Popov: theta >= L |k/(A E) - rho A/k|, largest of the corners
def test_popovs_multiplier_is_that_of_the_worst_corner():
    family = RodFamily(paper_rod().replace(damping="1"), WIDE, 5)

    def needed(E, A, k):
        return abs(k / (A * E) - 8 * A / k)

    most = max(needed(*ends) for ends in product(*WIDE.values()))
    draft = {**stiffest_contact(family).certificate, "theorem": "rod-popov"}
    draft["laws"] = {**draft["laws"], "time_varying": False, "sector": ["0", "1000000000000"]}
    found = complete_and_check({**draft, "multiplier": {"theta": str(most)}})
    assert recheck(found.certificate).accepted
    with pytest.raises(Rejected, match="theta"):
        complete_and_check({**draft, "multiplier": {"theta": str(most * Fraction(999, 1000))}})
    assert_both_reject(edited(found.certificate, "multiplier", "theta", value=str(most * Fraction(999, 1000))))


def test_a_file_reads_back_with_its_intervals_and_one_of_a_point_is_a_number():
    again = parse_system(system_to_toml(system()), name="own", source="here")
    assert again.intervals == system().intervals
    assert not changed("[900, 1100]", "[1000, 1000]").intervals.get("damping")
    assert "[900, 1100]" in system()._repr_html_()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[900, 1100]", "[1100, 900]", "the smaller number first"),
        ("[900, 1100]", "[900]", "an interval"),
        ("[4e-14, 6e-14]", "[0, 6e-14]", "positive numbers"),
        ("compliance", "exponent = 0.5\ncompliance", "at least 1"),
        ("length = 1", "length = 1\ngap = [0, 1]", "gap"),
    ],
)
def test_what_is_no_interval_is_refused_in_a_sentence(old, new, said):
    with pytest.raises(InputError, match=said):
        changed(old, new)


def test_what_is_asked_of_one_rod_is_refused(tmp_path, capsys):
    with pytest.raises(InputError, match="give each one number"):
        simulate(system())
    path = tmp_path / "rods.toml"
    path.write_text(STEEL)
    assert main(["simulate", str(path)]) == 2
    assert "lure certify and lure report alone" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
def test_the_report_says_it_of_all_rods(tmp_path, capsys):
    path = tmp_path / "rods.toml"
    path.write_text(STEEL + "[discretisation]\ncells = 3\n[simulation]\nuntil = 0.0005\n")
    assert main(["report", str(path), "-o", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "k in [900, 1100]" in said
    assert "the rod in the middle of the intervals" in said
    document = json.loads((tmp_path / "out" / "report.json").read_text("utf-8"))
    schema = resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8")
    jsonschema.Draft202012Validator(json.loads(schema)).validate(document)
    assert document["system"]["intervals"]["damping"] == ["900", "1100"]
