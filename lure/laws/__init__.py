"""The library of nonlinearities: exact parameters, values, slope, primitive, and what is known of each law."""

from lure.laws.checking import check_declared as check_declared
from lure.laws.formula import ExpressionLaw as ExpressionLaw
from lure.laws.law import Law as Law
from lure.laws.piecewise import DeadZone as DeadZone
from lure.laws.piecewise import GraphLaw as GraphLaw
from lure.laws.piecewise import LeakyReLU as LeakyReLU
from lure.laws.piecewise import ReLU as ReLU
from lure.laws.piecewise import Saturation as Saturation
from lure.laws.piecewise import relay_with_slope as relay_with_slope
from lure.laws.points import PiecewiseLinear as PiecewiseLinear
from lure.laws.properties import Properties as Properties
from lure.laws.properties import Property as Property
from lure.laws.properties import Standing as Standing
from lure.laws.properties import law_class as law_class
from lure.laws.properties import properties as properties
from lure.laws.quantiser import Quantiser as Quantiser
from lure.laws.shifted import ShiftedLaw as ShiftedLaw
from lure.laws.shifted import shifted_class as shifted_class
from lure.laws.shifted import shifted_law as shifted_law
from lure.laws.smooth import Cubic as Cubic
from lure.laws.smooth import Tanh as Tanh
from lure.laws.table import LAW_KINDS as LAW_KINDS
from lure.laws.table import law_from_table as law_from_table
