"""A tree as text the parser reads back to the same tree."""

from __future__ import annotations

from lure.expressions.tree import COMPARISONS, Apply, Node, Number, decimal

_INFIX = (*COMPARISONS, "+", "-", "*", "/", "**", "and", "or")


def render(node: Node) -> str:
    """Text with every operation inside another one in parentheses; ``where`` and the functions by name.

    >>> from lure.expressions.parser import parse
    >>> render(parse("-t**2 + sin(t)/3 if 0 < t else 0", variables=("t",), field="f"))
    'where(0 < t, (-(t**2)) + (sin(t)/3), 0)'
    """
    if isinstance(node, Number):
        text = decimal(node.value)
        assert text is not None, "constants that have no text are never folded"
        return text
    if not isinstance(node, Apply):
        return node.name
    if node.operation == "pi":
        return "pi"
    if node.operation == "neg":
        return f"-{_inner(node.arguments[0])}"
    if node.operation == "not":
        return f"not {_inner(node.arguments[0])}"
    if node.operation in _INFIX:
        left, right = (_inner(part) for part in node.arguments)
        space = "" if node.operation in ("*", "/", "**") else " "
        return f"{left}{space}{node.operation}{space}{right}"
    return f"{node.operation}({', '.join(render(part) for part in node.arguments)})"


def _inner(node: Node) -> str:
    text = render(node)
    simple = isinstance(node, Number) and text.replace(".", "").isdigit()
    named = not isinstance(node, Number | Apply) or (isinstance(node, Apply) and text == "pi")
    called = isinstance(node, Apply) and node.operation not in (*_INFIX, "neg", "not")
    return text if simple or named or called else f"({text})"
