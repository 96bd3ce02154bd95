from lure.analysis.sweeps.reading import read_study as read_study
from lure.analysis.sweeps.run import SweepSummary as SweepSummary
from lure.analysis.sweeps.run import sweep as sweep
from lure.analysis.sweeps.study import Study as Study
