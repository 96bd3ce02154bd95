"""The report: what was found about a system, in order of strength, as an object, as JSON and as a page."""

from analysis.report.build import build_report as build_report
from analysis.report.claims import Claim as Claim
from analysis.report.claims import claims as claims
from analysis.report.document import document as document
from analysis.report.loop import LoopReport as LoopReport
from analysis.report.loop import build_loop_report as build_loop_report
from analysis.report.loop import write_loop_report as write_loop_report
from analysis.report.model import ContradictionError as ContradictionError
from analysis.report.model import Simulation as Simulation
from analysis.report.model import StabilityReport as StabilityReport
from analysis.report.reporting import report_on as report_on
from analysis.report.write import write_report as write_report
