from lure.analysis.nonlinearity.bounds import law_bounds as law_bounds
from lure.analysis.nonlinearity.result import Extreme as Extreme
from lure.analysis.nonlinearity.result import LawBounds as LawBounds
from lure.analysis.nonlinearity.violations import Violation as Violation
from lure.analysis.nonlinearity.violations import violation as violation
