"""lure.analysis.rod.spectrum: every regime of the dashpot, the numbers of the paper, and the scheme against the rod."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import decades, ratios, rods, with_damping

from lure import AssumptionError
from lure.analysis.rod.spectrum import LISTED_MODES, rod_spectrum, wave_mode
from lure.rod import RodPlant, upwind
from lure.rod.systems import paper_rod, rod_from_exact

CELLS = [1, 2, 3, 10, 1000]
cells = st.integers(1, 1000)


def spectrum(damping, N):
    return rod_spectrum(upwind(paper_rod(damping), N))


# s = 6000 N = 6e4, -a = 1.1998/1.2002, |a|^{1/20} = exp(-3.33333e-4/20) = 1 - 1.66665e-5.  Slowest mode, m = 0:
# 6e4 * 1.66665e-5 = 1.0 1/s.  First elastic mode, m = 1: 6e4 (|a|^{1/20} e^{i pi/10} - 1) = 6e4 (-0.04896 + 0.30901 i);
# in the rod it decays at 3000 ln(1.2002/1.1998) = 1.0 1/s and turns at pi/T = 18849.6 rad/s.
def test_the_decay_rates_of_the_paper():
    found = spectrum("2e-4", 10)
    assert found.zero_multiplicity == 1
    assert found.residue_at_zero == 0.125
    assert found.decay_scheme == pytest.approx(1.0, abs=2e-5)
    assert found.decay_rod == pytest.approx(3000 * math.log(1.2002 / 1.1998), rel=1e-12)
    assert found.elastic_scheme.real == pytest.approx(6e4 * (math.cos(math.pi / 10) - 1), abs=1.0)
    assert -found.elastic_scheme.real == pytest.approx(2.9e3, rel=0.02)
    assert found.elastic_scheme.imag == pytest.approx(6e4 * math.sin(math.pi / 10), abs=1.0)
    assert found.elastic_rod == pytest.approx(complex(-1.0, 6000 * math.pi), rel=1e-7)


# so of the damping of the first elastic mode in the scheme all but 1/2937.6 is numerical, and the plot "settles" in
# 3/2937 s = 1 ms, as figures 6 and 7 do, where the rod needs seconds
def test_the_damping_of_the_first_elastic_mode_is_numerical():
    zero, first = spectrum("2e-4", 10).modes[:2]
    assert first.numerical_share == pytest.approx(1 - 1 / 2937.6, abs=1e-5)
    assert abs(zero.numerical_share) < 2e-5


# Re of s (|a|^{1/2N} e^{i pi m/N} - 1) is ln|a|/2T - (pi m)^2 s/(2 N^2) + ..: the numerical part falls as 1/N
def test_numerical_damping_falls_with_the_number_of_cells():
    added = [spectrum("0.3", N).elastic_rod.real - spectrum("0.3", N).elastic_scheme.real for N in (250, 500, 1000)]
    assert added[-1] == pytest.approx(math.pi**2 * 6000 / (2 * 1000), rel=0.05)
    assert added[0] / added[1] == pytest.approx(2, rel=0.02)
    assert added[1] / added[2] == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize("damping", ["2e-4", "0.3", "5", "-0.3", "-7", "0"])
def test_each_mode_of_the_scheme_tends_to_its_mode_of_the_rod(damping):
    errors = []
    for N in (1000, 10_000, 100_000):
        modes = spectrum(damping, N).modes
        errors.append(max(abs(mode.scheme - mode.rod) / (1 + abs(mode.rod)) for mode in modes))
    assert errors[0] < 0.1
    assert errors[1] < 0.11 * errors[0]
    assert errors[2] < 0.11 * errors[1]


@pytest.mark.parametrize("N", CELLS)
def test_without_damping_the_zero_is_double(N):
    found = spectrum("0", N)
    assert found.zero_multiplicity == 2
    assert found.residue_at_zero is None
    assert found.decay_scheme == found.decay_rod == 0
    assert not math.copysign(1, found.decay_scheme) < 0
    assert not found.unstable
    assert str(found).startswith("zero eigenvalue double; ")
    assert math.isnan(found.modes[0].numerical_share)
    assert found.modes[1].numerical_share == 1  # all of it


@pytest.mark.parametrize("damping", [Fraction(1, 10**300), Fraction(-1, 10**300), Fraction(1, 10**40)])
def test_the_least_damping_makes_the_zero_simple(damping):
    found = rod_spectrum(upwind(with_damping(paper_rod(), damping), 10))
    assert found.zero_multiplicity == 1
    assert found.residue_at_zero == pytest.approx(float(Fraction("0.25e-4") / damping), rel=1e-15)


@pytest.mark.parametrize("N", CELLS)
def test_the_matched_rod_has_no_modes_and_the_scheme_one_jordan_block(N):
    found = spectrum("1.2", N)
    assert found.zero_multiplicity == 1
    assert found.residue_at_zero == pytest.approx(1 / 48000, rel=1e-15)  # A/Z = d
    assert found.jordan_size == 2 * N
    assert found.modes == ()
    assert (found.decay_scheme, found.decay_rod) == (6000 * N, math.inf)
    assert (found.elastic_scheme, found.elastic_rod) == (-6000 * N, None)


def test_a_rod_matched_in_doubles_is_matched():
    rod = with_damping(paper_rod(), Fraction(11, 7))
    rod = with_damping(rod, rod.impedance)
    assert rod_spectrum(upwind(rod, 50)).jordan_size == 100


@pytest.mark.parametrize("N", CELLS)
@pytest.mark.parametrize("damping", ["-1e-6", "-0.3", "-1.1999"])
def test_weak_negative_damping_makes_a_mode_grow_in_scheme_and_rod(N, damping):
    found = spectrum(damping, N)
    assert found.unstable
    assert found.decay_rod < 0
    assert found.decay_scheme < 0
    assert found.residue_at_zero < 0
    assert found.zero_multiplicity == 1


# k = -3Z = -3.6: a = 2 and with one cell the wave eigenvalues are s (+- i sqrt 2 - 1); the rod grows at ln 2/(2T)
def test_strong_negative_damping_grows_in_the_rod_but_not_in_every_scheme():
    found = spectrum("-3.6", 1)
    assert found.decay_scheme == pytest.approx(6000)
    assert found.elastic_scheme == pytest.approx(6000 * complex(-1, math.sqrt(2)))
    assert found.decay_rod == pytest.approx(-3000 * math.log(2))
    assert found.unstable
    assert found.residue_at_zero == pytest.approx(0.25e-4 / -3.6)
    assert spectrum("-3.6", 1000).decay_scheme < 0


@given(rod=rods(), N=cells)
def test_for_positive_damping_the_slowest_rate_is_that_of_the_listed_eigenvalues(rod, N):
    scheme = upwind(rod, N)
    found, values = rod_spectrum(scheme), scheme.eigenvalues()
    assert found.decay_scheme > 0
    assert found.decay_rod > 0
    assert found.decay_scheme == pytest.approx(-np.max(values.real), rel=1e-14)
    for mode in found.modes:
        assert np.min(np.abs(values - mode.scheme)) <= 1e-14 * abs(mode.scheme)


@given(rod=rods(ratio=1.0), ratio=ratios(), N=st.integers(1, 40))
def test_the_modes_of_the_rod_are_its_poles_and_share_one_decay_rate(rod, ratio, N):
    rod = with_damping(rod, Fraction(ratio * rod.impedance))
    found, poles = rod_spectrum(upwind(rod, N)), RodPlant(rod).poles(LISTED_MODES)
    for mode in found.modes:
        assert np.min(np.abs(poles - mode.rod)) <= 1e-14 * abs(mode.rod)
        assert -mode.rod.real == pytest.approx(found.decay_rod, rel=1e-14)
    listed = min(N, LISTED_MODES) + (1 if rod.reflection < 0 else 0)
    assert len(found.modes) == (listed if rod.reflection else 0)


# an elastic mode of the scheme loses what the rod loses and what upwinding adds: |a|^{1/2N} cos <= |a|^{1/2N}
@given(rod=rods(ratio=1.0), ratio=st.one_of(decades(-6, -0.01), decades(0.01, 3)), N=cells)
def test_the_scheme_damps_every_elastic_mode_more_than_its_own_slowest_circle(rod, ratio, N):
    scheme = upwind(with_damping(rod, Fraction(ratio * rod.impedance)), N)
    radius = abs(scheme.rod.reflection) ** (1 / (2 * N))
    for mode in rod_spectrum(scheme).modes:
        assert abs(1 + mode.scheme / scheme.rate) == pytest.approx(radius, rel=1e-13)
        assert mode.scheme.real <= scheme.rate * (radius - 1) + 1e-13 * scheme.rate


@given(rod=rods(), N=cells, factor=decades(-3, 3))
def test_a_longer_rod_has_slower_modes(rod, N, factor):
    longer = rod_from_exact({**rod.exact, "length": rod.exact["length"] * Fraction(factor)})
    one, other = rod_spectrum(upwind(rod, N)), rod_spectrum(upwind(longer, N))
    assert other.decay_scheme * factor == pytest.approx(one.decay_scheme, rel=1e-12)
    assert other.residue_at_zero == one.residue_at_zero


def test_the_cost_does_not_grow_with_the_number_of_cells():
    found = spectrum("2e-4", 10_000_000)
    assert len(found.modes) == LISTED_MODES + 1
    assert found.elastic_scheme == pytest.approx(found.elastic_rod, rel=1e-5)


# for k < Z the slowest mode is no. 0, which does not oscillate, for k > Z the first that does: two decays that differ
# by a factor 2938 are named as what they are, and one that is both is named once
def test_a_spectrum_prints_as_a_sentence_that_tells_the_slowest_mode_from_the_first_that_oscillates():
    assert str(spectrum("2e-4", 10)) == (
        "zero eigenvalue simple; every wave mode of the rod decays at 1 1/s, in the scheme the slowest decays at "
        "0.999992 1/s and does not oscillate, the first that oscillates at 2937.56 1/s"
    )
    above, matched = spectrum("5", 10), spectrum("1.2", 10)
    assert above.decay_scheme == -above.elastic_scheme.real
    assert str(above).endswith(f"in the scheme the slowest decays at {above.decay_scheme:.6g} 1/s")
    assert str(matched).endswith("; the rod has no wave modes, those of the scheme decay at 60000 1/s")


@pytest.mark.parametrize(
    ("damping", "number", "N", "message"),
    [
        ("1.2", 1, 10, "the scheme with 10 cells has no wave mode 1 for a = 0"),
        ("1.2", 1, None, "the rod has no wave mode 1 for a = 0"),
        ("5", 0, None, "the rod has no wave mode 0 for a = "),
        ("2e-4", -1, 10, "the scheme with 10 cells has no wave mode -1 "),
        ("2e-4", 11, 10, "the scheme with 10 cells has no wave mode 11 "),
    ],
)
def test_a_mode_that_is_not_there_is_refused(damping, number, N, message):
    with pytest.raises(AssumptionError, match=f"^{message}"):
        wave_mode(paper_rod(damping), number, N)
