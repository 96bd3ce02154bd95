"""The report on a rod: what was found about it and its scheme, as an object, as JSON and as a page."""

from lure.analysis.rod.report.build import build_report as build_report
from lure.analysis.rod.report.document import document as document
from lure.analysis.rod.report.model import Claim as Claim
from lure.analysis.rod.report.model import Simulation as Simulation
from lure.analysis.rod.report.model import StabilityReport as StabilityReport
from lure.analysis.rod.report.model import claims as claims
from lure.analysis.rod.report.output import write_report as write_report
