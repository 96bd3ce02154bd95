"""Long runs of the rod itself: what it does under a periodic load, how that changes, where it comes to rest."""

from analysis.response.basin import Basin as Basin
from analysis.response.basin import basin as basin
from analysis.response.bifurcation import bifurcation as bifurcation
from analysis.response.model import Response as Response
from analysis.response.period import load_period as load_period
from analysis.response.period import proved_period as proved_period
from analysis.response.plan import Plan as Plan
from analysis.response.plan import Settling as Settling
from analysis.response.regime import Regime as Regime
from analysis.response.regime import Transients as Transients
from analysis.response.resting import Rest as Rest
from analysis.response.resting import resting_place as resting_place
from analysis.response.run import response as response
from analysis.response.separation import Separation as Separation
from analysis.response.statistics import Balance as Balance
from analysis.response.statistics import Impulses as Impulses
from analysis.response.statistics import Spectrum as Spectrum
from analysis.response.sweeping import Bifurcation as Bifurcation
from analysis.response.sweeping import Point as Point
from analysis.response.sweeping import Sweep as Sweep
