"""Simulation of the closed loop: exact between events, with contact and release located as events."""

from lure.analysis.rod.simulation.simulate import simulate as simulate
from lure.analysis.rod.simulation.trajectory import Trajectory as Trajectory
from lure.analysis.rod.simulation.trajectory import contradictions as contradictions
