"""The upwind scheme by its structure: free flight of very many cells in one jump, and its first contact."""

from lure.structured.contact import first_contact as first_contact
from lure.structured.flight import FreeFlight as FreeFlight
from lure.structured.flight import free_flight as free_flight
