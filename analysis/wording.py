"""What a certificate says, in words: its class, what follows for the solutions, and its counterexample."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import accumulate, groupby, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from lure.analysis.numerics.doubles import bound_above, bound_below
from lure.classes import FULL_BLOCK, in_channels, operator_words
from lure.record import decimal_text, exact_text, value_text

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted

BEYOND = "Not shown: a rate of decay, a bound on the size of the solution, anything about external inputs."

Nonlinearities = Mapping[str, Any]
Spelled = Mapping[Fraction, str]

_DOES = {  # by the conclusion of a refutation, from the checker
    "a loop of the class has a motion that does not converge to an equilibrium": "destabilises the loop",
    "a loop of the class has equilibria other than 0": "gives the loop other equilibria than 0",
    "the L2 gain from w to z is above gamma in a loop of the class": "gives the loop a larger L2 gain",
    "no L2 gain from w to z is finite for all loops of the class": (
        "gives the loop a transfer function from w to z with a pole that is not strictly stable"
    ),
    "a loop of the class is not well posed: 1 + g H(inf) = 0": "leaves the loop without exactly one solution",
}
_LONG = 300  # characters of one part of a plant
_DOUBLE, _DIGITS = 24, 60  # characters of p/q: fewer are read as they stand, more than the second are rounded
_NUMBER = re.compile(r"(?:= )?(?<![\w.])(-?\d+(?:/\d+)?)(?!\w|\.\d)(?: \(about [^)]*\))?")
_LISTED = 8  # gains, beyond which equal ones are counted
_ORBITS = ("orbit", "flow-orbit", "memory-orbit", "sampled-orbit")
_MOVING = ("switched-gains", "ramped-gains", "members")
_LATE = ("late-gains", "late-turns", "late-crossing")


def class_words(nonlinearities: Nonlinearities, *, inwards: bool = True, spelled: Spelled | None = None) -> str:
    """The class of nonlinearities of a certificate, such as ``odd phi with slope in [0, 2]``.

    Every phi has ``phi(0) = 0``; a phi is locally Lipschitz unless ``regularity`` says otherwise.

    Parameters
    ----------
    nonlinearities : Mapping
        ``laws`` of a certificate, see ``notebooks/notes/0008-certificates.md``; of several channels one after another.
    inwards : bool
        Whether bounds are rounded into the class, as for a proof; else out of it, as for a refutation.
    spelled : Mapping of Fraction to str, optional
        Numbers with the text that the reader gave them.

    Examples
    --------
    >>> entry = {"sector": ["0", "2"], "slope": ["0", "2"], "odd": True, "time_varying": False, "linear": False}
    >>> class_words(entry), class_words({**entry, "slope": None, "odd": False, "sector": ["1/3", "finite"]})
    ('odd phi with slope in [0, 2]', 'phi, time-invariant, in the sector [0.3333334, inf)')
    """
    if "channels" in nonlinearities:
        each = [class_words(one, inwards=inwards, spelled=spelled) for one in nonlinearities["channels"]]
        return in_channels(each, same_in(nonlinearities))
    if "memory" in nonlinearities:
        slope = interval(nonlinearities["slope"], inwards=inwards, spelled=spelled)
        return f"{nonlinearities['memory']} phi of a slope in {slope}"
    if "relu" in nonlinearities:
        low, high = map(Fraction, nonlinearities["slope"])
        leak = f" + {_number(low, up=inwards, spelled=spelled)} min(sigma, 0)" if low else ""
        return f"phi = {'' if high == 1 else _number(high, up=not inwards, spelled=spelled) + ' '}max(sigma, 0){leak}"
    if nonlinearities.get("operator", FULL_BLOCK) != FULL_BLOCK:
        bound, gain = Fraction(nonlinearities["sector"][1]), nonlinearities["operator"] == "performance"
        about = _number(1 / bound if gain else bound, up=inwards is gain, spelled=spelled)
        slow = nonlinearities.get("rate")
        paced = "" if slow is None else _number(Fraction(slow), up=not inwards, spelled=spelled)
        return operator_words(nonlinearities["operator"], about, paced)
    sector, slope = interval(nonlinearities["sector"], inwards=inwards, spelled=spelled), nonlinearities["slope"]
    bounds = sector if slope is None else interval(slope, inwards=inwards, spelled=spelled)
    words = f"{kind_words(nonlinearities)} {bounds}"
    words += "" if slope is None or list(slope) == list(nonlinearities["sector"]) else f", in the sector {sector}"
    if "rate" in nonlinearities:
        rate = _number(Fraction(nonlinearities["rate"]), up=not inwards, spelled=spelled)
        words += f", its gain at a rate of at most {rate}"
    return words


def same_in(several: Mapping[str, Any]) -> list[range]:
    """The channels, counted from 0, of each nonlinearity of a certificate about several.

    ``several``: ``laws`` of such a certificate.
    """
    m, repeated = len(several["channels"]), several["repeated"]
    sizes = ([m] if repeated else [1] * m) if isinstance(repeated, bool) else repeated
    ends = list(accumulate(sizes))
    return [range(end - size, end) for end, size in zip(ends, sizes, strict=True)]


def kind_words(nonlinearities: Nonlinearities) -> str:
    """The class without its bounds, such as ``odd phi with slope in``.

    ``nonlinearities``: ``laws`` of a certificate.
    """
    phi = f"{'odd ' if nonlinearities['odd'] else ''}{'linear ' if nonlinearities['linear'] else ''}phi"
    varying, rough = (
        nonlinearities["time_varying"],
        ", continuous or not," if nonlinearities.get("regularity") == "any" else "",
    )
    if nonlinearities["slope"] is None:
        when = "" if nonlinearities["linear"] else " time-varying," if varying else " time-invariant,"
        kind = "full-block sector" if "operator" in nonlinearities else "sector"
        return f"{phi}{rough or ',' * bool(when)}{when} in the {kind}"
    return f"{'time-varying ' if varying else ''}{phi}{rough} with slope in"


def interval(ends: Sequence[str], *, inwards: bool = True, spelled: Spelled | None = None) -> str:
    """Two bounds of a certificate as ``[l, k]``, ``[l, inf)`` for every finite ``k``, ``[l, inf]`` for no bound at all.

    Parameters
    ----------
    ends : sequence of str
        The bounds as text ``p/q``, ``-inf``, ``finite`` or ``inf``.
    inwards : bool
        Whether they are rounded towards each other.
    spelled : Mapping of Fraction to str, optional
        Numbers with the text that the reader gave them.
    """
    low, high = ends
    start = low if low == "-inf" else _number(Fraction(low), up=inwards, spelled=spelled)
    if high in ("finite", "inf"):
        return f"[{start}, inf{')' if high == 'finite' else ']'}"
    return f"[{start}, {_number(Fraction(high), up=not inwards, spelled=spelled)}]"


def _number(value: Fraction, *, up: bool, spelled: Spelled | None) -> str:
    return (spelled or {}).get(value) or (bound_above(value) if up else bound_below(value))


def meaning(shown: Proved, subject: str = "") -> str:
    """What is proved of the solutions, from the conclusion of the certificate.

    ``subject``: what moves, where it has a name.
    """
    conclusion = str(shown.certificate["conclusion"])
    said = f"The point {conclusion}" if conclusion.startswith("0 ") else conclusion[0].upper() + conclusion[1:]
    said = said.replace("zero of the law", "zero of the nonlinearity")
    if subject:
        return said.replace("motion", f"motion of {subject}", 1)
    return said if "comes to rest" in said else said.replace("motion", "solution", 1)  # the rod's are motions


def plain(claim: str) -> str:
    """A sentence of a certificate in the words of the field: solutions and nonlinearities for its motions and laws.

    A certificate's own sentences are part of its format, which stays.  What comes to rest is a rod, whose motions stay.
    Numbers of more than 60 digits are rounded, and doubles are the decimals they were given as: both are said to be.

    ``claim``: a conclusion, a fact or an assumption of a certificate.

    Examples
    --------
    >>> plain("every motion is bounded: all time-varying laws with phi(0) = 0")
    'every solution is bounded: all time-varying nonlinearities with phi(0) = 0'
    >>> plain(f"slope from 0 up to {10**300 + 1}/3, D = {Fraction(0.1)}")
    'slope from 0 up to about 3.33333333e+299, D about 0.1'
    """
    said = _NUMBER.sub(_short, claim)
    said = re.sub(r"\b(time-invariant|time-varying) laws\b", r"\1 nonlinearities", said)
    said = said.replace("zero of the law", "zero of the nonlinearity")
    return said if "comes to rest" in said else re.sub(r"\bmotion(s?)\b", r"solution\1", said)


def _short(found: re.Match[str]) -> str:
    """A number as it stands, or rounded where it is long, in place of the rounded one that may stand beside it."""
    number = found[1]
    if not _DOUBLE < len(number) < sys.int_info.default_max_str_digits:
        return found[0]
    text = decimal_text(Fraction(number), 9)
    return f"about {text}" if len(number) > _DIGITS or Fraction(float(text)) == Fraction(number) else found[0]


def loop_words(certificate: Mapping[str, Any]) -> str:
    """The loop that a certificate is about: sign convention, plant and given phi, exactly, long parts cut off.

    Examples
    --------
    >>> system = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "1/3"]}
    >>> loop_words({"convention": "sigma = H mu, mu = -phi(sigma)", "system": system})
    'sigma = H mu, mu = -phi(sigma); kind transfer, time continuous, numerator [1], denominator [1, 1/3]'
    """
    law = certificate.get("law")
    given = certificate["system"] | ({} if law is None else {"phi": law})
    texts = ((name, json.dumps(value).replace('"', "")) for name, value in given.items())
    parts = (f"{name} {text if len(text) <= _LONG else text[:_LONG] + ' ...'}" for name, text in texts)
    return f"{certificate['convention']}; {', '.join(parts)}"


def destroys(shown: Refuted) -> str:
    """What the counterexample does to the loop, from the conclusion of the certificate."""
    conclusion = str(shown.certificate["conclusion"])
    if method_of(shown) == "relu-ray":
        return "lets a solution grow without bound"
    moves = conclusion.endswith("converge to an equilibrium")
    does = "makes the loop oscillate" if moves and method_of(shown) in _ORBITS else _DOES[conclusion]
    verb, _, rest = does.partition(" ")
    said = counterexample(shown)
    alone = said.startswith(("phi = ", "the gain ", "the matrix ")) and " and " not in said
    several = not alone and (
        method_of(shown) in ("linear-gains", "linear-members", *_LATE, *_MOVING) or " and the gains" in said
    )
    return f"{verb[:-1]} {rest}" if several else does


def counterexample(shown: Refuted) -> str:
    """The destabilising nonlinearity of a certificate in words, and the parameters of the plant if it has any."""
    found, whole, system = _destabilising(_one(shown)), shown.certificate["proof"], shown.certificate["system"]
    if whole["method"] == "part":
        where = whole["channels"]
        return f"{found} in channel{'s' * (len(where) > 1)} {', '.join(map(str, where))}"
    if whole["method"] != "member":
        return found
    values = zip(system["parameters"], whole["at"], strict=True)
    return f"{found} at {', '.join(value_text(name, Fraction(v)) for (name, *_), v in values)}"


def plants_words(system: Mapping[str, Any], *, inwards: bool = True) -> str:
    """For which plants something is proved, such as `` for every a in [1, 2]``; empty for a single one.

    ``system``: ``system`` of a certificate.  ``inwards``: whether the ends of the box are rounded into it, as for a
    proof; else out of it.
    """
    if not str(system.get("kind")).endswith("family"):
        return ""
    rates = system.get("rates") or ["0"] * len(system["parameters"])
    most = {one: _number(Fraction(one), up=not inwards, spelled=None) for one in rates if one != "inf"}
    how = {one: f" that changes by at most {most[one]} in a unit of time" for one in most}
    how |= {"0": "", "inf": " that changes at any speed"}
    varied = [
        f"{name} in {interval(ends, inwards=inwards)}{how[rate]}"
        for (name, *ends), rate in zip(system["parameters"], rates, strict=True)
        if ends[0] != ends[1]
    ]
    return f" for every {', '.join(varied)}"


def _beside_operators(shown: _Shown) -> list[str]:
    """The constant gains of a counterexample in the channels without operators."""
    kinds = shown.certificate["laws"]["channels"]
    return [gain for gain, one in zip(_proof(shown)["gains"], kinds, strict=True) if "operator" not in one]


def _destabilising(shown: _Shown) -> str:
    proof, method = _proof(shown), method_of(shown)
    if method in ("linear-gain", "matrix-gain"):
        return linear_gain(Fraction(proof["gain"]))
    if method == "linear-members":
        own = _beside_operators(shown)
        words = [_linear(shown, own)] if own else []
        return " and ".join(words + ["all-pass operators"] * bool(proof["operators"])) or "the linear loop"
    if method == "delayed-members":
        own = _beside_operators(shown)
        delays = [f"a delay of {_told(Fraction(tau))}" for tau in proof["delays"]]
        return " and ".join([*delays, *([_linear(shown, own)] if own else [])])
    if method == "signal":
        steps = "steps" if "times" in proof else "samples"
        jumps = " with gains that jump" if any(isinstance(one[0], list) for one in proof["slopes"]) else ""
        return f"a disturbance of {len(proof['inputs'])} {steps}, from rest,{jumps}"
    if method == "delayed-gains":
        own, i = _beside_operators(shown), int(proof["channel"])
        size = f"{proof['samples']} samples" if "samples" in proof else _told(Fraction(proof["delays"][1]))
        late = f"a delay of {size} in channel {i}"
        return f"{late} and the gains {_about(own)}{_row(own)}" if own else late
    if "matrices" in proof:
        own = _beside_operators(shown)
        rows = [f"{_about(*one)}[{'; '.join(map(_row, one))}]" for one in proof["matrices"]]
        matrices = " and ".join(f"the matrix of gains {text}" for text in rows)
        return f"{_linear(shown, own)} and {matrices}" if own else matrices
    if method in ("linear-gains", *_LATE):
        kinds, gains = shown.certificate["laws"]["channels"], proof["gains"]
        each = zip(gains[0] if method == "late-crossing" else gains, kinds, strict=True)
        return _linear(shown, [gain for gain, one in each if one.get("operator") != "performance"])
    if method == "members":
        return _moving(shown.certificate["system"], proof)
    if method in _MOVING:
        about, (first, second) = _about(*proof["gains"]), map(_row, proof["gains"][:2])
        more = f" and {len(proof['gains']) - 2} more" if len(proof["gains"]) > 2 else ""
        if method == "ramped-gains":
            return f"gains that go linearly from {about}({first}) to ({second}){more}, over and over again"
        return f"the gains {about}({first}), then ({second}){more}, over and over again"
    if method == "relu-ray":
        about, rows = _about(*proof["gains"]), [f"({_row(row)})" for row in proof["gains"]]
        more = f" and {len(rows) - 3} more" if len(rows) > 3 else ""
        turns = ", again and again" * (len(rows) > 1)
        return f"that along which the gains are {about}{', then '.join(rows[:3])}{more}{turns}"
    if method == "crossing":
        return f"phi = k sigma with k about {_near(Fraction(proof['gains'][0]))}"
    if method == "switched-gain":
        gains = [Fraction(gain) for gain in proof["gains"]]
        return f"phi = k(t) sigma with k(t) between {_told(min(gains))} and {_told(max(gains))}, over and over again"
    return _of_orbit(shown)


def _of_orbit(shown: _Shown) -> str:
    """A nonlinearity with a solution that repeats, on another scale too, or that rests."""
    proof, method = _proof(shown), method_of(shown)
    if method == "flow-orbit":
        period = sum(map(Fraction, proof["durations"])) * (2 if proof["half"] else 1)
        graphs = [_graph(one) for one in proof.get("nonlinearities", [proof])]
        return f"{'; '.join(graphs)}, period {float(period):.7g} s"
    if method == "memory-orbit":
        kinds, period = shown.certificate["laws"]["channels"], 2 * sum(map(Fraction, proof["durations"]))
        parts = [
            f"a {one['memory']} of slope {_told(Fraction(gain))}"
            if "memory" in one
            else f"the gain {_told(Fraction(gain))}"
            for gain, one in zip(proof["gains"], kinds, strict=True)
        ]
        return f"{', '.join(parts)}, of any width, period {float(period):.7g} s"
    if "scale" in proof:
        scale = _told(Fraction(proof["scale"]))
        return f"a phi that is linear between {len(proof['u'])} points and their multiples by powers of {scale}"
    if method == "orbit":
        return _graph(proof)
    if method == "equilibrium":
        return "; ".join(_graph(one) for one in proof["nonlinearities"])
    if method == "sampled-orbit":
        graphs, period = [_graph(one) for one in proof["nonlinearities"]], len(proof["inputs"]) * (1 + proof["half"])
        return f"{'; '.join(graphs)}, period {period} samples"
    return "a nonlinearity of the class"


def _moving(system: Mapping[str, Any], proof: Mapping[str, Any]) -> str:
    """Parameters that move, and the gains beside them."""
    names = [name for name, *_ in system["parameters"]]
    rates = system.get("rates") or ["0"] * len(names)
    paths = [[Fraction(point[j]) for point in proof["at"]] for j in range(len(names))]
    said = list[str]()
    for name, path, rate in zip(names, paths, rates, strict=True):
        if len(set(path)) == 1:
            said.append(value_text(name, path[0]))
            continue
        moves = "jumping" if rate == "inf" else "going"
        said.append(f"{name} {moves} to and fro between {_told(min(path))} and {_told(max(path))}")
    rows = [tuple(row) for row in dict.fromkeys(tuple(row) for row in proof["gains"])]
    about = _about(*rows)
    beside = f"the gain{'s' * (len(rows[0]) > 1)} {about}{_row(rows[0])}"
    if len(rows) > 1:
        more = f" and {len(rows) - 2} more" if len(rows) > 2 else ""
        beside = f"gains that jump between {about}({_row(rows[0])}) and ({_row(rows[1])}){more} over and over"
    return f"parameters with {', '.join(said)} and {beside}"


def _linear(shown: _Shown, gains: Sequence[str]) -> str:
    """The gains of several channels; beside a performance channel one gain may be alone."""
    exact = [Fraction(gain) for gain in gains]
    asked = any(one.get("operator") == "performance" for one in shown.certificate["laws"]["channels"])
    if asked and len(exact) == 1:
        return linear_gain(exact[0])
    texts, about = [_near(gain) for gain in exact], _about(exact)
    if len(texts) > _LISTED:
        runs = [(text, len(list(run))) for text, run in groupby(texts)]
        texts = [f"{text} ({times} times)" if times > 1 else text for text, times in runs]
    if len(exact) > 1 == len(texts):
        return f"the gain {about}{_near(exact[0])} in all of {len(exact)} channels"
    return (
        constant_gains([about + texts[0], *texts[1:]])
        if asked
        else f"the gain{'s' * (len(texts) > 1)} {about}{', '.join(texts)}"
    )


def constant_gains(gains: Sequence[str]) -> str:
    """Constant gains in words: ``phi = 2 sigma``, ``phi = 0``, or of several channels ``the constant gains 0.5, 0``.

    ``gains``: the gains as they are to be read.
    """
    if len(gains) > 1:
        return f"the constant gains {', '.join(gains)}"
    return "phi = 0" if gains[0] == "0" else f"phi = {({'1': '', '-1': '-'}).get(gains[0], gains[0] + ' ')}sigma"


def linear_gain(gain: Fraction) -> str:
    """A constant gain in words: exactly where that is short, else about; rounded it may behave otherwise.

    Examples
    --------
    >>> linear_gain(Fraction(1)), linear_gain(Fraction(5, 2)), linear_gain(Fraction(10**9 + 1, 10**9))
    ('phi = sigma', 'phi = 2.5 sigma', 'phi = k sigma with k about 1')
    """
    text = exact_text(gain, 7)
    return constant_gains([text]) if Fraction(text) == gain else f"phi = k sigma with k about {text}"


def method_of(shown: _Shown | Refuted) -> str:
    """The method of a refutation, of one plant of a box that for this plant; ``shown``: what was accepted."""
    return str(_proof(shown)["method"])


def _proof(shown: _Shown | Refuted) -> Mapping[str, Any]:
    """The proof of a refutation, of one plant of a box that of the loop with this plant, of one part that of it."""
    proof: Mapping[str, Any] = shown.certificate["proof"]
    return proof["proof"] if proof["method"] in ("member", "part") else proof


class _Shown(NamedTuple):
    """What a certificate is about."""

    certificate: Mapping[str, Any]


def _one(shown: Refuted) -> _Shown:
    """A refutation, of one part of the loop as if there were nothing else."""
    certificate = shown.certificate
    if certificate["proof"]["method"] != "part":
        return _Shown(certificate)
    own, laws = [i - 1 for i in certificate["proof"]["channels"]], certificate["laws"]
    sizes = [size for block in same_in(laws) if (size := len({*block} & {*own}))]
    several = {"channels": [laws["channels"][i] for i in own], "repeated": sizes}
    alone = "multivariable" not in certificate["proof"]["kind"]
    about = several["channels"][0] if alone else several
    return _Shown({**certificate, "laws": about, "proof": certificate["proof"]["proof"]})


def _graph(proof: Mapping[str, Any]) -> str:
    """A piecewise linear nonlinearity: the dead zone and the saturation by name, others by their corners."""
    points = sorted((Fraction(x), Fraction(w)) for x, w in proof["points"])
    left, right = Fraction(proof["left"]), Fraction(proof["right"])
    if len(points) == 1 and left == right:
        return linear_gain(left)
    inner = [(w - v) / (x - y) for (y, v), (x, w) in pairwise(points)]
    (first, at_first), (last, at_last) = points[0], points[-1]
    if left == right and first == -last and at_first == -at_last and len(set(inner)) == 1:
        if inner[0] == 0:
            return f"a dead zone of +-{_near(last)} with slope {_told(right)}"
        if right == 0:
            return f"a saturation with slope {_told(inner[0])} up to +-{_near(last)}"
    slopes = [left, *inner, right]
    kinks = sum(a != b for a, b in pairwise(slopes))
    return f"a piecewise linear phi with {kinks} corners and slopes from {_told(min(slopes))} to {_told(max(slopes))}"


def _near(value: Fraction) -> str:
    """Exactly if that is short, else five digits: it is named here, the exact one stands in the certificate."""
    text = f"{float(value):.5g}"
    return f"{float(value):.7g}" if Fraction(f"{float(value):.7g}") == value else text


def _about(*rows: Iterable[str | Fraction]) -> str:
    """``about `` where one of the numbers is rounded: it may behave otherwise then."""
    exact = [Fraction(value) for row in rows for value in row]
    return "" if all(Fraction(_near(value)) == value for value in exact) else "about "


def _told(value: Fraction) -> str:
    """A number exactly, or after ``about``."""
    return _about([value]) + _near(value)


def _row(values: Iterable[str]) -> str:
    """Numbers one after another."""
    return ", ".join(_near(Fraction(value)) for value in values)


def proviso(shown: Proved) -> str:
    """What the certificate assumes of ``phi`` beyond its class, where ``H(inf)`` is not 0; empty if nothing.

    With ``D = H(inf)``, ``y = sigma + D phi(sigma)`` must determine ``sigma``.  Finite slope bounds of the class show
    it, where ``1 + D phi'`` keeps its sign; else the checker says what is assumed, and that is part of what is said.
    """
    return f"for which {plain(shown.assumed)}" if shown.assumed else ""


def direct_term(system: Mapping[str, Any]) -> Fraction:
    """``H(inf)`` of the system of a certificate."""
    if system["kind"] == "state-space":
        return Fraction(system["d"])
    if system["kind"] != "transfer" or len(system["numerator"]) < len(system["denominator"]):
        return Fraction(0)
    return Fraction(system["numerator"][0]) / Fraction(system["denominator"][0])
