"""What the tests of files for Coq share: how one is compiled, and what is falsified in it."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from lure.analysis.certificates.drafts import complete_and_check

KEPT = json.loads((Path(__file__).parent / "certificates.json").read_text("utf-8"))
LOOP = "(* ---- This loop ---- *)"
AXIOMS = {
    "ClassicalDedekindReals.sig_not_dec",
    "ClassicalDedekindReals.sig_forall_dec",
    "FunctionalExtensionality.functional_extensionality_dep",
    "Classical_Prop.classic",
}
needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="coqc is not installed (Debian: apt install coq)")


def common(folder, lemmas):
    """The lemmas that a file begins with, compiled in a folder: nothing of them is falsified."""
    (folder / "common.v").write_text(lemmas)
    subprocess.run(["coqc", "common.v"], cwd=folder, check=True, capture_output=True)
    return folder


def names(text):
    """What a file defines outside of its modules, in order."""
    text = re.sub(r"^Module (\w+)\.$.*?^End \1\.$", "", text, flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"^(?:Definition|Fixpoint|Inductive|Lemma|Theorem) (\w+)", text, re.MULTILINE)


def compiled(library, text):
    """Whether what is about the loop compiles, and what was printed; the whole file must define no name twice."""
    first, _, own = text.partition(LOOP)
    assert len(found := names(text)) == len({*found}), "a name is defined twice, which coqc refuses in one file"
    folder = library(first.partition("*)")[2])
    head = "Require Import Reals ZArith List Lra Lia Bool common.\nImport ListNotations.\nOpen Scope R_scope.\n"
    (folder / "loop.v").write_text(head + own)
    found = subprocess.run(["coqc", "loop.v"], cwd=folder, capture_output=True, text=True, check=False)
    return found.returncode == 0, found.stdout + found.stderr


def resting_on_axioms(said):
    """Whether nothing is assumed but the axioms of the reals and the excluded middle."""
    return set(re.findall(r"^([\w.]+)\s*(?:$|:)", said.partition("Axioms:")[2], re.MULTILINE)) <= AXIOMS


def changed(text, right, wrong):
    """One place changed."""
    assert right in text
    return text.replace(right, wrong)


def proved(system, upper, theorem="circle", multiplier=None, *, varying=False, lower="0", **more):
    laws = {"sector": [lower, upper], "slope": None, "odd": False, "time_varying": varying, "linear": False}
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": theorem, "multiplier": multiplier or {}}
    return complete_and_check(draft | {"proof": {"method": "polynomial"}} | more)
