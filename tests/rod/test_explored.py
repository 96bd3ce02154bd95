"""The rod on the page in the browser: what is answered about it, without a package that a browser does not have."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from explored import WITHOUT

from lure.analysis.certificates.checker import check
from lure.analysis.explore import respond

ROOT = Path(__file__).parents[2]
PAPER = {"youngs_modulus": "288e6", "density": "8", "length": "1", "area": "0.25e-4", "damping": "2e-4", "cells": "20"}


def ask(**changes):
    return json.loads(respond(json.dumps({"ask": "rod", **PAPER, **changes})))


# A dashpot that takes energy out proves the rod by its energy, one that feeds energy in refutes it; without one nothing
# is said.  Z = A sqrt(rho E) = 0.25e-4 * 48000 = 1.2 N s/m.
@pytest.mark.parametrize(
    ("damping", "verdict"),
    [("2e-4", "PROVED"), ("Z", "PROVED"), ("3", "PROVED"), ("0", "INCONCLUSIVE"), ("-0.1", "REFUTED")],
)
def test_both_models_have_the_verdict_of_their_energy(damping, verdict):
    found = ask(damping=damping)
    assert found["impedance"] == pytest.approx(1.2, rel=1e-15)
    for model in ("rod", "scheme"):
        assert found[model]["verdict"] == verdict
        if verdict != "INCONCLUSIVE":
            assert found[model]["second"] is True
            shown = check(json.loads(found[model]["certificate"]))
            assert type(shown).__name__.upper() == verdict
            assert shown.certificate["system"]["kind"] == {"rod": "rod", "scheme": "rod-scheme"}[model]


@pytest.mark.slow
def test_nothing_but_the_standard_library_and_flint_is_needed():
    script = f"import sys, json\nfor name in {WITHOUT}:\n    sys.modules[name] = None\n"
    script += "from lure.analysis.explore.served import respond\n"
    script += f"print(respond(json.dumps({ {'ask': 'rod', **PAPER}!r})))"
    run = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout) == ask()


@pytest.mark.parametrize(
    ("changes", "field", "said"),
    [
        ({"density": "0"}, "density", "rod.density is 0; give a positive number"),
        ({"area": "x"}, "area", "give a number"),
        ({"damping": "2 ZZ"}, "damping", "multiple of the impedance"),
        ({"damping": "-Z"}, "damping", "minus the impedance"),
        ({"cells": "0"}, "cells", "whole number from 1 to 2000"),
        ({"cells": "2.5"}, "cells", "whole number"),
        ({"cells": "1e9"}, "cells", "whole number"),
        ({"length": ""}, "length", "give a number"),
    ],
)
def test_bad_input_is_one_sentence_beside_its_field(changes, field, said):
    found = ask(**changes)
    assert found["field"] == field
    assert said in found["error"]
