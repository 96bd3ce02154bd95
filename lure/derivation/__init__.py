"""The paper's derivation, replayed in sympy: from Hamilton's principle to the scheme, its spectrum and its misprints.

``derivation()`` returns the steps in order, each with a residual that is zero; ``misprints()`` returns the formulas of
the paper that do not follow, each with a difference that is not.  The other functions return the pieces.
Importing this package imports sympy; ``import lure`` does not import this package.
"""

from lure.derivation.energy import Balance as Balance
from lure.derivation.energy import conserved_mean as conserved_mean
from lure.derivation.energy import energy_identity as energy_identity
from lure.derivation.energy import popov_lyapunov as popov_lyapunov
from lure.derivation.energy import rod_energy as rod_energy
from lure.derivation.errata import misprints as misprints
from lure.derivation.popov import ClosedForm as ClosedForm
from lure.derivation.popov import least_multiplier as least_multiplier
from lure.derivation.popov import low_frequency_limit as low_frequency_limit
from lure.derivation.popov import popov_expression as popov_expression
from lure.derivation.popov import scheme_delay as scheme_delay
from lure.derivation.replay import derivation as derivation
from lure.derivation.scheme import Scheme as Scheme
from lure.derivation.scheme import printed_input as printed_input
from lure.derivation.scheme import ring as ring
from lure.derivation.scheme import stated_matrices as stated_matrices
from lure.derivation.scheme import upwind_matrices as upwind_matrices
from lure.derivation.transfer import characteristic_polynomial as characteristic_polynomial
from lure.derivation.transfer import delay_limit as delay_limit
from lure.derivation.transfer import numerical_damping as numerical_damping
from lure.derivation.transfer import residue_at_zero as residue_at_zero
from lure.derivation.transfer import stated_characteristic_polynomial as stated_characteristic_polynomial
from lure.derivation.transfer import stated_transfer_function as stated_transfer_function
from lure.derivation.transfer import transfer_function as transfer_function
from lure.derivation.transfer import value_at_zero as value_at_zero
from lure.derivation.variation import Hamilton as Hamilton
from lure.derivation.variation import WeakForm as WeakForm
from lure.derivation.variation import hamilton as hamilton
from lure.derivation.variation import weak_form as weak_form
from lure.derivation.vocabulary import Misprint as Misprint
from lure.derivation.vocabulary import Step as Step
from lure.derivation.waves import BoundaryRelations as BoundaryRelations
from lure.derivation.waves import DelayEquation as DelayEquation
from lure.derivation.waves import Riemann as Riemann
from lure.derivation.waves import boundary_relations as boundary_relations
from lure.derivation.waves import delay_equation as delay_equation
from lure.derivation.waves import exact_transfer_function as exact_transfer_function
from lure.derivation.waves import rest_position as rest_position
from lure.derivation.waves import riemann as riemann
