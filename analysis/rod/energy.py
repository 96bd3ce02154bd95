"""What the upwind scheme conserves and loses: its energy, its deflated coordinate, its Popov-Lyapunov function."""

from __future__ import annotations

import math

from lure.arrays import ArrayLike, Reals, np
from lure.errors import AssumptionError, Reason
from lure.rod.discretisation import UpwindScheme


def split_state(scheme: UpwindScheme, y: ArrayLike) -> tuple[Reals, Reals]:
    """Waves and contact coordinate of states in the ordering of the scheme.

    ``scheme``: the scheme the states belong to; ``y``: (..., 2N+1) states.

    Returns
    -------
    waves : ndarray
        (..., 2N) in the order (39): ``xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0`` [m/s].
    gap : ndarray
        (...) ``z`` [m].
    """
    states = np.asarray(y, dtype=float)
    if scheme.ordering != "eq39":
        states = states[..., np.argsort(scheme.permutation)]
    return states[..., :-1], states[..., -1]


def discrete_energy(scheme: UpwindScheme, y: ArrayLike) -> Reals:
    r"""Energy of the scheme, waves and contact.

    .. math:: E = \tfrac14 A \rho h \sum_{i=1}^{2N} y_i^2 + A P(z), \qquad h = L/N, \quad P' = p,

    a Riemann sum of the rod's energy, since ``r1^2 + r2^2 = 2 (v^2 + c^2 u_x^2)``.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    y : array_like
        (..., 2N+1) states in its ordering.

    Returns
    -------
    ndarray
        (...) [J].
    """
    rod = scheme.rod
    waves, gap = split_state(scheme, y)
    per_cell = 0.25 * rod.area * rod.density * rod.length / scheme.cells
    return np.asarray(per_cell * np.square(waves).sum(axis=-1) + rod.area * rod.nonlinearity.primitive(gap))


def energy_balance(
    scheme: UpwindScheme, y: ArrayLike, force: ArrayLike = 0.0, body_force: ArrayLike | None = None
) -> tuple[Reals, Reals]:
    r"""Power lost and power supplied: ``E' = supply - dissipation`` along every motion of the scheme.

    Multiply row ``i`` by ``y_i`` and telescope around the ring.  With ``prev_1 = -a y_{2N} + 2 b g``,
    ``prev_{N+1} = y_N - 2 d p(z)`` and ``prev_i = y_{i-1}`` else,

    .. math::

        \text{dissipation} &= \tfrac{Z}{2}\Big[\tfrac12 \sum_i (\mathrm{prev}_i - y_i)^2
                              + \tfrac{1 - a^2}{2}\, y_{2N}^2\Big], \\
        \text{supply}      &= \tfrac{Z}{2}\Big[2 b^2 g^2 - 2 a b\, g\, y_{2N}
                              + \tfrac{1}{s} \sum_i \tfrac{f_i}{\rho A}\, y_i\Big].

    The nonlinearity enters the first line only, through ``prev_{N+1}``: contact itself neither takes nor gives.  For
    ``k >= 0`` the dissipation is nonnegative, whatever the nonlinearity and however large ``N``; for ``k < 0`` it need
    not be.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme; in the form ``"as-printed"`` a force ``g`` counts as ``g/s``.
    y : array_like
        (..., 2N+1) states in its ordering.
    force : array_like
        (...) ``g`` at the same instants [N].
    body_force : array_like, optional
        (..., 2N) ``f`` at the grid points of the waves, in the order (39) [N/m].

    Returns
    -------
    dissipation, supply : ndarray
        (...) [W].
    """
    rod, N, s = scheme.rod, scheme.cells, scheme.rate
    Z, b, a = rod.impedance, rod.input_gain, rod.reflection
    waves, gap = split_state(scheme, y)
    sent = np.asarray(force, dtype=float) * (float(scheme.b2.max()) / s)  # 2 b g
    end = waves[..., -1]
    jumps = np.empty_like(waves)
    jumps[..., 1:] = waves[..., :-1] - waves[..., 1:]
    jumps[..., 0] = sent - a * end - waves[..., 0]
    jumps[..., N] -= 2.0 * rod.mobility * rod.nonlinearity(gap)
    lost = 0.5 * np.square(jumps).sum(axis=-1) + 2.0 * (rod.damping * b) * (Z * b) * end**2
    given = 0.5 * sent**2 - a * sent * end
    if body_force is not None:
        given = given + (np.asarray(body_force) * waves).sum(axis=-1) / (s * rod.density * rod.area)
    return np.asarray(0.5 * Z * lost), np.asarray(0.5 * Z * given)


def zeta_weights(scheme: UpwindScheme) -> Reals:
    r"""Weights of the deflated coordinate, the left null vector of ``A`` that is 1 at ``z``.

    ``1/(s(1+a))`` on the forward waves, ``-a/(s(1+a))`` on the backward ones, with ``1 + a = 2k/(k+Z)``.

    Returns
    -------
    ndarray
        (2N+1,) in the ordering of the scheme [s for the waves, 1 for z].

    Raises
    ------
    AssumptionError
        ``k = 0``: the zero eigenvalue is double and cannot be split off so.
    """
    rod, N = scheme.rod, scheme.cells
    if rod.damping == 0:
        raise AssumptionError(
            "the deflated coordinate needs k != 0; the damping is 0 N s/m and the zero eigenvalue double",
            code=Reason.UNDAMPED,
        )
    forward = 1.0 / (2.0 * (rod.damping * rod.input_gain) * scheme.rate)
    weights = np.concatenate((np.full(N, forward), np.full(N, -rod.reflection * forward), [1.0]))
    return np.asarray(weights[scheme.permutation])


def deflated_coordinate(scheme: UpwindScheme, y: ArrayLike) -> Reals:
    r"""Coordinate ``zeta`` that waves do not move: where ``z`` goes if no contact is to come.

    .. math:: \zeta = z + \frac{1}{s(1+a)}\Big(\sum_{i \le N} y_i - a \sum_{i > N} y_i\Big), \qquad
        \zeta' = -\frac{A}{k}\, p(z) + \frac{g}{k} + (\text{terms in } f).

    Without loads and for ``k > 0`` it never increases, since ``p >= 0``.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, ``k != 0``.
    y : array_like
        (..., 2N+1) states in its ordering.

    Returns
    -------
    ndarray
        (...) [m].

    Raises
    ------
    AssumptionError
        ``k = 0``.
    """
    return np.asarray(np.asarray(y, dtype=float) @ zeta_weights(scheme))


def energy_theta(scheme: UpwindScheme) -> float:
    r"""Multiplier from which energy alone makes the Popov-Lyapunov function fall.

    Write the dissipation as ``D = |eta|^2/2`` in ``eta = (prev_i - y_i, i = 1..2N; sqrt(1-a^2) y_{2N})``.  Then
    ``zeta - z = alpha.eta`` and ``p = beta.eta`` are linear in ``eta``, and

    .. math:: V' &= -\frac{\theta}{2d}\,|\eta|^2 - 2 (\alpha\cdot\eta)(\beta\cdot\eta) - 2 z p \le -2 z p \\
        &\text{as soon as}\quad \theta \ge \theta_E = 2 d\,(|\alpha||\beta| - \alpha\cdot\beta).

    It serves every nonlinearity with ``z p(z) >= 0``.  It is an upper bound: Popov's inequality may hold for smaller
    ``theta``.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, ``k > 0``.

    Returns
    -------
    float
        ``theta_E`` [s].

    Raises
    ------
    AssumptionError
        ``k <= 0``.
    """
    _need_damping(scheme)
    rod, N = scheme.rod, scheme.cells
    kb, Zb, a = rod.damping * rod.input_gain, rod.impedance * rod.input_gain, rod.reflection
    one_plus_a, one_minus_a2 = 2.0 * kb, 4.0 * kb * Zb
    # alpha = -w (N, .., 1, 0, a, .., a (N-1), 2 a N/sqrt(1-a^2)),  2 d beta = -(1, .., 1, (1+a)/sqrt(1-a^2))
    w = 1.0 / (scheme.rate * one_plus_a)
    squares = N * (N + 1) * (2 * N + 1) / 6.0
    aa, bb = w * w * (squares + a * a * (squares - N * N)), 2.0 * N
    ab = w * (N * (N + 1) / 2.0 + a * (N * (N - 1) / 2.0))
    last_a, last_b = 2.0 * a * N * w / math.sqrt(one_minus_a2), one_plus_a / math.sqrt(one_minus_a2)
    product = ab + last_a * last_b
    norms = math.sqrt((aa + last_a**2) * (bb + last_b**2))
    # |alpha||beta| - alpha.beta by Lagrange's identity: the two are nearly equal for k much larger than Z
    area2 = (aa * bb - ab * ab) + aa * last_b**2 + bb * last_a**2 - 2.0 * ab * last_a * last_b
    return area2 / (norms + product)


def lyapunov_function(scheme: UpwindScheme, y: ArrayLike, theta: float) -> Reals:
    r"""Popov-Lyapunov function of the loop without loads.

    .. math:: V = \frac{\theta}{2 s d} \sum_i y_i^2 + 2\theta P(z) + \frac{\zeta^2}{\rho_0}, \qquad \rho_0 = A/k.

    ``V' <= -2 z p(z) <= 0`` for ``theta >= theta_E`` (:func:`energy_theta`) and every nonlinearity with ``z p(z) >=
    0``.  A smaller ``theta`` is allowed here and promises nothing.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, ``k > 0``.
    y : array_like
        (..., 2N+1) states in its ordering.
    theta : float
        Multiplier [s].

    Returns
    -------
    ndarray
        (...) [Pa s m].

    Raises
    ------
    AssumptionError
        ``k <= 0``: ``rho_0`` is not positive, and ``V`` not a Lyapunov function.
    """
    _need_damping(scheme)
    return np.asarray(
        2.0 * theta / scheme.rod.area * discrete_energy(scheme, y)
        + deflated_coordinate(scheme, y) ** 2 / scheme.rod.residue_at_zero
    )


def _need_damping(scheme: UpwindScheme) -> None:
    if scheme.rod.damping <= 0:
        raise AssumptionError(
            f"the Popov-Lyapunov function needs k > 0; the damping is {scheme.rod.damping:g} N s/m",
            code=Reason.UNDAMPED,
        )
