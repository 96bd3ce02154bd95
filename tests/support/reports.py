"""Reports on loops and on variants of the paper's rod, made without figures and files."""

from dataclasses import replace
from fractions import Fraction

from lure.analysis.report.loop.model import LoopReport
from lure.analysis.rod.report import build_report
from lure.rod import builtin_system
from lure.rod.systems import rod_from_exact


def loop_report(analysis):
    """What is said of a loop, nothing simulated."""
    return LoopReport(analysis=analysis, observed=(), hints=(), command="", versions={"lure": ""})


def rod_report(changes, *, cells):
    """The report on the paper's rod with some parameters changed, exact numbers as text, and few cells."""
    paper = builtin_system("paper-rod")
    exact = {**paper.rod.exact, **{key: Fraction(value) for key, value in changes.items()}}
    return build_report(replace(paper, rod=rod_from_exact(exact), cells=cells, until=3e-3))
