"""Sensors as layers of PyTorch, and data sets of videos: needs ``torch``.

>>> import torch, amacrine.torch                                          # doctest: +SKIP
>>> layer = amacrine.torch.EventSensor(torch.randn(4, 1, 5, 5) * 0.1, 0.2, fps=30)  # doctest: +SKIP
>>> seen = layer(frames)                                                  # doctest: +SKIP
>>> (seen.voxels.square().mean() + 1e-3 * seen.events).backward()         # doctest: +SKIP
"""

try:
    import torch as _torch
except ImportError as cause:
    raise ImportError(
        "amacrine.torch needs PyTorch: pip install 'amacrine[torch]', or torch as you have it"
    ) from cause

from .event_dataset import EventDataset, Item
from .event_sensor import EventSensor, Watched

__all__ = ["EventDataset", "EventSensor", "Item", "Watched"]
