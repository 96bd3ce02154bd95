"""An input ``w(t) = constant + amplitude sin(omega t)`` of a loop, to which its steady response is asked."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from lure.errors import InputError
from lure.exact import exact_number
from lure.record import Record, quantity

MOST_FREQUENCIES = 1000
_NAMES = ("amplitude", "omega", "constant", "unit")


class Forcing(Record):
    r"""An input of a loop.

    .. math:: w(t) = w_0 + a \sin(\omega t)

    Raises
    ------
    InputError
        Nothing moves the loop; ``constant`` and ``amplitude`` differ in length; a frequency is not positive, or has no
        amplitude; or there are more than 1000.

    Examples
    --------
    >>> print(Forcing.given({"amplitude": 2, "omega": [1, 3]}))
    w = 2 sin(omega t), omega = 1 to 3 rad/s
    """

    amplitude: tuple[Fraction, ...] = quantity("(p,) ``a`` [unit of w]", default=())
    omega: tuple[Fraction, ...] = quantity("The frequencies asked about [rad/s]; empty for some chosen", default=())
    constant: tuple[Fraction, ...] = quantity("(p,) ``w_0`` [unit of w]", default=())
    unit: str = quantity("The unit of ``z``, for figures", default="")
    _kind, _said = "forcing", "text"

    def __post_init__(self) -> None:
        moving = any(self.amplitude)
        if not moving and not any(self.constant):
            raise InputError("forcing has neither amplitude nor constant; give one, such as amplitude = 1")
        if len({len(side) for side in (self.amplitude, self.constant) if side}) > 1:
            raise InputError(
                f"forcing.amplitude has {len(self.amplitude)} entries and forcing.constant {len(self.constant)}; give "
                "one for each input w in both"
            )
        if self.omega and not moving:
            raise InputError("forcing.omega is given without amplitude; give forcing.amplitude, or leave omega out")
        low = min(self.omega, default=Fraction(1))
        if low <= 0:
            raise InputError(f"forcing.omega is {float(low):g}; give positive frequencies in rad/s")
        if len(self.omega) > MOST_FREQUENCIES:
            raise InputError(f"forcing.omega has {len(self.omega)} entries; give up to {MOST_FREQUENCIES}")

    @classmethod
    def given(cls, stated: object) -> Forcing:
        """The input that a mapping of numbers means, or one as it is.

        Parameters
        ----------
        stated : Forcing or mapping
            ``amplitude``, ``omega``, ``constant``: each a number or a list; ``unit``.

        Raises
        ------
        InputError
            It is neither, or as above.
        """
        if isinstance(stated, Forcing):
            return stated
        if not isinstance(stated, Mapping):
            raise InputError(f"forcing is {stated!r:.60}; give a mapping such as {{'amplitude': 1, 'omega': 2}}")
        unknown = next((name for name in stated if name not in _NAMES), None)
        if unknown is not None:
            raise InputError(f"forcing has {unknown!r:.40}; choose from {', '.join(_NAMES)}")
        sides = {name: exact_numbers(stated[name], f"forcing.{name}") for name in _NAMES[:3] if name in stated}
        return cls(**sides, unit=str(stated.get("unit", "")))

    @property
    def stated(self) -> dict[str, object]:
        """What is not left out."""
        return {name: side for name in _NAMES if (side := getattr(self, name))}

    @property
    def inputs(self) -> int:
        """Length of ``w``."""
        return max(len(self.amplitude), len(self.constant))

    def __str__(self) -> str:
        parts = [", ".join(f"{float(v):g}" for v in side) for side in (self.constant, self.amplitude)]
        parts = [f"({part})" if "," in part else part for part in parts]
        said = [parts[0]] if any(self.constant) else []
        said += [f"{parts[1]} sin(omega t)"] if any(self.amplitude) else []
        low, high = (f"{float(end(self.omega)):g}" for end in (min, max)) if self.omega else ("", "")
        where = (
            "" if not self.omega else f", omega = {low} rad/s" if low == high else f", omega = {low} to {high} rad/s"
        )
        return f"w = {' + '.join(said)}{where}"


def exact_numbers(value: object, name: str) -> tuple[Fraction, ...]:
    """A number, or a list or an array of them, exactly.

    Parameters
    ----------
    value : object
        The numbers.
    name : str
        What they are, for the message.

    Raises
    ------
    InputError
        One is no finite number.
    """
    listed: object = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, list | tuple):
        return (exact_number(listed, name),)
    return tuple(exact_number(one, f"{name}[{i}]") for i, one in enumerate(listed))
