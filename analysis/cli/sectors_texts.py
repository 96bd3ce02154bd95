"""The help text of ``lure sector``, within 80 columns."""

SECTOR = """Bound a law: its sector or its slopes, from both sides.

\b
Examples:
  lure sector --expr "max(x,0)**1.5" --on -1 1
  lure sector --expr "tanh(sigma) + sigma/3" --slope
  lure sector --expr "sin(x)" --within -0.25 1 --plot sector.svg
  lure sector --expr "min(max(2*x,-1),1)" --json
  lure sector data.csv --displacement depth --force load --fit
  lure sector data.csv --area 25e-6 --origin gap --plot data.svg
  lure sector amplifier.csv --units V,V

\b
Of a formula: the least and the largest phi(sigma)/sigma, or slope, over all
of R or the interval, certified: exact for piecewise linear laws, by isolated
roots for polynomials and rational functions, else in ball arithmetic with
zero and infinity included.

\b
Of measured data: bounds on the chords and slopes of the mean law that hold
with the confidence, under the assumptions printed; outliers are named, and
loading and unloading compared.  This is observed and proves nothing.  Units
stand in the headings, displacement [um], force (mN), or in --units mm,lbf.

\b
With --within, a point (or two, for slopes) is printed where the law leaves
the bounds.

\b
Exit status: 0 shown, or within the bounds; 11 the bounds are violated at a
point; 10 not decided, or measured data with hysteresis or without a stated
confidence; 2 bad input.
"""
