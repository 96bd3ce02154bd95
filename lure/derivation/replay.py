"""The derivation from beginning to end, as steps whose residuals must be zero."""

from __future__ import annotations

from lure.derivation.steps_rod import rod_steps
from lure.derivation.steps_scheme import scheme_steps
from lure.derivation.vocabulary import Form, Step, checked_cells, checked_form


def derivation(cells: int = 4, *, form: Form = "corrected") -> tuple[Step, ...]:
    """Replay the paper's derivation, Hamilton's principle to the Popov expression.

    Parameters
    ----------
    cells : int
        Largest number of cells for which the matrices are worked out, from 1 to 12; cost grows like ``N^3``.
    form : {"corrected", "as-printed"}
        ``"as-printed"`` takes the potential energy (1), the weak form (10) and the force in (36) as printed; the steps
        that rest on them then do not hold.  Other misprints are in :func:`lure.derivation.misprints`.

    Returns
    -------
    tuple of Step
        In the order of the paper.  ``step.holds`` for all of them in the corrected form.

    Raises
    ------
    InputError
        ``cells`` is not an integer from 1 to 12, or ``form`` is unknown.

    Notes
    -----
    Exact algebra, no floating point: a zero residual shows the step for the ``N`` named in its title and no other.  For
    every ``N`` at once: multiply row ``i`` by ``y_i`` and telescope (energy), diagonalise the f-circulant matrix (H_N).

    Examples
    --------
    >>> steps = derivation(1)
    >>> steps[9].statement
    'a = (k - Z)/(k + Z), b = 1/(k + Z), d = 1/sqrt(rho E), Z = A sqrt(rho E) (below (33))'
    >>> steps[9].residual
    0
    """
    checked_cells(cells)
    checked_form(form)
    return rod_steps(form) + scheme_steps(cells, form)
