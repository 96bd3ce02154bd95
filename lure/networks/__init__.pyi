from lure.networks.biased import Equilibrium as Equilibrium
from lure.networks.biased import equilibrium as equilibrium
from lure.networks.network import Network as Network
from lure.networks.reading import read_network as read_network
