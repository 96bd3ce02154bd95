from lure.analysis.certificates.second.opinion import SecondOpinion as SecondOpinion
from lure.analysis.certificates.second.opinion import recheck as recheck
from lure.analysis.certificates.second.opinion import recheck_apart as recheck_apart
