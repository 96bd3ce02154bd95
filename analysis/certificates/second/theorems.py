"""The theorems for rational blocks and dead time: what each asks of the loop, the class and the multiplier."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from flint import fmpq_poly

from analysis.certificates.second import axis, claims, gains
from analysis.certificates.second.classes import Laws
from analysis.certificates.second.cover import require_cover
from analysis.certificates.second.matrix import require_matrix
from analysis.certificates.second.multipliers import read_kernels, require_legal
from analysis.certificates.second.positivity import Need
from analysis.certificates.second.question import Question, require_polynomial
from analysis.certificates.second.reading import Document, NotShown, number, record, require
from analysis.certificates.second.shifting import Case, Shifted, require_well_posed, shifted
from analysis.certificates.second.systems import Delayed, Rational
from analysis.certificates.second.unit_circle import require_on_circle
from analysis.polynomial import X, to_fmpq
from analysis.refutation.realisation import Realisation

SOLVABLE = "assumed: sigma + H(inf) phi(sigma) is increasing with a locally Lipschitz inverse"
CONTINUOUS = ("circle", "popov", "off-axis-circle", "park", "zames-falb")
DISCRETE = ("circle", "zames-falb", "tsypkin", "jury-lee")
SLOPES = ("off-axis-circle", "park", "zames-falb")  # those whose class is one of slopes, not a sector
ROBUST = ("circle", "popov")  # those that cover the critical case, dead time and laws without upper bound


def proved(document: Document, system: Rational | Delayed, laws: Laws) -> str:
    """The sentence that is proved about a rational block or one with dead time.

    Raises
    ------
    NotShown
        A hypothesis fails or is not decided.
    """
    theorem = document.theorem
    require(theorem == "circle" or not laws.rough, "the theorem is for locally Lipschitz laws")
    if theorem == "hurwitz":
        record(document.multiplier)
        require(record(document.proof, "method")["method"] == "polynomial", "the method does not fit the theorem")
        if not isinstance(system, Rational):
            raise NotShown("constant gains are decided for rational blocks only")
        gains.require_every_gain_stable(system, laws)
        return claims.GAINS
    if theorem == "circle" and document.multiplier:
        require(record(document.multiplier, "mirrored")["mirrored"] is True, "mirrored is not true")
        system, laws = _mirrored(system), replace(laws, slope=None).mirrored()  # the sector is all that is used
    if theorem in SLOPES:  # the slope bounds the sector too
        if laws.slope is None:
            raise NotShown("the theorem needs slope bounds")
        laws = replace(laws, lower=laws.slope[0], upper=laws.slope[1])
    asked = Question(theorem=theorem, system=system, claim=claims.Claim.of(laws), document=document)
    _require_scope(asked)
    if isinstance(system, Rational):
        require_well_posed(system.feedthrough, asked.claim.lower, laws.upper)
    if document.proof.get("method") == "matrix":
        return _sentence(asked, _by_matrix(asked))
    block = shifted(system, asked.claim.lower)
    _require_case(asked, block.case)
    if block.discrete:
        require_on_circle(asked, block)
    else:
        _continuous(asked, block)
    return _sentence(asked, block.case)


def _require_scope(asked: Question) -> None:
    """What does not depend on the poles: time, laws that vary, laws without bound."""
    discrete = isinstance(asked.system, Rational) and asked.system.discrete
    require(asked.theorem in (DISCRETE if discrete else CONTINUOUS), "the theorem is unknown for this time")
    require(asked.theorem == "circle" or not asked.claim.laws.time_varying, "the theorem needs laws fixed in time")
    if isinstance(asked.system, Delayed):
        require(asked.theorem in ROBUST, "the theorem is not used with dead time")
        require(not asked.claim.unbounded, "laws without bound are not covered with dead time")
    require(asked.theorem in ROBUST or not asked.claim.unbounded, "the theorem needs an upper bound")
    if asked.claim.laws.rough:  # then every sequence of states is defined, and V falls along it, whatever phi is
        require(discrete and asked.plain_direct == 0, "laws that jump: in discrete time and without direct term only")


def _require_case(asked: Question, case: Case) -> None:
    if case == "critical":
        require(not asked.claim.laws.rough, "with a pole at z = 1 convergence needs continuous laws")
        require(asked.theorem in ROBUST, "the theorem needs a stable block, and this one has a pole at 0")
        if isinstance(asked.system, Delayed):
            require(not asked.claim.laws.time_varying, "a pole at 0 and dead time need laws fixed in time")


def _sentence(asked: Question, case: Case) -> str:
    if case == "critical":
        return claims.BOUNDED if asked.claim.laws.time_varying else claims.EQUILIBRIA
    return claims.DELAYED if isinstance(asked.system, Delayed) else claims.ATTRACTS


def _by_matrix(asked: Question) -> Case:
    system, theta = asked.system, Fraction(0)
    if not isinstance(system, Rational) or asked.theorem not in ROBUST:
        raise NotShown("matrices prove the circle and Popov's criterion of rational blocks only")
    if asked.theorem == "popov":
        theta = number(record(asked.document.multiplier, "theta")["theta"])
        _require_composed(asked, theta)
        require(not asked.claim.unbounded or asked.direct > 0 or theta >= 0, "laws without bound need theta >= 0")
    case = require_matrix(system, asked.claim, theta, asked.document.proof)
    _require_case(asked, case)
    return case


def _continuous(asked: Question, block: Shifted) -> None:
    claim, given = asked.claim, asked.document.multiplier
    need: Need = claim.need
    if asked.theorem == "off-axis-circle":
        inequality = axis.off_axis(block, number(record(given, "alpha")["alpha"]), claim.ease)
        require_polynomial(asked, block, inequality, need)
        return
    multiplier = axis.Multiplier()
    if asked.theorem == "circle" and claim.unbounded:
        require(not block.hidden, "laws without bound need a block without hidden modes")
        need = "decaying"
    elif asked.theorem == "popov":
        multiplier = axis.Multiplier(theta=number(record(given, "theta")["theta"]))
        need = _popov(asked, block, multiplier.theta)
    elif asked.theorem == "park":
        found = record(given, "theta", "tau")
        theta, tau = number(found["theta"]), number(found["tau"])
        require(tau >= 0, "tau is negative")
        grown = axis.Axis.of(fmpq_poly([1]) - to_fmpq(tau) * X * X)  # 1 - tau s^2 = 1 + tau omega^2
        multiplier = axis.Multiplier(terms={Fraction(0): grown}, theta=theta, growth=int(tau > 0))
    elif asked.theorem == "zames-falb":
        theta, kernels = read_kernels(given)
        require_legal([c for c, _ in kernels], claim, strict=False)
        multiplier = axis.kernels(theta, kernels)
    curve = axis.curve(block, multiplier, claim.ease)
    if curve.polynomial is None:
        require(need != "decaying" and asked.document.proof.get("method") == "cover", "delays need a cover")
        require_cover(curve, asked.document.proof, need)
    else:
        require_polynomial(asked, block, (curve.polynomial, curve.full), need, multiplier.factors)


def _popov(asked: Question, block: Shifted, theta: Fraction) -> Need:
    _require_composed(asked, theta)
    if block.plant is None and block.case == "critical":
        require(theta >= 0, "a pole at 0 and dead time need theta >= 0")
    if not asked.claim.unbounded:
        return asked.claim.need
    if asked.direct > 0:
        return "positive"
    require(theta >= 0, "laws without bound need theta >= 0")
    require(not block.hidden, "laws without bound need a block without hidden modes")
    return "decaying"


def _require_composed(asked: Question, theta: Fraction) -> None:
    """With a direct term ``D`` the primitive of ``phi (1 + D phi)^-1`` must exist and have its sign.

    For ``D, theta >= 0`` it is ``Phi + D phi^2/2 >= 0`` along every motion.  Otherwise ``sigma + D phi(sigma)`` must
    ascend: ``1 + D kappa > 0`` for every slope of the shifted law, which the sector alone does not say; then the file
    must list it as assumed of the class.
    """
    direct, laws, lower = asked.direct, asked.claim.laws, asked.claim.lower
    if direct == 0 or theta == 0 or (direct > 0 and theta > 0):
        return
    bound = None if laws.slope is None else laws.slope[0 if direct > 0 else 1]
    good = isinstance(bound, Fraction) and 1 + direct * (bound - lower) > 0
    stated = asked.document.hypotheses.get("solvable") == SOLVABLE and 1 + lower * asked.plain_direct > 0
    require(good or stated, "with this direct term and theta 1 + D slope > 0 must follow from the class, or be assumed")


def _mirrored(system: Rational | Delayed) -> Rational | Delayed:
    """The block ``-H``."""
    if isinstance(system, Delayed):
        return replace(system, terms=tuple((delay, -n) for delay, n in system.terms))
    r = system.realisation
    given = None if system.given is None else (-system.given[0], system.given[1])
    return replace(system, realisation=Realisation(r.A, r.b, tuple(-v for v in r.c), -r.d), given=given)
