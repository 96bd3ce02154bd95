"""The files of `make quick`: those whose tests name what git says is changed, then one or more of every floor.

``python tests/quick.py`` prints them.  Nothing is imported: to collect all tests takes longer than to run these.
"""

import re
import subprocess
from pathlib import Path

TESTS = Path(__file__).parent
ROOT = TESTS.parent
MOST = 12  # files of tests that the changes touch; `make test` runs all of them
FLOORS = (  # seconds each
    *(
        "layers",
        "floors",
        "problem",
        "analysis",
        "exact",
        "expressions",
        "sector",
        "rational",
        "transform",
        "system_file",
    ),
    *("polynomial", "trigonometric", "bounds_violations", "popov_plant", "park", "hurwitz", "refutation_switched"),
    *("certificate_kernel", "certificate_edges", "certify", "answers_agree", "measured_reading", "plots_public"),
    *("report_opening", "cli_explain", "rod", "free_motion"),
)


def changed():
    """Files that differ from the last commit, or those of the last commit where none does."""

    def git(*arguments):
        return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()

    now = git("diff", "--name-only", "HEAD") + git("ls-files", "--others", "--exclude-standard")
    return now or git("diff", "--name-only", "HEAD~1")


def touched(names, texts):
    """Files of tests that changed or that name a changed module, those that name most of them first."""
    modules = [name.removesuffix(".py").removesuffix("/__init__") for name in names if name.endswith(".py")]
    dotted = [
        re.compile(rf"\b{re.escape('lure.' * name.startswith('analysis') + name.replace('/', '.'))}\b")
        for name in modules
        if name.startswith(("lure/", "analysis/"))
    ]
    found = {path: sum(bool(module.search(text)) for module in dotted) for path, text in texts.items()}
    own = [path for path in texts if path.relative_to(ROOT).as_posix() in names]
    return (own + sorted((path for path in found if found[path]), key=lambda path: (-found[path], path)))[:MOST]


def chosen(names):
    """All files of `make quick`, each once."""
    texts = {path: path.read_text("utf-8") for path in sorted(TESTS.rglob("test_*.py"))}
    floors = [path for floor in FLOORS for path in texts if path.stem == f"test_{floor}"]
    return list(dict.fromkeys([*touched(names, texts), *floors]))


if __name__ == "__main__":
    print(*(path.relative_to(ROOT).as_posix() for path in chosen(changed())))
