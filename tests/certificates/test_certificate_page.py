"""The certificate in the documentation: it is the one the command writes, and the checker alone accepts it."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

from lure.analysis.certificates.checker import Proved, check
from lure.analysis.cli import main

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "certificates.md").read_text(encoding="utf-8")
(SHOWN,) = re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)


def test_the_certificate_shown_is_accepted_and_is_the_one_the_command_writes(tmp_path, monkeypatch):
    (command,) = re.findall(r"^\$ lure (certify .* -o cert\.json)", PAGE, re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)) == 0
    assert json.loads(Path("cert.json").read_text(encoding="utf-8")) == json.loads(SHOWN)
    assert isinstance(check(SHOWN), Proved)


def test_the_checker_alone_accepts_it_and_refuses_the_polynomial_the_text_does_not_name(tmp_path):
    (line,) = re.findall(r"^python (.*checker\.py) cert\.json$", PAGE, re.MULTILINE)
    file = tmp_path / "cert.json"
    # the text has the polynomial: 80 - 77 x + 20 x^2, whose least value, at x = 77/40, is 471/80 > 0
    a, b, c = map(int, re.findall(r"`(\d+) - (\d+) x \+ (\d+) x\^2 > 0`", PAGE)[0])
    assert 4 * a * c - b * b == 471
    for middle, status in ((b, 0), (b - 1, 11)):
        file.write_text(SHOWN.replace(f'"-{b}"', f'"-{middle}"'), encoding="utf-8")
        command = [sys.executable, *shlex.split(line), str(file)]
        assert subprocess.run(command, cwd=ROOT, capture_output=True, check=False).returncode == status


def test_the_number_of_lines_to_read_is_right():
    folder = ROOT / "analysis" / "certificates"
    beside = ("arithmetic", "balls", "blocks", "boxes", "channels", "frequencies", "gains", "memory", "parametric",
              "parts", "pieces", "powers", "regions", "several", "signals", "states", "windows")  # fmt: skip
    names = ("checker", *beside)
    decides, *computes = (len((folder / f"{name}.py").read_text(encoding="utf-8").splitlines()) for name in names)
    words = r"under (\d+) lines, which decides, and the seventeen files beside it, about (\d+) lines"
    most, about = map(int, re.search(words, " ".join(PAGE.split())).groups())
    assert decides < most
    assert abs(sum(computes) - about) < 0.1 * about
