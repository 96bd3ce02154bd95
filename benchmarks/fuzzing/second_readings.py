"""What a text says, read a second time by means of their own: Python's grammar, fractions, mpmath, its ``json``.

Only what the readers of ``lure`` have accepted comes here, so that ``eval`` meets numbers, operators and a few names.
"""

from __future__ import annotations

import ast
import json
import re
from decimal import Decimal
from fractions import Fraction
from typing import Any

import mpmath

from lure import Expression
from lure.files import loop_to_toml, parse_system
from lure.files.system import LoopSystem
from lure.networks.network import Network
from lure.plants.channel_family import ChannelFamily
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant

_DECIMAL = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
POINT = Fraction(17, 13)


def same_transfer(text: str, plant: RationalPlant) -> None:
    """A transfer function has the value that Python's grammar gives the text at one rational point."""
    exact = _DECIMAL.sub(lambda found: f"F('{found[0]}')", text.replace("^", "**"))
    try:
        code = compile(exact.strip(), "transfer", "eval", dont_inherit=True)
        value = eval(code, {"__builtins__": {}}, {"F": Fraction, "s": POINT, "z": POINT})
    except (SyntaxError, TypeError, ZeroDivisionError):  # a product without its sign, a pole
        return
    num, den = (sum(c * POINT**k for k, c in enumerate(reversed(p))) for p in (plant.numerator, plant.denominator))
    if num != value * den:
        raise RuntimeError(f"{text!r:.300} has the value {value} at {POINT}, and is read as {num / den}")


class _Exact(ast.NodeTransformer):
    """The literals of a formula as numbers of mpmath, its comparisons and cases as they are."""

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        """A number."""
        return ast.parse(f"mpf({str(node.value)!r})", mode="eval").body


def _where(case: Any, yes: Any, no: Any) -> Any:  # noqa: ANN401  (numbers)
    return yes if case else no


_FUNCTIONS = {"abs": abs, "min": min, "max": max, "sign": mpmath.sign, "where": _where, "mpf": mpmath.mpf} | {
    name: getattr(mpmath, name) for name in ("atan", "cos", "exp", "log", "sin", "sqrt", "tan", "tanh")
}


def same_formula(text: str, formula: Expression, sigma: float, t: float) -> None:
    """A formula has the value that Python's grammar gives it at one point, unless doubles cannot tell."""
    found = float(formula(sigma=sigma, t=t))
    inputs = {"sigma": mpmath.mpf(sigma), "t": mpmath.mpf(t), "pi": +mpmath.pi}
    try:
        tree = ast.fix_missing_locations(_Exact().visit(ast.parse(text.strip(), mode="eval")))
        code = compile(tree, "formula", "eval")
        values = []
        for digits in (15, 40):
            with mpmath.workdps(digits):
                values.append(eval(code, {"__builtins__": {}}, _FUNCTIONS | inputs))
    except (SyntaxError, TypeError, ArithmeticError, ValueError, MemoryError):  # a power by ^; what is nowhere defined
        return
    rough, fine = values
    if isinstance(fine, mpmath.mpc) or not mpmath.isfinite(fine) or abs(fine) > 1e300:
        return
    if abs(rough - fine) > 1e-9 * (1 + abs(fine)):  # digits cancel
        return
    if not abs(found - fine) <= 1e-6 * (1 + abs(fine)):
        raise RuntimeError(f"{text!r:.300} has the value {float(fine)} at sigma={sigma}, t={t}, and is read as {found}")


def same_network(text: str, network: Network) -> None:
    """A network has the numbers that the file holds, decimals as they stand."""
    held = json.loads(text, parse_float=lambda word: Fraction(Decimal(word)))
    weights = tuple(tuple(tuple(Fraction(v) for v in row) for row in rows) for rows in held["weights"])
    biases = tuple(tuple(Fraction(v) for v in bias) for bias in held.get("biases", ()))
    if (weights, biases if any(map(any, biases)) else ()) != (network.weights, network.biases):
        raise RuntimeError("the network has other numbers than its file")


def same_system(system: object) -> None:
    """What is written of a loop is read as that loop; the matrices of one channel may become those of their ``H``."""
    if not isinstance(system, LoopSystem):
        return
    written = loop_to_toml(system)
    again = parse_system(written, name=system.name, source=system.source, settings=())
    if not isinstance(again, LoopSystem):
        raise TypeError(f"what is written is no loop: {written[:600]!r}")
    first, second = (_told(one) for one in (system, again))
    if _same_block(system.block, again.block):
        first["block"] = second["block"]
    if first != second:
        differs = [key for key in first if first[key] != second.get(key)]
        raise RuntimeError(f"what is written reads back with another {differs}: {written[:600]!r}")


def _same_block(block: object, other: object) -> bool:
    """Whether both are one ``H``, of plants with parameters at two corners of the box."""
    if isinstance(block, PlantFamily | ChannelFamily) and isinstance(other, type(block)) and block.box == other.box:
        corners = [[ends[k] for ends in block.box] for k in (0, 1)]
        return all(block.at(corner) == other.at(corner) for corner in corners)
    return isinstance(block, RationalPlant) and block == other


def _told(system: LoopSystem) -> dict[str, str]:
    return {key: repr(value) for key, value in system.to_dict().items() if key not in ("source", "title")}
