"""Voxels in HDF5 as h5py reads them, against the same in an array of numpy."""

import sys
from pathlib import Path

import h5py
import numpy as np

folder = Path(sys.argv[1])
for name in ["a", "b"]:
    wanted = np.load(folder / f"{name}.npy")
    with h5py.File(folder / f"{name}.h5") as file:
        voxels = file["voxels"]
        assert voxels.shape == wanted.shape and voxels.dtype == wanted.dtype
        assert voxels.chunks == (1, *wanted.shape[1:]), voxels.chunks
        assert np.array_equal(voxels[:], wanted)
        assert np.array_equal(voxels[1234, 1, :, 2], wanted[1234, 1, :, 2])
        kinds = file.attrs["kinds"]
        kinds = kinds if isinstance(kinds, str) else kinds.decode()
        assert kinds.split("\n") == ["centre-on", "kind \u00e9"], kinds
    print(name, "agrees")
