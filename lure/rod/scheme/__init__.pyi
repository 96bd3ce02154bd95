from lure.rod.scheme.contact import first_contact as first_contact
from lure.rod.scheme.flight import FreeFlight as FreeFlight
from lure.rod.scheme.flight import free_flight as free_flight
from lure.rod.scheme.motion import StructuredMotion as StructuredMotion
from lure.rod.scheme.motion import structured_motion as structured_motion
