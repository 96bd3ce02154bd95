"""Criteria for blocks with dead time: ball arithmetic over all frequencies instead of polynomials."""
