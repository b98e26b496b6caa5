"""Import Gradio without what the page never uses: 40 % of the time, and pandas.

Gradio parses the source of each component and writes a stub file for editors, at every start. It
imports pandas for caches of tables, and the package of MCP where that is installed; the page's own
MCP needs neither (app/serving/mcp.py).
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from types import ModuleType
from typing import Any

WRITER, STUBS, TABLES = "gradio.component_meta", "create_or_modify_pyi", "pandas"
OPTIONAL = "mcp"


class Later(ModuleType):
    """A module that is imported when something of it is used."""

    def __getattr__(self, name: str) -> Any:
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


class WithoutStubs:
    """Finds Gradio's writer of stub files and replaces it by nothing."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None, target: Any = None) -> ModuleSpec | None:
        """Return the spec of that one module."""
        spec = PathFinder.find_spec(name, path) if name == WRITER else None
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def executed(module: ModuleType) -> None:
                execute(module)
                setattr(module, STUBS, lambda *_: None)

            spec.loader.exec_module = executed  # type: ignore[method-assign]
        return spec


@contextmanager
def light_imports() -> Iterator[None]:
    """Import Gradio faster inside; without effect if it is imported already."""
    tables = Later(TABLES)
    tables.__spec__ = find_spec(TABLES)
    sys.meta_path.insert(0, WithoutStubs)
    sys.modules.setdefault(TABLES, tables)
    left_out = sys.modules.setdefault(OPTIONAL, None) is None  # type: ignore[arg-type]
    try:
        yield
    finally:
        sys.meta_path.remove(WithoutStubs)
        if left_out:
            del sys.modules[OPTIONAL]
        if sys.modules.get(TABLES) is tables:
            del sys.modules[TABLES]
