"""Pictures of the pages: before Sphinx reads, the code of a page that shows pictures is run, in `docs/pictures/PAGE/`.

So a picture is what the code beside it draws; those of the theory pages are drawn by `figures`.  The tests run the
same pages with the same runner,
`tests/support/documents.py`.  A page is run again when its text changed or the packages did.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.config import Config

ROOT = Path(__file__).resolve().parents[2]
PICTURE = re.compile(r"pictures/([\w-]+)/[\w./-]+")


def shown(docs: Path) -> dict[str, Path]:
    """The pages whose pictures are shown anywhere, by the name of their folder in `docs/pictures/`."""
    written = [path for path in docs.rglob("*.md") if "notes" not in path.parts]
    names = {name for path in written for name in PICTURE.findall(path.read_text(encoding="utf-8"))}
    return {path.stem: path for path in written if path.stem in names}


def state(page: Path) -> str:
    """A digest of what the pictures of a page depend on: its text and every module."""
    digest = hashlib.sha256(page.read_bytes())
    for module in sorted((*ROOT.glob("lure/**/*.py"), *ROOT.glob("analysis/**/*.py"))):
        digest.update(module.read_bytes())
    return digest.hexdigest()


def draw(docs: Path) -> None:
    """Run every page whose pictures are not up to date."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from documents import run_page
    from matplotlib import rc_context

    for name, page in shown(docs).items():
        folder = docs / "pictures" / name
        stamp, now = folder / "state.txt", state(page)
        if stamp.exists() and stamp.read_text(encoding="utf-8") == now:
            continue
        # outside the repository, as for a reader; of a size that a phone need not shrink by much
        with TemporaryDirectory() as place, rc_context({"figure.figsize": (5.4, 4.1)}):
            run_page(page, Path(place))
            shutil.rmtree(folder, ignore_errors=True)
            for file in (path for path in Path(place).rglob("*") if path.suffix in {".svg", ".png"}):
                kept = folder / file.relative_to(place)
                kept.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, kept)
        stamp.write_text(now, encoding="utf-8")
    draw_theory(docs)


def draw_theory(docs: Path) -> None:
    """Draw the figures of the theory pages, if their script or a module has changed."""
    script, folder = Path(__file__).with_name("figures.py"), docs / "pictures" / "theory"
    runs = docs / "how-to" / "long-runs.md"
    stamp, now = folder / "state.txt", "".join(map(state, (script, script.with_name("channel_figures.py"), runs)))
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != now:
        import figures

        figures.draw(folder)
        stamp.write_text(now, encoding="utf-8")


def hold_places(docs: Path) -> None:
    """Write an empty drawing for every picture that is not there."""
    for page in docs.rglob("*.md"):
        for found in PICTURE.finditer(page.read_text(encoding="utf-8")):
            file = docs / found[0]
            if not file.exists():
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text('<svg xmlns="http://www.w3.org/2000/svg"/>', encoding="utf-8")


def prepare(app: Sphinx, config: Config) -> None:
    """Draw, before Sphinx looks for pictures."""
    if config.draw_pictures:
        draw(Path(app.srcdir))
    else:
        hold_places(Path(app.srcdir))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the setting ``draw_pictures``: 0 leaves every picture empty, for a quick look at the words."""
    app.add_config_value("draw_pictures", default=True, rebuild="env")
    app.connect("config-inited", prepare)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
