from lure.analysis.rod.runs.drawing import write_dataset as write_dataset
from lure.analysis.rod.runs.methods import sampled_motion as sampled_motion
from lure.analysis.rod.runs.request import Performed as Performed
from lure.analysis.rod.runs.request import Request as Request
from lure.analysis.rod.runs.request import perform as perform
from lure.analysis.rod.runs.sampled import Along as Along
from lure.analysis.rod.runs.sampled import SampledRun as SampledRun
