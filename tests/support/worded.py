"""What a sentence is made from: a class in a file, and a proof of it."""

from types import SimpleNamespace

from lure import NonlinearityClass, Sector
from lure.analysis.certificates.checker import ATTRACTS
from lure.classes import Diagonal

KNOWN = Diagonal((NonlinearityClass(sector=Sector(0, 1)),))
PLAIN = {"sector": ["0", "2"], "slope": None, "odd": False, "time_varying": False, "linear": False}


def shown(conclusion=ATTRACTS, theorem="circle", **more):
    system = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "1"]}
    certificate = {"conclusion": conclusion, "system": system, "laws": PLAIN, "proof": {"method": "polynomial"}, **more}
    return SimpleNamespace(certificate=certificate, theorem=theorem)
