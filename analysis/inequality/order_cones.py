r"""Quadratic forms that are nonnegative on the graph of a monotone nonlinearity, searched for by cutting planes.

Let ``phi`` have ``phi(0) = 0`` and slopes in ``[0, k]``.  Of samples ``sigma_1 .. sigma_p`` let ``u_i = phi(sigma_i)``,
``v_i = k sigma_i - u_i``: both ascend with ``sigma_i``.  For each ordering of the samples and 0 the vectors ``(u, v)``
form a cone, the *order cone*, whose ``2 p`` extreme rays are steps: ``u`` (or ``v``) is 1 for the samples above a cut
that lies above 0, or -1 for those below a cut that lies below 0.  A form ``w^T M w``, ``w = (u, v)``, is nonnegative on
the graph of every such ``phi`` exactly if it is so on every order cone: each point of a cone lies on the graph of a
piecewise linear ``phi``.  For odd ``phi`` the steps are those of ``s_i sigma_i >= 0`` in ascending order, one cone for
each ordering and all signs ``s``.

Nothing here is believed; the forms found are decided in exact arithmetic by the checkers.
"""

from __future__ import annotations

import math
from functools import cached_property
from itertools import combinations

from lure.analysis.certificates.states import order_cones
from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np, optimize
from lure.record import described, quantity

_LEAST = 1e-7  # a smaller margin is none
_WORTH = 1e-5  # the least relative gain that is looked for
_CLOSED = 1e-6  # where the search for the largest slope ends, relative
_ROUNDS, _START, _FARTHEST = 60, 60, 1e9


@described()
class OrderCones:
    """The order cones of some samples, and the cuts found so far."""

    samples: int = quantity("Their number ``p``")
    odd: bool = quantity("Whether for odd nonlinearities")
    cuts: list[Reals] = quantity(
        "Points ``w`` of the cones, (2 p,) of length 1, at which forms are to be nonnegative", default_factory=list
    )

    @cached_property
    def rays(self) -> Reals:
        """(cones, 2 p, 2 p): the rays of each cone, as rows of length 1."""
        steps = np.array(list(order_cones(self.samples, self.odd)), dtype=float)
        both = np.zeros((len(steps), 2 * self.samples, 2 * self.samples))
        both[:, : self.samples, : self.samples] = both[:, self.samples :, self.samples :] = steps
        return np.asarray(both / np.linalg.norm(both, axis=2, keepdims=True))

    @cached_property
    def _faces(self) -> list[NDArray[np.intp]]:
        size = 2 * self.samples
        return [np.array(list(combinations(range(size), count))) for count in range(1, size + 1)]

    def least(self, M: Reals) -> tuple[float, list[Reals]]:
        """The least value of ``x^T (R M R^T) x``, ``|x| = 1``, ``x >= 0``, over the cones, and where cones have theirs.

        Where the least value on a cone is negative it is attained in the relative interior of a face, at an eigenvector
        of the principal submatrix without negative entries: all faces are looked at.

        ``M``: (2 p, 2 p), symmetric.
        """
        forms = self.rays @ M @ self.rays.transpose(0, 2, 1)
        least, where = np.full(len(forms), np.inf), np.zeros(forms.shape[:2])
        for faces in self._faces:
            values, vectors = np.linalg.eigh(forms[:, faces[:, :, None], faces[:, None, :]])
            x = vectors[..., 0] * np.where(vectors[..., 0].sum(-1) >= 0, 1, -1)[..., None]
            values = np.where((x >= -1e-9).all(-1), values[..., 0], np.inf)
            best = values.argmin(1)
            for cone in np.flatnonzero(values.min(1) < least):
                least[cone], where[cone] = values[cone, best[cone]], 0
                where[cone, faces[best[cone]]] = np.maximum(x[cone, best[cone]], 0)
        points = [self.rays[i].T @ where[i] for i in np.flatnonzero(least < np.inf)[np.argsort(least[least < np.inf])]]
        return float(least.min()), [w / np.linalg.norm(w) for w in points]


@described(frozen=True, slots=True)
class FormProposal:
    """A multiplier ``sum of free + sum_i weight_i (1 - sign_i z^-shift_i)`` and a form, in floating point."""

    free: float = quantity("Weight of 1")
    weights: Reals = quantity("(taps,) not negative")
    M: Reals = quantity("(2 T, 2 T), symmetric")


class FormSearch:
    """Cutting planes over taps and a form of consecutive samples, for one response.

    Parameters
    ----------
    omega : ndarray
        Frequencies [rad per sample].
    H : ndarray
        The response there.
    length : int
        Largest shift of a tap.
    cones : OrderCones
        Of the samples; the cuts found stay there.

    Attributes
    ----------
    taps : list of (int, int)
        Shifts and signs of the ``1 - sign z^-shift`` that have a weight.
    """

    def __init__(self, omega: Reals, H: NDArray[np.complex128], length: int, cones: OrderCones) -> None:
        known = np.isfinite(H)
        self.cones, self.H = cones, H[known]
        z, size = np.exp(1j * omega[known]), 2 * cones.samples
        self.unit = 1 / float(np.abs(self.H).max())
        self.taps = [(i, s) for i in range(-length, length + 1) if i for s in ((1, -1) if cones.odd else (1,))]
        self._multipliers = np.stack([np.ones(len(z), complex), *(1 - s * z**-i for i, s in self.taps)], axis=1)
        self._left, self._right = np.tril_indices(size)
        self._twice = np.where(self._left == self._right, 1.0, 2.0)
        shift = (self._right % cones.samples) - (self._left % cones.samples)
        self._powers = z[:, None] ** shift * self._twice
        self._active = {*range(0, len(z), max(1, len(z) // _START)), len(z) - 1}

    def farthest(self, low: float, high: float) -> tuple[FormProposal, float] | None:
        """What serves for the largest slope ``k`` found above ``low``, and ``k``; None if nothing serves above ``low``.

        ``low``, ``high``: where to look; ``high`` may be infinite.
        """
        best: FormProposal | None = None
        start, k = low, low * (1 + _WORTH) if low else min(self.unit, high / 2)
        while best is None or high - low > _CLOSED * high:
            checkpoint()
            found = self.serving(k)
            if found is not None:
                best, low = found, max(k, min(high, self._reached(found, k)))
            elif start and best is None:
                break
            else:
                high = k
            if not self.unit / _FARTHEST < k < self.unit * _FARTHEST:
                break
            k = 4 * low if math.isinf(high) else (low + high) / 2
        return None if best is None else (best, low)

    def serving(self, k: float) -> FormProposal | None:
        """Weights and a form that serve for the slope ``k`` with a margin; None if there are none."""
        rows, known, best = self._rows(k), None, -math.inf
        for _ in range(_ROUNDS):
            checkpoint()
            x, margin = self._programme(rows)
            if margin < _LEAST:
                return None
            x = x if known is None else (x + known) / 2
            found, values = self._proposal(x), rows @ x
            least, points = self.cones.least(found.M)
            worst = min(least, -float(values.max()))
            if worst > max(_LEAST, margin / 4):
                return found
            padded = np.concatenate([[-np.inf], values, [-np.inf]])
            peaks = (values >= padded[:-2]) & (values >= padded[2:]) & (values > -margin / 2)
            self._active |= set(np.flatnonzero(peaks).tolist())
            self.cones.cuts += [w for w in points if w @ found.M @ w < margin / 2]
            known, best = (x, worst) if worst > best else (known, best)
        return None

    def _rows(self, k: float) -> Reals:
        """``W^* M W - Re[m G]`` at the frequencies, over ``1 + |G|^2``: linear in the weights and ``M``."""
        G, T = (1 + k * self.H)[:, None], self.cones.samples
        left, right = np.where(self._left < T, 1, -G), np.where(self._right < T, 1, -G)
        both = np.hstack([-(self._multipliers * G).real, (left.conj() * right * self._powers).real])
        return np.asarray(both / (1 + np.abs(G) ** 2))

    def _reached(self, found: FormProposal, k: float) -> float:
        """The slope up to which the same weights and form serve at the frequencies: each row is quadratic in it."""
        x = np.concatenate([[found.free], found.weights, found.M[self._left, self._right]])
        at = [1.0, 1.5, 2.0]
        values = [(self._rows(s * k) @ x) * (1 + np.abs(1 + s * k * self.H) ** 2) for s in at]
        a, b, c = np.linalg.solve(np.vander(np.array(at) - 1, 3), np.array(values))
        with np.errstate(invalid="ignore", divide="ignore"):
            turn = np.sqrt(b * b - 4 * a * c)
            ends = 2 * c / np.array([-b - turn, -b + turn])
        return k * (1 + float(ends[np.isfinite(ends) & (ends > 0)].min(initial=3.0)))

    def _proposal(self, x: Reals) -> FormProposal:
        M = np.zeros((2 * self.cones.samples,) * 2)
        M[self._left, self._right] = M[self._right, self._left] = x[1 + len(self.taps) :]
        return FormProposal(float(x[0]), x[1 : 1 + len(self.taps)], M)

    def _programme(self, rows: Reals) -> tuple[Reals, float]:
        """The weights and ``M`` of the largest margin that the cuts leave, and that margin."""
        cuts = np.array(self.cones.cuts).reshape(-1, 2 * self.cones.samples)
        taps, entries = 1 + len(self.taps), len(self._left)
        least = -cuts[:, self._left] * cuts[:, self._right] * self._twice
        free = np.concatenate([[-1.0], np.zeros(taps + entries - 1)])
        A = np.vstack([rows[sorted(self._active)], np.hstack([np.zeros((len(cuts), taps)), least]), free])
        solved = optimize.linprog(
            np.append(np.zeros(taps + entries), -1.0),
            A_ub=np.column_stack([A, np.ones(len(A))]),
            b_ub=np.zeros(len(A)),
            bounds=[(0, 1)] * taps + [(-1, 1)] * entries + [(None, 1)],
            method="highs",
        )
        if solved.x is None:
            return np.zeros(taps + entries), 0.0
        return np.asarray(solved.x[:-1]), float(solved.x[-1])
