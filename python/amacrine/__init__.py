"""Event sensors with any receptive field: float models, and programs on a SCAMP-5 array.

>>> import numpy as np, amacrine
>>> sensor = amacrine.Sensor.from_file("rgc-4")
>>> frames, fps = amacrine.load("pattern:bar?width=64&height=48&frames=8&fps=100")
>>> events = sensor.events(frames, fps, scale=1)
>>> events.dtype.names
('t', 'x', 'y', 'p', 'channel')

Frames are arrays of shape (T,H,W), (T,1,H,W) or (B,T,1,H,W): ``uint8`` as they are, floats (and
other whole numbers, and ``bool``) with an explicit ``scale`` to light from 0 to 255. Image coordinates: x to the right, y down. Times of
events are whole microseconds. Whatever is wrong raises :class:`Error`, a ``ValueError``, with the
words of the command line, its options called as arguments are here.
"""

from . import events, gradient
from ._amacrine import Error, __version__, threads
from .answer import Answer
from .caution import Caution
from .events import EVENT, EVENT_OF_KINDS
from .files import About, about, compare, read, write
from .frames import load
from .names import names, text
from .pool import set_threads
from .program import Program, ProgramRun
from .sensor import (
    ChipSensor, CompiledFilter, EventSensor, Sensor, Stream, compile, compile_filter
)
from .study import Quantised, design, feasibility, quantise, trade, waterfall
from .sweeps import Sweep, sweep

__all__ = [
    "EVENT",
    "EVENT_OF_KINDS",
    "About",
    "Answer",
    "Caution",
    "ChipSensor",
    "CompiledFilter",
    "Error",
    "EventSensor",
    "Program",
    "ProgramRun",
    "Quantised",
    "Sensor",
    "Stream",
    "Sweep",
    "__version__",
    "about",
    "compare",
    "compile",
    "compile_filter",
    "design",
    "events",
    "feasibility",
    "gradient",
    "load",
    "names",
    "quantise",
    "read",
    "set_threads",
    "sweep",
    "text",
    "threads",
    "trade",
    "waterfall",
    "write",
]
