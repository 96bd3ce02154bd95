from lure.analysis.rod.comparison import compare as compare
from lure.analysis.rod.response import basin as basin
from lure.analysis.rod.response import bifurcation as bifurcation
from lure.analysis.rod.response import resting_place as resting_place
