"""Every system, law and result pickles, copies and compares."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from functools import cache

import control
import numpy as np
import pytest

import lure
import lure.analysis
from lure import Loop, NonlinearityClass, Saturation, Sector, SlopeBounds, as_plant, builtin_loop
from lure.analysis import analyse, certify, max_sector, max_slope, nonlinearity_bounds
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.graphical import nyquist_response, popov_response
from lure.analysis.theorems.passivity import passivity_indices
from lure.record import same
from lure.rod import builtin_system

THIRD, LAG = ([1], [1, 3, 2, 0]), ([1], [1, 1])
POINTS = {"points": [(0, 0), (1, 1)], "left_slope": 1, "right_slope": 0}


def rod():
    return builtin_system("paper-rod")


SYSTEMS = {
    "RationalPlant": lambda: as_plant(control.ss([[-1, 3], [0, -2]], [[1], [2]], [[1, 1]], 0)),
    "DelayPlant": lambda: as_plant("exp(-s)/(s+1)"),
    "StateSpace": lambda: lure.StateSpace([[-1.0]], [1], [1]),
    "FrequencyData": lambda: lure.FrequencyData([1.0, 2.0], [1, 2j], error=[0, np.nan]),
    "LinearBlock": lambda: lure.LinearBlock(-np.eye(2), np.ones(2), np.ones(2), np.ones(2)),
    "UpwindScheme": lambda: lure.rod.upwind(rod().rod, 5),  # sparse matrices
    "RodPlant": lambda: lure.rod.RodPlant(rod().rod),
    "Rod": lambda: rod().rod,
    "RodSystem": rod,
    "Scenario": lambda: rod().scenario,
    "Loop": lambda: Loop(THIRD, Saturation()),
    "LoopSystem": lambda: builtin_loop("contact"),
    "Transformed": lambda: lure.loop.sector_shift(as_plant(THIRD), NonlinearityClass(sector=Sector(1, 2))),
    "NonlinearityClass": lambda: NonlinearityClass.slope_restricted(0, 1, odd=True),
    "Sector": lambda: Sector(0, 1),
    "SlopeBounds": lambda: SlopeBounds(0, 1),
    "Saturation": lambda: Saturation(limit=2),
    "Tanh": lure.Tanh,
    "DeadZone": lure.DeadZone,
    "Cubic": lure.Cubic,
    "ReLU": lure.ReLU,
    "LeakyReLU": lure.LeakyReLU,
    "Quantiser": lure.Quantiser,
    "PiecewiseLinear": lambda: lure.PiecewiseLinear(**POINTS),
    "ExpressionNonlinearity": lambda: lure.ExpressionNonlinearity("sigma/(1+sigma**2)", sector=Sector(0, 1)),
    "Expression": lambda: lure.Expression.parse("sigma**2", variables=("sigma",)),
    "NormalCompliance": lambda: lure.rod.NormalCompliance(stiffness=4, exponent=2),
}
RESULTS = {
    "max_sector": lambda: max_sector(THIRD),
    "max_sector, time-varying": lambda: max_sector(([1], [1, 1, 1]), time_varying=True, search="full"),
    "max_sector, dead time": lambda: max_sector("exp(-s)/(s+1)"),
    "max_sector, rod": lambda: max_sector(lure.rod.RodPlant(rod().rod)),
    "max_sector, computed": lambda: max_sector(lure.StateSpace(-np.eye(3) + np.eye(3, k=1), [0, 0, 1], [1, 0, 0])),
    "max_sector, sampled": lambda: max_sector(lure.FrequencyData([1.0, 2.0], [1, 0.5])),
    "max_sector, refuted": lambda: max_sector("12/((s-1)*(s+3))"),
    "max_slope": lambda: max_slope(([1], [1, 2, 2, 1]), search="linear"),
    "max_slope, orbit": lambda: max_slope("(2*z+0.92)/(z^2-0.5*z)", odd=True),
    "analyse": lambda: analyse(Loop(LAG, Saturation())),
    "certify": lambda: certify(Loop(LAG, Saturation())),
    "certify, open": lambda: certify(THIRD, NonlinearityClass(sector=Sector(0, 2), time_varying=True)),
    "Proved": lambda: certify(Loop(LAG, Saturation())).shown,
    "Refuted": lambda: certify("1/(s-1)", NonlinearityClass(sector=Sector(0, 0.5))).shown,
    "nonlinearity_bounds": lambda: nonlinearity_bounds("tanh(sigma)"),
    "passivity_indices": lambda: passivity_indices("1/(s+1)"),
    "describing_hint": lambda: lure.analysis.describing.describing_hint("12/(s*(s+1)*(s+2))", Saturation()),
    "nyquist_response": lambda: nyquist_response(THIRD),
    "popov_response": lambda: popov_response(THIRD),
    "Measurements": lure.analysis.measured.example_measurements,
    "sector_from_data": lambda: lure.analysis.measured.sector_from_data(lure.analysis.measured.example_measurements()),
    "fit_compliance": lambda: lure.analysis.measured.fit_compliance(lure.analysis.measured.example_measurements()),
    "margin_from_data": lambda: lure.analysis.measured.margin_from_data(
        lure.analysis.measured.sector_from_data(lure.analysis.measured.example_measurements()), LAG
    ),
    "Bracket": lambda: lure.analysis.Bracket(0, 1),
}
MADE = SYSTEMS | RESULTS


@cache
def sample(name):
    return MADE[name]()


@pytest.fixture(params=MADE)
def made(request):
    return sample(request.param)


@pytest.mark.parametrize("again", [lambda it: pickle.loads(pickle.dumps(it)), copy.copy, copy.deepcopy])
def test_what_comes_back_is_equal(made, again):
    found = again(made)
    assert type(found) is type(made)
    assert (found == made) is True
    assert (found != made) is False
    assert (found == object()) is False
    if hasattr(made, "to_dict"):
        assert repr(found.to_dict()) == repr(made.to_dict())


class Forged:
    """Pickles as a proof that carries a state of its own."""

    def __reduce__(self):
        """Written as protocol 4 writes any object."""
        shown = max_sector(THIRD).conclusion.shown
        return (
            object.__new__,
            (Proved,),
            {"certificate": shown.certificate, "claim": "", "facts": {}, "theorem": "popov"},
        )


def test_a_proof_does_not_arrive_by_pickle_unchecked():
    with pytest.raises(TypeError, match="__init__"):
        pickle.loads(pickle.dumps(Forged()))


def test_no_public_type_is_left_out():
    samples = {type(sample(name)).__name__ for name in MADE}
    left_out = {"AssumptionError", "InputError", "Plant", "Nonlinearity"}  # errors and protocols
    left_out |= {"Boundary", "Matching", "Motion", "Numerics", "Evidence", "Verdict"}  # enums, options and a simulation
    public = {
        name
        for package in (lure, lure.analysis, lure.rod)
        for name in dir(package)
        if isinstance(getattr(package, name), type)
    }
    assert {name for name in public if not name.startswith("_")} - samples == left_out


def test_equal_by_value_means_every_entry():
    data = lure.FrequencyData([1.0, 2.0], [1, 2j])
    assert data == lure.FrequencyData([1.0, 2.0], [1, 2j])
    assert hash(data) == hash(lure.FrequencyData([1.0, 2.0], [1, 2j]))
    assert data != lure.FrequencyData([1.0, 2.0], [1, 3j])
    assert data != lure.FrequencyData([1.0], [1])
    assert data != lure.FrequencyData([1.0, 2.0], [1, 2j], dt=Fraction(1))
    assert Loop(LAG, Saturation()) == Loop(LAG, Saturation())
    assert Loop(LAG, Saturation()) != Loop(LAG, Saturation(limit=2))
    assert builtin_loop("contact") != builtin_loop("dead-zone")
    assert lure.rod.upwind(rod().rod, 5) != lure.rod.upwind(rod().rod, 6)
    assert same((1, [np.nan]), (1, [np.nan]))
    assert not same((1, [0.0]), (1, [0.0, 0.0]))
    assert not same({"a": 1}, {"b": 1})


def test_a_seal_is_not_copied_but_earned():
    proved = certify(Loop(LAG, Saturation())).shown
    assert type(proved) is Proved
    text = pickle.dumps(proved)
    assert b"sector" in text
    assert proved.claim not in str(text)  # the claim is what the checker says where it arrives
    reach = proved.certificate["laws"]["slope"]
    proved.certificate["laws"]["slope"] = ["0", "-2"]
    with pytest.raises((Rejected, ValueError)):
        pickle.loads(pickle.dumps(proved))
    with pytest.raises((Rejected, ValueError)):
        copy.deepcopy(proved)
    proved.certificate["laws"]["slope"] = reach


def test_another_process_answers():
    with ProcessPoolExecutor(1) as pool:
        found = pool.submit(max_sector, THIRD).result()
    assert found == max_sector(THIRD)
