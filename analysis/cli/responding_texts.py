"""The help texts of ``lure response``, ``lure bifurcation`` and ``lure basin``, within 80 columns."""

RESPONSE = """Say what a rod does under a periodic force after a while.

\b
Examples:
  lure response paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+0.7*sin(3000*t)" --settle 0.5
  lure response paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+where(sin(3000*t)>0,1,-1)" \\
      --separation --plot response.svg
  lure response rod.toml --rigid --json > response.json

\b
The motion of the rod itself, exactly: regime, time in contact, impacts,
momentum, spectrum.  The period must follow from the formula (sines and
cosines with commensurable frequencies), or be given with --period.  A force
of mean 0 has no periodic response with contact: the rod walks away.
A motion that was not seen to repeat is not thereby proved chaotic.
A run costs round trips 2L/c: a light dashpot or a soft obstacle takes many.

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted (nothing is
written).
"""
BIFURCATION = """Follow the response through the values of a parameter.

\b
Examples:
  lure bifurcation paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+F*sin(3000*t)" \\
      --parameter F --from 0.5 --to 1.1 --count 31 --plot doubling.png
  lure bifurcation rod.toml --set rod.damping=0.24 --rigid \\
      --force "0.3+F*sin(3000*t)" --parameter F --from 0.5 --to 1.1 \\
      --count 31 --settle 0.1 --sweep down --json > down.json
  lure bifurcation rod.toml --force "0.3+0.7*sin(3000*t)" --rigid \\
      --parameter damping --from 0.1 --to 0.5 --count 20 --workers 2

\b
The parameter is a symbol of the force or a field of the rod: damping, gap,
compliance, youngs_modulus, density, length, area, exponent.  Each value
starts from the same data; with --sweep up or down it starts from the end of
the one before (symbols of the force only), which shows hysteresis.

\b
Ctrl-C keeps what is done: it is printed, written and drawn, and says that it
is not all.
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""
BASIN = """Say where a rod without a force comes to rest.

\b
Examples:
  lure basin paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --offset -1e-4 1e-4 9 \\
      --velocity -0.5 1 13 --plot basin.png
  lure basin rod.toml --set rod.damping=0.05 --set rod.compliance=1e-11 \\
      --velocity 0 100 6 --json

\b
Uniform displacements [m] and velocities [m/s] are added to the initial data.
Each motion is followed until it is known where it ends, or bounds are given.
Ctrl-C keeps what is done.

\b
Exit status: 0 done, 10 a resting place is not known, 2 bad input, 1 a bug in
lure, 130 interrupted.
"""
AS_PRINTED = (
    "Note: the scheme as printed answers the force divided by c N/L; the rod here answers the force as it stands."
)
