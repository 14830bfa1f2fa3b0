//! The Rust half of the Python package: arrays in, arrays and JSON out.
//!
//! What a person meets (names, defaults, docstrings, shapes) is in `amacrine/`; here are the
//! doors to the library. Sensors and programs read frames where numpy holds them; studies, which show
//! them again and again, keep a copy. Results are handed over without a copy, and the interpreter is
//! released while anything is computed.

mod beside;
mod chance;
mod chip;
mod clock;
mod error;
mod events;
mod files;
mod frames;
mod gradient;
mod names;
mod options;
mod picture;
mod pool;
mod program;
mod readout;
mod record;
mod remade;
mod run;
mod sensor;
mod source;
mod stop;
mod study;
mod sweep;
mod tensor;
mod turn;
mod watcher;

use amacrine::{
    compile::Effort,
    reference::MemoryRule,
    scene::{ASSUMED_FPS, Range, Transfer},
    study::defaults,
};
use numpy::PyArray1;
use pyo3::{prelude::*, types::PyTuple, wrap_pyfunction};

#[pymodule]
fn _amacrine(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    // Numpy is looked up once, here: within a call that Ctrl-C has stopped that would fail.
    drop(PyArray1::<u8>::zeros(py, 0, false));
    module.add("Error", py.get_type::<error::Error>())?;
    module.add("NotFinite", py.get_type::<error::NotFinite>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("ASSUMED_FPS", ASSUMED_FPS)?;
    // That of the authors needs a kernel for the memory, for which there is no argument.
    let memories = MemoryRule::ALL.iter().rev();
    let memories = memories.filter(|rule| !rule.has_kernel());
    for (name, words) in [
        ("MEMORIES", memories.map(|rule| rule.word()).collect()),
        ("RANGES", [&["auto"][..], Range::WORDS].concat()),
        ("TRANSFERS", [&["auto"][..], Transfer::WORDS].concat()),
        ("CANDIDATES", defaults::CANDIDATES.split(',').collect()),
    ] {
        module.add(name, PyTuple::new(py, words)?)?;
    }
    module.add("CHIP", defaults::CHIP)?;
    module.add("DOMAIN", defaults::DOMAIN)?;
    module.add("TO", defaults::TO)?;
    module.add("EFFORT", Effort::SECONDS)?;
    module.add("FEASIBILITY_CHIPS", defaults::FEASIBILITY_CHIPS)?;
    module.add("LINK_PJ", PyTuple::new(py, defaults::LINK_PJ)?)?;
    module.add("WATERFALL_CHIPS", defaults::WATERFALL_CHIPS)?;
    module.add("SAMPLE", defaults::SAMPLE)?;
    module.add("TRADE_WITHIN", defaults::TRADE_WITHIN.0 as f64 / 1e6)?;
    module.add("RUNS", defaults::RUNS)?;
    module.add_class::<sensor::Sensor>()?;
    module.add_class::<chip::Chip>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<stop::Halt>()?;
    module.add_class::<turn::Turn>()?;
    module.add_class::<program::Program>()?;
    module.add_class::<gradient::Seen>()?;
    module.add_class::<events::Events>()?;
    module.add_class::<tensor::Voxels>()?;
    module.add_class::<tensor::Stream>()?;
    module.add_function(wrap_pyfunction!(pool::set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(pool::threads, module)?)?;
    module.add_function(wrap_pyfunction!(options::in_words, module)?)?;
    module.add_function(wrap_pyfunction!(names::names, module)?)?;
    module.add_function(wrap_pyfunction!(names::meant, module)?)?;
    module.add_function(wrap_pyfunction!(names::is_sensor, module)?)?;
    module.add_function(wrap_pyfunction!(chip::check_domain, module)?)?;
    module.add_function(wrap_pyfunction!(names::text, module)?)?;
    module.add_function(wrap_pyfunction!(files::read, module)?)?;
    module.add_function(wrap_pyfunction!(files::write, module)?)?;
    module.add_function(wrap_pyfunction!(files::compare, module)?)?;
    module.add_function(wrap_pyfunction!(files::save, module)?)?;
    module.add_function(wrap_pyfunction!(source::scene, module)?)?;
    module.add_function(wrap_pyfunction!(study::compile_filter, module)?)?;
    module.add_function(wrap_pyfunction!(study::quantise, module)?)?;
    module.add_function(wrap_pyfunction!(study::on_chip, module)?)?;
    module.add_function(wrap_pyfunction!(study::design, module)?)?;
    module.add_function(wrap_pyfunction!(study::feasibility, module)?)?;
    module.add_function(wrap_pyfunction!(study::waterfall, module)?)?;
    module.add_function(wrap_pyfunction!(study::trade, module)?)?;
    module.add_function(wrap_pyfunction!(study::trade_program, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep_hash, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::merge, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep_rows, module)?)?;
    module.add_function(wrap_pyfunction!(gradient::forward, module)?)?;
    module.add_function(wrap_pyfunction!(gradient::learned_text, module)?)?;
    module.add_function(wrap_pyfunction!(tensor::check_room, module)?)?;
    module.add_function(wrap_pyfunction!(tensor::voxels, module)?)?;
    module.add_function(wrap_pyfunction!(tensor::surfaces, module)?)?;
    module.add_function(wrap_pyfunction!(tensor::event_frames, module)?)?;
    module.add_function(wrap_pyfunction!(chance::uniform, module)?)?;
    module.add_function(wrap_pyfunction!(picture::register_picture, module)?)?;
    module.add_function(wrap_pyfunction!(picture::event_picture, module)?)?;
    Ok(())
}
