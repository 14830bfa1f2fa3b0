"""The event generator in PyTorch, there and back, as `cargo bench --bench learn` has it: 26 frames of
256x256, 5x5 kernels, linear response, a refractory period of 1 ms by the authors' rule, and their
gradient (docs/learning.md, `authors`). Operations are passes over planes in double precision.

    python learn/frameworks/events.py [KINDS [THREADS]]
"""

import sys
import time

import torch
from torch.nn import functional

KINDS = int(sys.argv[1]) if len(sys.argv) > 1 else 1
torch.set_num_threads(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
FRAMES, SIDE, FPS, SILENCE, THRESHOLD = 26, 256, 240.0, 1e-3, 0.05


def as_if(value, smooth):
    """`value`, with the gradient of `smooth`."""
    return smooth + (value - smooth).detach()


def voxels(light, kernel, threshold):
    """Bins (T, K, H, W) of frames (T, H, W), and the number of events."""
    padded = functional.pad(light[:, None], (2, 2, 2, 2), mode="replicate")
    memory = functional.conv2d(padded[:1], kernel)
    fired = torch.full_like(memory, -SILENCE)
    bins = [torch.zeros_like(memory)]
    events = 0.0
    dt = 1.0 / FPS
    for n in range(1, len(light)):
        start = (n - 1) * dt
        d = functional.conv2d(padded[n : n + 1], kernel) - memory
        sign = as_if(d.sign(), d.tanh())
        nominal = torch.where(d >= 0, threshold, -threshold)
        spacing = dt / ((d + 1e-9 * d.sign()) / nominal)
        wait = SILENCE - (start - fired)
        apart = as_if((torch.floor(SILENCE / spacing) + 1) * spacing, SILENCE + spacing)
        before = torch.clamp(torch.floor(wait / spacing) * spacing, min=0).detach()
        fires = (apart <= dt - before).detach()
        smooth = (dt - torch.clamp(wait, min=0)) / (SILENCE + spacing + 1e-9)
        count = as_if(torch.floor((dt - before) / apart), smooth)
        triangle = apart / dt * count * (count + 1) / 2
        later = sign * (before / dt * count + triangle)
        earlier = sign * ((1 - before / dt) * count - triangle)
        # Where nothing fired, the later bin has the gradient of the distance alone.
        silent = d / nominal
        later = torch.where(fires, later, silent - silent.detach())
        earlier = torch.where(fires, earlier, 0.0)
        bins[-1] = bins[-1] + earlier
        bins.append(later)
        with torch.no_grad():
            kept = torch.where(fires, count, 0.0)
            fired = torch.where(kept > 0, start + before + apart * kept, fired)
            step = d.sign() * kept * threshold
            events += kept.sum().item()
        memory = memory + step
    return torch.cat(bins), events


torch.manual_seed(1)
# A smooth texture that pans, bright enough for about the bench's rate of events.
texture = torch.rand(SIDE + 64, SIDE + 64, dtype=torch.float64)
texture = functional.avg_pool2d(texture[None, None], 5, 1, 2)[0, 0]
texture = (texture - texture.min()) / (texture.max() - texture.min())
light = torch.stack([texture[n : n + SIDE, 2 * n : 2 * n + SIDE] for n in range(FRAMES)])
kernel = -torch.ones(KINDS, 1, 5, 5, dtype=torch.float64) / 24
kernel += torch.linspace(-5e-4, 5e-4, 25, dtype=torch.float64).reshape(5, 5)
kernel[:, :, 2, 2] = 1.0
kernel.requires_grad_()
threshold = torch.full((1, KINDS, 1, 1), THRESHOLD, dtype=torch.float64)
asked = torch.rand(FRAMES, KINDS, SIDE, SIDE, dtype=torch.float64) - 0.5
times, events = [], 0.0
for _ in range(5):
    begun = time.process_time()
    seen, events = voxels(light, kernel, threshold)
    (seen * asked).sum().backward()
    times.append((FRAMES - 1) / (time.process_time() - begun))
times.sort()
rate = events / (FRAMES - 1) / KINDS / SIDE**2
print(
    f"PyTorch {torch.__version__}, K = {KINDS}: {times[2]:.1f} pairs/s there and back"
    f" ({times[0]:.1f} to {times[-1]:.1f}), {rate:.2f} events a pixel and pair"
)
