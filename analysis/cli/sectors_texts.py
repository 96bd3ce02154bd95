"""The help text of ``lure sector``, within 80 columns."""

SECTOR = """Bound a law: its sector or its slopes, from both sides.

\b
Examples:
  lure sector --expr "max(x,0)**1.5" --on -1 1
  lure sector --expr "tanh(sigma) + sigma/3" --slope
  lure sector --expr "sin(x)" --within -0.25 1 --plot sector.svg
  lure sector --expr "min(max(2*x,-1),1)" --json
  lure sector data.csv

\b
Of a formula: the least and the largest phi(sigma)/sigma, or slope, over all
of R or the interval, certified: exact for piecewise linear laws, by isolated
roots for polynomials and rational functions, else in ball arithmetic with
zero and infinity included.  Of measured data: what the data show.

\b
With --within, a point (or two, for slopes) is printed where the law leaves
the bounds.

\b
Exit status: 0 shown, or within the bounds; 11 the bounds are violated at a
point; 10 not decided; 2 bad input.
"""
