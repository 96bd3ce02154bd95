"""The loop: a block in negative feedback with a nonlinearity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from lure.block import Block
from lure.nonlinearity import Nonlinearity
from lure.showing import html_table, plain
from lure.values import by_value

if TYPE_CHECKING:
    import control


@by_value
@dataclass(frozen=True, eq=False)
class Loop:
    r"""A Lur'e loop ``sigma = H mu``, ``mu = -phi(sigma)``.

    The minus sign stands here and nowhere else: blocks carry ``H`` from ``mu`` to ``sigma``, laws return ``phi``.

    Parameters
    ----------
    block : Block
        The linear part; a system of python-control or scipy.signal, coefficients or a formula become the block that
        :func:`lure.as_block` makes of them.
    nonlinearity : Nonlinearity
        The law, with the sector its author vouches for; ``control.saturation_nonlinearity`` becomes a ``Saturation``.

    Raises
    ------
    InputError
        The block is none, or the law has no sector, or a memory.

    Examples
    --------
    >>> from lure import Saturation
    >>> print(Loop(([1], [1, 3, 2, 0]), Saturation(gain=5)).nonlinearity.sector)
    [0, 5]
    """

    block: Block
    nonlinearity: Nonlinearity

    def __post_init__(self) -> None:
        if not hasattr(self.block, "transfer"):
            from lure.inputs import as_block

            object.__setattr__(self, "block", as_block(self.block))
        if not hasattr(self.nonlinearity, "sector"):
            from lure.laws.accepting import as_law

            object.__setattr__(self, "nonlinearity", as_law(self.nonlinearity))

    def to_control(self, *, pade: int | None = None) -> control.NonlinearIOSystem:
        """The closed loop as a nonlinear system of python-control, with a load ``r`` added to ``mu``.

        ``x' = A x + B mu``, ``sigma = C x + D mu``, ``mu = r - phi(sigma)`` (or ``x[k+1] = ..``): input ``r``, output
        ``sigma``.  Where the block was given by matrices these are its matrices, and its states with their names: an
        initial state means what it means there.  Else they are the controllable companion form of the transfer
        function, hidden modes kept.

        Parameters
        ----------
        pade : int, optional
            Order of the approximation that stands for a dead time; without it a dead time is refused.

        Raises
        ------
        InputError
            The block has no states (a measurement, or the rod itself), or a direct term ``D`` with which the loop
            need not define ``sigma``: ``1 + D k <= 0`` for a slope ``k`` of the law, or its slopes are not known.

        Notes
        -----
        For ``control.input_output_response``.  A simulation is one motion: it proves nothing about the others.

        Examples
        --------
        >>> import control
        >>> from lure.laws import Saturation
        >>> closed = Loop(control.tf([1], [1, 0]), Saturation()).to_control()
        >>> closed.nstates, closed.input_labels, closed.output_labels
        (1, ['r'], ['sigma'])
        """
        from lure.closed_loop import closed_loop

        return closed_loop(self, pade=pade)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: the block and the law."""
        return {"kind": "loop", "block": plain(self.block), "law": plain(self.nonlinearity)}

    def _repr_html_(self) -> str:
        return html_table("Loop: sigma = H mu, mu = -phi(sigma)", loop_rows(self.block, self.nonlinearity))


def loop_rows(block: object, law: object) -> list[tuple[str, str]]:
    """What the table of a loop says about its two parts.

    Parameters
    ----------
    block, law : object
        The parts; the law may be missing.
    """
    from lure.laws.showing import law_text

    rows = [("H", str(block) if type(block).__str__ is not object.__str__ else type(block).__name__)]
    if law is None:
        return rows
    known = cast("Nonlinearity", law)
    return [*rows, ("phi", law_text(known)), ("sector of phi", str(known.sector))]
