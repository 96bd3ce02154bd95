"""The report: what was found about a system, in order of strength, as an object, as JSON and as a page."""

from lure.analysis.report.build import build_report as build_report
from lure.analysis.report.claims import Claim as Claim
from lure.analysis.report.claims import claims as claims
from lure.analysis.report.document import document as document
from lure.analysis.report.loop import LoopReport as LoopReport
from lure.analysis.report.loop import build_loop_report as build_loop_report
from lure.analysis.report.loop import write_loop_report as write_loop_report
from lure.analysis.report.model import ContradictionError as ContradictionError
from lure.analysis.report.model import Simulation as Simulation
from lure.analysis.report.model import StabilityReport as StabilityReport
from lure.analysis.report.output import write_report as write_report
from lure.analysis.report.reporting import report_on as report_on

report = report_on  # its name in lure, where no module is in the way
