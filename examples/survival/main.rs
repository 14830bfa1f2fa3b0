//! What comes out of the silicon: for many kernels the words of the program that is compiled with
//! either objective, the correlation that is predicted of it and the one that a run as silicon
//! gives, each at its best input amplitude, as in the table of `docs/silicon.md`.
//!
//! ```text
//! cargo run --release --example survival
//! cargo run --release --example survival -- 40000      # states looked at, 400000 when left out
//! ```

mod filters;

use std::time::Instant;

use amacrine::{
    compile::{CompileError, Effort, Objective, Request, Signal},
    isa::Device,
};

/// Chips that a correlation is the mean of.
const CHIPS: u64 = 2;

fn main() -> Result<(), CompileError> {
    let device = Device::scamp5();
    let states = std::env::args().nth(1).and_then(|it| it.parse().ok());
    let effort = states.map_or_else(Effort::default, Effort::states);
    println!(
        "| kernels | words, `words` | correlation | words, `silicon` | correlation | predicted |"
    );
    println!("|---|---|---|---|---|---|");
    let (mut low, mut seconds) = ([0; 2], [0.0; 2]);
    let filters = filters::filters();
    for (name, kernels) in &filters {
        let mut line = format!("| {name} ");
        for (i, objective) in [Objective::Words, Objective::Silicon]
            .into_iter()
            .enumerate()
        {
            let mut request = Request::new(kernels, &device)?;
            request.effort = effort;
            request.objective = objective;
            let start = Instant::now();
            let filter = request.filter()?;
            seconds[i] += start.elapsed().as_secs_f64();
            let at = |amplitude| {
                let chips = (0..CHIPS).map(|seed| {
                    let all = filters::correlations(&filter, &request, amplitude, seed);
                    all.into_iter().fold(1.0, f64::min)
                });
                chips.sum::<f64>() / CHIPS as f64
            };
            let best = Signal::AMPLITUDES.map(at).into_iter().fold(0.0, f64::max);
            low[i] += usize::from(best < 0.95);
            line = format!("{line}| {} | {best:.3} ", filter.words.len());
            if objective == Objective::Silicon {
                let said = filter.best_forecast(&device, kernels);
                let said = said.iter().map(|f| f.correlation).fold(1.0, f64::min);
                line = format!("{line}| {said:.3} ");
            }
        }
        println!("{line}|");
    }
    println!(
        "\nbelow 0.95: {} of {} for words, {} for silicon; {:.1} and {:.1} s",
        low[0],
        filters.len(),
        low[1],
        seconds[0],
        seconds[1]
    );
    Ok(())
}
