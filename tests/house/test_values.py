"""Every system, nonlinearity and result pickles, copies and compares."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction

import numpy as np
import pytest
from results import RESULTS, SYSTEMS

import lure
import lure.analysis
from lure import Loop, NonlinearityClass, Saturation, Sector, builtin_loop
from lure.analysis import certify, max_sector
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.record import same
from lure.rod import builtin_system

THIRD, LAG = ([1], [1, 3, 2, 0]), ([1], [1, 1])


def rod():
    return builtin_system("paper-rod")


MADE = {  # what is no record
    "Rod": lambda: rod().rod,
    "Expression": lambda: lure.Expression.parse("sigma**2", variables=("sigma",)),
    "Proved": lambda: certify(Loop(LAG, Saturation())).shown,
    "Refuted": lambda: certify("1/(s-1)", NonlinearityClass(sector=Sector(0, 0.5))).shown,
}


@pytest.mark.parametrize("name", MADE)
@pytest.mark.parametrize("again", [lambda it: pickle.loads(pickle.dumps(it)), copy.copy, copy.deepcopy])
def test_what_comes_back_is_equal(name, again):
    made = MADE[name]()
    found = again(made)
    assert type(found) is type(made)
    assert (found == made) is True
    assert (found != made) is False
    assert (found == object()) is False


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
    samples = {type(make()).__name__ for make in (MADE | RESULTS).values()} | {
        type(system).__name__ for system in SYSTEMS.values()
    }
    left_out = {"AssumptionError", "InputError", "Plant", "Nonlinearity"}  # errors and protocols
    left_out |= {"Boundary", "Matching", "Numerics", "Verdict"}  # enums and options
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
