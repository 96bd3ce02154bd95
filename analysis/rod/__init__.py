"""What can be said of the rod and of its scheme: proofs, spectrum, motions, and the paper reproduced."""
