from lure.analysis.rod.confirmation.confirm import confirmation as confirmation
from lure.analysis.rod.confirmation.functionals import Track as Track
from lure.analysis.rod.confirmation.functionals import lyapunov_theta as lyapunov_theta
from lure.analysis.rod.confirmation.functionals import rod_energy as rod_energy
from lure.analysis.rod.confirmation.functionals import rod_lyapunov as rod_lyapunov
from lure.analysis.rod.confirmation.functionals import rod_zeta as rod_zeta
from lure.analysis.rod.confirmation.result import Confirmation as Confirmation
from lure.analysis.rod.confirmation.result import Side as Side
