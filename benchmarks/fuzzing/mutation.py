"""Valid texts, trees and bytes changed in a few places, by random numbers or by the bytes of a guided fuzzer."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import numpy as np

ODD_NUMBERS = (0, -1, 1, 2, 1e-320, 1e308, -0.0, 10**30, 10**400, float("nan"), float("inf"), -float("inf"), 0.1, True)
ODD_TEXTS = (
    *("", " ", "nan", "inf", "1e400", "-1/0", "1/3", "0x10", "9" * 10000, "\x00", "\u202e", "𝟙", "é", "a" * 5000),
    *("((" * 500, "s", "1/s", "sigma", "exp(-s)", "z", "1_0", "--1", "1;2", "[", "{a}", "\n", "true", "null"),
)


class Choices:
    """Random numbers that a guided fuzzer chooses: read off its bytes, 0 behind their end."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def _next(self, size: int) -> int:
        self.at += size
        return int.from_bytes(self.data[self.at - size : self.at], "little")

    def random(self) -> float:
        """A number from 0 to below 1."""
        return self._next(1) / 256

    def integers(self, low: int, high: int | None = None, size: int | None = None) -> Any:  # noqa: ANN401  (numpy's)
        """A whole number, or an array of them, with the ends as numpy has them."""
        low, high = (0, low) if high is None else (low, high)
        width = max(1, (int(high - low - 1).bit_length() + 7) // 8)
        if size is not None:
            return np.array([low + self._next(width) % (high - low) for _ in range(size)])
        return low + self._next(width) % (high - low)


Random = np.random.Generator | Choices


def pick(rng: Random, among: Any) -> Any:  # noqa: ANN401  (an element of anything)
    """One of them."""
    return among[int(rng.integers(len(among)))]


def places(tree: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:  # noqa: ANN401  (JSON)
    """The paths of everything in a tree, but itself."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ():
        yield (*at, key)
        yield from places(value, (*at, key))


def parent_of(tree: Any, path: tuple[Any, ...]) -> Any:  # noqa: ANN401  (JSON)
    """What holds the last part of the path."""
    for key in path[:-1]:
        tree = tree[key]
    return tree


def odd(rng: Random, value: Any, others: list[Any]) -> Any:  # noqa: ANN401  (JSON)
    """Something in place of a value: near to it, of another type, or from another file."""
    choice = rng.random()
    if choice < 0.25 and isinstance(value, int | float) and not isinstance(value, bool):
        return value * pick(rng, [-1, 2, 0.5, 1 + 1e-12, 1e6]) + pick(rng, [0, 0, 1])
    if choice < 0.4 and isinstance(value, str) and value:
        i = int(rng.integers(len(value)))
        return value[:i] + str(pick(rng, [*"0123456789-/.()*^se", "", pick(rng, ODD_TEXTS)])) + value[i + 1 :]
    if choice < 0.5:
        other = pick(rng, others)
        inside = list(places(other))
        path = pick(rng, inside) if inside else ()
        return copy.deepcopy(parent_of(other, path)[path[-1]]) if path else other
    if choice < 0.6:
        deep = value
        for _ in range(int(pick(rng, [1, 2, 30, 150]))):
            deep = [deep] if rng.random() < 0.7 else {"a": deep}
        return deep
    if choice < 0.65:
        return [value] * int(pick(rng, [0, 2, 50, 3000]))
    return pick(rng, [pick(rng, ODD_NUMBERS), pick(rng, ODD_TEXTS), [], {}, None, [[]], str(value)])


def mutated(rng: Random, tree: Any, others: list[Any]) -> Any:  # noqa: ANN401  (JSON)
    """A tree that is changed in one to four places."""
    tree = copy.deepcopy(tree)
    for _ in range(int(rng.integers(1, 5))):
        every = list(places(tree))
        if not every:
            return tree
        path = pick(rng, every)
        parent, key = parent_of(tree, path), path[-1]
        choice = rng.random()
        if choice < 0.15:
            del parent[key]
        elif choice < 0.25 and isinstance(parent, dict):
            parent[str(pick(rng, [*ODD_TEXTS, key + "s", key.upper(), pick(rng, every)[-1]]))] = copy.deepcopy(
                parent[key]
            )
        elif choice < 0.3 and isinstance(parent, list):
            parent.insert(int(rng.integers(len(parent) + 1)), copy.deepcopy(parent[key]))
        elif choice < 0.4:
            other = pick(rng, every)
            if other[: len(path)] != path and path[: len(other)] != other:
                parent_of(tree, other)[other[-1]], parent[key] = parent[key], parent_of(tree, other)[other[-1]]
        else:
            parent[key] = odd(rng, parent[key], others)
    return tree


def torn(rng: Random, text: str, others: list[str]) -> str:
    """A text that is cut, doubled or sprinkled in places."""
    for _ in range(int(rng.integers(1, 5))):
        i, j = sorted(int(v) for v in rng.integers(0, len(text) + 1, 2))
        other = pick(rng, others)
        a = int(rng.integers(0, len(other) + 1))
        text = pick(
            rng,
            [
                text[:i] + text[min(j, i + 20) :],
                text[:i] + str(pick(rng, ODD_TEXTS)) + text[i:],
                text[:i] + text[i : i + 30] * int(pick(rng, [2, 3, 200])) + text[i + 30 :],
                text[:i] + other[a : a + 40] + text[i:],
                text[:i] if rng.random() < 0.2 else text,
                text[:i] + str(pick(rng, list("()[]{}=,.\"'#\t\x00\x7f \n-+*/^e0"))) + text[i + 1 :],
            ],
        )
    return text[:200_000]


def toml_of(value: Any, *, top: bool = True) -> str:  # noqa: ANN401  (TOML)
    """A value as TOML; what it has no word for becomes a text."""
    if isinstance(value, dict):
        if top:
            plain = {k: v for k, v in value.items() if not isinstance(v, dict)}
            lines = [f"{json.dumps(k)} = {toml_of(v, top=False)}" for k, v in plain.items()]
            tables = [
                f"[{json.dumps(k)}]\n{toml_of(v, top=False)[1:-1]}"
                for k, v in value.items()
                if k not in plain and not v
            ]
            for k, v in value.items():
                if k not in plain and v:
                    tables.append(f"{json.dumps(k)} = {toml_of(v, top=False)}")
            return "\n".join([*lines, *sorted(tables, key=lambda line: line.startswith("["))]) + "\n"
        return "{" + ", ".join(f"{json.dumps(k)} = {toml_of(v, top=False)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml_of(v, top=False) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value) if not (isinstance(value, int) and abs(value) > 10**4000) else '"huge"'
    return json.dumps(str(value)).replace("\x7f", "\\u007f")


def chipped(rng: Random, data: bytes) -> bytes:
    """Bytes that are cut, doubled or exchanged in places."""
    for _ in range(int(rng.integers(1, 5))):
        i, j = sorted(int(v) for v in rng.integers(0, len(data) + 1, 2))
        value = bytes([int(rng.integers(256))])
        data = pick(
            rng,
            [
                data[:i] + value + data[i + 1 :],
                data[:i] + data[min(j, i + 20) :],
                data[:i] + data[i:j] + data[i : i + 64] + data[j:],
                data[:i] + pick(rng, [b"\xff" * 4, bytes(8), b"\xff" * 7 + b"\x7f"]) + data[i + 4 :],
                data[:i] if rng.random() < 0.3 else data,
            ],
        )
    return data[: 1 << 16]
