"""What mutants of the second checker lived through: each line here fails where one of its hypotheses is left out."""

import copy
import json
from fractions import Fraction
from pathlib import Path

import pytest
from flint import arb, arb_mat, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second import recheck
from lure.analysis.certificates.second.axis import require_same
from lure.analysis.certificates.second.frequencies import require_vertices
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.orbits import Stay, Watched, _Equations
from lure.analysis.certificates.second.reading import NotShown, count, mapping, number

STORED = json.loads((Path(__file__).parents[1] / "support" / "certificates.json").read_text())
SWITCHED = [name for name, one in STORED.items() if one["proof"]["method"] == "switched-gain"]


@pytest.mark.parametrize("name", SWITCHED)
def test_each_of_the_gains_that_jump_lies_in_the_class(name):
    certificate = copy.deepcopy(STORED[name])
    assert recheck(certificate).accepted
    gains = [Fraction(g) for g in certificate["proof"]["gains"]]
    assert min(gains) < max(gains)
    top = (min(gains) + max(gains)) / 2  # some gains are in this class, and not all
    certificate["laws"]["sector"][1] = str(top)
    assert "not in the class" in recheck(certificate).reason


def test_the_coefficients_written_are_not_those_of_the_negative_inequality():
    own = fmpq_poly([1, 2, 3])
    require_same(2 * own, own, [])
    with pytest.raises(NotShown, match="not those of the inequality"):
        require_same(-own, own, [])


# det(1 + D G) = 1 - g: it vanishes at the gain 1 and at no smaller one
@pytest.mark.parametrize(("width", "regular"), [(Fraction(9, 10), True), (Fraction(1), False), (Fraction(2), False)])
def test_a_loop_is_well_posed_at_the_vertices_too(width, regular):
    D = fmpq_mat([[-1]])
    if regular:
        require_vertices(D, [width])
        return
    with pytest.raises(NotShown, match="vanishes"):
        require_vertices(D, [width])


@pytest.mark.parametrize("value", [3, [1], None, {1: 2}])
def test_what_is_no_object_of_json_is_refused(value):
    with pytest.raises(NotShown, match="object is missing"):
        mapping(value)


@pytest.mark.parametrize(("read", "value"), [(number, 0.5), (number, True), (number, None), (count, -1), (count, True)])
def test_what_is_no_number_of_a_file_is_refused(read, value):
    with pytest.raises(NotShown):
        read(value)


# y = sin t, which is 1 at pi/2 and below 0 from pi on; it begins at 0, where it ascends
@pytest.mark.parametrize(
    ("low", "high", "enters", "duration", "stays"),
    [
        (Fraction(-1, 2), Fraction(9, 10), 0, Fraction(5, 2), False),
        (Fraction(-1, 2), Fraction(11, 10), 0, Fraction(5, 2), True),
        (Fraction(-1, 10), Fraction(2), 0, Fraction(7, 2), False),
        (Fraction(-1, 10), Fraction(2), 0, Fraction(3), True),
        (Fraction(0), None, 1, Fraction(3), True),
        (Fraction(0), None, 1, Fraction(7, 2), False),
    ],
)
def test_a_solution_stays_on_its_piece_from_beginning_to_end(low, high, enters, duration, stays):
    G = (
        (Fraction(0), Fraction(1), Fraction(0)),
        (Fraction(-1), Fraction(0), Fraction(0)),
        (Fraction(0), Fraction(0), Fraction(0)),
    )
    one = Watched(row=(Fraction(1), Fraction(0), Fraction(0)), low=low, high=high, enters=enters, leaves=0)
    with working_precision(128):
        equations = _Equations(2, [Stay(G=G, entry=one.row, watched=(one,))], half=False)
        start = arb_mat([[0], [1], [1]])
        assert equations.on_its_piece(0, one, start, arb(fmpq(duration.numerator, duration.denominator))) is stays
