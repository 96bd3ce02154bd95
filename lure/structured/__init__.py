"""The upwind scheme by its structure: jumps of any length for very many cells, and contact event to event."""

from lure.structured.contact import first_contact as first_contact
from lure.structured.flight import FreeFlight as FreeFlight
from lure.structured.flight import free_flight as free_flight
from lure.structured.motion import StructuredMotion as StructuredMotion
from lure.structured.motion import structured_motion as structured_motion
