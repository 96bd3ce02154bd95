"""The scheme in closed form, its matrices and its Popov expression; and the energies of the rod and of the scheme."""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from lure.record import described, quantity
from lure.rod.derivation.rod import f, hamilton, strain_left, strain_right, u, velocity_left
from lure.rod.derivation.vocabulary import (
    E,
    Form,
    T,
    a,
    area,
    b,
    checked_cells,
    checked_form,
    d,
    g,
    k,
    laplace,
    omega,
    p,
    primitive,
    rho,
    s,
    t,
    theta,
    x,
)

# The Popov expression of the rod and of the scheme in closed form, and where its numbers come from.

# The upwind method of lines: (35) put into (34), and the matrices of (38) and (42).

mu, z = sp.symbols("mu z", real=True)


@described(frozen=True, kw_only=True, slots=True)
class Scheme:
    """``y' = A y + b1 mu + b2 g``, ``sigma = c^T y``, ``mu = -p(sigma)``, in the ordering (39)."""

    A: sp.ImmutableMatrix = quantity("(2N+1, 2N+1) [1/s]")
    b1: sp.ImmutableMatrix = quantity("(2N+1, 1) column of ``mu``")
    b2: sp.ImmutableMatrix = quantity("(2N+1, 1) column of ``g``")
    c: sp.ImmutableMatrix = quantity("(2N+1, 1) column of the output")
    state: tuple[sp.Symbol, ...] = quantity("``xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0, z``")

    @property
    def cells(self) -> int:
        """Number of cells, ``N``."""
        return (len(self.state) - 1) // 2

    def rates(self, nonlinearity: sp.Expr = -p) -> sp.ImmutableMatrix:
        """``y'`` with ``mu = nonlinearity``, a (2N+1, 1) column."""
        return sp.ImmutableMatrix(self.A * sp.Matrix(self.state) + self.b1 * nonlinearity + self.b2 * g)


def upwind_matrices(cells: int, *, form: Form = "corrected") -> Scheme:
    r"""Substitute the boundary relations (35) in the upwind equations (34) and read off the matrices.

    (34): ``xi1^i' = s (xi1^{i-1} - xi1^i)`` for ``i = 1..N``, ``xi2^i' = s (xi2^{i+1} - xi2^i)`` for ``i = 0..N-1``.
    (35): ``xi1^0 = -a xi2^0 + 2 b g``, ``xi2^N = xi1^N - 2 d p``, ``z' = (xi1^N + xi2^N)/2``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    form : {"corrected", "as-printed"}
        ``"as-printed"`` takes the force in the first row of (36) as printed, ``2 b g`` instead of ``2 s b g``.

    Raises
    ------
    InputError
        ``cells`` is not an integer from 1 to 12, or ``form`` is unknown.

    Examples
    --------
    >>> print(upwind_matrices(1).A)
    Matrix([[-s, -a*s, 0], [s, -s, 0], [1, 0, 0]])
    """
    last = checked_cells(cells)
    xi1 = sp.symbols(f"xi1^0:{last + 1}", real=True)
    xi2 = sp.symbols(f"xi2^0:{last + 1}", real=True)
    ends = {xi1[0]: -a * xi2[0] + 2 * b * g, xi2[last]: xi1[last] + 2 * d * mu}
    forward = [(xi1[i], s * (xi1[i - 1] - xi1[i])) for i in range(1, last + 1)]
    backward = [(xi2[i], s * (xi2[i + 1] - xi2[i])) for i in reversed(range(last))]
    rows = [*forward, *backward, (z, (xi1[last] + xi2[last]) / 2)]
    state = tuple(component for component, _ in rows)
    right = sp.Matrix([sp.expand(rate.subs(ends)) for _, rate in rows])
    force = right.diff(g) / (s if checked_form(form) == "as-printed" else 1)
    return Scheme(
        A=sp.ImmutableMatrix(right.jacobian(state)),
        b1=sp.ImmutableMatrix(right.diff(mu)),
        b2=sp.ImmutableMatrix(force),
        c=sp.ImmutableMatrix([component.diff(z) for component in state]),
        state=state,
    )


def stated_matrices(cells: int) -> Scheme:
    """The matrices written down row by row, not derived: ``y1' = -s y1 - s a y_{2N} + 2 s b g`` and so on.

    Row ``i`` is ``s y_{i-1} - s y_i``, row ``N+1`` has ``2 s d mu`` besides, and ``z' = y_N + d mu``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    last = 2 * checked_cells(cells)
    A, b1, b2, output = (sp.zeros(last + 1, width) for width in (last + 1, 1, 1, 1))
    for i in range(last):
        A[i, i], A[i, (i - 1) % last] = -s, s if i else -s * a
    A[last, cells - 1], b1[cells], b1[last], b2[0], output[last] = 1, 2 * s * d, d, 2 * s * b, 1
    columns = {"A": A, "b1": b1, "b2": b2, "c": output}
    return Scheme(
        **{name: sp.ImmutableMatrix(value) for name, value in columns.items()}, state=upwind_matrices(cells).state
    )


def as_scheme(system: int | Scheme) -> Scheme:
    """Return the scheme itself, or the corrected scheme with that many cells."""
    if isinstance(system, Scheme):
        return system
    return upwind_matrices(system)


def ring(cells: int) -> tuple[sp.ImmutableMatrix, sp.ImmutableMatrix]:
    """The CNN matrix of (42), (2N, 2N), and the cyclic shift whose top right corner is ``f`` instead of 1.

    A matrix is f-circulant exactly when it is a polynomial in that shift ``K_f``; it is circulant when ``f = 1``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    order = 2 * checked_cells(cells)
    shift = sp.zeros(order)
    for i in range(1, order):
        shift[i, i - 1] = 1
    shift[0, order - 1] += sp.Symbol("f", real=True)
    return sp.ImmutableMatrix(upwind_matrices(cells).A[:order, :order]), sp.ImmutableMatrix(shift)


def printed_input(cells: int) -> sp.ImmutableMatrix:
    """``b1`` as printed under (38), ``[..., -2 s d, ..., -d]``: with ``mu = -p`` it makes contact pull.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    return sp.ImmutableMatrix(-upwind_matrices(cells).b1)


# What the matrices give: H_N, the characteristic polynomial, the zero eigenvalue, and the limit of many cells.


@cache
def transfer_function(system: int | Scheme) -> sp.Expr:
    """``H_N(s') = c^T (s' I - A)^-1 b1``, from ``mu`` to ``sigma`` [m/Pa], by exact elimination over Q(a, d, s, s').

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Raises
    ------
    InputError
        The number of cells is not an integer from 1 to 12.

    Examples
    --------
    >>> sp.cancel(transfer_function(1) - stated_transfer_function(1))
    0
    """
    scheme = as_scheme(system)
    size = len(scheme.state)
    extended = (laplace * sp.eye(size) - scheme.A).row_join(scheme.b1)
    field = DomainMatrix.from_Matrix(sp.Matrix(extended)).to_field()
    solution = field.extract(range(size), range(size)).lu_solve(field.extract(range(size), [size])).to_Matrix()
    return sp.cancel((scheme.c.T * solution)[0])


def stated_transfer_function(cells: int) -> sp.Expr:
    """``(d/s') (1 - a q^{2N})/(1 + a q^{2N})`` with ``q = 1/(1 + s'/s)``: claimed for every ``N`` [m/Pa].

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    delayed = a / (1 + laplace / s) ** (2 * checked_cells(cells))
    return d / laplace * (1 - delayed) / (1 + delayed)


@cache
def characteristic_polynomial(system: int | Scheme) -> sp.Expr:
    """``det(s' I - A)``, computed from the matrix; ``s' ((s' + s)^{2N} + a s^{2N})`` is what it should be.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Examples
    --------
    >>> print(characteristic_polynomial(1).coeff(laplace, 2))
    2*s
    """
    scheme = as_scheme(system)
    return sp.expand((laplace * sp.eye(len(scheme.state)) - scheme.A).det(method="berkowitz"))


def stated_characteristic_polynomial(cells: int) -> sp.Expr:
    """``s' ((s' + s)^{2N} + a s^{2N})``, not derived.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    power = 2 * checked_cells(cells)
    return laplace * ((laplace + s) ** power + a * s**power)


@cache
def residue_at_zero(system: int | Scheme) -> sp.Expr:
    """``rho_0``, the residue of ``H_N`` at zero, ``d (1 - a)/(1 + a)`` [m/(s Pa)] for every ``N``.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    return sp.factor(sp.cancel(laplace * transfer_function(system)).subs(laplace, 0))


def value_at_zero(system: int | Scheme) -> sp.Expr:
    """``H_h(0)``, the limit of ``H_N - rho_0/s'`` at zero, ``4 a d T/(1 + a)^2`` with ``s = N/T`` [m/Pa].

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    regular = sp.cancel(transfer_function(scheme) - residue_at_zero(scheme) / laplace)
    return sp.factor(regular.subs(laplace, 0).subs(s, scheme.cells / T))


def delay_limit() -> sp.Expr:
    """Limit of ``q^{2N}`` as ``N`` grows, ``s'`` fixed and ``s = N/T``: ``exp(-2 s' T)``.

    Examples
    --------
    >>> print(delay_limit())
    exp(-2*T*s')
    """
    cells = sp.Symbol("N", positive=True)
    return sp.limit((1 + laplace * T / cells) ** (-2 * cells), cells, sp.oo)


def numerical_damping() -> sp.Expr:
    """Leading term of what upwinding adds to the exponent of the delay: ``ln q^{2N} + 2 s' T = (s' T)^2/N + O(1/N^2)``.

    On the imaginary axis it is ``-(omega T)^2/N``: damping, though the rod has none there.
    """
    step = sp.Symbol("1/N", positive=True)
    return sp.series(-2 * sp.log(1 + laplace * T * step) / step, step, 0, 2).removeO() + 2 * laplace * T


modulus = sp.Symbol("r", positive=True)  # |q^{2N}|; 1 for the rod itself
phase = sp.Symbol("psi", real=True)  # minus the argument of q^{2N}; 2 omega T for the rod itself


@described(frozen=True, kw_only=True, slots=True)
class ClosedForm:
    """A frequency function taken two ways."""

    computed: sp.Expr = quantity("By the definition")
    closed: sp.Expr = quantity("In the closed form claimed")
    angle: sp.Symbol = quantity("The only angle in both")

    @property
    def residual(self) -> sp.Expr:
        """Numerator of ``computed - closed``, reduced by ``sin^2 + cos^2 = 1``: a normal form, zero if they agree."""
        cosine, sine = sp.symbols("C S")
        on_circle = {sp.tan(self.angle): sine / cosine, sp.cos(self.angle): cosine, sp.sin(self.angle): sine}
        numerator, _ = sp.fraction(sp.together((self.computed - self.closed).subs(on_circle)))
        return sp.factor(sp.reduced(sp.expand(numerator), [sine**2 + cosine**2 - 1], sine, cosine)[1])


def popov_expression() -> ClosedForm:
    r"""Popov's expression with ``q^{2N} = r exp(-i psi)``, for the scheme and (``r = 1``) the rod [m/Pa].

    .. math::

        \mathrm{Re}\,[(1 + i\omega\theta) H(i\omega)]
        &= d\,\frac{2 a r \sin(\psi)/\omega + \theta (1 - a^2 r^2)}{1 + a^2 r^2 + 2 a r \cos\psi}, \\
        H &= \frac{d}{i\omega}\,\frac{1 - a r e^{-i\psi}}{1 + a r e^{-i\psi}}.

    Examples
    --------
    >>> print(popov_expression().residual)
    0
    """
    delayed = a * modulus * (sp.cos(phase) - sp.I * sp.sin(phase))
    response = d / (sp.I * omega) * (1 - delayed) / (1 + delayed)
    value = (1 + sp.I * omega * theta) * response
    closed_numerator = 2 * a * modulus * sp.sin(phase) / omega + theta * (1 - a**2 * modulus**2)
    return ClosedForm(
        computed=(value + sp.conjugate(value)) / 2,
        closed=d * closed_numerator / (1 + a**2 * modulus**2 + 2 * a * modulus * sp.cos(phase)),
        angle=phase,
    )


def scheme_delay() -> ClosedForm:
    """``q = 1/(1 + s'/s)`` at ``s' = i omega``, ``omega = s tan(chi)``: it is ``cos(chi) exp(-i chi)``.

    So ``q^{2N}`` has ``r = (1 + omega^2/s^2)^{-N}`` and ``psi = 2 N atan(omega/s)``, for every ``N``.
    """
    chi = sp.Symbol("chi", real=True)
    return ClosedForm(
        computed=1 / (1 + sp.I * sp.tan(chi)),
        closed=sp.cos(chi) * (sp.cos(chi) - sp.I * sp.sin(chi)),
        angle=chi,
    )


def low_frequency_limit() -> sp.Expr:
    """Limit of the rod's Popov expression at frequency zero, ``4 a d T/(1 + a)^2 + theta d (1 - a)/(1 + a)`` [m/Pa].

    For ``0 < k < Z`` (``-1 < a < 0``) it is negative unless ``theta >= -4 a T/(1 - a^2)``: with ``theta = 0``, the
    circle criterion, only small sectors are left.
    """
    closed = popov_expression().closed.subs({modulus: 1, phase: 2 * omega * T})
    return sp.factor(sp.limit(closed, omega, 0))


def least_multiplier() -> sp.Expr:
    """The multiplier that makes the low-frequency limit zero, ``theta = -4 a T/(1 - a^2)`` [s].

    It is positive when ``0 < k < Z``.  For an infinite sector no smaller ``theta`` can work; that it works at every
    frequency is not shown here.
    """
    return sp.factor(sp.solve(low_frequency_limit(), theta)[0])


@described(frozen=True, kw_only=True, slots=True)
class Balance:
    """``d/dt function = rate`` claimed along every solution, for any locally Lipschitz ``p`` with ``P' = p``."""

    function: sp.Expr = quantity("The function of the state; ``P(z)`` is the primitive of the nonlinearity")
    derivative: sp.Expr = quantity("Its derivative, by the chain rule along the matrices")
    rate: sp.Expr = quantity("What the derivative is claimed to be")

    @property
    def residual(self) -> sp.Expr:
        """``derivative - rate``, expanded or simplified; zero if the claim is true."""
        difference = sp.expand(self.derivative - self.rate)
        return difference if difference == 0 else sp.cancel(difference)


def energy_identity(system: int | Scheme) -> Balance:
    r"""Energy balance of the scheme, exact in time and for every ``N``.

    .. math::

        \frac{d}{dt}\Bigl[\frac{1}{2s}\sum_i y_i^2 + 2 d P(z)\Bigr]
        = -\tfrac12 \sum_{i=1}^{2N} (\mathrm{prev}_i - y_i)^2
        + \tfrac12 \bigl[(2 b g - a y_{2N})^2 - y_{2N}^2\bigr],

    with ``prev_1 = -a y_{2N} + 2 b g``, ``prev_{N+1} = y_N - 2 d p``, ``prev_i = y_{i-1}`` otherwise.  For ``g = 0``
    and ``|a| <= 1`` it never grows, whatever the nonlinearity; that it bounds the waves needs ``P`` bounded below
    besides. The energy in joules is ``Z/2`` times it.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Examples
    --------
    >>> print(energy_identity(2).residual)
    0
    """
    scheme = as_scheme(system)
    cells = scheme.state[:-1]
    function = sum(y**2 for y in cells) / (2 * s) + 2 * d * primitive
    jumps = sum((before - y) ** 2 for before, y in zip(_previous(scheme), cells, strict=True))
    rate = -jumps / 2 + ((2 * b * g - a * cells[-1]) ** 2 - cells[-1] ** 2) / 2
    return Balance(function=function, derivative=_along(function, scheme), rate=rate)


def conserved_mean(system: int | Scheme) -> Balance:
    r"""The deflated coordinate ``zeta``, which only the nonlinearity and the force move.

    ``zeta = z + (sum_{i<=N} y_i - a sum_{i>N} y_i)/(s (1 + a))`` and ``zeta' = -rho_0 p + g/k``, where
    ``rho_0 = d (1 - a)/(1 + a)`` and ``1/k = 2 b/(1 + a)``.  Its gradient is the left null vector of ``A``.
    There is no such coordinate for ``a = -1``.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    forward, backward = scheme.state[: scheme.cells], scheme.state[scheme.cells : -1]
    function = z + (sum(forward) - a * sum(backward)) / (s * (1 + a))
    return Balance(function=function, derivative=_along(function, scheme), rate=-_residue() * p + 2 * b / (1 + a) * g)


def popov_lyapunov(system: int | Scheme) -> Balance:
    r"""Lyapunov function of Popov's type along the free scheme (``g = 0``).

    .. math::

        V &= \frac{\theta}{2 s d} \sum_i y_i^2 + 2\theta P(z) + \frac{\zeta^2}{\rho_0}, \qquad
        V' = -\frac{\theta}{d} D - 2 \zeta p, \\
        D &= \tfrac12 \sum_i (\mathrm{prev}_i - y_i)^2 + \tfrac12 (1 - a^2) y_{2N}^2.

    The identity alone does not say that ``V`` falls: ``zeta p`` has no sign of its own; that is what Popov's inequality
    is for.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    energy, mean = energy_identity(scheme), conserved_mean(scheme)
    function = theta / d * energy.function + mean.function**2 / _residue()
    dissipation = -energy.rate.subs(g, 0)  # D: the rate of the energy identity with its sign turned
    return Balance(
        function=function,
        derivative=_along(function, scheme).subs(g, 0),
        rate=-theta / d * dissipation - 2 * mean.function * p,
    )


def rod_energy() -> Balance:
    """Energy of the rod itself: power through the ends, ``E' = -k u_t(t,0)^2 + g u_t(t,0) + int f u_t dx``.

    ``function`` is the density ``(rho A u_t^2 + A E u_x^2)/2`` [J/m]; ``derivative`` is the power that flows in through
    the ends plus that of the contact, ``A p z'``, with the boundary conditions put in; ``rate`` is the claim without
    ``f`` [W].  That energy flows as used here is ``local_energy_balance``.
    """
    motion = hamilton()
    tip = sp.Symbol("u_t(t,L)", real=True)
    end_left, end_right = sp.solve(motion.left, strain_left)[0], sp.solve(motion.right, strain_right)[0]
    power = area * E * (end_right * tip - end_left * velocity_left)
    return Balance(
        function=(rho * area * u.diff(t) ** 2 + area * E * u.diff(x) ** 2) / 2,
        derivative=sp.expand(power + area * p * tip),
        rate=-k * velocity_left**2 + g * velocity_left,
    )


def local_energy_balance() -> sp.Expr:
    """``e_t - (A E u_x u_t)_x - f u_t - u_t (rho A u_tt - A E u_xx - f)``, zero identically [W/m]."""
    flux = area * E * u.diff(x) * u.diff(t)
    return sp.expand(rod_energy().function.diff(t) - flux.diff(x) - f * u.diff(t) - u.diff(t) * hamilton().equation)


def _previous(scheme: Scheme) -> list[sp.Expr]:
    cells = scheme.state[:-1]
    previous = [-a * cells[-1] + 2 * b * g, *cells[:-1]]
    previous[scheme.cells] -= 2 * d * p
    return previous


def _along(function: sp.Expr, scheme: Scheme) -> sp.Expr:
    rates = scheme.rates()
    chain = sum(function.diff(y) * rate for y, rate in zip(scheme.state, rates, strict=True))
    return chain + function.diff(primitive) * p * rates[-1]


def _residue() -> sp.Expr:
    return d * (1 - a) / (1 + a)
