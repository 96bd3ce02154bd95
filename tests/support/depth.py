"""How hard the tests search: samples as a working day bears them, and all of them in `make thorough`."""

import pytest
from hypothesis import settings

THOROUGH = "thorough"


def thorough():
    """Whether this run is to search as hard as it can: ``--hypothesis-profile=thorough``."""
    return settings.get_current_profile_name() == THOROUGH


def sampled(count, *, of):
    """The size of a sample: ``count``, and ``of`` in a thorough run."""
    return of if thorough() else count


def rarely(values, *left):
    """The parameters of a test, those that are left to `make thorough` marked: the others show the same for less.

    A tuple among the values has the values of several parameters.  What is left to `make slow` is marked `slow_for`.
    """
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=[pytest.mark.thorough] * (value in left))
        for value in values
    ]
