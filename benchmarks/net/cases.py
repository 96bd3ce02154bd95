"""The cases of the safety net: every built-in system through every command, and random problems."""

import json
import math
import random
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

ROD = ("--set", "rod.gap=0", "--set", "rod.damping=0.24", "--set", "rod.compliance=3.5e-11")
FORMULAS = ("sin(x)", "tanh(x) + x/3", "min(max(2*x,-1),1)", "x*exp(-abs(x))", "x + x**3/3", "where(x > 1, x - 1, 0)")
NONLINEARITIES = ('kind = "saturation"\nlimit = 1', 'kind = "tanh"\nscale = 2', 'kind = "dead zone"\nwidth = 0.5')
REFUSED = (("systems", "nosuch"), ("max-sector", "--num", "x", "--den", "1"), ("certify", "--num", "1", "--den", "1 1"))


Case = dict[str, Any]  # name, argv, files, limit [s]; once answered also status, out, stderr, certificates, checked
Said = Callable[..., tuple[int, str, str]]  # exit status, standard output and standard error of a command


def builtin_cases(said: Said) -> Iterator[Case]:
    """Every built-in system through every command; DIR stands for the folder of the case."""
    names = [line.split()[0] for line in said("systems")[1].splitlines() if not line.startswith(" ")]
    every: list[tuple[str, ...]] = [("systems",), ("explain", "--json"), ("reproduce", "paper", "-o", "DIR/paper")]
    for name in names:
        toml = said("systems", name, "--toml")[1]
        every += [("systems", name), ("systems", name, "--toml"), ("report", name, "-o", "DIR/report")]
        if "[rod]" in toml:
            every += [("simulate", name), ("simulate", name, "--method", "scheme", "--until", "0.01")]
            every.append(("simulate", name, "--rigid", "--until", "0.05"))
            every += [("simulate", name, "--method", "galerkin", "--order", "11", "--until", "0.001")]
            every.append(("compare", name, "--until", "0.01", "--cells", "10,20", "--galerkin", "P1:11,cosine:10"))
            continue
        every += [("analyse", name), ("certify", name, "-o", "DIR/certificate.json")]
        for question in (("max-sector",), ("max-sector", "--time-varying"), ("max-slope",), ("max-slope", "--odd")):
            every.append((*question, "--system", name))
        for asked in (
            "--sector 0 1/2",
            "--sector 0 4",
            "--slope 0 1",
            "--slope 0 4 --odd",
            "--sector 0 1 --time-varying",
        ):
            every.append(("certify", name, *asked.split(), "-o", "DIR/certificate.json"))
        every.append(("certify", name, "--sector", "0", "1/2", "--method", "matrix", "-o", "DIR/certificate.json"))
        every += [("sector", "--expr", text) for text in re.findall(r'^text = "(.*)"', toml, re.MULTILINE)]
    every += [("sector", "--expr", text, *more) for text in FORMULAS for more in ((), ("--within", "0", "1"))]
    every += [("sector", "DIR/data.csv"), ("sector", "DIR/data.csv", "--fit"), *REFUSED]
    force, short = ("--force", "0.3+F*sin(3000*t)"), ("--settle", "0.05", "--periods", "8")
    every.append(("response", "paper-rod", *ROD, "--force", "0.3+0.7*sin(3000*t)", *short))
    span = ("--parameter", "F", "--from", "0.5", "--to", "1.1", "--count", "3")
    every.append(("bifurcation", "paper-rod", *ROD, *force, *span, *short))
    every.append(("basin", "paper-rod", *ROD, "--offset", "-1e-4", "1e-4", "2", "--velocity", "-0.5", "1", "3"))
    rows = (f"{i / 100 - 0.1},{max(i / 100 - 0.1, 0) ** 1.5 + 1e-4 * math.sin(97 * i * i):.9f}" for i in range(60))
    data = "displacement [mm],force [N]\n" + "\n".join(rows) + "\n"
    for argv in dict.fromkeys(every):
        files = {"data.csv": data} if "DIR/data.csv" in argv else {}
        bare = () if argv[0] == "systems" else ("--json",)
        quiet = () if argv[0] in ("systems", "explain") else ("--quiet",)
        rest = "+".join(argv[1:]).replace("DIR/", "").replace("/", ":")
        yield {"name": f"builtin/{argv[0]}/{rest}", "argv": [*argv, *bare, *quiet], "files": files, "limit": 120}


def random_case(place: int) -> Case:
    """A random problem: order 1 to 5, both times, poles at 0 or 1, dead time, sectors and slopes, odd or not."""
    draw = random.Random(place)
    discrete, n = draw.random() < 0.4, draw.randint(1, 5)
    steps = ([-4, -3, -2, -2, -1, -1, 0, 1], [1, 1, 2, 3]) if not discrete else ([*range(-9, 10), 11], [10])
    poles = [Fraction(draw.choice(steps[0]), draw.choice(steps[1])) for _ in range(n)]
    poles = poles if draw.random() < 0.2 else [Fraction(-1, 2) if not discrete and p >= 0 else p for p in poles]
    if draw.random() < 0.2:
        poles[0] = Fraction(discrete)
    den = [Fraction(1)]
    for pole in poles:
        den = [a - pole * b for a, b in zip([*den, 0], [0, *den], strict=True)]
    if n >= 2 and draw.random() < 0.4:  # a resonance: complex poles, found by moving a coefficient
        den[2] += Fraction(draw.randint(0, 8), 40 if discrete else 2)
    num = [Fraction(draw.randint(-3, 6), draw.choice([1, 1, 4])) for _ in range(draw.choice([n, n, n, n + 1]))]
    num, k = num if any(num) else [Fraction(1)], draw.choice(["0.1", "0.3", "0.6", "1", "2", "4"])
    kinds = {"max-sector": 26, "max-sector --time-varying": 10, "max-sector --full": 6, "max-sector --lower 1/4": 4}
    kinds |= {"max-slope": 9, "max-slope --odd": 9, "max-slope --criterion circle": 2, "analyse": 3, "certify": 3}
    kinds |= {f"certify --sector 0 {k}": 14, f"certify --slope 0 {k}": 7, f"certify --slope 0 {k} --odd": 7}
    question = draw.choices([*kinds], [*kinds.values()])[0]
    texts = [" ".join(map(str, side)) for side in (num, den)]
    plant = ["--num", texts[0], "--den", texts[1], *(["--dt", "1"] if discrete else [])]
    step, files = "dt = 1\n" if discrete else "", {}
    if not discrete and draw.random() < 0.03 and question.startswith(("max-sector", "certify --sector")):
        sides = ["+".join(f"({c})*s^{len(side) - 1 - i}" for i, c in enumerate(side)) for side in (num, den)]
        plant = ["--transfer", f"exp(-{draw.choice(['0.1', '0.5', '1'])}*s)*({sides[0]})/({sides[1]})"]
    if question in ("analyse", "certify"):
        sides = [json.dumps([str(c) for c in side]) for side in (num, den)]
        phi = draw.choice(NONLINEARITIES)
        text = f"[plant]\nnum = {sides[0]}\nden = {sides[1]}\n{step}[nonlinearity]\n{phi}\ngain = {k}\n"
        files, plant = {"plant.toml": text}, ["DIR/plant.toml"]
    written = ["-o", "DIR/certificate.json"] if question.startswith("certify") else []
    argv = [*question.split(), *plant, *written, "--json", "--quiet"]
    return {"name": f"random/{place:04d}", "argv": argv, "files": files, "limit": 10}
