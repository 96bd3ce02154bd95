"""One place of a function changed: the operators of the mutants of ``benchmarks/mutants.py``."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator

LAYOUT = {  # functions whose results hold no verdict, class or number, or hold them all whatever they do
    "inline": "a picture put into the page",
    "glyphs": "letters of pictures",
    "template": "the page's frame",
    "_unbroken": "no line break in an interval",
    "_sentence": "capital letters and full stops",
    "_table": "columns aligned",
    "columns": "columns aligned",
    "plot": "draws",
}
LAID_OUT = ("fill", "ljust")  # calls whose arguments are widths
SWAPS: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
}
_TYPED = ("isinstance", "getattr", "hasattr", "min", "max")  # exchanged arguments of these always fail, or never
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}


def changed(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Every other node that may stand in the place of one, with what was done."""
    if isinstance(node, ast.Compare):
        for i, op in enumerate(node.ops):
            for new in SWAPS.get(type(op), ()):
                other = copy.deepcopy(node)
                other.ops[i] = new()
                yield f"{type(op).__name__} to {new.__name__}", other
    elif isinstance(node, ast.BinOp) and not isinstance(node.left, ast.JoinedStr):
        for new in SWAPS.get(type(node.op), ()):
            yield f"{type(node.op).__name__} to {new.__name__}", ast.BinOp(node.left, new(), node.right)
    elif isinstance(node, ast.BoolOp):
        yield "and/or", ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
        for i in range(len(node.values)):
            rest = node.values[:i] + node.values[i + 1 :]
            yield f"operand {i} left out", rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield f"{type(node.op).__name__} left out", node.operand
    elif isinstance(node, ast.IfExp) and not _plural(node):
        yield "branches exchanged", ast.IfExp(node.test, node.orelse, node.body)
    elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
        for new in (not node.value,) if isinstance(node.value, bool) else (node.value + 1, node.value - 1):
            yield f"{node.value} to {new}", ast.Constant(new)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in NAMES:
        yield f"{node.id} to {NAMES[node.id]}", ast.Name(NAMES[node.id], ast.Load())
    elif isinstance(node, ast.Call) and len(node.args) == 2 and getattr(node.func, "id", "") not in _TYPED:
        yield "arguments exchanged", ast.Call(node.func, node.args[::-1], node.keywords)
    elif isinstance(node, ast.If) and not node.orelse:
        yield "if left out", ast.If(ast.Constant(value=False), node.body, [])
        yield "always", ast.If(ast.Constant(value=True), node.body, [])


def _plural(node: ast.IfExp) -> bool:
    """Whether a conditional chooses between one and several."""
    return {getattr(node.body, "value", None), getattr(node.orelse, "value", None)} == {"", "s"}


def mutants(tree: ast.Module, within: ast.AST | None = None, name: str = "") -> Iterator[tuple[str, str, range]]:
    """Every mutant of a module: function, what was done, its lines; until the next the tree is that mutant."""
    for node in ast.iter_child_nodes(within or tree):
        if isinstance(node, ast.ClassDef):
            yield from mutants(tree, node)
        elif isinstance(node, ast.FunctionDef) and node.name not in LAYOUT:
            for each in node.body:
                yield from _inside(node, each, node.name)


def _inside(parent: ast.AST, statement: ast.stmt, function: str) -> Iterator[tuple[str, str, range]]:
    """The mutants of a statement of a function, those of the statements in it included."""
    body = getattr(statement, "body", None)
    end = body[0].lineno if isinstance(body, list) else (statement.end_lineno or 0) + 1
    lines = range(statement.lineno, max(end, statement.lineno + 1))
    for _, value in ast.iter_fields(parent):
        if isinstance(value, list) and any(one is statement for one in value):
            at = next(i for i, one in enumerate(value) if one is statement)
            for said, new in changed(statement):
                value[at] = new
                yield function, f"line {statement.lineno}: {said}", lines
                value[at] = statement
    inner: list[tuple[ast.AST, ast.stmt]] = []
    todo: list[ast.AST] = [statement]
    while todo:
        holder = todo.pop()
        for name, value in ast.iter_fields(holder):
            if name in ("decorator_list", "annotation", "returns", "args") and isinstance(holder, ast.FunctionDef):
                continue
            for i, old in enumerate(value) if isinstance(value, list) else [(None, value)]:
                if isinstance(old, ast.stmt):
                    inner.append((holder, old))
                elif isinstance(old, ast.AST):
                    for said, new in changed(old):
                        _put(holder, name, i, new)
                        yield function, f"line {getattr(old, 'lineno', statement.lineno)}: {said}", lines
                        _put(holder, name, i, old)
                    if not (isinstance(old, ast.Call) and getattr(old.func, "attr", "") in LAID_OUT):
                        todo.append(old)
                    elif old.args:
                        todo.append(old.args[0])
    for holder, each in inner:
        yield from _inside(holder, each, function)


def _put(parent: ast.AST, name: str, i: int | None, node: ast.AST) -> None:
    if i is None:
        setattr(parent, name, node)
    else:
        getattr(parent, name)[i] = node
