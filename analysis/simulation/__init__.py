"""Simulation of the closed loop: exact between events, with contact and release located as events."""

from analysis.simulation.simulate import simulate as simulate
from analysis.simulation.trajectory import Contact as Contact
from analysis.simulation.trajectory import Trajectory as Trajectory
from analysis.simulation.trajectory import contradictions as contradictions
