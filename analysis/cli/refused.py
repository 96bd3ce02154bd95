"""Refusals of the command line, made without importing the package ``lure`` before there is one to make."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lure.errors import InputError


def refused(sentence: str) -> InputError:
    """The error that ends a command with status 2.

    ``import lure`` takes longer than most certificates do to check; a command that needs none of it should not wait.

    Parameters
    ----------
    sentence : str
        The field, the value found and the fix.
    """
    from lure.errors import InputError

    return InputError(sentence)
