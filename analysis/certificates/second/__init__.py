"""A second checker of certificates, on python-flint, written from the theorems and not from the first checker."""

from analysis.certificates.second.apart import recheck_apart as recheck_apart
from analysis.certificates.second.opinion import SecondOpinion as SecondOpinion
from analysis.certificates.second.opinion import recheck as recheck
