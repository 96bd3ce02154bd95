r"""Several nonlinearities, checked again: the loop shifted by the lower bounds, and a Schur complement in balls.

With ``phi = L sigma + psi``, ``psi_i`` in ``[0, w_i]``, and ``sigma = C x + D mu`` the loop is ``x' = A~ x - B~ psi``,
``sigma = C~ x - D~ psi`` where ``E = (1 + D L)^{-1}``, ``C~ = E C``, ``D~ = E D``, ``A~ = A - B L C~``, ``B~ = B (1
- L D~)``.  The form ``V = x'P x + 2 sum theta_i int_0^{sigma_i} phi_i`` is ``x'(P + C' L Theta C) x + 2 sum theta_i int
psi_i``, and with ``Q`` for that matrix, ``N = C~' Lambda W + A~' C' Theta``, what has to be positive definite is

.. math::

    \begin{pmatrix} -(\tilde A'Q + Q\tilde A) & Q\tilde B - N \\ \cdot &
    2\Lambda + \Lambda W\tilde D + \tilde D'W\Lambda + \Theta C\tilde B + \tilde B'C'\Theta \end{pmatrix},

in discrete time, ``Theta = 0``, with ``Q - A~'Q A~``, ``A~'Q B~ - C~' W Lambda`` and ``- B~'Q B~`` added.  ``V > 0`` if
``Q + C' Theta^- W C > 0``, ``Theta^-`` the negative part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat, fmpq_mat, fmpz

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.classes import Nonlinearities, read_nonlinearities
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import (
    ball,
    half_plane_counts,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    flag,
    listed,
    mapping,
    numbers,
    record,
    require,
    tick,
)
from lure.analysis.certificates.second.systems import mapped

LARGEST = 400


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The plant and the classes of a certificate; bounds are those of ``phi_i(sigma)/sigma``."""

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat
    discrete: bool
    nonlinearities: tuple[Nonlinearities, ...]
    repeated: bool

    @property
    def bounds(self) -> list[tuple[Fraction, Fraction]]:
        """Finite bounds of every channel.

        Raises
        ------
        NotShown
            A channel has none.
        """
        ends = [nonlinearities.ends for nonlinearities in self.nonlinearities]
        if any(low is None or high is None or low >= high for low, high in ends):
            raise NotShown("a channel has no finite bounds")
        return [(low, high) for low, high in ends if low is not None and high is not None]


def shown(document: Document) -> str:
    """The sentence that a certificate about several nonlinearities shows.

    Parameters
    ----------
    document : Document
        The parts of the certificate.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    asked = _read(document)
    require(document.nonlinearity is None, "no nonlinearity is given beside several classes")
    if document.verdict == "PROVED":
        _proved(document, asked)
        return claims.ATTRACTS
    require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    return _refuted(document, asked)


def _read(document: Document) -> Asked:
    found = record(document.system, "kind", "time", "A", "B", "C", "D")
    require(found["kind"] == "multivariable", "the kind of system is unknown for several nonlinearities")
    require(found["time"] in ("continuous", "discrete"), "the time is unknown")
    rows = {name: [numbers(row) for row in listed(found[name])] for name in "ABCD"}
    n, m = len(rows["A"]), len(rows["D"])
    require(0 < n <= LARGEST and 0 < m <= LARGEST, "there are no states or channels, or too many")
    for name, height, width in (("A", n, n), ("B", n, m), ("C", m, n), ("D", m, m)):
        fits = len(rows[name]) == height and all(len(row) == width for row in rows[name])
        require(fits, f"{name} does not fit the other matrices")
    stated = record(document.nonlinearities, "channels", "repeated")
    given = [mapping(one) for one in listed(stated["channels"])]
    repeated = flag(stated["repeated"])
    require(len(given) == m, "there is not one class for each channel")
    require(not repeated or all(dict(one) == dict(given[0]) for one in given), "one nonlinearity has one class")
    sides = {name: fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for name, side in rows.items()}
    return Asked(
        **sides,
        discrete=found["time"] == "discrete",
        nonlinearities=tuple(map(read_nonlinearities, given)),
        repeated=repeated,
    )


def _proved(document: Document, asked: Asked) -> None:
    m, popov = asked.D.nrows(), document.theorem == "diagonal-popov"
    require(popov or document.theorem == "diagonal-circle", "the theorem is not one for several nonlinearities")
    given = record(document.multiplier, *(("lambda", "theta") if popov else ("lambda",)))
    weights = numbers(given["lambda"])
    theta = numbers(given["theta"]) if popov else [Fraction(0)] * m
    require(len(weights) == m == len(theta), "the multipliers are not one for each channel")
    require(all(v >= 0 for v in weights), "a weight is negative")
    require(
        not any(nonlinearities.rough for nonlinearities in asked.nonlinearities),
        "the theorem is for locally Lipschitz nonlinearities",
    )
    require(not (popov and asked.discrete), "Popov's criterion is for continuous time")
    for i, nonlinearities in enumerate(asked.nonlinearities):
        state_only = all(asked.D[i, j] == 0 for j in range(m))
        require(
            theta[i] == 0 or (state_only and not nonlinearities.time_varying), "Popov's term does not fit its channel"
        )
    proof = record(document.proof, "method", "P", "exponent")
    require(proof["method"] == "matrix", "the method does not fit the theorem")
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    shifted = _shifted(asked)
    rows = triangle(proof["P"], asked.A.nrows())
    for bits in BITS:
        with working_precision(bits):
            if all(map(positive_definite, _forms(asked, shifted, (rows, exponent), weights, theta))):
                return
    raise NotShown("V or the matrix of the inequality is not shown to be positive definite")


def _shifted(asked: Asked) -> tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat]:
    """``A~, B~, C~, D~``."""
    m = asked.D.nrows()
    lower, one = _diagonal([low for low, _ in asked.bounds]), _diagonal([Fraction(1)] * m)
    whole = one + asked.D * lower
    require(bool(whole.det() != 0), "the loop is not well posed at the lower bounds")
    inverse = whole.inv()
    C, D = inverse * asked.C, inverse * asked.D
    return asked.A - asked.B * lower * C, asked.B * (one - lower * D), C, D


def _forms(
    asked: Asked,
    shifted: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    scaled: tuple[list[list[fmpz]], int],
    weights: Sequence[Fraction],
    theta: Sequence[Fraction],
) -> tuple[arb_mat, arb_mat]:
    """At the working precision what has to be positive definite: for ``V``, and for its fall."""
    (rows, exponent), n, m = scaled, asked.A.nrows(), asked.D.nrows()
    A, B, C, D = map(arb_mat, shifted)
    own, unit = arb_mat(asked.C), arb(2) ** -exponent
    P = arb_mat([[arb(rows[max(i, j)][min(i, j)]) * unit for j in range(n)] for i in range(n)])
    low, width = [low for low, _ in asked.bounds], [high - low for low, high in asked.bounds]
    turn, weight = _balls(theta), _balls([w * v for w, v in zip(weights, width, strict=True)])
    Q = P + own.transpose() * _balls([t * v for t, v in zip(theta, low, strict=True)]) * own
    least = Q + own.transpose() * _balls([min(t, Fraction(0)) * v for t, v in zip(theta, width, strict=True)]) * own
    moved = A.transpose() * Q
    side = C.transpose() * weight
    corner = _balls([2 * v for v in weights]) + weight * D + (weight * D).transpose()
    if asked.discrete:
        main, edge, corner = Q - moved * A, moved * B - side, corner - B.transpose() * Q * B
    else:
        rate = turn * own * B
        main, edge = -(moved + moved.transpose()), Q * B - side - A.transpose() * own.transpose() * turn
        corner = corner + rate + rate.transpose()
    top = [[*(main[i, j] for j in range(n)), *(edge[i, j] for j in range(m))] for i in range(n)]
    bottom = [[*(edge[j, i] for j in range(n)), *(corner[i, j] for j in range(m))] for i in range(m)]
    return least, arb_mat([*top, *bottom])


def _diagonal(values: Sequence[Fraction]) -> fmpq_mat:
    return fmpq_mat([[to_fmpq(v) if i == j else to_fmpq(0) for j in range(len(values))] for i, v in enumerate(values)])


def _balls(values: Sequence[Fraction]) -> arb_mat:
    return arb_mat([[ball(v) if i == j else arb(0) for j in range(len(values))] for i, v in enumerate(values)])


def _refuted(document: Document, asked: Asked) -> str:
    """What constant gains do: the characteristic polynomial, its roots counted by their side."""
    proof = record(document.proof, "method", "gains")
    require(proof["method"] == "linear-gains", "the method is unknown for several nonlinearities")
    gains, m = numbers(proof["gains"]), asked.D.nrows()
    require(len(gains) == m, "there is not one gain for each channel")
    require(
        all(nonlinearities.has_gain(g) for nonlinearities, g in zip(asked.nonlinearities, gains, strict=True)),
        "a gain is not in its class",
    )
    require(not asked.repeated or len(set(gains)) == 1, "one nonlinearity has one gain")
    G = _diagonal(gains)
    whole = _diagonal([Fraction(1)] * m) + asked.D * G
    if whole.det() == 0:
        return claims.NO_SOLUTION
    tick()
    p = (asked.A - asked.B * G * whole.inv() * asked.C).charpoly()
    require(p.degree() == asked.A.nrows(), "the characteristic polynomial has another degree")
    inner = mapped(p, p.degree()) if asked.discrete else p
    counts = half_plane_counts(inner)
    at_infinity = p.degree() - inner.degree()  # z = -1
    at_zero = next(i for i in range(inner.degree() + 1) if to_fraction(inner[i]) != 0)
    require(counts.right + counts.axis + at_infinity > 0, "the loop with these gains is asymptotically stable")
    rests = counts.right == 0 and at_infinity == 0 and counts.axis == at_zero
    return claims.OTHER_EQUILIBRIA if rests else claims.NO_REST
