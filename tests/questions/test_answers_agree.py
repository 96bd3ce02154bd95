"""One question, one answer: ``analyse`` and ``certify`` say the same of a loop and a class."""

import pytest

from lure import Sector
from lure.analysis import Verdict, analyse, certify, max_sector, max_slope
from lure.classes import NonlinearityClass, SlopeBounds
from lure.nonlinearities import Cubic, LeakyReLU

PROVED, REFUTED = Verdict.PROVED, Verdict.REFUTED


def sloped(sector, slope):
    return NonlinearityClass(sector=sector, slope=slope)


CASES = {
    # s^2 + k = 0 has its roots on the axis for every k > 0, and a double one at 0 for k = 0
    "1/s^2, slope from 0.0375 on": ("1/s^2", sloped(Sector(0.0375, 0.3), SlopeBounds(0.0375, 0.3)), REFUTED),
    "1/s^2, sector from 1 on": ("1/s^2", Sector(1, 3), REFUTED),
    "1/s^2, leaky ReLU": ("1/s^2", LeakyReLU(negative_slope=0.09, positive_slope=0.9), REFUTED),
    # z^2 - 2 z + 1 + k = 0: the product of the roots is 1 + k > 1
    "1/(z-1)^2": ("1/(z-1)^2", Sector(0.5, 1), REFUTED),
    # arctan 5 w + 0.2 w = pi at w = 7.98, where |1 + 5 i w| = 39.9: that gain lies in [26.25, inf]
    "dead time, cubic": ("exp(-0.2*s)/(5*s+1)", Cubic(linear=26.25, cubic=1), REFUTED),
    # w + arctan w = pi at w = 2.029, where |1 + i w| = 2.262
    "dead time, from below 0, with an unstable gain": ("exp(-s)/(s+1)", Sector(-0.5, 5), REFUTED),
    # |H| <= 1, so |H - 1/2| < 3/2: the disk on [-1, 2] = [-1/1, 1/0.5] holds the Nyquist plot, and touches it nowhere
    "dead time, from below 0, without": ("exp(-s)/(s+1)", Sector(-0.5, 1), PROVED),
    "dead time, slopes from below 0": ("exp(-s)/(s+1)", sloped(Sector(0, 1), SlopeBounds(-1, 1)), PROVED),
    # H(inf) = 1: with phi = -sigma the loop has no solution, and phi(sigma)/sigma >= 0 excludes it
    "least slope -1/H(inf), outside the sector": ("(s+2)/(s+1)", sloped(Sector(0, 3), SlopeBounds(-1, 5)), PROVED),
    "least slope -1/H(inf), nothing else": ("(s+2)/(s-1)", sloped(Sector(0, 3), SlopeBounds(-1, 5)), REFUTED),
    "least gain -1/H(inf)": ("(s+2)/(s+1)", Sector(-1, 3), REFUTED),
    "least slope and gain -1/H(inf)": ("(s+2)/(s+1)", sloped(Sector(-1, 3), SlopeBounds(-1, 3)), REFUTED),
}


@pytest.mark.slow_for("dead time")  # half a second to two each
@pytest.mark.parametrize("name", CASES)
def test_analyse_and_certify_agree(name):
    plant, phi, verdict = CASES[name]
    looked, check_for_class = analyse(plant, phi), certify(plant, phi)
    assert (looked.verdict, check_for_class.verdict) == (verdict, verdict)
    assert looked.code == check_for_class.code


@pytest.mark.parametrize("ask", [max_sector, max_slope])
@pytest.mark.parametrize("lower", [0, 0.25, 1])
def test_a_lower_gain_with_poles_on_the_axis_refutes_every_class(ask, lower):
    found = ask("1/s^2", lower=lower)
    assert found.verdict is REFUTED
    assert found.refuted_at == lower
    assert found.refutation.certificate["proof"] == {"method": "linear-gain", "gain": f"{found.lower}"}
    said = {0: "phi = 0", 0.25: "phi = 0.25 sigma", 1: "phi = sigma"}[lower]
    assert f"{said} (certified)" in str(found.conclusion)


@pytest.mark.slow
@pytest.mark.parametrize("lower", [-0.5, 0, 0.5])
def test_with_dead_time_the_upper_bound_that_would_be_proved_is_advised(lower):
    advised = analyse("exp(-s)/(s+1)", Sector(lower, 5)).hints
    assert any("upper bound of 2.2618" in hint for hint in advised)


@pytest.mark.slow
def test_with_dead_time_each_row_says_what_was_asked_of_it():
    # sectors from 1/2 on are asked about as a list of one, slopes from 0 on are not; both end at 2.262, not at a factor
    found = analyse("exp(-s)/(s+1)", sloped(Sector(0.5, 1), SlopeBounds(0, 1)))
    assert {(row.question, row.lower) for row in found.rows} == {("sector", 0.5), ("slope", 0)}
    assert all(2.2 < row.refuted_at < 2.3 for row in found.rows if not row.time_varying)
    assert found.verdict is PROVED
