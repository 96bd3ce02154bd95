"""Figures: results in, axes out.  The only package that imports matplotlib, and only when something is drawn.

Every function draws on the axes it is given (a new pyplot figure without them), returns them, shows nothing and leaves
matplotlib's settings alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.handing_out import handing_out

if TYPE_CHECKING:
    from analysis.plots.animation import animate as animate
    from analysis.plots.balances import plot_hint as plot_hint
    from analysis.plots.comparison import plot_comparison as plot_comparison
    from analysis.plots.comparison import plot_comparison_end as plot_comparison_end
    from analysis.plots.comparison import plot_comparison_error as plot_comparison_error
    from analysis.plots.confirmation import plot_both_decays as plot_both_decays
    from analysis.plots.confirmation import plot_both_ends as plot_both_ends
    from analysis.plots.export import Draw as Draw
    from analysis.plots.export import Picture as Picture
    from analysis.plots.export import render as render
    from analysis.plots.frequencies import drawing_frequencies as drawing_frequencies
    from analysis.plots.loops import plot_loop_nyquist as plot_loop_nyquist
    from analysis.plots.loops import plot_loop_popov as plot_loop_popov
    from analysis.plots.loops import plot_reach as plot_reach
    from analysis.plots.measured import plot_compliance as plot_compliance
    from analysis.plots.measured import plot_measured as plot_measured
    from analysis.plots.measured import plot_measurements as plot_measurements
    from analysis.plots.modes import plot_damping as plot_damping
    from analysis.plots.modes import plot_spectrum as plot_spectrum
    from analysis.plots.motion import plot_decay as plot_decay
    from analysis.plots.motion import plot_end_motion as plot_end_motion
    from analysis.plots.motion import plot_rest as plot_rest
    from analysis.plots.motion import plot_surface as plot_surface
    from analysis.plots.motions import plot_convergence as plot_convergence
    from analysis.plots.motions import plot_motion as plot_motion
    from analysis.plots.nyquist import plot_nyquist as plot_nyquist
    from analysis.plots.orbits import plot_law as plot_law
    from analysis.plots.orbits import plot_orbit as plot_orbit
    from analysis.plots.orbits import plot_orbit_signals as plot_orbit_signals
    from analysis.plots.paper import EndCurve as EndCurve
    from analysis.plots.paper import plot_end_curves as plot_end_curves
    from analysis.plots.paper import plot_end_envelope as plot_end_envelope
    from analysis.plots.paper import plot_waves as plot_waves
    from analysis.plots.popov import plot_popov as plot_popov
    from analysis.plots.popov import plot_popov_expression as plot_popov_expression
    from analysis.plots.response import plot_history as plot_history
    from analysis.plots.response import plot_impulses as plot_impulses
    from analysis.plots.response import plot_poincare as plot_poincare
    from analysis.plots.response import plot_response as plot_response
    from analysis.plots.response import plot_response_spectrum as plot_response_spectrum
    from analysis.plots.responses import plot_nyquist_response as plot_nyquist_response
    from analysis.plots.responses import plot_popov_response as plot_popov_response
    from analysis.plots.rod_frequency import plot_rod_nyquist as plot_rod_nyquist
    from analysis.plots.rod_frequency import plot_rod_popov as plot_rod_popov
    from analysis.plots.run import plot_run_dashpot as plot_run_dashpot
    from analysis.plots.run import plot_run_end as plot_run_end
    from analysis.plots.run import plot_run_energy as plot_run_energy
    from analysis.plots.run import plot_run_stress as plot_run_stress
    from analysis.plots.sectors import plot_law_sector as plot_law_sector
    from analysis.plots.sectors import plot_law_slope as plot_law_slope
    from analysis.plots.solutions import plot_solutions as plot_solutions
    from analysis.plots.space_time import plot_space_time as plot_space_time
    from analysis.plots.sweeps import plot_basin as plot_basin
    from analysis.plots.sweeps import plot_bifurcation as plot_bifurcation
    from analysis.plots.violation import plot_violation as plot_violation

_HOMES = {
    "animate": "animation",
    "plot_hint": "balances",
    "plot_comparison": "comparison",
    "plot_comparison_end": "comparison",
    "plot_comparison_error": "comparison",
    "plot_both_decays": "confirmation",
    "plot_both_ends": "confirmation",
    "Draw": "export",
    "Picture": "export",
    "render": "export",
    "drawing_frequencies": "frequencies",
    "plot_loop_nyquist": "loops",
    "plot_loop_popov": "loops",
    "plot_reach": "loops",
    "plot_compliance": "measured",
    "plot_measured": "measured",
    "plot_measurements": "measured",
    "plot_damping": "modes",
    "plot_spectrum": "modes",
    "plot_decay": "motion",
    "plot_end_motion": "motion",
    "plot_rest": "motion",
    "plot_surface": "motion",
    "plot_convergence": "motions",
    "plot_motion": "motions",
    "plot_nyquist": "nyquist",
    "plot_law": "orbits",
    "plot_orbit": "orbits",
    "plot_orbit_signals": "orbits",
    "EndCurve": "paper",
    "plot_end_curves": "paper",
    "plot_end_envelope": "paper",
    "plot_waves": "paper",
    "plot_popov": "popov",
    "plot_popov_expression": "popov",
    "plot_history": "response",
    "plot_impulses": "response",
    "plot_poincare": "response",
    "plot_response": "response",
    "plot_response_spectrum": "response",
    "plot_nyquist_response": "responses",
    "plot_popov_response": "responses",
    "plot_rod_nyquist": "rod_frequency",
    "plot_rod_popov": "rod_frequency",
    "plot_run_dashpot": "run",
    "plot_run_end": "run",
    "plot_run_energy": "run",
    "plot_run_stress": "run",
    "plot_law_sector": "sectors",
    "plot_law_slope": "sectors",
    "plot_solutions": "solutions",
    "plot_space_time": "space_time",
    "plot_basin": "sweeps",
    "plot_bifurcation": "sweeps",
    "plot_violation": "violation",
}

__getattr__, __dir__ = handing_out(__name__, _HOMES)  # what the figures draw is itself drawn by them
