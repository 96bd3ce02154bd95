"""Long runs of the rod itself: what it does under a periodic load, how that changes, where it comes to rest."""

from lure.analysis.rod.response.basin import Basin as Basin
from lure.analysis.rod.response.basin import basin as basin
from lure.analysis.rod.response.bifurcation import bifurcation as bifurcation
from lure.analysis.rod.response.model import Response as Response
from lure.analysis.rod.response.period import load_period as load_period
from lure.analysis.rod.response.period import proved_period as proved_period
from lure.analysis.rod.response.plan import Plan as Plan
from lure.analysis.rod.response.plan import Settling as Settling
from lure.analysis.rod.response.regime import Regime as Regime
from lure.analysis.rod.response.regime import Transients as Transients
from lure.analysis.rod.response.resting import Rest as Rest
from lure.analysis.rod.response.resting import resting_place as resting_place
from lure.analysis.rod.response.run import response as response
from lure.analysis.rod.response.separation import Separation as Separation
from lure.analysis.rod.response.statistics import Balance as Balance
from lure.analysis.rod.response.statistics import Impulses as Impulses
from lure.analysis.rod.response.statistics import Spectrum as Spectrum
from lure.analysis.rod.response.sweeping import Bifurcation as Bifurcation
from lure.analysis.rod.response.sweeping import Point as Point
from lure.analysis.rod.response.sweeping import Sweep as Sweep
