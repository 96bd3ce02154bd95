"""Lur'e systems: linear blocks, nonlinearities known by their sector, and the elastic rod with a compliant obstacle."""

from lure.extensions import extend
from lure.lazy import lazy_exports

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

extend(
    "system file",
    {
        "lure.rod.systems:RodSystem": "lure.rod.file:ROD_FILE",
        "lure.rod.assembly:RodAssembly": "lure.rod.assembly_file:ASSEMBLY_FILE",
    },
)
