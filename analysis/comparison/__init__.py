"""The exact motion of the rod beside its approximations: integrators of the scheme, Galerkin, one table."""

from analysis.comparison.compare import compare as compare
from analysis.comparison.integrators import SCHEME_METHODS as SCHEME_METHODS
from analysis.comparison.integrators import SchemeMethod as SchemeMethod
from analysis.comparison.integrators import integrate as integrate
from analysis.comparison.result import Comparison as Comparison
from analysis.comparison.result import Order as Order
from analysis.comparison.result import Row as Row
from analysis.comparison.scheme_run import SchemeRun as SchemeRun
from analysis.comparison.settling_claim import SettlingRow as SettlingRow
