"""One answer everywhere: verdict, class and number in JSON, text, page, table, dataset and certificates agree.

The class and the numbers are read off the certificates by this file, not by the functions that word them.
"""

import math
import re
from fractions import Fraction
from functools import cache
from html import unescape

import pytest
from markupsafe import Markup
from pages import page_with_its_data
from reports import loop_report, rod_report

from lure import StateSpace
from lure.analysis import analyse, max_sector, max_slope
from lure.analysis.certificates.refutations import growing_gain
from lure.analysis.report.loop.write import loop_page
from lure.analysis.rod.report import claims
from lure.analysis.rod.report.document import document
from lure.analysis.rod.report.output import page
from lure.analysis.verdict import Verdict
from lure.analysis.wording import same_in
from lure.files import parse_system
from lure.files.builtin import builtin_loop, loop_names
from lure.rod import builtin_system
from lure.rod.systems import rod_from_exact
from lure.rod.transfer import RodPlant

SEARCHED = {"ct-3", "ct-4", "ct-5", "ct-6", "ct-7", "dt-1", "dt-2", "dt-3", "dt-5", "dt-6", "integrator-lead"}
SEARCHED |= {"fetzer-scherer", "kalman-fitts", "leonov-bragin-kuznetsov", "veenman-scherer-koroglu"}  # seconds each
LONG = SEARCHED - {"dt-5", "integrator-lead"}  # more than two; dt-6 is among the files above
LONG |= {"ct-1", "iqc-odd-slope", "iqc-resonance", "three-lags", "triple-lag"}  # of the kind of 1/(s+1)^3 in FILES
SEARCHED |= {"biproper", "secant-ring", "between", "rough", "slope", "late"}  # "odd" and "checked" are such; dead time
LAW = '[nonlinearity]\nkind = "{}"\n{}\n'
DT_6 = '[plant]\ntransfer = "(2*z+0.92)/(z^2-0.5*z)"\ndt = 1\n[class]\n'
FILES = {
    "checked": '[plant]\ntransfer = "1/(s+1)^3"\n' + LAW.format("tanh", "gain = 3\nscale = 0.5"),
    "declared": '[plant]\ntransfer = "(s+2)/(s+1)"\n'
    + LAW.format("expression", 'expression = "tanh(sigma)"\nsector = [0, 2]'),
    "rough": '[plant]\ntransfer = "1/(s+1)^3"\n' + LAW.format("quantiser", "step = 1"),
    "rough and sampled": '[plant]\ntransfer = "0.5/(z-0.5)"\ndt = 0.1\n' + LAW.format("quantiser", "step = 1"),
    "zero only": '[plant]\ntransfer = "1/(s*(s+1)*(s+2))"\n' + LAW.format("saturation", "gain = 3\nlimit = 1"),
    "odd": '[plant]\ntransfer = "1/(s+1)^3"\n[class]\nsector = [0, 3]\nslope = [0, 3]\nodd = true\n',
    "slope": '[plant]\ntransfer = "1/(s+1)^3"\n[class]\nsector = [0.5, 3]\nslope = [0.5, 3]\n',
    "third": '[plant]\ntransfer = "4/((s-1)*(s/3+1))"\n[class]\nsector = ["1/3", 0.9]\ntime_varying = true\n',
    "beyond": '[plant]\ntransfer = "1/(s*(s+1)*(s+2))"\n[class]\nsector = [0, 7]\n',
    "between": '[plant]\ntransfer = "1/(s+1)^3"\n[class]\nsector = [0, 5.78]\ntime_varying = true\n',
    # slopes up to 0.91 for monotone phi, refuted from there on, and up to 1.08 for odd ones; the sector ends before 0.9
    "odd alone": f"{DT_6}sector = [0, 1]\nslope = [0, 1]\nodd = true\n",
    "odd not promised": f"{DT_6}sector = [0, 1]\nslope = [0, 1]\n",
    "late": '[plant]\ntransfer = "exp(-s)/(s+1)"\n[class]\nsector = [0, 1]\n',
    "matrices": "[plant]\nA = [[-1, 1], [0, -2]]\nB = [0, 1]\nC = [1, 0]\n[class]\nsector = [0, 1]\n",
    "endless": '[plant]\ntransfer = "(s+1)/(s*(s+2))"\n[class]\nsector = [0, inf]\n',
}
SEVERAL = {name for name in loop_names() if builtin_loop(name).classes is not None}
LOOPS = [
    pytest.param(name, marks=[pytest.mark.slow] * (name in SEARCHED) + [pytest.mark.thorough] * (name in LONG))
    for name in (*FILES, *loop_names())
]
RODS = {"proved": {}, "pushed": {"damping": "-2e-4"}, "free": {"damping": "0"}, "bent": {"exponent": "3/2"}}
RODS |= {"rough": {"exponent": "1/2"}, "matched": {"damping": "1.2"}}


class Told:
    """A loop as it is told: the object, the JSON, the text, the page, its numbers by key."""

    def __init__(self, name):
        loop = parse_system(FILES[name], name=name, source="a file") if name in FILES else builtin_loop(name)
        self.found = analyse(loop)
        report = loop_report(self.found)
        self.data, self.text = report.to_dict(), " ".join(str(report).split())
        self.lines = str(report).splitlines()
        self.page = loop_page(self.data, (), Markup(""))
        self.words = plain(self.page)
        self.numbers = {key: (value, plain(text)) for value, key, text in NUMBER.findall(self.page)}


NUMBER = re.compile(r'<data value="([^"]*)" data-key="([^"]*)"[^>]*>(.*?)</data>', re.DOTALL)
told = cache(Told)


def plain(text):
    """The words of a page in the signs of the JSON."""
    text = re.sub(r"<(style|svg)\b.*?</\1>", "", text, flags=re.DOTALL)
    text = re.sub(r" × 10<sup>(.*?)</sup>", r"e\1", text)
    text = unescape(re.sub(r"<[^>]+>", " ", text))
    for sign, letters in {"φ": "phi", "∞": "inf", "−": "-", "\N{NO-BREAK SPACE}": " ", "σ": "sigma", "±": "+-"}.items():
        text = text.replace(sign, letters)
    text = re.sub("phi([₀-₉]+)", lambda found: f"phi_{''.join(str(ord(c) - 0x2080) for c in found[1])}", text)
    return " ".join(text.split())


def exact(end):
    return {"inf": math.inf, "finite": math.inf, "-inf": -math.inf}.get(end) or Fraction(end)


def intervals(text):
    """Every interval of a text, its ends as numbers, and how it closes."""
    found = re.findall(r"\[([^\s,\[\]]+), ([^\s,\[\]()]+)([\])])", text)
    return [(exact(low), exact(high), closing) for low, high, closing in found]


def near(value, other):
    """Equal to the digits that are printed."""
    return value == other or (math.isfinite(value) and abs(value - other) <= 2e-6 * max(abs(value), abs(other)))


def is_class(text, nonlinearities, *, inside):
    """Whether a text names the class of a certificate, its bounds rounded into it or out of it."""
    if "channels" in nonlinearities:
        parts, first = text.split("; "), [block[0] for block in same_in(nonlinearities)]
        for part, i in zip(parts, first, strict=True):
            assert f"phi_{i + 1}" in part
            is_class(part, nonlinearities["channels"][i], inside=inside)
        return
    assert ("odd " in text) == nonlinearities["odd"]
    assert ("time-varying" in text) == nonlinearities["time_varying"]
    assert ("slope in" in text) == (nonlinearities["slope"] is not None)
    assert ("continuous or not" in text) == (nonlinearities.get("regularity") == "any")
    assert ("linear" in text) == nonlinearities["linear"]
    (low, high, closing), ends = intervals(text)[0], nonlinearities["slope"] or nonlinearities["sector"]
    assert (closing == ")") == (ends[1] == "finite")
    true_low, true_high = map(exact, ends)
    assert near(low, true_low)
    assert near(high, true_high)
    assert (low >= true_low and high <= true_high) if inside else (low <= true_low and high >= true_high)


# loops ----------------------------------------------------------------------------------------------------------------


@pytest.mark.slow_for("checked", "matrices", "odd alone", "odd not promised", "odd")
@pytest.mark.parametrize("name", LOOPS)
def test_the_verdict_and_the_class_are_those_of_the_certificate_everywhere(name):
    loop = told(name)
    conclusion, shown = loop.data["conclusion"], loop.found.shown
    verdict = conclusion["verdict"]
    assert loop.text.split()[0] == verdict == str(loop.found.verdict)
    assert f'class="badge {verdict}"' in loop.page
    assert loop.found.to_xarray().attrs["verdict"] == verdict
    assert conclusion["statement"].startswith(conclusion["headline"][:-1])
    assert conclusion["statement"].replace(" ", "") in loop.text.replace(" ", "")  # lines may end at a hyphen
    assert conclusion["statement"] in unescape(loop.found._repr_html_())
    assumed = conclusion["membership"] != "checked" or " for which " in conclusion["law_class"]
    assert bool(conclusion["assumed"]) >= (" for which " in conclusion["law_class"])
    head = conclusion["headline" if assumed else "meaning"]
    assert plain(re.search(r"<h1.*?</h1>", loop.page, re.DOTALL)[0]).rstrip(".") == plain(head).rstrip(".")
    assert loop.data["system"]["class"] is None or near_class(loop.data["system"]["class"], loop.found.problem.given)
    if shown is None:
        assert verdict == "INCONCLUSIVE"
        assert conclusion["reason"] in conclusion["statement"]
        assert conclusion["code"] in conclusion["statement"]
        assert conclusion["law_class"] == conclusion["meaning"] == ""
        return
    certificate = shown.certificate
    assert certificate["verdict"] == verdict == loop.data["certificates"][0]["verdict"]
    assert conclusion["code"] is None
    is_class(conclusion["law_class"], certificate["laws"], inside=verdict == "PROVED")
    assert conclusion["law_class"].partition(" for which")[0] in conclusion["statement"]
    if verdict == "PROVED":
        said = certificate["conclusion"]
        stated = conclusion["meaning"].lower().removeprefix("the point ").replace("solution", "motion")
        zero_only = (
            said == "every motion converges to the set of equilibria" and stated == "every motion converges to 0"
        )
        assert stated == said or zero_only
        assert conclusion["attracts"] == (said.startswith("0 attracts") or zero_only)


def near_class(data, nonlinearity_class):
    """Whether the class in the JSON is the one asked about."""
    pairs = [(data["sector"], nonlinearity_class.sector), (data["slope"], nonlinearity_class.slope)]
    ends = all(
        (one is None) == (other is None)
        and (one is None or list(map(float, one)) == [float(other.lower), float(other.upper)])
        for one, other in pairs
    )
    return ends and (data["odd"], data["time_varying"]) == (nonlinearity_class.odd, nonlinearity_class.time_varying)


@pytest.mark.parametrize("name", LOOPS)
def test_every_answer_is_a_page_and_plain_data(name):
    rows = told(name).found.rows
    pages = [page_with_its_data(row) for row in rows]
    assert len(pages) > 0
    assert all(text.startswith(f"{row.verdict} ") and str(row) in text for row, text in zip(rows, pages, strict=True))


@pytest.mark.parametrize("name", [one for one in LOOPS if one.values[0] not in SEVERAL])
def test_the_smaller_a_class_the_farther_it_is_proved(name):
    rows = {(row.question, row.odd, row.time_varying): row for row in told(name).found.rows}
    classes = [("sector", False, True), ("sector", False, False), ("slope", False, False), ("slope", True, False)]
    ends = [rows[one].largest.low if rows[one].verdict is Verdict.PROVED else -math.inf for one in classes]
    refuted = [rows[one].refuted_at or math.inf for one in classes]
    assert ends == sorted(ends)
    assert refuted == sorted(refuted)


@pytest.mark.parametrize("name", [one for one in LOOPS if one.values[0] not in SEVERAL])
def test_every_row_says_what_its_certificates_say_everywhere(name):
    loop = told(name)
    table = loop.found.to_xarray()
    head = next(i for i, line in enumerate(loop.lines) if line.startswith("class "))
    cells = [re.split(r"\s{2,}", line) for line in loop.lines[head + 1 : head + 5]]
    assert len(loop.found.rows) == len(loop.data["answers"]) == len(cells) == 4
    kinds = {("sector", False, True), ("sector", False, False), ("slope", False, False), ("slope", True, False)}
    assert {(row["question"], row["odd"], row["time_varying"]) for row in loop.data["answers"]} == kinds
    for i, (row, data, cell) in enumerate(zip(loop.found.rows, loop.data["answers"], cells, strict=True)):
        proved = data["verdict"] == "PROVED"
        assert cell[0] == data["question"] + ", odd" * data["odd"] + ", time-varying" * data["time_varying"]
        assert table["law_class"].values[i] == cell[0]
        assert table["verdict"].values[i] == data["verdict"]
        key, low = f"answers.{i}.largest.0", float(data["largest"][0])
        if proved:
            nonlinearities = row.proof.certificate["laws"]
            at_least_that_class(nonlinearities, data, row.lower)
            top, said = exact(nonlinearities["sector"][1]), exact(data["proved_text"])
            assert Fraction(low) <= top if math.isfinite(low) else top == math.inf
            assert said <= top
            assert near(said, low)
            assert near(low, top)
            assert cell[2].partition(",")[0] == data["proved_text"]
            assert cell[3] == data["evidence"] == "certified"
            assert table["proved_up_to"].values[i] == low
            assert key not in loop.numbers or loop.numbers[key] == (repr(low), data["proved_text"])
            assert (key in loop.numbers) == math.isfinite(low)
        else:
            assert cell[1:4] == ["-"] * 3
            assert math.isnan(table["proved_up_to"].values[i])
            assert data["proved_text"] == ""
            assert key not in loop.numbers
        refuted, key = data["refuted_at"], f"answers.{i}.refuted_at"
        assert cell[4] == (data["refuted_text"] or "-")
        assert cell[6] == data["gap"]
        assert table["closed"].values[i] == data["closed"] == (data["gap"] == "closed")
        assert data["closed"] == (low == math.inf or (refuted is not None and low >= refuted * (1 - 1e-6)))
        if refuted is None:
            assert (row.refutations, data["refuted_text"], data["witness"]) == ((), "", None)
            continue
        assert refuted == table["refuted_at"].values[i]
        assert loop.numbers[key] == (repr(refuted), data["refuted_text"])
        assert not proved or low < refuted
        one = min(row.refutations, key=lambda shown: exact(shown.certificate["laws"]["sector"][1]))
        smallest = exact(one.certificate["laws"]["sector"][1])
        assert refuted >= data["lower"]
        if data["verdict"] != "REFUTED":
            assert near(refuted, smallest)
            assert smallest <= exact(data["refuted_text"])
            assert near(exact(data["refuted_text"]), smallest)
        for shown in row.refutations:
            nonlinearities = shown.certificate["laws"]
            assert not nonlinearities["time_varying"] or data["time_varying"]
            assert nonlinearities["odd"] or not data["odd"]
            assert nonlinearities["slope"] is not None or data["question"] == "sector"
            assert Fraction(nonlinearities["sector"][0]) >= row.lower


def at_least_that_class(nonlinearities, data, lower):
    """Whether what is proved about these nonlinearities covers the classes of a row."""
    assert nonlinearities["time_varying"] or not data["time_varying"]
    assert data["odd"] or not nonlinearities["odd"]
    assert data["question"] == "slope" or nonlinearities["slope"] is None
    assert exact(nonlinearities["sector"][0]) <= lower


@pytest.mark.parametrize("name", LOOPS)
def test_the_certificates_are_listed_once_each_with_what_they_claim(name):
    loop = told(name)
    listed = loop.data["certificates"]
    assert [one["claim"] for one in listed] == [shown.claim for shown in loop.found.certificates]
    accepted = [row.answers for row in loop.found.rows]
    proofs = {repr(one.proof.certificate) for answers in accepted for one in answers if one.proof is not None}
    refuted = {repr(one.certificate) for row in loop.found.rows for one in row.refutations}
    own = {repr(loop.found.shown.certificate)} if loop.found.shown is not None else set()
    assert {repr(one.certificate) for one in loop.found.certificates} == proofs | refuted | own
    assert len(listed) == len(proofs | refuted | own)
    for answers in accepted:
        for one in answers:
            assert (one.proof is not None) == (str(one.verdict) == "PROVED")


@pytest.mark.parametrize("name", [one for one in LOOPS if one.values[0] in FILES])
def test_the_verdicts_are_these(name):
    others = {"beyond": "REFUTED", "odd not promised": "REFUTED", "rough": "INCONCLUSIVE", "between": "INCONCLUSIVE"}
    assert name == "endless" or str(told(name).found.verdict) == others.get(name, "PROVED")


# one question -------------------------------------------------------------------------------------------------------


@pytest.mark.slow_for("True", "False-0")
@pytest.mark.parametrize("lower", [0, Fraction(1, 3)])
@pytest.mark.parametrize("varying", [False, True])
def test_the_largest_sector_is_told_as_its_certificate_has_it(varying, lower):
    # 1/(s+1)^3: gains from 0 up to 8; the circle and Popov reach 4 and 8
    assert_one_answer(max_sector("1/(s+1)^3", time_varying=varying, lower=lower))


@pytest.mark.parametrize("odd", [False, True])
def test_the_largest_slope_is_told_as_its_certificate_has_it(odd):
    assert_one_answer(max_slope("1/(s+1)^3", odd=odd))


def test_where_every_gain_destabilises_no_class_is_refuted_but_those_of_the_certificate():
    # -1/(s (s + 1)), s^2 + s - g: unstable for every g > 0, while with 0 itself its solutions converge to equilibria
    found = max_sector("-1/(s*(s+1))")
    sector = found.refutation.certificate["laws"]["sector"]
    assert (str(found.verdict), sector[0]) == ("REFUTED", "0")
    assert 0 < exact(sector[1]) <= Fraction(found.refuted_at) == Fraction(found.to_dict()["refuted_at"])
    assert (found.closed, found.gap) == (False, "open")
    assert "in the sector [0, k], whatever k >= 0.001; phi = " in str(found)


@pytest.mark.parametrize("plant", ["4/((s-1)*(s/3+1))", "(s+1)/s^2"])
def test_what_is_never_stable_is_told_so(plant):
    found = max_sector(plant)
    assert str(found.verdict) == found.to_dict()["verdict"] == "REFUTED"
    assert str(found).startswith("Not stable for phi, time-invariant, in the sector [0, k], whatever k > 0")
    assert found.refutation.certificate["proof"]["gain"] == "0"
    row = table_of(found)
    assert (row["proved up to k ="], row["why"]) == ("nothing is proved", found.reason or "-")
    assert (row["evidence"], row["refuted from k ="]) == ("certified", "0")
    assert "phi = 0" in row["refuted by"]


@pytest.mark.parametrize(
    ("damping", "ends"), [("2e-4", (math.inf, math.inf)), ("0", (0, math.inf)), ("-1", (0, math.inf))]
)
def test_every_linear_gain_is_stable_for_a_rod_that_is_damped_and_unknown_for_another(damping, ends):
    paper = builtin_system("paper-rod").rod
    block = RodPlant(rod_from_exact({**paper.exact, "damping": Fraction(damping)}))
    found = max_sector(block, criterion="popov")
    assert (found.hurwitz.low, found.hurwitz.high) == ends
    assert table_of(found)["linear gains"] == ("stable up to inf" if ends[0] else "-")


def test_a_gain_that_the_checker_refuses_is_no_counterexample(monkeypatch):
    # 1/(s+1)^3 in Jordan's form: with the gain k the roots of (s+1)^3 = -k, on the axis for k = 8, to its right beyond
    block = StateSpace([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, -1.0]], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    found = growing_gain(block, Fraction(0))
    assert 8 <= found.k < 8.1
    assert found.refutation.certificate["verdict"] == "REFUTED"
    growing_gain.cache_clear()

    def refusing(block, witness):
        raise ArithmeticError("refused")

    monkeypatch.setattr("lure.analysis.certificates.refutations._settled", refusing)
    assert growing_gain(block, Fraction(0)) is None
    growing_gain.cache_clear()


def table_of(found):
    """The cells of an answer's table by their names."""
    rows = re.findall(r"<tr>(.*?)</tr>", found._repr_html_().partition("</table>")[0], re.DOTALL)
    cells = [[plain(cell) for cell in re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row, re.DOTALL)] for row in rows]
    return {cell[0]: cell[1] for cell in cells}


def assert_one_answer(found):
    data, nonlinearities, table = found.to_dict(), found.proof.certificate["laws"], found.to_xarray()
    assert data["verdict"] == table.attrs["verdict"] == str(found.verdict) == "PROVED"
    is_class(str(found), nonlinearities, inside=True)
    top = exact(nonlinearities["sector"][1])
    assert found.largest.low <= top <= found.largest.high
    assert near(found.largest.low, top)
    assert exact(found.proved_text) <= top
    assert data["largest"] == [found.largest.low, found.largest.high]
    assert table["low"].values[0] == found.largest.low
    row = table_of(found)
    assert (row["proved up to k ="], row["refuted from k ="]) == (found.proved_text, found.refuted_text)
    assert row["proved by"].partition(",")[0] == found.criterion == found.proof.theorem
    assert (row["evidence"], row["in a sentence"]) == ("certified", plain(str(found)))
    assert near(exact(row["linear gains"].removeprefix("stable up to ")), Fraction(8))


# rods -----------------------------------------------------------------------------------------------------------------


@cache
def rod(name):
    return rod_report(RODS[name], cells=10)


@pytest.mark.parametrize("name", RODS)
def test_a_rod_is_told_as_its_certificates_have_it(name):
    report = rod(name)
    data, shown = document(report), plain(page(document(report), claims(report), ()))
    conclusion, text = data["conclusion"], " ".join(str(report).split())
    verdict = {"pushed": "REFUTED", "free": "INCONCLUSIVE", "rough": "INCONCLUSIVE"}.get(name, "PROVED")
    assert conclusion["verdict"] == verdict == text.split()[0] == str(report.verdict)
    assert f"{verdict} · paper-rod · stability report" in shown
    assert conclusion["statement"] in text
    assert plain(conclusion["headline"]) in shown
    if verdict != "INCONCLUSIVE":
        kinds = [one.certificate["system"]["kind"] for one in report.certificates]
        assert {"rod", "rod-scheme"} <= set(kinds)
        first = report.certificates[0].certificate
        assert first["verdict"] == verdict
        is_class(conclusion["law_class"], first["laws"], inside=verdict == "PROVED")
        assert conclusion["law_class"] in conclusion["statement"]
    energy = [one for one in report.certificates if one.theorem == "rod-energy"]
    assert len(energy) == (2 if verdict == "PROVED" else 0)
    rows = claims(report)
    stated = {
        row.answer for row in rows if "motion" in row.text and row.evidence is not None and "compared" not in row.text
    }
    assert stated == ({"PROVED"} if verdict == "PROVED" else set())
    # without damping the rod flies away at any speed: a double zero; with k != 0 the residue at zero is A/k, simple
    zero = next(row for row in rows if "zero eigenvalue" in row.text)
    assert zero.text == f"the zero eigenvalue is {'double' if name == 'free' else 'simple'}"
    assert zero.answer == ("checked" if name in ("free", "pushed") else "PROVED")
    assert data["spectrum"]["zero_multiplicity"] == (2 if name == "free" else 1)


def cells_of(html):
    """The rows of the tables of a page, cell by cell, in plain words."""
    rows = re.findall(r"<tr.*?</tr>", html, re.DOTALL)
    return [[plain(cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row, re.DOTALL)] for row in rows]


@pytest.mark.parametrize("name", RODS)
def test_a_rod_in_a_notebook_says_of_each_criterion_what_its_json_says(name):
    report = rod(name)
    shown = [row[:4] for row in cells_of(report._repr_html_())[1:5]]
    rows = document(report)["criteria"]
    assert [row[:3] for row in shown] == [[row["name"], row["model"], row["verdict"]] for row in rows]
    # without damping nothing is decided of any criterion, and nothing stands on evidence
    assert {row[3] for row in shown} == {"-" if name == "free" else "certified"}


def test_a_claim_about_the_exact_motion_names_what_was_compared():
    # with 0 < k everything is compared; with k <= 0 there is neither a Lyapunov functional nor a resting place
    for name, last in (
        ("proved", "Lyapunov functional, zeta, resting place"),
        ("pushed", "energy"),
        ("free", "energy"),
    ):
        said = next(row for row in claims(rod(name)) if row.text.startswith("exact motion"))
        assert said.text.endswith(f"compared: energy balance, {'energy, ' if name == 'proved' else ''}{last}")
        assert said.answer == "agrees"


# k > 0 and m >= 1 are decided from exact values; load, data, wave equation and class are the user's word
@pytest.mark.parametrize(
    ("name", "assumed", "fails"), [("proved", 4, 0), ("bent", 4, 0), ("pushed", 0, 1), ("free", 0, 1), ("rough", 0, 2)]
)
def test_each_hypothesis_of_a_rod_is_shown_as_checked_assumed_or_failing(name, assumed, fails):
    report = rod(name)
    shown = page(document(report), claims(report), ())
    stated = [row for row in cells_of(shown) if row and row[0] in ("checked", "assumed", "fails")]
    assert [sum(row[0] == status for row in stated) for status in ("assumed", "fails")] == [assumed, fails]
    for status, *rest in stated:
        words = " ".join(rest)
        assert (status == "fails") == bool(re.search(r"k > 0: fails|Lipschitz.*fails", words))
        assert (status == "checked") == bool(re.search(r": checked|bounded below", words)) or status == "fails"


@pytest.mark.parametrize("name", RODS)
def test_the_numbers_of_a_rods_criteria_are_safe_to_quote_and_the_same_everywhere(name):
    report = rod(name)
    data, lines = document(report), str(report).splitlines()
    head = next(i for i, line in enumerate(lines) if line.split()[:2] == ["criterion", "model"])
    cells = [line.split() for line in lines[head + 1 : head + 5]]
    numbers = {key: (value, plain(text)) for value, key, text in NUMBER.findall(page(data, claims(report), ()))}
    for i, (result, row, cell) in enumerate(zip(report.criteria, data["criteria"], cells, strict=True)):
        assert (
            cell[:3]
            == [row["name"], row["model"], row["verdict"]]
            == [result.criterion, result.model, str(result.verdict)]
        )
        assert (result.shown is None) == (row["verdict"] == "INCONCLUSIVE")
        if result.shown is not None:
            assert result.shown.certificate["verdict"] == row["verdict"]
            assert result.shown.certificate["laws"]["time_varying"] == (
                row["name"] == "circle" and row["verdict"] == "PROVED"
            )
            kind = "rod" if row["model"] == "rod" else "rod-scheme"
            assert result.shown.certificate["system"]["kind"] == kind
        whys = f"In the {result.model}, {result.reason}." in " ".join(str(report).split())
        assert whys == (result.theta is None) == (row["theta"] is None)
        if row["margin"] is None:
            continue
        low, high = row["margin_bracket"]
        assert (row["margin"], row["smallest_theta"]) == (low, (row["smallest_theta_bracket"] or [0, None])[1])
        said = [f"{float(value):.4g}" for value in (row["theta"], low, row["largest_sector"][0])]
        assert cell[4:] == said
        if row["verdict"] == "PROVED":
            assert numbers[f"criteria.{i}.margin"][0] == repr(low)
            printed = Fraction(numbers[f"criteria.{i}.margin"][1])
            assert printed <= Fraction(low)
            assert printed >= Fraction(low) * Fraction(999, 1000)
            assert low <= high
