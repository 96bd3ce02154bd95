"""Two-sided answers: how far a class of laws is proved stable, and where a member of it destabilises the loop."""

from analysis.answers.largest import Largest as Largest
from analysis.answers.questions import max_sector as max_sector
from analysis.answers.questions import max_slope as max_slope
from analysis.answers.table import LoopAnalysis as LoopAnalysis
from analysis.answers.table import analyse as analyse
