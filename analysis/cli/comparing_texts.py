"""The help text of ``lure compare``, within 80 columns."""

COMPARE = """Hold the scheme and Galerkin models against the exact motion.

\b
Examples:
  lure compare paper-rod
  lure compare paper-rod --until 0.01 --plot compare.svg
  lure compare rod.toml --cells 10,20,40,80 --galerkin P1:26,P1:51
  lure compare paper-rod --cells 200 --method CVODE --galerkin none --json
  lure compare paper-rod --set rod.gap=5e-5 --set rod.compliance=1e-9

\b
One table: error of u(t, L), energy, decay of the elastic modes, observed
order, cost; for the release of the paper also its settling time.  The exact
row is about the rod, every other row about a discrete model.

\b
Methods for the scheme: exact (no time step), RK45, DOP853, Radau, BDF, LSODA
(scipy), CVODE, CVODE-Adams (needs lure[cvode]).

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""
