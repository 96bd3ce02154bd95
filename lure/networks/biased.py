r"""Where a loop rests that a network with biases closes, and what its neurons do around there.

.. math:: 0 = E x - B \varphi(\sigma) + a, \quad \sigma = C x - D \varphi(\sigma) + \beta,

``E = A``, in discrete time ``A - 1``.  Counted from a solution, ``x - x^*``, ``\sigma - \sigma^*``, the loop has the
plant it had and the functions ``\varphi_i(\sigma^*_i + \cdot) - \varphi_i(\sigma^*_i)``, without biases.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from lure.arrays import Reals, np
from lure.errors import InputError
from lure.expressions.regularity import smooth
from lure.expressions.rigorous import ball, enclosure
from lure.expressions.tree import derivative
from lure.networks.network import Network
from lure.nonlinearities.base import LibraryNonlinearity, Nonlinearity
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.named import Cubic, Tanh
from lure.nonlinearities.piecewise_linear import Graph, GraphNonlinearity
from lure.nonlinearities.shifted import MovedNonlinearity, moved_graph
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from flint import arb, arb_mat, fmpq

_TURNS, _STARTS, _SEED, _FAR = 60, 20, 20261123, 1e9
_BITS, _GRID, _RADIUS, _REFINED = 256, 110, 100, 8  # of the arithmetic, a rational equilibrium, the box around it
_NONE = (
    "no equilibrium of the loop with the biases was found, and there may be none; give a network that holds one, or "
    "train it without biases"
)


class Equilibrium(NamedTuple):
    """An equilibrium: exactly, or in a box in which there is exactly one.

    Attributes
    ----------
    x : tuple of Fraction
        (n,) the state.
    sigma : tuple of Fraction
        (m,) what each function sees there.
    plant : MultivariablePlant
        The linear part of the loop around it.
    nonlinearities : tuple of Nonlinearity
        The functions around it, one for each channel.
    within : Fraction
        How far each entry of ``x`` and ``sigma`` is at most from that of the equilibrium; 0 where they are exact.
    """

    x: tuple[Fraction, ...]
    sigma: tuple[Fraction, ...]
    plant: MultivariablePlant
    nonlinearities: tuple[Nonlinearity, ...]
    within: Fraction = Fraction(0)


def equilibrium(
    network: Network, plant: MultivariablePlant | RationalPlant, nonlinearities: Sequence[Nonlinearity] = ()
) -> Equilibrium:
    r"""An equilibrium of the loop of a network with biases, and the loop around it.

    With piecewise linear neurons it is exact.  With ``tanh`` it is no rational number: that there is one, and only one,
    within :math:`2^{-100}` of what is returned is proved by Krawczyk's operator in ball arithmetic [1]_, and what is
    said of the functions around it, :class:`~lure.nonlinearities.MovedNonlinearity`, is true wherever it lies in there.

    Parameters
    ----------
    network : Network
        Its neurons.
    plant : MultivariablePlant or RationalPlant
        As for :meth:`Network.closed`.
    nonlinearities : sequence of Nonlinearity
        Those of the plant's own channels, in order.

    Returns
    -------
    Equilibrium
        One of them: there may be others.  With no bias it is 0.

    Raises
    ------
    InputError
        None is found; a nonlinearity of the plant sees another value than 0 there and is neither piecewise linear, nor
        ``tanh``, a cubic or a smooth formula; or an equilibrium that is not exact lies at a kink.

    References
    ----------
    .. [1] R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken, Computing 4 (1969)
       187-201.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lure import as_plant
    >>> network = Network.given([[[1]], [[-1]]], [[Fraction(1, 2)], [1]], activation="relu")
    >>> plant = as_plant(([[-1]], [[1]], [[1]], 0))
    >>> found = equilibrium(network, plant)    # x' = -x + u, u = 1 - max(x + 1/2, 0)
    >>> print(found.x[0], found.sigma[0], found.nonlinearities[0])
    1/4 3/4 piecewise linear nonlinearity through (-0.75, -0.75), (0, 0), slope 0 to the left and 1 to the right
    >>> smooth = Network.given([[[1]], [[-1]]], [[Fraction(1, 2)], [1]], activation="tanh")
    >>> found = equilibrium(smooth, plant)    # x' = -x + 1 - tanh(x + 1/2)
    >>> print(f"{float(found.x[0]):.6f}", found.nonlinearities[0], found.within < 1e-30)
    0.323195 tanh(sigma) around 0.823195 True
    """
    closed, (a, beta) = network.closed(plant), network.offsets(plant)
    phi = [*nonlinearities, *network.nonlinearities()]
    if len(phi) != closed.inputs:
        raise InputError(
            f"{len(nonlinearities)} nonlinearities of the plant are given, and it has "
            f"{closed.inputs - len(network.nonlinearities())} channels of its own; give one for each"
        )
    graphs = [one.graph if isinstance(one, GraphNonlinearity) else None for one in phi]
    exact = None if network.activation == "tanh" and any((*a, *beta)) else _solved(closed, graphs, a, beta)
    if exact is not None and not any(at and own is None for own, at in zip(graphs, exact[1], strict=True)):
        x, sigma = exact
        around = [moved_graph(g, s) if g and s else one for g, s, one in zip(graphs, sigma, phi, strict=True)]
        return Equilibrium(x, sigma, closed, tuple(around))
    if all(graphs):
        raise InputError(_NONE)
    for number, one in enumerate(phi, 1):
        if not isinstance(one, GraphNonlinearity | Tanh | Cubic) and not _formula(one):
            raise InputError(
                f"the nonlinearity of channel {number}, {one!s:.40}, may see another value than 0 at the equilibrium, "
                "and only piecewise linear ones, tanh, cubics and smooth formulas are moved; give the plant around its "
                "equilibrium"
            )
    x, sigma, within = _enclosed(closed, phi, a, beta)
    return Equilibrium(
        x,
        sigma,
        closed,
        tuple(MovedNonlinearity(one, at, within) for one, at in zip(phi, sigma, strict=True)),
        within,
    )


def _formula(phi: object) -> bool:
    """Whether it is a smooth formula."""
    return isinstance(phi, ExpressionNonlinearity) and smooth(phi.expression.tree)


# Equilibria in a box.


def _enclosed(
    H: MultivariablePlant, phi: Sequence[Nonlinearity], a: Sequence[Fraction], beta: Sequence[Fraction]
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...], Fraction]:
    """The state, ``sigma`` and the radius of a box around them in which there is exactly one equilibrium."""
    from flint import ctx

    n, found = H.order, _guess(H, phi, a, beta)
    if found is None:
        raise InputError(_NONE)
    z, radius = [Fraction(float(v)) for v in found], Fraction(1, 2**_RADIUS)
    with ctx.workprec(_BITS):
        for _ in range(_REFINED):
            moved = _step(H, phi, (a, beta), z, None)
            if moved is None:
                break
            z, before = [Fraction(round(v * 2**_GRID), 2**_GRID) for v in moved], z
            if max(abs(u - v) for u, v in zip(z, before, strict=True)) < radius / 32:
                break
        if _step(H, phi, (a, beta), z, radius) is None:
            raise InputError(
                "an equilibrium of the loop with the biases was found near x = "
                f"({', '.join(f'{float(v):.6g}' for v in z[:n])}), and could not be proved to exist; it may lie at a "
                "kink, or others close to it"
            )
    return tuple(z[:n]), tuple(z[n:]), radius


def _step(
    H: MultivariablePlant,
    phi: Sequence[Nonlinearity],
    given: tuple[Sequence[Fraction], Sequence[Fraction]],
    z: Sequence[Fraction],
    radius: Fraction | None,
) -> list[Fraction] | None:
    """Newton's step from ``z``; with a radius ``z`` itself if Krawczyk's operator maps the box around it into itself.

    Of ``f`` with slopes in the matrix ``J`` over the box ``Z``, and any invertible ``Y``, the image is ``z - Y f(z) +
    (1 - Y J)(Z - z)``: strictly inside, it shows that ``f`` has exactly one zero in ``Z``.
    """
    from flint import arb, arb_mat

    n, size, box = H.order, len(z), Fraction(0) if radius is None else radius
    points = list(map(ball, z))
    wide = [p + arb(0, float(box)) if box else p for p in points]
    try:
        f, slopes = _residual(H, phi, given, points), _slopes(H, phi, wide[n:])
        middle = arb_mat([[v.mid() for v in row] for row in slopes.tolist()])
        Y = middle.inv()
    except (ZeroDivisionError, InputError):
        return None
    moved = Y * f
    if radius is None:
        new = [p - moved[i, 0] for i, p in enumerate(points)]
        finite = all(v.is_finite() for v in new)
        return [_rational(v.mid()) for v in new] if finite else None
    Y = arb_mat([[v.mid() for v in row] for row in Y.tolist()])
    one = arb_mat([[int(i == j) for j in range(size)] for i in range(size)])
    image = (one - Y * slopes) * arb_mat([[arb(0, float(box))]] * size) - Y * f
    inside = all(bool(abs(image[i, 0]) < ball(radius)) for i in range(size))
    return list(z) if inside and bool(Y.det() != 0) else None


def _rational(value: arb) -> Fraction:
    top, exponent = value.man_exp()
    return Fraction(int(top)) * Fraction(2) ** int(exponent)


def _residual(
    H: MultivariablePlant,
    phi: Sequence[Nonlinearity],
    given: tuple[Sequence[Fraction], Sequence[Fraction]],
    z: Sequence[arb],
) -> arb_mat:
    """``E x - B phi(sigma) + a`` and ``C x - D phi(sigma) + beta - sigma``, as a column."""
    from flint import arb_mat, fmpq_mat

    n = H.order
    x, sigma = arb_mat([[v] for v in z[:n]]), arb_mat([[v] for v in z[n:]])
    values = arb_mat([[_values(one, v)[0]] for one, v in zip(phi, z[n:], strict=True)])
    A, B, C, D = (arb_mat(fmpq_mat(_exact(side))) for side in (H.A, H.B, H.C, H.D))
    first, last = (arb_mat(fmpq_mat(_exact([[v] for v in part]))) for part in given)
    rest = A * x - B * values + first - (x if H.dt is not None else 0 * x)
    return arb_mat([*rest.tolist(), *(C * x - D * values + last - sigma).tolist()])


def _slopes(H: MultivariablePlant, phi: Sequence[Nonlinearity], sigma: Sequence[arb]) -> arb_mat:
    """The matrix of derivatives of the residual over balls of ``sigma``."""
    from flint import arb_mat

    k = [_values(one, v)[1] for one, v in zip(phi, sigma, strict=True)]
    still = int(H.dt is not None)
    rows = [
        [*(ball(v - still * (i == j)) for j, v in enumerate(A)), *(-ball(b) * s for b, s in zip(B, k, strict=True))]
        for i, (A, B) in enumerate(zip(H.A, H.B, strict=True))
    ]
    rows += [
        [*map(ball, C), *(-ball(d) * s - int(i == j) for j, (d, s) in enumerate(zip(D, k, strict=True)))]
        for i, (C, D) in enumerate(zip(H.C, H.D, strict=True))
    ]
    return arb_mat(rows)


def _values(phi: Nonlinearity, sigma: arb) -> tuple[arb, arb]:
    """Value and slope of a nonlinearity, enclosed over a ball.

    Raises
    ------
    InputError
        A kink lies in the ball.
    """
    if isinstance(phi, Tanh):
        t = (sigma / ball(phi.scale)).tanh()
        return ball(phi.gain) * t, ball(phi.gain / phi.scale) * (1 - t * t)
    if isinstance(phi, Cubic):
        square = sigma * sigma
        linear, cubic = ball(phi.linear), ball(phi.cubic)
        return sigma * (linear + cubic * square), linear + 3 * cubic * square
    if isinstance(phi, GraphNonlinearity):
        graph = phi.graph
        if any(not (sigma > ball(x) or sigma < ball(x)) for x in graph.kinks):
            raise InputError("a kink lies at the equilibrium")
        place = bisect_left(graph.knots, _rational(sigma.mid()))
        knot = min(place, len(graph.knots) - 1)
        slope = ball(graph.slopes[place])
        return ball(graph.values[knot]) + slope * (sigma - ball(graph.knots[knot])), slope
    assert isinstance(phi, ExpressionNonlinearity), "no other is taken"
    tree, point = phi.expression.tree, dict.fromkeys(phi.expression.variables, sigma)
    return enclosure(tree, point), enclosure(derivative(tree, phi.expression.variables[0]), point)


def _guess(
    H: MultivariablePlant, phi: Sequence[Nonlinearity], a: Sequence[Fraction], beta: Sequence[Fraction]
) -> Reals | None:
    """About an equilibrium ``(x, sigma)``: Newton's method in floating point, from several starts."""
    rng, n = np.random.default_rng(_SEED), H.order
    A, B, C, D = H.doubles()
    E = A - np.eye(n) * (H.dt is not None)
    first, last = np.array([float(v) for v in a]), np.array([float(v) for v in beta])

    def residual(z: Reals) -> Reals:
        """What has to vanish."""
        values = np.array([float(one(s)) for one, s in zip(phi, z[n:], strict=True)])
        return np.concatenate([E @ z[:n] - B @ values + first, C @ z[:n] - D @ values + last - z[n:]])

    def slopes(z: Reals) -> Reals:
        """Its derivative."""
        k = np.array([float(_sloped(one).slope(s)) for one, s in zip(phi, z[n:], strict=True)])
        return np.block([[E, -B * k], [C, -D * k - np.eye(len(phi))]])

    for start in range(_STARTS):
        z = np.concatenate([rng.normal(size=n) * (start and 4.0 ** rng.integers(-2, 3)), np.zeros(len(phi))])
        for _ in range(len(phi)):  # sigma, channel after channel
            z[n:] += residual(z)[n:]
        for _ in range(_TURNS):
            now = residual(z)
            size = float(np.linalg.norm(now))
            if not max(size, float(np.abs(z).max())) < _FAR:
                break
            if size <= 1e-11 * (1 + float(np.linalg.norm(z))):
                return z
            try:
                step = np.linalg.solve(slopes(z), now)
            except np.linalg.LinAlgError:
                break
            shares = [share for share in 0.5 ** np.arange(8) if np.linalg.norm(residual(z - share * step)) < size]
            z = z - (shares[0] if shares else 1.0) * step
    return None


def _sloped(phi: Nonlinearity) -> LibraryNonlinearity:
    """A nonlinearity of the library, which has a slope."""
    return phi  # type: ignore[return-value]  # piecewise linear, tanh, cubic or a formula


def _exact(rows: Sequence[Sequence[Fraction]]) -> list[list[fmpq]]:
    from flint import fmpq

    return [[fmpq(Fraction(v).numerator, Fraction(v).denominator) for v in row] for row in rows]


# Exact equilibria.


def _solved(
    H: MultivariablePlant, graphs: Sequence[Graph | None], a: Sequence[Fraction], beta: Sequence[Fraction]
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]] | None:
    """The state and ``sigma``: Newton's method over the pieces, exact, from several of them; None if none is found."""
    rng, n = np.random.default_rng(_SEED), H.order
    _, _, C, D = H.doubles()
    for start in range(_STARTS):
        x, sigma = rng.normal(size=n) * (start and 4.0 ** rng.integers(-2, 3)), list[float]()
        for i, own in enumerate(graphs):
            mu = [0.0 if g is None else -float(g.exact(Fraction(s))) for g, s in zip(graphs, sigma, strict=False)]
            sigma.append(float(C[i] @ x + D[i, :i] @ np.array(mu) + float(beta[i])))
            assert own is None or own.knots
        pieces = _pieces(graphs, [Fraction(v) for v in sigma])
        seen = set[tuple[int, ...]]()
        while tuple(pieces) not in seen and len(seen) < _TURNS:
            seen.add(tuple(pieces))
            found = _linear(H, graphs, pieces, a, beta)
            if found is None:
                break
            after = _pieces(graphs, found[n:])
            if after == pieces:
                return tuple(found[:n]), tuple(found[n:])
            pieces = after
    return None


def _pieces(graphs: Sequence[Graph | None], sigma: Sequence[Fraction]) -> list[int]:
    """On which piece each ``sigma_i`` is."""
    return [0 if g is None else bisect_left(g.knots, v) for g, v in zip(graphs, sigma, strict=True)]


def _linear(
    H: MultivariablePlant,
    graphs: Sequence[Graph | None],
    pieces: Sequence[int],
    a: Sequence[Fraction],
    beta: Sequence[Fraction],
) -> list[Fraction] | None:
    """The solution on these pieces, ``phi = k sigma + q``; None where there is not exactly one."""
    from flint import fmpq_mat

    lines = [(Fraction(0), Fraction(0))] * len(graphs)
    for i, (g, p) in enumerate(zip(graphs, pieces, strict=True)):
        if g is not None:
            at = min(p, len(g.knots) - 1)
            lines[i] = g.slopes[p], g.values[at] - g.slopes[p] * g.knots[at]
    still = 0 if H.dt is None else 1
    rows, right = list[list[Fraction]](), list[Fraction]()
    for i, (A, B) in enumerate(zip(H.A, H.B, strict=True)):
        rows.append(
            [*(v - still * (i == j) for j, v in enumerate(A)), *(-b * k for b, (k, _) in zip(B, lines, strict=True))]
        )
        right.append(sum((b * q for b, (_, q) in zip(B, lines, strict=True)), Fraction(0)) - a[i])
    for i, (C, D) in enumerate(zip(H.C, H.D, strict=True)):
        rows.append([*(-v for v in C), *((i == j) + d * k for j, (d, (k, _)) in enumerate(zip(D, lines, strict=True)))])
        right.append(beta[i] - sum((d * q for d, (_, q) in zip(D, lines, strict=True)), Fraction(0)))
    try:
        solved = fmpq_mat(_exact(rows)).solve(fmpq_mat(_exact([[v] for v in right])))
    except ZeroDivisionError:
        return None
    return [Fraction(int(row[0].p), int(row[0].q)) for row in solved.tolist()]
