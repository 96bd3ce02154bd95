"""How hard the tests search: samples as a working day bears them, and all with ``--hypothesis-profile=ci``."""

from hypothesis import settings


def sampled(count, *, of):
    """The size of a sample: ``count``, and ``of`` where the profile `ci` searches harder."""
    return of if settings.get_current_profile_name() == "ci" else count
