"""Tensors of PyTorch, which is not needed for them to be told."""

from __future__ import annotations

from typing import Any


def untracked(given: Any) -> Any:
    """A tensor without its gradient, in memory, of a type that numpy has; else what was given."""
    if hasattr(given, "detach") and hasattr(given, "cpu"):
        given = given.detach().cpu()
    return widened(given)


def widened(given: Any) -> Any:
    """A tensor of bfloat16, which numpy does not have, as float32, which holds all of it; else what
    was given."""
    is_narrow = str(getattr(given, "dtype", "")) == "torch.bfloat16"
    return given.float() if is_narrow and hasattr(given, "float") else given
