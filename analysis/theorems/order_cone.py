"""The order-cone criterion in discrete time: forms of several samples at once, beyond every Zames-Falb multiplier."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import ClassVar

from flint import fmpq_poly

from lure.analysis.certificates.states import order_positive
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.order_cones import FormProposal, FormSearch, OrderCones
from lure.analysis.inequality.protocol import Best, Proves
from lure.analysis.inequality.protocol import Multiplier as Weights
from lure.analysis.inequality.unit_circle import DiscretePlant, largest_certified
from lure.analysis.numerics.doubles import double_below, text_above
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.trigonometric import Laurent, positive_on_circle
from lure.analysis.theorems.criterion import Criterion, slope_criterion
from lure.analysis.theorems.fir import Multiplier, SampledResponse
from lure.analysis.theorems.zames_falb_discrete import TapsInequality, best_multiplier
from lure.analysis.verdict import Bracket, CriterionResult
from lure.arrays import np
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

NAME = "order-cone"
TITLE = "the order-cone criterion"
THEOREM = (
    "Quadratic constraints on windows of samples, copositive on every order cone, with the stability theorem for "
    "integral quadratic constraints (A. Megretski and A. Rantzer, IEEE Trans. Automatic Control 42 (1997) 819-830)"
)
CLOSED = 1e-6
WINDOWS = {False: (3, 4), True: (3,)}  # for odd nonlinearities four samples have 192 cones
LONGEST, MOST_TAPS = 4, 100
DENOMINATOR, RAISED = 10**10, (0.0, 1e-9, 1e-8, 1e-7, 1e-6)


def order_cone_largest(
    block: RationalPlant,
    *,
    odd: bool,
    lower: Fraction = Fraction(0),
    window: int | None = None,
    taps: int | None = None,
) -> CriterionResult:
    r"""Largest slope that Zames-Falb taps and a form of a window of consecutive samples prove.

    In ``sigma = H mu``, ``mu = -phi(sigma)``, ``phi`` time-invariant with ``phi(0) = 0`` and slope in ``[0, k]``, let
    ``u_t = phi(sigma_t)``, ``v_t = k sigma_t - u_t`` and ``w_t = (u_t, .., u_{t+T-1}, v_t, .., v_{t+T-1})``.  If ``M``
    is symmetric with ``w^T M w >= 0`` on every order cone (``lure.analysis.inequality.order_cones``), then ``w_t^T M
    w_t >= 0`` along every solution, and the origin is globally asymptotically stable if ``H`` is stable, ``1 + k H(inf)
    > 0`` and for some Zames-Falb multiplier ``m(z) = 1 - sum h_i z^-i``, ``sum |h_i| < 1``,

    .. math:: \mathrm{Re}\,[m\,G] - W^* M\, W > 0 \quad (|z| = 1), \qquad G = 1 + k H, \quad
        W = (1, z, .., z^{T-1}, -G, -G z, .., -G z^{T-1}) .

    ``h_i >= 0`` and ``M`` is for all orderings of the samples and 0; for odd ``phi`` the ``h_i`` may have either sign
    and ``M`` is for all orderings of ``|sigma_i|``.  Where ``M`` only needs to be entrywise nonnegative in the
    increments of the order it is a Zames-Falb multiplier; forms that are not go farther.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    odd : bool
        Whether ``phi`` is known to be odd.  The answer for odd nonlinearities says nothing about others.
    lower : Fraction
        Lower slope.
    window : int, optional
        Number ``T`` of samples, at most 4; by default 3 and, unless ``odd``, 4 if 3 gain something.
    taps : int, optional
        Largest ``|i|``, 0 for none; by default those of :func:`.zames_falb_discrete_largest`.

    Returns
    -------
    CriterionResult
        ``largest.low`` is certified, up to itself; ``parameters`` hold the exact taps, ``M`` and ``k``.  That nothing
        larger was found means neither that there is no such form nor that the loop is unstable.

    Raises
    ------
    InputError
        The block is in continuous time; ``window`` or ``taps`` is out of range.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    Cutting planes: a linear programme over the taps and ``M``, to which the worst frequencies and the worst points of
    the cones are added.  The numbers are rounded; copositivity is then decided in rationals on every face of every
    cone, and the frequency inequality by counting the roots of a polynomial.

    Examples
    --------
    >>> block = RationalPlant([Fraction(2), Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
    >>> round(order_cone_largest(block, odd=False, window=3, taps=0).largest.low, 5)  # 175/192 destabilises
    0.91146
    """
    for name, value, top in (("window", window, LONGEST), ("taps", taps, MOST_TAPS)):
        whole = isinstance(value, int) and not isinstance(value, bool)
        least = 1 if name == "window" else 0
        if value is not None and not (whole and least <= value <= top):
            raise InputError(f"order_cone_largest: {name} is {value!r:.40}; give a whole number from {least} to {top}")
    windows = () if window is None else (window,)
    return _criterion(odd=odd).answer(WindowInequality.of(block, Fraction(lower), odd=odd, windows=windows, taps=taps))


def order_cone_criterion(block: RationalPlant, bounds: SlopeBounds, *, odd: bool) -> CriterionResult:
    r"""Whether Zames-Falb taps and a form of a window of samples prove one class of slopes.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds on the slope of ``phi``.
    odd : bool
        Whether ``phi`` is known to be odd.

    Returns
    -------
    CriterionResult
        As :func:`order_cone_largest`, about this class; INCONCLUSIVE if it is beyond the forms found, which does not
        mean that the loop is unstable.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        A bound is infinite, or the block is not stable with the gain ``bounds.lower``.
    """
    return _criterion(odd=odd).decide(block, bounds)


@described(frozen=True, kw_only=True, slots=True)
class WindowInequality(TapsInequality):
    """``Re[m G] - W^* M W > 0`` on the circle, with taps in ``m`` and a form ``M`` of consecutive samples."""

    windows: tuple[int, ...] = quantity(
        "Numbers of samples to try, ascending, as long as one gains something; empty for the usual ones", default=()
    )
    title: ClassVar[str] = TITLE
    critical: ClassVar[bool] = False

    def best(self, enough: Fraction | None = None) -> Best:
        """The farthest form that the cutting planes find; above it nothing is ruled out but what linear gains do."""
        discrete, lower = self.discrete, self.base.lower
        top = hurwitz_limit(self.base.plant.block, lower).high
        response = SampledResponse.of(*discrete.coefficients())
        taps, low = Multiplier(taps={}), math.nan
        if self.taps is None:
            taps, low = best_multiplier(discrete, self.base.plant.block, odd=self.odd)
        length = max(map(abs, taps.taps), default=0) if self.taps is None else self.taps
        form = Form(taps, (), Fraction(1) if math.isnan(low) else Fraction(low) - lower)
        for samples in self.windows or WINDOWS[self.odd]:
            if low >= top * (1 - CLOSED):
                break
            search = FormSearch(response.omega, response.at(response.omega), length, OrderCones(samples, self.odd))
            ends = (0.0 if math.isnan(low) else float((Fraction(low) - lower) * discrete.gain), math.inf)
            found = search.farthest(
                ends[0], ends[1] if math.isinf(top) else float((Fraction(top) - lower) * discrete.gain)
            )
            trial = None if found is None else _rounded(found[0], search.taps, odd=self.odd)
            if found is None or trial is None:
                break
            k = largest_certified(discrete, 1 / found[1], partial(self._holds, trial))
            if math.isnan(k) or k <= low:
                break
            form, low = replace(trial, width=Fraction(k) - lower), k
        words = f"{form.taps}, and a form of {len(form.rows) // 2} samples" if form.rows else str(form.taps)
        end = low if low > lower else double_below(lower)
        limit = f"linear gains are stable only below {text_above(top)}" if top < math.inf else ""
        return Best(multiplier=form.weights, largest=Bracket(end, max(top, end)), formula=words, limit=limit)

    def _holds(self, form: Form, width: Fraction) -> bool:
        """Whether a form satisfies the inequality for this width, exactly; whether it is legal is another question."""
        return (
            width > 0 and self.discrete.well_posed(width) and positive_on_circle(form.inequality(self.discrete, width))
        )

    def serving(self, best: Best, _proves: Proves) -> Weights:
        """The best form: it serves every smaller class too, scaled down with it."""
        return best.multiplier or Form(Multiplier(taps={}), (), Fraction(1)).weights

    def decide(self, multiplier: Weights, upper: Fraction) -> bool:
        """Whether taps and form prove the slopes ``[lower, upper]``, exactly."""
        width = Fraction(upper) - self.base.lower
        form = Form.of(multiplier).at(width)
        return form.legal(odd=self.odd) and self._holds(form, width)

    def polynomial(self, multiplier: Weights, width: Fraction | None) -> fmpq_poly:
        """The left-hand side times ``|d|^2`` as a polynomial in ``cos w``, for a finite width of the class."""
        assert width is not None, "the forms are about finite bounds"
        return Form.of(multiplier).at(width).inequality(self.discrete, width)


@described(frozen=True, slots=True)
class Form:
    """Exact taps and a form."""

    taps: Multiplier = quantity("Of the Zames-Falb multiplier")
    rows: tuple[tuple[Fraction, ...], ...] = quantity(
        "The lower triangle of ``M`` for ``v = width sigma - phi``; empty for no form"
    )
    width: Fraction = quantity("The largest slope, that of the shifted nonlinearity")

    @classmethod
    def of(cls, weights: Weights) -> Form:
        """From the weights of an answer."""
        rows = tuple(
            tuple(map(Fraction, row)) for _, row in sorted(weights["window"].items(), key=lambda one: int(one[0]))
        )
        return cls(
            Multiplier(taps={int(i): Fraction(h) for i, h in weights["taps"].items()}), rows, Fraction(weights["width"])
        )

    @property
    def weights(self) -> dict[str, object]:
        """As they stand in an answer."""
        taps = {str(i): str(h) for i, h in sorted(self.taps.taps.items())}
        window = {str(i): [str(v) for v in row] for i, row in enumerate(self.rows)}
        return {"taps": taps, "window": window, "width": str(self.width)}

    def legal(self, *, odd: bool) -> bool:
        """Whether the taps are those of a Zames-Falb multiplier, and ``M`` is positive on every order cone."""
        M = [[self.rows[max(i, j)][min(i, j)] for j in range(len(self.rows))] for i in range(len(self.rows))]
        return self.taps.legal(odd=odd) and (not M or order_positive(M, odd))

    def inequality(self, discrete: DiscretePlant, width: Fraction) -> fmpq_poly:
        """``|d|^2 (Re[m G] - W^* M W)`` on the circle as a polynomial in ``cos w``."""
        d, turned = discrete.d, discrete.d + discrete.n.scaled(width)  # G = turned/d
        total, T = (self.taps.laurent * turned * d.conjugate()).real_part(), len(self.rows) // 2
        for i, row in enumerate(self.rows):
            for j, value in enumerate(row):
                if value:
                    left, right = (d if part < T else turned.scaled(Fraction(-1)) for part in (i, j))
                    once = (left.conjugate() * right * Laurent(fmpq_poly([1]), i % T - j % T)).real_part()
                    total -= to_fmpq(value * (1 if i == j else 2)) * once
        return total

    def at(self, width: Fraction) -> Form:
        """The same form for smaller slopes, up to ``width``.

        With ``v' = k' sigma - u`` it is ``v = (k/k') v' + (k/k' - 1) u``, nonnegative where ``u`` and ``v'`` are, and
        ``Re[m G]`` over ``k`` grows, so that ``(k'/k) M`` in ``u``, ``v'`` serves with the same taps.
        """
        if not 0 < width < self.width:
            return self
        ratio, T = self.width / width, len(self.rows) // 2

        def entry(i: int, j: int) -> Fraction:
            """The entry of the symmetric form."""
            return self.rows[max(i, j)][min(i, j)]

        uu = [[entry(i, j) for j in range(T)] for i in range(T)]
        uv = [[entry(i, T + j) for j in range(T)] for i in range(T)]
        vv = [[entry(T + i, T + j) for j in range(T)] for i in range(T)]
        more = ratio - 1
        rows = [[uu[i][j] + more * (uv[i][j] + uv[j][i]) + more**2 * vv[i][j] for j in range(i + 1)] for i in range(T)]
        for i in range(T):
            left = [ratio * (uv[j][i] + more * vv[i][j]) for j in range(T)]
            rows.append([*left, *(ratio**2 * vv[i][j] for j in range(i + 1))])
        return Form(self.taps, tuple(tuple(v / ratio for v in row) for row in rows), width)


def certificate_multiplier(parameters: Mapping[str, object], width: Fraction, *, odd: bool) -> dict[str, object]:
    """What a certificate about the slopes ``[lower, lower + width]`` holds.

    Parameters
    ----------
    parameters : Mapping
        Those of an answer: ``taps``, ``window`` and the ``width`` that they are for.
    width : Fraction
        Of the class.
    odd : bool
        Whether the form is for odd nonlinearities.
    """
    form = Form.of(parameters).at(width)
    taps = [[i, str(h)] for i, h in sorted(form.taps.taps.items())]
    return {"taps": taps, "window": [[str(v) for v in row] for row in form.rows], "odd": odd}


def _rounded(proposal: FormProposal, shifts: Sequence[tuple[int, int]], *, odd: bool) -> Form | None:
    """The same in decimals, over the mean of its multiplier, ``M`` raised until it is positive; None if that fails."""
    total, taps = proposal.free + float(proposal.weights.sum()), dict[int, Fraction]()
    for (i, sign), weight in zip(shifts, proposal.weights.tolist(), strict=True):
        taps[i] = taps.get(i, Fraction(0)) + sign * Fraction(math.floor(weight / total * DENOMINATOR), DENOMINATOR)
    kept = Multiplier(taps={i: h for i, h in taps.items() if h})
    for raised in RAISED:
        M = (proposal.M / total + raised * np.eye(len(proposal.M))) * DENOMINATOR
        rows = (tuple(Fraction(round(v), DENOMINATOR) for v in row[: i + 1]) for i, row in enumerate(M.tolist()))
        form = Form(kept, tuple(rows), Fraction(1))
        if form.legal(odd=odd):
            return form
    return None


def _criterion(*, odd: bool) -> Criterion:
    """The criterion for monotone nonlinearities, or for odd ones."""
    return slope_criterion(
        odd=odd,
        name=NAME,
        title=TITLE,
        theorem=THEOREM,
        formula="M(z) = 1 - sum h_i z^-i, and a form of consecutive samples",
        inequality=partial(WindowInequality.of, odd=odd),
        legal=(
            f"sum |h_i| < 1, {'of either sign, for odd phi' if odd else 'h_i >= 0'}, and the form is positive on every "
            "order cone: checked exactly"
        ),
    )
