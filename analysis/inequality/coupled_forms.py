r"""Forms that couple channels and samples, in floating point: one semidefinite programme in ``P`` and the forms.

For ``phi = l sigma + psi`` let ``u = psi`` and ``v = w sigma - psi`` of ``T`` samples (in continuous time one) of some
channels.  The forms ``M`` in ``(u, v)`` are those that the checkers take (``lure.analysis.certificates.windows``):

ReLU: ``u >= 0 >= v``, ``u_k v_k = 0``, so that the entries of ``M`` have the sign of the product, and those of ``u_k
v_k`` either sign.  One nonlinearity in all channels, slopes in ``[0, w]``: ``2 u'Q v``, ``Q`` doubly hyperdominant, for
odd ones doubly dominant.  Slopes bounded on one side, ``l`` or ``h`` of the sector: ``2 u'Q (u + v)``, or ``2 v'Q (u +
v)``, which contains Tsypkin's and the Jury-Lee criterion.  A sector: ``sum q_k u_k v_k``, ``q_k >= 0``.  An operator of
norm ``w``: ``lambda (w^2 |sigma|^2 - |psi|^2)`` of the last sample, which is nonnegative summed up to any time.

With ReLUs, and with one sample, ``V`` is bounded from below, by forms of ``T - 1`` samples; entries between later
samples alone are of no use then, as moving them to earlier ones changes ``V`` by what these forms hold.  Without ReLUs
``P`` has either sign, and ``Q`` has to be dominant only summed over time: Zames and Falb's multipliers with ``T - 1``
taps on each side.  With a ``rate`` the loop is that of the solutions times ``r^-t``, and sums and Popov's terms are
weighed (docs/theory/rates.md).  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, ClassVar, Literal, NamedTuple, TypeVar

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.analysis.numerics.doubles import decimals, matrix_proof
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, linalg, np
from lure.record import described, quantity

Kind = Literal["relu", "monotone", "odd", "sector", "operator", "rising", "odd rising", "falling", "odd falling"]
Samples = TypeVar("Samples", bound="NDArray[Any]")
MOST_UNKNOWNS, MOST_ROWS = 1500, 60
_SURE, _LARGEST, _LARGEST_THETA, _BITS, _SMALL = 1e-7, 100.0, 1e4, 56, 1e-12


class Group(NamedTuple):
    """Channels whose samples one form is about."""

    kind: Kind
    channels: tuple[int, ...]

    def sides(self, u: Samples, v: Samples) -> tuple[Samples, Samples]:
        """What the products of the form are of; ``u``, ``v``: the samples."""
        return (v, u + v) if "falling" in self.kind else (u, u + v) if "rising" in self.kind else (u, v)


class Entry(NamedTuple):
    """An unknown of a form: ``sign`` times it stands in ``M`` at a place; it is nonnegative unless ``free``."""

    row: int
    column: int
    sign: int
    free: bool = False


class Cone(NamedTuple):
    """The entries of one form, and of which of them the signed sums have to be nonnegative."""

    entries: list[Entry]
    sums: list[dict[int, Fraction]]

    def rounded(self, found: Reals) -> list[Fraction]:
        """Unknowns of about 12 digits of which signs and sums hold exactly.

        ``found``: (entries,).
        """
        both = zip(found, self.entries, strict=True)
        values = [Fraction(f"{v if e.free else max(v, 0.0):.12g}") for v, e in both]
        for terms in self.sums:
            own = next(k for k, factor in terms.items() if factor > 0)
            lacking = -sum(values[k] * factor for k, factor in terms.items()) / terms[own]
            values[own] += max(Fraction(0), lacking)
        return values


def cone_of(  # noqa: PLR0913  (a form, and how it is summed)
    kind: Kind, width: int, samples: int, *, summed: bool, first: bool, rate: Fraction = Fraction(1)
) -> Cone:
    """What a form of so many channels and samples may hold.

    Parameters
    ----------
    kind : {"relu", "monotone", "odd", "sector", "operator", "rising", "odd rising", "falling", "odd falling"}
        The kind of form; of an operator there is one unknown, its weight.
    width, samples : int
        Numbers of channels and of samples.
    summed : bool
        Whether the form has to be nonnegative over all time only.
    first : bool
        Whether entries without the first sample are left out, as they change nothing.
    rate : Fraction
        The samples are those at the time ``t`` times ``rate^-t``.
    """
    p = width * samples
    if kind == "operator":
        return Cone([Entry(0, 0, 1)], [])

    def used(*places: int) -> bool:
        """Whether an entry of these places is kept."""
        return not first or min((place % p) // width for place in places) == 0

    if kind == "relu":
        pairs = ((i, j) for i in range(2 * p) for j in range(i + 1) if used(i, j))
        return Cone([Entry(i, j, 1 if (i < p) == (j < p) else -1, i == j + p) for i, j in pairs], [])
    if kind == "sector":
        return Cone([Entry(p + k, k, 1) for k in range(p) if used(k)], [])
    entries, rows, columns = list[Entry](), dict[int, dict[int, Fraction]](), dict[int, dict[int, Fraction]]()
    fold = width if summed else p
    for k in range(p):
        for j in (j for j in range(p) if not summed or used(k, j)):
            for sign in (1,) if k == j else (-1, 1) if "odd" in kind else (-1,):
                a, b = k // width, j // width
                weights = (rate ** (a - b), rate ** (b - a)) if summed else (rate ** (-a - b),) * 2
                for sums, at, weight in zip((rows, columns), (k, j), weights, strict=True):
                    sums.setdefault(at % fold, {})[len(entries)] = weight if k == j else -weight
                entries.append(Entry(p + j, k, sign))
    return Cone(entries, [*rows.values(), *columns.values()])


class Solved(NamedTuple):
    """A solution of the programme: ``P``, the unknowns of the forms and of those at the start, ``theta``."""

    P: NDArray[np.float64]
    forms: list[NDArray[np.float64]]
    start: list[NDArray[np.float64]]
    theta: NDArray[np.float64]


@described()
class CoupledForms(ChannelSearch):
    """The search for one plant and lower bounds; the others: see :class:`ChannelSearch`."""

    groups: Sequence[Group] = quantity("Each channel stands in one")
    samples: int = quantity("Number ``T``; one in continuous time")
    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    popov: bool = quantity("Whether a certificate states ``theta``")
    discrete: bool = quantity("Whether in discrete time")
    rate: Fraction | None = quantity(
        "The loop is that of the solutions times ``rate^-t``, or ``e^(rate t)``", default=None
    )
    sloped: Sequence[bool] = quantity(
        "With a rate: in which channels the slopes are in the bounds of the sector", default=()
    )
    precision: ClassVar[float] = 1e-6

    def __post_init__(self) -> None:
        n, T = len(self.A), self.samples
        self.bounded = T == 1 or any(group.kind == "relu" for group in self.groups)
        summed, sizes = not self.bounded, [len(group.channels) for group in self.groups]
        rate = self.rate if self.discrete and self.rate is not None else Fraction(1)
        self.cones = [
            cone_of(group.kind, size, T, summed=summed, first=T > 1, rate=rate)
            for group, size in zip(self.groups, sizes, strict=True)
        ]
        self.starts = [
            Cone([], [])
            if group.kind == "operator"
            else cone_of(group.kind, size, T - 1, summed=False, first=False, rate=rate)
            for group, size in zip(self.groups, sizes, strict=True)
            if self.bounded and T > 1
        ]
        self.order = n + len(self.D) * (T - 1)
        self.unit = float(np.abs(np.linalg.eigvals(self.A)).max(initial=0.0) or 1.0) ** -1

    @property
    def possible(self) -> bool:
        """Whether the programme is small enough to be solved in seconds."""
        unknowns = self.order * (self.order + 1) // 2 + sum(len(cone.entries) for cone in (*self.cones, *self.starts))
        return unknowns <= MOST_UNKNOWNS and self.order + len(self.D) <= MOST_ROWS

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme finds forms; see :meth:`solved`."""
        return self.solved(widths) is not None

    def scales(self, widths: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Units of the states and of ``phi``, by which the solutions are about as large as the inputs."""
        top = np.maximum(np.abs(self.lower), np.abs(self.lower + widths))
        closed = np.linalg.solve(np.eye(len(self.D)) + self.D * self.lower, self.C)
        A, B = self.A - (self.B * self.lower) @ closed, self.B * top
        try:
            with np.errstate(all="ignore"), warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # of a pole at 0; these are units, and no more
                W = (
                    linalg.solve_discrete_lyapunov(A, B @ B.T)
                    if self.discrete
                    else linalg.solve_continuous_lyapunov(A, -B @ B.T)
                )
        except (np.linalg.LinAlgError, ValueError):
            W = np.eye(len(A))
        sizes = np.abs(np.diag(W))
        usable = bool(np.isfinite(sizes).all() and sizes.max() > 0)
        return np.sqrt(np.maximum(sizes, 1e-8 * sizes.max())) if usable else np.ones(len(A)), top

    def solved(self, widths: NDArray[np.float64]) -> Solved | None:
        """``P`` and forms with a margin that is more than rounding; None if there are none, or too many unknowns.

        Nor are there any where numbers leave the doubles.

        ``widths``: (m,) upper bounds less lower ones.
        """
        try:
            with np.errstate(over="raise", invalid="raise"):
                return self._solved(widths) if self.possible else None
        except FloatingPointError:
            return None

    def _solved(self, widths: NDArray[np.float64]) -> Solved | None:
        checkpoint()
        n, m, T, order = len(self.A), len(self.D), self.samples, self.order
        units, top = self.scales(widths)
        size = np.concatenate([units, *[top] * T])
        A, C = self.A * units / units[:, None], self.C * units
        B, phi = self.B / units[:, None], np.eye(n + m * T)[n:] * size
        x, sigma, states = np.eye(n, n + m * T), list[Reals](), list[Reals]()
        for t in range(T):
            at = phi[m * t : m * (t + 1)]
            sigma.append(C @ x - self.D @ at)
            x = A @ x - B @ at
            states.append(x)
        seen, low = np.vstack(sigma), np.tile(self.lower, T)[:, None]
        u, v = phi - low * seen, (low + np.tile(widths, T)[:, None]) * seen - phi
        now, basis = np.eye(order, n + m * T), symmetric_basis(order)
        if self.discrete:
            later = np.vstack([states[0], np.eye(n + m * T)[n + m :]])
            falls = now.T @ basis @ now - later.T @ basis @ later
        else:
            falls = -(now.T @ basis @ states[0] + states[0].T @ basis @ now)
        turning = [-np.outer(phi[i], C[i] @ states[0]) * self.unit for i in range(m) if self.free[i]]
        turns = np.array([sign * (t + t.T) for t in turning for sign in (1, -1)]).reshape(-1, n + m * T, n + m * T)
        if self.rate and len(turns):
            turns -= self._growing(u, v, widths)
        unit = float(top.max()) or 1.0  # of u, v and of phi sigma'
        turns, u, v = turns / unit, u / unit, v / unit
        parts = [falls, *(-self._products(g, c, u, v, T) for g, c in zip(self.groups, self.cones, strict=True)), turns]
        begun = [
            -self._products(g, c, u, v, T - 1)[:, :order, :order]
            for g, c in zip(self.groups, self.starts or [Cone([], [])] * len(self.groups), strict=True)
        ]
        counts = [*map(len, parts), *map(len, begun), 1]
        places = np.concatenate([[0], np.cumsum(counts)])
        total, spare = int(places[-1]), len(parts)
        first, second = np.zeros((total, n + m * T, n + m * T)), np.zeros((total, order, order))
        first[: places[spare]] = np.concatenate(parts)
        first[-1] = -np.eye(n + m * T)
        second[: len(basis)] = basis
        second[places[spare] : places[-2]] = np.concatenate(begun)
        second[-1] = -np.eye(order)
        ends = [(self.lower[i], self.lower[i] + widths[i]) for i in range(m) if self.free[i]]
        rows = [C[i] for i in range(m) if self.free[i]]
        for k, ((below, above), c) in enumerate(zip(ends, rows, strict=True)):
            for sign, end in ((0, below), (1, -above)):
                second[places[spare - 1] + 2 * k + sign] = end * np.outer(c, c) * self.unit / unit
        limits = self._limits(places, total)
        blocks = [Block(np.zeros(first.shape[1:]), first)]
        blocks += [Block(np.zeros(second.shape[1:]), second)] * self.bounded
        cost = np.zeros(total)
        cost[-1] = 1.0
        found = proposed(cost, blocks, *limits)
        if found is None or found[-1] <= _SURE:
            return None
        each = [found[a:b] for a, b in pairwise(places)]
        each = [each[0], *(one / unit**2 for one in each[1:-1]), each[-1]]
        each[spare - 1] *= unit
        whole = np.tensordot(each[0], basis, 1) / size[:order] / size[:order, None]
        theta, turned = np.zeros(m), each[spare - 1]
        theta[[i for i in range(m) if self.free[i]]] = (turned[::2] - turned[1::2]) * self.unit
        forms = each[1 : spare - 1]
        self._unturned(forms, turned, widths)
        return Solved(whole, forms, each[spare:-1][: len(self.starts)], theta)

    def _unturned(self, forms: Sequence[Reals], turned: Reals, widths: Reals) -> None:
        """What ``theta_i`` of both signs adds to ``V'`` with bounded slopes, ``psi (w sigma - psi)``, as a form."""
        if not self.rate:
            return
        for i, both in zip(
            (i for i, free in enumerate(self.free) if free), turned.reshape(-1, 2).min(axis=1), strict=True
        ):
            for group, cone, x in zip(self.groups, self.cones, forms, strict=True):
                if self.sloped[i] and i in group.channels:
                    k, width = list(group.channels).index(i), len(group.channels)
                    at = next(j for j, one in enumerate(cone.entries) if (one.row, one.column) == (width + k, k))
                    x[at] += 2 * both * abs(float(self.rate)) * self.unit / widths[i]

    def _growing(
        self, u: NDArray[np.float64], v: NDArray[np.float64], widths: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """What a rate adds to ``V'`` at most for ``theta_i = 1`` and ``-1``, one after the other, in units of time."""
        found = list[Reals]()
        for i in (i for i, free in enumerate(self.free) if free):
            for turn in (float(self.rate or 0), -float(self.rate or 0)):  # psi, w sigma, w sigma - psi: u, u + v, v
                one = u[i] if self.sloped[i] or turn < 0 else u[i] + v[i]
                other = u[i] + v[i] if turn < 0 and not self.sloped[i] else v[i]
                product = np.outer(one, other) * abs(turn) * self.unit / widths[i]
                found.append(product + product.T)
        return np.array(found)

    def _products(
        self, group: Group, cone: Cone, u: NDArray[np.float64], v: NDArray[np.float64], samples: int
    ) -> NDArray[np.float64]:
        """The form of each entry, in the coordinates of the rows of ``u`` and ``v``."""
        m = len(self.D)
        if group.kind == "operator":
            last = [m * (samples - 1) + i for i in group.channels]
            both = u[last] + v[last]  # w sigma
            return np.asarray(both.T @ both - u[last].T @ u[last])[None][: len(cone.entries)]
        places = [m * t + i for t in range(samples) for i in group.channels]
        w = np.concatenate(group.sides(u[places], v[places]))
        found = np.zeros((len(cone.entries), w.shape[1], w.shape[1]))
        for k, one in enumerate(cone.entries):
            product = one.sign * np.outer(w[one.row], w[one.column])
            found[k] = product if one.row == one.column else product + product.T
        return found

    def _limits(self, places: NDArray[np.intp], total: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Signs, sums and sizes of the unknowns, as rows and what these are at most."""
        limits = Limits(total)
        cones = [*zip(self.cones, places[1:], strict=False)]
        cones += [*zip(self.starts, places[2 + len(self.cones) :], strict=False)]
        for cone, at in cones:
            for k, entry in enumerate(cone.entries):
                limits.at_most({at + k: 1.0}, _LARGEST)
                limits.at_most({at + k: -1.0}, _LARGEST if entry.free else 0.0)
            for terms in cone.sums:
                limits.at_most({at + k: -float(factor) for k, factor in terms.items()}, 0.0)
        for k in range(places[1 + len(self.cones)], places[2 + len(self.cones)]):
            limits.at_most({k: 1.0}, _LARGEST_THETA)
            limits.at_most({k: -1.0}, 0.0)
        limits.at_most({total - 1: 1.0}, _LARGEST)
        return limits.arrays()

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded."""
        found = self.solved(np.array([float(w) for w in widths]))
        if found is None:
            return
        stated = [cone.rounded(x) for cone, x in zip(self.cones, found.forms, strict=True)]
        begun = [cone.rounded(x) for cone, x in zip(self.starts, found.start, strict=True)]
        multiplier: dict[str, Any] = {"forms": self.stated(self.cones, stated, self.samples)}
        weights = [Fraction(0)] * len(self.D)
        for group, x in zip(self.groups, found.forms, strict=True):
            for i in group.channels if group.kind == "operator" else ():
                weights[i] = Fraction(f"{max(float(x[0]), 0.0):.12g}") / (1 + (self.samples == 1))  # there of twice it
        if any(group.kind == "operator" for group in self.groups):
            multiplier["lambda"] = [str(v) for v in weights]
        if self.samples > 1:
            start = self.stated(self.starts, begun, self.samples - 1) if self.bounded else None
            multiplier |= {"samples": self.samples, "start": start}
        elif self.popov:
            multiplier["theta"] = [*map(str, decimals(found.theta))]
        sizes = np.abs(np.diag(found.P))
        yield Proposal(multiplier, matrix_proof(found.P, float(max(sizes.min(), sizes.max() * _SMALL)), _BITS))

    def stated(
        self, cones: Sequence[Cone], found: Sequence[Sequence[Fraction]], samples: int
    ) -> list[Mapping[str, Any]]:
        """The forms as a certificate has them.

        ``cones``: of each group; ``found``: the unknowns of each; ``samples``: of each channel.
        """
        stated = list[Mapping[str, Any]]()
        for group, cone, values in zip(self.groups, cones, found, strict=True):
            if group.kind == "operator":
                continue
            p = samples * len(group.channels)
            M = [[Fraction(0)] * 2 * p for _ in range(2 * p)]
            for value, one in zip(values, cone.entries, strict=True):
                M[one.row][one.column] += one.sign * value
            rows = [row[: i + 1] for i, row in enumerate(M)]
            if group.kind != "relu":
                rows = [[M[p + j][k] for j in range(p)] for k in range(p)]
            texts = [[str(v) for v in row] for row in rows]
            stated.append({"kind": group.kind, "channels": [i + 1 for i in group.channels], "rows": texts})
        return stated
