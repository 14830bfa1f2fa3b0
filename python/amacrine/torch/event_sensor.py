"""A sensor as a layer, with the adjoint of the reference as its way back."""

from __future__ import annotations

import math
import weakref
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch.autograd.function import once_differentiable

from .. import _amacrine, arguments
from .._amacrine import Error, NotFinite
from ..frames import shaped
from ..gradient import Rule, Slope, check_float, seconds
from ..kernels import Kernels
from ..sensor import Sensor, Thresholds, stacked

RULES = ("through", "reset", "authors", "mean")

OPTIONS = ("response", "memory", "border", "refractory", "names", "name")
"""What of :class:`amacrine.Sensor` a layer can be told."""


_Set = tuple[float, float | None, Rule | None, Slope, float | None, float | None, int | None]
"""Frames per second, scale, rule, slope, mismatch, phase and seed."""


class Watched(NamedTuple):
    """What a sensor made of a batch of clips."""

    voxels: torch.Tensor
    """Voxels in events, (B,T,K,H,W), or (T,K,H,W) of one clip: a bin for each frame, centred on it,
    which shares an event with the bin of the frame beside it. To stack bins and kinds for a
    convolution: ``voxels.flatten(1, 2)`` of clips, ``voxels.flatten(0, 1)`` of one."""
    counts: torch.Tensor
    """ON less OFF between each two frames, (B,T-1,K,H,W), or (T-1,K,H,W) of one clip."""
    events: torch.Tensor
    """The number of events of all clips, whatever their sign; a scalar whose gradient all cells feel
    (``slope="all"``), or those that fired."""


class EventSensor(torch.nn.Module):
    """A float sensor whose kernels and thresholds are learned.

    Frames go in, voxels and counts come out: without ``phase`` to the bit those of the sensor that
    :meth:`to_sensor` gives, for light that is exact in ``dtype``, as 8-bit light is. The way back is the
    adjoint of the float model (``docs/learning.md``): kernels, thresholds and light have gradients. It
    is computed on the processor, on all threads and with the interpreter released; the results are the
    same on any number of them, and on any device. The answer lies where the layer does (``layer.cuda()``);
    frames may lie elsewhere: those that a ``DataLoader`` gives are best left on the processor. There is
    one derivative: no second one, and no ``torch.func``. A loss whose gradient is NaN or infinite, or
    leaves the dtype on its way, gives NaN back for all of them, as ``torch.amp.GradScaler`` and
    ``torch.autograd.detect_anomaly`` look for; the next clip is then an :class:`amacrine.Error`, if a
    step was taken with it. Where PyTorch keeps copies of what is saved, or nothing
    (``torch.utils.checkpoint``, ``save_on_cpu``), the way back makes the events again.

    Args:
        kernels: (K,k,k) or (K,1,k,k), or names, as for :class:`amacrine.Sensor`: where learning begins.
        thresholds: As for :class:`amacrine.Sensor`, in the unit of the filtered signal. Their
            logarithms are learned, so that they stay above 0.
        fps: Frames per second.
        scale: What frames are multiplied by to be light from 0 to 255: 255 where they are 0 to 1.
            ``uint8`` frames are light as they are, unless it is given.
        rule: What flows back through the memory: ``"through"``, ``"reset"``, ``"authors"`` or
            ``"mean"``; ``"through"`` where the memory steps and ``"reset"`` where it snaps if it is left
            out. Where events are few, ``"mean"`` points where the loss falls.
        slope: Which cells feel a loss on the number of events: ``"all"`` or ``"fired"``. With the rule
            ``"mean"`` those that leave their play, whatever it is.
        mismatch: Deviation of the thresholds from cell to cell, as a share of their mean; a fixed
            pattern that ``seed`` chooses, and that learns with the thresholds. Left out, that of
            ``thresholds`` (``sigma``).
        phase: Begins each memory between two thresholds, at a place of its own that this moves on,
            another for each clip of a batch; left out, all begin at the first frame.
        seed: Chooses mismatch and phases; that of :meth:`to_sensor` without either, too.
        dtype: ``torch.float32`` or ``torch.float64``: all is computed in it.
        options: Of :class:`amacrine.Sensor`: ``response``, ``memory`` (``"filtered-step"`` or
            ``"filtered-snap"``), ``border``, ``refractory``, ``names``, ``name``.

    Attributes:
        kernels: The parameter (K,k,k), row 0 to the north; kernels of several sizes have zeros round
            them up to the largest.
        log_thresholds: The parameter (K,2): the logarithms of the ON and the OFF threshold. Weight
            decay, which ``torch.optim.AdamW`` has by default, pulls them to 0, thresholds to 1, and
            kernels to 0: give both a parameter group of their own with ``weight_decay=0``.

        given_thresholds: The buffer (K,2): the thresholds with which learning began.
        given_log_thresholds: The buffer (K,2): their logarithms, by which it is known which thresholds
            have not been learned, in whatever dtype and on whatever machine.

    A ``state_dict`` holds these; ``fps``, ``scale``, rule, mismatch and seed are those of the layer
    that takes it.
    """

    _given_sigma: _GivenSigma | None = None
    """Where the mismatch is that of the sensor it began as."""

    def __init__(
        self,
        kernels: Kernels,
        thresholds: Thresholds,
        *,
        fps: float,
        scale: float | None = None,
        rule: Rule | None = None,
        slope: Slope = "all",
        mismatch: float | None = None,
        phase: float | None = None,
        seed: int = 0,
        dtype: torch.dtype = torch.float32,
        **options: Any,
    ) -> None:
        super().__init__()
        odd = sorted(set(options) - {*OPTIONS, "noise"})
        if odd:
            raise Error(f"a layer has no option {odd[0]}\nhelp: give {', '.join(OPTIONS)}")
        given = kernels.detach().cpu() if isinstance(kernels, torch.Tensor) else kernels
        limits = thresholds
        if isinstance(limits, torch.Tensor):
            limits = limits.detach().cpu().double().tolist()
        sensor = Sensor(given, limits, **options)
        self._make(sensor, dtype, (fps, scale, rule, slope, mismatch, phase, seed))

    @classmethod
    def from_sensor(
        cls,
        sensor: Sensor,
        *,
        fps: float,
        scale: float | None = None,
        rule: Rule | None = None,
        slope: Slope = "all",
        mismatch: float | None = None,
        phase: float | None = None,
        seed: int | None = None,
        dtype: torch.dtype = torch.float32,
    ) -> EventSensor:
        """The layer that begins as this sensor, each of whose kinds of cells has one kernel; with its
        mismatch and its seed, where they are left out."""
        self = cls.__new__(cls)
        torch.nn.Module.__init__(self)
        self._make(sensor, dtype, (fps, scale, rule, slope, mismatch, phase, seed))
        return self

    def _make(self, sensor: Sensor, dtype: torch.dtype, how: _Set) -> None:
        """The layer that begins as this sensor; with its mismatch and its seed, where none is given."""
        fps, scale, rule, slope, mismatch, phase, seed = how
        # Parameters that are made in inference mode could never be learned.
        with torch.inference_mode(False):
            self._begin(sensor, dtype)
            own = mismatch is None
            if mismatch is None:
                mismatch = _mismatch(sensor, self.given_thresholds)
            if own:
                self._given_sigma = _GivenSigma.of(sensor, float(mismatch), self.given_thresholds)
            if seed is None:
                seed = sensor._seed
            self._set(fps, scale, rule, slope, mismatch, phase, seed)

    def _begin(self, sensor: Sensor, dtype: torch.dtype) -> None:
        _check_dtype(dtype)
        check_float(sensor)
        if not sensor._native.plain:
            raise Error(
                f"{sensor.name}: its kinds of cells are more than kernels\n"
                "help: give every kind one kernel (k,k), without a pattern, a mesh or log-temporal"
            )
        weights = torch.from_numpy(stacked(sensor.kernels))
        limits = torch.from_numpy(np.stack([limit[:2] for limit in sensor.thresholds]))
        given = limits.to(dtype)
        logarithms = given.double().log().to(dtype)
        self.kernels = torch.nn.Parameter(weights.to(dtype))
        self.log_thresholds = torch.nn.Parameter(logarithms.clone())
        self.given_thresholds: torch.Tensor
        self.given_log_thresholds: torch.Tensor
        self.register_buffer("given_thresholds", given)
        self.register_buffer("given_log_thresholds", logarithms)
        self._template = sensor

    def _set(
        self,
        fps: float,
        scale: float | None,
        rule: Rule | None,
        slope: Slope,
        mismatch: float,
        phase: float | None,
        seed: int,
    ) -> None:
        if rule is not None and rule not in RULES:
            raise Error(f"`{rule}` is no rule of the gradient\nhelp: give one of {', '.join(RULES)}")
        if slope not in ("all", "fired"):
            raise Error(f"`{slope}` is no slope\nhelp: give all or fired")
        self.mismatch = arguments.share("mismatch", mismatch)
        seconds(2, fps, None)
        self.fps, self.rule, self.slope = arguments.rate(fps), rule, slope
        self.scale = None if scale is None else arguments.scale(scale)
        self.phase = arguments.phase(phase)
        self.seed = arguments.whole("seed", seed)
        # What no clip passes is told here, not after the first.
        side = self.kernels.shape[-1]
        light = torch.zeros((1, 2, side, side), dtype=self.kernels.dtype, device="cpu")
        with torch.enable_grad():
            torch.autograd.backward(self._watched(light).events)
        self.zero_grad()
        # Made and tried on the processor, whose logarithms are those of any device.
        self.to(torch.empty(0).device)

    @property
    def thresholds(self) -> torch.Tensor:
        """ON and OFF thresholds, (K,2), in the unit of the filtered signal."""
        return self._limits().to(self.log_thresholds.device)

    def _limits(self) -> torch.Tensor:
        """The thresholds on the processor: other devices round an exponential in another way. Where
        nothing was learned yet, those that were given, to the bit."""
        logarithms, given = self.log_thresholds.cpu(), self.given_thresholds.cpu()
        limits = logarithms.exp()
        # Of many a number the exponential of its logarithm is the one beside it. Numbers that are so
        # near differ by what needs no rounding.
        at_first = (logarithms == self.given_log_thresholds.cpu()) & limits.isfinite()
        rest = torch.where(at_first, given - limits, 0.0)
        return limits + rest.detach()

    def _sigma(self, limits: torch.Tensor) -> torch.Tensor:
        """The deviation of the thresholds of each kind, (K,1), on the processor: their mean times the
        mismatch. Where nothing was learned yet, that of the sensor it began as, to the bit."""
        limits = limits.double()
        sigma = self.mismatch * limits.mean(1, keepdim=True)
        given = self._given_sigma
        if given is None or given.mismatch != self.mismatch:
            return sigma
        # What a number is of another, times that other, may be the number beside it.
        at_first = (limits == given.thresholds).all(1, keepdim=True)
        return sigma + torch.where(at_first, given.sigma - sigma, 0.0).detach()

    def forward(self, frames: torch.Tensor) -> Watched:
        """The events of clips: light of shape (T,H,W), (T,1,H,W) or (B,T,1,H,W), two frames at
        least."""
        # Whoever calls half() or bfloat16() has changed it since.
        _check_dtype(self.kernels.dtype)
        light, batched = self._light(frames)
        seen = self._watched(light)
        return seen if batched else Watched(seen.voxels[0], seen.counts[0], seen.events)

    def _watched(self, light: torch.Tensor) -> Watched:
        """The events of light (B,T,H,W)."""
        clips, frames, height, width = light.shape
        how = _How(
            native=self._template._native,
            times=seconds(frames, self.fps, None),
            seed=self.seed,
            phase=self.phase,
            rule=self.rule,
            slope=self.slope,
        )
        kernels, thresholds, light = self.kernels.cpu(), self._limits(), light.cpu()
        to = self.kernels.device
        if clips == 0:
            # Of no clip, with a gradient of 0.
            none = (0.0 * (kernels.sum() + thresholds.sum() + light.sum())).to(to)
            voxels = none.new_zeros((0, frames, len(kernels), height, width))
            return Watched(voxels + none, voxels[:, 1:] + none, none)
        voxels, counts, events = _Watch.apply(
            kernels, thresholds, self._sigma(thresholds), light, how
        )
        return Watched(voxels.to(to), counts.to(to), events.to(to))

    def _light(self, frames: torch.Tensor) -> tuple[torch.Tensor, bool]:
        """Light from 0 to 255, (B,T,H,W), and whether there are several clips."""
        if not isinstance(frames, torch.Tensor):
            frames = _tensor(frames)
        if frames.layout != torch.strided or frames.is_meta:
            what = "without memory (meta)" if frames.is_meta else "that is sparse"
            raise Error(f"frames are a tensor {what}\nhelp: give a dense one (tensor.to_dense())")
        shape = tuple(frames.shape)
        if frames.is_complex():
            raise Error(f"frames of dtype {frames.dtype} are no light\nhelp: give uint8 or floats")
        if frames.dtype != torch.uint8 and self.scale is None:
            raise Error(
                f"frames of dtype {frames.dtype} have no scale of their own\n"
                "help: say what they are multiplied by to be light from 0 to 255: "
                "EventSensor(…, scale=255) where they are 0 to 1, scale=1 where they are 0 to 255"
            )
        light = frames.to(self.kernels.dtype)
        if frames.dtype != torch.uint8 or self.scale is not None:
            light = light * (1.0 if self.scale is None else self.scale)
        if len(shape) == 3:
            return light[None], False
        if len(shape) == 4 and shape[1] == 1:
            return light[None, :, 0], False
        if len(shape) == 5 and shape[2] == 1:
            return light[:, :, 0], True
        raise Error(
            f"frames of shape {shape} are no clip\n"
            f"help: {shaped(shape)}"
        )

    def to_sensor(self, name: str | None = None) -> Sensor:
        """The sensor as it is now, which makes the same counts and voxels where the layer has no
        ``phase``; its ``text`` is the file that ``amacrine run --sensor`` takes, of a layer with
        mismatch with ``--seed``, which a comment in it says."""
        limits = self._limits().detach().double()
        parameters = _parameters(self.kernels, limits, self._sigma(limits))
        text = _amacrine.learned_text(self._template._native, parameters, name)
        if self.mismatch > 0:
            text = f"# The seed that chose the mismatch is not in here: --seed {self.seed}\n{text}"
        format = "f32" if self.kernels.dtype == torch.float32 else "f64"
        return Sensor.from_text(text, seed=self.seed, format=format)

    def extra_repr(self) -> str:
        """What stands in the representation of the layer."""
        kinds, rows, columns = self.kernels.shape
        count = "1 kind" if kinds == 1 else f"{kinds} kinds"
        return f"{count} of {rows}x{columns}, fps={self.fps}, rule={self.rule or 'by memory'}"


def _tensor(frames: Any) -> torch.Tensor:
    """An array as a tensor; in the byte order of the machine, since tensors have no other."""
    arguments.unmasked("frames", frames)
    called = type(frames).__name__
    try:
        array = np.ascontiguousarray(frames)
        called = f"{called} and dtype {array.dtype}"
        return torch.as_tensor(array.astype(array.dtype.newbyteorder("="), copy=False), device="cpu")
    except (TypeError, ValueError, RuntimeError) as cause:
        raise Error(f"frames of type {called} are no light\nhelp: give a tensor or an array") from cause


def _check_dtype(dtype: torch.dtype) -> None:
    """Refuses what the adjoint is not computed in."""
    if dtype not in (torch.float32, torch.float64):
        raise Error(f"a sensor in {dtype}\nhelp: give torch.float32 or torch.float64")


class _GivenSigma(NamedTuple):
    """The mismatch of the sensor that a layer began as."""

    mismatch: float
    """As a share of the mean."""
    thresholds: torch.Tensor
    """Its thresholds (K,2), as the layer has them."""
    sigma: torch.Tensor
    """Their deviations (K,1)."""

    @classmethod
    def of(cls, sensor: Sensor, mismatch: float, thresholds: torch.Tensor) -> _GivenSigma:
        sigma = torch.from_numpy(np.stack([limit[2:] for limit in sensor.thresholds]))
        return cls(mismatch, thresholds.double().clone(), sigma)


def _mismatch(sensor: Sensor, thresholds: torch.Tensor) -> float:
    """The mismatch of a sensor, as a share of the mean of its thresholds (K,2) as a layer has them.

    Of the numbers beside the quotient that give the deviations back, the shortest: of a layer's sensor
    the share that the layer had.
    """
    shares = [float(limit[2] / limit[:2].mean()) for limit in sensor.thresholds]
    if max(shares) - min(shares) > 1e-9:
        told = ", ".join(f"{share:.4g}" for share in shares)
        raise Error(
            f"{sensor.name}: the mismatch of its kinds of cells is {told} of their thresholds\n"
            "help: give one for all, such as mismatch=0.1"
        )
    means: list[float] = thresholds.double().mean(1).tolist()
    deviations = [float(limit[2]) for limit in sensor.thresholds]
    near = [deviations[0] / means[0]]
    for end in (0.0, math.inf):
        beside = near[0]
        for _ in range(2):
            beside = math.nextafter(beside, end)
            near.append(beside)
    pairs = list(zip(means, deviations))
    fitting = (share for share in near if all(share * mean == of for mean, of in pairs))
    return min(fitting, key=lambda share: len(repr(share)), default=near[0])


def _parameters(
    kernels: torch.Tensor, limits: torch.Tensor, sigma: torch.Tensor
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Kernels (K,k,k) and thresholds with their mismatch (K,3), as the library takes them."""
    weights = kernels.detach().cpu().double().contiguous().numpy()
    both = torch.cat([limits.double(), sigma], 1).detach()
    return weights, both.contiguous().numpy()


class _How(NamedTuple):
    """What has no gradient."""

    native: _amacrine.Sensor
    times: list[float]
    seed: int
    phase: float | None
    rule: Rule | None
    slope: Slope


class _Held:
    """A pass, held by a tensor that PyTorch frees with what it saved itself."""

    def __init__(self, seen: _amacrine.Seen) -> None:
        self.seen = seen
        self._byte = np.zeros(1, np.uint8)
        self.__array_interface__ = self._byte.__array_interface__
        _KEPT[self._byte.ctypes.data] = self

    def tensor(self) -> torch.Tensor:
        """A tensor of one byte whose memory is this object's."""
        return torch.from_numpy(np.asarray(self))


_KEPT: weakref.WeakValueDictionary[int, _Held] = weakref.WeakValueDictionary()
"""By the address of their byte: a copy of the tensor finds nothing here."""


def _watch(how: _How, *given: torch.Tensor) -> _amacrine.Seen:
    """What cells of these kernels, thresholds and deviations see in light."""
    kernels, thresholds, sigma, light = given
    return _amacrine.forward(
        how.native,
        _parameters(kernels, thresholds, sigma),
        light.detach().contiguous().numpy(),
        how.times,
        how.seed,
        how.phase,
    )


class _Watch(torch.autograd.Function):
    """Light, kernels and thresholds to voxels, counts and the number of events, on the processor."""

    @staticmethod
    def forward(
        ctx: Any,
        kernels: torch.Tensor,
        thresholds: torch.Tensor,
        sigma: torch.Tensor,
        light: torch.Tensor,
        how: _How,
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        seen = _watch(how, kernels, thresholds, sigma, light)
        # The pass is kept with the first of them; where that is not what is saved, but a copy of it,
        # the others make it again. An optimiser may step before the way back.
        given = (kernels.clone(), thresholds, sigma, light)
        ctx.save_for_backward(_Held(seen).tensor(), *(of.detach() for of in given))
        ctx.how = how
        ctx.set_materialize_grads(False)
        clips, frames, *rest = seen.shape
        # Not a view of another tensor, which could not be changed in place.
        voxels = torch.from_numpy(seen.voxels.reshape(seen.shape))
        counts = torch.from_numpy(seen.counts).reshape(clips, frames - 1, *rest)
        events = torch.tensor(float(seen.events), dtype=kernels.dtype, device="cpu")
        return voxels, counts.to(kernels.dtype), events

    @staticmethod
    @once_differentiable
    def backward(
        ctx: Any,
        voxels: torch.Tensor | None,
        counts: torch.Tensor | None,
        events: torch.Tensor | None,
    ) -> tuple[torch.Tensor | None, ...]:
        # Freed after the first backward without retain_graph: PyTorch then says so here.
        byte, *given = ctx.saved_tensors
        held = _KEPT.get(byte.data_ptr())
        seen = _watch(ctx.how, *given) if held is None else held.seen
        asked = 0.0 if events is None else float(events)
        wants_light = bool(ctx.needs_input_grad[3])
        try:
            kinds, light = seen.backward(
                _flat(voxels), _flat(counts), asked, ctx.how.rule, ctx.how.slope, wants_light
            )
        except NotFinite:
            nan = [torch.full_like(of, torch.nan) for of in given]
            return *nan[:3], nan[3] if wants_light else None, None
        weights = np.stack([own[0] for own, *_ in kinds])
        limits = np.array([[on[0], off[0]] for _, on, off, *_ in kinds])
        spread = np.array([sigma for _, _, _, sigma, _ in kinds])
        of_parameters = (torch.from_numpy(of) for of in (weights, limits, spread))
        back = None
        if light is not None:
            clips, frames, _, height, width = seen.shape
            back = torch.from_numpy(light).reshape(clips, frames, height, width)
        own = [of.to(to.dtype) for of, to in zip(of_parameters, given)]
        return *own, back, None


def _flat(of: torch.Tensor | None) -> Any:
    return None if of is None else of.detach().contiguous().reshape(-1).numpy()
