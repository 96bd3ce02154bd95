"""The report on any Lur'e loop: one table of classes, what proves and what refutes them, as HTML and JSON."""

from analysis.report.loop.build import build_loop_report as build_loop_report
from analysis.report.loop.model import LoopReport as LoopReport
from analysis.report.loop.write import write_loop_report as write_loop_report
