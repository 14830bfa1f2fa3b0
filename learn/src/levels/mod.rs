//! Kernels of few values: what the chip can compute, and how a gradient passes through it.
