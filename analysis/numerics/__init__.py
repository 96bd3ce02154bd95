"""Exact and ball arithmetic: polynomials, matrices, minima, and numbers rounded in a stated direction."""
