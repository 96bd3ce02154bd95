"""Passivity of a rational transfer function: its two indices and positive realness, by exact root counts."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import fmpq_poly

from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.minimum import infimum, nonnegative_from_zero, positive_with_limits
from lure.analysis.numerics.polynomial import X, even_odd, is_hurwitz, real_roots, to_fmpq
from lure.analysis.numerics.precision import outward
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.plants.conversion import exact_block
from lure.record import Record, quantity

ABSENT = Bracket(-math.inf, -math.inf)


class Passivity(Record):
    """What holds between input and output of ``H``, apart from hidden modes."""

    positive_real: Verdict = quantity("PROVED or REFUTED, never undecided")
    strictly_positive_real: Verdict = quantity("PROVED or REFUTED, never undecided")
    input_feedforward: Bracket = quantity(
        "``nu``, the largest number with ``H - nu`` positive real; ``-inf`` where there is none",
        label="input feedforward nu",
    )
    output_feedback: Bracket | None = quantity(
        "``rho``, the largest number with ``1/H - rho`` positive real; ``-inf`` where there is none, None for ``H = "
        "0``",
        label="output feedback rho",
        form=lambda rho: "none" if rho is None else rho,
    )
    evidence: Evidence = quantity("What all of it rests on")
    reason: str = quantity("One sentence")
    _kind, _said = "passivity", "sentence"
    _title = "H is positive real"
    _notes = ("From rest, between input and output: nothing is said about hidden modes.",)
    _no_truth = "passivity has several answers; compare passivity.positive_real or the indices"

    @property
    def _verdict(self) -> str:
        return str(self.positive_real)

    def __str__(self) -> str:
        rho = "none" if self.output_feedback is None else f"{self.output_feedback}"
        return f"nu = {self.input_feedforward}, rho = {rho} ({self.evidence}): {self.reason}"


def passivity_indices(block: object) -> Passivity:
    r"""The passivity indices of ``H`` and whether it is positive real, strictly so, or not, with no tolerance.

    .. math:: \nu = \inf_\omega \mathrm{Re}\, H(i\omega), \qquad \rho = \inf_\omega \mathrm{Re}\, (1/H(i\omega)),

    the first where ``H`` has no pole in the open right half-plane and only simple ones with positive residue on the
    axis, the second where the same holds for ``1/H`` (a pole at infinity included); otherwise the index is minus
    infinity.  From rest, ``int u y >= nu int u^2`` and ``int u y >= rho int y^2`` up to any time.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        The block, in continuous or (with the unit circle for the axis) discrete time.

    Returns
    -------
    Passivity
        Brackets to a relative width of 1e-15 or so.  Hidden modes are left out: nothing is said about states that
        input or output does not see.

    Raises
    ------
    InputError
        The block has no exact coefficients.

    Notes
    -----
    A coprime ``n/d`` is positive real if and only if ``Re(n conj d) >= 0`` on the axis and ``n + d`` has no root in the
    closed right half-plane nor at infinity: then ``(d - n)/(d + n)`` is analytic there and bounded by 1 (maximum
    principle) [1]_.  ``H`` is strictly positive real (``H(s - e)`` positive real for some ``e > 0``) if and only if its
    poles lie in the open left half-plane, ``Re H > 0`` at every frequency, and ``Re H`` or ``w^2 Re H`` has a positive
    limit at infinity [2]_; in discrete time ``Re H > 0`` on the circle.

    References
    ----------
    .. [1] B. D. O. Anderson and S. Vongpanitlerd, Network Analysis and Synthesis, Prentice-Hall, 1973.
    .. [2] H. K. Khalil, Nonlinear Systems, 3rd ed., lemma 6.1.

    Examples
    --------
    >>> print(passivity_indices("1/(s+1)"))
    nu = 0, rho = 1 (certified): H is strictly positive real
    """
    plant = TransferPolynomials.of(exact_block(block, "passivity_indices"))
    n, d = plant.n // plant.hidden, plant.d // plant.hidden
    degree = max(n.degree(), d.degree())
    passive = _positive_real(n, d, degree)
    strict = _strictly_positive_real(n, d, degree, discrete=plant.discrete)
    return Passivity(
        input_feedforward=_index(n, d, degree),
        output_feedback=_index(d, n, degree) if n.degree() >= 0 else None,
        positive_real=Verdict.PROVED if passive else Verdict.REFUTED,
        strictly_positive_real=Verdict.PROVED if strict else Verdict.REFUTED,
        evidence=Evidence.CERTIFIED,
        reason=_reason(n, d, passive=passive, strict=strict),
    )


def _positive_real(n: fmpq_poly, d: fmpq_poly, degree: int) -> bool:
    """Whether the coprime ``n/d``, of which one has the given degree and the other at most that, is positive real."""
    total = n + d
    return total.degree() == degree and is_hurwitz(total) and nonnegative_from_zero(_real_part(n, d))


def _strictly_positive_real(n: fmpq_poly, d: fmpq_poly, degree: int, *, discrete: bool) -> bool:
    U, square = _real_part(n, d), _real_part(d, d)
    return (
        d.degree() == degree
        and is_hurwitz(d)
        and positive_with_limits(U, U.degree())
        and square.degree() - U.degree() <= (0 if discrete else 1)
    )


def _real_part(n: fmpq_poly, d: fmpq_poly) -> fmpq_poly:
    """``Re(n conj d)`` on the axis as a polynomial in ``x = w^2``."""
    (ne, no), (de, do) = even_odd(n), even_odd(d)
    return ne * de + X * no * do


def _index(n: fmpq_poly, d: fmpq_poly, degree: int) -> Bracket:
    """The largest ``nu`` with ``n/d - nu`` positive real."""
    U, D = _real_part(n, d), _real_part(d, d)
    shared = U.gcd(D)
    U, D = U // shared, D // shared
    if D[0] < 0:
        U, D = -U, -D
    # Re must stay bounded at poles on the axis and at infinity, or n/d - nu is positive real for no nu
    if U.degree() > D.degree() or D[0] == 0 or any(bool(x > 0) for x in real_roots(D)):
        return ABSENT
    found = infimum(U, D)
    bracket = outward(found.low, found.high)
    if not math.isfinite(bracket.low):
        return Bracket(-math.inf, bracket.high)
    if not _positive_real(n - to_fmpq(Fraction(bracket.low)) * d, d, degree):
        return ABSENT
    return bracket


def _reason(n: fmpq_poly, d: fmpq_poly, *, passive: bool, strict: bool) -> str:
    if strict:
        return "H is strictly positive real"
    if passive:
        return "H is positive real, not strictly"
    if not nonnegative_from_zero(_real_part(n, d)):
        return "H is not positive real: Re H is negative at some frequency"
    return "H is not positive real: a pole lies right of the axis, or on it and is multiple or of residue not positive"
