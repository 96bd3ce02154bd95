r"""Where a loop rests that a network with biases closes, and what its neurons do around there.

.. math:: 0 = E x - B \varphi(\sigma) + a, \quad \sigma = C x - D \varphi(\sigma) + \beta,

``E = A``, in discrete time ``A - 1``.  Counted from a solution, ``x - x^*``, ``\sigma - \sigma^*``, the loop has the
plant it had and the functions ``\varphi_i(\sigma^*_i + \cdot) - \varphi_i(\sigma^*_i)``, without biases.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from lure.arrays import np
from lure.errors import InputError
from lure.networks.network import Network
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.piecewise_linear import Graph, GraphNonlinearity, PiecewiseLinear
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant

_TURNS, _STARTS, _SEED = 60, 20, 20261123


class Equilibrium(NamedTuple):
    """An equilibrium, exactly.

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
    """

    x: tuple[Fraction, ...]
    sigma: tuple[Fraction, ...]
    plant: MultivariablePlant
    nonlinearities: tuple[Nonlinearity, ...]


def equilibrium(
    network: Network, plant: MultivariablePlant | RationalPlant, nonlinearities: Sequence[Nonlinearity] = ()
) -> Equilibrium:
    """An equilibrium of the loop of a network with biases, and the loop around it.

    Parameters
    ----------
    network : Network
        Its neurons piecewise linear.
    plant : MultivariablePlant or RationalPlant
        As for :meth:`Network.closed`.
    nonlinearities : sequence of Nonlinearity
        Those of the plant's own channels, in order.  One that is not piecewise linear must see 0 at the equilibrium.

    Returns
    -------
    Equilibrium
        One of them: there may be others.  With no bias it is 0.

    Raises
    ------
    InputError
        Neurons are ``tanh``, whose equilibrium is no rational number; a neuron is straight around its value; none is
        found; or a nonlinearity of the plant sees another value than 0 and is not piecewise linear.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lure import as_plant
    >>> network = Network.given([[[1]], [[-1]]], [[Fraction(1, 2)], [1]], activation="relu")
    >>> plant = as_plant(([[-1]], [[1]], [[1]], 0))
    >>> found = equilibrium(network, plant)    # x' = -x + u, u = 1 - max(x + 1/2, 0)
    >>> print(found.x[0], found.sigma[0], found.nonlinearities[0])
    1/4 3/4 piecewise linear nonlinearity through (-0.75, -0.75), (0, 0), slope 0 to the left and 1 to the right
    """
    closed, (a, beta) = network.closed(plant), network.offsets(plant)
    phi = [*nonlinearities, *network.nonlinearities()]
    if len(phi) != closed.inputs:
        raise InputError(
            f"{len(nonlinearities)} nonlinearities of the plant are given, and it has "
            f"{closed.inputs - len(network.nonlinearities())} channels of its own; give one for each"
        )
    if network.activation == "tanh" and any(map(any, network.biases)):
        raise InputError(
            "the biases of a network of tanh neurons have no rational equilibrium; take relu, leaky relu or "
            "saturation, or train it without biases"
        )
    graphs = [one.graph if isinstance(one, GraphNonlinearity) else None for one in phi]
    x, sigma = _solved(closed, graphs, a, beta)
    found = tuple(_around(one, at, i) for i, (one, at) in enumerate(zip(phi, sigma, strict=True), 1))
    return Equilibrium(x, sigma, closed, found)


def _around(phi: Nonlinearity, at: Fraction, channel: int) -> Nonlinearity:
    """``phi(at + sigma) - phi(at)``."""
    if at == 0:
        return phi
    if not isinstance(phi, GraphNonlinearity):
        raise InputError(
            f"the nonlinearity of channel {channel}, {phi!s:.40}, sees {float(at):.6g} at the equilibrium, and only "
            "piecewise linear ones are moved there; give the plant around its equilibrium"
        )
    graph, value = phi.graph, phi.graph.exact(at)
    kinks = [k for k, (x, s, t) in enumerate(zip(graph.knots, graph.slopes, graph.slopes[1:], strict=False)) if s != t]
    points = [(graph.knots[k] - at, graph.values[k] - value) for k in kinks]
    return PiecewiseLinear(
        sorted({*points, (Fraction(0), Fraction(0))}), left_slope=graph.slopes[0], right_slope=graph.slopes[-1]
    )


def _solved(
    H: MultivariablePlant, graphs: Sequence[Graph | None], a: Sequence[Fraction], beta: Sequence[Fraction]
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """The state and ``sigma``: Newton's method over the pieces, exact, from several of them."""
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
    raise InputError(
        "no equilibrium of the loop with the biases was found, and there may be none; give a network that holds one, "
        "or train it without biases"
    )


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
    from flint import fmpq, fmpq_mat

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
    whole = fmpq_mat([[fmpq(Fraction(v).numerator, Fraction(v).denominator) for v in row] for row in rows])
    try:
        solved = whole.solve(fmpq_mat([[fmpq(v.numerator, v.denominator)] for v in right]))
    except ZeroDivisionError:
        return None
    return [Fraction(int(row[0].p), int(row[0].q)) for row in solved.tolist()]
