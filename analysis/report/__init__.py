"""Reports: what was found about a system, in order of strength, as an object, as JSON and as a page."""

from lure.analysis.report.loop import LoopReport as LoopReport
from lure.analysis.report.loop import build_loop_report as build_loop_report
from lure.analysis.report.loop import write_loop_report as write_loop_report
from lure.analysis.report.parts import ContradictionError as ContradictionError
from lure.analysis.report.reporting import report_on as report_on

report = report_on  # its name in lure, where no module is in the way
