"""Cross-references as Python would follow them: from the module of a docstring to where a name is documented."""

from __future__ import annotations

import ast
import builtins
import functools
import inspect
import re
import sys

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging

from lure_docs.listing import home, resolved

_LOG = logging.getLogger(__name__)
_THEIRS = ("abc", "control", "hypothesis", "matplotlib", "numpy", "scipy", "sympy", "xarray", "collections", "typing")
_TYPES = ("class", "exception", "data", "type")


class References(SphinxPostTransform):
    """Each reference to a Python object gets the name under which it is documented, before Sphinx looks for it."""

    default_priority = 5

    def run(self, **_arguments: object) -> None:
        """Rename or drop the references; a role that points nowhere is a warning, a word of a type stays a word."""
        for field in self.document.findall(nodes.field):
            _mark(field)
        for node in list(self.document.findall(addnodes.pending_xref)):
            if node.get("refdomain") != "py":
                continue
            of_a_type = bool(node.get("refspecific")) or isinstance(node.parent, addnodes.desc_returns)
            name = self._name(str(node["reftarget"]).strip("."), node, of_a_type=of_a_type)
            if name is not None:
                node["reftarget"], node["refspecific"] = name, False
                continue
            if not of_a_type and node["reftype"] != "mod" and not self._theirs(str(node["reftarget"])):
                _LOG.warning("nothing is documented under %s", node["reftarget"], location=node)
            node.replace_self(node.children)

    def _name(self, target: str, node: nodes.Element, *, of_a_type: bool) -> str | None:
        """The documented name for what is written in a docstring."""
        objects = self.env.domains.python_domain.objects
        if target in objects and "." in target:
            return target
        owner, _, attribute = target.rpartition(".")
        if node["reftype"] == "attr" and owner and attribute in getattr(_object(owner), "__annotations__", ()):
            target = owner  # fields of a class are listed in its entry
        for path in _paths(target, node):
            found = _home(path)
            for name in objects if found else ():
                if name == found or (name.rpartition(".")[2] == path.rpartition(".")[2] and _home(name) == found):
                    return name
            if path in objects:  # data, which does not know where it is from
                return path
            if found:  # another of that name, which has no entry
                return None
        same = {
            entry.node_id
            for name, entry in objects.items()
            if f".{name}".endswith(f".{target}") and (not of_a_type or entry.objtype in _TYPES)
        }
        return same.pop() if len(same) == 1 and not hasattr(builtins, target) else None

    @staticmethod
    def _theirs(target: str) -> bool:
        return target.split(".")[0] in _THEIRS or hasattr(builtins, target.split(".")[0])


def _mark(field: nodes.Element) -> None:
    """Make references of the words of a type where napoleon leaves them as they are: attributes, what is returned."""
    if field[0].astext() in ("Attributes", "Returns", "Yields"):
        for paragraph in field[1].findall(nodes.paragraph):
            before = paragraph[:3]  # the name and a bracket, or nothing
            for kind in [each for each in before if isinstance(each, nodes.emphasis)][:1]:
                _words(kind)


def _words(kind: nodes.Element) -> None:
    parts = re.split(r"([A-Za-z_][\w.]*)", kind.astext())
    kind.children[:] = []
    for part in parts:
        word = nodes.Text(part)
        what = {"refdomain": "py", "reftype": "class", "reftarget": part, "refspecific": True}
        kind += addnodes.pending_xref("", word, **what) if part[:1].isidentifier() else word


def _home(name: str) -> str | None:
    try:
        return home(resolved(name))
    except (LookupError, ImportError):
        return None


def _paths(target: str, node: nodes.Element) -> list[str]:
    """Where the name may stand: as it is, in the object that is documented, or in the module that defines it."""
    paths = [target]
    above: nodes.Element | None = node
    while (above := above.parent if above is not None else None) is not None:
        inside = _inside(above)
        if inside:
            paths += [f"{inside}.{target}", f"{inside.rpartition('.')[0]}.{target}"]
            defined = getattr(_object(inside), "__module__", None)
            if defined in sys.modules:
                first, point, rest = target.partition(".")
                paths.append(f"{_imports(defined).get(first, f'{defined}.{first}')}{point}{rest}")
    return [*paths, f"{node.get('py:module')}.{target}"] if node.get("py:module") else paths


@functools.cache
def _imports(module: str) -> dict[str, str]:
    """Where the names come from that a module imports, those for the type checker alone among them."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    return {each.asname or each.name: f"{node.module}.{each.name}" for node in found for each in node.names}


def _inside(above: nodes.Element) -> str | None:
    """The object that an entry, or a row of a summary table, describes."""
    if isinstance(above, addnodes.desc) and above[0].get("ids"):
        return str(above[0]["ids"][0])
    if isinstance(above, nodes.row):
        return next((str(found["reftarget"]) for found in above.findall(addnodes.pending_xref)), None)
    return None


def _object(name: str) -> object:
    try:
        return resolved(name)
    except (LookupError, ImportError):
        return None


def setup(app: Sphinx) -> None:
    """Rename references before Sphinx resolves them."""
    app.add_post_transform(References)
