"""Rods with several contacts themselves, not their scheme: the energy theorem, with its certificate."""

from __future__ import annotations

from typing import Any

from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked
from lure.errors import AssumptionError, Reason
from lure.rod.assembly import RodAssembly
from lure.rod.transfer import certificate_parameters


def of_the_rods(assembly: RodAssembly) -> tuple[str, Proved | None]:
    """What a report on their scheme says of the rods themselves, and what the checker accepted; None if nothing.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.
    """
    head = f"All other answers are about the upwind scheme. Of the rods themselves, {assembly.words}, "
    try:
        shown = rods_at_rest(assembly)
    except AssumptionError as refused:
        return f"{head}nothing is proved: {refused}.", None
    laws = "whatever the pressures are, if they oppose the closing of their contacts and are locally Lipschitz"
    return f"{head}it is proved without loads that {shown.certificate['conclusion']}, {laws} (certified).", shown


def rods_at_rest(assembly: RodAssembly) -> Proved:
    """That every motion of the rods comes to rest, for all pressures that oppose the closing of their contacts.

    A theorem about the partial differential equations (docs/theory/several-rods.md), for every stiffness: ``E' = - sum
    k v(t, 0)^2 - k_o w'^2``.  The pressures are locally Lipschitz functions of ``sigma_i`` with ``sigma_i p_i >= 0``,
    ``mu_i = -p_i``; the contact laws of the assembly are such.  Nothing is said of loads, or of a rate.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.

    Returns
    -------
    Proved
        What the checker accepted; ``claim`` is the sentence, ``certificate`` the certificate.

    Raises
    ------
    AssumptionError
        A dashpot has ``k <= 0``: energy is not lost.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=210e9, density=7850, length=1, area=1e-4, damping=800, compliance=1)
    >>> one, none = (Fraction(1),) * 2, (Fraction(0),) * 2
    >>> between = RodAssembly(arrangement="both-ends", rods=(rod,), compliances=one, gaps=none)
    >>> print(rods_at_rest(between).certificate["conclusion"])
    every motion of finite energy comes to rest, and the pressure of every contact tends to 0
    """
    for number, rod in enumerate(assembly.rods, 1):
        if not rod.damping > 0:
            raise AssumptionError(
                f"[[rod]] number {number}: its damping is {rod.damping:g}, and the energy of the rods falls only where "
                "every dashpot damps; give a positive one",
                code=Reason.UNDAMPED,
            )
    pressure: dict[str, Any] = {
        "sector": ["0", "inf"],
        "slope": None,
        "odd": False,
        "time_varying": False,
        "linear": False,
    }
    plate = assembly.obstacle_damping
    found = checked(
        {
            "verdict": "PROVED",
            "numbers": "decimals as written",
            "system": {
                "kind": "rods",
                "arrangement": assembly.arrangement,
                "rods": [certificate_parameters(rod) for rod in assembly.rods],
                "obstacle": None if plate is None else str(plate),
            },
            "laws": {"channels": [pressure] * assembly.contacts, "repeated": False},
            "theorem": "rods-energy",
            "multiplier": {},
            "proof": {"method": "structure"},
        }
    )
    assert isinstance(found, Proved), "the draft says so"
    return found
