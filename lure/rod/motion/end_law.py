"""What holds the end ``x = L``: the contact law cut into segments, on each of which ``z`` can be solved for."""

from __future__ import annotations

import math

from lure.errors import InputError
from lure.nonlinearities import GraphNonlinearity
from lure.record import described, quantity
from lure.rod.parameters import Rod

_STIFFEST = 1e12  # a boundary layer of this many times less than T is narrower than the doubles near T can show


@described(frozen=True, kw_only=True, slots=True)
class Boundary:
    """Boundary conditions beyond those of the paper."""

    clamped: bool = quantity(
        "Whether the end ``x = 0`` is held, ``k = inf`` (then ``a = 1``, ``b = 0``: a wave comes back as minus "
        "itself and the force has no effect). ``k = 0`` and ``k = Z`` are values of the rod's own damping",
        default=False,
    )
    end_damping: float = quantity(
        "``k_L >= 0``, a dashpot at ``x = L``: ``A E u_x(t, L) = -A p(z) - k_L u_t(t, L)`` [N s/m]", default=0.0
    )
    rigid: bool = quantity(
        "Whether the obstacle is rigid, ``eps = 0``: ``z <= 0``, ``p >= 0``, ``z p = 0`` (Signorini)", default=False
    )
    nonlinearity: GraphNonlinearity | None = quantity(
        "A nondecreasing piecewise linear nonlinearity ``p(z)`` [Pa] in place of the rod's own; None for that of "
        "the rod",
        default=None,
    )

    def __post_init__(self) -> None:
        if isinstance(self.end_damping, bool) or not 0.0 <= self.end_damping < math.inf:
            raise InputError(f"Boundary.end_damping is {self.end_damping!r}; give a number from 0 N s/m on")
        if self.rigid and self.nonlinearity is not None:
            raise InputError(
                "Boundary has both rigid and nonlinearity; a rigid obstacle has no nonlinearity, give one of the two"
            )
        if self.nonlinearity is not None and not isinstance(self.nonlinearity, GraphNonlinearity):
            raise InputError(
                f"Boundary.nonlinearity is a {type(self.nonlinearity).__name__}; give a piecewise linear nonlinearity "
                "of lure.nonlinearities"
            )


@described(frozen=True, kw_only=True, slots=True)
class Segment:
    """A stretch ``low <= z <= high`` of the law, ``p = stress + slope (z - origin)`` or a power of ``z - origin``."""

    low: float = quantity("Lower end; infinite at the outer one", "m")
    high: float = quantity("Upper end; infinite at the outer one", "m")
    origin: float = quantity("Coordinate from which ``zeta = z - origin`` is counted", "m")
    push: float = quantity("``d p`` at the origin [m/s]")
    rate: float = quantity("``d p'`` [1/s]; ``inf`` for a rigid obstacle")
    power: float = quantity("``m``, with ``d p = rate zeta^m``; 1 for a straight segment", default=1.0)
    touching: bool = quantity("Whether the stress is not zero throughout", default=True)


@described(frozen=True, kw_only=True, slots=True)
class EndLaw:
    """The segments in ascending order, and what was put in place of a nonlinearity too stiff for doubles."""

    segments: tuple[Segment, ...] = quantity(
        "From ``z = -inf`` to ``inf``; the last ends at its start if the obstacle is rigid"
    )
    note: str = quantity("What was changed, or nothing", default="")
    error: float = quantity("Largest ``z`` [m] per unit of wave [m/s] that the change leaves out [s]", default=0.0)


def end_law(rod: Rod, boundary: Boundary) -> EndLaw:
    """The segments of the law of the rod, or of the one that takes its place.

    Raises
    ------
    InputError
        A slope of the nonlinearity is negative, or too steep for double precision.
    """
    mobility = rod.mobility / (1.0 + boundary.end_damping / rod.impedance)
    if boundary.nonlinearity is not None:
        return EndLaw(segments=_graph(boundary.nonlinearity, mobility, rod.travel_time))
    free = Segment(low=-math.inf, high=0.0, origin=0.0, push=0.0, rate=0.0, touching=False)
    if boundary.rigid:
        return EndLaw(segments=(free, _rigid()))
    rate = mobility * rod.nonlinearity.stiffness
    if rod.exponent != 1.0:
        contact = Segment(low=0.0, high=math.inf, origin=0.0, push=0.0, rate=rate, power=rod.exponent)
        return EndLaw(segments=(free, contact))
    if rate * rod.travel_time > _STIFFEST:
        note = f"compliance {rod.compliance:.3g} m/Pa is below what doubles resolve: the obstacle counts as rigid"
        return EndLaw(segments=(free, _rigid()), note=note, error=1.0 / rate)
    return EndLaw(segments=(free, Segment(low=0.0, high=math.inf, origin=0.0, push=0.0, rate=rate)))


def _rigid() -> Segment:
    return Segment(low=0.0, high=math.inf, origin=0.0, push=0.0, rate=math.inf)


def _graph(nonlinearity: GraphNonlinearity, mobility: float, transit: float) -> tuple[Segment, ...]:
    slopes, knots = nonlinearity.graph.slopes, nonlinearity.graph.knots
    if min(slopes) < 0 or mobility * float(max(slopes)) * transit > _STIFFEST:
        raise InputError(
            f"Boundary.nonlinearity has slopes from {float(min(slopes)):g} to {float(max(slopes)):g} Pa/m; give slopes "
            f"from 0 to {_STIFFEST / mobility / transit:.3g} Pa/m"
        )
    found = []
    for i, slope in enumerate(slopes):
        low = float(knots[i - 1]) if i > 0 else -math.inf
        high = float(knots[i]) if i < len(knots) else math.inf
        ends = range(max(i - 1, 0), min(i + 1, len(knots)))
        anchor = min(ends, key=lambda j: abs(knots[j]))  # the end near 0, where doubles are dense
        value = nonlinearity.graph.values[anchor]
        found.append(
            Segment(
                low=low,
                high=high,
                origin=float(knots[anchor]),
                push=mobility * float(value),
                rate=mobility * float(slope),
                touching=bool(slope != 0 or value != 0),
            )
        )
    return tuple(found)
