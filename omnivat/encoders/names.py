"""Resolve an encoder's name to the function that loads it."""

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, cast

from omnivat.errors import DataError, MissingNameError, SettingsError
from omnivat.tables import load, suggestion

GROUP = "omnivat.encoders"  # group of entry points of other packages
IMPORTED = "imported:"  # prefix of an encoder that is not available here
HUB = "hf:"  # prefix of a folder or hub name of a transformers model


def loader_of(name: str, table: Mapping[str, str]) -> Callable[..., Any]:
    """Return the function that loads the encoder called `name`.

    name    a name in `table`; `hf:NAME_OR_FOLDER`; `module:function` or `path/file.py:function`; or
            an entry point of the group "omnivat.encoders"

    Raises MissingNameError for an unknown name, DataError if the named code cannot be imported.
    """
    if name in table:
        return cast("Callable[..., Any]", load(table, name, kind="encoder"))
    if name.startswith(IMPORTED):
        raise DataError(
            f"The embeddings of '{name.removeprefix(IMPORTED)}' were made elsewhere and imported; no "
            "image can be encoded here. Wrap that encoder (docs/encoders.md) and embed the pairs with it."
        )
    if name.startswith(HUB):
        from omnivat.encoders.huggingface import load as load_model

        return partial(load_model, name.removeprefix(HUB))
    declared = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name in declared:
        return _imported(name, declared[name].load)
    if ":" in name:
        return _imported(name, partial(_attribute, name))
    known = [*table, *declared]
    raise MissingNameError(
        f"No encoder is called '{name}'; there are {', '.join(known)}, hf:NAME_OR_FOLDER and "
        f"module:function.{suggestion(name, known)}"
    )


def accepted(loader: Callable[..., Any], name: str, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that a loader accepts.

    wanted  setting -> value. Default values that the loader lacks are dropped: weights None,
            precision "fp32", download "ask", and the device, which the loader then chooses.
    Raises SettingsError for any other setting that the loader lacks.
    """
    taken = inspect.signature(loader).parameters
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in taken.values()):
        return dict(wanted)
    plain = {"weights": None, "precision": "fp32"}
    for setting, value in plain.items():
        if setting not in taken and wanted.get(setting) != value:
            raise SettingsError(
                f"The encoder '{name}' takes no {setting}, and '{wanted[setting]}' came; leave out "
                f"--{setting}, or give its function an argument of that name."
            )
    return {setting: value for setting, value in wanted.items() if setting in taken}


def _imported(name: str, importer: Callable[[], Any]) -> Callable[..., Any]:
    try:
        found = importer()
    except DataError:
        raise
    except Exception as error:  # any error of the imported module
        raise DataError(
            f"The encoder '{name}' cannot be imported ({type(error).__name__}: {error}); check the "
            "module and the folder this command runs in."
        ) from error
    if not callable(found):
        raise DataError(f"'{name}' is no function; it must return an encoder when called.")
    return cast("Callable[..., Any]", found)


def _attribute(name: str) -> Any:
    """Return the function of "module:function" or "path/file.py:function"."""
    module, _, attribute = name.rpartition(":")
    file = Path(module)
    folder = str((file.parent if file.suffix == ".py" else Path()).resolve())
    if folder not in sys.path:  # as `python -m` does; the installed command would not find code beside the file
        sys.path.append(folder)
    if file.suffix == ".py":
        spec = importlib.util.spec_from_file_location(f"omnivat_encoder_{file.stem}", file)
        if not file.is_file() or spec is None or spec.loader is None:
            raise DataError(f"There is no file '{file}' with an encoder; check its path.")
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
    else:
        loaded = importlib.import_module(module)
    if not hasattr(loaded, attribute):
        raise DataError(f"'{module}' has no function '{attribute}' to load an encoder.")
    return getattr(loaded, attribute)
