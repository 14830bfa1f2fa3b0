"""Reads what amacrine wrote with everybody's readers, and compares event by event.

    readers.py FOLDER     FOLDER/CASE/{reference.npy, a.FORMAT…}, FOLDER/lines.txt

Prints one line for each reader that agrees; the first that does not is an error.
"""

import os
import pathlib
import sys
import warnings

import numpy as np

warnings.filterwarnings("ignore")

import aedat
import dv
import dv_processing
import event_stream
import eventcv
import evlib
import expelliarmus
import faery
import polars


def nothing():
    return [np.zeros(0, int)] * 4


def joined(parts, names):
    parts = [part for part in parts]  # not list(): dv has no length
    if not parts:
        return nothing()
    array = np.concatenate(parts)
    return [array[name] for name in names]


def by_faery(path):
    array = faery.events_stream_from_file(path).to_array()
    return [array[name] for name in ("t", "x", "y", "on")]


def by_faery_upside_down(path):
    stream = faery.events_stream_from_file(path)
    height = stream.dimensions()[1]
    t, x, y, p = by_faery(path)
    return t, x, height - 1 - y.astype(int), p


def by_expelliarmus(encoding):
    def read(path):
        array = expelliarmus.Wizard(encoding).read(path)
        return [array[name] for name in "txyp"]

    return read


def by_evlib(path):
    table = evlib.load_events(str(path)).collect()
    t = table["t"].cast(polars.Int64).to_numpy()
    # OFF is -1 here.
    return t, table["x"].to_numpy(), table["y"].to_numpy(), table["polarity"].to_numpy() > 0


def by_eventcv(path):
    array = eventcv.load(str(path)).numpy()
    return array[:, 2], array[:, 0], array[:, 1], array[:, 3]


def by_aedat(path):
    return joined((p["events"] for p in aedat.Decoder(path) if "events" in p), ("t", "x", "y", "on"))


def by_dv_processing(path):
    recording = dv_processing.io.MonoCameraRecording(str(path))
    batches = iter(recording.getNextEventBatch, None)
    return joined((b.numpy() for b in batches), ("timestamp", "x", "y", "polarity"))


def by_dv(path):
    return joined(dv.AedatFile(path)["events"].numpy(), ("timestamp", "x", "y", "polarity"))


def by_dv_legacy(path):
    events = [(e.timestamp, e.x, e.y, e.polarity) for e in dv.LegacyAedatFile(path)]
    return np.array(events, dtype=np.int64).T if events else nothing()


def by_event_stream(path):
    return joined(event_stream.Decoder(path), ("t", "x", "y", "on"))


def by_numpy(path):
    arrays = np.load(path)
    return [arrays[name] for name in "txyp"]


def by_h5py(path):
    import h5py

    with h5py.File(path) as file:
        events = {name: file["events"][name][:] for name in "txyp"}
        relative = events["t"].astype(np.int64)
        t = relative + int(file["t_offset"][()])
        index = file["ms_to_idx"][:]
    # The definition of the index: the first event at or after each millisecond.
    wanted = np.searchsorted(relative, np.arange(len(index)) * 1000)
    assert (index == wanted).all(), "ms_to_idx"
    return t, events["x"], events["y"], events["p"]


def by_pyarrow(path):
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    return [table[name].to_numpy() for name in "txyp"]


def by_polars(path):
    table = polars.read_parquet(path)
    return [table[name].to_numpy() for name in "txyp"]


def by_pandas(path):
    import pandas

    read = pandas.read_parquet if path.suffix == ".parquet" else pandas.read_csv
    table = read(path)
    return [table[name].to_numpy() for name in "txyp"]


def by_pandas_of_seconds(path):
    import pandas

    table = pandas.read_csv(path, sep=" ", header=None, names=["t", "x", "y", "p"])
    return np.rint(table["t"].to_numpy(float) * 1e6), table["x"], table["y"], table["p"]


def by_numpy_of_seconds(skiprows):
    def read(path):
        t, x, y, p = np.loadtxt(path, skiprows=skiprows, ndmin=2).reshape(-1, 4).T
        return np.rint(t * 1e6), x, y, p

    return read


def by_numpy_of_csv(path):
    table = np.loadtxt(path, dtype=np.int64, delimiter=",", skiprows=1, ndmin=2)
    return table.reshape(-1, 4).T


def by_csv(path):
    import csv

    with open(path, newline="") as file:
        rows = [[int(row[name]) for name in "txyp"] for row in csv.DictReader(file)]
    return np.array(rows, dtype=np.int64).reshape(-1, 4).T


def by_e2vid(path):
    # As its run_reconstruction.py opens a file, text or zip.
    import pandas

    size = pandas.read_csv(path, sep=r"\s+", header=None, names=["width", "height"], nrows=1)
    assert size.values.tolist() == [[346, 260]], size
    names = ["t", "x", "y", "pol"]
    kinds = {"t": np.float64, "x": np.int16, "y": np.int16, "pol": np.int16}
    table = pandas.read_csv(path, sep=r"\s+", header=None, names=names, dtype=kinds, skiprows=1)
    return np.rint(table["t"].to_numpy() * 1e6), table["x"], table["y"], table["pol"]


#                 the readers of a format, and the cases that each cannot read
READERS = {
    "csv": [(by_pandas, ()), (by_numpy_of_csv, ()), (by_csv, ()), (by_faery, ())],
    "txt": [
        (by_numpy_of_seconds(0), ()),
        (by_pandas_of_seconds, ()),
        (by_eventcv, ("one", "empty")),
    ],
    "npy": [(by_numpy, ())],
    "e2vid": [(by_e2vid, ()), (by_numpy_of_seconds(1), ())],
    "zip": [(by_e2vid, ())],
    "npz": [(by_numpy, ()), (by_eventcv, ("empty",))],
    "evt2": [
        (by_faery, ()),
        (by_expelliarmus("evt2"), ("many", "wrap", "empty")),
        (by_evlib, ("many", "wrap", "empty")),
        (by_eventcv, ("many", "empty")),
    ],
    "evt2.1": [(by_evlib, ("empty",))],
    "evt3": [(by_faery, ()), (by_evlib, ("many", "empty")), (by_eventcv, ("many", "empty"))],
    "dat": [(by_faery, ()), (by_expelliarmus("dat"), ("many", "empty")), (by_eventcv, ("many", "empty"))],
    "aedat2": [(by_dv_legacy, ("many",))],
    "aedat3": [(by_dv_legacy, ("many",))],
    "aedat4": [
        (by_aedat, ()),
        (by_faery, ("many",)),
        (by_dv_processing, ("many",)),
        (by_dv, ("many",)),
        (by_eventcv, ("many", "empty")),
    ],
    "aedat4-zstd": [(by_aedat, ()), (by_faery, ()), (by_dv_processing, ()), (by_dv, ())],
    "aedat4-none": [(by_aedat, ()), (by_faery, ()), (by_dv_processing, ()), (by_dv, ())],
    "es": [(by_event_stream, ()), (by_faery_upside_down, ())],
    "hdf5": [
        (by_h5py, ()),
        # It adds no `t_offset`.
        (by_evlib, ("late", "one", "empty")),
    ],
    "parquet": [(by_pyarrow, ()), (by_polars, ()), (by_pandas, ())],
}


def name_of(reader):
    return reader.__qualname__.split(".")[0].removeprefix("by_")


def main(folder):
    # With AMACRINE_SURVEY set, everything is tried and nothing is an error.
    strict = "AMACRINE_SURVEY" not in os.environ
    for case in sorted(p for p in folder.iterdir() if p.is_dir()):
        reference = np.load(case / "reference.npy")
        for path in sorted(case.glob("a.*")):
            kind = path.name.removeprefix("a.").removesuffix(".raw").removesuffix(".aedat4")
            kind = kind.removesuffix(".h5").removesuffix(".aedat") or "aedat4"
            for reader, cannot in READERS[kind]:
                if strict and case.name.split("-")[0] in cannot:
                    continue
                what = f"{kind} {case.name} {name_of(reader)}"
                try:
                    found = [np.asarray(column).astype(np.int64) for column in reader(path)]
                    for name, column in zip("txyp", found):
                        wanted = reference[name].astype(np.int64)
                        assert len(column) == len(wanted), f"{len(column)} of {len(wanted)} events"
                        bad = np.flatnonzero(column != wanted)
                        assert not len(bad), f"{name} of event {bad[0]} is {column[bad[0]]}, not {wanted[bad[0]]}"
                    print("agrees", what, flush=True)
                except BaseException as error:
                    if strict:
                        raise SystemExit(f"{what}: {type(error).__name__}: {error}")
                    print("DIFFERS", what, type(error).__name__, str(error)[:90], flush=True)
    # The lines that amacrine prints and docs/formats.md has.
    for line in (folder / "lines.txt").read_text().splitlines():
        scope = {}
        exec(line, scope)
        assert scope["events"] is not None
        print("opens", line, flush=True)


main(pathlib.Path(sys.argv[1]))
