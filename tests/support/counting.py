"""Work that is counted and not timed: a clock says more of what else the machine does than of the code."""

import sys
from contextlib import contextmanager


class Work:
    """How often a function was entered or left, Python's and C's alike."""

    calls = 0

    def __call__(self, _frame, _event, _argument):
        """One more."""
        self.calls += 1


@contextmanager
def counted():
    """The work of the body, in `calls`."""
    work, before = Work(), sys.getprofile()
    sys.setprofile(work)
    try:
        yield work
    finally:
        sys.setprofile(before)
