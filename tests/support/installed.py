"""An empty environment with lure installed from its wheel: what somebody gets who has never seen the repository."""

import os
import re
import subprocess
import sys
import venv
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]


def built(into):
    """The sdist, and the wheel built from what the sdist holds; every path relative to the repository stays behind."""
    run([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", into], cwd=ROOT)
    (sdist,) = into.glob("*.tar.gz")
    unpacked = into / "unpacked"
    unpacked.mkdir()
    run(["tar", "xzf", sdist, "-C", unpacked])
    (source,) = unpacked.iterdir()
    run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", into], cwd=source)
    (wheel,) = into.glob("*.whl")
    return sdist, wheel


def needed(name, extras=()):
    """The distributions ``name`` asks for, directly or not, as installed here; none that it does not ask for."""
    found, waiting = {}, [(name, frozenset(extras))]
    while waiting:
        asked, extra = waiting.pop()
        if (canonical(asked), extra) in found:
            continue
        found[canonical(asked), extra] = have = distribution(asked)
        for requirement in map(Requirement, have.requires or []):
            marker = requirement.marker
            if marker is None or any(marker.evaluate({"extra": name}) for name in extra | {""}):
                waiting.append((requirement.name, frozenset(requirement.extras)))
    return [have for (key, _), have in found.items() if key != canonical(name)]


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


class Environment:
    """A virtual environment that holds the wheel and what the wheel asks for, and nothing else."""

    def __init__(self, folder, wheel):
        venv.create(folder, with_pip=False, symlinks=True)
        self.bin = folder / "bin"
        self.home = folder / "home"
        self.home.mkdir()
        version = f"python{sys.version_info[0]}.{sys.version_info[1]}"
        self.packages, self.wheel = folder / "lib" / version / "site-packages", wheel
        self.add()

    def add(self, *extras):
        """Install the wheel, or extras of it."""
        for have in needed("lure", extras):
            link(have, self.packages)
        # pip checks that everything the wheel's metadata asks for is there, in a version that will do
        pip = [
            sys.executable,
            "-m",
            "pip",
            "--python",
            self.bin / "python",
            "--disable-pip-version-check",
            "install",
            "--no-compile",
        ]
        run([*pip, "--no-index", "--quiet", f"{self.wheel}[{','.join(extras)}]" if extras else self.wheel])

    def run(self, *command, cwd, status=0):
        """What the command printed; it sees neither this environment nor the repository."""
        variables = {"PATH": f"{self.bin}:/usr/bin:/bin", "HOME": str(self.home), "OMP_NUM_THREADS": "1"}
        return run(
            [self.bin / command[0], *command[1:]], cwd=cwd, env={**variables, "MPLBACKEND": "Agg"}, status=status
        )


def link(have, packages):
    """The files of one installed distribution, linked into another environment."""
    for top in {file.parts[0] for file in have.files or [] if file.parts[0] not in ("..", "__pycache__")}:
        target = packages / top
        if not target.exists():
            target.symlink_to(Path(str(have.locate_file(top))).resolve())


def run(command, *, cwd=None, env=None, status=0):
    """Standard output of a command that ends with ``status``."""
    done = subprocess.run(list(map(os.fspath, command)), cwd=cwd, env=env, capture_output=True, text=True, timeout=300)
    assert done.returncode == status, f"{command}: {done.returncode}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout
