"""Lur'e loops as named systems: a block, what is said of the nonlinearity, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from lure.classes import NonlinearityClass
from lure.errors import InputError
from lure.loop import Loop, loop_rows
from lure.nonlinearities.base import Nonlinearity
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import Record, quantity

if TYPE_CHECKING:
    import control


class LoopSystem(Record):
    """A linear block in a loop ``sigma = H mu``, ``mu = -phi(sigma)``, and what is said of ``phi``."""

    name: str = quantity("Name for the report")
    title: str = quantity("One line that says what it is")
    source: str = quantity("Where the numbers come from", default="")
    block: RationalPlant | DelayPlant | StateSpace = quantity("The linear block")
    nonlinearity: Nonlinearity | None = quantity("The nonlinearity, if there is one", key="law", default=None)
    nonlinearity_class: NonlinearityClass | None = quantity(
        "The class of nonlinearities asked about, if there is one; it contains the nonlinearity",
        key="class",
        default=None,
    )
    nonlinearity_table: Mapping[str, object] | None = quantity(
        "The entries of the table ``[nonlinearity]`` that mean the nonlinearity", key="", default=None
    )
    _kind = "loop system"
    _notes = ("sigma = H mu, mu = -phi(sigma); lure.analysis.analyse(system) decides.",)

    def to_control(self, *, pade: int | None = None) -> control.NonlinearIOSystem:
        """The closed loop with the nonlinearity; see :meth:`lure.Loop.to_control`.

        Parameters
        ----------
        pade : int, optional
            Order of the approximation that stands for a dead time.

        Raises
        ------
        InputError
            There is no nonlinearity to close the loop with, or the loop cannot be simulated there.
        """
        if self.nonlinearity is None:
            raise InputError(
                f"the system {self.name!r:.60} has no nonlinearity to close the loop with; Loop(system.block, "
                "phi) has one"
            )
        return Loop(self.block, self.nonlinearity).to_control(pade=pade)

    @property
    def _title(self) -> str:
        return f"{self.name}: {self.title}" if self.title else self.name

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield from loop_rows(self.block, self.nonlinearity)
        if self.nonlinearity_class is not None:
            yield "class asked about", str(self.nonlinearity_class)
        if self.source:
            yield "source", self.source


def loop_system(
    identity: tuple[str, str, str],
    block: RationalPlant | DelayPlant | StateSpace,
    *,
    nonlinearity_table: Mapping[str, object] | None = None,
    nonlinearity_class: NonlinearityClass | None = None,
) -> LoopSystem:
    """A loop from its block and the table of its nonlinearity.

    Parameters
    ----------
    identity : tuple of str
        Name, title and source.
    block : RationalPlant, DelayPlant or StateSpace
        The linear block.
    nonlinearity_table : Mapping of str to object, or None
        ``kind`` and parameters of the nonlinearity, as :func:`lure.nonlinearities.nonlinearity_from_table` takes them.
    nonlinearity_class : NonlinearityClass or None
        The class asked about.

    Raises
    ------
    InputError
        The nonlinearity is refused, or it is not known to belong to the class: the class would promise what the
        nonlinearity breaks.
    """
    nonlinearity = None
    if nonlinearity_table is not None:
        from lure.nonlinearities import nonlinearity_from_table

        values = dict(nonlinearity_table)
        nonlinearity = nonlinearity_from_table(str(values.pop("kind")), values)
        if nonlinearity_class is not None:
            _check_member(nonlinearity, nonlinearity_class)
    name, title, source = identity
    return LoopSystem(
        name=name,
        title=title,
        block=block,
        nonlinearity=nonlinearity,
        nonlinearity_class=nonlinearity_class,
        source=source,
        nonlinearity_table=None if nonlinearity_table is None else MappingProxyType(dict(nonlinearity_table)),
    )


def _check_member(nonlinearity: Nonlinearity, asked: NonlinearityClass) -> None:
    from lure.nonlinearities import ExpressionNonlinearity, nonlinearity_class

    if isinstance(nonlinearity, ExpressionNonlinearity) and not nonlinearity.sector_declared:
        return  # it declares nothing that could be compared: the analysis certifies it, or says that it was given so
    known = nonlinearity_class(nonlinearity)
    inside = asked.sector.lower <= known.sector.lower and known.sector.upper <= asked.sector.upper
    slope = asked.slope is None or (
        known.slope is not None and asked.slope.lower <= known.slope.lower and known.slope.upper <= asked.slope.upper
    )
    if not (inside and slope and (known.odd or not asked.odd)):
        raise InputError(
            f"the class is {asked} but the nonlinearity is only known to be among {known}; give a class that "
            "contains the nonlinearity, or leave one of the two out"
        )
