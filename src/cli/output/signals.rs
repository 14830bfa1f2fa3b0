//! Signals that end the program: what has no name yet goes first.

use std::sync::{Arc, atomic::AtomicBool};

use crate::save;

/// From now on the usual signals remove temporaries before they end the program, as by
/// themselves: a shell sees 128 + n. What was ignored when the program began stays ignored; a
/// second signal does not wait.
#[cfg(unix)]
pub(in crate::cli) fn watch() {
    use signal_hook::{consts, flag, iterator::Signals, low_level};

    let ignored = ignored();
    let heard = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    let ends = [
        consts::SIGHUP,
        consts::SIGINT,
        consts::SIGQUIT,
        consts::SIGTERM,
        consts::SIGXCPU,
    ];
    let ends: Vec<i32> = ends.into_iter().filter(heard).collect();
    // A file that grows too large is an error of the write, which has a message.
    if heard(&consts::SIGXFSZ) {
        let _ = flag::register(consts::SIGXFSZ, Arc::default());
    }
    let Ok(mut signals) = Signals::new(&ends) else {
        return;
    };
    let second: Arc<AtomicBool> = Arc::default();
    for signal in ends {
        let _ = flag::register_conditional_default(signal, Arc::clone(&second));
        let _ = flag::register(signal, Arc::clone(&second));
    }
    let wait = move || {
        for signal in &mut signals {
            save::remove_all();
            let _ = low_level::emulate_default_handler(signal);
        }
    };
    // Without the thread signals would only be taken note of: the second one ends the program.
    let _ = std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(wait);
}

#[cfg(not(unix))]
pub(in crate::cli) fn watch() {
    let _: (Arc<AtomicBool>, fn()) = (Arc::default(), save::remove_all);
}

/// The signals that whoever began this program had ignored (`nohup`, `trap ''`), as bits from
/// signal 1 on. Where the system does not say, SIGHUP is taken to be.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(1 << (signal_hook::consts::SIGHUP - 1))
}
