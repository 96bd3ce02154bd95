"""What can be said about a Lur'e loop, by what means, and with which margin."""

from lure.extensions import extend
from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

extend(
    "drawing",
    {
        "lure.analysis.describing:DescribingHint": "lure.analysis.plots.responses:plot_hint",
        "lure.analysis.graphical.nyquist:NyquistResponse": "lure.analysis.plots.responses:plot_nyquist_response",
        "lure.analysis.graphical.popov:PopovResponse": "lure.analysis.plots.responses:plot_popov_response",
        "lure.analysis.measured.compliance:ComplianceFit": "lure.analysis.plots.measured:plot_compliance",
        "lure.analysis.measured.measured_sector:MeasuredSector": "lure.analysis.plots.measured:plot_measured",
        "lure.analysis.measured.reading:Measurements": "lure.analysis.plots.measured:plot_measurements",
        "lure.analysis.nonlinearity.result:NonlinearityBounds": "lure.analysis.plots.sectors:plot_nonlinearity_sector",
        "lure.analysis.questions.channel_map:StabilityMap": "lure.analysis.plots.regions:plot_map",
        "lure.analysis.questions.margins:Tolerances": "lure.analysis.plots.regions:plot_tolerances",
        "lure.analysis.questions.decay:RateBound": "lure.analysis.plots.performance:plot_rate",
        "lure.analysis.questions.gain:GainBound": "lure.analysis.plots.performance:plot_gain",
        "lure.analysis.questions.regions:RegionOfAttraction": "lure.analysis.plots.regions:plot_region",
        "lure.analysis.questions.steady:SteadyResponse": "lure.analysis.plots.performance:plot_steady",
        "lure.analysis.questions.largest:StabilityBound": "lure.analysis.plots.loops:plot_largest",
        "lure.analysis.questions.table:LoopAnalysis": "lure.analysis.plots.loops:plot_largest",
        "lure.analysis.rod.confirmation.result:Confirmation": "lure.analysis.rod.plots.comparison:plot_both_ends",
        "lure.analysis.rod.response.resting:Basin": "lure.analysis.rod.plots.response:plot_basin",
        "lure.analysis.rod.response.run:Response": "lure.analysis.rod.plots.response:plot_response",
        "lure.analysis.rod.response.sweeping:Bifurcation": "lure.analysis.rod.plots.response:plot_bifurcation",
        "lure.analysis.rod.runs.sampled:SampledRun": "lure.analysis.rod.plots.run:plot_run_end",
        "lure.analysis.rod.simulation.trajectory:Trajectory": "lure.analysis.rod.plots.motion:plot_end_motion",
        "lure.analysis.testing.result:Violation": "lure.analysis.plots.sectors:plot_violation",
    },
)
extend("explored", {"lure.rod.systems:RodSystem": "lure.analysis.rod.explored:ANSWERS"})
extend("explore panel", {"lure.rod.systems:RodSystem": "lure.analysis.rod.explored:panel"})
extend("file", {"builtins:object": "lure.analysis.plots.style:render"})
extend("beyond", {"lure.rod.assembly:RodAssembly": "lure.analysis.rod.assembly:of_the_rods"})
extend("beyond, followed", {"lure.rod.assembly:RodAssembly": "lure.analysis.rod.assembly:followed"})
extend("sweep", {"lure.rod.systems:RodSystem": "lure.analysis.rod.sweeping:rod_row"})
extend("report", {"lure.rod.systems:RodSystem": "lure.analysis.rod.report.build:build_report"})
extend(
    "report files",
    {
        "lure.analysis.report.loop.model:LoopReport": "lure.analysis.report.loop.write:write_loop_report",
        "lure.analysis.rod.report.model:StabilityReport": "lure.analysis.rod.report.output:write_report",
    },
)
_ROD = ("lure.rod.transfer:RodPlant", "lure.rod.discretisation:UpwindScheme")
extend("resonances", dict.fromkeys(_ROD, "lure.analysis.rod.spectrum:drawn_resonances"))
extend("theory", dict.fromkeys(_ROD, "lure.analysis.rod.theory:RodTheory"))
extend("theory", {"lure.rod.family:RodFamily": "lure.analysis.rod.theory:FamilyTheory"})
