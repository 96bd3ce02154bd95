"""Confirmation: the exact motions of the rod and of its scheme, held side by side against what was shown of each."""

from analysis.confirmation.confirm import confirmation as confirmation
from analysis.confirmation.functionals import lyapunov_theta as lyapunov_theta
from analysis.confirmation.functionals import rod_energy as rod_energy
from analysis.confirmation.functionals import rod_lyapunov as rod_lyapunov
from analysis.confirmation.functionals import rod_zeta as rod_zeta
from analysis.confirmation.result import Confirmation as Confirmation
from analysis.confirmation.result import Side as Side
from analysis.confirmation.track import Track as Track
