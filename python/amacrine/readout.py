"""What stands between cells and events."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Union

from . import arguments, toml
from .names import opened

Readout = Union[str, Path, Mapping[str, Any]]
"""A name, a file, or a table with one of these as ``readout`` and with settings."""


def readout_of(given: Any) -> tuple[str, str | None, list[tuple[str, str]]] | None:
    """Name, text of the file where it is one, and settings; none is none."""
    if given is None:
        return None
    such_as = '{"readout": "arbiter", "fifo": 64}'
    settings = arguments.table("readout", given, such_as) if isinstance(given, Mapping) else {}
    name = settings.pop("readout", None) if isinstance(given, Mapping) else given
    what = f"a name, the path of a file, or a table such as {such_as}"
    path = Path(arguments.file("readout", name, what))
    text = opened("readouts", path, "readout")[1] if path.suffix == ".toml" else None
    return str(name), text, [(toml.key(key), str(value)) for key, value in settings.items()]
