"""The letters of the derivation; the step, whose residual must be zero; the misprint, whose difference must not."""

from __future__ import annotations

import sympy as sp

from lure.errors import InputError
from lure.record import Page, Record, derived, quantity
from lure.rod.discretisation import FORMS as FORMS
from lure.rod.discretisation import Form as Form

MAX_CELLS = 12

t, x = sp.symbols("t x", real=True)
E, rho, area, L, c = sp.symbols("E rho A L c", positive=True)  # modulus [Pa], density, cross-section, length, speed
k, gap = sp.symbols("k l", real=True)  # dashpot [N s/m], initial gap [m]
a, b = sp.symbols("a b", real=True)  # reflection at x = 0 [-], 1/(k + Z) [m/(N s)]
d, s = sp.symbols("d s", positive=True)  # 1/sqrt(rho E) [m/(s Pa)], rate c N/L of the scheme [1/s]
T = sp.Symbol("T", positive=True)  # travel time L/c [s]
laplace = sp.Symbol("s'")  # Laplace variable [1/s]
omega = sp.Symbol("omega", positive=True)  # angular frequency [rad/s]
theta = sp.Symbol("theta", real=True)  # Popov multiplier [s]
g, p = sp.symbols("g p", real=True)  # force at x = 0 [N], contact stress p(z) [Pa]
primitive = sp.Symbol("P(z)", real=True)  # integral of the contact stress
IMPEDANCE = area * sp.sqrt(rho * E)  # Z [N s/m]

_MARK = sp.Symbol("lambda")


class Step(Record):
    """One step of the derivation."""

    title: str = quantity("What is being done")
    statement: str = quantity("The formula claimed, with its equation number in the paper")
    residual: sp.Expr = quantity(
        "Derived minus claimed, simplified.  Several claims in one step are the coefficients of a polynomial in "
        "``lambda``, so that the residual is zero only if every one of them is",
        plainly=str,
    )

    @property
    @derived()
    def holds(self) -> bool:
        """Whether the residual simplified to zero; ``False`` leaves the residual to look at."""
        return bool(self.residual == 0)

    def _page(self) -> Page:
        rows = [("claim", self.statement), ("residual", self.residual)]
        return Page(self.title, rows, verdict="HOLDS" if self.holds else "OPEN")

    def __str__(self) -> str:
        """One line: the claim, and what remains of it."""
        return f"{self.title}: {self.statement} [residual {self.residual}]"


class Misprint(Record):
    """A formula of the paper that does not follow from its own premises."""

    where: str = quantity("Equation numbers of the paper")
    printed: sp.Expr = quantity("As printed", plainly=str)
    corrected: sp.Expr = quantity("The same quantity as the derivation gives it", plainly=str)
    explanation: str = quantity("Which premise decides, and how")

    @property
    @derived(plainly=str)
    def difference(self) -> sp.Expr:
        """``printed - corrected``, simplified; not identically zero."""
        return sp.factor(sp.simplify(self.printed - self.corrected))

    def _page(self) -> Page:
        rows = [(name, getattr(self, name)) for name in ("printed", "corrected", "difference")]
        return Page(f"misprint in {self.where}", rows, notes=(self.explanation,))

    def __str__(self) -> str:
        """One line: where, what is printed, what it should be, why."""
        return f"{self.where}: printed {self.printed}, correct {self.corrected}. {self.explanation}"


def residual(*differences: sp.Expr) -> sp.Expr:
    """Return several differences as one expression, zero exactly when all of them simplify to zero.

    ``*differences``: each one an expression that should vanish identically.

    Returns
    -------
    sympy.Expr
        The differences, simplified, as coefficients of the powers of ``lambda``.
    """
    simplified = (_simplified(sp.sympify(difference)) for difference in differences)
    return sp.Add(*(term * _MARK**power for power, term in enumerate(simplified)))


def _simplified(difference: sp.Expr) -> sp.Expr:
    """Expand first, which settles almost every step; simplify only what is left."""
    expanded = sp.expand(difference.doit())
    return expanded if expanded == 0 else sp.simplify(expanded)


def checked_cells(cells: int) -> int:
    """Return ``cells`` if symbolic matrices of that size are sensible.

    Raises
    ------
    InputError
        ``cells`` is not an integer between 1 and ``MAX_CELLS``.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or not 1 <= cells <= MAX_CELLS:
        raise InputError(
            f"cells is {cells!r}; the symbolic derivation takes an integer from 1 to {MAX_CELLS}, "
            "for more cells use lure.rod.upwind"
        )
    return cells


def checked_form(form: Form) -> Form:
    """Return ``form`` if it is one of ``FORMS``.

    Raises
    ------
    InputError
        ``form`` is neither ``"corrected"`` nor ``"as-printed"``.
    """
    if form not in FORMS:
        raise InputError(f"form is {form!r}; choose 'corrected' or 'as-printed'")
    return form
