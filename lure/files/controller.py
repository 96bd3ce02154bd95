"""The table ``[controller]`` of a file: a plant closed by a network, one channel for each neuron."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from lure.errors import InputError
from lure.files.schema import ControllerTable, PlantTable
from lure.files.system import LoopSystem, channel_system, nonlinearity_of, single
from lure.networks.biased import equilibrium
from lure.networks.network import Network
from lure.networks.reading import read_network
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.piecewise_linear import PiecewiseLinear
from lure.nonlinearities.shifted import MovedNonlinearity
from lure.plants.conversion import as_plant
from lure.plants.multivariable import MultivariablePlant, counted
from lure.plants.rational import RationalPlant

Table = Mapping[str, object]


def with_network(  # noqa: PLR0913  (a plant, what closes it, where it stands, and how both are read)
    identity: tuple[str, str, str],
    table: PlantTable,
    controller: ControllerTable,
    folder: Path,
    *,
    known: Sequence[Table],
    block_of: Callable[[PlantTable], object],
) -> LoopSystem:
    """The loop of a plant that a network closes: one channel for each neuron behind those of the plant.

    Parameters
    ----------
    identity : tuple of str
        Name, title and source.
    table : PlantTable
        The plant.
    controller : ControllerTable
        The network, and where it acts.
    folder : Path
        That of the file, from which the path of the network starts.
    known : sequence of mappings
        The tables of the plant's own nonlinearities.
    block_of : callable
        Makes a plant of its table.

    Raises
    ------
    InputError
        The network cannot be read, does not fit, or rests elsewhere than at 0 and ``origin`` does not say so.
    """
    told = {name: getattr(controller, name) for name in ("activation", "negative_slope", "saturation")}
    try:
        network = read_network(folder / controller.network, **told)
        opened = _opened(table, controller, network, block_of)
        if controller.origin not in (None, "equilibrium"):
            raise InputError(f"origin is {controller.origin!r:.40}; write 'equilibrium', or leave it out")
        if not network.biases:
            return channel_system(identity, network.closed(opened), nonlinearity_tables=[*known, *network.tables])
        each = [one for given in (*known, *network.tables) for one in single(given)]
        own = [nonlinearity_of(one) for one in each[: opened.inputs - network.outputs]]
        found = equilibrium(network, opened, own)
    except InputError as error:
        raise InputError(f"controller: {error}") from None
    name, title, source = identity
    where = f"({', '.join(f'{float(v):.6g}' for v in found.x)})"
    if any(found.x) and controller.origin is None:
        raise InputError(
            f"controller: with the biases of the network the loop rests at x = {where}; write origin = 'equilibrium', "
            "and x is counted from there, or train the network without biases"
        )
    moved = [_moved(one, phi) for one, phi in zip(each, found.nonlinearities, strict=True)]
    near = f", to within {float(found.within):.1e}" if found.within else ""
    title = f"{title}, x counted from {where}{near}" if any(found.x) else title
    return channel_system((name, title, source), found.plant, nonlinearity_tables=moved)


def _moved(table: Table, phi: Nonlinearity) -> Table:
    """The table of a nonlinearity around the equilibrium."""
    if isinstance(phi, MovedNonlinearity):
        return {**table, "at": phi.at, "within": phi.within}
    if not isinstance(phi, PiecewiseLinear):
        return table
    points = [list(point) for point in phi.points]
    return {"kind": "piecewise-linear", "points": points, "left_slope": phi.left_slope, "right_slope": phi.right_slope}


def _opened(
    table: PlantTable, controller: ControllerTable, network: Network, block_of: Callable[[PlantTable], object]
) -> MultivariablePlant:
    """The plant with ``u`` as last inputs and ``y`` as last outputs, behind its own channels."""
    if controller.Bu is None:
        if controller.Cy is not None:
            raise InputError("Cy is given without Bu; give how u moves the state too")
        if table.A is not None and table.B is None and table.C is None:
            raise InputError("Bu is missing; give how u moves the state, a row for each state")
        plant = block_of(table)
        if isinstance(plant, RationalPlant):
            plant = MultivariablePlant.of_one_channel(plant)
        if not isinstance(plant, MultivariablePlant):
            raise InputError("the plant of a network has exact rational entries; leave the dead time out")
        return plant
    if table.A is None or table.num is not None or table.transfer is not None:
        raise InputError("Bu is about the states, and the plant is given without; give it by A, and B and C")
    n, own = len(table.A), table.B is not None or table.C is not None
    Cy = controller.Cy if controller.Cy is not None else [[int(i == j) for j in range(n)] for i in range(n)]
    for name, side, high, wide in (("Bu", controller.Bu, n, network.outputs), ("Cy", Cy, network.inputs, n)):
        rows = side if isinstance(side[0], list) else [[v] for v in side] if name == "Bu" else [side]
        if len(rows) != high or any(len(row) != wide for row in rows):
            sizes = [(len(rows), "row"), (len(rows[0]), "number"), (n, "state"), (network.inputs, "input")]
            sizes += [(network.outputs, "output"), (high, "row"), (wide, "number")]
            has, of, states, taken, put, right, each = (counted(*size) for size in sizes)
            raise InputError(
                f"{name} has {has} of {of}; with {states} and a network of {taken} and {put} give {right} of {each}"
            )
    free = as_plant((table.A, controller.Bu, Cy, 0), dt=table.dt)
    found = MultivariablePlant.of_one_channel(free) if isinstance(free, RationalPlant) else free
    assert isinstance(found, MultivariablePlant), "matrices make no other plant"
    if not own:
        return found
    block = block_of(table)
    rest = MultivariablePlant.of_one_channel(block) if isinstance(block, RationalPlant) else block
    assert isinstance(rest, MultivariablePlant), "nor do these"
    m, p, zero = network.outputs, network.inputs, Fraction(0)
    return replace(
        rest,
        B=tuple((*a, *b) for a, b in zip(rest.B, found.B, strict=True)),
        C=(*rest.C, *found.C),
        D=(*((*row, *[zero] * m) for row in rest.D), *(((zero,) * (rest.inputs + m),) * p)),
        names=(),
    )
