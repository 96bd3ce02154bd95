"""What answers to "how well?" have in common: a number from both sides, a proof of one and a member on the other."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from lure.analysis.certificates import codes
from lure.analysis.verdict import Verdict
from lure.record import Record, derived

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked
    from lure.analysis.certificates.codes import Code

_WORDS = ("criterion", "witness", "reason")
_FIRST = ("kind", "verdict", "evidence", *_WORDS, "code", "stopped", "classes")


class TwoSided(Record):
    """The base of answers about a gain, a rate, a region, a steady response: one shape of JSON for all.

    What has no value is None, or empty text for words.  ``certificates`` has the keys ``low`` and ``high``, after the
    end of the numbers that each shows.  A subclass says its ``_schema``, has a ``verdict``, and in ``_sides`` what the
    checker accepted of both ends.
    """

    _schema: ClassVar[str] = ""

    @property
    @derived(plainly=lambda code: None if code is None else code.identifier)
    def code(self) -> Code | None:
        """The code of the reason; None with a verdict."""
        if getattr(self, "verdict") is not Verdict.INCONCLUSIVE:  # noqa: B009  (a field or a property, as they have it)
            return None
        return codes.OUT_OF_TIME if getattr(self, "stopped", None) == "time" else codes.NO_MULTIPLIER

    @property
    @abstractmethod
    def _sides(self) -> tuple[Checked | None, Checked | None]:
        """What the checker accepted of the lower and of the upper end."""

    @property
    def certificates(self) -> dict[str, Mapping[str, Any] | None]:
        """The certificates of the lower and of the upper end, None where there is none."""
        low, high = (None if shown is None else shown.certificate for shown in self._sides)
        return {"low": low, "high": high}

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data with both certificates; infinite numbers are the text ``inf``."""
        own = super().to_dict()
        first = {key: own.pop(key, "" if key in _WORDS else None) for key in _FIRST}
        return {"schema": self._schema} | first | own | {"certificates": self.certificates}
