"""Files as instruments and repositories write them, imitated: what is read, and what is said of the rest."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lure import AssumptionError, InputError
from lure.analysis.cli import main
from lure.analysis.measured import Measurements, read_measurements, sector_from_data
from lure.analysis.measured.table import known_unit

ROWS = [(0.0, 0.0), (0.5, 10.0), (1.0, 20.0), (1.5, 30.0)]  # mm and N, in every file below


def lines(*rows, separator=",", comma=False):
    """Rows of numbers as text."""
    text = "\n".join(separator.join(f"{value:g}" for value in row) for row in rows) + "\n"
    return text.replace(".", ",") if comma else text


FILES = {
    "tensile test with decimal commas and a heading of three lines": "Prüfung;A12\nProbe;Stahl\nStandardweg;Kraft\n"
    "mm;N\n" + lines(*ROWS, separator=";", comma=True),
    "test machine with numbers above the heading": "Specimen width,25,mm,2\nRate,2,mm/min,1\n"
    "Time (s),Extension (mm),Load (N),Cycle\n" + lines(*((i, u, f, 1) for i, (u, f) in enumerate(ROWS))),
    "the size of the specimen in two columns": "25,10\n\nExtension [mm],Load [N]\n" + lines(*ROWS),
    "damper, pounds and inches": "Disp (in)\tForce (lbf)\n"
    + lines(*((u / 25.4, f / 4.4482216152605) for u, f in ROWS), separator="\t").replace("2.24809", "2.248089431"),
    "repeated headings": "x [mm],F [N]\n" + lines(*ROWS[:2]) + "x [mm],F [N]\n" + lines(*ROWS[2:]),
    "repeated headings with units": "x,F\nmm,N\n" + lines(*ROWS[:2]) + "x,F\nmm,N\n" + lines(*ROWS[2:]),
    "a remark below": "travel [mm];force [N]\n" + lines(*ROWS, separator=";") + "End of test\nMax. force;30 N\n",
    "a remark below the first of three columns": "n;travel [mm];force [N]\n"
    + lines(*((i, *row) for i, row in enumerate(ROWS)), separator=";")
    + "End of test\n",
    "a summary below": "travel [mm],force [N]\n" + lines(*ROWS) + "Maximum,30\n",
    "units spelled out": "Displacement (Millimeters),Load (newtons)\n" + lines(*ROWS),
    "gram-force": "Position (mm),Load (gf)\n" + lines(*((u, round(f / 9.80665e-3, 6)) for u, f in ROWS)),
    "a time stamp and a remark in every row": "Time;Weg [mm];Kraft [N];Status\n"
    + "".join(f"12:00:0{i};{u};{f};ok\n" for i, (u, f) in enumerate(ROWS)),
    "an index first, and voltages beside": "n,U [V],x [mm],F [N]\n" + lines(*((i, 5, *r) for i, r in enumerate(ROWS))),
}


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_files_of_instruments_are_read(text, tmp_path):
    found = read_measurements(text)
    np.testing.assert_allclose(found.displacement, [1e-3 * u for u, _ in ROWS], rtol=1e-5)
    np.testing.assert_allclose(found.load, [f for _, f in ROWS], rtol=1e-5)
    assert (found.unit, found.displacement_unit) == ("N", "m")
    path = tmp_path / "file.csv"
    for encoding in ("utf-8-sig", "latin-1"):
        path.write_bytes(text.encode(encoding))
        np.testing.assert_array_equal(read_measurements(path).load, found.load)


@pytest.mark.parametrize(
    ("name", "note"),
    [
        ("repeated headings", "Left out, since they repeat the heading: line 4 (1 in all)."),
        ("a remark below", "Left out, as a remark below the rows: lines 6, 7 (2 in all)."),
        ("a summary below", "Left out, as a remark below the rows: line 6 (1 in all)."),
        ("the size of the specimen in two columns", "the numbers on line 1 (1 in all)."),
    ],
)
def test_what_is_left_out_is_said(name, note):
    assert any(text.endswith(note) for text in read_measurements(FILES[name]).notes)


# a key switch: pressed to 2 mm and released, its columns side by side, the release with one row less
KEY = """Extend travel [mm],Extend force [gf],Retract travel [mm],Retract force [gf]
0,0,2,60
1,30,1,20
2,60,0,0
"""


def test_columns_of_both_directions_are_put_one_after_the_other():
    found = read_measurements(KEY)
    np.testing.assert_allclose(1e3 * found.displacement, [0, 1, 2, 2, 1, 0], rtol=1e-12)
    np.testing.assert_allclose(found.load / 9.80665e-3, [0, 30, 60, 60, 20, 0], rtol=1e-12, atol=1e-12)
    assert found.lines.tolist() == [2, 3, 4, 2, 3, 4]
    assert "the way back, and were put one after the other" in found.notes[0]
    ramp = read_measurements("Ramp_nm,Force_Ex_nN,Force_Rt_nN\n0,0,0\n1,3,2\n2,6,6\n")
    assert [round(1e9 * u) for u in ramp.displacement] == [0, 1, 2, 2, 1, 0]  # the way back is recorded from its end
    assert [round(1e9 * f) for f in ramp.load] == [0, 3, 6, 6, 2, 0]
    alone = read_measurements(KEY, displacement="1", force="2")
    assert len(alone) == 3


# definitions: 1 lbf = 0.45359237 kg * 9.80665 m/s^2, 1 in = 25.4 mm, 1 psi = 1 lbf/in^2
@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        ("lbf", "force", Fraction("0.45359237") * Fraction("9.80665")),
        ("gf", "force", Fraction("0.00980665")),
        ("inch", "length", Fraction("0.0254")),
        ("psi", "stress", Fraction("0.45359237") * Fraction("9.80665") / Fraction("0.0254") ** 2),
        ("Millimetres", "length", Fraction(1, 1000)),
        ("micrometer", "length", Fraction(1, 10**6)),
        ("kilonewtons", "force", 1000),
        ("mV", "voltage", Fraction(1, 1000)),
        ("N·mm", "torque", Fraction(1, 1000)),
        ("mm/s", "velocity", Fraction(1, 1000)),
        ("%", "number", Fraction(1, 100)),
    ],
)
def test_units_have_their_defined_size(text, kind, factor):
    assert (known_unit(text).kind, known_unit(text).factor) == (kind, factor)


def test_degrees_become_radians():
    found = read_measurements("Winkel [°],Drehmoment [N m]\n0,0\n90,1\n180,2\n")
    np.testing.assert_allclose(found.displacement, [0, np.pi / 2, np.pi], rtol=1e-15)
    assert (found.displacement_unit, found.unit, found.stiffness_unit) == ("rad", "N m", "N m/rad")


def amplifier(tmp_path):
    """In and out of an amplifier with the gain 10 that saturates at 8 V, in volts."""
    u = np.linspace(-1, 1, 201)
    v = np.clip(10 * u, -8, 8) + 0.01 * np.random.default_rng(0).standard_normal(201)
    path = tmp_path / "amplifier.csv"
    path.write_text("in,out\n" + "".join(f"{a:.4f},{b:.4f}\n" for a, b in zip(u, v, strict=True)), encoding="utf-8")
    return path


def test_an_amplifier_in_volts(tmp_path, capsys):
    path = amplifier(tmp_path)
    assert main(["sector", str(path), "--units", "V,V"]) in (0, 10)
    printed = " ".join(capsys.readouterr().out.split())
    assert "or sigma in [-1, 1] V" in printed
    assert "V/V" in printed
    assert "sigma is column 1 'in' (by its place), phi is column 2 'out' (by its place)" in printed
    assert "--displacement and --force choose others" in printed
    found = sector_from_data(read_measurements(path, units=("V", "V")))
    # chords from 8 at the ends to 10 within the linear part
    assert 7 < found.lower.bound <= 8
    assert 10 <= found.upper.bound < 11
    assert found.to_xarray()["sigma"].attrs["units"] == "V"
    assert main(["sector", str(path), "--units", "V,V", "--fit"]) == 2
    assert "a contact law relates m to N or Pa, and the data V to V" in capsys.readouterr().err


@pytest.mark.parametrize("units", ["mm", "mm,", "mm,N,s", "N,mm", "furlong,N"])
def test_units_that_are_none_are_refused_in_a_sentence(tmp_path, capsys, units):
    assert main(["sector", str(amplifier(tmp_path)), "--units", units]) == 2
    assert "Traceback" not in capsys.readouterr().err


CELLS = st.sampled_from(
    [
        "",
        "0",
        "1",
        "-2.5",
        "1e3",
        "1,5",
        "1.000,5",
        "nan",
        "inf",
        "x",
        "u [mm]",
        "F (N)",
        "mm",
        "N",
        "V",
        '"',
        "#",
        "1e999",
    ]
)


# whatever a file holds, the command ends with a status and prints no traceback; so do the sector and the fit
@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(
    head=st.lists(st.lists(CELLS, min_size=1, max_size=4), max_size=3),
    body=st.lists(st.lists(CELLS, min_size=2, max_size=3), max_size=16),
    mark=st.sampled_from([",", ";", "\t", " "]),
)
def test_any_table_is_read_or_refused(head, body, mark):
    text = "\n".join(mark.join(cells) for cells in [*head, *body]) + "\n"
    try:
        found = read_measurements(text)
    except InputError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 - there may be no error
        return
    assert np.isfinite(found.displacement).all()
    assert np.isfinite(found.load).all()


SIZES = st.sampled_from([1e-300, 1e-15, 1e-9, 1.0, 1e9, 1e200])


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None, max_examples=15)
@given(
    values=st.lists(
        st.tuples(st.sampled_from([-1.0, 0.0, 0.3, 0.5, 1.0]), st.sampled_from([-1.0, 0.0, 0.1, 2.0])),
        min_size=12,
        max_size=40,
    ),
    sizes=st.tuples(SIZES, SIZES),
)
@pytest.mark.slow
def test_any_numbers_have_a_sector_or_a_sentence(values, sizes):
    from lure.analysis.measured import report_from_data

    u, p = (np.array(column) * size for column, size in zip(zip(*values, strict=True), sizes, strict=True))
    for fit in (False, True):
        try:
            found = report_from_data(Measurements.from_arrays(u, p), fit=fit)
        except (InputError, AssumptionError) as error:
            assert len(str(error).splitlines()) == 1  # noqa: PT017 - there may be no error
        else:
            assert str(found)
