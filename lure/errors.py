"""The exceptions worth catching: one for wrong data, one for a theorem whose hypothesis fails."""


class InputError(ValueError):
    """Wrong data: the message names the field, the value found and the fix."""


class AssumptionError(ValueError):
    """A theorem was asked for where one of its hypotheses does not hold; the message carries the number."""
