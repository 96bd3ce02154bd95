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
from lure.loop import Loop as Loop
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
from lure.upwind import UpwindScheme as UpwindScheme
from lure.upwind import upwind as upwind
from lure.waves import RodBlock as RodBlock

__version__ = "0.1.0"
