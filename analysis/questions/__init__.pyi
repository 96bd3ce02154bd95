from lure.analysis.questions.answers import answer as answer
from lure.analysis.questions.answers import max_sector as max_sector
from lure.analysis.questions.answers import max_slope as max_slope
from lure.analysis.questions.largest import StabilityBound as StabilityBound
from lure.analysis.questions.problem import Problem as Problem
from lure.analysis.questions.table import LoopAnalysis as LoopAnalysis
from lure.analysis.questions.table import analyse as analyse
