"""One motion by any of the ways to compute it, as samples, as an xarray Dataset, as a netCDF file."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)
