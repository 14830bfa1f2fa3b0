"""One step of the same U-Net in PyTorch: python learn/frameworks/step.py [threads]."""

import sys
import time

import torch
from torch import nn

torch.set_num_threads(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
WIDTHS = [16, 32, 48, 64]


def level(inputs, width):
    return nn.Sequential(
        nn.Conv2d(inputs, width, 3, padding=1), nn.ReLU(),
        nn.Conv2d(width, width, 3, padding=1), nn.ReLU(),
    )


class Net(nn.Module):
    def __init__(self):
        super().__init__()
        sides = [11, *WIDTHS]
        self.down = nn.ModuleList(level(a, b) for a, b in zip(sides, sides[1:]))
        self.up = nn.ModuleList(level(WIDTHS[n + 1] + WIDTHS[n], WIDTHS[n]) for n in (2, 1, 0))
        self.head = nn.Conv2d(16, 1, 1)

    def forward(self, x):
        seen = []
        for n, layers in enumerate(self.down):
            x = layers(x if n == 0 else nn.functional.avg_pool2d(x, 2))
            seen.append(x)
        for layers, skip in zip(self.up, seen[-2::-1]):
            x = layers(torch.cat([nn.functional.interpolate(x, scale_factor=2), skip], 1))
        return self.head(x)


net = Net()
adam = torch.optim.Adam(net.parameters(), 1e-4)
x = torch.rand(8, 11, 64, 64)
times = []
for _ in range(15):
    start = time.process_time()
    adam.zero_grad()
    net(x).square().mean().backward()
    adam.step()
    times.append((time.process_time() - start) * 1e3)
times.sort()
print(f"PyTorch {torch.__version__}: median {times[7]:.0f} ms, least {times[0]:.0f} ms of processor time")
