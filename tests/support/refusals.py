"""What the tests of bad input share: the sentence of a refusal, after the checks that hold for every one of them."""

import pytest

from lure.errors import InputError


def refusal(make, *arguments, **options):
    """The sentence with which ``make`` refuses its arguments: one line, printable, of a readable length."""
    with pytest.raises(InputError) as caught:
        make(*arguments, **options)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 400
    return message
