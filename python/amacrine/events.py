"""Events as structured arrays."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import numpy.typing as npt

from ._amacrine import Error

EVENT = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "i1")])
"""One event: time in microseconds, column, row, 1 for ON and 0 for OFF. The dtype of a `.npy` of
events, and that of tonic."""

EVENT_OF_KINDS = np.dtype([*((n, EVENT[n]) for n in ("t", "x", "y", "p")), ("channel", "u1")])
"""The same of a sensor with several kinds of cells: `channel` counts them from 0."""

Events = npt.NDArray[np.void]
"""A structured array of :data:`EVENT` or :data:`EVENT_OF_KINDS`."""


def view(records: npt.NDArray[np.uint8], channels: int) -> Events:
    """The bytes of records as events; nothing is copied."""
    dtype = EVENT_OF_KINDS if channels > 1 else EVENT
    events: Events = records.view(dtype)
    return events


def npy(events: npt.NDArray[Any]) -> bytes:
    """Events as the bytes of a `.npy`: the library reads, and checks, any order and width of
    fields."""
    events = np.asarray(events)
    if events.dtype.names is None:
        raise Error(
            f"events of dtype {events.dtype} have no fields\n"
            "help: give a structured array with the fields t, x, y and p, such as amacrine.EVENT"
        )
    file = io.BytesIO()
    np.save(file, events.ravel(), allow_pickle=False)
    return file.getvalue()
