"""A way out where rounding sends the end to and fro between contact and flight at one instant.

In a piece that is hardly wider than the rounding of time, each of two neighbouring segments of the law may find that
the end has just left it.  After two departures back at once the segment entered is kept for a moment, twice as long
each time that does not help: what this leaves out of ``z`` is at most the moment times the wave.
"""

from __future__ import annotations

FIRST = 4e-15  # [transits]
_AT_ONCE = 16.0
_TURNS = 2


def next_turn(steps: tuple[int, int], lasted: float, turns: int, length: float) -> tuple[int, float, float]:
    """Turns so far and the next moment's length after a departure, and how long the segment entered is kept [transits].

    Parameters
    ----------
    steps : tuple of int
        The step of the departure before this one, and of this one: 1 or -1.
    lasted : float
        Time between the two [transits].
    turns, length
        As they were returned; 0 and ``FIRST`` at first.
    """
    if steps[0] != -steps[1] or lasted > _AT_ONCE * length:
        return 0, FIRST, 0.0
    if turns + 1 < _TURNS:
        return turns + 1, length, 0.0
    return turns + 1, 2.0 * length, length
