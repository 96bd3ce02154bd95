"""The motion of the rod itself, with contact, to rounding: no grid, no time step."""

from lure.motion.end_law import Boundary as Boundary
from lure.motion.impacts import Impact as Impact
from lure.motion.motion import Motion as Motion
from lure.motion.solve import Numerics as Numerics
from lure.motion.solve import exact_motion as exact_motion
from lure.motion.solve import motion_windows as motion_windows
from lure.motion.windows import Window as Window
