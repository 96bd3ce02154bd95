"""Figures: results in, axes out.  The only package that imports matplotlib, and only when something is drawn.

Every function draws on the axes it is given (a new pyplot figure without them), returns them, shows nothing and leaves
matplotlib's settings alone.
"""

from analysis.plots.export import Draw as Draw
from analysis.plots.export import Picture as Picture
from analysis.plots.export import render as render
from analysis.plots.frequencies import drawing_frequencies as drawing_frequencies
from analysis.plots.modes import plot_damping as plot_damping
from analysis.plots.modes import plot_spectrum as plot_spectrum
from analysis.plots.motion import plot_decay as plot_decay
from analysis.plots.motion import plot_end_motion as plot_end_motion
from analysis.plots.motion import plot_rest as plot_rest
from analysis.plots.motion import plot_surface as plot_surface
from analysis.plots.nyquist import plot_nyquist as plot_nyquist
from analysis.plots.popov import plot_popov as plot_popov
from analysis.plots.popov import plot_popov_expression as plot_popov_expression
