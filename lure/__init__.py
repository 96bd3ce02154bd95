"""Lur'e systems: linear blocks, nonlinearities known by their sector, and the elastic rod with a compliant obstacle."""

from lure.block import Block as Block
from lure.block import LinearBlock as LinearBlock
from lure.delay import DelayBlock as DelayBlock
from lure.errors import AssumptionError as AssumptionError
from lure.errors import InputError as InputError
from lure.expressions import Expression as Expression
from lure.frequency_data import FrequencyData as FrequencyData
from lure.inputs import as_block as as_block
from lure.law_class import LawClass as LawClass
from lure.laws import Cubic as Cubic
from lure.laws import DeadZone as DeadZone
from lure.laws import ExpressionLaw as ExpressionLaw
from lure.laws import LeakyReLU as LeakyReLU
from lure.laws import PiecewiseLinear as PiecewiseLinear
from lure.laws import Quantiser as Quantiser
from lure.laws import ReLU as ReLU
from lure.laws import Saturation as Saturation
from lure.laws import Tanh as Tanh
from lure.laws import relay_with_slope as relay_with_slope
from lure.loop import Loop as Loop
from lure.motion import Boundary as Boundary
from lure.motion import Motion as Motion
from lure.motion import Numerics as Numerics
from lure.motion import exact_motion as exact_motion
from lure.nonlinearity import Nonlinearity as Nonlinearity
from lure.nonlinearity import NormalCompliance as NormalCompliance
from lure.rational import RationalBlock as RationalBlock
from lure.rod import Rod as Rod
from lure.scenario import Matching as Matching
from lure.scenario import Scenario as Scenario
from lure.scenario import initial_state as initial_state
from lure.scenario import matching as matching
from lure.sector import Sector as Sector
from lure.sector import SlopeBounds as SlopeBounds
from lure.state_space import StateSpaceBlock as StateSpaceBlock
from lure.systems import RodSystem as RodSystem
from lure.systems import builtin_system as builtin_system
from lure.systems import builtin_systems as builtin_systems
from lure.systems_loop import LoopSystem as LoopSystem
from lure.transform import pole_shift as pole_shift
from lure.transform import sector_shift as sector_shift
from lure.upwind import UpwindScheme as UpwindScheme
from lure.upwind import upwind as upwind
from lure.waves import RodBlock as RodBlock

__version__ = "0.1.0"
