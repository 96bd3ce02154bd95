"""Both checkers on the same files, valid and invalid ones drawn at random: they must agree, and in good time."""

import json

import pytest
from certificate_family import DISCRETE, LAG_1, OSCILLATOR, THIRD, draft, nonlinearities, transfer
from depth import sampled
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tampering import refused_again

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.blocks import block
from lure.analysis.certificates.checker import check, inequality, polynomial_proof, unbounded
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.second import opinion as apart
from lure.analysis.certificates.second import recheck, recheck_apart
from lure.analysis.certificates.second.classes import ATTRACTS, BOUNDED, EQUILIBRIA
from lure.analysis.certificates.second.reading import OUT_OF_TIME
from lure.analysis.certificates.states import SOLVABLE, classes

ANY_BOX = {"method": "cover", "boxes": [["0", "1"]], "order": 7}  # the second checker decides polynomials by itself
PLANTS = (THIRD, OSCILLATOR, LAG_1, transfer("1 2", "1 1"), transfer("-1", "1 1"), transfer("2 -1 0", "1 2 2 1"))
SAMPLED = (DISCRETE, transfer("1", "1 -1", "discrete"), transfer("1/2 1", "1 -1/2", "discrete"))
LOWER, UPPER = ("-inf", "-2", "-1/4", "0", "1/3", "33"), ("-1/8", "0", "1/2", "29/10", "4", "33", "finite", "inf")
TAME = (("0",), ("1/4", "1/2", "3/4", "6/5", "29/10"))
QUARTERS = st.integers(-8, 8).map(lambda n: f"{n}/4")
SMALL = st.sampled_from(["0", "1/4", "1/2", "1/2", "3/4", "-1/4"])


def first(asked):
    """The certificate that the first checker accepts; None for none."""
    try:
        return completed(asked)
    except (Malformed, Rejected):
        return None


def written(asked):
    """The polynomial as the first checker builds it, which a file in discrete time has to show."""
    name, data = asked["theorem"], asked["multiplier"]
    try:
        given = classes(asked["laws"])
        F, _, critical, _ = inequality(name, data, block(asked["system"]), given)
        return polynomial_proof(F, critical=critical, bounded=not unbounded(name, data, given))
    except (Malformed, Rejected):
        return ANY_BOX


def second(asked):
    """Whether the second checker accepts the claim with any of the conclusions, on no other ground than its own."""
    base = {"format": "lure-certificate/1", "convention": "sigma = H mu, mu = -phi(sigma)", "numbers": "rationals"}
    given = {
        **base,
        "law": None,
        "hypotheses": {"solvable": SOLVABLE},
        **asked,
        "proof": written(asked) if asked["system"]["time"] == "discrete" else ANY_BOX,
    }
    return any(recheck({**given, "conclusion": end}).accepted for end in (ATTRACTS, EQUILIBRIA, BOUNDED))


@st.composite
def drafts(draw):
    """A theorem, a multiplier and a class for a plant, such as may hold, and then often one thing that is wild."""
    theorem = draw(
        st.sampled_from(
            ["circle", "popov", "off-axis-circle", "park", "zames-falb", "tsypkin", "tsypkin-odd", "jury-lee"]
        )
    )
    discrete = theorem in ("tsypkin", "tsypkin-odd", "jury-lee") or (
        theorem in ("circle", "zames-falb") and draw(st.booleans())
    )
    system = draw(st.sampled_from(SAMPLED if discrete else PLANTS))
    wild = draw(st.sampled_from(["nothing", "nothing", "multiplier", "sector", "slope", "flags"]))
    size = QUARTERS if wild == "multiplier" else SMALL
    kernel = {
        "coefficient": draw(size),
        "rate": "2",
        "order": 2,
        "side": draw(st.sampled_from(["causal", "anticausal"])),
    }
    multiplier = {
        "circle": {"mirrored": True} if wild == "multiplier" else {},
        "popov": {"theta": draw(size)},
        "off-axis-circle": {"alpha": draw(size)},
        "park": {"theta": draw(size), "tau": draw(size)},
        "zames-falb": {"taps": [[1, draw(size)]]} if discrete else {"theta": draw(size), "kernels": [kernel]},
        "tsypkin": {"q": draw(size)},
        "tsypkin-odd": {"q": draw(size)},
        "jury-lee": {"q": draw(size)},
    }[theorem]
    lower, upper = (LOWER, UPPER) if wild == "sector" else TAME
    sector = [draw(st.sampled_from(lower)), draw(st.sampled_from(upper))]
    slope = [draw(st.sampled_from(LOWER)), draw(st.sampled_from(UPPER))] if wild == "slope" else sector
    if theorem in ("circle", "popov") and wild != "slope" and draw(st.booleans()):
        slope = None
    odd, varying = draw(st.booleans()), wild == "flags" and draw(st.booleans())
    return draft(system, nonlinearities(*sector, slope=slope, odd=odd, time_varying=varying), theorem, multiplier)


@pytest.mark.slow
@settings(max_examples=sampled(60, of=150))
@example(draft(LAG_1, nonlinearities("33", "inf", slope=["-1", "5"]), "circle", {}))
@example(draft(OSCILLATOR, nonlinearities(0, "29/10", slope=True), "off-axis-circle", {"alpha": "0"}))
@example(
    draft(transfer("-1", "1 1"), nonlinearities("-inf", "1/2", slope=["-1", "finite"]), "circle", {"mirrored": True})
)
@given(drafts())
def test_both_checkers_accept_the_same_claims(asked):
    accepted = first(asked)
    assert second(asked) is (accepted is not None)
    if accepted is not None:
        assert recheck(json.dumps(accepted)).accepted  # the very file, as the first one wrote it


def test_a_class_without_a_law_proves_nothing():
    # phi(sigma)/sigma >= 33 and a slope of at most 5 exclude each other: phi(0) = 0
    empty = draft(LAG_1, nonlinearities("33", "inf", slope=["-1", "5"]), "circle", {})
    assert not second(empty)
    assert second({**empty, "laws": nonlinearities("33", "inf", slope=["-1", "33"])})  # phi = 33 sigma
    assert second({**empty, "laws": nonlinearities("33", "inf")})


def test_an_off_axis_line_through_the_real_axis_is_the_circle_criterion():
    shown = completed(draft(OSCILLATOR, nonlinearities(0, "29/10", slope=True), "off-axis-circle", {"alpha": "0"}))
    assert shown["proof"]["variable"] == "omega^2"
    assert recheck(shown).accepted
    assert refused_again({**shown, "multiplier": {"alpha": "1"}})


def test_the_mirrored_circle_asks_nothing_of_the_slopes():
    given = nonlinearities("-inf", "1/2", slope=["-1", "finite"])
    shown = completed(draft(transfer("-1", "1 1"), given, "circle", {"mirrored": True}))
    assert recheck(shown).accepted
    assert refused_again({**shown, "laws": nonlinearities("-inf", "finite", slope=["-1", "finite"])})


# the time allowed


def long_file(count, order):
    """Kernels with as many poles of that order: a polynomial of degree 2 count order + 4."""
    kernels = [
        {"coefficient": f"1/{2 * count}", "rate": f"{n + 2}/{n + 1}", "order": order, "side": "causal"}
        for n in range(count)
    ]
    asked = draft(OSCILLATOR, nonlinearities(0, 1, slope=True), "zames-falb", {"theta": "0", "kernels": kernels})
    base = {"format": "lure-certificate/1", "convention": "sigma = H mu, mu = -phi(sigma)", "numbers": "rationals"}
    return {**base, "law": None, "hypotheses": {}, "conclusion": ATTRACTS, **asked, "proof": ANY_BOX}


def test_many_kernels_are_added_by_halves():
    assert recheck(long_file(30, 20)).accepted  # 4 s and more, one by one


@pytest.mark.parametrize("certificate", [long_file(400, 20), long_file(2, 1)])
def test_the_second_checker_stops_when_its_time_is_over(certificate):
    opinion = recheck(certificate, seconds=1e-9)
    assert (opinion.accepted, opinion.reason) == (False, OUT_OF_TIME)
    assert recheck(long_file(2, 1)).accepted  # and the limit is gone


def test_a_large_file_is_ended_in_the_middle_of_an_operation():
    assert recheck_apart(long_file(400, 20), seconds=1).reason == OUT_OF_TIME


@pytest.mark.slow
def test_a_large_file_gets_the_same_answer_from_a_process_of_its_own(monkeypatch):
    good = long_file(3, 2)
    monkeypatch.setattr(apart, "SMALL", 0)
    assert recheck_apart(good, seconds=100) == recheck(good)
    wrong = {**good, "multiplier": {"theta": "0", "kernels": [{**good["multiplier"]["kernels"][0], "rate": "0"}]}}
    assert recheck_apart(wrong, seconds=100) == recheck(wrong)


def test_verify_rejects_what_the_second_checker_has_no_time_for(lure, here, monkeypatch):
    shown = completed(draft(OSCILLATOR, nonlinearities(0, "29/10"), "circle", {}))
    check(shown)
    (here / "proof.json").write_text(json.dumps(shown))
    assert lure("verify", "proof.json", "--second", "--seconds", "100")[0] == 0
    monkeypatch.setattr(apart, "recheck", lambda certificate, seconds: recheck(certificate, seconds=1e-9))
    status, out, _ = lure("verify", "proof.json", "--second", "--seconds", "100")
    assert status == 11
    assert "the second checker has not decided: the time allowed" in " ".join(out.split())
