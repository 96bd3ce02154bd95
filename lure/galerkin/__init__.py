"""The weak form of the rod in finite-dimensional spaces, section 3 of the paper: matrices, motion, energy, errors."""

from lure.galerkin.error import Convergence as Convergence
from lure.galerkin.error import KnownState as KnownState
from lure.galerkin.error import StateError as StateError
from lure.galerkin.error import convergence as convergence
from lure.galerkin.error import formula_state as formula_state
from lure.galerkin.error import free_state as free_state
from lure.galerkin.error import state_error as state_error
from lure.galerkin.model import GalerkinModel as GalerkinModel
from lure.galerkin.model import galerkin as galerkin
from lure.galerkin.nonuniform import NonuniformRod as NonuniformRod
from lure.galerkin.run import GalerkinRun as GalerkinRun
from lure.galerkin.run import Touch as Touch
from lure.galerkin.spaces import Space as Space
