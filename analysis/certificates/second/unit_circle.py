"""The theorems in discrete time: their inequality on the unit circle, a polynomial in ``c = cos w`` on ``[-1, 1]``."""

from __future__ import annotations

from fractions import Fraction

from flint import fmpq_poly

from analysis.certificates.second.multipliers import read_taps, require_legal
from analysis.certificates.second.positivity import Need, half_line, holds_on_circle
from analysis.certificates.second.question import Question, require_written
from analysis.certificates.second.reading import number, record, require
from analysis.certificates.second.shifting import Shifted
from analysis.polynomial import to_fmpq
from analysis.trigonometric import Laurent

ONE_MINUS_C = fmpq_poly([1, -1])


def require_on_circle(asked: Question, block: Shifted) -> None:
    """Check the inequality of a theorem in discrete time.

    Parameters
    ----------
    asked : Question
        The theorem, the class and the multiplier.
    block : Shifted
        The block after the shift.

    Raises
    ------
    NotShown
        The inequality fails somewhere on the unit circle, or the class is larger than the theorem covers.
    """
    claim, given, laws = asked.claim, asked.document.multiplier, asked.claim.laws
    need: Need = "positive" if claim.unbounded else claim.need
    one, z = Laurent(fmpq_poly([1])), Laurent(fmpq_poly([0, 1]))
    if asked.theorem == "circle":
        require(not (claim.unbounded and block.hidden), "laws without bound need a block without hidden modes")
        p = on_response(block, one, claim.ease)
    elif asked.theorem == "zames-falb":
        taps = read_taps(given)
        require_legal(list(taps.values()), claim, strict=True)
        p = on_sum(block, taps_multiplier(taps), claim.ease)
    else:
        q, width = number(record(given, "q")["q"]), claim.width
        require(q >= 0, "q is negative")
        if asked.theorem == "tsypkin":
            require(
                laws.slopes_within(claim.lower, laws.upper if block.feedthrough < 0 else "inf"),
                "Tsypkin's criterion needs the slope from the lower bound on, and up to k if H(inf) < 0",
            )
            difference, loss = one + z.conjugate().scaled(Fraction(-1)), Fraction(0)
        else:
            require(
                laws.slopes_within(claim.lower if block.feedthrough > 0 else "-inf", laws.upper),
                "the Jury-Lee criterion needs the slope up to the upper bound, and from l on if H(inf) > 0",
            )
            require(width is not None or q == 0, "for every finite bound at once q must be 0")
            difference, loss = z + one.scaled(Fraction(-1)), q * (width or 0) / 2
        p = on_response(block, one + difference.scaled(q), claim.ease, loss)
    require_written(asked, half_line(p), block, (fmpq_poly([1, 1]),))
    require(holds_on_circle(p, need), "the inequality does not hold on the unit circle")


def on_sum(block: Shifted, multiplier: Laurent, ease: Fraction) -> fmpq_poly:
    """``|d|^2 Re[M (H + ease)]``; in the critical case divided by ``1 - c``.

    Parameters
    ----------
    block : Shifted
        In discrete time.
    multiplier : Laurent
        ``M``; it acts on ``ease`` too.
    ease : Fraction
        ``1/w``.
    """
    n, d = Laurent(block.n[0][1]), Laurent(block.d)
    inner = n * d.conjugate() + (d * d.conjugate()).scaled(ease)
    return _finished(block, (multiplier * inner).real_part(), n, Fraction(0))


def on_response(block: Shifted, multiplier: Laurent, ease: Fraction, loss: Fraction = Fraction(0)) -> fmpq_poly:
    """``|d|^2 (ease + Re[M H] - loss |(z - 1) H|^2)``: the multiplier acts on ``H`` alone.

    ``loss`` is ``q w/2`` of the Jury-Lee criterion.
    """
    n, d = Laurent(block.n[0][1]), Laurent(block.d)
    inner = multiplier * n * d.conjugate() + (d * d.conjugate()).scaled(ease)
    return _finished(block, inner.real_part(), n, loss)


def taps_multiplier(taps: dict[int, Fraction]) -> Laurent:
    """``1 - sum h_i z^-i``."""
    reach = max((abs(i) for i in taps), default=0)
    coefficients = [to_fmpq(-taps.get(reach - j, Fraction(0))) for j in range(2 * reach + 1)]
    coefficients[reach] += 1
    return Laurent(fmpq_poly(coefficients), reach)


def _finished(block: Shifted, real_part: fmpq_poly, n: Laurent, loss: Fraction) -> fmpq_poly:
    difference = 2 * ONE_MINUS_C * (n * n.conjugate()).real_part()  # |z - 1|^2 |n|^2
    found = real_part - to_fmpq(loss) * difference
    # |d|^2 and the real part both vanish at z = 1, where d has its simple root
    return found // ONE_MINUS_C if block.case == "critical" else found
