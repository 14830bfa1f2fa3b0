"""The text of a sensor file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ._amacrine import Error
from .arguments import letters


def value(of: Any) -> str:
    """A value as TOML, on one line."""
    if isinstance(of, (bool, np.bool_)):
        return "true" if of else "false"
    if isinstance(of, str):
        # What JSON leaves as it is, and TOML does not take.
        return json.dumps(letters("a text", of), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(of, (int, np.integer)):
        return str(int(of))
    if isinstance(of, (float, np.floating)):
        return repr(float(of))
    if isinstance(of, np.ndarray):
        return value(of.tolist())
    if isinstance(of, Mapping):
        pairs = (f"{key(name)} = {value(one)}" for name, one in of.items())
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(of, (list, tuple)):
        return "[" + ", ".join(map(value, of)) + "]"
    raise Error(f"{of!r} is nothing that a sensor file can say\nhelp: give numbers and words")


def key(name: str) -> str:
    """A key: underscores are the dashes of the file."""
    return letters("a key", str(name)).replace("_", "-")


def table(of: Mapping[str, Any]) -> str:
    """A line for each key that has a value."""
    return "".join(f"{key(name)} = {value(one)}\n" for name, one in of.items() if one is not None)
