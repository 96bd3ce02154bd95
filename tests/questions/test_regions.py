"""Regions of attraction: exact with one state; ellipsoids that both checkers accept, and nothing that leaves them."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq_poly
from matplotlib.figure import Figure
from tampering import assert_both_reject, edited

from lure import InputError, Saturation, Sector, as_plant
from lure.analysis import check, region
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.second.graphs import Graph
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.regions import _integral_bounded
from lure.analysis.cli import main
from lure.analysis.questions.region_areas import union_volume
from lure.analysis.questions.region_proofs import proved_ellipsoid, proved_growth
from lure.analysis.questions.region_sets import matrix_of, shape_of, volume_below
from lure.analysis.verdict import Verdict
from lure.files import loop_to_toml, parse_system, read_system
from lure.nonlinearities import Cubic, DeadZone
from lure.nonlinearities.base import LocalSector
from lure.plants.multivariable import MultivariablePlant


def rows(matrix):
    return tuple(tuple(Fraction(str(v)) for v in row) for row in matrix)


# The first example of Tarbouriech et al. (2011): two inputs, limits 5 and 2, u = sat(K x), so sigma = -K x.
A = [[0.1, -0.1], [0.1, -3]]
TWO = MultivariablePlant(
    rows(A), rows([[5, 0], [0, 1]]), rows([[0.7283, 0.0338], [0.0135, 1.3583]]), rows([[0, 0]] * 2)
)
LIMITS = [Saturation(limit=5), Saturation(limit=2)]
# x' = y, y' = x - sat(3 x + 4 y): a saddle that is held near 0.
SADDLE = as_plant(([[0, 1], [1, 0]], [0, 1], [3, 4], 0))


def accepted(certificate):
    """What the two checkers say."""
    try:
        check(json.dumps(dict(certificate)), draft=True)  # not by the findings stored in it
        first = True
    except (Rejected, Malformed):
        first = False
    return first, recheck(certificate).accepted


@pytest.fixture(scope="module")
def square():
    return region(TWO, LIMITS, along=[[1, 1], [1, -1]])


@pytest.fixture(scope="module")
def saddle():
    return region(SADDLE, Saturation())


# x' = a x - b sat(k x), limit 1, b k > a: the signs change where a x = b, at +-b/a; beyond, x' > 0.
@pytest.mark.parametrize(("a", "b", "k"), [("1", "1", "2"), ("0.7", "3", "1"), ("5", "1/3", "20")])
def test_one_state_with_a_saturation_is_exact_from_both_sides(a, b, k):
    a, b, k = map(Fraction, (a, b, k))
    found = region(as_plant(([[a]], [b], [1], 0)), Saturation(gain=k, limit=1))
    assert found.sets[0].interval == found.outside[0].interval == (-b / a, b / a)
    assert found.area[0] <= 2 * b / a <= found.area[1] == pytest.approx(found.area[0], rel=1e-15)
    assert [accepted(one.proof.certificate) for one in (*found.sets, *found.outside)] == [(True, True)] * 2


def test_limits_that_differ_give_an_interval_that_is_not_symmetric():
    # x' = 3 x - sat(7 x) between -1 and 2: 3 x = 2 at 2/3, 3 x = -1 at -1/3
    assert region(([1], [1, -3]), Saturation(gain=7, limit=2, lower_limit=-1)).sets[0].interval == (
        Fraction(-1, 3),
        Fraction(2, 3),
    )


def test_a_root_that_is_irrational_is_enclosed():
    # x' = -x + 2 x^3: the ends are +-1/sqrt(2)
    found = region(([1], [1, 1]), Cubic(cubic=-2))
    low, high = found.area
    assert low <= math.sqrt(2) <= high
    assert high - low < 1e-14
    assert accepted(found.sets[0].proof.certificate) == (True, True)


def test_discrete_time_with_one_state():
    # x+ = 1.5 x - sat(1.5 x): 0 for |x| <= 2/3, then 1.5 x - 1 < x up to x = 2, and > x beyond
    found = region(as_plant("1/(z-1.5)", dt=1), Saturation(gain="3/2", limit=1))
    assert found.sets[0].interval == found.outside[0].interval == (-2, 2)
    beyond = found.outside[0].proof.certificate
    assert accepted(beyond) == (True, True)
    assert_both_reject(edited(beyond, "proof", "interval", value=["-1", "1"]))  # 1.5 goes to 1.25


def test_the_command_says_what_x_is_where_no_matrices_are_given(tmp_path, capsys):
    # x+ = 1.2 x + mu, sigma = x/10, |mu| <= 1: from 5 on 1.2 x - 1 >= x; of sigma it would be 1/2
    file = tmp_path / "plant.toml"
    law = '[nonlinearity]\nkind = "saturation"\ngain = 5\nlimit = 1\n'
    file.write_text(f"[plant]\nnum = [0.1]\nden = [1, -1.2]\ndt = 1\n{law}")
    said = "x is the state of the companion form of the transfer function, with C = [0.1].\n"
    assert main(["region", str(file), "-q"]) == 0
    assert capsys.readouterr().out.endswith(f"The length of the region is at most 10.\n{said}")
    file.write_text(f"[plant]\nA = [[1.2]]\nB = [[1]]\nC = [[0.1]]\ndt = 1\n{law}")
    assert main(["region", str(file), "-q"]) == 0
    assert capsys.readouterr().out.endswith("The length of the region is at most 10.\n")


def test_the_square_of_the_published_example_grows_more_than_the_published_factor(square):
    # published with the generalised sector condition: 74.6; simulated solutions escape from 249.74 on
    assert 244 < square.reach < 249.74
    assert accepted(square.sets[0].proof.certificate) == (True, True)


def test_a_rejected_direction_is_the_users(square):
    assert square.sets[0].contains([240, 240])
    assert not square.sets[0].contains([400, 400])


def simulated(plant, nonlinearities, starts, *, step=0.02, steps=2000):
    """Last states of many solutions at once, by Heun's rule."""
    A, B, C, D = plant.doubles()
    assert not D.any()

    def rate(x):
        phi = np.stack([f(s) for f, s in zip(nonlinearities, C @ x, strict=True)])
        return A @ x - B @ phi

    x = np.array(starts, dtype=float).T
    for _ in range(steps):
        k = rate(x)
        x = x + step / 2 * (k + rate(x + step * k))
    return x.T


def boundary(P, count, seed):
    """Points with x'P x = 1, random directions."""
    z = np.random.default_rng(seed).normal(size=(count, len(P)))
    z /= np.linalg.norm(z, axis=1)[:, None]
    return np.linalg.solve(np.linalg.cholesky(np.array(P, dtype=float)).T, z.T).T


@pytest.mark.slow
def test_no_start_of_a_set_escapes(square, saddle):
    for found, plant, laws in (
        (square, TWO, LIMITS),
        (saddle, MultivariablePlant.of_one_channel(SADDLE), [Saturation()]),
    ):
        starts = 0.999999 * boundary(found.sets[0].P, 300, 1)
        ends = simulated(plant, laws, starts)
        assert np.all(np.einsum("ki,ij,kj->k", ends, np.array(found.sets[0].P, dtype=float), ends) < 0.5)


def test_members_satisfy_the_terms_that_a_certificate_uses(square):
    # the falsifier: (u sigma - phi)(phi - h x) >= 0 at random points of the ellipsoid
    certificate = square.sets[0].proof.certificate
    x = boundary(square.sets[0].P, 2000, 2) * np.random.default_rng(3).uniform(0, 1, (2000, 1))
    for term, law, c in zip(certificate["multiplier"]["terms"], LIMITS, TWO.doubles()[2], strict=True):
        sigma = x @ c
        phi, h = law(sigma), np.array([float(Fraction(v)) for v in term["row"]])
        assert np.min((sigma - phi) * (phi - x @ h)) >= -1e-9


@pytest.mark.slow
def test_local_sectors_of_formulas_in_both_times():
    # pendulum with friction; a cubic spring that softens, sampled
    for plant, law in ((([1], [1, 1, 0]), "sin(sigma)"), (as_plant("0.1/(z**2 - 1.7*z + 0.8)", dt=1), "-sigma**3")):
        found = region(plant, law)
        assert found.verdict is Verdict.PROVED
        assert accepted(found.sets[0].proof.certificate) == (True, True)
        assert found.sets[0].bounds[0]["interval"][1] == found.sets[0].bounds[0]["interval"][0][1:]


def test_starts_outside_of_the_published_example_are_known_to_a_percent(square):
    # simulated solutions escape from 266.27 along (1, 1) and from 249.74 along (1, -1) on
    (beyond,) = square.outside
    assert accepted(beyond.proof.certificate) == (True, True)
    Q = np.array(beyond.Q, dtype=float)
    for point, simulated_from in (([1, 1], 266.27), ([1, -1], 249.74)):
        assert simulated_from < (point @ Q @ point) ** -0.5 < 1.01 * simulated_from


def test_one_unstable_mode_of_a_saddle_is_bounded_by_its_left_eigenvector(saddle):
    # w = (1, 1): (w'x)' = w'x - sat(.), so |w'x| > 1 diverges; Q tends to w w'
    (beyond,) = saddle.outside
    assert accepted(beyond.proof.certificate) == (True, True)
    assert np.allclose(np.array(beyond.Q, dtype=float), 1, atol=1e-3)
    weights = beyond.proof.certificate["proof"]["weights"]
    for bad in (
        edited(beyond.proof.certificate, "proof", "weights", 0, value=str(2 * Fraction(weights[0]))),
        edited(beyond.proof.certificate, "proof", "rate", value="3"),
        edited(beyond.proof.certificate, "proof", "Q", 0, 0, value="2"),
        edited(beyond.proof.certificate, "proof", "Q", 1, 1, value="4"),
    ):
        assert accepted(bad) == (False, False)


# of sigma held between -a and b the integral 2 int phi is sigma^2 up to there, then 2 b sigma - b^2: at 3 for b = 1
# it is 5, so that sigma^2 times 5/9 is below it and sigma^2 times 1 above
@pytest.mark.parametrize(("a", "b"), [(1, 2), (2, 1)])
def test_integrals_are_bounded_on_both_sides_up_to_the_reach(a, b):
    held = Graph(cuts=(Fraction(-a), Fraction(b)), pieces=(fmpq_poly([-a]), fmpq_poly([0, 1]), fmpq_poly([b])))
    for least, above, right in (("5/9", True, True), ("5/8", True, False), ("1", False, True), ("9/10", False, False)):
        assert _integral_bounded(held, Fraction(least), Fraction(3), above=above) is right


@pytest.mark.slow
def test_integrals_make_a_set_larger_and_both_checkers_accept_it():
    found = region(TWO, LIMITS)
    level, ellipse, *_ = found.sets
    assert (level.kind, ellipse.kind) == ("level set", "ellipsoid")
    assert level.volume > 1.01 * ellipse.volume
    assert found.area[0] >= level.volume
    good = level.proof.certificate
    assert accepted(good) == (True, True)
    for i, entry in enumerate(good["proof"]["integrals"]):
        at = ("proof", "integrals", i)
        assert accepted(edited(good, *at, "theta", value="0")) == (False, False)
        assert accepted(edited(good, *at, "least", value=str(Fraction(entry["least"]) * Fraction(101, 100)))) == (
            False,
            False,
        )
        assert accepted(edited(good, *at, "reach", value=str(Fraction(entry["reach"]) * Fraction(9, 10)))) == (
            False,
            False,
        )
    assert accepted(edited(good, "system", "time", value="discrete")) == (False, False)
    starts = np.array([x for x in boundary(ellipse.P, 400, 5) * 1.02 if level.contains(x) and not ellipse.contains(x)])
    assert len(starts) > 20
    assert np.abs(simulated(TWO, LIMITS, starts)).max() < 1e-3 * np.abs(starts).max()
    assert np.all(level.values(starts) <= 1)


def test_what_holds_the_points_is_the_set_that_is_named(saddle, monkeypatch):
    # the set that goes farthest towards them may be a smaller one: a curve beside a larger ellipsoid, say
    long = region(SADDLE, Saturation(), along=[[1, 0]]).proof
    monkeypatch.setattr("lure.analysis.questions.regions.proved_ellipsoid", lambda *_: saddle.proof)
    monkeypatch.setattr("lure.analysis.questions.regions.proved_level_set", lambda *_: long)
    found = region(SADDLE, Saturation(), along=[[1, 0]])
    first, larger = found.sets
    assert larger.volume > 1.3 * first.volume
    assert found.area[0] >= larger.volume
    assert [one.contains([found.reach, 0]) for one in found.sets] == [True, False]
    assert f"its area is at least {first.volume:.6g}"[:-1] in str(found)


def test_equilibria_are_found_exactly(saddle):
    # x' = y, y' = x - sat(3 x + 4 y): y = 0 and x = +-1; in discrete time x+ = 1.5 x - sat(1.5 x): x = 2 (x - 1) etc.
    assert saddle.equilibria == ((-1, 0), (1, 0))
    found = region(as_plant("1/(z-1.5)", dt=1), Saturation(gain="3/2", limit=1))
    assert found.equilibria == ((-2,), (2,))
    assert not any(one.contains(x) for one in saddle.sets for x in saddle.equilibria)


@pytest.mark.slow
def test_without_stable_modes_the_area_is_bounded_from_both_sides():
    found = region(as_plant(([["0.2", 1], [-1, "0.2"]], [0, 1], ["0.5", 2], 0)), Saturation())
    low, high = found.area
    assert 0 < low < high < 2.1 * low
    assert accepted(found.outside[0].proof.certificate) == (True, True)


def test_a_loop_with_little_damping_near_0_has_a_set_too():
    # tanh(sigma/0.01), gain 100 at 0: modes that decay by 6e-4 per second, and a set of the size of 1e-2
    plant = as_plant(([1, 0, 0], [1, "0.12", "2.0254", "0.121308", "0.981919"]))
    local = LocalSector(Fraction(9999, 100), 100, Fraction(1, 10**4))  # what tanh does there, and more
    found = region(plant, local)
    assert found.verdict is Verdict.PROVED
    assert accepted(found.sets[0].proof.certificate) == (True, True)


# z = x1 + x2 has z' = z - sat(2 z), z+ = 1.2 z - sat(.4 z): |z| < 1, |z| < 5 is attracted; x1 - x2 decays: no end.
@pytest.mark.slow_for("row0-2-None-1")
@pytest.mark.parametrize(("row", "k", "dt", "most"), [(["0", "1"], 2, None, 1), (["0.85", "0.35"], "0.4", 1, 25)])
def test_where_sets_grow_for_ever_some_are_proved(row, k, dt, most):
    found = region(as_plant(([row, row[::-1]], [0, 1], [k, k], 0), **({"dt": dt} if dt else {})), Saturation())
    for one in found.sets:
        (a, b), (_, d) = matrix_of(one.proof.certificate)
        assert (a - 2 * b + d) / (a * d - b * b) < most  # the largest z^2
        assert recheck(one.proof.certificate).accepted
    assert found.verdict is Verdict.PROVED


def test_a_dead_zone_that_does_not_hold_an_unstable_plant():
    # x' = x - dz(x): near 0 x' = x grows; there is no set
    assert region(([1], [1, -1]), DeadZone(width=1, gain=3)).sets == ()


def test_a_changed_digit_class_or_sign_is_refused_by_both(square, saddle):
    good = square.sets[0].proof.certificate
    P, term = good["proof"]["P"], good["multiplier"]["terms"][0]
    for bad in (
        edited(good, "proof", "P", 0, 0, value=str(Fraction(P[0][0]) / 2)),  # leaves a strip
        edited(good, "proof", "P", 1, 1, value=str(-Fraction(P[1][1]))),
        edited(good, "multiplier", "terms", 0, "weight", value=str(-Fraction(term["weight"]))),
        edited(good, "multiplier", "terms", 0, "row", 0, value=str(2 * Fraction(term["row"][0]))),
        edited(good, "multiplier", "terms", 0, "channel", value=2),
        edited(good, "laws", "graphs", 0, "cuts", value=["-4", "4"]),  # jumps
        edited(good, "system", "A", 0, 0, value="3"),
        edited(good, "system", "time", value="discrete"),
        edited(good, "theorem", value="diagonal-circle"),
        edited(good, "verdict", value="REFUTED"),
        edited(good, "laws", "graphs", 0, value={"kind": "sector", "sector": ["0", "1"], "reach": "5"}),
    ):
        assert accepted(bad) == (False, False), bad
    assert_both_reject(edited(good, "conclusion", value="0 attracts every motion"), stored=True)
    exact = region(([1], [1, -1]), Saturation(gain=2, limit=1))
    inner, outer = (one.proof.certificate for one in (exact.sets[0], exact.outside[0]))
    for one, interval in ((inner, ["-1", "101/100"]), (outer, ["-1", "99/100"]), (inner, ["1", "-1"])):
        bad = edited(one, "proof", "interval", value=interval)
        bad["conclusion"] = (
            bad["conclusion"].replace("and 1 ", f"and {interval[1]} ").replace("or 1 ", f"or {interval[1]} ")
        )
        assert accepted(bad) == (False, False)


@pytest.mark.slow
def test_a_sector_of_an_interval_is_checked_on_the_interval():
    good = region(([1], [1, 1, 1]), "-sigma**3").sets[0].proof.certificate
    term = good["multiplier"]["terms"][0]
    assert accepted(good) == (True, True)
    larger = str(Fraction(term["reach"]) * 2)  # -sigma^2 is below l there
    assert accepted(edited(good, "multiplier", "terms", 0, "reach", value=larger)) == (False, False)
    upper = str(Fraction(-1, 1000))  # the chord tends to 0 at 0
    assert accepted(edited(good, "multiplier", "terms", 0, "sector", 1, value=upper)) == (False, False)


FILE = """
[plant]
A = [[0, 1], [1, 0]]
B = [0, 1]
C = [3, 4]
[nonlinearity]
kind = "saturation"
gain = 1
limit = 1
"""


def test_the_command_and_its_certificate(tmp_path, capsys):
    file, proof = tmp_path / "plant.toml", tmp_path / "region.json"
    file.write_text(FILE)
    assert main(["region", str(file), "--json", "--along", "1 0", "--certificate", str(proof), "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert main(["region", str(file), "-o", str(proof), "-q"]) == 2
    assert main(["region", str(file), "--output", str(proof), "--replace"]) == 0
    assert f"The certificate of the first set is {proof}; check it: lure verify {proof}" in capsys.readouterr().out
    assert found["schema"] == "lure-region/1"
    assert found["area"][0] == pytest.approx(found["sets"][0]["volume"])
    assert found["sets"][0]["level"] == "1"
    assert main(["verify", "--second", str(proof)]) == 0


@pytest.mark.slow
def test_the_drawing_shows_what_is_known(saddle):
    axes = Figure().add_subplot()
    assert saddle.plot(ax=axes) is axes
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert said == ["never tends to 0", "tends to 0 (ellipsoid)", "solutions", "other equilibria"]
    assert axes.get_xlabel() == "state 1"
    line = region(([1], [1, -1]), Saturation(gain=2, limit=1)).plot(ax=Figure().add_subplot())
    assert [text.get_text() for text in line.get_legend().get_texts()] == ["tends to 0", "never tends to 0"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--along", "1 2 3"], "along has the point 1 2 3, of 3 numbers; give 2, one for each state"),
        (["--along", "0 0"], "points away from it"),
        (["--along", "x"], "separated by semicolons"),
        (["--seconds", "-1"], "positive number of seconds"),
    ],
)
def test_bad_options_are_refused_in_a_sentence(tmp_path, capsys, arguments, words):
    file = tmp_path / "plant.toml"
    file.write_text(FILE)
    assert main(["region", str(file), *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.slow
def test_a_class_that_holds_on_an_interval_is_used_on_it_alone():
    # x' = x - phi, phi in [2, 3] sigma for |sigma| <= 1, anything beyond: attracted for |x| < 1, and no more is known
    plant = as_plant(([[1]], [1], [1], 0))
    found = region(plant, LocalSector(2, 3, "1"))
    assert 0.999 < found.area[0] / 2 < 1
    good = found.sets[0].proof.certificate
    assert accepted(good) == (True, True)
    assert accepted(edited(good, "laws", "graphs", 0, "reach", value="1/2")) == (False, False)
    assert accepted(edited(good, "laws", "graphs", 0, "sector", value=["1", "3"])) == (False, False)
    assert accepted(edited(good, "multiplier", "terms", value=[])) == (False, False)
    # x+ = 3/2 x - phi: of a gain 3 it is -3/2 x
    sampled = region(as_plant("1/(z - 3/2)", dt=1), LocalSector(1, 2, 1)).sets[0].proof.certificate
    assert accepted(sampled) == (True, True)
    assert accepted(edited(sampled, "laws", "graphs", 0, "sector", value=["1", "3"])) == (False, False)
    assert found.plot(ax=Figure().add_subplot()).get_xlabel() == "state"
    assert region(plant, LocalSector("1/2", 3, 1)).sets == ()
    with pytest.raises(InputError, match="two bounds in order"):
        LocalSector(1, 0, 1)


@pytest.mark.slow
def test_a_direct_term_feeds_what_is_bounded_into_a_sector():
    # two channels, sigma_2 = x_2 + phi_1/2: |sigma_2| <= |x_2| + 1/2 on every set
    plant = as_plant(([[1, 0], [0, -1]], [[1, 0], [0, 1]], [[3, 0], [0, 1]], [[0, 0], ["-1/2", 0]]))
    found = region(plant, [Saturation(), "sigma**3 - sigma/2"])
    assert found.verdict is Verdict.PROVED
    assert accepted(found.sets[0].proof.certificate) == (True, True)
    terms = found.sets[0].proof.certificate["multiplier"]["terms"]
    assert Fraction(terms[1]["reach"]) > Fraction(1, 2)
    cycle = as_plant(([[1, 0], [0, -1]], [[1, 0], [0, 1]], [[3, 0], [0, 1]], [[0, "1/9"], ["-1/2", 0]]))
    assert region(cycle, [Saturation(), Saturation()]).sets == ()


class ByItsValues:
    sector = Sector(0, 1)

    def __call__(self, sigma):
        return np.tanh(sigma)


def test_what_is_no_question_about_a_region_is_refused():
    with pytest.raises(InputError, match="none is given"):
        region(([1], [1, 1]))
    with pytest.raises(InputError, match="give one for each channel"):
        region(([1], [1, 1]), [Saturation(), Saturation()])
    with pytest.raises(InputError, match="known by its values alone"):
        region(([1], [1, 1]), ByItsValues())
    with pytest.raises(InputError, match="asked of a known nonlinearity in each channel"):
        region(([1], [1, 1]), Sector(0, 1))


# x' = (U - 1) grad U with U = 20 x1^2 + x2^2 is attracted from U < 1 alone, which holds x'x <= 1/20 and no larger disc;
# solvers have printed 1/15.  By polarisation, x1 x2^2 = ((x1 + x2)^3 + (x1 - x2)^3 - 2 x1^3)/6, it is a loop of four
# cubics.
@pytest.mark.slow
def test_a_level_beyond_the_boundary_of_the_region_is_never_certified():
    B = [["-2360/3", 0, "-20/3", "-20/3"], [0, "34/3", "-20/3", "20/3"]]
    plant = MultivariablePlant(
        rows([[-40, 0], [0, -2]]),
        tuple(tuple(map(Fraction, row)) for row in B),
        rows([[1, 0], [0, 1], [1, 1], [1, -1]]),
        rows([[0] * 4] * 4),
    )
    A, inward, C, _ = plant.doubles()
    x = np.random.default_rng(4).normal(size=(50, 2))
    U = 20 * x[:, 0] ** 2 + x[:, 1] ** 2
    assert np.allclose(x @ A.T - (x @ C.T) ** 3 @ inward.T, (U - 1)[:, None] * x * [40, 2])
    good = proved_ellipsoid(plant, [shape_of(Cubic(cubic=1))] * 4, None).certificate
    for P in ([["15"], ["0", "15"]], [["999/50"], ["0", "999/50"]], [["20"], ["0", "999/1000"]]):
        assert_both_reject(edited(good, "proof", "P", value=P))
    assert volume_below(matrix_of(good)) < math.pi / math.sqrt(20)
    assert Fraction(2237, 10000) ** 2 * matrix_of(good)[0][0] > 1


LOCAL = """
[plant]
A = [[1]]
B = [1]
C = [1]
[class]
sector = [2, 3]
on = [-1, 2]
"""


def test_a_class_on_an_interval_from_a_file(tmp_path, capsys):
    file = tmp_path / "plant.toml"
    file.write_text(LOCAL)
    system = read_system(file)
    assert system.local == (LocalSector(2, 3, 1),)
    assert parse_system(loop_to_toml(system), name="again", source="a text").local == system.local
    assert 0.999 < region(system).area[0] / 2 < 1  # as in Python
    assert main(["certify", str(file)]) == main(["report", str(file), "-o", str(tmp_path / "r")]) == 2
    assert "hold on an interval alone" in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("on = [-1, 2]", "on = [1, 2]", "give an interval around 0"),
        ("on = [-1, 2]", "on = [-inf, inf]", "the whole line"),
        ("sector = [2, 3]", "slope = [2, 3]", "give sector = [l, u], finite"),
        ("on = [-1, 2]", "on = [-1, 2]\nodd = true", "beside other keys"),
        ("on = [-1, 2]", "on = [-1, 2]\nrepeated = 2", "about 2 channels"),
        ("[class]", "[nonlinearity]\nkind = 'tanh'\n[class]", "beside a nonlinearity"),
    ],
)
def test_bad_intervals_are_refused_in_a_sentence(tmp_path, capsys, old, new, words):
    file = tmp_path / "plant.toml"
    file.write_text(LOCAL.replace(old, new))
    assert main(["region", str(file)]) == 2
    assert words in " ".join(capsys.readouterr().err.split())


# x+ = x + 0.1 (y, -x - y) + 0.1 (0, x^3): ellipsoids with other intervals go farther along the axes of the largest one,
# and where each of them holds a point the others do not, their union is larger.
@pytest.mark.slow
def test_ellipsoids_with_other_intervals_are_united():
    loop = as_plant(([[1, "0.1"], ["-0.1", "0.9"]], [0, "0.1"], [1, 0], 0), dt=Fraction(1, 10))
    found = region(loop, Cubic(linear=0, cubic=-1))
    first, *more = found.sets
    assert more
    assert found.area[0] > 1.05 * first.volume
    assert "Together with" in str(found)
    for one in more:
        assert recheck(json.dumps(dict(one.proof.certificate))).accepted
        values, axes = np.linalg.eigh(np.array(first.P, dtype=float))
        ends = (axes / np.sqrt(values)).T  # of the axes of the first
        assert one.values(ends).min() < 0.99


# sat(sigma) = sigma - dz(sigma): (A, B, C) with a saturation is (A - B C, -B, C) with a dead zone, whose slope falls
# from 0 to 1 outward: a line of slope 1 with limits, where that of a saturation has slope 0.
@pytest.mark.parametrize(
    ("A", "B", "dt"),
    [([[0, 1], [1, 0]], [0, 1], None), ([["1", "0.1"], ["0.1", "1"]], ["0", "0.1"], Fraction(1, 10))],
)
def test_a_dead_zone_around_the_closed_loop_is_a_saturation(A, B, dt):
    C, b = [3, 4], [Fraction(v) for v in B]
    closed = [[Fraction(v) - u * c for v, c in zip(row, C, strict=True)] for row, u in zip(A, b, strict=True)]
    saturated = MultivariablePlant.of_one_channel(as_plant((A, B, C, 0), dt=dt))
    around = MultivariablePlant.of_one_channel(as_plant((closed, [-v for v in b], C, 0), dt=dt))
    loops = (saturated, shape_of(Saturation())), (around, shape_of(DeadZone(width=1, gain=1)))
    inside = [proved_ellipsoid(plant, [shape], None) for plant, shape in loops]
    sizes = [volume_below(matrix_of(one.certificate)) for one in inside]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-3)
    outside = [proved_growth(plant, [shape]) for plant, shape in loops]
    assert np.allclose(
        *(np.array(matrix_of(one.certificate, "Q"), dtype=float) for one in outside), rtol=1e-2, atol=1e-4
    )
    for one in (*inside, *outside):
        assert recheck(json.dumps(dict(one.certificate))).accepted


# x^2 + 2 y^2 + 5 z^2 <= 1 or 2 x^2 + y^2 + 5 z^2 <= 1: the first reaches farther where |y| <= |x|, the share
# 2 atan(sqrt 2)/pi of a ball in (x, sqrt 2 y, sqrt 5 z), and the other where it does not: 16 atan(sqrt 2)/(3 sqrt 10).
# Of two ellipses, 1, 2 and 2, 1, it is 4 atan(sqrt 2)/sqrt 2
def test_the_volume_of_a_union_is_known_from_below_to_a_few_thousandths():
    def ellipsoid(*weights):
        return lambda points: points**2 @ np.array(weights)

    exact = 16 * math.atan(2**0.5) / (3 * 10**0.5)
    for turn in (np.eye(3), np.diag([1, 0.7, 0.45])):
        found = union_volume([ellipsoid(1, 2, 5), ellipsoid(2, 1, 5)], turn)
        assert 0.997 * exact < found < exact
    plane = 4 * math.atan(2**0.5) / 2**0.5
    assert (1 - 1e-5) * plane < union_volume([ellipsoid(1, 2), ellipsoid(2, 1)], np.eye(2)) < plane


# x1' = x2, x2' = x3, x3' = x1 - sat(3 x1 + 5 x2 + 4 x3)
@pytest.mark.slow
def test_three_states_have_the_volume_of_a_union_too():
    found = region(as_plant(([[0, 1, 0], [0, 0, 1], [1, 0, 0]], [0, 0, 1], [3, 5, 4], 0)), Saturation())
    assert len(found.sets) > 1
    assert found.area[0] > 1.02 * found.sets[0].volume
    assert found.to_dict()["area"][0] == found.area[0]


def test_a_panic_of_the_solver_ends_the_search_and_no_more(monkeypatch):
    class PanicException(BaseException):  # what a compiled solver raises is no Exception
        pass

    class Solver:
        def __init__(self, *_):
            pass

        def solve(self):
            raise PanicException("Eigval error")

    monkeypatch.setattr("clarabel.DefaultSolver", Solver)
    found = region(as_plant(([[0, 1], [1, 0]], [0, 1], [3, 4], 0)), "tanh(sigma)")
    assert (found.verdict, found.reason) == (Verdict.INCONCLUSIVE, "no invariant ellipsoid was found")


def test_why_nothing_is_said_of_a_disturbance_is_a_sentence():  # x' = x - sum sat(x) + w with 12 terms
    plant = as_plant(([[1]], [[1] * 12], [[1]] * 12, [[0] * 12] * 12))
    found = region(plant, [Saturation()] * 12, disturbance=[[1]])
    assert found.reachable is None
    assert str(found).endswith("Disturbances are asked about with fewer than 12 channels, and the loop has 12.")
