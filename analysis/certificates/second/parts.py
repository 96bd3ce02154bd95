"""Loops side by side, checked again: each as a document of its own, from the plant's matrices by its power series.

The states and channels of a part are invariant: ``A``, ``B``, ``C`` and ``D`` commute with the projections on them.  Of
one channel the numerator is the polynomial part of ``det(s - A) (d + sum c A^k b s^(-k - 1))``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from flint import fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channels import Asked, read
from lure.analysis.certificates.second.classes import SCALAR
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.reading import (
    Document,
    count,
    listed,
    mapping,
    numbers,
    record,
    require,
    text,
    tick,
)

ONE, ALL, CASCADE = "part", "parts", "cascade"
_DELAYS = ("delay", "varying delay")
_STRENGTH = {claims.GAINS: 0, claims.ATTRACTS: 0, claims.EQUILIBRIA: 1, claims.BOUNDED: 2}
_WHERE = ("channels", "states", "kind")


def documents(document: Document) -> list[Document]:
    """The certificates of the parts: of a proof all of them, of a refutation the one that it names.

    Raises
    ------
    NotShown
        They are no parts of this plant, or not all.
    """
    require(document.rate is None and document.nonlinearity is None, "of parts no rate and no nonlinearity is given")
    asked = read(document)
    require(not asked.performance, "a gain from w to z is not one of parts")
    if document.verdict == "REFUTED":
        require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
        found = record(document.proof, "method", *_WHERE, "proof")
        require(found["method"] == ONE, "a refutation names one part")
        return [replace(_alone(document, asked, found), proof=_proof(found))]
    known = document.theorem in (ALL, CASCADE)
    require(document.verdict == "PROVED" and known, "the verdict is neither PROVED nor REFUTED")
    require(not document.multiplier, "each part has its own multiplier")
    turned = ("basis",) * ("basis" in document.proof)
    whole = record(document.proof, "method", "parts", *turned)
    entries = listed(whole["parts"])
    asked = _turned(asked, whole["basis"]) if turned else asked
    asked = _without_drive(asked, entries) if document.theorem == CASCADE else asked
    require(len(entries) > 1 and document.proof["method"] == ALL, "there are not two parts")
    made, taken = list[Document](), {"channels": list[int](), "states": list[int]()}
    for entry in entries:
        found = record(entry, *_WHERE, "theorem", "multiplier", "proof")
        for name, total in taken.items():
            total += map(count, listed(found[name]))
        theorem, multiplier = text(found["theorem"]), mapping(found["multiplier"])
        require(theorem not in (ALL, CASCADE), "a part has parts")
        alone = _alone(document, asked, found)
        made.append(replace(alone, theorem=theorem, multiplier=multiplier, proof=_proof(found)))
    for name, size in (("channels", asked.D.nrows()), ("states", asked.A.nrows())):
        require(sorted(taken[name]) == list(range(1, size + 1)), f"the {name} are not each in one part")
    return made


def together(document: Document, said: Sequence[str]) -> str:
    """What follows of the whole from what is shown of its parts; ``said``: the sentence that is shown of each part.

    Raises
    ------
    NotShown
        Nothing follows.
    """
    if document.verdict == "REFUTED":
        (only,) = said
        return only
    if document.theorem == CASCADE:
        require(all(_STRENGTH.get(one) == 0 for one in said), "in a cascade 0 attracts in each part")
    if claims.DELAYED in said:
        kinds = {*said} - {claims.DELAYED, claims.ATTRACTS, claims.GAINS}
        require(not kinds, "dead times beside eigenvalues 0 are not covered")
        ends = [one.upper for one in read(document).nonlinearities]
        require(not {"finite", "inf"} & {*map(str, ends)}, "beside dead times a class has no upper bound")
        return claims.DELAYED
    require(all(one in _STRENGTH for one in said), "of a part something else is shown")
    weakest = max(said, key=lambda one: _STRENGTH[one])
    return claims.ATTRACTS if _STRENGTH[weakest] == 0 else weakest


def _proof(found: Mapping[str, object]) -> Mapping[str, object]:
    """The proof of a part."""
    proof = mapping(found["proof"])
    require(proof.get("method") not in (ONE, ALL), "a part has parts")
    return proof


def _turned(asked: Asked, basis: object) -> Asked:
    """The plant in other states ``z``, ``x = S z``."""
    n = asked.A.nrows()
    rows = [numbers(row) for row in listed(basis)]
    require(not asked.late and [len(row) for row in rows] == [n] * n, "the basis does not fit, or there are dead times")
    S = fmpq_mat([[to_fmpq(v) for v in row] for row in rows])
    require(S.rank() == n, "the basis is singular")
    back = S.inv()
    return replace(asked, A=back * asked.A * S, B=back * asked.B, C=asked.C * S)


def _without_drive(asked: Asked, entries: Sequence[object]) -> Asked:
    """The plant of the parts alone, after a check that each is driven by earlier ones only.

    With the projections ``E_k`` on the parts up to the ``k``-th: ``E_k side (1 - E_k) = 0``.
    """
    n, m = asked.A.nrows(), asked.D.nrows()
    require(not asked.late, "cascades with dead times are not covered")
    for one in asked.nonlinearities:
        finite = isinstance(one.upper, Fraction) and isinstance(one.lower, Fraction)
        require(finite and not one.rough, "in a cascade a class has no finite bounds, or nonlinearities that jump")
    sides = {"A": ("states", "states"), "B": ("states", "channels"), "C": ("channels", "states")}
    sides["D"] = ("channels", "channels")
    size, found = {"states": n, "channels": m}, dict[str, fmpq_mat]()
    first = {name: fmpq_mat(total, total) for name, total in size.items()}
    each = [
        {name: _projection(_places(mapping(entry).get(name), total), total) for name, total in size.items()}
        for entry in entries
    ]
    for name in sides:
        found[name] = getattr(asked, name) * 0
    for part in each:
        first = {name: first[name] + part[name] for name in size}
        for name, (left, right) in sides.items():
            side = getattr(asked, name)
            require(first[left] * side == first[left] * side * first[right], "a part is driven by a later one")
            found[name] = found[name] + part[left] * side * part[right]
    require(asked.discrete or found["D"] == asked.D, "in continuous time D joins parts")
    return replace(asked, A=found["A"], B=found["B"], C=found["C"], D=found["D"])


def _alone(document: Document, asked: Asked, found: Mapping[str, object]) -> Document:
    """A document about one part, without what proves it."""
    require(not asked.rates, "a neutral equation is not taken apart")
    n, m, kind = asked.A.nrows(), asked.D.nrows(), text(found["kind"])
    states, channels = _places(found["states"], n), _places(found["channels"], m)
    inside, own = _projection(states, n), _projection(channels, m)
    pairs = [(asked.A, inside, inside), (asked.B, inside, own), (asked.C, own, inside), (asked.D, own, own)]
    pairs += [(C, own, inside) for _, C in asked.late] + [(A, inside, inside) for A in asked.inner]
    require(all(left * side == side * right for side, left, right in pairs), "a part is joined to the others")
    _require_whole_operators(asked, channels)
    A, B, C, D = (_cut(asked.A, states, states), _cut(asked.B, states, channels), _cut(asked.C, channels, states),
                  _cut(asked.D, channels, channels))  # fmt: skip
    back = [_cut(side, states, states) for side in asked.inner]
    late = [(tau, _cut(side, channels, states)) for tau, side in asked.late]
    kept = [k for k, (_, side) in enumerate(late) if any(side.entries()) or (back and any(back[k].entries()))]
    time: dict[str, object] = {"time": "discrete" if asked.discrete else "continuous"}
    classes = listed(document.nonlinearities["channels"])
    if kind in ("multivariable", "multivariable delay"):
        require(kind.endswith("delay") is bool(kept), "a part is of another kind")
        sides: dict[str, object] = {name: _rows(side) for name, side in zip("ABCD", (A, B, C, D), strict=True)}
        if kept:
            sides["late"] = [[str(late[k][0]), _rows(late[k][1]), *([_rows(back[k])] if back else [])] for k in kept]
        firsts = [asked.repeated[i] for i in channels]
        sizes = [firsts.count(first) for first in dict.fromkeys(firsts)]
        laws = {"channels": [classes[i] for i in channels], "repeated": sizes}
        return replace(document, system={"kind": kind, **time, **sides}, nonlinearities=laws)
    require(len(channels) == 1 and not back, "a part of this kind has one channel")
    alone = replace(document, nonlinearities=mapping(classes[channels[0]]))
    if kind == "state-space":
        require(not kept, "a part is of another kind")
        vectors = {"A": _rows(A), "b": [str(v) for v in B.entries()], "c": [str(v) for v in C.entries()]}
        return replace(alone, system={"kind": kind, **time, **vectors, "d": str(D[0, 0])})
    below = A.charpoly()
    tops = [
        (None, _top(A, B, C, D[0, 0], below)),
        *((late[k][0], _top(A, B, late[k][1], fmpq(0), below)) for k in kept),
    ]
    if kind == "transfer":
        require(not kept, "a part is of another kind")
        return replace(
            alone, system={"kind": kind, **time, "numerator": tops[0][1] or ["0"], "denominator": _falling(below)}
        )
    require(kind == "delay" and bool(kept), "a part is of no kind there is")
    terms = [[str(tau or 0), top] for tau, top in tops if top]
    return replace(alone, system={"kind": kind, "terms": terms, "denominator": _falling(below)})


def _places(value: object, size: int) -> list[int]:
    """Ascending numbers from 0 of what is counted from 1."""
    found = [count(one, least=1) - 1 for one in listed(value)]
    require(bool(found) and found == sorted({*found}) and found[-1] < size, "states or channels of a part are none")
    return found


def _projection(places: Sequence[int], size: int) -> fmpq_mat:
    return fmpq_mat([[int(i == j and i in places) for j in range(size)] for i in range(size)])


def _cut(side: fmpq_mat, rows: Sequence[int], columns: Sequence[int]) -> fmpq_mat:
    return fmpq_mat([[side[i, j] for j in columns] for i in rows])


def _rows(side: fmpq_mat) -> list[list[str]]:
    return [[str(v) for v in row] for row in side.tolist()]


def _require_whole_operators(asked: Asked, channels: Sequence[int]) -> None:
    """Check that no operator acts on all of its channels together where these are in several parts."""
    for block in asked.operators:
        joint = asked.nonlinearities[block[0]].operator not in (SCALAR, *_DELAYS)
        inside = {*block} & {*channels}
        require(not joint or inside in ({*block}, set()), "an operator acts on several parts together")


def _top(A: fmpq_mat, B: fmpq_mat, C: fmpq_mat, direct: fmpq, below: fmpq_poly) -> list[str]:
    """The numerator over ``det(s - A)``, highest power first; nothing if it is 0."""
    n, state, series = A.nrows(), B, [direct]
    for _ in range(n):
        tick()
        series.append((C * state)[0, 0])
        state = A * state
    p = below.coeffs()  # ascending; the coefficient of s^i is a sum of those of s^(i + k) times the k-th
    return _falling(
        fmpq_poly([sum((p[i + k] * v for k, v in enumerate(series[: n - i + 1])), fmpq(0)) for i in range(n + 1)])
    )


def _falling(p: fmpq_poly) -> list[str]:
    return [str(c) for c in reversed(p.coeffs())]
