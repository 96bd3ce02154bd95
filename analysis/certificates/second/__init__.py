"""A second checker of certificates, on python-flint, written from the theorems and not from the first checker."""

from lure.analysis.certificates.second.opinion import SecondOpinion as SecondOpinion
from lure.analysis.certificates.second.opinion import recheck as recheck
from lure.analysis.certificates.second.opinion import recheck_apart as recheck_apart
