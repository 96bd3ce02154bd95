"""A certificate with a part changed is rejected, unless what it then says is true by an independent test."""

import copy
import itertools
import json
from fractions import Fraction

import pytest
from certificate_family import DRAFTS, accepted, certificate, nonlinearities
from depth import sampled
from flint import fmpq, fmpq_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import complete_and_check, completed
from lure.analysis.certificates.second import recheck

F = Fraction
WORDS = (
    *(
        "PROVED",
        "REFUTED",
        "circle",
        "popov",
        "park",
        "off-axis-circle",
        "zames-falb",
        "tsypkin",
        "tsypkin-odd",
        "jury-lee",
        "homogeneous-lyapunov",
        "hurwitz",
    ),
    *("counterexample", "rod-popov", "rod-circle", "rod-energy", "rod", "rod-scheme", "continuous", "discrete"),
    *(
        "omega",
        "omega^2",
        "polynomial",
        "cover",
        "matrix",
        "matrix-gain",
        "structure",
        "causal",
        "anticausal",
        "inf",
        "finite",
        "-inf",
    ),
    *("sigma = H mu, mu = phi(sigma)", "sigma = -H mu, mu = -phi(sigma)", "0", "1", "-1", "tanh", "transfer", "delay"),
)
CLAIM = ("verdict", "system", "laws", "law", "theorem", "conclusion")


def leaves(tree, path=()):
    """The path to every part that is no list and no object, and to every list and object."""
    if path:
        yield path
    parts = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, part in parts:
        yield from leaves(part, (*path, key))


def tampered_text(draw, text):
    """One digit, the sign, the numerator or the whole of a text."""
    kind = draw(st.sampled_from(["digit", "sign", "upside down", "near", "word", "lost"]))
    digits = [i for i, c in enumerate(text) if c.isdigit()]
    if kind == "digit" and digits:
        i = draw(st.sampled_from(digits))
        return text[:i] + draw(st.sampled_from("0123456789")) + text[i + 1 :]
    if kind == "sign":
        return text[1:] if text.startswith("-") else "-" + text
    if kind == "upside down" and text.count("/") == 1:
        return "/".join(reversed(text.split("/")))
    if kind == "near" and digits:
        try:
            return str(F(text) * (1 + draw(st.sampled_from([1, -1])) * F(1, 2 ** draw(st.sampled_from([1, 4, 40])))))
        except ValueError:
            pass
    if kind == "lost" and text:
        i = draw(st.integers(0, len(text) - 1))
        return text[:i] + text[i + 1 :]
    return draw(st.sampled_from(WORDS))


@st.composite
def tampering(draw, name):
    """A certificate of the family with one part changed."""
    whole = json.loads(json.dumps(certificate(name)))
    # each of the great parts as likely as another, so that long proofs do not hide the rest
    head = draw(st.sampled_from(list(whole)))
    *above, last = draw(st.sampled_from([path for path in leaves(whole) if path[0] == head]))
    place = whole
    for key in above:
        place = place[key]
    part = place[last]
    if isinstance(place, list):
        kind = draw(st.sampled_from(["change", "drop", "twice", "swap"]))
        if kind == "drop":
            del place[last]
            return whole
        if kind == "twice":
            place.insert(last, copy.deepcopy(part))
            return whole
        if kind == "swap":
            other = draw(st.integers(0, len(place) - 1))
            place[last], place[other] = place[other], part
            return whole
    elif draw(st.integers(0, 9)) == 0:
        del place[last]
        return whole
    elif draw(st.integers(0, 9)) == 0:
        place[draw(st.sampled_from(["note", "theta", "tau", "zero", "cells", "kind"]))] = part
        return whole
    if isinstance(part, bool) or part is None:
        place[last] = draw(st.sampled_from([True, False, None, 0, 1]))
    elif isinstance(part, int):
        place[last] = part + draw(st.sampled_from([-part, 1, -1, 2, -2, 64]))
    elif isinstance(part, str):
        place[last] = tampered_text(draw, part)
    elif isinstance(part, list):
        place[last] = draw(st.sampled_from([part[::-1], part[:-1], [*part, *part[-1:]], [part], None]))
    else:
        place[last] = draw(st.sampled_from([{}, None, dict(list(part.items())[:-1])]))
    return whole


def polynomial_of(texts):
    return fmpq_poly([fmpq(v.numerator, v.denominator) for v in map(F, reversed(texts))])


def is_stable(system, gain):
    """Whether every root of d + g n is strictly inside, by balls around the roots; undecided is no."""
    p = polynomial_of(system["denominator"]) + fmpq(gain.numerator, gain.denominator) * polynomial_of(
        system["numerator"]
    )
    if p.degree() < len(system["denominator"]) - 1:
        return False
    inside = (abs(r) < 1 if system["time"] == "discrete" else r.real < 0 for r, _ in p.numer().complex_roots())
    return all(inside)


def gains_of(given):
    """Constant gains of a class, close to its ends and between; both slopes and chords bind."""
    pairs = [given["sector"]] + ([given["slope"]] if given["slope"] else [])
    low = max((F(a) for a, _ in pairs if a != "-inf"), default=None)
    high = min((F(b) for _, b in pairs if b not in ("inf", "finite")), default=None)
    low = low if low is not None else (high or F(0)) - 10**4
    high = high if high is not None else low + 10**4
    if low > high:
        return []  # no nonlinearity has such slopes and such chords
    return [low + (high - low) * F(i, 24) for i in range(25)] + [low + (high - low) * F(1, 2**i) for i in range(5, 20)]


def assert_true(found):
    """The claim is true by the second checker and, for rational blocks, by the roots for constant gains."""
    made = found.certificate
    if made["system"]["kind"] == "delay" and made["proof"]["method"] == "linear-gain":
        # d(0) + g sum n_j(0) is 0, or has the sign opposite to that for large s: a root s >= 0
        top, d = made["system"]["terms"], made["system"]["denominator"]
        assert (F(d[-1]) + F(made["proof"]["gain"]) * sum(F(n[-1]) for _, n in top)) * F(d[0]) <= 0
        return
    assert recheck(made).accepted, recheck(made).reason
    if made["system"]["kind"] != "transfer":
        return
    if isinstance(found, Proved):
        converges = made["conclusion"].startswith(("every motion converges", "every motion is bounded"))
        for gain in gains_of(made["laws"]):
            at_the_end = gain in (F(made["laws"]["sector"][0] if made["laws"]["sector"][0] != "-inf" else gain + 1), 0)
            assert is_stable(made["system"], gain) or (converges and at_the_end)
    elif made["proof"]["method"] in ("linear-gain", "matrix-gain"):
        assert not is_stable(made["system"], F(made["proof"]["gain"]))


SHORT = [name for name in DRAFTS if not name.startswith("flow-orbit")]
MANY = settings(max_examples=sampled(60, of=150))


@pytest.mark.parametrize("names", [SHORT[i::6] for i in range(6)], ids=lambda names: names[0])
@MANY
@given(data=st.data())
def test_a_certificate_with_one_part_changed_is_rejected_or_still_true(names, data):
    name = data.draw(st.sampled_from(names))
    whole, changed = certificate(name), data.draw(tampering(name))
    try:
        found = check(json.dumps(changed))
    except (Rejected, Malformed):
        return
    # accepted: the claim is that of the original, and another multiplier, witness or origin shows it as well;
    # or it is another claim, and true
    assert changed["convention"] == whole["convention"]
    if any(changed[key] != whole[key] for key in CLAIM):
        assert_true(found)
    assert recheck(changed).accepted


@pytest.mark.parametrize("names", [SHORT[i::6] for i in range(6)], ids=lambda names: names[0])
@MANY
@given(data=st.data())
def test_a_change_that_is_carried_through_is_rejected_or_still_true(names, data):
    # the forger also recomputes what the checker compares: polynomial, conclusion and hypotheses
    changed = data.draw(tampering(data.draw(st.sampled_from(names))))
    forged = {key: value for key, value in changed.items() if key not in ("conclusion", "hypotheses")}
    if not isinstance(forged.get("proof"), dict) or set(forged) != set(certificate("popov")) - {
        "conclusion",
        "hypotheses",
    }:
        return
    found = accepted_or_refused(forged)
    if found is not None:
        assert_true(found)


def accepted_or_refused(forged):
    """Drafts are filled in outside the checker: there a wrong type may be an error of Python."""
    try:
        return complete_and_check(forged)
    except (ValueError, TypeError, KeyError, AttributeError, IndexError):
        return None


def test_a_tampered_orbit_in_continuous_time_is_rejected():
    # every part of the proof that says something; state, durations and inverse may differ by less than the radius
    whole = json.loads(json.dumps(certificate("flow-orbit")))
    proof = whole["proof"]
    assert check(json.dumps(whole)).theorem == "counterexample"
    forged = [
        {"half": True},
        {"pieces": proof["pieces"][::-1]},
        {"pieces": [1 - p if p < 2 else p for p in proof["pieces"]]},
        {"pieces": proof["pieces"][:-1], "durations": proof["durations"][:-1]},
        {"durations": proof["durations"][::-1]},
        {"durations": [str(F(t) * F(1001, 1000)) for t in proof["durations"]]},
        {"state": [str(-F(x)) for x in proof["state"]]},
        {"state": [str(F(x) * F(1001, 1000)) for x in proof["state"]]},
        {"state": proof["state"][::-1]},
        {"inverse": [["0"] * len(row) for row in proof["inverse"]]},
        {"inverse": [[str(-F(v)) for v in row] for row in proof["inverse"]]},
        {"radius": "0"},
        {"radius": "-" + proof["radius"]},
        {"radius": "1/10"},
        {"left": "1/2"},
        {"right": "2"},
        {"points": [["-1", "0"], ["0", "0"], ["1", "1/4"]]},
        {"points": [["-2", "0"], ["0", "0"], ["1", "0"]]},
    ]
    for part in forged:
        assert accepted({**whole, "proof": {**proof, **part}}) is None, part
    assert accepted({**whole, "laws": nonlinearities(0, "1/2", slope=True)}) is None
    assert accepted({**whole, "laws": nonlinearities(0, 1, slope=True, linear=True)}) is None
    for numerator, denominator in ((["1", "0"], ["1", "1/5", "1"]), (["-1", "0"], ["1", "-1/5", "1"])):
        other = {**whole["system"], "numerator": numerator, "denominator": denominator}
        assert accepted({**whole, "system": other}) is None


def test_every_theorem_and_method_is_attacked():
    made = [certificate(name) for name in DRAFTS]
    assert {c["theorem"] for c in made} == {w for w in WORDS[2:16]}
    methods = (
        "polynomial",
        "cover",
        "matrix",
        "powers",
        "structure",
        "linear-gain",
        "crossing",
        "switched-gain",
        "orbit",
    )
    assert {c["proof"]["method"] for c in made} == {*methods, "matrix-gain", "flow-orbit"}
    assert [n for n in DRAFTS if not recheck(certificate(n)).accepted] == []


def test_only_the_checker_makes_a_verdict():
    for kind, args in itertools.product((Proved, Refuted), ((), (object(), certificate("popov"), "", {}))):
        with pytest.raises(TypeError):
            kind(*args)
    assert completed(DRAFTS["popov"]()) == certificate("popov")
