"""Plants and classes as the second checker has them, for tests of its parts."""

from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction as F
from types import SimpleNamespace

import numpy as np
import pytest
from flint import fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.channels import Asked
from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import Rational, States, read_system

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


def poly(*ascending):
    """A polynomial of exact numbers or texts."""
    return fmpq_poly([to_fmpq(F(v)) for v in ascending])


def rational(A, b, c, d=0, *, discrete=False):
    """A plant of matrices with one channel."""
    rows = tuple(tuple(map(F, row)) for row in A)
    state = States(A=rows, b=tuple(map(F, b)), c=tuple(map(F, c)), d=F(d))
    return Rational(discrete=discrete, states=state, given=None)


def transfer(n, d, *, discrete=False):
    """A transfer function of texts, the highest power first."""
    time = "discrete" if discrete else "continuous"
    return read_system({"kind": "transfer", "time": time, "numerator": n.split(), "denominator": d.split()})


def rows_of(M):
    """An exact matrix as an array of floating-point numbers."""
    return np.array([[float(v.p) / float(v.q) for v in row] for row in M.tolist()])


def of(**proof):
    """A document of which the proof alone is read."""
    return SimpleNamespace(proof=proof)
