"""The exact motion of the rod beside its approximations: integrators of the scheme, Galerkin, one table."""

from lure.analysis.rod.comparison.compare import compare as compare
from lure.analysis.rod.comparison.integrators import SCHEME_METHODS as SCHEME_METHODS
from lure.analysis.rod.comparison.integrators import SchemeMethod as SchemeMethod
from lure.analysis.rod.comparison.integrators import SchemeRun as SchemeRun
from lure.analysis.rod.comparison.integrators import integrate as integrate
from lure.analysis.rod.comparison.modes import SettlingRow as SettlingRow
from lure.analysis.rod.comparison.result import Comparison as Comparison
from lure.analysis.rod.comparison.result import Order as Order
from lure.analysis.rod.comparison.result import Row as Row
