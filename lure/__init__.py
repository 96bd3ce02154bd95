"""Lur'e systems: linear blocks, sector nonlinearities and the loop that joins them."""

__version__ = "0.1.0"
