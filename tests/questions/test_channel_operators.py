"""Norm-bounded operators in several channels: both sides of the largest factor against values known otherwise."""

from itertools import product

import numpy as np
import pytest
from depth import rarely

from lure import Diagonal, InputError, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis.certificates.second.opinion import recheck
from lure.files import find_system
from lure.files.loop import loop_to_toml

ANY = NonlinearityClass.norm_bounded(1)
INVARIANT = NonlinearityClass.norm_bounded(1, dynamics="linear time-invariant")
SCALAR = NonlinearityClass.norm_bounded(1, dynamics="scalar linear time-invariant")


def largest_singular_value(plant, points):
    return np.linalg.norm(plant.transfer(points), 2, axis=(1, 2)).max()


# one block alone: the small gain theorem is sharp, |Delta| < 1/||H||, for any causal operator and for linear ones
@pytest.mark.slow
@pytest.mark.parametrize(("dt", "one"), rarely(product((None, 1), (ANY, INVARIANT)), (None, ANY), (1, INVARIANT)))
def test_one_operator_alone_reaches_the_inverse_of_the_norm_from_both_sides(one, dt):
    A = [[-0.4, -1.0], [1.0, -0.2]] if dt is None else [[0.5, -0.6], [0.6, 0.2]]
    plant = as_plant((A, [[1, 0.5], [0, 1]], [[1, 0], [0.3, 1]], [[0, 0], [0, 0]]), dt=dt)
    points = 1j * np.linspace(0, 4, 40001) if dt is None else np.exp(1j * np.linspace(0, np.pi, 40001))
    found = max_sector(plant, Diagonal((one, one), repeated=True))
    assert found.closed
    assert found.largest.low * largest_singular_value(plant, points) == pytest.approx(1, abs=1e-6)


# singular values that are equal, at a frequency where H is real: M/(s + 1) with M normal, |M| at omega = 0
@pytest.mark.slow
@pytest.mark.parametrize(("M", "size"), [([[1, 0], [0, 1]], 1), ([[1, 2], [-2, 1]], 5**0.5)])
def test_an_operator_around_a_normal_matrix_is_refuted_at_the_norm(M, size):
    plant = as_plant(([[-1, 0], [0, -1]], M, [[1, 0], [0, 1]], [[0, 0], [0, 0]]))
    found = max_sector(plant, Diagonal((ANY, ANY), repeated=True))
    assert found.largest.low < 1 / size < found.refuted_at < (1 + 1e-6) / size


# three operators: scalings for each frequency leave nothing open (Packard and Doyle 1993), so both sides meet
@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [2, pytest.param(1, marks=pytest.mark.thorough), pytest.param(6, marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize("dt", [None, pytest.param(1, marks=pytest.mark.thorough)])
def test_several_operators_are_refuted_where_the_proof_ends(seed, dt):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(6, 6))
    poles = np.linalg.eigvals(A)
    A = np.round(8 * A - 8 * (poles.real.max() + 0.3) * np.eye(6)) / 8 if dt is None else A * 0.8 / np.abs(poles).max()
    B, C = (np.round(8 * rng.normal(size=shape)) / 8 for shape in ((6, 3), (3, 6)))
    found = max_sector(as_plant((np.round(64 * A) / 64, B, C, np.zeros((3, 3))), dt=dt), [INVARIANT] * 3)
    assert found.largest.low > found.refuted_at * (1 - 1e-3)
    assert recheck(dict(found.refutation.certificate)).accepted


@pytest.mark.slow
def test_time_invariant_operators_have_scalings_that_others_have_not():
    # H = [[0, a], [b, 0]] with |a| = 1/|1 + s|, |b| = |s|/|1 + s|: det(1 + H Delta) = 1 - a b Delta_1 Delta_2, so the
    # truth is 1/r^2 = max |a b| = 1/2 for linear ones; with constant scalings max(|a| d, |b|/d) >= 1
    rows = [["0", "1/(s+1)"], ["s/(s+1)", "0"]]
    found = [max_sector(as_plant(rows), [one, one]) for one in (ANY, INVARIANT)]
    assert found[0].largest.low == pytest.approx(1, rel=1e-6)
    assert found[1].criterion == "matrix-zames-falb"
    assert 1.4 < found[1].largest.low < 2**0.5
    assert found[1].refuted_at == pytest.approx(2**0.5, rel=1e-6)


# delta I beside H: 1/max rho(H); H = [[1, 2], [0, 1/2]]/(s + 1) has the eigenvalue 1/(s + 1), of modulus 1 at 0, where
# |H| is 2.29; in discrete time [[1, 2], [0, 1/2]]/(2 z + 1), of modulus 1 at z = -1
@pytest.mark.slow
@pytest.mark.parametrize(("below", "dt"), rarely([("(s+1)", None), ("(2*z+1)", 1)], ("(2*z+1)", 1)))
def test_one_scalar_operator_in_two_channels_reaches_the_inverse_of_the_spectral_radius(below, dt):
    plant = as_plant([[f"1/{below}", f"2/{below}"], ["0", f"1/(2*{below})"]], dt=dt)
    found = [max_sector(plant, Diagonal((one, one), repeated=True)) for one in (SCALAR, INVARIANT)]
    assert found[0].largest.low == pytest.approx(1, rel=1e-6)
    assert found[0].refuted_at == pytest.approx(1, rel=1e-6)
    assert found[1].refuted_at < 0.44
    shown = (found[0].proof, found[0].refutation)
    assert all(recheck(dict(one.certificate)).accepted for one in shown)


# s + 1 + g J, J = [[0, -1], [1, 0]], has the eigenvalues -1 +- i g: no gain in both channels destabilises, and
# beside it 1/(s + 2) and an operator on a third channel meet at 2
@pytest.mark.slow
def test_one_gain_in_two_channels_beside_an_operator_has_skew_scalings():
    A, turn = np.diag([-1.0, -1, -2]), np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    one = NonlinearityClass.constant_gain(-1, 1)
    plant = as_plant((A, turn, np.eye(3), np.zeros((3, 3))))
    found = max_sector(plant, Diagonal((one, one, INVARIANT), repeated=(2, 1)))
    assert found.largest.low == pytest.approx(2, rel=1e-4)
    assert found.refuted_at == pytest.approx(2, rel=1e-6)


def test_a_file_says_that_one_operator_acts_in_each_of_two_channels(tmp_path):
    path = tmp_path / "loop.toml"
    rows = (
        'name = "two"\n[plant]\ntransfer = [["1/(s+1)", "1"], ["0", "1/(s+1)"]]\n[[class]]\nnorm = 0.5\nrepeated = 2\n'
    )
    path.write_text(rows + 'dynamics = "linear time-invariant"\n')
    system = find_system(str(path), [])
    assert str(system.classes) == "scalar linear time-invariant operator phi_1 = phi_2 of norm <= 0.5"
    path.write_text(loop_to_toml(system))
    assert find_system(str(path), []).classes == system.classes
    path.write_text(rows)
    with pytest.raises(InputError, match=r"class.repeated of an operator is 2|repeated of an operator is 2"):
        find_system(str(path), [])


@pytest.mark.slow
def test_operators_beside_a_sector_and_a_file_of_blocks_that_are_not_square(tmp_path):
    # x' = -x + mu_1 + mu_2, sigma_1 = (x, x): mu_1 = -Delta sigma_1, Delta a row of norm r, so |mu_1| <= sqrt(2) r |x|;
    # phi_2 in [0, k] helps: the factor of both is 1/(sqrt 2 r), with phi_2 = 0
    path = tmp_path / "loop.toml"
    path.write_text(
        'name = "block"\n[plant]\nA = [[-1]]\nB = [[1, 1]]\nC = [[1], [1], [1]]\nD = [[0, 0], [0, 0], [0, 0]]\n'
        "[[class]]\nnorm = 0.5\nsize = [1, 2]\n[[class]]\nsector = [0, 1]\n"
    )
    system = find_system(str(path), [])
    assert str(system.classes) == "operator (phi_1, phi_2) of norm <= 0.5; phi_3 in the sector [0, 1]"
    assert system.block.inputs == 3
    found = max_sector(system.block, system.classes)
    assert found.largest.low == pytest.approx(2**0.5, rel=1e-6)
    assert found.refuted_at == pytest.approx(2**0.5, rel=1e-6)
    assert "at rest" in str(found)
    again = tmp_path / "again.toml"
    again.write_text(loop_to_toml(system))
    assert find_system(str(again), []).classes == system.classes


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("norm = -1", "class.norm is -1; give a positive bound"),
        ("norm = 1\nodd = true", "norm is given beside other keys"),
        ("size = 2\nsector = [0, 1]", "are about 2 channels, and the plant has 1"),
        ('norm = 1\ndynamics = "fast"', "give 'any' or 'linear time-invariant'"),
        ("norm = 1\nsize = [1, 2]", "the blocks have 1 inputs and 2 outputs together"),
        ("norm = 1\nsize = 0", "give the rows and columns of the operator"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_in_one_sentence(tmp_path, table, message):
    path = tmp_path / "loop.toml"
    path.write_text(f"[plant]\nnum = [1]\nden = [1, 1]\n[[class]]\n{table}\n")
    with pytest.raises(InputError, match=message.replace("[", r"\[")):
        find_system(str(path), [])


@pytest.mark.slow
def test_one_channel_may_have_an_operator_and_a_list_says_so():
    assert certify("1/(s+1)", NonlinearityClass.norm_bounded(0.9)).verdict.name == "PROVED"
    assert certify("1/(s+1)", [NonlinearityClass.norm_bounded(1.1)]).verdict.name == "REFUTED"
    with pytest.raises(InputError, match="positive finite number"):
        NonlinearityClass.norm_bounded(0)
    with pytest.raises(InputError, match="last block"):
        Diagonal((NonlinearityClass.performance(), NonlinearityClass(sector=Sector(0, 1))))


# IQClab's demonstrations 1 to 5 are about one plant, whose D has a cycle; any loop is well posed as F > 0 at infinity
CYCLE = as_plant(([[-2, -3], [1, 1]], [[1, 0], [0, 0]], [[1, 0], [0, 0]], [[1, -2], [1, -1]]))


@pytest.mark.slow
def test_a_scalar_operator_has_scalings_where_d_has_a_cycle():
    # delta I destabilises from 1/rho on, the largest modulus of an eigenvalue of H; the norm of H is 1/.3016
    exact = 1 / np.abs(np.linalg.eigvals(CYCLE.transfer(1j * np.linspace(0.5, 2, 20001)))).max()
    assert exact == pytest.approx(0.469099, abs=1e-6)
    for share, verdict in ((0.995, "PROVED"), (1.005, "REFUTED")):
        one = NonlinearityClass.norm_bounded(exact * share, dynamics="scalar linear time-invariant")
        shown = certify(CYCLE, Diagonal((one, one), repeated=True))
        assert shown.verdict.name == verdict
        assert recheck(dict(shown.shown.certificate)).accepted


# 1/(s + 1) has the norm 1, so an operator of norm 3 may destabilise it. The certificate was about norms up to 1 + 1e-10
# and functions up to a third of the bound, and the sentence named these in place of the classes that were given
@pytest.mark.slow
def test_a_refutation_is_about_the_classes_that_were_given():
    plant = as_plant(([[-1, 0], [1, -2]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]))
    shown = certify(plant, [NonlinearityClass.norm_bounded(3), Sector(0, 1)])
    assert "L2 gain up to 3, at rest at first; channel 2" in str(shown)
    assert str(shown).endswith("from 0 up to 1")
    assert recheck(dict(shown.shown.certificate)).accepted
