"""The parser's place in the text, its budget of nodes and nesting, and the one way it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn, TypeVar

from lure.errors import InputError
from lure.expressions.build import apply
from lure.expressions.tokens import Token
from lure.expressions.tree import Node, depth

MAX_NODES = 200
MAX_DEPTH = 30
_Part = TypeVar("_Part")


@dataclass(slots=True)
class Reader:
    """Position in the tokens, and how much of the budget of nodes and nesting is used."""

    tokens: list[Token]
    variables: tuple[str, ...]
    field: str
    position: int = 0
    nodes: int = 0
    level: int = 0

    @property
    def ended(self) -> bool:
        """Whether all words are used."""
        return self.token.kind == "end"

    @property
    def token(self) -> Token:
        """The next word."""
        return self.tokens[self.position]

    def refuse(self, message: str, token: Token | None = None) -> NoReturn:
        """Raise InputError naming the field and the column."""
        raise InputError(f"{self.field}: {message} at column {(token or self.token).column}.")

    def accept(self, *texts: str) -> Token | None:
        """Step over the next word if it is one of these."""
        token = self.token
        if token.kind in ("symbol", "name") and token.text in texts:
            self.position += 1
            return token
        return None

    def expect(self, text: str, after: str) -> None:
        """Step over a word that must come now."""
        if not self.accept(text):
            comma = " (the decimal separator is a point)" if self.token.text == "," else ""
            self.refuse(f"expected {text!r} {after} but found {self.token}{comma}")

    def node(self, operation: str, *arguments: Node, at: Token) -> Node:
        """An operation, charged to the budget."""
        self.count(at)
        result = apply(operation, *arguments)
        if depth(result) > MAX_DEPTH:
            self.refuse(
                f"more than {MAX_DEPTH} operations are nested or chained; group a long sum with parentheses", at
            )
        return result

    def count(self, at: Token) -> None:
        """Charge one node to the budget."""
        self.nodes += 1
        if self.nodes > MAX_NODES:
            self.refuse(f"the expression has more than {MAX_NODES} numbers, names and operations", at)

    def enter(self, at: Token) -> None:
        """One level deeper: a parenthesis, sign or branch opens."""
        self.level += 1
        if self.level > MAX_DEPTH:
            self.refuse(f"more than {MAX_DEPTH} parentheses or signs are nested", at)

    def leave(self) -> None:
        """The level is closed again."""
        self.level -= 1

    def closed(self, opening: Token, part: Callable[[Reader], _Part]) -> _Part:
        """The part inside a parenthesis that is open, and its end."""
        self.enter(opening)
        found = part(self)
        self.leave()
        self.expect(")", f"to close '(' of column {opening.column}")
        return found
