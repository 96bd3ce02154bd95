"""How rates and tolerances are looked for and told, one decision at a time, of loops that are made up."""

from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import pytest
from worded import PLAIN

from lure import InputError, NonlinearityClass, RationalPlant, Sector, SlopeBounds, as_plant
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.questions import decay, margins
from lure.analysis.questions.decay import RateBound
from lure.analysis.questions.margins import Margin, Tolerances, _ChannelGrowth, _Growth, tolerances
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.classes import Diagonal
from lure.errors import AssumptionError
from lure.plants.family import PlantFamily

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
CLASSES = Diagonal((NonlinearityClass(sector=Sector(0, 2)),))
GIVEN = "phi, time-invariant, in the sector [0, 2]"


def certificate(rate, time="continuous", late=False, **proof):
    system = {"kind": "transfer", "time": time, "numerator": ["1"], "denominator": ["1", "1"]}
    system |= {"late": []} if late else {}
    given = {"system": system, "laws": PLAIN, "proof": {"method": "linear-gain", "gain": "1"} | proof}
    return given if rate is None else given | {"rate": str(rate)}


def proved(rate, time="continuous", late=False):
    return SimpleNamespace(certificate=certificate(rate, time, late), theorem="circle", assumed="")


def against(rate, time="continuous", **proof):
    return SimpleNamespace(certificate=certificate(rate, time, **proof))


def bound(low, high, time="continuous", **more):
    given = {"time": time, "rate": Bracket(low, high), "classes": CLASSES, "nonlinearity_class": GIVEN}
    return RateBound(**given | more)


EVERY = "Every solution satisfies |x(t)| <= c |x(0)|"
ALL = f"with one c for {GIVEN} (circle, certified)"


# continuous time: the rate from below, in discrete time the factor from above; the member's the other way round
@pytest.mark.parametrize(
    ("found", "verdict", "said"),
    [
        (bound(1 / 3, inf, proof=proved("1/3")), PROVED, f"{EVERY} exp(-0.3333333 t) {ALL}."),
        (
            bound(0, 2 / 3, "discrete", proof=proved("2/3", "discrete")),
            PROVED,
            f"{EVERY} 0.6666667^t (t in samples) {ALL}.",
        ),
        (
            bound(1 / 3, inf, proof=proved("1/3", late=True)),
            PROVED,
            f"Every solution satisfies |x(t)| <= c m exp(-0.3333333 t), m the greatest |x| before t = 0, {ALL}.",
        ),
        (
            bound(1 / 3, 2 / 3, proof=proved("1/3"), refutation=against("2/3")),
            PROVED,
            f"{EVERY} exp(-0.3333333 t) {ALL}; with phi = sigma a solution decays no faster than exp(-0.6666667 t).",
        ),
        (
            bound(1 / 3, 2 / 3, "discrete", refutation=against("1/3", "discrete")),
            PROVED,
            f"No rate is proved for {GIVEN}; with phi = sigma a solution decays no faster than 0.3333333^t (t "
            "in samples).",
        ),
        (
            bound(-inf, 2 / 3, refutation=against("2/3", method="switched-gain")),
            OPEN,
            f"No rate is proved for {GIVEN}; with gains that jump a solution decays no faster than exp(-0.6666667 t).",
        ),
        (
            bound(-inf, 0, refutation=against(None)),
            REFUTED,
            f"Not every solution decays for all members of the class ({GIVEN}): with phi = sigma a solution does not "
            "decay.",
        ),
        (
            bound(-1, -1 / 3, proof=proved(-1), refutation=against("-1/3")),
            REFUTED,
            f"Not every solution decays for all members of the class ({GIVEN}): with phi = sigma a solution grows at "
            f"least like exp(0.3333333 t); every solution satisfies |x(t)| <= c |x(0)| exp(1 t) {ALL}.",
        ),
        (
            bound(1, 2, "discrete", proof=proved(2, "discrete"), refutation=against(None, "discrete")),
            REFUTED,
            f"Not every solution decays for all members of the class ({GIVEN}): with phi = sigma a solution does not "
            f"decay; every solution satisfies |x(t)| <= c |x(0)| 2^t (t in samples) {ALL}.",
        ),
        (
            bound(-1, 1, proof=proved(-1)),
            OPEN,
            "No decay is proved; every solution satisfies |x(t)| <= c |x(0)| exp(1",
        ),
        (bound(-inf, inf, stopped="time"), OPEN, f"No rate is proved for {GIVEN}. The time allowed ended the search"),
    ],
)
def test_a_rate_is_told_from_both_sides(found, verdict, said):
    assert found.verdict is verdict
    assert str(found).startswith(said)
    assert str(found) == said or said[-1] != "."
    assert found.evidence is (Evidence.CERTIFIED if found.proof or found.refutation else None)
    sides = (found.proof, found.refutation)
    assert found._sides == (sides[::-1] if found.time == "discrete" else sides)


@pytest.mark.parametrize(
    ("low", "high", "time", "verdict", "closed"),
    [
        (0, inf, "continuous", OPEN, False),
        (1, 1.000001, "continuous", PROVED, True),
        (1, 1.00001, "continuous", PROVED, False),
        (-inf, 0, "continuous", REFUTED, False),
        (0, 1, "discrete", OPEN, False),
        (1, inf, "discrete", REFUTED, False),
        (0.5, 0.9999, "discrete", PROVED, False),
        (-1000001e-6, -1, "continuous", REFUTED, True),
    ],
)
def test_what_a_rate_means(low, high, time, verdict, closed):
    assert (bound(low, high, time).verdict, bound(low, high, time).closed) == (verdict, closed)


CLOSE = F(1, 10**4)


def loop(discrete=False, **more):
    """A loop of which everything is known: what is proved and refuted is decided by comparing with one rate."""
    asked = SimpleNamespace(classes=CLASSES)
    made = {"discrete": discrete, "close": CLOSE, "asked": asked, "words": GIVEN, "fastest": 5.0, "base": {}}
    return SimpleNamespace(**made | more)


# the nearest short fraction first, then ever further on the side where the member is no faster
@pytest.mark.parametrize("discrete", [False, True])
def test_the_rate_of_the_slowest_gain_is_tried_outwards(discrete):
    asked, value = [], F(1 / 3)
    made = loop(discrete, slowest=(1 / 3, None), refute=asked.append)
    assert decay._refuted(made) is None
    sign = -1 if discrete else 1
    steps = [F(1, 10**n) for n in (15, 12, 9, 7, 5, 3)]
    assert asked == [F(1, 3), F(1, 3), *(value + sign * step * value for step in steps)]
    made.refute = lambda rate: "shown" if abs(rate - value) > F(1, 10**10) else None
    assert decay._refuted(made) == (value + sign * F(1, 10**9) * value, "shown")
    asked.clear()
    assert decay._refuted(loop(discrete, slowest=(0.0123, None), refute=asked.append)) is None
    assert (len(asked), asked[0]) == (7, F(123, 10000))  # none of three digits is as near as a millionth


# at rest, within rounding, 0 is tried alone; of a gain that grows 0 at last, in discrete time no factor is 0 or below
@pytest.mark.parametrize(
    ("slowest", "discrete", "asked"),
    [(inf, False, []), (1e-12, False, [0]), (-1e-13, False, [0]), (0.0, True, [])],
)
def test_a_gain_at_rest_is_tried_at_0(slowest, discrete, asked):
    heard = []
    assert decay._refuted(loop(discrete, slowest=(slowest, None), refute=heard.append)) is None
    assert heard == asked
    if asked == [0]:
        assert decay._refuted(loop(slowest=(slowest, None), refute=lambda rate: "shown")) == (0, "shown")


def test_a_gain_that_grows_refutes_at_0_where_its_own_rate_is_not_shown():
    heard = []
    assert decay._refuted(loop(slowest=(-0.5, None), refute=heard.append)) is None
    assert heard[-1] == 0
    assert heard[0] == F(-1, 2) == min(heard)
    assert max(heard[:-1]) == F(-1, 2) + F(1, 2000)
    made = loop(slowest=(-0.5, None), refute=lambda rate: None if rate else "shown")
    assert decay._refuted(made) == (0, "shown")
    assert decay._refuted(loop(slowest=(0.5, None), refute=lambda rate: None if rate else "shown")) is None


# gains that jump are asked while they are slower than what is known
@pytest.mark.parametrize(
    ("discrete", "known", "found"),
    [
        (False, None, 3),
        (False, (F(4), "known"), 3),
        (False, (F(3), "known"), None),
        (False, (F(1), "known"), None),
        (True, None, 3),
        (True, (F(2), "known"), 3),
        (True, (F(3), "known"), None),
        (True, (F(5), "known"), None),
    ],
)
def test_gains_that_jump_are_slower_than_what_is_known(discrete, known, found, monkeypatch):
    shown = object.__new__(Refuted)
    monkeypatch.setattr(decay, "accepted", lambda draft: shown if draft["proof"] == "second" else None)
    made = loop(discrete, patterns=[(F(3), "first"), (F(3), "second"), (F(3), "second")], base={"laws": 1})
    assert decay._slower(made, known) == (known if found is None else (F(found), shown))
    assert decay._slower(loop(discrete, patterns=[(F(3), "first")]), known) == known


# what is proved comes as near to the truth as asked for, with a guess at once, without by halving
@pytest.mark.parametrize(
    ("discrete", "refuted", "truth"),
    [
        (False, F(1, 2), F(1, 2)),
        (False, F(1, 2), F(3, 10)),
        (False, None, F(3, 10)),
        (False, F(1, 2), F(-2)),
        (False, F(-1), F(-3)),
        (False, F(0), F(-3)),
        (False, F(1, 2), -(10**9)),
        (True, F(1, 2), F(1, 2)),
        (True, F(1, 2), F(3, 4)),
        (True, None, F(3, 4)),
        (True, F(1, 2), F(7)),
        (True, F(2), F(5)),
        (True, F(1), F(5)),
        (True, F(1, 2), 10**9),
    ],
)
@pytest.mark.parametrize("guessed", [True, False])
def test_a_rate_is_proved_up_to_the_truth(discrete, refuted, truth, guessed):
    asked = []

    def prove(rate):
        asked.append(rate)
        return "shown" if (rate >= truth if discrete else rate <= truth) else None

    def expected(easy, best):
        near = sorted((easy, best))
        return float(min(max(truth, near[0]), near[1]) if guessed else best)

    found = [rate for rate, shown in decay._proofs(loop(discrete, prove=prove, expected=expected), refuted)]
    if abs(truth) > 10**6:
        assert found == []
        return
    scale = max(abs(F(5) if refuted is None else refuted), abs(truth), F(1, 1000)) if not discrete or refuted else F(9)
    assert abs(found[-1] - truth) <= 2 * CLOSE * max(scale, max(map(abs, found)))
    assert found == sorted(found, reverse=discrete)
    assert len(set(found)) == len(found)
    assert len(asked) <= (12 if guessed and refuted else 40)


# both sides and every step: who is asked what, and what is the answer
@pytest.mark.parametrize(
    ("discrete", "refuted", "proofs", "multipliers", "ways", "steps", "ends"),
    [
        (False, F(2), [F(1), F(2)], [], {}, "gc", (2, 2)),
        (False, F(2), [F(1)], [F(3, 2)], {}, "gczj", (1.5, 2)),
        (False, None, [], [], {}, "gczjx", (-inf, 9)),
        (False, None, [], [], {"jumping": False}, "gcz", (-inf, inf)),
        (False, F(2), [], [], {}, "gczjx", (-inf, 9)),
        (False, F(-1), [], [], {}, "gczj", (-inf, -1)),
        (False, F(2), [F(1)], [], {"worst": True}, "gczjr", (1, 2)),
        (False, F(2), [F(2) - 3 * CLOSE], [], {}, "gc", (2 - 3e-4, 2)),
        (False, F(2), [F(2) - 5 * CLOSE], [], {}, "gczj", (2 - 5e-4, 2)),
        (True, F(1, 2), [F(3, 4)], [], {}, "gczj", (0.5, 0.75)),
        (True, F(1, 2), [F(2)], [], {}, "gczjx", (9, 2)),
        (True, None, [F(1)], [], {}, "gczjx", (9, 1)),
        (True, F(1), [F(2)], [], {}, "gczj", (1, 2)),
    ],
)
def test_both_sides_of_a_rate(discrete, refuted, proofs, multipliers, ways, steps, ends, monkeypatch):
    told = []
    made = loop(
        discrete, lasting=lambda: "lasting", by_multipliers=lambda end, best: iter([(one, one) for one in multipliers])
    )
    monkeypatch.setattr(decay, "_refuted", lambda _one: None if refuted is None else (refuted, refuted))
    monkeypatch.setattr(decay, "_proofs", lambda _one, _end: iter([(one, one) for one in proofs]))
    monkeypatch.setattr(decay, "_slower", lambda _one, known: known)
    monkeypatch.setattr(decay, "_rescaled", lambda *_given: iter(()))
    found = decay._answered(made, None, lambda step, done: told.append((step, done)), **ways)
    names = {"g": "constant gains", "c": "the circle criterion", "z": "Zames-Falb multipliers"}
    names |= {"j": "gains that jump", "r": "solutions that repeat on another scale", "x": "counterexamples"}
    assert [step for step, _ in told] == [names[one] for one in steps]
    assert [done for _, done in told] == [{"g": 0, "c": 0.2, "z": 0.4, "j": 0.7, "r": 0.75, "x": 0.8}[s] for s in steps]
    if "x" in steps:
        still = 1 if discrete else 0
        ends = (still, ends[1]) if discrete else (ends[0], still)
        assert found.refutation == "lasting"
    assert (found.rate.low, found.rate.high) == pytest.approx(ends)
    decays = found.proof is not None and (found.proof < 1 if discrete else found.proof > 0)
    assert (found.reason == "") is decays
    assert (found.time, found.classes, found.nonlinearity_class) == (
        "discrete" if discrete else "continuous",
        CLASSES,
        GIVEN,
    )


LAGS = as_plant(([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]))
BOXED = PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)})
VARYING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)


# a loop of its own kind for one channel, several, dead time and boxes; of differences gains that jump are no members
@pytest.mark.parametrize(
    ("plant", "given", "kind"),
    [
        (RationalPlant([1], [1, 1]), Sector(0, 1), "OneChannel"),
        ("exp(-s)/(s+1)", Sector(0, 1), "LateChannels"),
        (BOXED, Sector(0, 1), "BoxOfPlants"),
        (LAGS, [Sector(0, 1)] * 2, "SeveralChannels"),
        (as_plant([["exp(-s)/(s+1)", "0"], ["0", "1/(s+1)"]]), [Sector(0, 1)] * 2, "LateChannels"),
        (LAGS, None, "no class of nonlinearities is given"),
    ],
)
def test_which_loop_a_rate_is_asked_of(plant, given, kind, monkeypatch):
    heard = []
    monkeypatch.setattr(decay, "_answered", lambda one, *_given, **ways: heard.append((type(one).__name__, ways)))
    if " " in kind:
        with pytest.raises(InputError, match=kind):
            decay.decay_rate(plant, given)
        return
    decay.decay_rate(plant, given, worst=True)
    assert heard[0][0] == kind
    assert heard[0][1] == ({"worst": True} if kind in ("OneChannel", "BoxOfPlants") else {})
    decay.difference_rate(RationalPlant([1], [1, 1]), Diagonal((VARYING,)))
    decay.difference_rate(LAGS, Diagonal((VARYING,) * 2))
    assert heard[1:] == [("OneChannel", {"jumping": False}), ("SeveralChannels", {"jumping": False})]


# tolerances -----------------------------------------------------------------------------------------------------------


FAMILY = PlantFamily.of_coefficients(["b"], [1, "a"], {"a": (1, 2), "b": (3, 4)})


@pytest.mark.parametrize(
    ("box", "inwards", "said"),
    [
        (((1, 2), (3, 4)), True, "as given"),
        (((F(1, 2), F(5, 2)), (3, 4)), True, "100 % wider"),
        (((F(5, 4), F(7, 4)), (3, 4)), True, "50 % narrower"),
        (((1, F(4, 3) + 1), (3, 4)), True, "33.3 % wider"),
        (((1, F(4, 3) + 1), (3, 4)), False, "33.4 % wider"),
        (((1, F(5, 3)), (3, 4)), True, "33.4 % narrower"),
        (((1, F(5, 3)), (3, 4)), False, "33.3 % narrower"),
    ],
)
def test_how_much_wider_a_box_is(box, inwards, said):
    assert margins._percent(FAMILY, 0, box, inwards=inwards) == said


WIDE = ((F(2, 3), F(7, 3)), (F(8, 3), F(13, 3)))


@pytest.mark.parametrize(
    ("names", "more", "said"),
    [
        ("a", {"proved": WIDE}, "a: may be in [0.6666667, 2.333333] (66.6 % wider), and nothing farther was refuted"),
        ("a", {"refuted": WIDE}, "a: not in [0.6666666, 2.333334] (66.7 % wider)"),
        (
            "ab",
            {"proved": WIDE},
            "all together: proved for a in [0.6666667, 2.333333], b in [2.666667, 4.333333] (66.6 % wider), and "
            "nothing farther was refuted",
        ),
        (
            "ab",
            {"proved": WIDE, "refuted": (*WIDE,)},
            "all together: proved for a in [0.6666667, 2.333333], b in [2.666667, 4.333333] (66.6 % wider), not for "
            "all of a in [0.6666666, 2.333334], b in [2.666666, 4.333334] (66.7 % wider)",
        ),
        ("a", {}, "a: nothing is shown"),
    ],
)
def test_a_margin_is_told(names, more, said):
    assert Margin(parameters=tuple(names), width=Bracket(0, inf), **more).words(FAMILY) == said


def told(verdict=PROVED, **more):
    given = {"family": FAMILY, "verdict": verdict, "nonlinearity_class": GIVEN, "margins": ()}
    return Tolerances(**given | more)


PROOF = SimpleNamespace(certificate={}, assumed="x")
BOX = "a in [1, 2], b in [3, 4]"


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (told(), f"Proved for {GIVEN} and every {BOX}."),
        (told(shown=PROOF), f"Proved for {GIVEN}, for which x, and every {BOX}."),
        (told(REFUTED, shown=PROOF, reason="why"), f"Refuted for {GIVEN} and some {BOX}: why."),
        (told(OPEN, stopped="time"), f"Undecided for {GIVEN} and every {BOX}. The time allowed"),
    ],
)
def test_tolerances_are_told(found, said):
    assert str(found).startswith(said)
    assert (found.proof, found.refutation, found.evidence) == (None, None, None)


def test_the_margins_of_tolerances_are_told_with_their_evidence():
    none = Margin(parameters=("a",), width=Bracket(0, inf))
    each = Margin(parameters=("a",), width=Bracket(0, 1), refuted=WIDE, refutation=PROOF)
    last = Margin(parameters=("a", "b"), width=Bracket(1, inf), proved=WIDE, proof=PROOF)
    found = told(margins=(each, last))
    end = f" How far parameters may go about the middle of their intervals: {each.words(FAMILY)}; {last.words(FAMILY)}"
    assert str(found).endswith(f"{end} (certified).")
    assert (found.proof, found.refutation, found.evidence) == (PROOF, None, Evidence.CERTIFIED)
    assert (told(margins=(none,)).evidence, told(margins=(each,)).evidence) == (None, Evidence.CERTIFIED)
    assert found.assumed == told(margins=(last,)).assumed == "for which x"
    assert told(margins=(each,)).assumed == ""


class Grown(_Growth):
    """Boxes of which it is known from which width on they are refuted, and up to which they are proved."""

    def __init__(self, refuted_from, proved_to, shown=(F(0), F(0))):
        super().__init__(Problem.about(FAMILY, NonlinearityClass(sector=Sector(0, 1))))
        self.from_, self.to, self.looked, self.shown = refuted_from, proved_to, [], shown

    def width(self, box):
        return box[0][1] - box[0][0]

    def unstable(self, box):
        self.looked.append(self.width(box))
        return self.from_ is not None and self.width(box) >= self.from_

    def _worst_place(self, own, s):
        return [F(-1), F(1)]

    def _moves(self, own, place, s):
        return self.width(self.box(own, s)) >= self.from_

    def refuted(self, box):
        return "against" if self.width(box) >= self.from_ * (1 + self.shown[0]) else None

    def likely(self, box):
        self.looked.append(self.width(box))
        return self.width(box) <= self.to

    def proved(self, box):
        return "proof" if self.width(box) <= self.to * (1 - self.shown[1]) else None


SHARE = F(1, 100)


# from the width given on by doubling up to 32, then by halving to a hundredth
@pytest.mark.parametrize("truth", [F(1, 3), F(1), F(3), F(31), F(32)])
def test_the_width_that_is_refuted_is_found_to_a_hundredth(truth):
    made = Grown(truth, truth)
    width, shown = made._refuted((0,))
    assert (truth <= width <= truth * (1 + SHARE), shown) == (True, "against")
    assert made.looked[0] == 1
    later = Grown(truth, truth, shown=(SHARE / 2, F(0)))._refuted((0,))
    assert truth == 32 or truth * (1 + SHARE / 2) <= later[0] <= truth * (1 + 2 * SHARE)
    twice = Grown(truth, truth, shown=(F(1, 2), F(0)))._refuted((0,))
    assert twice is None if truth * 2 > 32 else twice[0] >= truth * F(3, 2)


def test_no_width_is_refuted_beyond_the_largest_of_interest():
    made = Grown(None, F(0))
    assert made._refuted((0,)) is None
    assert made.looked == [1, 2, 4, 8, 16, 32]


# just below what is refuted, else by halving from 1/64 on; a proof that fails is tried of a little less, and of a half
@pytest.mark.parametrize(("to", "found"), [(F(4), None), (F(1), 1), (F(1, 100), 0), (F(1, 64), 1)])
def test_the_width_that_is_proved_is_found_to_a_hundredth(to, found):
    made = Grown(F(4), to)
    one = made._proved((0,), F(4))
    if found is None:
        assert one == (4 * (1 - SHARE / 2), "proof")
        assert Grown(F(4), to, shown=(F(0), SHARE))._proved((0,), F(4))[0] == 4 * (1 - SHARE / 2) * (1 - SHARE)
        assert Grown(F(4), to, shown=(F(0), F(1, 3)))._proved((0,), F(4))[0] == 2 * (1 - SHARE / 2)
        assert Grown(F(4), to, shown=(F(0), F(2, 3)))._proved((0,), F(4)) is None
    elif found:
        assert (to * (1 - SHARE) <= one[0] <= to, one[1]) == (True, "proof")
    else:
        assert one is None


def test_a_margin_has_both_ends_and_their_boxes():
    made = Grown(F(2), F(1))
    found = made.margin((0,))
    assert (found.parameters, found.proof, found.refutation) == (("a",), "proof", "against")
    assert found.proved == made.box((0,), made._proved((0,), made._refuted((0,))[0])[0])
    assert 0.98 < found.width.low <= 1 < 2 <= found.width.high < 2.05
    assert (found.proved[1], found.refuted[1]) == ((3, 4), (3, 4))
    open_ = Grown(None, F(64)).margin((1,))
    assert (open_.width.high, open_.refuted, open_.refutation) == (inf, None, None)
    assert open_.width.low == pytest.approx(32 * 0.995)


def test_a_box_grows_about_its_middle():
    made = Grown(F(2), F(1))
    assert made.box((0,), F(3)) == ((0, 3), (3, 4))
    assert made.box((0, 1), F(1, 2)) == ((F(5, 4), F(7, 4)), (F(13, 4), F(15, 4)))
    assert made.most((0,)) == 32


# a dead time in [1, 2], about 3/2, is 0 at the width 3
def test_no_dead_time_becomes_negative():
    late = PlantFamily.of_formula("exp(-T*s)/(s + a)", {"a": (1, 2), "T": (1, 2)})
    made = Grown(F(2), F(1))
    made.asked = Problem.about(late, NonlinearityClass(sector=Sector(0, 1)))
    assert (made.most((1,)), made.most((0,))) == (3, 32)


# 1/(s^3 + a s^2 + 3 s + 1) with gains up to 3: stable for 3 a > 4, so that the least a, 3 - s, is the worst
def test_where_in_a_box_gains_end_first():
    lags = PlantFamily.of_coefficients([1], [1, "a", 3, 1], {"a": (2, 4)})
    made, widths = _Growth(Problem.about(lags, NonlinearityClass(sector=Sector(0, 3)))), (F(1), F(8, 5), F(7, 4))
    assert made._worst_place((0,), F(1)) == [-1]
    assert [made._moves((0,), [F(-1)], s) for s in widths] == [False, False, True]
    assert not made._moves((0,), [F(1)], F(7, 4))
    assert [made.unstable(made.box((0,), s)) for s in widths] == [False, False, True]
    assert made.refuted(made.box((0,), F(1))) is None
    assert made.refuted(made.box((0,), F(7, 4))) is not None
    assert [(lower, upper) for _, lower, upper in made._bounds()] == [(0, 3)] * len(made.rows)
    open_ = _Growth(Problem.about(lags, NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(-1, inf))))
    slopes = {(row.slope, low, high) for row, low, high in open_._bounds()}
    assert slopes <= {(False, 0, 1), (True, -1, "finite")}
    assert (True, -1, "finite") in slopes


# each parameter, then all of them; what ends is said
def test_tolerances_ask_for_each_parameter_and_for_all(monkeypatch):
    heard, made = [], Grown(F(2), F(1))
    conclusion = SimpleNamespace(verdict=REFUTED, reason="why", shown=None)
    monkeypatch.setattr(Grown, "_certification", lambda _self: SimpleNamespace(conclusion=conclusion), raising=False)
    found = made.answered(None, lambda step, done: heard.append((step, done)))
    assert heard == [("the box given", 0.0), ("a", 0.0), ("b", 1 / 3), ("a, b", 2 / 3)]
    assert [one.parameters for one in found.margins] == [("a",), ("b",), ("a", "b")]
    assert (found.verdict, found.reason, found.stopped) == (REFUTED, "why", None)
    monkeypatch.setattr(Grown, "margin", lambda _self, _own: (_ for _ in ()).throw(TimeoutError))
    assert (made.answered(None, None).stopped, made.answered(None, None).margins) == ("time", ())


# of several channels each criterion is asked; one of which boxes are found is enough
@pytest.mark.parametrize(("shows", "found"), [((), False), (("a",), True), (("b",), True)])
def test_boxes_of_several_channels_are_likely_where_a_criterion_has_some(shows, found, monkeypatch):
    class Search:
        def __init__(self, asked, name):
            self.asked, self.name = asked, name

        def tree(self, alpha):
            """Boxes, or none."""
            assert (self.asked, alpha) == ("another box", 1)
            if self.name not in shows:
                raise AssumptionError("none")
            return "boxes"

        def whole(self):
            """What is accepted."""
            return object.__new__(Proved) if self.name in shows else None

    monkeypatch.setattr(margins.channel_families, "criteria", lambda _asked: ["a", "b"])
    monkeypatch.setattr(margins.channel_families, "BoxSearch", Search)
    monkeypatch.setattr(_ChannelGrowth, "at", lambda _self, _box: "another box")
    made = _ChannelGrowth(None)
    assert made.likely("box") is found
    assert isinstance(made.proved("box"), Proved) is found
    assert made.most((0,)) == 32


def test_tolerances_are_of_plants_with_parameters():
    with pytest.raises(InputError, match="of a plant with parameters"):
        tolerances(RationalPlant([1], [1, 1]), Sector(0, 1))
    with pytest.raises(InputError, match="of a plant with parameters"):
        tolerances(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)])


# x1' = 0, x2' = -x2 + mu, sigma = x2: of an eigenvalue 0 scipy warns, where Lyapunov's equation is for units alone
def test_a_pole_at_0_is_no_matter_of_warnings():
    found = decay.decay_rate(([[0, 0], [0, -1]], [[0], [1]], [[0, 1]], [[0]]), Sector(0, 1))
    assert (found.verdict, float(found.rate.low)) == (REFUTED, pytest.approx(0, abs=1e-9))
