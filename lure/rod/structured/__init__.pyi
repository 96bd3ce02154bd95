from lure.rod.structured.contact import first_contact as first_contact
from lure.rod.structured.flight import FreeFlight as FreeFlight
from lure.rod.structured.flight import free_flight as free_flight
from lure.rod.structured.motion import StructuredMotion as StructuredMotion
from lure.rod.structured.motion import structured_motion as structured_motion
