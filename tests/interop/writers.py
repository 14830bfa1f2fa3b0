"""Writes the events of FOLDER/reference.npy with everybody's writers, into FOLDER/theirs."""

import pathlib
import sys
import warnings

import numpy as np

warnings.filterwarnings("ignore")

import dv_processing
import event_stream
import expelliarmus
import faery

folder = pathlib.Path(sys.argv[1])
theirs = folder / "theirs"
theirs.mkdir()
events = np.load(folder / "reference.npy")
width, height = 346, 260

by_faery = np.zeros(len(events), dtype=faery.EVENTS_DTYPE)
for name, own in zip(("t", "x", "y", "on"), "txyp"):
    by_faery[name] = events[own]
for name in ("faery.evt2.raw", "faery.evt3.raw", "faery.dat", "faery.aedat4", "faery.es"):
    stream = faery.events_stream_from_array(by_faery, (width, height))
    # Or it takes the first time off.
    options = {"zero_t0": False} if not name.endswith(".aedat4") else {}
    if name.endswith(".raw"):
        options["version"] = name.split(".")[1]
    stream.to_file(str(theirs / name), **options)

by_expelliarmus = np.zeros(len(events), dtype=[("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])
for name in "txyp":
    by_expelliarmus[name] = events[name]
for encoding, name in (("evt2", "expelliarmus.raw"), ("dat", "expelliarmus.dat")):
    expelliarmus.Wizard(encoding).save(str(theirs / name), by_expelliarmus)

for kind in ("LZ4", "ZSTD", "NONE"):
    config = dv_processing.io.MonoCameraWriter.EventOnlyConfig(
        "camera", (width, height), getattr(dv_processing.CompressionType, kind)
    )
    writer = dv_processing.io.MonoCameraWriter(str(theirs / f"dv_processing.{kind}.aedat4"), config)
    store = dv_processing.EventStore()
    for t, x, y, p in events.tolist():
        store.push_back(t, x, y, bool(p))
    writer.writeEvents(store)
    del writer

own = np.zeros(len(events), dtype=event_stream.dvs_dtype)
for name, ours in zip(("t", "x", "y", "on"), "txyp"):
    own[name] = events[ours]
with event_stream.Encoder(str(theirs / "event_stream.es"), "dvs", width, height) as encoder:
    encoder.write(own)

import h5py

# As event_utils packages events, and as MVSEC has its two cameras.
for name, times in (("event_utils.h5", events["t"] * 1e-6), ("event_utils.micros.h5", events["t"])):
    with h5py.File(theirs / name, "w") as file:
        columns = {"xs": events["x"], "ys": events["y"], "ts": times, "ps": events["p"].astype(bool)}
        for column, values in columns.items():
            file.create_dataset(f"events/{column}", data=values, maxshape=(None,), chunks=True)
        file.attrs["sensor_resolution"] = (height, width)
        file.attrs["num_events"] = len(events)
        file.create_dataset("images/image000000000", data=np.zeros((height, width), np.uint8))
with h5py.File(theirs / "mvsec.h5", "w") as file:
    sign = np.where(events["p"], 1, -1)
    rows = np.stack([events["x"], events["y"], events["t"] * 1e-6, sign], 1)
    for camera, part in (("left", rows), ("right", rows[:7])):
        file.create_dataset(f"davis/{camera}/events", data=part, compression="gzip")

columns = {name: events[name] for name in "txyp"}
np.savez(theirs / "numpy.npz", **columns)
np.savez_compressed(theirs / "numpy_compressed.npz", **columns)
np.savez_compressed(theirs / "numpy_records.npz", events)
