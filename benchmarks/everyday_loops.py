"""Claim: commands, both checkers, simulation and Python objects agree on more than 300 everyday loops.

Textbook plants of order 1 to 8, servos, integrators, dead times, sampled loops, resonances and unstable plants, each
with several nonlinearities and classes, each plant in one of the forms that people bring.  Every loop goes through
``report``, ``analyse``, ``certify``, ``verify`` and ``verify --second``, and through ``analyse`` of Python objects.
Fails where a command ends with a status other than 0, 10 or 11 (1 is a bug, or a contradiction between proof and
simulation), where two of them disagree, where a checker refuses what was written, or where numpy warns of a number.

``python benchmarks/everyday_loops.py --part 1/20`` runs every twentieth loop, and ``NAME ...`` those named.
"""

import argparse
import contextlib
import io
import itertools
import json
import multiprocessing
import sys
import tempfile
import time
import tomllib
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

STATUS = {"PROVED": 0, "INCONCLUSIVE": 10, "REFUTED": 11}
LIMIT = 300.0  # [s] for one loop through all commands

# name: (formula, a gain near which linear loops become unstable or, where there is none, a large one)
CONTINUOUS = {
    "lag": ("1/(s+1)", 20),
    "fast-lag": ("10/(s+10)", 5),
    "slow-lag": ("1/(1000*s+1)", 50),
    "lead-lag": ("(s+2)/(s+1)", 10),
    "lag-lead": ("(s+1)/(s+10)", 10),
    "washout": ("s/(s+1)", 10),
    "two-lags": ("1/((s+1)*(0.1*s+1))", 30),
    "three-lags": ("1/((s+1)*(0.5*s+1)*(0.25*s+1))", 13),
    "triple-lag": ("1/(s+1)^3", 8),
    "four-lags": ("1/(s+1)^4", 4),
    "six-lags": ("1/(s+1)^6", 2),
    "eight-lags": ("1/(s+1)^8", 1.5),
    "spread-lags": ("1/((s+1)*(0.2*s+1)*(0.04*s+1)*(0.008*s+1)*(0.0016*s+1))", 30),
    "integrator": ("1/s", 10),
    "motor": ("1/(s*(s+1))", 10),
    "motor-fast": ("50/(s*(0.02*s+1))", 1),
    "servo": ("1/(s*(s+1)*(s+2))", 6),
    "servo-lags": ("10/(s*(0.1*s+1)*(0.02*s+1))", 6),
    "pd-servo": ("(0.2*s+1)*10/(s*(0.1*s+1)*(0.02*s+1))", 20),
    "pi-servo": ("(0.8+1.6/s)*10/(s*(0.1*s+1)*(0.02*s+1))", 5),
    "pi-lag": ("(1+0.5/s)/(s+1)", 10),
    "pid-lags": ("(1+0.2/s+0.3*s/(0.03*s+1))/((s+1)*(0.5*s+1))", 20),
    "double-integrator": ("1/s^2", 1),
    "double-integrator-pd": ("(s+1)/s^2", 1),
    "resonance": ("1/(s^2+0.2*s+1)", 5),
    "sharp-resonance": ("1/(s^2+0.002*s+1)", 1),
    "velocity-resonance": ("s/(s^2+0.1*s+1)", 10),
    "two-masses": ("(s^2+0.1*s+1)/(s*(s+1)*(s^2+0.2*s+4))", 8),
    "integrator-resonance": ("1/(s*(s^2+0.4*s+1))", 0.4),
    "notch": ("(s^2+0.02*s+1)/((s^2+0.4*s+2)*(s+1))", 6),
    "zero-right": ("(1-s)/((s+1)*(s+2))", 3),
    "zero-right-slow": ("(1-0.2*s)/((s+1)^2)", 10),
    "oscillator-biproper": ("(s^2-s+10)/(s^2+s+25)", 20),
    "unstable-lag": ("4/((s-1)*(s/3+1))", 1),
    "unstable-pole": ("1/(s-1)", 4),
    "pendulum-pd": ("(s+3)/(s^2-1)", 4),
    "aircraft": ("(s+0.6)/(s*(s^2+1.4*s+2.2)*(0.1*s+1))", 8),
    "hydraulic": ("100/(s*(s^2+12*s+400))", 40),
    "thermal": ("1/((300*s+1)*(20*s+1)*(2*s+1))", 60),
    "negative": ("-1/(s+1)^2", 0.9),
    "dead-time": ("exp(-s)/(s+1)", 2.2),
    "dead-time-slow": ("exp(-0.2*s)/(5*s+1)", 35),
    "dead-time-second": ("2*exp(-0.5*s)/((s+1)*(2*s+1))", 3),
}
# name: (formula, gain, sampling time [s])
DISCRETE = {
    "sampled-lag": ("0.1/(z-0.9)", 15, "1"),
    "sampled-integrator": ("0.5/(z-1)", 3, "1"),
    "sampled-lead": ("(z+1)/(z-0.5)", 2, "1"),
    "sampled-motor": ("(0.005*z+0.0048)/((z-1)*(z-0.9))", 18, "0.1"),
    "kilohertz": ("0.01/(z^2*(z-0.99))", 40, "0.001"),
    "kilohertz-integrator": ("0.02/(z^2*(z-1))", 20, "0.001"),
    "two-samples": ("0.2/(z^2*(z-0.8))", 3, "0.01"),
    "sampled-resonance": ("(0.1*z+0.09)/(z^2-1.8*z+0.9)", 1, "0.05"),
    "dt-1": ("0.1*z/(z^2-1.8*z+0.81)", 30, "1"),
    "dt-5": ("(-0.5*z+0.1)/(z^3-0.9*z^2+0.79*z+0.089)", 0.8, "1"),
    "dt-6": ("(2*z+0.92)/(z^2-0.5*z)", 0.9, "1"),
    "sampled-fourth": ("0.001*(z+0.9)/((z-0.9)*(z-0.8)*(z-0.7)*(z-0.6))", 15, "0.02"),
    "moving-average": ("0.25*(z^3+z^2+z+1)/z^4", 3, "1"),
    "sampled-unstable": ("0.5/(z-1.1)", 2, "1"),
}


def nonlinearities(gain: float) -> dict[str, str]:
    """Tables of a system file by name, scaled so that the steepest has the given gain."""
    half = gain / 2
    return {
        "saturation": f'[nonlinearity]\nkind = "saturation"\ngain = {gain:g}\nlimit = 1\n',
        "tanh": f'[nonlinearity]\nkind = "tanh"\ngain = {gain:g}\nscale = 0.5\n',
        "dead-zone": f'[nonlinearity]\nkind = "dead zone"\nwidth = 0.1\ngain = {gain:g}\n',
        "quantiser": f'[nonlinearity]\nkind = "quantiser"\nstep = {half:g}\n',
        "relu": f'[nonlinearity]\nkind = "relu"\ngain = {gain:g}\n',
        "leaky": f'[nonlinearity]\nkind = "leaky relu"\nnegative_slope = {half / 5:g}\npositive_slope = {gain:g}\n',
        "points": f'[nonlinearity]\nkind = "piecewise linear"\npoints = [[-1, {-half:g}], [0, 0], [1, {half:g}]]\n'
        f"left_slope = {half / 4:g}\nright_slope = {gain:g}\n",
        "declared": '[nonlinearity]\nkind = "expression"\n'
        f'expression = "{half:g}*tanh(sigma) + {half:g}*sigma/(1+sigma**2)"\nsector = [0, {gain:g}]\n',
        "formula": f'[nonlinearity]\nkind = "expression"\nexpression = "{half:g}*(sigma + sin(sigma)/2)"\n'
        f"sector = [0, {gain:g}]\nslope = [0, {gain:g}]\nodd = true\n",
        "cubic": f'[nonlinearity]\nkind = "cubic"\ncubic = 1\nlinear = {half:g}\n',
        "sector": f"[class]\nsector = [0, {gain:g}]\n",
        "sector-shifted": f"[class]\nsector = [{half / 4:g}, {gain:g}]\n",
        "slope-odd": f"[class]\nsector = [0, {gain:g}]\nslope = [0, {gain:g}]\nodd = true\n",
        "slope": f"[class]\nsector = [0, {gain:g}]\nslope = [0, {gain:g}]\n",
        "varying": f"[class]\nsector = [0, {gain:g}]\ntime_varying = true\n",
        "every": "[class]\nsector = [0, inf]\n",
    }


FORMS = ("transfer", "coefficients", "matrices")
OBJECTS = ("tf", "ss", "scipy", "tuple")


@dataclass(frozen=True, slots=True)
class Everyday:
    """A loop: its name, its system file, and the kind of Python object that its plant is brought as."""

    name: str
    text: str
    brought_as: str


def loops() -> Iterator[Everyday]:
    """All loops, the same at every call: each plant with a rotating choice of six nonlinearities or classes."""
    forms, objects, factors = itertools.cycle(FORMS), itertools.cycle(OBJECTS), itertools.cycle((0.3, 0.9, 1.5, 0.6))
    plants = [(name, formula, gain, None) for name, (formula, gain) in CONTINUOUS.items()]
    plants += [(name, formula, gain, dt) for name, (formula, gain, dt) in DISCRETE.items()]
    for place, (name, formula, gain, dt) in enumerate(plants):
        kinds = list(nonlinearities(1))
        for kind in [kinds[(place + 3 * step) % len(kinds)] for step in range(6)]:
            form = "transfer" if "exp(" in formula else next(forms)
            table = nonlinearities(round(gain * next(factors), 4))[kind]
            text = f'name = "{name}-{kind}"\n\n[plant]\n{plant_lines(formula, form, dt)}\n{table}'
            yield Everyday(f"{name}-{kind}", text, next(objects))


def plant_lines(formula: str, form: str, dt: str | None) -> str:
    """The table ``[plant]`` of a formula in one of the forms."""
    from lure import as_plant

    sampling = "" if dt is None else f"dt = {dt}\n"
    if form == "transfer":
        return f'transfer = "{formula}"\n{sampling}'
    block = as_plant(formula, dt=None if dt is None else float(dt))
    numerator, denominator = block.numerator, block.denominator
    if form == "coefficients" or len(denominator) == 1:
        texts = ([f"{value}" for value in side] for side in (numerator, denominator))
        return (
            "\n".join(f"{key} = {json.dumps(side)}" for key, side in zip(("num", "den"), texts, strict=True))
            + f"\n{sampling}"
        )
    n = len(denominator) - 1
    padded = [0] * (n + 1 - len(numerator)) + list(numerator)
    through = padded[0]
    rows = [[f"{int(j == i + 1)}" for j in range(n)] for i in range(n - 1)]
    rows.append([f"{-value}" for value in reversed(denominator[1:])])
    output = [
        f"{value - through * below}"
        for value, below in zip(reversed(padded[1:]), reversed(denominator[1:]), strict=True)
    ]
    matrices = {"A": rows, "B": ["0"] * (n - 1) + ["1"], "C": output, "D": f"{through}"}
    return "\n".join(f"{key} = {json.dumps(value)}" for key, value in matrices.items()) + f"\n{sampling}"


def run(*arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of a command."""
    from lure.analysis.cli import main

    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        status = main(arguments)
    return status, out.getvalue(), err.getvalue()


def faults(loop: Everyday, folder: Path) -> tuple[list[str], str]:
    """What is wrong with the commands' answers to one loop, and the verdict."""
    file = folder / "loop.toml"
    file.write_text(loop.text, encoding="utf-8")
    found: list[str] = []
    verdicts: dict[str, str] = {}
    for command, more in (
        ("analyse", ()),
        ("report", ("-o", str(folder / "report"))),
        ("certify", ("-o", str(folder / "certificate.json"), "--force")),
    ):
        status, out, err = run(command, str(file), "--json", "--quiet", *more)
        if status not in STATUS.values():
            found.append(f"{command}: status {status}: {err.strip()[:300]}")
            continue
        verdicts[command] = next(verdict for verdict, code in STATUS.items() if code == status)
        if (said := json.loads(out).get("verdict")) not in (None, verdicts[command]):
            found.append(f"{command}: status {status}, and the JSON says {said}")
    if len(set(verdicts.values())) > 1:
        found.append(f"disagreement: {verdicts}")
    written = [*sorted((folder / "report").glob("certificates/*.json")), *folder.glob("certificate.json")]
    if verdicts.get("certify") not in (None, "INCONCLUSIVE") and not (folder / "certificate.json").exists():
        found.append("certify: no certificate was written")
    for options in ((), ("--second",)):
        status, out, err = run("verify", *map(str, written), *options) if written else (0, "", "")
        if status:
            refused = [line for line in out.splitlines() if "REJECTED" in line][:2]
            found.append(f"verify {' '.join(options)}: status {status}: {refused} {err.strip()[:300]}")
    verdict = verdicts.get("analyse", "none")
    found += objects_disagree(loop, verdict)
    return found, verdict


def objects_disagree(loop: Everyday, verdict: str) -> list[str]:
    """What the same loop says when its plant is brought as a Python object; nothing where no object can say it."""
    from lure.analysis import analyse
    from lure.files import parse_system
    from lure.loop import Loop
    from lure.plants.rational import RationalPlant

    system = parse_system(loop.text, name=loop.name, source="loop.toml", settings=())
    if (
        not isinstance(system.block, RationalPlant)
        or system.nonlinearity is None
        or "class" in tomllib.loads(loop.text)
    ):
        return []
    plant = brought(system.block, loop.brought_as)
    other = str(analyse(Loop(plant, system.nonlinearity)).verdict)
    return (
        [] if other == verdict else [f"disagreement: analyse says {verdict}, of the {loop.brought_as} object {other}"]
    )


def brought(block: object, form: str) -> object:
    """A rational block as an object of python-control or scipy, or as a tuple of coefficients."""
    import control
    import scipy.signal

    numerator, denominator = ([float(value) for value in side] for side in (block.numerator, block.denominator))
    dt = 0 if block.dt is None else float(block.dt)
    if form == "tuple" and block.dt is None:
        return numerator, denominator
    if form == "scipy":
        sampling: Mapping[str, float] = {} if block.dt is None else {"dt": dt}
        return scipy.signal.TransferFunction(numerator, denominator, **sampling)
    plant = control.tf(numerator, denominator, dt)
    return control.ss(plant) if form == "ss" else plant


def watched(loop: Everyday) -> tuple[list[str], str, float]:
    """The faults of a loop, found in a process of its own that is ended when its time is over."""
    ours, theirs = multiprocessing.get_context("fork").Pipe(duplex=False)

    def work() -> None:
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", RuntimeWarning)
            try:
                found, verdict = faults(loop, Path(folder))
                theirs.send(([*found, *(f"{each.filename}: {each.message}" for each in given)], verdict))
            except BaseException as error:  # what a loop raises is what is looked for
                theirs.send(([f"{type(error).__name__}: {error}"], "none"))

    start = time.perf_counter()
    process = multiprocessing.get_context("fork").Process(target=work)
    process.start()
    answer = ours.recv() if ours.poll(LIMIT) else ([f"not done within {LIMIT:g} s"], "none")
    process.kill()
    process.join()
    return *answer, time.perf_counter() - start


def main() -> int:
    """Run the campaign; 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--part", default="1/1", help="I/N: every N-th loop, from the I-th on")
    parser.add_argument("--quiet", action="store_true", help="print only what is wrong, and the count")
    chosen = parser.parse_args()
    first, step = map(int, chosen.part.split("/"))
    every = [loop for loop in loops() if not chosen.names or loop.name in chosen.names][first - 1 :: step]
    wrong, verdicts, start = 0, Counter(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        faults(next(loops()), Path(folder))  # what it imports is there in the processes of the others
    for loop in every:
        found, verdict, seconds = watched(loop)
        wrong += bool(found)
        verdicts[verdict] += 1
        if found or not chosen.quiet:
            print(f"{loop.name:<36} {verdict:<13} {seconds:6.1f} s  {' | '.join(found)}", flush=True)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
    print(f"{len(every)} loops in {time.perf_counter() - start:.0f} s: {counts}; {wrong} with faults   (claim: 0)")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
