"""What the tests of certify share: blocks whose limits are known, and the question."""

from lure import NonlinearityClass, RationalPlant, Sector
from lure.analysis.questions.certify import ProofOptions, certify

THIRD = RationalPlant([1], [1, 3, 2, 0])  # Routh and Popov: 6


def sector(lower, upper, **words):
    return NonlinearityClass(sector=Sector(lower, upper), **words)


def asked(block, nonlinearity_class, criterion="best", **ways):
    return certify(block, nonlinearity_class, ways=ProofOptions(criterion=criterion, **ways))
