"""Loads and initial data of the rod, and whether they fit together at the ends."""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property

from lure.arrays import NDArray, np
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Record, described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.parameters import Rod

_MARGIN = 1e-12  # of the end of a span


def _zero(*variables: str) -> Expression:
    return Expression.parse(0, variables=variables)


class Scenario(Record):
    """What acts on the rod and how it starts.

    Examples
    --------
    >>> pushed = Scenario.parse(force="2*sin(4*t)", velocity=1)
    >>> pushed.free, float(pushed.force(t=0.0))
    (False, 0.0)
    """

    force: Expression = quantity(
        "``g(t)`` on the end ``x = 0``, positive along ``x`` [N]", default_factory=lambda: _zero("t")
    )
    body_force: Expression = quantity("``f(t, x)`` along the rod [N/m]", default_factory=lambda: _zero("t", "x"))
    displacement: Expression = quantity(
        "``u0(x)`` [m], a displacement (not a position: the paper's (50) adds the coordinate)",
        default_factory=lambda: _zero("x"),
    )
    velocity: Expression = quantity("``u1(x)`` [m/s]", default_factory=lambda: _zero("x"))
    _kind = "scenario"

    @classmethod
    def parse(
        cls,
        *,
        force: str | float | Fraction = 0,
        body_force: str | float | Fraction = 0,
        displacement: str | float | Fraction = 0,
        velocity: str | float | Fraction = 0,
    ) -> Scenario:
        """Build a scenario from numbers or text.

        Parameters
        ----------
        force, body_force, displacement, velocity : str or number
            Formulas in the variables of the attributes; errors name them ``force.g``, ``force.f``, ``initial.u0`` and
            ``initial.u1``, the keys of a TOML file.

        Raises
        ------
        InputError
            A formula does not parse: one sentence with its key, the column and what is allowed.
        """
        return cls(
            force=Expression.parse(force, variables=("t",), field="force.g"),
            body_force=Expression.parse(body_force, variables=("t", "x"), field="force.f"),
            displacement=Expression.parse(displacement, variables=("x",), field="initial.u0"),
            velocity=Expression.parse(velocity, variables=("x",), field="initial.u1"),
        )

    @property
    def free(self) -> bool:
        """Whether no load acts: ``g = 0`` and ``f = 0``."""
        return self.force.is_zero and self.body_force.is_zero

    def breaks(self, until: float) -> list[float]:
        """Instants inside ``(0, until)`` at which a load may change its formula, as far as they are known [s]."""
        loads = (load for load in (self.force, self.body_force) if not load.is_constant)
        found = {float(point) for load in loads for point in load.breakpoints("t", 0, until) or ()}
        return sorted(point for point in found if 0.0 < point < until)

    def loads(
        self, t: float, x: NDArray[np.float64], span: tuple[float, float]
    ) -> tuple[float, NDArray[np.float64] | None]:
        """``g`` [N] and ``f`` [N/m] at ``t``, read strictly inside ``span``, where formulas do not change.

        Parameters
        ----------
        t : float
            The instant [s].
        x : ndarray
            (n,) places [m] of the body force, which is None where there is none.
        span : (float, float)
            Two of :meth:`breaks`, or ends of the motion [s].

        Raises
        ------
        InputError
            A load is not finite there.
        """
        margin = _MARGIN * span[1]
        t = min(max(t, span[0] + margin if span[0] else 0.0), span[1] - margin)
        force = 0.0 if self.force.is_zero else float(self.force(t=t))
        if not np.isfinite(force):
            raise InputError(f"force.g is {force} at t = {t:g} s; give a formula that is finite over the run")
        if self.body_force.is_zero:
            return force, None
        body = self.body_force(t=t, x=x)
        if not np.isfinite(body).all():
            raise InputError(
                f"force.f is not finite at t = {t:g} s somewhere on the rod; give a formula that is finite over the run"
            )
        return force, body

    @cached_property
    def slope(self) -> Expression:
        """``u0'(x)`` [-]."""
        return self.displacement.derivative("x")

    def waves(self, rod: Rod, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Initial Riemann invariants ``r1 = u1 - c u0'`` and ``r2 = u1 + c u0'`` at ``x`` [m/s].

        Raises
        ------
        InputError
            ``u1`` or the slope of ``u0`` is not a finite number at one of the points.
        """
        speed = rod.wave_speed * finite(self.slope(x=x), "the slope of initial.u0", x)
        velocity = finite(self.velocity(x=x), "initial.u1", x)
        return velocity - speed, velocity + speed

    def contact_coordinate(self, rod: Rod) -> float:
        """Initial ``z = u0(L) - gap`` [m].

        Raises
        ------
        InputError
            ``u0(L)`` is not a finite number.
        """
        end = np.array([rod.length])
        return float(finite(self.displacement(x=end), "initial.u0", end)[0]) - rod.gap


@described(frozen=True, kw_only=True, slots=True)
class Matching:
    """How far initial data are from the boundary conditions at ``t = 0``."""

    dashpot: float = quantity("``A E u0'(0) - k u1(0) + g(0)``, a force out of balance", "N")
    contact: float = quantity("``E u0'(L) + p(u0(L) - gap)``, a stress out of balance", "Pa")
    matched: bool = quantity("Both vanish within ``1e-9`` of the largest force (stress) that enters them")

    def __str__(self) -> str:
        if self.matched:
            return "Initial and boundary data are matched at both ends."
        return (
            f"Initial and boundary data are not matched (off by {self.dashpot:.4g} N at x = 0 and {self.contact:.4g} "
            "Pa at x = L): a jump enters the rod at t = 0 and runs along the characteristics; in the rod it stays a "
            "jump, the scheme smears it, and pointwise accuracy near it is lost."
        )


def matching(rod: Rod, scenario: Scenario) -> Matching:
    """Compare the initial data with the boundary conditions (8) at ``t = 0``.

    The paper stresses below (37) that unmatched data let the initial discontinuities propagate.

    Parameters
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Its loads and initial data; only their values and slopes at the two ends count.

    Raises
    ------
    InputError
        One of these is not a finite number.
    """
    ends = np.array([0.0, rod.length])
    strain = finite(scenario.slope(x=ends), "the slope of initial.u0", ends)
    velocity = finite(scenario.velocity(x=ends), "initial.u1", ends)
    force = float(finite(scenario.force(t=np.zeros(1)), "force.g", np.zeros(1), "t", "s")[0])
    left = (rod.area * rod.youngs_modulus * strain[0], -rod.damping * velocity[0], force)
    right = (rod.youngs_modulus * strain[1], float(rod.nonlinearity(scenario.contact_coordinate(rod))))
    gaps = [float(sum(left)), float(sum(right))]
    matched = all(abs(gap) <= 1e-9 * max(map(abs, terms)) for gap, terms in zip(gaps, (left, right), strict=True))
    return Matching(dashpot=gaps[0], contact=gaps[1], matched=matched)


def initial_state(scheme: UpwindScheme, scenario: Scenario) -> NDArray[np.float64]:
    """Initial state of the scheme (2N+1,), in its ordering: (37) with the misprints corrected.

    ``xi1^i = r1(x_i)`` for ``i = 1..N``, ``xi2^i = r2(x_i)`` for ``i = 0..N-1``, ``z = u0(L) - gap``.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    scenario : Scenario
        Its initial data.

    Raises
    ------
    InputError
        ``u1``, the slope of ``u0`` or ``u0(L)`` is not a finite number.
    """
    N, rod = scheme.cells, scheme.rod
    x = rod.length * np.arange(N + 1) / N
    forward, backward = scenario.waves(rod, x)
    contact = np.array([scenario.contact_coordinate(rod)])
    return np.concatenate((forward[1:], backward[N - 1 :: -1], contact))[scheme.permutation]


def finite(
    values: NDArray[np.float64], what: str, points: NDArray[np.float64], variable: str = "x", unit: str = "m"
) -> NDArray[np.float64]:
    """The values, or a refusal that says what is not finite and where.

    Raises
    ------
    InputError
        One of them is not finite.
    """
    if not np.isfinite(values).all():
        wrong = ~np.isfinite(values)
        where = f"{variable} = {points[wrong][0]:g} {unit}"
        raise InputError(f"{what} is {values[wrong][0]} at {where}; give a formula that is finite there")
    return values
