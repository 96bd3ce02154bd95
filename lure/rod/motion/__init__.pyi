from lure.rod.datasets import Contact as Contact
from lure.rod.motion.end_law import Boundary as Boundary
from lure.rod.motion.motion import Motion as Motion
from lure.rod.motion.motion import Numerics as Numerics
from lure.rod.motion.motion import exact_motion as exact_motion
from lure.rod.motion.motion import motion_windows as motion_windows
from lure.rod.motion.record import Window as Window
