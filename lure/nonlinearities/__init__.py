"""The library of nonlinearities: exact parameters, values, slope, primitive, and what is known of each nonlinearity."""

from lure.nonlinearities.base import LibraryNonlinearity as LibraryNonlinearity
from lure.nonlinearities.formula import ExpressionNonlinearity as ExpressionNonlinearity
from lure.nonlinearities.named import Cubic as Cubic
from lure.nonlinearities.named import Quantiser as Quantiser
from lure.nonlinearities.named import Tanh as Tanh
from lure.nonlinearities.piecewise_linear import DeadZone as DeadZone
from lure.nonlinearities.piecewise_linear import GraphNonlinearity as GraphNonlinearity
from lure.nonlinearities.piecewise_linear import LeakyReLU as LeakyReLU
from lure.nonlinearities.piecewise_linear import PiecewiseLinear as PiecewiseLinear
from lure.nonlinearities.piecewise_linear import ReLU as ReLU
from lure.nonlinearities.piecewise_linear import Saturation as Saturation
from lure.nonlinearities.piecewise_linear import relay_with_slope as relay_with_slope
from lure.nonlinearities.properties import Properties as Properties
from lure.nonlinearities.properties import Property as Property
from lure.nonlinearities.properties import Provenance as Provenance
from lure.nonlinearities.properties import check_declared as check_declared
from lure.nonlinearities.properties import nonlinearity_class as nonlinearity_class
from lure.nonlinearities.properties import properties as properties
from lure.nonlinearities.reading import LAW_KINDS as LAW_KINDS
from lure.nonlinearities.reading import nonlinearity_from_table as nonlinearity_from_table
from lure.nonlinearities.shifted import MovedNonlinearity as MovedNonlinearity
from lure.nonlinearities.shifted import ShiftedNonlinearity as ShiftedNonlinearity
from lure.nonlinearities.shifted import shifted_class as shifted_class
from lure.nonlinearities.shifted import shifted_nonlinearity as shifted_nonlinearity
