"""Results on disk: directories that appear whole or not at all, and what they may replace."""

from analysis.output.placing import replaced as replaced
from analysis.output.target import checked_target as checked_target
from analysis.output.textfile import write_new as write_new
