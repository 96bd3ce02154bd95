"""Loops with an input: periodic solutions by harmonic balance, and in ball arithmetic how far from them one can be."""
