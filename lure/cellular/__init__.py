"""Cellular neural networks: cloning templates on a line or in the plane, and the paper's rod as one of them."""

from lure.cellular.convergence import ChuaYang as ChuaYang
from lure.cellular.convergence import chua_yang as chua_yang
from lure.cellular.convergence import chua_yang_energy as chua_yang_energy
from lure.cellular.gallery import diffusion_network as diffusion_network
from lure.cellular.gallery import edge_network as edge_network
from lure.cellular.motion import CellularMotion as CellularMotion
from lure.cellular.network import CellularNetwork as CellularNetwork
from lure.cellular.network import saturation as saturation
from lure.cellular.rod import rod_network as rod_network
from lure.cellular.rod import rod_ring as rod_ring
from lure.cellular.template import Template as Template
