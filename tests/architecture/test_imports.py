"""Forbidden imports, and loading of every module and table entry."""

import importlib
import inspect
import pkgutil
import re
import subprocess
import sys

import pytest

import omnivat

HEAVY = {"torch", "numpy", "umap", "plotly", "gradio", "sklearn", "scipy", "transformers", "PIL"}


def loaded_by(statement, *options):
    """Return which heavy packages a fresh interpreter has loaded after `statement`."""
    code = f"import sys; {statement}; print(*{{m.split('.')[0] for m in sys.modules}})"
    words = [sys.executable, *options, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return HEAVY & set(done.stdout.split())


def test_importing_the_library_and_a_figure_as_json_load_nothing_heavy():
    assert loaded_by("import omnivat") == set()
    drawn = "from omnivat.figures.specs import training_spec as t; t([{'loss': 2.0, 'order': 0.5}])"
    assert "plotly" not in loaded_by(drawn)


def test_the_help_needs_neither_torch_nor_docstrings():
    code = "import omnivat.cli as c\ntry: c.main(['train', '--help'])\nexcept SystemExit: pass"
    heavy = {"torch", "umap", "plotly", "gradio", "transformers"}
    assert not loaded_by(f"exec({code!r})", "-OO") & heavy


MODULES = [
    module.name
    for module in pkgutil.walk_packages(omnivat.__path__, "omnivat.")
    if not module.name.endswith("__main__")
]


@pytest.mark.parametrize("name", MODULES)
def test_every_module_imports_and_says_what_it_is_for(name):
    assert (importlib.import_module(name).__doc__ or "").strip()


def tables():
    """Return every entry of every table of "module:attribute" texts."""
    found = []
    for name in MODULES:
        for table, value in vars(importlib.import_module(name)).items():
            if table.isupper() and isinstance(value, dict):
                for key, target in value.items():
                    if isinstance(target, str) and target.startswith("omnivat.") and ":" in target:
                        found.append((f"{name}.{table}", key, target))
    return sorted(set(found))


def test_every_table_entry_loads():
    entries = tables()
    assert len(entries) > 10
    for _, _, target in entries:
        module, attribute = target.split(":")
        assert hasattr(importlib.import_module(module), attribute), target


def test_every_public_name_is_offered_and_loads():
    assert dir(omnivat) == sorted(omnivat.__all__)
    for name in omnivat.__all__:
        assert getattr(omnivat, name) is not None


def test_a_public_function_that_takes_a_path_takes_its_text():
    public = filter(inspect.isfunction, (getattr(omnivat, name) for name in omnivat.__all__))
    taken = [p for function in public for p in inspect.signature(function).parameters.values()]
    paths = [hint for p in taken if re.search(r"\bPath\b", hint := str(p.annotation))]
    assert len(paths) > 10
    assert all(re.search(r"\bstr\b", hint) for hint in paths)


def test_an_unknown_public_name_is_refused():
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = omnivat.nothing
