from lure.networks.network import Network as Network
from lure.networks.reading import read_network as read_network
