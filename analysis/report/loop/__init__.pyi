from lure.analysis.report.loop.model import LoopReport as LoopReport
from lure.analysis.report.loop.write import build_loop_report as build_loop_report
from lure.analysis.report.loop.write import write_loop_report as write_loop_report
