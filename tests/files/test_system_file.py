"""Systems as TOML files: exact numbers in, the same system out, settings, and files that are none."""

import os
import re
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from system_files import ROD, parsed, refused, with_line

from lure import __version__
from lure.errors import InputError
from lure.files import find_system, parse_system, read_system
from lure.rod.discretisation import MAX_CELLS
from lure.rod.file import ROD_FILE, system_to_toml, template
from lure.rod.parameters import PARAMETERS
from lure.rod.systems import builtin_system, builtin_systems


def same(left, right):
    """Equality of systems but for what a file does not hold, the title and the source; exact in every number."""
    scenarios = [
        (s.scenario.force, s.scenario.body_force, s.scenario.displacement, s.scenario.velocity) for s in (left, right)
    ]
    return (
        scenarios[0] == scenarios[1]
        and dict(left.rod.exact) == dict(right.rod.exact)
        and (left.name, left.cells, left.form, left.until, left.simulation_cells)
        == (right.name, right.cells, right.form, right.until, right.simulation_cells)
    )


# numbers as given


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.1", Fraction(1, 10)),
        ("0.25e-4", Fraction(1, 40000)),
        ("1_000.5", Fraction(2001, 2)),
        ("3", Fraction(3)),
        ("0x10", Fraction(16)),
        ("1e-300", Fraction(1, 10**300)),
        ("-2e-4", Fraction(-1, 5000)),
        ("0e999999999", Fraction(0)),
    ],
)
def test_a_decimal_in_a_file_is_that_decimal_and_not_the_nearest_double(text, value):
    assert parsed(with_line(f"damping = {text}")).rod.exact["damping"] == value


def test_decimals_in_formulas_and_settings_are_exact_too():
    system = parsed(with_line("g = 0.1", "force"), "rod.damping=0.1", "initial.u0=0.3")
    assert system.scenario.force.exact() == Fraction(1, 10)
    assert system.rod.exact["damping"] == Fraction(1, 10)
    assert system.scenario.displacement.exact() == Fraction(3, 10)


def test_what_a_file_leaves_out_takes_the_documented_default():
    system = parsed(ROD)
    assert (system.name, system.cells, system.form, system.simulation_cells) == ("rod", 10, "corrected", None)
    assert system.rod.exact["exponent"] == 1
    assert system.rod.exact["gap"] == 0
    assert system.scenario.free
    assert system.until == pytest.approx(20 / 6000)  # ten round trips of 2 L/c, c = 6000 m/s


@pytest.mark.parametrize("damping", ["0", "-1", "-1e-9"])
def test_a_damping_that_destabilises_is_physics_and_not_bad_input(damping):
    assert parsed(with_line(f"damping = {damping}")).rod.exact["damping"] == Fraction(damping)


# round trips


def test_the_template_is_the_paper_rod():
    system = parse_system(template(), name="x", source="rod.toml", settings=["name=paper-rod"])
    assert same(system, builtin_system("paper-rod"))


def test_the_template_shows_every_key_and_keeps_to_100_columns():
    lines = template().splitlines()
    keys = {re.match(r"(?:# )?(\w+) *=", line)[1] for line in lines if re.match(r"(?:# )?\w+ *= \S", line)}
    assert keys == {key.rpartition(".")[2] for key in ROD_FILE.keys}
    assert max(map(len, lines)) <= 100
    assert str(MAX_CELLS) in template()


@pytest.mark.parametrize("name", builtin_systems())
def test_a_built_in_written_as_toml_reads_back_as_itself(name):
    text = system_to_toml(builtin_system(name))
    assert same(parsed(text), builtin_system(name))
    assert system_to_toml(parsed(text)).split("\n", 2)[2] == text.split("\n", 2)[2]


positive = st.decimals("1e-9", "1e9", allow_nan=False, places=12).filter(bool)
damping = st.decimals("-1e3", "1e3", places=9)
formulas = st.sampled_from(["0", "0.5", "2*sin(4*t)", "t if t < 1 else 0.25", "exp(-t)*1e-3"])
names = st.text(st.characters(exclude_categories=["Cs", "Cc", "Zl", "Zp"]), min_size=1, max_size=100).filter(
    lambda text: text.isprintable() and bool(text.strip())
)


@given(
    values=st.tuples(positive, positive, positive, positive, damping, positive, st.sampled_from([1, 2]), damping),
    name=names,
    cells=st.integers(1, MAX_CELLS),
    form=st.sampled_from(["corrected", "as-printed"]),
    force=formulas,
    until=st.floats(1e-9, 1e9),
    simulated=st.none() | st.integers(1, MAX_CELLS),
)
@example(
    values=(1, 1, 1, 1, 0, 1, 1, 0),
    name='"\\ # [rod]',
    cells=1,
    form="corrected",
    force="0",
    until=5e-324 * 2**60,
    simulated=None,
)
def test_a_system_written_as_toml_reads_back_as_itself(values, name, cells, form, force, until, simulated):
    settings = [f"rod.{key}={value}" for key, value in zip(PARAMETERS, values, strict=True)]
    settings += [f"discretisation.cells={cells}", f"discretisation.form={form}", f"force.g={force}"]
    settings += [f"simulation.until={until!r}", *([f"simulation.cells={simulated}"] if simulated else [])]
    system = parsed(ROD, *settings, f"name={name}")
    assert system.name == name.strip()
    assert same(parsed(system_to_toml(system)), system)


# settings


def test_a_setting_is_applied_before_anything_is_checked():
    assert parsed(with_line("length = -1"), "rod.length = 2").rod.length == 2
    assert parsed(ROD.replace("length = 1\n", ""), "rod.length=2").rod.length == 2


def test_the_last_of_two_settings_counts():
    assert parsed(ROD, "rod.length=2", "rod.length=3").rod.length == 3


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("rod.damping", "--set rod.damping: give KEY=VALUE, such as --set rod.damping=8e-4"),
        ("=1", "--set =1: the key is missing; give one such as rod.damping=8e-4"),
        ("rod.dampng=1", "--set: unknown key rod.dampng; did you mean rod.damping? [rod] takes "),
        ("damping=1", "--set: unknown key damping; did you mean rod.damping? a system has "),
        ("rod=1", "--set: unknown key rod; "),
        ("a.b.c=1", "--set: unknown key a.b.c; a system has "),
        ("rod.length=", "rod.length is ''; give a number"),
        ("rod.length=1/3", "rod.length is '1/3'; give a number"),
        ("rod.length=nan", "rod.length is 'nan'; give a number"),
        ("rod.length=1,5", "rod.length is '1,5'; give a number"),
        ("rod.length=true", "rod.length is 'true'; give a number"),
        ("rod.length=[0.5", "rod.length is '[0.5'; give a number"),
        ("rod.length=[0.5]\nname=3", "rod.length is "),
        ("rod.length=[0.5]", "rod.length is an array of 1; give a number, or an interval [low, high]"),
        ("simulation.cells=1e9", "simulation.cells is 1E+9; give a whole number"),
        ("\x1b[2J=1", "--set: unknown key \\x1b[2J; "),
    ],
)
def test_a_wrong_setting_is_refused(setting, sentence):
    assert refused(ROD, setting).startswith(sentence)


def test_a_changed_built_in_says_so_in_its_name_and_title():
    system = find_system("paper-rod", ["rod.damping=8e-4"])
    assert system.rod.exact["damping"] == Fraction(8, 10000)
    assert (system.name, system.until) == ("paper-rod (changed)", 2.5e-3)
    assert system.title.endswith("; with rod.damping=8e-4")
    assert find_system("paper-rod", ["rod.damping=8e-4", "name=mine"]).name == "mine"
    assert find_system("paper-rod", []).name == "paper-rod"


# files


def test_a_file_is_found_by_its_suffix_or_because_it_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare").write_text(ROD)
    (tmp_path / "a b.toml").write_text(ROD)
    assert find_system("bare").name == "bare"
    assert (find_system("a b.toml").name, find_system("a b.toml").source) == ("a b", "a b.toml")
    assert find_system(str(tmp_path / "bare")).source == "bare"
    (tmp_path / "paper-rod").write_text("nonsense")
    assert find_system("paper-rod").name == "paper-rod"
    with pytest.raises(InputError, match=r"^mine\.toml does not exist; `lure init --loop mine\.toml` writes a loop"):
        find_system("mine.toml")
    with pytest.raises(
        InputError, match=r"'paper-rd'; did you mean 'paper-rod'\? .*, or give the path of a TOML file$"
    ):
        find_system("paper-rd")


def test_a_byte_order_mark_and_windows_line_ends_are_no_obstacle(tmp_path):
    path = tmp_path / "rod.toml"
    path.write_bytes(b"\xef\xbb\xbf" + template().replace("\n", "\r\n").encode())
    assert same(read_system(path), parsed(template()))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (ROD.encode("utf-16"), r"is not UTF-8 text \(byte 0xff at position 0\); save it as UTF-8$"),
        (b"# St\xe4be\n", r"is not UTF-8 text \(byte 0xe4 at position 4\); save it as UTF-8$"),
        (b"#" * 70_000, "is larger than 64 KiB; a system file is a page of text$"),
        (b"\x00\x01\x02", "does not parse as TOML: "),
    ],
)
def test_a_file_that_is_no_text_is_refused(tmp_path, content, sentence):
    path = tmp_path / "rod.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        read_system(path)


@pytest.mark.parametrize(("name", "said"), [("H.mat", "what scipy.io.loadmat reads"), ("bode.CSV", "a measured H")])
def test_a_file_of_data_is_refused_with_the_way_to_read_it(tmp_path, name, said):
    (tmp_path / name).write_bytes(b"1,2,3\n")
    with pytest.raises(InputError, match=f"is data, and a system is a TOML file .*{said}"):
        read_system(tmp_path / name)


def test_directories_pipes_and_devices_are_refused_unread(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "dir.toml").mkdir()
    with pytest.raises(InputError, match=r"dir\.toml is a directory; give a TOML file$"):
        read_system(tmp_path / "dir.toml")
    with pytest.raises(InputError, match=r"pipe\.toml is not an ordinary file; give a TOML file$"):
        read_system(tmp_path / "pipe.toml")


def test_an_unreadable_file_is_refused_with_the_reason(tmp_path, monkeypatch):
    path = tmp_path / "rod.toml"
    path.write_text(ROD)

    def deny(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "open", deny)
    with pytest.raises(InputError, match=r"rod\.toml cannot be read \(Permission denied\); give a readable TOML file$"):
        read_system(path)


def test_a_file_name_is_shown_without_its_control_characters(tmp_path):
    path = tmp_path / "a\x1b[2J.toml"
    path.write_text(ROD)
    assert read_system(path).name.isprintable()
    with pytest.raises(InputError) as caught:
        read_system(tmp_path / "b\x1b[2J.toml")
    assert str(caught.value).isprintable()


def test_the_package_knows_its_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+", __version__)
