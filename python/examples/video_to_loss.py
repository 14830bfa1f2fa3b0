"""From a clip to a loss: what a chip makes of a layer of kernels, as a network would see it.

Run it with the path of a video, or without for the clip that comes with the package.
"""

import sys
import numpy as np
import amacrine

frames, fps = amacrine.load(sys.argv[1] if len(sys.argv) > 1 else None, frames=24)
weights = np.random.default_rng(0).normal(size=(2, 1, 3, 3))  # those of a torch.nn.Conv2d
weights -= weights.mean(axis=(2, 3), keepdims=True)
sensor = amacrine.Sensor(weights, 0.4, memory="filtered-snap", border="zero")
chip = sensor.on_chip("int-5", domain="silicon")
want = sensor.voxels(frames, fps, bins=9, window=1.0, scale=1)  # (windows, kinds, bins, H, W)
got = chip.voxels(frames, fps, bins=9, window=1.0, scale=1)
loss = float(np.abs(got - want).mean())
print(f"{want.shape}: loss {loss:.4f}; {chip.words} words, {chip.array_us:.1f} us a frame")
