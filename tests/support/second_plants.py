"""Plants and classes as the second checker has them, for tests of its parts."""

from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction as F

import pytest
from flint import fmpq_mat

from lure.analysis.certificates.second.channels import Asked
from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.reading import NotShown

PLAIN = Nonlinearities(lower=F(0), upper=F(1), slope=(F(0), F(1)), odd=False, time_varying=False, linear=False)


def asked(A, B, C, D, *classes, **more):
    """A plant of rows with a class for each channel, functions in [0, 1] unless others are given."""
    sides = dict(zip("ABCD", map(fmpq_mat, (A, B, C, D)), strict=True))
    own = classes or (PLAIN,) * len(D)
    repeated = more.pop("repeated", tuple(range(len(D))))
    return Asked(**sides, discrete=more.pop("discrete", False), nonlinearities=own, repeated=repeated, **more)


def unit(n):
    """The unit matrix."""
    return fmpq_mat([[int(i == j) for j in range(n)] for i in range(n)])


def at(sides, s):
    """``D + C (s - A)^-1 B``."""
    A, B, C, D = sides
    return D + C * (s * unit(A.nrows()) - A).inv() * B


def assert_accepted_if(holds: bool) -> AbstractContextManager:
    """Where what does not hold has to be refused."""
    return nullcontext() if holds else pytest.raises(NotShown)
