"""The float model backwards: from a loss on voxels and counts to kernels, thresholds and light.

What counts whole events has no derivative; the rules differ in what takes its place. See
``docs/learning.md``, which derives each. :class:`amacrine.torch.EventSensor` is the same as a module
of PyTorch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments
from ._amacrine import Error
from .frames import clips
from .sensor import Sensor, stacked

Rule = Literal["through", "reset", "authors", "mean"]
"""What flows back through the memory: ``mean``, exact on average over the phases of the memory for
kernels and for both thresholds scaled as one where ON and OFF thresholds are equal (else, and for one
threshold alone, off by tens of per cent: ``docs/learning.md``), points where the loss falls at any
rate, if a dead time costs few events; ``through`` does where events are many; ``reset`` is that of a memory that snaps; ``authors`` is
the released simulator's."""

Slope = Literal["all", "fired"]
"""Which cells feel a loss on the number of events: all of them, or those that fired."""


@dataclass(frozen=True, eq=False)
class Gradient:
    """The gradient of a loss."""

    kernels: list[npt.NDArray[np.float64]]
    """For each kind of cell that of its kernel, (k,k); (4,k,k) of a 2x2 pattern, smaller kernels in the
    middle of zeros."""
    on: list[npt.NDArray[np.float64]]
    """For each kind of cell that of its ON threshold, (1,); (4,) of a pattern."""
    off: list[npt.NDArray[np.float64]]
    """The same of the OFF threshold, a positive magnitude."""
    sigma: list[npt.NDArray[np.float64]]
    """The same of the deviation of the thresholds' mismatch, which ON and OFF share."""
    light: npt.NDArray[Any] | None
    """That of the light (0 to 255), (B,T,H,W), or (T,H,W) of one clip; where it was asked for."""


class Forward:
    """What a sensor made of clips, and what the way back needs; :func:`forward` makes it."""

    def __init__(self, seen: _amacrine.Seen, batched: bool) -> None:
        self._seen, self._batched = seen, batched

    @property
    def voxels(self) -> npt.NDArray[Any]:
        """Voxels in events, of the dtype that was asked for: (B,T,K,H,W), or (T,K,H,W) of one clip.
        Bins are centred on the frames, as in ``Sensor.voxels(frames, fps)``."""
        voxels = self._seen.voxels.reshape(self._seen.shape)
        return voxels if self._batched else voxels[0]

    @property
    def counts(self) -> npt.NDArray[np.int32]:
        """Signed counts between each two frames, (B,T-1,K,H,W), or (T-1,K,H,W) of one clip."""
        clips, frames, *rest = self._seen.shape
        counts = self._seen.counts.reshape(clips, frames - 1, *rest)
        return counts if self._batched else counts[0]

    @property
    def events(self) -> int:
        """The number of events of all clips."""
        return self._seen.events

    def backward(
        self,
        voxels: npt.ArrayLike | None = None,
        counts: npt.ArrayLike | None = None,
        *,
        events: float = 0.0,
        rule: Rule | None = None,
        slope: Slope = "all",
        light: bool = False,
    ) -> Gradient:
        """The gradient of a loss, from its gradients of what came out.

        Args:
            voxels: The loss's gradient of :attr:`voxels`, in their shape.
            counts: The loss's gradient of :attr:`counts`, in their shape.
            events: The loss's gradient of the number of events, whatever their sign.
            rule: What flows back through the memory; ``through`` where it steps and ``reset`` where
                it snaps if it is left out.
            slope: Which cells feel ``events``; with the rule ``mean`` those that leave their play.
            light: Whether the light's gradient is wanted.
        """
        of_voxels = self._flat(voxels, self.voxels.shape)
        of_counts = self._flat(counts, self.counts.shape)
        asked = arguments.number("events", events, "give the loss's gradient, such as events=1e-7")
        kinds, back = self._seen.backward(
            of_voxels,
            of_counts,
            asked,
            arguments.word_or_none("rule", rule, "mean"),
            arguments.word("slope", slope, "all"),
            arguments.flag("light", light),
        )
        if back is not None:
            clips, frames, _, height, width = self._seen.shape
            back = back.reshape(clips, frames, height, width)
            back = back if self._batched else back[0]
        return Gradient(
            kernels=[stacked(own) if len(own) > 1 else own[0] for own, *_ in kinds],
            on=[np.array(on) for _, on, *_ in kinds],
            off=[np.array(off) for _, _, off, *_ in kinds],
            sigma=[np.array(sigma) for _, _, _, sigma, _ in kinds],
            light=back,
        )

    def __repr__(self) -> str:
        return f"<Forward: voxels {self.voxels.shape}, {self.events} events>"

    def _flat(
        self, given: npt.ArrayLike | None, shape: tuple[int, ...]
    ) -> npt.NDArray[Any] | None:
        if given is None:
            return None
        help = "give the loss's gradient of voxels as voxels, that of counts as counts"
        array = arguments.real("a gradient", given, help)
        if array.shape != shape:
            raise Error(
                f"a gradient of shape {array.shape} of what has the shape {shape}\n"
                f"help: {help}"
            )
        return np.ascontiguousarray(array, self._seen.voxels.dtype).reshape(-1)


def forward(
    sensor: Sensor,
    frames: Any,
    fps: float | None = None,
    *,
    times: npt.ArrayLike | None = None,
    scale: float | None = None,
    dtype: npt.DTypeLike = np.float32,
    phase: float | None = None,
) -> Forward:
    """The events of clips, with what their gradient needs.

    Voxels and counts are to the bit those of the sensor in the number format ``f32`` or ``f64``, where
    the light is exact in ``dtype``, as 8-bit light is.

    Args:
        sensor: A float sensor. What has no gradient here (a memory of pixels, noise, a mesh) is an
            :class:`Error` that says what to use instead.
        frames: Light, (T,H,W), (T,1,H,W) or (B,T,1,H,W), of two frames at least.
        fps: Frames per second.
        times: The time of each frame in seconds, in place of ``fps``.
        scale: What floats are multiplied by to be light from 0 to 255.
        dtype: float32 or float64: all is computed in it.
        phase: Begins each memory between two thresholds, at a place of each cell's own that this moves
            on (1 is once around). Left out, memories begin at the first frame.
    """
    check_float(sensor)
    number = arguments.dtype(dtype, "float32 or float64")
    if number not in (np.float32, np.float64):
        raise Error(f"gradients in {number}\nhelp: give float32 or float64")
    given = clips(frames, scale)
    light = np.ascontiguousarray(given.all, number)
    if given.scale != 1.0:
        # As the sensor has it: multiplied in double precision, rounded once.
        light = (given.all.astype(np.float64) * given.scale).astype(number)
    shift = arguments.phase(phase)
    seen = _amacrine.forward(
        sensor._native, None, light, seconds(given.frames, fps, times), sensor._seed, shift
    )
    return Forward(seen, given.batched)


def check_float(sensor: Any) -> None:
    """Refuses what is no float model in single or double precision: there are gradients of nothing
    else."""
    if not isinstance(sensor, Sensor):
        raise Error(
            f"the gradient of a {type(sensor).__name__}\n"
            "help: give a Sensor, the float model: amacrine.Sensor.from_file(…) for a name or a file"
        )
    if sensor._format not in ("f32", "f64"):
        raise Error(
            f"{sensor.name} computes in {sensor._format}, and gradients in float32 or float64\n"
            'help: give sensor.in_format("f64")'
        )


def seconds(frames: int, fps: float | None, times: npt.ArrayLike | None) -> list[float]:
    """The time of each frame."""
    if frames < 2:
        raise Error(f"{frames} frame{'s' * (frames != 1)}\nhelp: give at least two frames: the first makes no event")
    if times is not None:
        if fps is not None:
            raise Error("fps and times both say when frames are\nhelp: give one of them")
        given = arguments.numbers("times", times, "give the time of each frame, in seconds")
        if len(given) != frames:
            raise Error(f"{len(given)} times for {frames} frames\nhelp: give one for each, in s")
        return given
    rate = arguments.rate(fps)
    if math.isinf(rate):
        raise Error(f"{fps} frames per second is no rate\nhelp: give fps, such as fps=240")
    return [n / rate for n in range(frames)]
