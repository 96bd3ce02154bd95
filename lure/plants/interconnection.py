"""The channels of a larger plant that nonlinearities close, by the names of its inputs and outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Literal, cast

from lure.errors import InputError, did_you_mean
from lure.plants.conversion import as_plant
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant

Place = str | int
Pair = tuple[Place, Place]


def padded(plant: MultivariablePlant, sizes: Sequence[tuple[int, int]]) -> MultivariablePlant:
    """The plant with inputs that do nothing and outputs that are 0, so that each block has as many of both.

    ``sizes``: inputs and outputs of each block, in order.

    Raises
    ------
    InputError
        The sizes do not add up to the inputs and outputs of the plant.
    """
    totals = tuple(sum(size[side] for size in sizes) for side in (0, 1))
    if totals != (plant.inputs, plant.outputs):
        raise InputError(
            f"the blocks have {totals[0]} inputs and {totals[1]} outputs together, and the plant has {plant.size}; "
            "give as many"
        )
    if all(ins == outs for ins, outs in sizes):
        return plant
    places: list[list[int | None]] = [[], []]  # which input and output stands where, None for a new one
    for size in sizes:
        for found, own in zip(places, size, strict=True):
            start = sum(at is not None for at in found)
            found += [*range(start, start + own), *[None] * (max(size) - own)]
    columns, rows = places
    zero = Fraction(0)

    def across(row: Sequence[Fraction]) -> tuple[Fraction, ...]:
        """A row of ``B`` or ``D``."""
        return tuple(zero if j is None else row[j] for j in columns)

    return replace(
        plant,
        B=tuple(across(row) for row in plant.B),
        C=tuple((zero,) * plant.order if i is None else plant.C[i] for i in rows),
        D=tuple((zero,) * len(columns) if i is None else across(plant.D[i]) for i in rows),
        names=(),
    )


def lft(  # noqa: PLR0913  (a plant, its channels, and how its sides are called)
    plant: object,
    channels: Mapping[str, Pair] | Sequence[Pair],
    *,
    feedback: Literal["negative", "positive"] = "negative",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    dt: object = None,
) -> MultivariablePlant | RationalPlant | DelayMatrix | DelayPlant:
    r"""The part ``sigma = H mu`` of a larger plant that nonlinearities close, one in each of the named channels.

    Channel ``i`` leads from the output ``sigma_i`` through ``phi_i`` to an input, ``mu_i = -phi_i(sigma_i)``; what the
    other inputs (references, disturbances) and outputs (measurements) do is another question, and stability does not
    depend on it.  All states stay, those too that the channels do not reach or see.

    Parameters
    ----------
    plant : object
        Whatever :func:`lure.as_plant` takes; a system of python-control, such as ``control.interconnect`` makes, brings
        the names of its inputs and outputs.
    channels : mapping or sequence
        ``{"valve": ("position", "force"), ...}`` or ``[("position", "force"), ...]``: for each channel the output that
        is its ``sigma`` and the input that its ``mu`` enters, by name or counted from 0.
    feedback : {"negative", "positive"}
        ``positive`` for models in which ``+phi(sigma)`` enters the input: then ``H`` gets the other sign.
    inputs, outputs : sequence of str, optional
        Names for a plant that brings none.
    dt : None, 0, True or number
        As for :func:`lure.as_plant`.

    Returns
    -------
    MultivariablePlant, RationalPlant, DelayMatrix or DelayPlant
        The second and the last for one channel, unless states come back late; the last two where there is dead time.
        ``names`` are those of the channels, in order; classes may be given by name.

    Raises
    ------
    InputError
        There is no such input or output, there are no channels, or the plant is not rational.

    Examples
    --------
    >>> import control
    >>> G = control.ss([[-1, 0], [1, -2]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], 0, inputs=["u", "d"], outputs=["x", "y"])
    >>> print(lft(G, {"spring": ("y", "u")}))
    1 / (s^2 + 3 s + 2)
    >>> print(lft(G, {"spring": ("y", "u"), "valve": ("x", "d")}).names)
    ('spring', 'valve')
    """
    found = as_plant(plant, dt=dt)
    if isinstance(found, RationalPlant):
        found = MultivariablePlant.of_one_channel(found)
    late, inner, rates = (found.late, found.inner, found.rates) if isinstance(found, DelayMatrix) else ((), (), ())
    found = found.base if isinstance(found, DelayMatrix) else found
    if not isinstance(found, MultivariablePlant):
        raise InputError(f"lft needs a plant with exact entries and channels, and this is a {type(found).__name__}")
    if feedback not in ("negative", "positive"):
        raise InputError(f"feedback is {feedback!r:.40}; give 'negative' for mu = -phi(sigma), or 'positive'")
    names = tuple(map(str, channels)) if isinstance(channels, Mapping) else ()
    pairs = list(channels.values() if isinstance(channels, Mapping) else channels)
    if not pairs or any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in pairs):
        raise InputError("channels are pairs (output, input), one for each nonlinearity; give at least one")
    outs, ins = _labels(plant, outputs, "output", found.outputs), _labels(plant, inputs, "input", found.inputs)
    rows = [_place(pair[0], outs, "output") for pair in pairs]
    columns = [_place(pair[1], ins, "input") for pair in pairs]
    sign = 1 if feedback == "negative" else -1
    chosen = replace(
        found,
        B=tuple(tuple(sign * row[j] for j in columns) for row in found.B),
        C=tuple(found.C[i] for i in rows),
        D=tuple(tuple(sign * found.D[i][j] for j in columns) for i in rows),
        names=names,
    )
    moved = [(delay, tuple(side[i] for i in rows)) for delay, side in late]
    moved = moved if inner else [(delay, side) for delay, side in moved if any(map(any, side))]
    swift = tuple((tuple(side[i] for i in rows), E) for side, E in rates)
    whole = DelayMatrix(chosen, tuple(moved), inner, swift) if moved else chosen
    return whole.channel(0, 0) if len(pairs) == 1 and not inner else whole


def _labels(plant: object, given: Sequence[str] | None, word: str, number: int) -> list[str]:
    """Names of the inputs or outputs; their numbers where there are none."""
    own = given if given is not None else getattr(plant, f"{word}_labels", None)
    labels = list(map(str, cast("Sequence[object]", own))) if own else list(map(str, range(number)))
    if len(labels) != number or len(set(labels)) != number:
        raise InputError(f"{word}s are {labels}; the plant has {number}, give each a name of its own")
    return labels


def _place(name: Place, labels: Sequence[str], word: str) -> int:
    if isinstance(name, int) and not isinstance(name, bool) and 0 <= name < len(labels):
        return name
    if name in labels:
        return labels.index(str(name))
    raise InputError(
        f"there is no {word} {name!r:.40}; {did_you_mean(str(name), labels)}choose from {', '.join(labels)}"
    )
