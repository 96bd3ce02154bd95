"""Systems as TOML files: exact numbers in, one sentence out for whatever is wrong."""

import os
import re
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lure import __version__
from lure.errors import InputError
from lure.rod import PARAMETERS
from lure.system_file import find_system, parse_system, read_system, system_to_toml, template
from lure.system_file.problems import nearest_key
from lure.system_file.schema import dotted_keys
from lure.systems import builtin_system, builtin_systems
from lure.upwind import MAX_CELLS

ROD = """
[rod]
youngs_modulus = 288e6
density = 8
length = 1
area = 0.25e-4
damping = 2e-4
compliance = 1
"""


def parsed(text, *settings):
    return parse_system(text, name="rod", source="rod.toml", settings=settings)


def with_line(line, table="rod"):
    """The smallest file with one line in one table, in the place of the line for the same key if there is one."""
    key = re.escape(line.split("=")[0].strip())
    text = re.sub(rf"^{key} *=.*\n", "", ROD, flags=re.MULTILINE) if table == "rod" else ROD
    return text + (f"{line}\n" if table == "rod" else f"[{table}]\n{line}\n")


def refusal(text, *settings):
    """The sentence, after the checks that hold for every refusal: one line, printable, of a readable length."""
    with pytest.raises(InputError) as caught:
        parsed(text, *settings)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 400
    return message


def outcome(text, *settings):
    """The name of the system or the refusal; any other exception passes."""
    try:
        return parsed(text, *settings).name
    except InputError as error:
        return str(error)


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
    assert keys == {key.rpartition(".")[2] for key in dotted_keys()}
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


# unknown and missing keys


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("rod.dampng", "rod.damping"),
        ("rod.Damping", "rod.damping"),
        ("rod.E", "rod.youngs_modulus"),
        ("rod.eps", "rod.compliance"),
        ("discretization", "discretisation"),
        ("discretization.cells", "discretisation.cells"),
        ("damping", "rod.damping"),
        ("rod.cells", "discretisation.cells"),
        ("rod.until", "simulation.until"),
        ("N", "discretisation.cells"),
        ("rod.colour", None),
    ],
)
def test_a_misspelt_key_is_recognised(key, meant):
    assert nearest_key(key) == meant


def test_an_unknown_key_names_its_table_what_was_meant_and_what_is_allowed():
    assert refusal(ROD.replace("damping", "dampng")) == (
        "unknown key rod.dampng; did you mean rod.damping? [rod] takes youngs_modulus, density, length, area, damping, "
        "compliance, exponent, gap"
    )
    assert refusal(ROD + "[force2]\ng = 1").startswith("unknown key force2; did you mean force? a system has the key")


@pytest.mark.parametrize("key", ["youngs_modulus", "density", "length", "area", "damping", "compliance"])
def test_a_missing_key_is_named_with_its_unit(key):
    assert re.fullmatch(rf"rod\.{key} is missing; give .*\[.+\]", refusal(re.sub(rf"(?m)^{key}.*\n", "", ROD)))


def test_an_empty_file_is_told_what_it_needs():
    expected = "the table [rod] is missing; give it with youngs_modulus, density, length, area, damping, compliance"
    assert refusal("") == expected
    assert refusal("rod = {}").startswith("rod.youngs_modulus is missing; give E, Young's modulus [Pa] (and 5 more)")


def test_further_problems_are_counted():
    text = with_line("cells = 0", "discretisation") + "[force]\ng = nan\n"
    assert refusal(text).endswith("give a whole number from 1 to 10000000 (and 1 more)")


# values


@pytest.mark.parametrize("key", ["youngs_modulus", "density", "length", "area", "compliance", "exponent"])
@pytest.mark.parametrize("value", ["0", "-1", "-0.0", "-1e-300"])
def test_what_must_be_positive_is_refused_at_zero_and_below(key, value):
    assert re.fullmatch(rf"rod\.{key} is -?[\de.-]+; give a positive number", refusal(with_line(f"{key} = {value}")))


@pytest.mark.parametrize("key", PARAMETERS)
@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("nan", "rod.{} is NaN; give a finite number"),
        ("-inf", "rod.{} is -Infinity; give a finite number"),
        ('"8"', "rod.{} is '8'; give a number"),
        ("true", "rod.{} is true; give a number"),
        ("[1]", "rod.{} is an array; give a number"),
        ("{ a = 1 }", "rod.{} is a table; give a number"),
        ("1979-05-27", "rod.{} is 1979-05-27; give a number"),
        ("1e401", "rod.{} is 1E+401, outside the range of double precision; rescale the units"),
        ("1e999999999", "rod.{} is 1E+999999999, outside the range of double precision; rescale the units"),
        ("1e-999999999", "rod.{} is 1E-999999999, outside the range of double precision; rescale the units"),
        ("1e99999999999999999999", "rod.{} is '1e99999999999999999999'; give a number"),
        ("1." + 2000 * "3", "rod.{} has more than 1000 digits; give fewer"),
    ],
)
def test_what_is_not_a_finite_number_is_refused_by_name(key, value, sentence):
    assert refusal(with_line(f"{key} = {value}")) == sentence.format(key)


@pytest.mark.parametrize("value", [4000 * "9", "0x" + 20000 * "f", "1" + 400 * "0"])
def test_a_whole_number_of_any_length_is_refused_without_being_printed(value):
    assert "outside the range of double precision" in refusal(with_line(f"length = {value}"))
    assert "more than 18 digits" in refusal(with_line(f"cells = {value}", "discretisation"))


@pytest.mark.parametrize("table", ["discretisation", "simulation"])
@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("0", "is 0; give a whole number from 1 to 10000000"),
        ("-5", "is -5; give a whole number from 1 to 10000000"),
        ("10.0", "is 10.0; give a whole number"),
        ("true", "is true; give a whole number"),
        ('"10"', "is '10'; give a whole number"),
        (
            "1000000000",
            "is 1000000000 (it would need about 100 GB for its matrices); give a whole number from 1 to 10000000",
        ),
    ],
)
def test_a_number_of_cells_is_a_whole_number_that_fits_in_memory(table, value, sentence):
    assert refusal(with_line(f"cells = {value}", table)) == f"{table}.cells {sentence}"


@pytest.mark.parametrize(
    ("line", "table", "sentence"),
    [
        ("damping = -1.2", "rod", "rod.damping is -1.2, minus the impedance of the rod: "),  # Z = 0.25e-4 sqrt(8*288e6)
        ("form = 'printed'", "discretisation", 'discretisation.form is \'printed\'; give "corrected" or "as-printed"'),
        ("form = 1", "discretisation", "discretisation.form is 1; give "),
        ("until = 0", "simulation", "simulation.until is 0; give a positive number"),
        ("until = 'long'", "simulation", "simulation.until is 'long'; give a number"),
        ("g = true", "force", "force.g is true; give a number or a formula in quotes"),
        ("g = nan", "force", "force.g: the number must be finite but is NaN"),
        ("g = '2*sin(4*x)'", "force", "force.g: unknown name 'x' "),
        ("f = '2*'", "force", "force.f: expected a number, a name or '(' but found "),
        ("u1 = 't'", "initial", "initial.u1: unknown name 't' "),
        ("u0 = '1/x'", "initial", "initial.u0 is not a finite number at x = 0; change the formula"),
        ("u0 = 'sqrt(x)'", "initial", "the derivative of initial.u0 is not a finite number at x = 0; "),
        ("u1 = 'log(x - 0.5)'", "initial", "initial.u1 is not a finite number at x = 0; "),
        ("g = 'sqrt(t - 1e-3)'", "force", "force.g is not a finite number at t = 0; "),
        ("f = '1/(x - 1)'", "force", "force.f is not a finite number at t = 0; "),
    ],
)
def test_a_wrong_value_is_named_with_the_fix(line, table, sentence):
    assert refusal(with_line(line, table)).startswith(sentence)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("rod = 5", "rod is 5; give a table that starts with the line [rod]"),
        ("[[rod]]\nlength = 1", "rod is an array; give a table that starts with the line [rod]"),
        (f"force = 'x'\n{ROD}", "force is 'x'; give a table that starts with the line [force]"),
        (f"name = 3\n{ROD}", "name is 3; give a text in quotes"),
        (f"name = ' '\n{ROD}", "name is ' '; give one line of 1 to 100 printable characters"),
        (f"name = '{101 * 'n'}'\n{ROD}", "name is 'nnn"),
    ],
)
def test_a_wrong_table_or_name_is_refused(text, sentence):
    assert refusal(text).startswith(sentence)


def test_a_setting_cannot_be_put_into_what_is_no_table():
    assert refusal("rod = 5", "rod.length=1").startswith("rod is 5; give a table")


# hostile text

HOSTILE = [
    "__import__('os').system('touch pwned')",
    "().__class__.__mro__[1].__subclasses__()",
    "t.__class__",
    "9**9**9**9",
    "factorial(10**8)",
    "lambda: 1",
    "exec('1')",
    "(" * 2000,
    "-" * 2000,
    "{{ config }}",
    "${HOME}",
    "<script>alert(1)</script>",
    "\x1b[2J\x07",
    "\u202egnp.exe",
    "\ufffe",
    "1;t",
    "t\n1",
    "𝐭",
]


@pytest.mark.parametrize("text", HOSTILE)
@pytest.mark.parametrize(
    "key", ["force.g", "force.f", "initial.u0", "rod.length", "simulation.cells", "discretisation.form"]
)
def test_hostile_text_is_refused_where_a_value_belongs(key, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table, name = key.split(".")
    quoted = system_to_toml(builtin_system("paper-rod")).replace('name = "paper-rod"\n', "")
    base = re.sub(rf"(?ms)(^\[{table}\].*?^){name} = [^#\n]*(#[^\n]*)?\n", r"\1", quoted)
    literal = '"' + "".join(f"\\U{ord(sign):08x}" for sign in text) + '"'
    message = refusal(base.replace(f"[{table}]\n", f"[{table}]\n{name} = {literal}\n"))
    assert message.startswith(key)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", [text for text in HOSTILE if text.isprintable() and len(text) <= 100])
def test_a_printable_name_may_be_anything_and_comes_back_unchanged(text):
    assert parsed(system_to_toml(parsed(ROD, f"name={text}"))).name == text


@pytest.mark.parametrize("text", [text for text in HOSTILE if not text.isprintable() or len(text) > 100])
def test_a_name_that_could_move_the_cursor_is_refused(text):
    assert refusal(ROD, f"name=x{text}x").startswith("name is 'x")


@given(st.text(max_size=60), st.text(max_size=60))
@example("[", "a = [")
@example("rod.length", "\x00")
def test_no_text_gets_past_the_parser_as_anything_but_a_refusal(before, after):
    for text in (f"{before}\n{ROD}", f"{ROD}{after}"):
        assert outcome(text).isprintable()


@given(st.sampled_from(dotted_keys()), st.text(max_size=40))
@example("simulation.until", "1_0")
@example("rod.length", "١٢")  # digits, but not ours
@example("rod.length", "1e99999999999999999999")
@example("rod.length", "_1")
@example("rod.length", ".")
def test_no_setting_gets_past_the_parser_as_anything_but_a_refusal(key, text):
    assert outcome(ROD, f"{key}={text}").isprintable()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a = [" + 30000 * "[", "brackets are nested too deeply"),
        ("a = " + 10000 * "{a=", "brackets are nested too deeply"),
        ("a = " + 5000 * "9", "a whole number has more than 4300 digits"),
        ("[rod]\nlength = 1\nlength = 2", "Cannot overwrite a value (at "),
        ("[rod]\n[rod]", "Cannot declare"),
        ("length = 0.", "(at line 1"),
        ("length", "(at "),
        ("a = '\x1b'", "'\\x1b' (at line 1, column 6)"),
    ],
)
def test_text_that_is_not_toml_is_refused_with_its_place(text, sentence):
    message = refusal(text)
    assert message.startswith("rod.toml does not parse as TOML: ")
    assert sentence in message


@pytest.mark.parametrize("part", ["a", '""', '"\u2028"'])
@pytest.mark.parametrize("form", ["{}=1", "[{}]", "{}"])
def test_a_key_of_thousands_of_parts_is_refused_unread(part, form):
    # tomllib needs 14 s for 32 000 parts and its memory grows with their square
    assert "has a line with more than 1000 points" in refusal(form.format(".".join([part] * 10000)))
    many = "\n".join(form.format(".".join([f"a{i}"] + ["a"] * 999)) for i in range(30))
    assert refusal(many)


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
        ("simulation.cells=1e9", "simulation.cells is 1E+9; give a whole number"),
        ("\x1b[2J=1", "--set: unknown key \\x1b[2J; "),
    ],
)
def test_a_wrong_setting_is_refused(setting, sentence):
    assert refusal(ROD, setting).startswith(sentence)


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
    with pytest.raises(InputError, match=r"^mine\.toml does not exist; `lure init mine\.toml` writes a file"):
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
