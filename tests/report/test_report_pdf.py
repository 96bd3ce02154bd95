"""`lure report --pdf`: one PDF, with every figure, or one sentence where none can be made."""

import base64
import re
import sys

import pytest

from lure.analysis.cli import main
from lure.analysis.report.diagram import block_diagram, class_graph
from lure.analysis.report.loop import build_loop_report
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.write import loop_diagram, loop_page
from lure.analysis.report.pdf import MARK, pdf_maker, pdf_of, printed_diagram
from lure.errors import InputError
from lure.files.builtin import builtin_loop

installed = pytest.mark.usefixtures("weasyprint")


@pytest.fixture
def weasyprint():
    """The module, imported where a test needs it: it takes half a second."""
    try:
        return pdf_maker()
    except InputError as missing:
        pytest.skip(str(missing))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def names(directory):
    return sorted(path.name for path in directory.iterdir())


@installed
@pytest.mark.usefixtures("sketched")
@pytest.mark.slow
def test_a_name_that_ends_in_pdf_is_a_file(here, capsys, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")  # fontTools writes the date into a subset of a font
    assert main(["report", "contact", "-o", "loop.pdf", "--quiet"]) == 0
    assert names(here) == ["loop.pdf"]
    first = (here / "loop.pdf").read_bytes()
    assert first.startswith(b"%PDF-")
    assert first.endswith(MARK)
    assert main(["report", "contact", "-o", "loop.pdf"]) == 0  # one of ours is replaced
    assert (here / "loop.pdf").read_bytes() == first
    assert capsys.readouterr().out.endswith("The report is loop.pdf\n")


@installed
@pytest.mark.usefixtures("sketched")
@pytest.mark.slow
def test_a_directory_gets_a_pdf_only_if_asked_and_is_replaced_as_before(here):
    assert main(["report", "contact", "--pdf", "--quiet"]) == 0
    assert names(here / "lure-report") == ["certificates", "figures", "report.html", "report.json", "report.pdf"]
    assert main(["report", "contact", "--quiet"]) == 0
    assert names(here / "lure-report") == ["certificates", "figures", "report.html", "report.json"]


@pytest.mark.slow_for("thesis.pdf-'thesis.pdf' exists")
@installed
@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("thesis.pdf", "'thesis.pdf' exists and is not a report; give another name with -o\n"),
        ("no/loop.pdf", "'no/loop.pdf' cannot be written, since 'no' is not a directory; make it first\n"),
    ],
)
def test_a_pdf_of_others_stays(here, capsys, target, sentence):
    (here / "thesis.pdf").write_bytes(b"%PDF-1.7 ten years of work")
    assert main(["report", "contact", "-o", target]) == 2
    assert capsys.readouterr().err.endswith(sentence)
    assert names(here) == ["thesis.pdf"]
    assert (here / "thesis.pdf").read_bytes() == b"%PDF-1.7 ten years of work"


@pytest.mark.parametrize("words", [["--pdf"], ["-o", "loop.pdf"]])
def test_without_the_extra_one_sentence_says_so_and_nothing_is_written(here, monkeypatch, capsys, words):
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    assert main(["report", "contact", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "pip install 'lure[pdf]'" in err
    assert names(here) == []
    with pytest.raises(InputError, match="needs weasyprint"):
        pdf_of("<p>x</p>")


@pytest.fixture(scope="module")
def paper():
    report = build_loop_report(builtin_loop("contact"))
    figures = loop_figures(report)
    return loop_page(report.to_dict(), figures, loop_diagram(report), paper=True), figures


@pytest.mark.slow
def test_on_paper_every_figure_is_an_image_in_colours_of_its_own(paper):
    page, figures = paper
    images = re.findall(r'<img class="(\w+)" alt="[^"]*" src="data:image/svg\+xml;base64,([^"]+)">', page)
    assert [kind for kind, _ in images] == ["diagram", *["figure"] * len(figures)]
    for _, data in images:
        assert "var(--" not in base64.b64decode(data).decode()
    assert not re.findall('<svg class="(?:figure|diagram)"', page)


def test_the_diagram_on_paper_has_every_rule_of_the_page():
    made = printed_diagram(block_diagram("1 / (s + 1)", "phi", class_graph(None)))
    svg = base64.b64decode(re.findall(r"base64,([^\"]+)", made)[0]).decode()
    for rule in (".box {", ".wire {", ".tip {", "text {", ".small {", ".axis {", ".graph {", ".wedge {"):
        assert rule in svg
    assert svg.startswith("<svg xmlns=")
    assert "s + 1" in svg


@pytest.mark.slow
def test_the_details_are_open_on_paper(paper, weasyprint):
    page, _ = paper
    whole = weasyprint.HTML(string=page).render()
    folded = weasyprint.HTML(string=re.sub(r"<details.*?</details>", "", page, flags=re.DOTALL)).render()
    assert len(whole.pages) > len(folded.pages) >= 1
