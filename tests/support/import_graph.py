"""What each module of conrod imports, read from its source."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import conrod

DEFERRED = ("DeferredLibrary(", "DeferredFunctions(")
ROOT = Path(conrod.__file__).parent
MODULES = {
    ".".join(("conrod", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(ROOT.rglob("*.py"))
}


def within(module: str, package: str) -> bool:
    """True if a module is a package or lies below it."""
    return module == package or module.startswith(package + ".")


def imports(path: Path, type_checking: bool = False) -> set[str]:
    """Modules that a file imports, wherever in it; those for the type checker alone only where asked for."""
    found: set[str] = set()

    def visit(node: ast.AST) -> None:
        if not type_checking and isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            for child in node.orelse:
                visit(child)
            return
        if isinstance(node, ast.Assign) and ast.unparse(node.value).startswith(DEFERRED):
            # A library or a module that is imported when it is first used.
            found.update(ast.literal_eval(argument) for argument in node.value.args)  # type: ignore[attr-defined]
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: a relative import"
            base = str(node.module)
            found.add(base)
            # `from package import module` is an import of the module.
            found.update(f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in MODULES)
        for child in ast.iter_child_nodes(node):
            # An import is a statement: no expression holds one.
            if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
                visit(child)

    visit(ast.parse(path.read_text(encoding="utf-8")))
    return found


@cache
def import_graph() -> dict[str, set[str]]:
    """Modules that each module of conrod imports; to read them all takes a second."""
    return {module: imports(path) for module, path in MODULES.items()}
