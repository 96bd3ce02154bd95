r"""A feedforward network as a controller: its neurons become the channels of a Lur'e loop.

A network computes ``u = N(y)`` by

.. math:: v_1 = W_1 y + b_1, \quad v_{k+1} = W_{k+1}\, \phi(v_k) + b_{k+1}, \quad u = \mathrm{sat}(v_{K}),

the saturation only where one is given.  Biases move the equilibrium, see :mod:`lure.networks.biased`.

With one channel for each neuron, ``sigma = v`` and ``mu = -phi(sigma)``, its
layers are the blocks ``-W_{k+1}`` of the feedthrough ``D`` below the diagonal, so that ``sigma`` is given channel after
channel and the loop is well posed whatever the weights are (Yin, Seiler, Arcak 2022; Kim, Patron, Braatz 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.nonlinearities.base import Nonlinearity, positive
from lure.nonlinearities.reading import nonlinearity_from_table
from lure.plants.multivariable import MOST_CHANNELS, MultivariablePlant, counted
from lure.plants.rational import RationalPlant
from lure.plants.text import exact_coefficient
from lure.record import Record, quantity

Rows = tuple[tuple[Fraction, ...], ...]
ACTIVATIONS = ("tanh", "relu", "leaky relu", "saturation")
"""What a neuron may do."""


class Network(Record):
    """A network ``u = N(y)``, all neurons of its hidden layers alike.

    Raises
    ------
    InputError
        There is no hidden layer, the sizes of two layers or a bias do not fit, the activation is unknown, or a
        number is none.

    Examples
    --------
    >>> network = Network.given([[[1, 2], [0, 1]], [[1, -1]]], activation="tanh", saturation=1)
    >>> print(network)
    2 inputs, 2 neurons (tanh) in 1 layer, 1 output, saturated at 1
    >>> network([0.5, 0.0])
    array([0.46211716])
    """

    weights: tuple[Rows, ...] = quantity(
        "``W_1`` to ``W_K``, exactly, each with a row for each of its outputs", label=""
    )
    activation: str = quantity("of the hidden layers")
    negative_slope: Fraction | None = quantity("of a leaky ReLU", default=None)
    saturation: Fraction | None = quantity("limit of every output, None if there is none", default=None)
    biases: Rows = quantity("``b_1`` to ``b_K``, exactly; empty if all are 0", label="", default=())
    _kind, _said = "network", "text"

    def __post_init__(self) -> None:
        if self.activation not in ACTIVATIONS:
            raise InputError(f"the activation is {self.activation!r:.40}; choose from {', '.join(ACTIVATIONS)}")
        if (self.activation == "leaky relu") != (self.negative_slope is not None):
            raise InputError("negative_slope goes with the activation 'leaky relu', and with no other")
        if len(self.weights) < 2:
            raise InputError(
                f"the network has {counted(len(self.weights), 'layer')}; give two at least, of which the last is linear"
            )
        for k, (before, after) in enumerate(pairwise(self.weights), 1):
            if len(after[0]) != len(before):
                raise InputError(
                    f"layer {k + 1} of the network has {counted(len(after[0]), 'input')}, and layer {k} "
                    f"{counted(len(before), 'output')}; give a row for each neuron and a column for each before it"
                )
        for k, (rows, bias) in enumerate(zip(self.weights, self.biases, strict=False), 1):
            if len(bias) != len(rows):
                raise InputError(
                    f"layer {k} of the network has {counted(len(rows), 'output')} and biases of length {len(bias)}; "
                    "give one for each"
                )
        if self.biases and len(self.biases) != len(self.weights):
            raise InputError(
                f"biases are given of {counted(len(self.biases), 'layer')} of {len(self.weights)}; give all, or none"
            )

    @classmethod
    def given(
        cls,
        weights: Sequence[Any],
        biases: Sequence[Any] = (),
        *,
        activation: str,
        negative_slope: object = None,
        saturation: object = None,
    ) -> Network:
        """The network of nested lists or arrays of numbers; a float means the double it is, a text the decimal it says.

        Parameters
        ----------
        weights : sequence of matrices
            ``W_1`` to ``W_K``, each with a row for each of its outputs.
        biases : sequence of vectors
            Of the layers, one for each output; empty if there are none.
        activation : str
            ``tanh``, ``relu``, ``leaky relu`` or ``saturation``, which is ``max(-1, min(1, v))``.
        negative_slope : number or None
            Of a leaky ReLU, below 0.
        saturation : number or None
            Limit of every output, positive.

        Raises
        ------
        InputError
            As for the class.
        """
        layers = tuple(_matrix(rows, f"layer {k} of the network") for k, rows in enumerate(weights, 1))
        shifts = list[tuple[Fraction, ...]]()
        for k, bias in enumerate(biases, 1):
            entries = bias.tolist() if hasattr(bias, "tolist") else bias
            shifts.append(tuple(exact_coefficient(v, f"the bias of layer {k}") for v in entries))
        slope = None if negative_slope is None else exact_coefficient(negative_slope, "negative_slope")
        limit = None if saturation is None else positive(exact_coefficient(saturation, "saturation"), "saturation")
        word = " ".join(str(activation).lower().replace("_", " ").replace("-", " ").split())
        word = {"leakyrelu": "leaky relu", "sat": "saturation"}.get(word, word)
        moved = tuple(shifts) if any(map(any, shifts)) else ()
        return cls(weights=layers, activation=word, negative_slope=slope, saturation=limit, biases=moved)

    @property
    def inputs(self) -> int:
        """Length of ``y``."""
        return len(self.weights[0][0])

    @property
    def outputs(self) -> int:
        """Length of ``u``."""
        return len(self.weights[-1])

    @property
    def neurons(self) -> int:
        """How many there are in the hidden layers."""
        return sum(map(len, self.weights[:-1]))

    @property
    def tables(self) -> list[dict[str, Any]]:
        """The nonlinearities of its channels as the tables ``[[nonlinearity]]`` of a file."""
        kinds: dict[str, dict[str, Any]] = {
            "tanh": {"kind": "tanh"},
            "relu": {"kind": "relu"},
            "leaky relu": {"kind": "leaky relu", "negative_slope": self.negative_slope},
            "saturation": {"kind": "saturation", "gain": Fraction(1), "limit": Fraction(1)},
        }
        found = [{**kinds[self.activation], "repeated": self.neurons}]
        if self.saturation is not None:
            last = {"kind": "saturation", "gain": Fraction(1), "limit": self.saturation}
            found.append(last if self.outputs == 1 else {**last, "repeated": self.outputs})
        return found

    def nonlinearities(self) -> list[Nonlinearity]:
        """Those of its channels, in order: the neurons, then the saturations of the outputs."""
        found = list[Nonlinearity]()
        for table in self.tables:
            rest = {key: value for key, value in table.items() if key not in ("kind", "repeated")}
            found += [nonlinearity_from_table(table["kind"], rest)] * table.get("repeated", 1)
        return found

    def offsets(self, plant: MultivariablePlant | RationalPlant) -> tuple[list[Fraction], list[Fraction]]:
        """What the biases add to ``x'``, or ``x+``, and to each ``sigma_i`` of the loop :meth:`closed`.

        Parameters
        ----------
        plant : MultivariablePlant or RationalPlant
            As there.
        """
        plant = _channels(plant)
        own, zero = plant.inputs - self.outputs, Fraction(0)
        *hidden, last = self.biases or [(zero,) * len(rows) for rows in self.weights]
        layers = [v for bias in hidden for v in bias]
        if self.saturation is not None:
            return [zero] * plant.order, [*[zero] * own, *layers, *last]
        sides = [[_dot(row[own:], last) for row in side] for side in (plant.B, plant.D[:own])]
        return sides[0], [*sides[1], *layers]

    def closed(self, plant: MultivariablePlant | RationalPlant) -> MultivariablePlant:
        """The linear part of the loop ``u = N(y)`` around a plant, its neurons behind the plant's own channels.

        Biases are no part of it: see :func:`lure.networks.equilibrium`.

        Parameters
        ----------
        plant : MultivariablePlant or RationalPlant
            With ``u`` as its last inputs and ``y`` as its last outputs; what is before them are channels ``mu_i =
            -phi_i(sigma_i)`` of its own.

        Raises
        ------
        InputError
            It has fewer inputs or outputs than the network, ``y`` depends on ``u`` at once, or there are too many
            channels.
        """
        plant = _channels(plant)
        own, m = plant.inputs - self.outputs, self.neurons + (self.outputs if self.saturation is not None else 0)
        if own < 0 or plant.outputs - self.inputs != own:
            raise InputError(
                f"the plant has {plant.size}, and the network {counted(self.inputs, 'input')} and "
                f"{counted(self.outputs, 'output')}; the plant's channels come before those, as many of both"
            )
        if any(any(row[own:]) for row in plant.D[own:]):
            raise InputError("what the network measures depends at once on what it puts out; give D = 0 between them")
        if own + m > MOST_CHANNELS:
            raise InputError(
                f"the loop has {own + m} channels, one for each neuron and limit; {MOST_CHANNELS} are the most"
            )
        zero = Fraction(0)
        last, back = self.weights[-1], len(self.weights[-2])  # u = W_K phi, or u_j = sat(W_K phi)
        first = self.weights[0]

        def inward(row: Sequence[Fraction]) -> tuple[Fraction, ...]:
            """What ``mu`` does in a row of ``B`` or ``D`` whose last entries are those of ``u``."""
            mine, own_u = row[:own], row[own:]
            if self.saturation is not None:
                return (*mine, *[zero] * self.neurons, *(-v for v in own_u))
            through = (-_dot(own_u, [w[j] for w in last]) for j in range(back))
            return (*mine, *[zero] * (self.neurons - back), *through)

        D = [list(inward(row)) for row in plant.D[:own]]
        D += [[*(_dot(w, [row[j] for row in plant.D[own:]]) for j in range(own)), *[zero] * m] for w in first]
        at = own
        for before, rows in pairwise(self.weights if self.saturation is not None else self.weights[:-1]):
            D += [[*[zero] * at, *(-v for v in row), *[zero] * (own + m - at - len(before))] for row in rows]
            at += len(before)
        seen = [tuple(_dot(w, [row[j] for row in plant.C[own:]]) for j in range(plant.order)) for w in first]
        rest = [(zero,) * plant.order] * (m - len(first))
        return replace(
            plant,
            B=tuple(map(inward, plant.B)),
            C=(*plant.C[:own], *seen, *rest),
            D=tuple(map(tuple, D)),
            names=(),
        )

    def __call__(self, y: ArrayLike) -> NDArray[np.float64]:
        """``N(y)`` in floating point; the last axis of ``y`` has its entries."""
        values, phi = np.asarray(y, dtype=float), self.nonlinearities()
        biases = [np.array(bias, dtype=float) for bias in self.biases] or [np.zeros(1)] * len(self.weights)
        for rows, bias in zip(self.weights[:-1], biases, strict=False):
            values = phi[0](values @ np.array(rows, dtype=float).T + bias)
        values = values @ np.array(self.weights[-1], dtype=float).T + biases[-1]
        return np.asarray(values if self.saturation is None else phi[-1](values))

    def __str__(self) -> str:
        said = f"{counted(self.inputs, 'input')}, {counted(self.neurons, 'neuron')} ({self.activation}) in "
        said += f"{counted(len(self.weights) - 1, 'layer')}, {counted(self.outputs, 'output')}"
        return said if self.saturation is None else f"{said}, saturated at {float(self.saturation):g}"


def _channels(plant: MultivariablePlant | RationalPlant) -> MultivariablePlant:
    """The plant, one of one channel in the form of several."""
    return MultivariablePlant.of_one_channel(plant) if isinstance(plant, RationalPlant) else plant


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), Fraction(0))


def _matrix(given: Any, name: str) -> Rows:  # noqa: ANN401  (nested lists or an array)
    rows = given.tolist() if hasattr(given, "tolist") else given
    listed = isinstance(rows, list | tuple) and rows and all(isinstance(row, list | tuple) and row for row in rows)
    if not listed or len({len(row) for row in rows}) > 1:
        raise InputError(f"{name} is {rows!r:.60}; give rows of numbers of equal length, one for each neuron")
    return tuple(
        tuple(exact_coefficient(v, f"{name}, row {i}, column {j}") for j, v in enumerate(row, 1))
        for i, row in enumerate(rows, 1)
    )
