from lure.analysis.nonlinearity.bounds import nonlinearity_bounds as nonlinearity_bounds
from lure.analysis.nonlinearity.result import Extreme as Extreme
from lure.analysis.nonlinearity.result import NonlinearityBounds as NonlinearityBounds
from lure.analysis.nonlinearity.violations import Violation as Violation
from lure.analysis.nonlinearity.violations import violation as violation
