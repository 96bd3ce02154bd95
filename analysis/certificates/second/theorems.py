"""The theorems for rational blocks and dead time: what each asks of the loop, the class and the multiplier."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from flint import fmpq_poly

from lure.analysis.certificates.second import axis, gains
from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.axis import Need, half_line, holds_on_circle
from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.cover import require_cover
from lure.analysis.certificates.second.matrix import require_matrix
from lure.analysis.certificates.second.numerics import Laurent, X, to_fmpq
from lure.analysis.certificates.second.order import require_positive_on_orders
from lure.analysis.certificates.second.pace import kernel_weights, tap_weights
from lure.analysis.certificates.second.powers import require_powers
from lure.analysis.certificates.second.question import (
    Question,
    read_kernels,
    read_taps,
    require_legal,
    require_polynomial,
    require_written,
)
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    flag,
    listed,
    number,
    numbers,
    record,
    require,
)
from lure.analysis.certificates.second.systems import (
    Case,
    Delayed,
    Rational,
    Shifted,
    States,
    require_well_posed,
    shifted,
)

# The theorems in discrete time: their inequality on the unit circle, a polynomial in ``c = cos w`` on ``[-1, 1]``.

ONE_MINUS_C = fmpq_poly([1, -1])


def require_on_circle(asked: Question, block: Shifted) -> None:
    """Check the inequality of a theorem in discrete time.

    ``asked``: the theorem, the class and the multiplier; ``block``: the block after the shift.

    Raises
    ------
    NotShown
        The inequality fails somewhere on the unit circle, or the class is larger than the theorem covers.
    """
    claim = asked.claim
    need: Need = "positive" if claim.unbounded else claim.need
    if asked.theorem == "order-cone":
        p = _window(asked, block)
    else:
        hidden = asked.theorem == "circle" and claim.unbounded and block.hidden
        require(not hidden, "nonlinearities without bound need a block without hidden modes")
        n, d = Laurent(block.n[0][1]), Laurent(block.d)
        p = on_products(asked, block.feedthrough, (n * d.conjugate(), d * d.conjugate(), n * n.conjugate()))
        # |d|^2 and the real part both vanish at z = 1, where d has its simple root
        p = p // ONE_MINUS_C if block.case == "critical" else p
    require_written(asked, half_line(p), block, (fmpq_poly([1, 1]),))
    require(holds_on_circle(p, need), "the inequality does not hold on the unit circle")


def on_products(asked: Question, feedthrough: Fraction, products: tuple[Laurent, Laurent, Laurent]) -> fmpq_poly:
    """``|d|^2 (Re[M (H + 1/w)])`` or ``|d|^2 (1/w + Re[M H] - loss |(z - 1) H|^2)`` on the circle, in ``c = cos w``.

    Parameters
    ----------
    asked : Question
        The theorem, not that of forms of several samples, the class and the multiplier.
    feedthrough : Fraction
        ``H(inf)`` after the shift.
    products : tuple of Laurent
        ``n d*``, ``|d|^2`` and ``|n|^2``, in which this is linear.

    Raises
    ------
    NotShown
        The multiplier is not one of the theorem for such a class.
    """
    claim, given, nonlinearities = asked.claim, asked.document.multiplier, asked.claim.nonlinearities
    one, z, (cross, square, own) = Laurent(fmpq_poly([1])), Laurent(fmpq_poly([0, 1])), products
    eased = square.scaled(claim.inverse_gain)
    if asked.theorem == "circle":
        return (cross + eased).real_part()
    if asked.theorem == "zames-falb":
        taps = read_taps(given)
        rate = asked.document.rate
        masses = None if rate is None else tap_weights(taps, rate)
        require_legal(list(taps.values()), claim, strict=rate is None, masses=masses)
        return (taps_multiplier(taps) * (cross + eased)).real_part()
    q, width = number(record(given, "q")["q"]), claim.width
    require(q >= 0, "q is negative")
    if asked.theorem != "jury-lee":
        odd = asked.theorem == "tsypkin-odd"
        require(nonlinearities.odd or not odd, "the theorem is for odd nonlinearities")
        require(
            nonlinearities.slopes_within(claim.lower, nonlinearities.upper if feedthrough < 0 else "inf"),
            "Tsypkin's criterion needs the slope from the lower bound on, and up to k if H(inf) < 0",
        )
        difference, loss = one + z.conjugate().scaled(Fraction(1 if odd else -1)), Fraction(0)
    else:
        require(
            nonlinearities.slopes_within(claim.lower if feedthrough > 0 else "-inf", nonlinearities.upper),
            "the Jury-Lee criterion needs the slope up to the upper bound, and from l on if H(inf) > 0",
        )
        require(width is not None or q == 0, "for every finite bound at once q must be 0")
        difference, loss = z + one.scaled(Fraction(-1)), q * (width or 0) / 2
    found = ((one + difference.scaled(q)) * cross + eased).real_part()
    return found - to_fmpq(loss) * 2 * ONE_MINUS_C * own.real_part()  # |z - 1|^2 |n|^2


def _window(asked: Question, block: Shifted) -> fmpq_poly:
    """``|d|^2 (Re[m G] - W* M W)``, ``G = 1 + w H``: each entry of ``M`` with the powers of ``z`` of its samples."""
    found, width = record(asked.document.multiplier, "taps", "window", "odd"), asked.claim.width
    if width is None:
        raise NotShown("forms of several samples need a bound on the slope")
    odd, taps = flag(found["odd"]), read_taps({"taps": found["taps"]})
    rows = [numbers(row) for row in listed(found["window"])]
    require(asked.claim.nonlinearities.odd or not odd, "the form is for odd nonlinearities")
    require_legal(list(taps.values()), asked.claim, strict=False)
    require_positive_on_orders(rows, odd=odd)
    n, d = Laurent(block.n[0][1]), Laurent(block.d)
    G, half = d + n.scaled(width), len(rows) // 2
    total = (taps_multiplier(taps) * G * d.conjugate()).real_part()
    samples = [Laurent(fmpq_poly([0] * i + [1])) for i in range(half)]
    window = [z * d for z in samples] + [z * G.scaled(Fraction(-1)) for z in samples]
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            once = (window[i].conjugate() * window[j]).real_part()
            total -= to_fmpq(value if i == j else 2 * value) * once
    return total


def taps_multiplier(taps: dict[int, Fraction]) -> Laurent:
    """``1 - sum h_i z^-i``."""
    reach = max((abs(i) for i in taps), default=0)
    coefficients = [to_fmpq(-taps.get(reach - j, Fraction(0))) for j in range(2 * reach + 1)]
    coefficients[reach] += 1
    return Laurent(fmpq_poly(coefficients), reach)


SOLVABLE = "assumed: sigma + H(inf) phi(sigma) is increasing with a locally Lipschitz inverse"
HIGHER = "homogeneous-lyapunov"
CONTINUOUS = ("circle", "popov", "off-axis-circle", "park", "zames-falb", HIGHER)
DISCRETE = ("circle", "zames-falb", "order-cone", "tsypkin", "tsypkin-odd", "jury-lee", HIGHER)
SLOPES = ("off-axis-circle", "park", "zames-falb", "order-cone")  # those whose class is one of slopes, not a sector
ROBUST = ("circle", "popov")  # those that cover nonlinearities without upper bound


def proved(document: Document, system: Rational | Delayed, nonlinearities: Nonlinearities) -> str:
    """The sentence that is proved about a rational block or one with dead time.

    Raises
    ------
    NotShown
        A hypothesis fails or is not decided.
    """
    theorem = document.theorem
    require(theorem == "circle" or not nonlinearities.rough, "the theorem is for locally Lipschitz nonlinearities")
    if theorem == "hurwitz":
        record(document.multiplier)
        require(record(document.proof, "method")["method"] == "polynomial", "the method does not fit the theorem")
        if not isinstance(system, Rational):
            raise NotShown("constant gains are decided for rational blocks only")
        gains.require_every_gain_stable(system, nonlinearities)
        return claims.GAINS
    if theorem == "circle" and document.multiplier:
        require(record(document.multiplier, "mirrored")["mirrored"] is True, "mirrored is not true")
        system, nonlinearities = (
            _mirrored(system),
            replace(nonlinearities, slope=None).mirrored(),
        )  # the sector is all that is used
    asked = posed(document, system, nonlinearities)
    if asked.theorem == HIGHER:
        record(document.multiplier)
        if not isinstance(asked.system, Rational):
            raise NotShown("Lyapunov functions of higher degree are for rational blocks")
        return sentence(asked, require_powers(asked.system, asked.claim, document.proof))
    if document.proof.get("method") == "matrix":
        return sentence(asked, _by_matrix(asked))
    block = shifted(system, asked.claim.lower)
    require_case(asked, block.case)
    if block.discrete:
        require_on_circle(asked, block)
    else:
        _continuous(asked, block)
    return sentence(asked, block.case)


def posed(document: Document, system: Rational | Delayed, nonlinearities: Nonlinearities) -> Question:
    """The theorem, applied to what it covers as far as that does not depend on the poles.

    Raises
    ------
    NotShown
        It does not cover it.
    """
    if document.theorem in SLOPES:  # the slope bounds the sector too
        if nonlinearities.slope is None:
            raise NotShown("the theorem needs slope bounds")
        nonlinearities = replace(nonlinearities, lower=nonlinearities.slope[0], upper=nonlinearities.slope[1])
    claim = claims.Claim.of(nonlinearities)
    asked = Question(theorem=document.theorem, system=system, claim=claim, document=document)
    _require_scope(asked)
    if isinstance(system, Rational):
        require_well_posed(system.feedthrough, claim.lower, nonlinearities.upper)
    return asked


def _require_scope(asked: Question) -> None:
    """What does not depend on the poles: time, nonlinearities that vary, nonlinearities without bound."""
    discrete = isinstance(asked.system, Rational) and asked.system.discrete
    require(asked.theorem in (DISCRETE if discrete else CONTINUOUS), "the theorem is unknown for this time")
    require(
        asked.theorem in ("circle", HIGHER) or not asked.claim.nonlinearities.time_varying,
        "the theorem needs nonlinearities fixed in time",
    )
    if isinstance(asked.system, Delayed):
        require(asked.theorem != "off-axis-circle", "the theorem is not used with dead time")
        require(not asked.claim.unbounded, "nonlinearities without bound are not covered with dead time")
    require(asked.theorem in ROBUST or not asked.claim.unbounded, "the theorem needs an upper bound")
    if (
        asked.claim.nonlinearities.rough
    ):  # then every sequence of states is defined, and V falls along it, whatever phi is
        require(
            discrete and asked.plain_direct == 0,
            "nonlinearities that jump: in discrete time and without direct term only",
        )


def require_case(asked: Question, case: Case) -> None:
    """Check that the theorem covers the poles."""
    if case == "critical":
        require(
            not asked.claim.nonlinearities.rough, "with a pole at z = 1 convergence needs continuous nonlinearities"
        )
        require(asked.theorem != "order-cone", "the theorem needs a stable block, and this one has a pole at 0")
        require(asked.theorem == "circle" or asked.document.rate is None, "with a pole at 0 nothing decays at a rate")
        if isinstance(asked.system, Delayed):
            require(
                not asked.claim.nonlinearities.time_varying,
                "a pole at 0 and dead time need nonlinearities fixed in time",
            )


def sentence(asked: Question, case: Case) -> str:
    """What follows where the inequality holds."""
    if case == "critical":
        return claims.BOUNDED if asked.claim.nonlinearities.time_varying else claims.EQUILIBRIA
    return claims.DELAYED if isinstance(asked.system, Delayed) else claims.ATTRACTS


def _by_matrix(asked: Question) -> Case:
    system, theta = asked.system, Fraction(0)
    if not isinstance(system, Rational) or asked.theorem not in ROBUST:
        raise NotShown("matrices prove the circle and Popov's criterion of rational blocks only")
    if asked.theorem == "popov":
        theta = number(record(asked.document.multiplier, "theta")["theta"])
        _require_composed(asked, theta)
        require(
            not asked.claim.unbounded or asked.direct > 0 or theta >= 0, "nonlinearities without bound need theta >= 0"
        )
    case = require_matrix(system, asked.claim, theta, asked.document.proof)
    require_case(asked, case)
    return case


def _continuous(asked: Question, block: Shifted) -> None:
    claim, given = asked.claim, asked.document.multiplier
    need: Need = claim.need
    if asked.theorem == "off-axis-circle":
        inequality = axis.off_axis(block, number(record(given, "alpha")["alpha"]), claim.inverse_gain)
        require_polynomial(asked, block, inequality, need)
        return
    if asked.theorem == "circle" and claim.unbounded:
        require(not block.hidden, "nonlinearities without bound need a block without hidden modes")
        need = "decaying"
    multiplier = multiplier_of(asked)
    if asked.theorem == "popov":
        need = _popov(asked, block, multiplier.theta)
    curve = axis.curve(block, multiplier, claim.inverse_gain)
    if curve.polynomial is None:
        require(need != "decaying" and asked.document.proof.get("method") == "cover", "delays need a cover")
        require_cover(curve, asked.document.proof, need)
    else:
        require_polynomial(asked, block, (curve.polynomial, curve.full), need, multiplier.factors)


def multiplier_of(asked: Question) -> axis.Multiplier:
    """The multiplier of a theorem in continuous time, but for the off-axis circle criterion.

    Raises
    ------
    NotShown
        It is none of the theorem for such a class.
    """
    given = asked.document.multiplier
    if asked.theorem == "popov":
        return axis.Multiplier(theta=number(record(given, "theta")["theta"]))
    if asked.theorem == "park":
        found = record(given, "theta", "tau")
        theta, tau = number(found["theta"]), number(found["tau"])
        require(tau >= 0, "tau is negative")
        grown = axis.Axis.of(fmpq_poly([1]) - to_fmpq(tau) * X * X)  # 1 - tau s^2 = 1 + tau omega^2
        return axis.Multiplier(terms={Fraction(0): grown}, theta=theta, growth=int(tau > 0))
    if asked.theorem == "zames-falb":
        theta, kernels = read_kernels(given)
        rate = asked.document.rate
        masses = None if rate is None else kernel_weights(theta, kernels, rate)
        require(rate is None or theta == 0 or asked.direct == 0, "theta and a rate need H(inf) = 0")
        require_legal([c for c, _ in kernels], asked.claim, strict=False, masses=masses)
        return axis.kernels(theta, kernels)
    require(asked.theorem == "circle", "the theorem has no multiplier")
    return axis.Multiplier()


def _popov(asked: Question, block: Shifted, theta: Fraction) -> Need:
    _require_composed(asked, theta)
    if block.plant is None and block.case == "critical":
        require(theta >= 0, "a pole at 0 and dead time need theta >= 0")
    if not asked.claim.unbounded:
        return asked.claim.need
    if asked.direct > 0:
        return "positive"
    require(theta >= 0, "nonlinearities without bound need theta >= 0")
    require(not block.hidden, "nonlinearities without bound need a block without hidden modes")
    return "decaying"


def _require_composed(asked: Question, theta: Fraction) -> None:
    """With a direct term ``D`` the primitive of ``phi (1 + D phi)^-1`` must exist and have its sign.

    For ``D, theta >= 0`` it is ``Phi + D phi^2/2 >= 0`` along every solution.  Otherwise ``sigma + D phi(sigma)`` must
    ascend: ``1 + D kappa > 0`` for every slope of the shifted nonlinearity, which the sector alone does not say; then
    the file must list it as assumed of the class.
    """
    direct, nonlinearities, lower = asked.direct, asked.claim.nonlinearities, asked.claim.lower
    if direct == 0 or theta == 0 or (direct > 0 and theta > 0):
        return
    bound = None if nonlinearities.slope is None else nonlinearities.slope[0 if direct > 0 else 1]
    good = isinstance(bound, Fraction) and 1 + direct * (bound - lower) > 0
    stated = asked.document.hypotheses.get("solvable") == SOLVABLE and 1 + lower * asked.plain_direct > 0
    require(good or stated, "with this direct term and theta 1 + D slope > 0 must follow from the class, or be assumed")


def _mirrored(system: Rational | Delayed) -> Rational | Delayed:
    """The block ``-H``."""
    if isinstance(system, Delayed):
        return replace(system, terms=tuple((delay, -n) for delay, n in system.terms))
    r = system.states
    given = None if system.given is None else (-system.given[0], system.given[1])
    return replace(system, states=States(A=r.A, b=r.b, c=tuple(-v for v in r.c), d=-r.d), given=given)
