"""The reference: every public name stands on one of its pages, and its docstring is valid and says what the code says.

The pages are ``docs/reference``; ``make docs`` builds them without a warning.  This is what can be seen of that without
Sphinx: the sections of a docstring are parsed one by one, as reStructuredText.
"""

import ast
import copy
import dataclasses
import functools
import importlib
import inspect
import io
import pkgutil
import re
import textwrap
from pathlib import Path

import docutils.core
import docutils.frontend
import docutils.nodes
import docutils.parsers.rst.roles
import docutils.readers.standalone
import pytest

import lure

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "reference").glob("*.rst"))
FIELDS = ("Parameters", "Attributes", "Returns", "Yields", "Raises")
SECTIONS = (*FIELDS, "Notes", "References", "Examples", "See Also", "Warns", "Warnings")
HEADING = re.compile(r"^(\S[^\n]*)\n-{3,}\n", re.MULTILINE)
ROLES = ("attr", "class", "data", "exc", "func", "meth", "mod", "obj")


def a_link(_role, text, _source, _line, _inliner, _options=None, _content=None):
    return [docutils.nodes.literal(text, text)], []


for role in ROLES:
    docutils.parsers.rst.roles.register_local_role(role, a_link)
    docutils.parsers.rst.roles.register_local_role(f"py:{role}", a_link)


def listed(page):
    """The names in the `api` lists of a page: indented twice below the directive."""
    for block in re.findall(r"^\.\. api::\n((?:\n| +.*\n)*)", page.read_text(encoding="utf-8"), re.MULTILINE):
        yield from re.findall(r"^ {6}(\S+)$", block, re.MULTILINE)


def found(path):
    """The object at a dotted path, through modules and then attributes."""
    parts = path.split(".")
    for count in range(len(parts) - 1, 0, -1):
        try:
            thing = importlib.import_module(".".join(parts[:count]))
            for name in parts[count:]:
                thing = getattr(thing, name)
        except (ModuleNotFoundError, AttributeError):
            continue
        return thing
    raise LookupError(path)


NAMES = [(page.stem, name) for page in PAGES for name in listed(page)]
THINGS = {name: found(name) for _, name in NAMES}


def exported():
    """What `lure`, `analysis` and the packages inside them hand out: names imported under themselves, or defined."""
    inner = pkgutil.walk_packages(lure.__path__, "lure.")
    for home in (lure, *(importlib.import_module(module.name) for module in inner if module.ispkg)):
        yield from ((f"{home.__name__}.{name}", getattr(home, name)) for name in getattr(home, "__all__", ()))
        tree = ast.parse(Path(home.__file__).read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                names = [alias.asname for alias in node.names if alias.asname]
            else:
                names = [node.name] if isinstance(node, ast.FunctionDef | ast.ClassDef) else []
            for name in names:
                if not name.startswith("_"):
                    yield f"{home.__name__}.{name}", getattr(home, name)


def described():
    """Every function and class of the reference, and the public members of its classes, with their docstrings."""
    for name, thing in THINGS.items():
        if not (inspect.isclass(thing) or inspect.isroutine(thing)):
            continue
        yield name, thing
        for key, member in vars(thing).items() if inspect.isclass(thing) else ():
            inner = (
                getattr(member, "fget", None) or getattr(member, "func", None) or getattr(member, "__func__", member)
            )
            if inspect.isfunction(inner) and inner.__doc__ and (key == "__call__" or not key.startswith("_")):
                yield f"{name}.{key}", inner


DESCRIBED = dict(described())


def sections(thing):
    """The docstring in parts: what comes first under "", and each section under its heading."""
    parts = HEADING.split(inspect.cleandoc(thing.__doc__ or "") + "\n")
    return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}


def entries(section):
    """The entries of a section such as Parameters: names, type, description."""
    parts = re.split(r"^(\S.*)\n", section, flags=re.MULTILINE)[1:]
    for head, text in zip(parts[::2], parts[1::2], strict=True):
        names, _, kind = head.partition(" : ")
        yield [name.strip("* ") for name in names.split(",")], kind, textwrap.dedent(text)


def texts(thing):
    """The pieces of a docstring that are reStructuredText, as the reference takes them apart."""
    parts = sections(thing)

    def cited(text):
        """A text with the sources that it cites."""
        return f"{text}\n\n{parts.get('References', '')}" if "]_" in text else text

    prose = [text for heading, text in parts.items() if heading not in FIELDS]
    yield "\n\n".join(prose)
    for heading in FIELDS:
        for names, kind, description in entries(parts.get(heading, "")):
            yield kind if heading in ("Parameters", "Attributes") else ", ".join(names)
            yield cited(description)
    first = " ".join(parts[""].split("\n\n")[0].split())
    yield cited(re.split(r"(?<=[.])[ ]", first)[0])  # a summary table shows the first sentence alone


PLAIN = re.compile(
    r"\s*([A-Z][a-z]+|[a-z]+)([ ,][^`*_|:\\]*)?\n?"
)  # begins with a word, has none of the signs of markup


@functools.cache
def complaints(text):
    """What docutils says of a text."""
    if "\n" not in text.strip() and PLAIN.fullmatch(text):
        return []
    settings = copy.copy(usual_settings())
    settings.warning_stream = io.StringIO()
    docutils.core.publish_doctree(text, settings=settings)
    return settings.warning_stream.getvalue().splitlines()


@functools.cache
def usual_settings():
    """Made once: to read the options of docutils takes longer than to read a docstring."""
    parts = (docutils.parsers.rst.Parser, docutils.readers.standalone.Reader)
    settings = docutils.frontend.get_default_settings(*parts)
    settings.report_level, settings.halt_level, settings.file_insertion_enabled = 2, 5, False
    return settings


def said_of(wrong):
    """One line for each."""
    return "\n".join(f"{name}: {wrong[name]}" for name in wrong) if isinstance(wrong, dict) else "\n".join(wrong)


def test_every_name_on_a_page_exists_and_stands_there_once():
    assert len(NAMES) > 300
    homes = [id(found(name)) for _, name in NAMES]
    twice = [name for _, name in NAMES if homes.count(id(THINGS[name])) > 1]
    assert not twice, said_of(twice)


def test_every_public_name_stands_on_a_page():
    there = {id(thing) for thing in THINGS.values()}
    missing = [name for name, thing in exported() if id(thing) not in there]
    assert not missing, said_of(missing)


def test_every_page_is_reached_from_the_index():
    reference = ROOT / "docs" / "reference"
    named = re.findall(r"^([\w-]+)$", (reference / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    whole = (reference / "certificate-format.rst").read_text(encoding="utf-8")  # with a page for each of its parts
    assert sorted(page.stem for page in PAGES) == sorted(named + re.findall(r"^   ([\w-]+)$", whole, re.MULTILINE))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_docstrings_are_restructuredtext(page):
    own = [name for stem, name in NAMES if stem == page.stem]
    wrong = {
        name: said
        for name, thing in DESCRIBED.items()
        if name in own or name.rpartition(".")[0] in own
        for said in [[line for text in texts(thing) for line in complaints(text)]]
        if said or not thing.__doc__
    }
    assert not wrong, said_of(wrong)


def test_docstrings_have_only_sections_that_the_reference_knows():
    wrong = {name: set(sections(thing)) - {"", *SECTIONS} for name, thing in DESCRIBED.items()}
    wrong = {name: unknown for name, unknown in wrong.items() if unknown}
    assert not wrong, said_of(wrong)


def arguments(thing):
    """The parameters, of a class those it is made with: by position in order, then by name in any order."""
    try:
        signature = inspect.signature(thing).parameters.values()
    except ValueError:  # an exception of no parameters of its own
        return [], set()
    given = [each for each in signature if each.name not in ("self", "cls") and not each.name.startswith("_")]
    first = [each.name for each in given if each.kind is not each.KEYWORD_ONLY]
    return first, {each.name for each in given if each.kind is each.KEYWORD_ONLY}


def stated(thing, heading):
    """Names of the entries of a section, None without it."""
    text = sections(thing).get(heading)
    return None if text is None else [name for names, _, _ in entries(text) for name in names]


def test_parameters_are_those_of_the_signature():
    wrong = {
        name: (said, *wanted)
        for name, thing in DESCRIBED.items()
        for said, wanted in [(stated(thing, "Parameters"), arguments(thing))]
        if said is not None and [said[: len(wanted[0])], set(said[len(wanted[0]) :])] != [*wanted]
    }
    assert not wrong, said_of(wrong)


def test_functions_say_what_their_parameters_are():
    silent = [
        name
        for name, thing in THINGS.items()
        if inspect.isfunction(thing) and stated(thing, "Parameters") is None
        for first, others in [arguments(thing)]
        if not all(f"``{argument}``" in thing.__doc__ for argument in (*first, *others))
    ]
    assert not silent, said_of(silent)


def test_data_classes_say_what_they_are_made_of():
    silent = [
        name
        for name, thing in THINGS.items()
        if inspect.isclass(thing) and dataclasses.is_dataclass(thing)
        if stated(thing, "Parameters") is None and stated(thing, "Attributes") is None
    ]
    assert not silent, said_of(silent)


def test_attributes_are_those_of_the_class():
    wrong = {}
    for name, thing in THINGS.items():
        said = stated(thing, "Attributes") if inspect.isclass(thing) else None
        if said is not None:
            fields = [field.name for field in dataclasses.fields(thing)] if dataclasses.is_dataclass(thing) else []
            unknown = [key for key in said if key not in fields and not hasattr(thing, key)]
            missing = (
                [] if stated(thing, "Parameters") else [k for k in fields if k not in said and not k.startswith("_")]
            )
            if unknown or missing:
                wrong[name] = unknown, missing
    assert not wrong, said_of(wrong)


def test_exit_statuses_are_those_of_the_command():
    page = (ROOT / "docs" / "reference" / "command-line.rst").read_text(encoding="utf-8")
    table = set(re.findall(r"^   \* - (\d+)$", page, re.MULTILINE))
    said = sections(found("lure.analysis.cli.main"))["Returns"]
    assert table == set(re.findall(r"\b(\d+) [a-z]", said))
