"""Regions of attraction as files for Coq: true ones compile, falsified ones do not."""

from fractions import Fraction

import pytest
from replayed import LOOP, changed, compiled, needs_coq, resting_on_axioms

from lure import Saturation
from lure.analysis import region
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.analysis.export.graphs import Known
from lure.analysis.export.regional import regional_text
from lure.errors import InputError
from lure.plants.multivariable import MultivariablePlant

SATURATED = {"kind": "piecewise-polynomial", "cuts": ["-1", "1"], "pieces": [["-1"], ["0", "1"], ["1"]]}


def beyond(*, discrete=False):
    """``x' = x - sat(x)`` beyond ``9/10 x^2 = 1``: ``V' - V + phi^2`` is ``9/10 x^2 - 9/5 x phi + phi^2``, positive.

    In discrete time ``x+ = 2 x - sat(x)``: ``V+ - 2 V + phi^2`` is ``9/5 x^2 - 18/5 x phi + 19/10 phi^2``.
    """
    plant = {"kind": "multivariable", "time": "discrete" if discrete else "continuous", "B": [["1"]], "C": [["1"]]}
    plant |= {"A": [["2" if discrete else "1"]], "D": [["0"]]}
    draft = {"verdict": "REFUTED", "system": plant, "laws": {"graphs": [SATURATED]}, "theorem": "counterexample"}
    proof = {"method": "growth", "Q": [["9/10"]], "rate": "1", "weights": ["1"]}
    return complete_and_check(draft | {"multiplier": {}, "proof": proof})


def attracted(system, graphs, terms, proof, time="continuous"):
    A, B, C, D = ([row.split() for row in side] for side in system)
    plant = {"kind": "multivariable", "time": time, "A": A, "B": B, "C": C, "D": D}
    theorem = "local-popov" if "integrals" in proof else "local-circle"
    draft = {"verdict": "PROVED", "system": plant, "laws": {"graphs": graphs}, "theorem": theorem}
    return complete_and_check(draft | {"multiplier": {"terms": terms}, "proof": proof})


def local():
    """``x' = x - phi(x)``, ``phi`` in [2, 3] for ``|x| <= 1``, the set ``2 x^2 <= 1``.

    ``V' = 4 x (x - phi)``, and with the term ``4/5 (3 x - phi)(phi - 2 x)`` ``-V'`` is ``4/5 (x^2 + phi^2)``.
    """
    graph = {"kind": "sector", "sector": ["2", "3"], "reach": "1"}
    term = {"channel": 1, "weight": "2/5", "sector": ["2", "3"], "reach": "1"}
    return attracted((["1"], ["1"], ["1"], ["0"]), [graph], [term], {"method": "ellipsoid", "P": [["2"]]})


def interval(ends, graphs, A="1", B="2", C="1", time="continuous"):
    """``x' = A x - B phi(C x)`` on an interval; of two nonlinearities ``B`` and ``C`` have two numbers."""
    columns = C.split()
    plant = {"kind": "multivariable", "time": time, "A": [[A]], "B": [B.split()], "C": [[v] for v in columns]}
    plant["D"] = [["0"] * len(columns)] * len(columns)
    draft = {"verdict": "PROVED", "system": plant, "laws": {"graphs": graphs}, "theorem": "scalar", "multiplier": {}}
    return coq_text(complete_and_check(draft | {"proof": {"method": "signs", "interval": ends}}))


LIMITED = {"kind": "piecewise-polynomial", "cuts": ["-2"], "pieces": [["-2"], ["0", "1"]]}  # from below alone
INTERVALS = {  # f = x - 2 phi(x) is 0 at 2 and -2, below 0 at -4; the last one 2 - 1 - 2/2 at 2 and -6 + 1 + 4 at -6
    "both": lambda: interval(["-2", "2"], [SATURATED]),
    "one": lambda: interval(["-4", "inf"], [LIMITED]),
    "none": lambda: interval(["-inf", "inf"], [SATURATED], A="0", B="1", C="1/2"),
    "two": lambda: interval(["-2", "inf"], [SATURATED, LIMITED], B="1/2 3/2", C="1 1"),
}


def test_an_interval_of_one_state_is_kept_and_attracted():
    held = "(forall t, 0 <= t -> {}) /\\ tends_to (x 0%nat) 0.\nProof."
    ends = {"both": "(-2) < x 0%nat t /\\ x 0%nat t < 2", "one": "(-4) < x 0%nat t", "two": "(-2) < x 0%nat t"}
    for name, kept in ends.items():
        assert held.format(kept) in INTERVALS[name]()
    assert "(continuity_pt (x 0%nat) 0) ->\n  tends_to (x 0%nat) 0.\nProof." in INTERVALS["none"]()
    cubic = {"kind": "piecewise-polynomial", "cuts": [], "pieces": [["0", "1", "0", "1"]]}
    with pytest.raises(InputError, match="lines between cuts"):
        interval(["-1", "1"], [cubic], A="0", B="1")
    with pytest.raises(InputError, match="in continuous time"):  # x+ = (2 x - sat(x))/4
        interval(["-4", "4"], [SATURATED], A="1/2", B="1/4", time="discrete")
    with pytest.raises(InputError, match="curves have none"):
        regional_text({"proof": {"method": "spiral"}}, "")


def everywhere(graph, **more):
    """``x_1' = x_2``, ``x_2' = -phi(x_1 + x_2)``: ``V = x_2^2 + 2 int phi`` falls by ``2 phi^2``."""
    plant = {"kind": "multivariable", "time": "continuous", "A": [["0", "1"], ["0", "0"]], "B": [["0"], ["1"]]}
    plant |= {"C": [["1", "1"]], "D": [["0"]]}
    draft = {"verdict": "PROVED", "system": plant, "laws": {"graphs": [graph]}, "theorem": "global-popov"}
    given = {"lambda": ["0"], "theta": ["1"], "inverse": ["1"]} | more
    proof = {"method": "everywhere", "P": [["0"], ["0", "1"]], "least": ["1"]}
    return coq_text(complete_and_check(draft | {"multiplier": given, "proof": proof}))


def test_what_attracts_everything_is_said_of_every_solution():
    stated = (text := everywhere(SATURATED))[text.rindex("Theorem region") : text.rindex("Proof.")]
    assert "forall (Phi : R -> R) (x w : nat -> R -> R),\n  (integral_of Phi phi) ->" in stated
    assert stated.endswith("  tends_to (x 0%nat) 0 /\\ tends_to (x 1%nat) 0.\n")
    for cuts, pieces, inverse, why in (
        (["0"], [["0", "1"], ["0", "1/2"]], "1", "not of lines, one through 0"),
        ([], [["0", "1/2", "0", "1"]], "0", "not known and below a line"),
    ):
        with pytest.raises(InputError, match=why):
            everywhere({"kind": "piecewise-polynomial", "cuts": cuts, "pieces": pieces}, inverse=[inverse])


@needs_coq
@pytest.mark.thorough
def test_what_attracts_everything_compiles_and_what_is_falsified_does_not(library):
    lifted = {"kind": "piecewise-polynomial", "cuts": ["-1/2", "2"], "pieces": [["-1/4", "1/4"], ["0", "3/4"], ["3/2"]]}
    assert compiled(library, everywhere(lifted))[0]
    text = everywhere(SATURATED)
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("((-1) * w 0%nat t)", "(1 * w 0%nat t)"),
        ("1 * x 0%nat t + 1 * x 1%nat t.", "1 * x 0%nat t + 2 * x 1%nat t."),
        ("if Rle_dec s (-1) then (-1) else", "if Rle_dec s (-1) then 1 else"),
        ("tends_to (x 0%nat) 0", "tends_to (x 0%nat) 1"),
        ("Definition Q : list (list Z) := [[", "Definition Q : list (list Z) := [[-"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], (right, wrong)


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("name", INTERVALS)
def test_intervals_compile_and_falsified_ones_do_not(name, library):
    text = INTERVALS[name]()
    lemmas, _, own = text.partition(LOOP)
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        {"both": ("x 0%nat 0 < 2", "x 0%nat 0 < 3"), "one": ("(-4) < x 0%nat 0", "(-5) < x 0%nat 0")}.get(
            name, ("tends_to (x 0%nat) 0", "tends_to (x 0%nat) 1")
        ),
        ("if Rle_dec s (-2)" if name in ("one", "two") else "if Rle_dec s (-1)", "if Rle_dec s (-3)"),
        ("0 < t -> derivable", "1 < t -> derivable"),
    ):
        assert not compiled(library, lemmas + LOOP + changed(own, right, wrong))[0], (right, wrong)


def driven(*, discrete=False):
    """The same with a disturbance of energy up to 1/8: ``4/5 (x^2 + phi^2) - 4 x w + 8 w^2`` is positive.

    In discrete time, up to 1/32, ``x+ = 3/2 x - phi(x) + w``: ``V+`` gains ``4 w (3 x/2 - phi) + 2 w^2``.
    """
    ends = ["1", "2"] if discrete else ["2", "3"]
    graph = {"kind": "sector", "sector": ends, "reach": "1"}
    term = {"channel": 1, "weight": "5/4" if discrete else "2/5", "sector": ends, "reach": "1"}
    proof = {"method": "ellipsoid", "P": [["2"]], "energy": "1/32" if discrete else "1/8", "Bw": [["1"]]}
    side = (["3/2" if discrete else "1"], ["1"], ["1"], ["0"])
    return attracted(side, [graph], [term], proof, "discrete" if discrete else "continuous")


def saddle():
    """``x' = y``, ``y' = x - sat(3 x + 4 y)``, on ``2 x^2 + 3 x y + 2 y^2 <= 1``, where ``5/4 |x + y| <= 1``."""
    system = (["0 1", "1 0"], ["0", "1"], ["3 4"], ["0"])
    term = {"channel": 1, "weight": "3/4", "row": ["5/4", "5/4"]}
    proof = {"method": "ellipsoid", "P": [["2"], ["3/2", "2"]]}
    return attracted(system, [SATURATED], [term], proof)


def cubic():
    """Van der Pol's oscillator back in time, ``x' = -x + x^3/3 - y``, ``y' = x``; ``2 int phi = -x^4/6 >= -x^2/6``."""
    graph = {"kind": "piecewise-polynomial", "cuts": [], "pieces": [["0", "0", "0", "-1/3"]]}
    term = {"channel": 1, "weight": "3/2", "sector": ["-1/3", "0"], "reach": "1"}
    proof = {"method": "level-set", "P": [["3/2"], ["1/4", "3/2"]]}
    proof["integrals"] = [{"channel": 1, "theta": "1/4", "reach": "1", "least": "-1/6"}]
    return attracted((["-1 -1", "1 0"], ["1", "0"], ["1 0"], ["0"]), [graph], [term], proof)


def steps():
    """``x+ = 3/2 x - phi(x)``, ``phi`` in [1, 2] for ``|x| <= 1``, the set ``2 x^2 <= 1``.

    ``2 x^2 - 2 (3 x/2 - phi)^2 - 5/2 (2 x - phi)(phi - x) = (5 x^2 - 3 x phi + phi^2)/2``, positive.
    """
    graph = {"kind": "sector", "sector": ["1", "2"], "reach": "1"}
    term = {"channel": 1, "weight": "5/4", "sector": ["1", "2"], "reach": "1"}
    return attracted((["3/2"], ["1"], ["1"], ["0"]), [graph], [term], {"method": "ellipsoid", "P": [["2"]]}, "discrete")


def test_a_region_is_said_of_where_solutions_start():
    text = coq_text(local())
    stated = text[text.rindex("Theorem region") :]
    assert "(forall t, in_sector_up_to 1 2 3 (phi t)) ->" in stated
    assert "(continuity_pt (x 0%nat) 0) ->\n  (level x w 0 <= 1) ->" in stated
    assert "(forall t, 0 <= t -> level x w t <= 1) /\\\n  tends_to (x 0%nat) 0." in stated
    text = coq_text(cubic())
    assert "Definition phi (s : R) : R :=\n  (-1 / 3) * s ^ 3." in text
    assert "level Phi x w t <= 1 /\\ Rabs (sigma x w t) <= 1) /\\" in text
    assert "  (level x w 0%nat <= 1) ->\n  (forall t, level x w t <= 1) /\\\n  Un_cv (x 0%nat) 0." in coq_text(steps())


def test_a_bound_without_room_between_its_ends_is_refused():
    # y phi = y^2 + (y^2 - 1)^2 y^2, so that the lower end 1 is touched at +-1 and 1/2 is not
    one, none = Fraction(1), Fraction(0)
    touching = Known(name="phi", cuts=[], pieces=[[none, 2 * one, none, -2 * one, none, one]])
    assert touching.local("local", one / 2, 2 * one, one).count("nonneg_along_sound") == 4
    with pytest.raises(InputError, match="leaves too little room"):
        touching.local("local", one, 8 * one, Fraction(7, 5))


def test_disturbances_are_said_of_their_energy():
    text = coq_text(driven())
    assert "(x 0%nat 0 = 0) ->\n  (forall t, 0 < t -> derivable_pt_lim Ed t (d 0%nat t ^ 2)) ->" in text
    assert "(forall t, 0 <= t -> Ed t - Ed 0 <= (1 / 8)) ->\n  (forall t, 0 <= t -> level x w d t <= 1) /\\" in text
    assert "(forall t, Ed (S t) = Ed t + (d 0%nat t ^ 2)) ->" in coq_text(driven(discrete=True))


def test_starts_beyond_a_set_are_said_not_to_tend_to_0():
    assert "  (1 < level x w 0) ->\n  ~ (tends_to (x 0%nat) 0)." in coq_text(beyond())
    assert "  (1 < level x w 0%nat) ->\n  ~ (Un_cv (x 0%nat) 0)." in coq_text(beyond(discrete=True))


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("discrete", [False, True])
def test_starts_beyond_a_set_compile_and_falsified_files_do_not(discrete, library):
    text = coq_text(beyond(discrete=discrete))
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    speed = 2 if discrete else 1
    for right, wrong in (
        ("(9 / 10) * (x 0%nat t * x 0%nat t)", "2 * (x 0%nat t * x 0%nat t)"),
        (f"{speed} * x 0%nat t + (-1) * w", "(1 / 2) * x 0%nat t + (-1) * w"),
        ("1 < level", "(1 / 2) < level"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


@needs_coq
@pytest.mark.slow
def test_a_region_of_a_saturation_compiles_and_falsified_files_do_not(library):
    text = coq_text(saddle())
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("2 * (x 1%nat t * x 1%nat t)", "1 * (x 1%nat t * x 1%nat t)"),  # a larger set
        ("if Rle_dec s 1 then 1 * s else", "if Rle_dec s (1 / 2) then 1 * s else"),  # it would jump
        ("3 * x 0%nat t + 4 * x 1%nat t", "3 * x 0%nat t + (-4) * x 1%nat t"),
        ("(level x w 0 <= 1)", "(level x w 0 <= 2)"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("made", "changes"),
    [
        (
            local,
            [
                ("in_sector_up_to 1 2 3", "in_sector_up_to 1 (1 / 2) 3"),
                ("in_sector_up_to 1 2", "in_sector_up_to (1 / 2) 2"),
            ],
        ),
        (cubic, [("(-1 / 3) * s ^ 3", "(-1) * s ^ 3"), ("(Rabs (sigma x w 0) <= 1)", "(Rabs (sigma x w 0) <= 2)")]),
        (driven, [("<= (1 / 8)", "<= (1 / 2)"), ("(x 0%nat 0 = 0)", "(x 0%nat 0 = 1)")]),
        (lambda: driven(discrete=True), [("<= (1 / 32)", "<= (1 / 2)"), ("+ 1 * d 0%nat t", "+ 9 * d 0%nat t")]),
        (steps, [("(3 / 2) * x 0%nat t", "(5 / 2) * x 0%nat t"), ("in_sector_up_to 1 1 2", "in_sector_up_to 1 1 3")]),
    ],
)
def test_regions_of_other_kinds_compile_and_falsified_files_do_not(made, changes, library):
    text = coq_text(made())
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in changes:
        assert not compiled(library, changed(text, right, wrong))[0]


# Two inputs with limits (Tarbouriech et al. 2011), and two layers: tanh feeds a saturation.
@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("layers", [False, True])
def test_regions_of_several_channels_compile(layers, library):
    sides = (["1/10 -1/10", "1/10 -3"], ["5 0", "0 1"], ["7283/10000 169/5000", "27/2000 13583/10000"], ["0 0", "0 0"])
    if layers:
        sides = (["1/10 1", "0 -1"], ["0 0", "0 1"], ["1 0", "2 1"], ["0 0", "-1/2 0"])
    plant = MultivariablePlant(*(tuple(tuple(map(Fraction, row.split())) for row in side) for side in sides))
    found = region(plant, ["tanh(sigma)", Saturation()] if layers else [Saturation(limit=5), Saturation(limit=2)])
    for one in found.sets:
        ok, said = compiled(library, coq_text(one.proof))
        assert ok, said
