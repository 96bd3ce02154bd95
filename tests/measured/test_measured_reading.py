"""Files of measurements: every way they are written, and one sentence for what cannot be read."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import InputError
from lure.analysis.measured import Measurements, read_measurements
from lure.analysis.measured.table import known_unit, split_heading

U, F = [1e-6, 2.5e-6, 4e-6], [1e-3, 2e-3, 4.5e-3]  # in metres and newtons, in every file below
SAME = {
    "comma": "depth [um],force [mN]\n1,1\n2.5,2\n4,4.5\n",
    "tabs and units in round brackets": "Depth (µm)\tLoad (uN)\n1\t1000\n2.5\t2000\n4\t4500\n",
    "the other sign for micro": "depth [μm],force [mN]\n1,1\n2.5,2\n4,4.5\n",
    "blanks under a comment": "% rubber\n%  depth [nm]   force [N]\n  1000   1e-3\n  2500  2.0d-3\n  4000  .0045\n",
    "decimal commas": "Weg / mm;Kraft / kN\n0,001;0,000001\n0,0025;2E-6\n0,004;4,5e-6\n",
    "decimal commas between blanks": "# depth_um force_mN\n1,0 1,0\n2,5 2,0\n4,0 4,5\n",
    "byte order mark, blank lines, old line ends": "\ufeffdepth [um],force [mN]\r\r1,1\r2.5,2\r\r4,4.5\r",
    "a line of units, and a title": "Pad 3\ntime,depth,force\n(s),(um),(mN)\n0,1,1\n1,2.5,2\n2,4,4.5\n",
    "columns and units in comments": "# names: load depth t\n# units: N m s\n.001 1e-6 0\n.002 2.5e-6 1\n.0045 4e-6 2",
    "the force first": "force [mN],indentation [um]\n1,1\n2,2.5\n4.5,4\n",
    "quoted": '"depth, corrected [um]","force [mN]"\n"1","1"\n"2.5","2"\n"4","4.5"\n',
    "separators at the ends of lines": "depth [um];force [mN];\n1;1;\n2.5;2;\n4;4.5;\n",
    "minus signs of typographers, comments between": "depth [um],force [mN]\n1,1\n# retract\n2.5,2\n4,4.5\n",
}


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_every_way_to_write_it_gives_the_same_numbers(text):
    found = read_measurements(text)
    np.testing.assert_allclose(found.displacement, U, rtol=1e-15)
    np.testing.assert_allclose(found.load, F, rtol=1e-15)
    assert found.unit == "N"
    assert found.notes == ()


def test_lines_are_those_of_the_file():
    found = read_measurements("# a\n\ndepth [um],force [mN]\n1,1\n\n2,nan\n3,3\n-,4\n5,5\n")
    assert found.lines.tolist() == [4, 7, 9]
    assert found.notes == ("Left out, since a number is missing or infinite: lines 6, 8 (2 in all).",)


def test_a_first_row_that_misses_a_number_is_a_row():
    assert read_measurements("depth [um],force [mN]\n1,nan\n2,2\n3,3\n4,4\n").notes[0].endswith("line 2 (1 in all).")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings(tmp_path, encoding):
    path = tmp_path / "data.txt"
    path.write_bytes("depth [µm];force [mN]\n1;1\n2,5;2\n4;4,5\n".encode(encoding))
    np.testing.assert_allclose(read_measurements(path).displacement, U, rtol=1e-15)
    assert read_measurements(str(path)).source == "data.txt"


def test_stress_and_area():
    text = "depth [mm],stress [MPa]\n1,1\n2,2\n3,3\n"
    assert read_measurements(text).load.tolist() == [1e6, 2e6, 3e6]
    found = read_measurements("depth [mm],force [N]\n1,1\n2,2\n3,3\n", area=25e-6)
    np.testing.assert_allclose(found.load, [4e4, 8e4, 1.2e5], rtol=1e-15)
    assert (found.unit, found.stiffness_unit) == ("Pa", "Pa/m")


def test_columns_by_name_by_heading_and_by_number():
    text = "t [s],u1 [um],u2 [um],F [mN]\n0,9,1,1\n1,9,2.5,2\n2,9,4,4.5\n"
    for name in ("u2", "U2", "u2 [um]", "3"):
        np.testing.assert_allclose(read_measurements(text, displacement=name).displacement, U, rtol=1e-15)
    assert read_measurements(text, displacement="u1", units=("mm", "mN")).displacement[0] == 9e-3


def test_without_units_si_is_assumed_and_said():
    notes = read_measurements("1 2\n2 3\n3 4\n").notes
    assert len(notes) == 2
    assert "m is assumed" in notes[0]
    assert "N is assumed" in notes[1]


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("depth [um],force [mN]\n1,2\n2,x1\n3,4\n", {}, r"line 3, column 'force \[mN\]': 'x1' is not a number"),
        ("depth [um],force [mN]\n1,2\n2\n3,4\n", {}, "line 3, .*: the line has too few columns, 1;"),
        ("depth [um],force [mN]\n1,2\n2,1e999\n3,4\n", {}, "line 3, .* beyond the largest double"),
        ("depth [um];force [mN]\n1;2\n2;1.000,5\n3;4\n", {}, r"'1\.000,5' is not a number"),
        ("depth [um],force [st]\n1,2\n2,3\n3,4\n", {"force": "force"}, "has the unit 'st', which is not known"),
        ("depth [um],force [mN]\n1,2\n2,3\n3,4\n", {"units": ("mm", "furlong")}, "or 1 for a plain number"),
        ("depth [um],force [V]\n1,2\n2,3\n3,4\n", {"area": 1e-4}, "an area goes with a force, but the load is in V"),
        ("depth [um],force [mN]\n1,2\n2,3\n3,4\n", {"displacement": "force"}, "a unit of force; choose another"),
        ("depth [um],force [mN]\n1,2\n2,3\n3,4\n", {"force": "load"}, "there is no such column; choose .*1: depth"),
        ("u [um],v [um],w [um]\n1,2,1\n2,3,1\n3,4,1\n", {}, "the column of the displacement cannot be told"),
        ("depth [um],force [mN]\n1,2\n2,3\n", {}, "has 2 rows with two numbers"),
        ("nothing here\nat all\n", {}, "no line has two numbers"),
        ("depth [um],force [mN]\n1,2\n2,3\n3,4\n", {"area": 0}, "area is 0; give a positive number"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_sentence(text, options, message):
    with pytest.raises(InputError, match=message):
        read_measurements(text, **options)


def test_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_measurements(tmp_path / "missing.csv")
    (tmp_path / "binary.xlsx").write_bytes(b"PK\x03\x04\0\0")
    with pytest.raises(InputError, match="not a text file"):
        read_measurements(tmp_path / "binary.xlsx")


def test_capitals_tell_milli_from_mega():
    assert known_unit("mN").factor == Fraction(1, 1000)
    assert known_unit("MN").factor == 10**6
    assert known_unit("furlong") is None
    assert split_heading("a_b_um") == ("a_b", "um")
    assert split_heading("a_b") == ("a_b", "")


NUMBERS = st.floats(-1e6, 1e6).map(lambda value: round(value, 6))


@given(
    rows=st.lists(st.tuples(NUMBERS, NUMBERS), min_size=3, max_size=12),
    style=st.sampled_from([",", ";", "\t", " ", ",;"]),
)
def test_what_is_written_is_read(rows, style):
    separator = style[-1]

    def shown(value):
        return repr(value).replace(".", ",") if style == ",;" else repr(value)

    text = f"u [m]{separator}F [N]\n" + "\n".join(f"{shown(u)}{separator}{shown(f)}" for u, f in rows) + "\n"
    found = read_measurements(text)
    assert list(zip(found.displacement.tolist(), found.load.tolist(), strict=True)) == rows


@given(st.text(st.characters(codec="utf-8"), max_size=200))
def test_any_text_is_read_or_refused(text):
    try:
        found = read_measurements(text + "\n")
    except InputError:
        return
    assert np.isfinite(found.displacement).all()
    assert np.isfinite(found.load).all()


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("depth [um] x1000,force [N]", r"'depth \[um\] x1000' speaks of 'um', but its unit cannot be told"),
        ("depth (mm) LVDT,force (kN) Sensor 1", "speaks of 'mm'"),
        ("depth in millimetres LVDT,force [N]", "speaks of 'millimetres'"),
        ("depth lever,force\n,kg", "speaks of 'kg'"),
    ],
)
def test_a_unit_that_cannot_be_told_is_not_taken_for_si(heading, message):
    with pytest.raises(InputError, match=message):
        read_measurements(heading + "\n0,0\n1,2\n2,4\n")
    given = read_measurements(heading + "\n0,0\n1,2\n2,4\n", displacement="1", force="2", units=("um", "mN"))
    assert (given.displacement[1], given.load[1]) == (1e-6, 2e-3)


def test_a_unit_after_a_blank_is_a_unit():
    found = read_measurements("Weg mm;Kraft kN\n0;0\n1;2\n2;4\n")
    assert (found.displacement[1], found.load[1], found.notes) == (1e-3, 2e3, ())


@pytest.mark.parametrize("heading", ["force,stroke", "Kraft,Weg", "Effort,Course"])
def test_two_columns_are_not_exchanged(heading):
    found = read_measurements(heading + "\n5,1\n6,2\n7,3\n")
    assert (found.displacement[0], found.load[0]) == (1, 5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Weg [mm];Kraft [N]\n0,5;999,5\n0,6;1.000\n0,7;1.200\n", "line 3.*'1.000' has a point in a file with decimal"),
        ("depth [mm];force [N]\n0.5;999\n0.6;1,000\n0.7;1,200\n", "line 2.*'0.5' has a point in a file with decimal"),
        ("depth [mm],force [N]\n0,0\n0,5,2\n1,4\n1,5,6\n", "line 3 has 3 columns where the first has 2"),
        ("depth [um],force [N]\n0%,1%\n1,2\n2,4\n3,6\n", "line 2: '0%' is not a number, nor a heading"),
    ],
)
def test_numbers_that_could_be_read_in_two_ways_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_measurements(text)


def test_commas_that_might_mark_thousands_are_noted():
    found = read_measurements("Weg [mm];Kraft [N]\n0;1,234\n1;5,600\n2;9,000\n")
    assert (found.load[0], found.notes) == (1.234, ("Commas were read as decimal points: 1,234 as 1.234.",))
    assert read_measurements("Weg [mm];Kraft [N]\n0;1,234\n1;5,60\n2;9,000\n").notes == ()


# of two columns in volts neither is the only one, and x is the argument wherever it stands
def test_two_columns_with_one_unit_are_told_apart_in_words_that_are_true():
    found = read_measurements("y [V],x [V]\n1,1\n2,2.5\n4.5,4\n")
    np.testing.assert_array_equal(found.displacement, [1, 2.5, 4])
    assert found.reasons == ("by its name", "the other one with such a unit")
    assert read_measurements("speed [m/s],force [N]\n1,1\n2,2.5\n4.5,4\n").stiffness_unit == "N/(m/s)"


def test_measurements_without_rows_are_refused():  # were taken, and their text ended with an error of numpy
    with pytest.raises(InputError, match=r"^Measurements has no rows; give"):
        Measurements.from_arrays([], [])
