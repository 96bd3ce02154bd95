"""Destabilising members of a class of laws: linear gains, switched gains, and laws with periodic orbits."""
