"""Hostile text in a system file is refused where a value belongs, unread and unexecuted."""

import re

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from system_files import ROD, parsed, refused

from lure.errors import InputError
from lure.rod.file import ROD_FILE, system_to_toml
from lure.rod.systems import builtin_system


def outcome(text, *settings):
    """The name of the system or the refusal; any other exception passes."""
    try:
        return parsed(text, *settings).name
    except InputError as error:
        return str(error)


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
    message = refused(base.replace(f"[{table}]\n", f"[{table}]\n{name} = {literal}\n"))
    assert message.startswith(key)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", [text for text in HOSTILE if text.isprintable() and len(text) <= 100])
def test_a_printable_name_may_be_anything_and_comes_back_unchanged(text):
    assert parsed(system_to_toml(parsed(ROD, f"name={text}"))).name == text


@pytest.mark.parametrize("text", [text for text in HOSTILE if not text.isprintable() or len(text) > 100])
def test_a_name_that_could_move_the_cursor_is_refused(text):
    assert refused(ROD, f"name=x{text}x").startswith("name is 'x")


@given(st.text(max_size=60), st.text(max_size=60))
@example("[", "a = [")
@example("rod.length", "\x00")
def test_no_text_gets_past_the_parser_as_anything_but_a_refusal(before, after):
    for text in (f"{before}\n{ROD}", f"{ROD}{after}"):
        assert outcome(text).isprintable()


@given(st.sampled_from(ROD_FILE.keys), st.text(max_size=40))
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
    message = refused(text)
    assert message.startswith("rod.toml does not parse as TOML: ")
    assert sentence in message


@pytest.mark.parametrize("part", ["a", '""', '"\u2028"'])
@pytest.mark.parametrize("form", ["{}=1", "[{}]", "{}"])
def test_a_key_of_thousands_of_parts_is_refused_unread(part, form):
    # tomllib needs 14 s for 32 000 parts and its memory grows with their square
    assert "has a line with more than 1000 points" in refused(form.format(".".join([part] * 10000)))
    many = "\n".join(form.format(".".join([f"a{i}"] + ["a"] * 999)) for i in range(30))
    assert refused(many)
