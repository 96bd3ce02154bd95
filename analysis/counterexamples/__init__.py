"""Destabilising members of a class of nonlinearities: linear gains, switched gains, periodic orbits."""
