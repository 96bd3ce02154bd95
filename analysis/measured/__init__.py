"""Measured laws: displacement and force from files, the sector of the mean law, the compliance law fitted."""

from analysis.measured.compliance import fit_compliance as fit_compliance
from analysis.measured.compliance_fit import ComplianceFit as ComplianceFit
from analysis.measured.compliance_fit import Parameter as Parameter
from analysis.measured.example import PATH as EXAMPLE
from analysis.measured.example import example_measurements as example_measurements
from analysis.measured.hysteresis import hysteresis_of as hysteresis_of
from analysis.measured.margin import MeasuredMargin as MeasuredMargin
from analysis.measured.margin import margin_of as margin_of
from analysis.measured.measured_sector import Hysteresis as Hysteresis
from analysis.measured.measured_sector import MeasuredSector as MeasuredSector
from analysis.measured.measured_sector import Outlier as Outlier
from analysis.measured.measurements import Measurements as Measurements
from analysis.measured.reading import read_measurements as read_measurements
from analysis.measured.report import MeasuredReport as MeasuredReport
from analysis.measured.report import report_of as report_of
from analysis.measured.sector import sector_of as sector_of

__all__ = [
    "EXAMPLE",
    "ComplianceFit",
    "Hysteresis",
    "MeasuredMargin",
    "MeasuredReport",
    "MeasuredSector",
    "Measurements",
    "Outlier",
    "Parameter",
    "example_measurements",
    "fit_compliance",
    "hysteresis_of",
    "margin_of",
    "read_measurements",
    "report_of",
    "sector_of",
]
