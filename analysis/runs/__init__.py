"""One motion by any of the ways to compute it, as samples, as an xarray Dataset, as a netCDF file."""

from analysis.runs.dataset import motion_dataset as motion_dataset
from analysis.runs.dataset import run_dataset as run_dataset
from analysis.runs.exact import sampled_motion as sampled_motion
from analysis.runs.request import Performed as Performed
from analysis.runs.request import Request as Request
from analysis.runs.request import perform as perform
from analysis.runs.sampled import Along as Along
from analysis.runs.sampled import SampledRun as SampledRun
from analysis.runs.writing import write_dataset as write_dataset
