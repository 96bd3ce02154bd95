"""Long runs of the rod itself: what it does under a periodic load, how that changes, where it comes to rest."""

from lure.analysis.rod.response.period import load_period as load_period
from lure.analysis.rod.response.period import proved_period as proved_period
from lure.analysis.rod.response.recording import Plan as Plan
from lure.analysis.rod.response.recording import Settling as Settling
from lure.analysis.rod.response.resting import Basin as Basin
from lure.analysis.rod.response.resting import Rest as Rest
from lure.analysis.rod.response.resting import basin as basin
from lure.analysis.rod.response.resting import resting_place as resting_place
from lure.analysis.rod.response.run import Response as Response
from lure.analysis.rod.response.run import response as response
from lure.analysis.rod.response.seen import Balance as Balance
from lure.analysis.rod.response.seen import Impulses as Impulses
from lure.analysis.rod.response.seen import Regime as Regime
from lure.analysis.rod.response.seen import Separation as Separation
from lure.analysis.rod.response.seen import Spectrum as Spectrum
from lure.analysis.rod.response.seen import Transients as Transients
from lure.analysis.rod.response.sweeping import Bifurcation as Bifurcation
from lure.analysis.rod.response.sweeping import Point as Point
from lure.analysis.rod.response.sweeping import Sweep as Sweep
from lure.analysis.rod.response.sweeping import bifurcation as bifurcation
