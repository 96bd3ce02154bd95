"""Loops side by side: the channels and states of a plant that do not interact, each by itself; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from . import states
from .arithmetic import INF, ZERO, eliminated, fields, form, integer, need, number, numbers
from .balls import dot
from .channels import DELAYS, SCALAR, Channels, Plant, Rows, channels, characteristic, described, plant

THEOREMS = ("parts", "cascade")
METHODS, PLACE = ("parts", "part"), ("channels", "states", "kind")
LATE = 10
WEAKER = (12, 0, LATE, 4, 5)  # constant gains are stable, 0 attracts, with inputs too, equilibria, all are bounded


def examined(
    judged: Any, ends: Any, verdict: str, name: str, data: Any, system: Any, given: Any, phi: Any, proof: Any, rate: Any
) -> tuple[bool, int, dict[str, str], str]:
    """As of several nonlinearities, each loop by itself, ``judged`` with one of the conclusions ``ends``.

    A solution of the whole is one of each part at the same time, one nonlinearity in several parts included, and 0 in
    all parts but one is a solution of these.  Where dead times are in one, the others have inputs of finite energy
    too: every theorem about them is of a strict inequality, with a form ``V`` or over all frequencies, from which
    those add a multiple of their energy.  So it is in a cascade, where a part is driven by those before it: with
    ``sigma = H mu + e``, where ``e`` and (in continuous time) ``e'`` have finite energy, ``x``, ``phi`` and ``x'``
    have, and ``x`` tends to 0.
    """
    need(rate is None and phi is None, "of loops side by side neither rates nor one nonlinearity are shown")
    H = plant(system, True)
    asked = channels(given, len(H.D))
    need(asked.performance is None, "a gain from w to z is not one of loops side by side")
    facts, assumed = {"class": described(asked)}, list[str]()
    if verdict == "REFUTED":
        _, *where, inner = fields(proof, "method", *PLACE, "proof")
        need((name, data) == ("counterexample", {}), "a refutation is a counterexample")
        form(isinstance(inner, dict) and inner.get("method", "part") not in METHODS, "a proof is missing")
        one, laws, words = part(H, asked, given, *where)
        _, conclusion, found, _ = judged(verdict, one, laws, None, name, data, inner)
        facts |= {"part": f"the loop of {words} does not touch the others"} | found | facts
        return False, ends.index(conclusion), facts, ""
    _, listed, *basis = fields(proof, "method", "parts", *["basis"] * ("basis" in proof))
    form(isinstance(listed, list) and len(listed) > 1 and fields(data) == [], "there are two parts or more")
    need(name in THEOREMS, f"there is no theorem {name!r:.40} of loops side by side")
    entries = [fields(entry, *PLACE, "theorem", "multiplier", "proof") for entry in listed]
    H = turned(H, *basis) if basis else H
    if name == "cascade":
        bounded = all(INF not in map(abs, family.sector) and not family.rough for family in asked.families)
        need(bounded, "in a cascade a class has no finite bounds, or nonlinearities that jump")
        H = driven(H, [(channels_of, states_of) for channels_of, states_of, *_ in entries])
    seen, found_ends = (list[int](), list[int]()), [0]
    for *where, theorem, multiplier, inner in entries:
        form(isinstance(theorem, str) and theorem not in THEOREMS, "the theorem of a part is none")
        form(isinstance(inner, dict) and inner.get("method", "parts") not in METHODS, "a proof is missing")
        one, laws, words = part(H, asked, given, *where)
        _, conclusion, found, more = judged(verdict, one, laws, None, theorem, multiplier, inner)
        need(ends.index(conclusion) in WEAKER, f"of {words} something else is shown")
        need(found.get("solvable") != states.SOLVABLE, f"the class of {words} is a smaller one")
        facts[words] = "; ".join([theorem, *(f"{key}: {fact}" for key, fact in found.items() if key != "class")])
        assumed += [f"in {words} {more}"] * bool(more)
        found_ends.append(ends.index(conclusion))
        for total, own in zip(seen, where):
            total.extend(own)
    whole = [[*range(1, len(side) + 1)] for side in (H.D, H.A)]
    need([sorted(x) for x in seen] == whole, "the parts are not the whole")
    weakest = max(found_ends, key=WEAKER.index)
    need(weakest == 0 or name == "parts", "in a cascade 0 attracts in each part")
    if LATE in found_ends:
        need(weakest == LATE, "dead times and eigenvalues 0 are not both covered")
        need(all(family.sector[1] != INF for family in asked.families), "beside dead times there are upper bounds")
    facts["parts"] = "no entry of the matrices joins the states and channels of one part to those of another"
    if name == "cascade":
        facts["parts"] = "each part is driven by those before it alone, through the states, or inputs in discrete time"
    return True, weakest, facts, " and ".join(assumed)


def turned(H: Plant, basis: Any) -> Plant:
    """The plant of ``z``, ``x = S z``, ``S`` given by rows."""
    n = len(H.A)
    form(isinstance(basis, list) and len(basis) == n, "the basis has other rows")
    S = [numbers(row, n) for row in basis]
    columns = [*zip(*S)]
    AS, CS = ([[dot(row, column) for column in columns] for row in side] for side in (H.A, H.C))
    found = eliminated(S, [[*row, *b] for row, b in zip(AS, H.B)])
    need(found is not None and not H.late, "the basis is singular, or there are dead times")
    assert found is not None
    return H._replace(A=[row[:n] for row in found], B=[row[n:] for row in found], C=CS)


def driven(H: Plant, places: Any) -> Plant:
    """The plant without what parts do to those after them, there being nothing else between parts."""
    of = [{i: k for k, where in enumerate(places) for i in where[side]} for side in (0, 1)]
    sizes = zip(of, (H.D, H.A))
    form(all({*own} == {*range(1, len(side) + 1)} for own, side in sizes), "the parts are not the whole")
    need(not H.late, "cascades with dead times are not covered")

    def own(side: Any, left: int, right: int) -> Rows:
        """What is left of a matrix."""
        rank = [[(of[left][i + 1], of[right][j + 1]) for j in range(len(row))] for i, row in enumerate(side)]
        forward = all(not v or k >= l for row, ks in zip(side, rank) for v, (k, l) in zip(row, ks))
        need(forward, "a part is driven by a later one")
        return [[v if k == l else ZERO for v, (k, l) in zip(row, ks)] for row, ks in zip(side, rank)]

    found = H._replace(A=own(H.A, 1, 1), B=own(H.B, 1, 0), C=own(H.C, 0, 1), D=own(H.D, 0, 0))
    need(H.discrete or found.D == H.D, "in continuous time D joins parts")
    return found


def part(H: Plant, asked: Channels, given: Any, listed: Any, own: Any, kind: Any) -> Any:
    """The system and the class of some channels and states, counted from 1, that no others touch; and which they are.

    Of one channel also by the transfer function ``c (s - A)^-1 b + d``, with ``c adj(s - A) b = det(s - A + b c) -
    det(s - A)``.
    """
    form(isinstance(listed, list) and isinstance(own, list) and min(len(listed), len(own)) > 0, "a part is empty")
    need(not H.rates, "parts of neutral equations are not covered")
    rows, inside = [integer(i, 1, len(H.D)) - 1 for i in listed], [integer(i, 1, len(H.A)) - 1 for i in own]
    form(all(a < b for x in (rows, inside) for a, b in pairwise(x)), "channels or states of a part do not ascend")
    joint = [b for b in asked.operators if asked.families[b[0]].operator not in (SCALAR, *DELAYS)]
    need(all({*b} <= {*rows} or not {*b} & {*rows} for b in joint), "an operator acts on channels of several parts")

    def cut(side: Any, left: list[int], right: list[int]) -> Any:
        """The rows and columns of this part, if it has no other entries, as they stand in a certificate."""
        apart = all(not v or (i in left) is (j in right) for i, row in enumerate(side) for j, v in enumerate(row))
        need(apart, "an entry of the matrices joins a part to the others")
        return [[str(side[i][j]) for j in right] for i in left]

    sides = dict(zip("ABCD", (cut(H.A, inside, inside), cut(H.B, inside, rows), cut(H.C, rows, inside))))
    sides["D"] = cut(H.D, rows, rows)
    back = [[cut(A, inside, inside)] for A in H.inner] or [list[Any]() for _ in H.late]
    late = [[str(tau), cut(C, rows, inside), *more] for (tau, C), more in zip(H.late, back)]
    late = [one for one in late if any(v != "0" for side in one[1:] for row in side for v in row)]
    time = {"time": "discrete" if H.discrete else "continuous"}
    words = f"channel{'s' * (len(rows) > 1)} {', '.join(map(str, listed))}"
    if kind in ("multivariable", "multivariable delay"):
        form(kind == "multivariable" + " delay" * bool(late), "the kind of a part is another")
        sizes = [size for block in asked.blocks if (size := len({*block} & {*rows}))]
        laws = {"channels": [given["channels"][i] for i in rows], "repeated": sizes}
        return {"kind": kind} | time | sides | ({"late": late} if late else {}), laws, words
    form(kind in ("transfer", "delay", "state-space") and len(rows) == 1, "the kind of a part is none, of one channel")
    form((kind == "delay") is bool(late) and not H.inner, "the kind of a part is another")
    ([*b],), (c,), ((d,),) = zip(*sides["B"]), sides["C"], sides["D"]
    if kind == "state-space":
        found = {"kind": kind} | time | {"A": sides["A"], "b": b, "c": c, "d": d}
        return found, given["channels"][rows[0]], words
    A, inward, tops = [numbers(row) for row in sides["A"]], numbers(b), list[list[Any]]()
    bottom = characteristic(A)
    for tau, seen in [("0", c), *((one[0], one[1][0]) for one in late)]:
        moved = characteristic([[v - x * y for v, y in zip(row, numbers(seen))] for row, x in zip(A, inward)])
        top = [u + (number(d) * (tau == "0") - 1) * v for u, v in zip(moved, bottom)]
        lead = next((i for i, v in enumerate(top) if v), len(top) - 1)
        tops.append([tau, [str(v) for v in top[lead:]]])
    below = [str(v) for v in bottom]
    if kind == "transfer":
        found = {"kind": kind} | time | {"numerator": tops[0][1], "denominator": below}
    else:
        terms = [one for one in tops if one[1] != ["0"]]
        found = {"kind": kind, "terms": terms, "denominator": below}
    return found, given["channels"][rows[0]], words
