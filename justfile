# What people do here, by name. `just` lists it.
default:
    @just --list

# The demo: a real clip through both sensors, results in out/
demo:
    cargo run --release

# All tests
test:
    cargo test --release --all-features

# What CI runs
ci:
    bash .ci/run

# Speed, against plain versions, peers and the machine's limits
bench:
    cargo bench --bench reference
    cargo bench --bench array
    cargo bench --bench learn
    cargo bench --bench mesh
    cargo bench --bench files

# The field's own readers of event files against ours
interop:
    .ci/interop

# The Python package: built, tested, checked
python:
    .ci/python-package

# All that takes in bytes under libFuzzer, so many seconds each
fuzz SECONDS="60":
    .ci/fuzz {{SECONDS}}

# The bundled clip, from OpenCV's vtest.avi as y4m (see clips/README.md)
clip Y4M:
    cargo run --release --example bundle_clip -- {{Y4M}} clips/vtest_256x256.apng 1900000

# docs/gallery.md and its pictures: sensors by clips, programs by registers
gallery:
    cargo run --release --example gallery
