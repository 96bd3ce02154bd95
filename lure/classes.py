"""Classes of nonlinearities: what is assumed of ``phi``, and nothing more."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import accumulate
from typing import Final, Literal, cast

from lure.bounds import Sector as Sector
from lure.bounds import SlopeBounds as SlopeBounds
from lure.bounds import lower_text, upper_text
from lure.errors import InputError
from lure.exact import exact_number
from lure.record import Record, quantity

SCALAR = "scalar linear time-invariant"
FULL_BLOCK: Final = "full block"
Operator = Literal[
    "",
    "any",
    "linear time-invariant",
    "scalar linear time-invariant",
    "performance",
    "delay",
    "varying delay",
    "full block",
]
OPERATORS = ("any", "linear time-invariant", SCALAR)
DELAYS = ("delay", "varying delay")


class NonlinearityClass(Record):
    r"""All ``phi`` with ``phi(0) = 0`` that satisfy the properties listed; a theorem holds for every one of them.

    Parameters
    ----------
    sector : Sector
        Bounds on ``phi(sigma) / sigma``; by default those of the slope.
    slope : SlopeBounds or None
        Bounds on every difference quotient, None if nothing is assumed of them.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    time_varying : bool
        Whether ``phi`` may depend on time; then ``slope`` and ``odd`` hold at each time.
    linear : bool
        Whether ``phi(sigma) = g sigma`` is assumed, the gain ``g`` constant and unknown; see :meth:`constant_gain`.
    rectifier : bool
        Whether ``phi`` is known but for its scale: the upper bound times ``sigma`` above 0 and the lower one times
        ``sigma`` below; see :meth:`relu`.
    rate : Fraction or None
        Of a linear ``phi`` that depends on time: a bound on how fast ``g`` changes; see :meth:`varying_gain`.
    memory : {"", "play", "stop"}
        Not ``""``: no function of ``sigma``, but increments as the slope bounds say; see :meth:`hysteretic`.
    operator : str
        Not ``""``: an operator ``mu_b = -Delta sigma_b`` on the channels of its block, ``"any"``, ``"linear
        time-invariant"``, ``"scalar linear time-invariant"``, ``"performance"``, ``"delay"`` or ``"varying delay"``;
        see :meth:`norm_bounded`, :meth:`performance` and :meth:`delayed`.  ``"full block"``: a function of all
        ``sigma`` of the block together, see :meth:`full_block`.

    Raises
    ------
    InputError
        Neither sector nor slope bounds are given; or the slope bounds lie outside the sector's: members would leave
        the sector; or the bounds coincide; or constant gains are said to depend on time, or a rate is given of others;
        or a ReLU is said to be odd, or its sector and slope bounds differ or are infinite; or an operator has other
        properties than a bound of its norm.

    Examples
    --------
    >>> print(NonlinearityClass(sector=Sector(0, 2), slope=SlopeBounds(0, 2), odd=True))
    odd phi with slope in [0, 2]
    """

    sector: Sector = quantity("", default=None)
    slope: SlopeBounds | None = quantity("", form=lambda bounds: bounds or "nothing is assumed", default=None)
    odd: bool = quantity("", form=lambda odd: "assumed" if odd else "not assumed", default=False)
    time_varying: bool = quantity(
        "", label="time", form=lambda varying: f"phi {'may' if varying else 'does not'} depend on it", default=False
    )
    linear: bool = quantity("", label="", default=False)
    rectifier: bool = quantity("", label="", key="relu", default=False)
    rate: Fraction | None = quantity("", label="", default=None)
    memory: Literal["", "play", "stop"] = quantity("", label="", key="", default="")
    operator: Operator = quantity("", key="", label="", default="")
    _kind, _said = "class of nonlinearities", "text"

    def __post_init__(self) -> None:
        if cast("Sector | None", self.sector) is None:
            if self.slope is None:
                raise InputError("NonlinearityClass has neither sector nor slope bounds; give one of both")
            object.__setattr__(self, "sector", Sector(self.slope.lower, self.slope.upper))
        for bounds in (self.sector, self.slope):
            if bounds is not None and bounds.lower == bounds.upper:
                raise InputError(
                    f"NonlinearityClass has the bounds {bounds}, in which only a straight line lies; a linear gain "
                    "belongs into the block"
                )
        if self.slope is not None and (self.slope.lower > self.sector.lower or self.slope.upper < self.sector.upper):
            raise InputError(
                f"NonlinearityClass has the sector {self.sector} and the slope bounds {self.slope}: a "
                "nonlinearity with these "
                "slopes lies in the sector of the same bounds; give a sector inside the slope bounds"
            )
        paced = self.rate is not None
        if (self.linear or (paced and not self.operator)) and (
            self.time_varying is not paced or self.slope is None or not self.odd
        ):
            raise InputError(
                "NonlinearityClass has constant gains that are not odd, have no slope bounds, or depend on time; give "
                "NonlinearityClass.constant_gain(lower, upper), the sector for gains that depend on time, or "
                "NonlinearityClass.varying_gain(lower, upper, rate=r) for those that change slowly"
            )
        if self.rate is not None:
            if not self.linear and self.operator != DELAYS[1]:
                raise InputError(
                    "NonlinearityClass has a rate and is not linear; give NonlinearityClass.varying_gain(lower, upper, "
                    "rate=r), or leave the rate out"
                )
            rate = exact_number(self.rate, "NonlinearityClass.rate")
            if rate <= 0:
                raise InputError(
                    f"NonlinearityClass.rate is {float(rate):g}; give how fast the gain may change, a positive number, "
                    "or for constant gains NonlinearityClass.constant_gain"
                )
            object.__setattr__(self, "rate", rate)
        if self.rectifier and not self._is_relu:
            raise InputError(
                "NonlinearityClass has a ReLU that is odd, linear, depends on time, or whose sector and slope bounds "
                "differ or are infinite; give NonlinearityClass.relu(lower, upper)"
            )
        if self.memory and not (self._is_relu and self.sector.lower == 0 and not (self.rectifier or self.operator)):
            raise InputError(
                "NonlinearityClass has memory and other properties than slopes from 0 to a finite bound; give "
                "NonlinearityClass.hysteretic('play' or 'stop', bound)"
            )
        if self.operator:
            self._check_operator()

    @property
    def _is_relu(self) -> bool:
        """Whether the other fields are those of a ReLU."""
        ends = (self.sector.lower, self.sector.upper)
        same = self.slope is not None and (self.slope.lower, self.slope.upper) == ends
        return same and not (self.odd or self.linear or self.time_varying or math.inf in map(abs, ends))

    def _check_operator(self) -> None:
        if self.operator not in (*OPERATORS, "performance", *DELAYS, FULL_BLOCK):
            raise InputError(f"NonlinearityClass.operator is {self.operator!r:.40}; choose from {', '.join(OPERATORS)}")
        low, high = self.sector.lower, self.sector.upper
        if self.operator == FULL_BLOCK:
            if self.slope is not None or self.odd or self.linear or self.rate is not None or math.inf in (-low, high):
                raise InputError(
                    "NonlinearityClass is a function of several channels with other properties than finite bounds of "
                    "its sector; give NonlinearityClass.full_block(lower, upper)"
                )
            return
        if self.slope is not None or self.odd or self.linear or low != -high or high == math.inf:
            raise InputError(
                "NonlinearityClass is an operator with other properties than a finite bound of its norm; give "
                "NonlinearityClass.norm_bounded(bound)"
            )
        if self.rate is not None and self.rate >= 1:
            raise InputError(
                f"the rate of a delay is {float(self.rate):g}; give a number below 1, or leave it out for delays that "
                "change at any rate"
            )
        object.__setattr__(self, "time_varying", self.operator not in (*OPERATORS[1:], DELAYS[0]))

    @classmethod
    def slope_restricted(
        cls, lower: float | Fraction, upper: float | Fraction, *, odd: bool = False
    ) -> NonlinearityClass:
        """Time-invariant nonlinearities with slope in ``[lower, upper]``, hence in the same sector."""
        return cls(slope=SlopeBounds(lower, upper), odd=odd)

    @classmethod
    def constant_gain(cls, lower: float | Fraction, upper: float | Fraction) -> NonlinearityClass:
        """The gains ``phi(sigma) = g sigma`` with a constant ``g`` in ``[lower, upper]`` that is not known.

        Examples
        --------
        >>> print(NonlinearityClass.constant_gain(0, 2))
        phi = g sigma, g in [0, 2]
        """
        return cls(sector=Sector(lower, upper), slope=SlopeBounds(lower, upper), odd=True, linear=True)

    @classmethod
    def relu(cls, lower: float | Fraction = 0, upper: float | Fraction = 1) -> NonlinearityClass:
        """The ReLU ``phi(sigma) = max(sigma, 0)``, or ``upper max(sigma, 0) + lower min(sigma, 0)``: a leaky one.

        No linear gain is a member.  With ``u = phi - lower sigma`` and ``v = phi - upper sigma`` it is what ``u >= 0``,
        ``v >= 0`` and ``u v = 0`` say.

        Examples
        --------
        >>> print(NonlinearityClass.relu())
        phi = max(sigma, 0)
        """
        return cls(sector=Sector(lower, upper), slope=SlopeBounds(lower, upper), rectifier=True)

    @classmethod
    def varying_gain(
        cls, lower: float | Fraction, upper: float | Fraction, *, rate: float | Fraction
    ) -> NonlinearityClass:
        """The gains ``phi(sigma) = g(t) sigma`` with ``g`` in ``[lower, upper]`` that change slowly.

        In continuous time ``|g(t) - g(s)| <= rate |t - s|``, in discrete time ``|g(t + 1) - g(t)| <= rate``.

        Parameters
        ----------
        lower, upper : int, float or Fraction
            Bounds of the gain.
        rate : int, float or Fraction
            The bound on its change, positive [unit of the gain / s; discrete: / sample].

        Examples
        --------
        >>> print(NonlinearityClass.varying_gain(0, 2, rate=0.5))
        phi = g(t) sigma, g in [0, 2], rate at most 0.5
        """
        bounds = Sector(lower, upper), SlopeBounds(lower, upper)
        paced: Fraction = rate  # type: ignore[assignment]  # made exact there
        return cls(sector=bounds[0], slope=bounds[1], odd=True, time_varying=True, linear=True, rate=paced)

    @classmethod
    def norm_bounded(cls, bound: float | Fraction, *, dynamics: str = "any") -> NonlinearityClass:
        r"""The operators ``mu_b = -Delta sigma_b`` with ``|Delta| <= bound`` on a block ``b`` of channels.

        ``"any"``: causal operators with :math:`\int_0^T |\mu_b|^2 \le \mathrm{bound}^2 \int_0^T |\sigma_b|^2` for every
        ``T``, nonlinear and time-varying ones too.  ``"linear time-invariant"``: stable transfer matrices with
        :math:`\|\Delta\|_\infty \le` bound.  ``"scalar linear time-invariant"``: these with :math:`\Delta = \delta I`,
        one and the same ``delta`` in each channel.  In a :class:`Diagonal` the class stands once for each channel of
        the block, and ``repeated`` says how many these are.

        Parameters
        ----------
        bound : int, float or Fraction
            Largest gain in the Euclidean norm, positive and finite [unit of mu / unit of sigma].
        dynamics : {"any", "linear time-invariant", "scalar linear time-invariant"}
            Which operators.

        Raises
        ------
        InputError
            The bound is not positive and finite, or there are no such operators.

        Examples
        --------
        >>> print(NonlinearityClass.norm_bounded(2))
        operator phi of norm <= 2
        >>> one = NonlinearityClass.norm_bounded(1, dynamics="linear time-invariant")
        >>> print(Diagonal((one, one, NonlinearityClass(sector=Sector(0, 1))), repeated=(2, 1)))
        linear time-invariant operator (phi_1, phi_2) of norm <= 1; phi_3 in the sector [0, 1]
        >>> one = NonlinearityClass.norm_bounded(1, dynamics="scalar linear time-invariant")
        >>> print(Diagonal((one, one), repeated=True))
        scalar linear time-invariant operator phi_1 = phi_2 of norm <= 1
        """
        if dynamics not in OPERATORS:
            raise InputError(f"NonlinearityClass.operator is {dynamics!r:.40}; choose from {', '.join(OPERATORS)}")
        return cls._of_norm(bound, dynamics, "bound")

    @classmethod
    def full_block(
        cls, lower: float | Fraction, upper: float | Fraction, *, time_varying: bool = False
    ) -> NonlinearityClass:
        r"""Functions ``mu_b = -phi(sigma_b)`` of all channels of a block together, in a full-block sector.

        They are locally Lipschitz, and :math:`(\phi(\sigma_b) - l\sigma_b)^\top(u\sigma_b - \phi(\sigma_b)) \ge 0`
        for every :math:`\sigma_b`.  A nonlinearity in the sector ``[l, u]`` in each channel is a member, and so is each
        matrix of gains :math:`G` with :math:`(G - l)^\top(u - G) + (u - G)^\top(G - l) \ge 0`.  In a
        :class:`Diagonal` the class stands once for each channel of the block, and ``repeated`` says how many these are.

        Parameters
        ----------
        lower, upper : int, float or Fraction
            ``l`` and ``u``, finite [unit of mu / unit of sigma].
        time_varying : bool
            Whether ``phi`` may depend on time.

        Examples
        --------
        >>> one = NonlinearityClass.full_block(0, 2)
        >>> print(Diagonal((one, one, NonlinearityClass(sector=Sector(0, 1))), repeated=(2, 1)))
        (phi_1, phi_2) in the full-block sector [0, 2]; phi_3 in the sector [0, 1]
        """
        return cls(sector=Sector(lower, upper), time_varying=time_varying, operator=FULL_BLOCK)

    @classmethod
    def hysteretic(cls, kind: str, slope: float | Fraction = 1) -> NonlinearityClass:
        """Play (backlash) and stop (elastic, perfectly plastic) operators, their initial states included.

        A play of width ``2 r`` and slope ``k`` is ``k`` times what follows ``sigma`` at a distance of at most ``r``;
        the stop of the same is ``k sigma`` less that.  Members have any ``r > 0`` and any ``k`` up to ``slope``.

        Parameters
        ----------
        kind : {"play", "stop"}
            Which.
        slope : int, float or Fraction
            The largest ``k``, positive and finite.

        Raises
        ------
        InputError
            There is no such kind, or the slope is not positive and finite.

        Examples
        --------
        >>> print(NonlinearityClass.hysteretic("play", 2))
        play phi of a slope in [0, 2]
        """
        if kind not in ("play", "stop"):
            raise InputError(f"the kind of memory is {kind!r:.40}; choose from play, stop")
        number = isinstance(slope, int | float | Fraction) and not isinstance(slope, bool)
        if not number or not 0 < slope < math.inf:
            raise InputError(f"the slope of a {kind} is {slope!r:.40}; give a positive finite number")
        bounds = Sector(0, slope), SlopeBounds(0, slope)
        return cls(sector=bounds[0], slope=bounds[1], memory=kind)  # type: ignore[arg-type]  # checked above

    @classmethod
    def delayed(
        cls, bound: float | Fraction, *, varying: bool = False, rate: float | Fraction | None = None
    ) -> NonlinearityClass:
        r"""The delays ``mu = -sigma(t - tau)`` with ``0 <= tau <= bound``, of which nothing else is known.

        ``tau`` is constant; or, ``varying``, any measurable function of time.  In the class ``sector`` is ``[-bound,
        bound]``: :math:`|\sigma(t - \tau) - \sigma|_{L_2} \le \mathrm{bound}\, |\sigma'|_{L_2}`.  With ``repeated``
        all channels of the block have the same delay.  In discrete time it is a number of samples.

        Parameters
        ----------
        bound : int, float or Fraction
            The largest delay, positive and finite [s; discrete: samples].
        varying : bool
            Whether the delay may change, at any rate; then in continuous time ``sigma`` has to be a function of the
            state alone.
        rate : int, float, Fraction or None
            Of a delay that varies in continuous time: a bound of ``|tau'|``, above 0 and below 1.

        Raises
        ------
        InputError
            The bound is not positive and finite, or the rate is out of range.

        Examples
        --------
        >>> print(NonlinearityClass.delayed(0.5))
        delay phi = sigma(t - tau), tau in [0, 0.5]
        """
        found = cls._of_norm(bound, DELAYS[bool(varying or rate is not None)], "bound", "delay")
        paced: Fraction | None = rate  # type: ignore[assignment]  # made exact there
        return found if rate is None else replace(found, rate=paced)

    @classmethod
    def performance(cls, bound: float | Fraction = 1) -> NonlinearityClass:
        """What closes the loop from ``z`` to ``w`` where the L2 gain is asked for: it is below ``1/bound``.

        Parameters
        ----------
        bound : int, float or Fraction
            The inverse of the gain, positive and finite.
        """
        return cls._of_norm(bound, "performance", "bound")

    @classmethod
    def _of_norm(cls, bound: float | Fraction, operator: str, name: str, of: str = "norm") -> NonlinearityClass:
        number = isinstance(bound, int | float | Fraction) and not isinstance(bound, bool)
        if not number or not 0 < bound < math.inf:
            raise InputError(f"the {name} of a {of} is {bound!r:.40}; give a positive finite number")
        return cls(sector=Sector(-bound, bound), operator=operator)  # type: ignore[arg-type]  # checked there

    @property
    def gains(self) -> tuple[float | Fraction, float | Fraction]:
        """Bounds of ``phi(sigma)/sigma``: those of the sector and, as ``phi(0) = 0``, those of the slopes."""
        slope = self.slope or self.sector
        return max(self.sector.lower, slope.lower), min(self.sector.upper, slope.upper)

    def scaled(self, alpha: Fraction) -> NonlinearityClass:
        """The class with its upper bounds times ``alpha``; lower bounds and rates stay, but of a norm both are ``+-``.

        Parameters
        ----------
        alpha : Fraction
            The factor.
        """
        if self.operator and self.operator != FULL_BLOCK:
            bound = alpha * Fraction(self.sector.upper)
            return replace(self, sector=Sector(-bound, bound))

        def top(value: float | Fraction) -> float | Fraction:
            """The upper bound times ``alpha``; an infinite one as it is."""
            return value if value in (math.inf, -math.inf) else alpha * Fraction(value)

        slope = self.slope and SlopeBounds(self.slope.lower, top(self.slope.upper))
        return replace(self, sector=Sector(self.sector.lower, top(self.sector.upper)), slope=slope)

    def __str__(self) -> str:
        if self.rate is not None and not self.operator:
            return f"phi = g(t) sigma, g in {self.sector}, rate at most {upper_text(self.rate)}"
        if self.memory:
            return f"{self.memory} phi of a slope in {self.slope}"
        if self.linear:
            return f"phi = g sigma, g in {self.sector}"
        if self.rectifier:
            low, high = self.gains
            leak = f" + {lower_text(low)} min(sigma, 0)" if low else ""
            return f"phi = {'' if high == 1 else f'{upper_text(high)} '}max(sigma, 0){leak}"
        if self.operator and self.operator != FULL_BLOCK:
            bound, gain = self.sector.upper, self.operator == "performance"
            slow = "" if self.rate is None else upper_text(self.rate)
            return operator_words(self.operator, upper_text(1 / Fraction(bound)) if gain else lower_text(bound), slow)
        words = "odd phi" if self.odd else "phi"
        kind = "full-block sector" if self.operator else "sector"
        bounds = f"slope in {self.slope}" if self.slope is not None else f"{kind} {self.sector}"
        if self.slope is not None and (self.slope.lower, self.slope.upper) != (self.sector.lower, self.sector.upper):
            bounds += f" and sector {self.sector}"
        when = ", time-varying" if self.time_varying else ""
        return f"{words} with {bounds}{when}" if self.slope is not None else f"{words} in the {bounds}{when}"

    @property
    def _title(self) -> str:
        return f"Class of nonlinearities: {self}"


def operator_words(operator: str, bound: str, rate: str = "") -> str:
    """A norm-bounded block, or the performance channel, in words.

    Parameters
    ----------
    operator : str
        ``operator`` of a class.
    rate : str
        That of a delay in digits, empty if there is none.
    bound : str
        The bound of the norm; of the performance channel the gain, its inverse.
    """
    if operator == "performance":
        return f"an L2 gain of {bound} from w to z"
    if operator in DELAYS:
        slow = f", |tau'| <= {rate}" if rate else ""
        return f"delay phi = sigma(t - tau{'(t)' * (operator != DELAYS[0])}), tau in [0, {bound}]{slow}"
    return f"{'' if operator == 'any' else operator + ' '}operator phi of norm <= {bound}"


class Diagonal(Record, kw_only=False):
    """The classes of several nonlinearities, one for each channel: ``mu_i = -phi_i(sigma_i)``.

    Parameters
    ----------
    classes : tuple of NonlinearityClass
        One for each channel.
    repeated : bool or tuple of int
        Whether all channels have the same nonlinearity; or how many channels in turn have the same one: ``(1, 2)`` is
        one in channel 1 and another in channels 2 and 3.  The classes of the same nonlinearity are equal.  Of a class
        with an ``operator``: the channels on which one operator acts.

    Raises
    ------
    InputError
        There is no class, or something else in its place; those of the same nonlinearity differ, or the numbers of
        channels do not add up; or a performance channel is not the last block.

    Examples
    --------
    >>> print(Diagonal((NonlinearityClass(sector=Sector(0, 2)),)))
    phi in the sector [0, 2]
    >>> one, two = NonlinearityClass(sector=Sector(0, 1)), NonlinearityClass.slope_restricted(0, 3)
    >>> print(Diagonal((one, two, two), repeated=(1, 2)))
    phi_1 in the sector [0, 1]; phi_2 = phi_3 with slope in [0, 3]
    """

    classes: tuple[NonlinearityClass, ...] = quantity("", label="class", form="rows")
    repeated: bool | tuple[int, ...] = False
    _kind, _said = "classes of nonlinearities", "text"

    def __post_init__(self) -> None:
        if not self.classes:
            raise InputError("Diagonal has no class; give one for each channel")
        for i, one in enumerate(self.classes):
            if not isinstance(one, NonlinearityClass):
                how = "NonlinearityClass(sector=Sector(0, 1)) or NonlinearityClass(slope=SlopeBounds(0, 1))"
                raise InputError(f"Diagonal.classes[{i}] is {one!r:.60}, no class of nonlinearities; give {how}")
        if not isinstance(self.repeated, bool):
            sizes, m = tuple(self.repeated), len(self.classes)
            if not all(type(size) is int and size > 0 for size in sizes) or sum(sizes) != m:
                raise InputError(
                    f"Diagonal.repeated is {list(sizes)!r:.60} for {m} classes; give how many channels in turn have "
                    "the same nonlinearity, numbers that add up to that of the classes"
                )
            object.__setattr__(self, "repeated", sizes if 1 < len(sizes) < m else len(sizes) == 1 < m)
        for block in self.blocks:
            if len({self.classes[i] for i in block}) > 1:
                told = "; ".join(f"channel {i + 1}: {self.classes[i]}" for i in block)
                raise InputError(f"Diagonal repeats one nonlinearity, and its classes differ: {told}")
        if any(self.classes[block[0]].operator == "performance" for block in self.blocks[:-1]):
            raise InputError("Diagonal has a performance channel before other channels; give it as the last block")

    @property
    def performance(self) -> range | None:
        """The channels from ``z`` to ``w``, None where no gain is asked for."""
        return self.blocks[-1] if self.classes[-1].operator == "performance" else None

    @property
    def operators(self) -> tuple[range, ...]:
        """The blocks of channels with an operator, the performance channel among them."""
        return tuple(block for block in self.blocks if self.classes[block[0]].operator)

    @property
    def blocks(self) -> tuple[range, ...]:
        """The channels, counted from 0, of each nonlinearity."""
        m = len(self.classes)
        sizes = ((m,) if self.repeated else (1,) * m) if isinstance(self.repeated, bool) else self.repeated
        ends = list(accumulate(sizes))
        return tuple(range(end - size, end) for end, size in zip(ends, sizes, strict=True))

    @property
    def rectified(self) -> bool:
        """Whether a class is that of a ReLU; then the classes of a smaller factor are others, and not contained."""
        return any(one.rectifier for one in self.classes)

    def require_no_rectifier(self) -> None:
        """Refuse ReLUs where linear gains are taken for members, as they are around one channel, and operators.

        Raises
        ------
        InputError
            A class is that of a ReLU, or of an operator.
        """
        if self.operators or any(one.memory for one in self.classes):
            raise InputError(
                "an operator, a delay or memory closes a channel of several; give a rational plant, and the classes as "
                "a list"
            )
        if self.rectified:
            raise InputError(
                "a ReLU is asked about around a rational plant alone, as the class of each channel, of its only one "
                "too: classes=[NonlinearityClass.relu()]"
            )

    @property
    def lower(self) -> tuple[Fraction, ...]:
        """Gains by which the loop is shifted: the finite lower bounds of ``phi_i(sigma)/sigma``.

        0 for operators, and 1 for delays: what these are where ``tau = 0``.
        """
        moved = ((one, bool(one.operator) and one.operator != FULL_BLOCK) for one in self.classes)
        return tuple(Fraction(one.operator in DELAYS if whole else one.gains[0]) for one, whole in moved)

    @property
    def upper(self) -> tuple[Fraction, ...]:
        """Upper bounds of ``phi_i(sigma)/sigma``, which are finite."""
        return tuple(Fraction(one.gains[1]) for one in self.classes)

    @property
    def least(self) -> Fraction:
        """Of the factors beyond it each leaves every upper bound above the lower one."""
        if self.performance is not None:
            return Fraction(0)
        ends = [one.gains for one in self.classes if one.operator in ("", FULL_BLOCK)]
        return max(Fraction(0), *(Fraction(low) / Fraction(high) for low, high in ends if high > 0), Fraction(0))

    def scaled(self, alpha: Fraction) -> Diagonal:
        """The classes with every upper bound times ``alpha``; lower bounds stay.  Of a gain: that gain over ``alpha``.

        Parameters
        ----------
        alpha : Fraction
            The factor.
        """
        whole = self.performance is None
        scaled = tuple(one.scaled(alpha) if whole or one.operator == "performance" else one for one in self.classes)
        return Diagonal(scaled, repeated=self.repeated)

    def __str__(self) -> str:
        return in_channels([str(one) for one in self.classes], self.blocks)


def in_channels(words: Sequence[str], blocks: Iterable[Sequence[int]]) -> str:
    """What is said of ``phi`` in each channel, once for each nonlinearity: ``phi_1 ...; phi_2 = phi_3 ...``.

    ``words``: a text about ``phi`` for each channel; ``blocks``: the channels, counted from 0, of each nonlinearity.
    """
    if len(words) == 1:
        return words[0]
    same = {block[0]: [f"phi_{i + 1}" for i in block] for block in blocks}
    shown = {i: each if len(each) < 4 else [each[0], "...", each[-1]] for i, each in same.items()}
    names = {i: " = ".join(each) for i, each in shown.items()}
    together = {i for i in shown if "operator" in words[i] or "full-block" in words[i]}
    joint = {i for i in together if not words[i].startswith("scalar")}
    names |= {i: f"({', '.join(shown[i])})" for i in joint if len(shown[i]) > 1}
    return "; ".join(words[i].replace("phi", name, 1) for i, name in names.items())
