//! Training, from outside: what is learned, that it can be stopped anywhere and goes on alike, and that
//! what comes out is what the main program takes.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use amacrine::{
    array::Arithmetic,
    event::{Packet, Polarity},
    gradient::{Clips as Light, Model},
    isa::Device,
    number::{F32, Format},
    plane::{Plane, Size},
    reference::{Description, MemoryRule, Reference},
    scene::Frame,
    sensor::Sensor,
    study::expanded::Expanded,
    unit::Micros,
};
use amacrine_learn::{
    network::{Adam, Network},
    record::{Decoder, Form, Record},
    scene::{Clips, Motion, Photographs},
    task::Task,
    train::{Batch, Loss, Progress, Run, State, TrainError, Trainee},
};

const SMALL: &str = "steps = 12\nbatch = 2\ncrop = 16\ntargets = [0.05]\nseeds = [1]\ncheckpoint = 2\n\
    [network]\nwidths = [4, 6]\nconvolutions = 1\n[test]\nclips = 6\ncrop = 24\n[scenes]\npan = 1\n";

fn text(goal: &str, arms: &str) -> String {
    format!("goal = \"{goal}\"\narms = [{arms}]\n{SMALL}")
}

fn task(text: &str) -> Task {
    Task::parse("small.toml", text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn clips(task: &Task) -> Clips {
    let (training, _) = Photographs::bundled().unwrap().split();
    let size = Size::new(task.crop, task.crop);
    Clips::new(&training, &task.scenes.motion, size, task.scenes.frames, 1).unwrap()
}

#[test]
fn one_batch_is_learned_by_heart() {
    for goal in ["interpolation", "flow"] {
        let mut task = task(&text(goal, "\"dvs\""));
        task.widths = vec![12, 16];
        let clips = clips(&task);
        let arm = &task.arms[0];
        let mut trainee = Trainee::new((&task, arm), (0.2, 1), &clips).unwrap();
        trainee.state.threshold /= 2.0;
        let batch = Batch::new(&clips, 0..2);
        let sensor = trainee.applied().unwrap().unwrap();
        let sensor = trainee.sensor(&sensor.kernels, trainee.state.threshold);
        let light = batch.light(0.0, amacrine::rng::Hash::new(0));
        let times = task.scenes.times();
        let model = Model::<f32>::new(sensor, batch.size(), 1).unwrap();
        let seen = model
            .forward(Light::new(&light, &times, batch.size()).unwrap())
            .unwrap();
        let network = Network::<f32>::new(task.plan(arm), batch.size(), 2);
        let mut weights = network.start(3, task.fan());
        let mut adam = Adam::new(weights.len());
        let mut losses = Vec::new();
        for _ in 0..400 {
            let packed = network.packed(&weights);
            let input = batch.input((&task, network.shape()), 0..2, Some(&seen));
            let (answers, kept) = network.forward(&weights, &packed, input);
            let answers = [answers];
            let loss = Loss::new(&task, network.shape(), &batch, &answers);
            losses.push(loss.mean);
            let mut gradient = vec![0.0; weights.len()];
            for asked in loss.asked {
                network.backward(&packed, &kept, asked, (&mut gradient, false));
            }
            adam.step(&mut weights, &gradient, 5e-3);
        }
        let (first, last) = (losses[0], losses[399]);
        assert!(last < 0.35 * first, "{goal}: from {first} to {last}");
    }
}

/// The gradient of each loss is its difference.
#[test]
fn losses_fall_where_their_gradient_says() {
    let goals = ["interpolation", "flow"];
    let all = goals.map(|goal| ["charbonnier", "l1"].map(|loss| (goal, loss)));
    let mut means = Vec::new();
    for (goal, loss) in all.into_iter().flatten() {
        let task = task(&format!("loss = {loss:?}\n{}", text(goal, "\"dvs\"")));
        let clips = clips(&task);
        let batch = Batch::new(&clips, 0..2);
        let network = Network::<f32>::new(task.plan(&task.arms[0]), batch.size(), 2);
        let shape = network.shape();
        let mut weights = network.start(3, task.fan());
        let biases = weights.len() - network.plan().outputs;
        weights[biases..].fill(0.05);
        let none = amacrine_learn::network::Maps::zeros(shape, network.plan().inputs);
        let mut answers = network.answers(&weights, vec![none]);
        let loss = Loss::new(&task, shape, &batch, &answers);
        let asked: f32 = (0..16)
            .flat_map(|y| loss.asked[0].row(shape, (1, 0), y))
            .sum();
        let step = 2e-3;
        for y in 0..16 {
            for value in answers[0].row_mut(shape, (1, 0), y) {
                *value += step;
            }
        }
        means.push(loss.mean);
        let moved = Loss::new(&task, shape, &batch, &answers).mean - loss.mean;
        let want = f64::from(asked * step);
        assert!(
            (moved - want).abs() < 0.1 * want.abs().max(1e-5),
            "{goal}: {moved} {want}"
        );
    }
    // An error that is rounded off at 0 is larger than itself, by the thousandth at most.
    for pair in means.chunks(2) {
        let more = pair[0] - pair[1];
        assert!(more > 0.0 && more <= 1e-3, "{means:?}");
    }
}

#[test]
fn what_is_seen_is_what_the_task_says() {
    let usual = task(&text("interpolation", "\"dvs\"")).scenes.motion;
    assert_eq!(
        usual,
        Motion {
            pan: [0.2, 1.0],
            ..Motion::default()
        }
    );
    let keys =
        "pan = 1\nturn = 0\nzoom = 0\nshear = 0\ngain = [1, 1]\ngamma = [1, 2]\noccluded = 0";
    let own = text("interpolation", "\"dvs\"").replace("pan = 1", keys);
    let own = task(&own);
    assert_eq!(
        own.scenes.motion,
        Motion {
            pan: [0.2, 1.0],
            turn: 0.0,
            zoom: 0.0,
            shear: 0.0,
            occluder: 0.0,
            gain: [1.0; 2],
            gamma: [1.0, 2.0],
        }
    );
    // All of a clip then moves alike.
    let flow = clips(&own).clip(0).flow.unwrap();
    assert!(flow.u.iter().all(|u| (u - flow.u[[0, 0]]).abs() < 1e-5));
}

fn trained(threads: usize, arm: &str) -> State {
    let task = task(&text("interpolation", &format!("{arm:?}")));
    let clips = clips(&task);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let mut trainee = Trainee::new((&task, &task.arms[0]), (0.05, 1), &clips).unwrap();
        // Beyond the half, where the chip comes into the loop.
        for _ in 0..8 {
            trainee.step(&clips).unwrap();
        }
        trainee.state
    })
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for arm in ["rgc", "int-5", "rgc-2x2", "mesh"] {
        let one = trained(1, arm);
        assert_ne!(
            one.kernel.1.first,
            vec![0.0; one.kernel.0.len()],
            "{arm} has not learned"
        );
        for threads in [2, 5] {
            assert!(one == trained(threads, arm), "{arm} on {threads} threads");
        }
    }
}

fn gone(text: &str, steps: u64) -> Vec<State> {
    let task = task(text);
    let clips = clips(&task);
    let mut trainee = Trainee::new((&task, &task.arms[0]), (0.05, 1), &clips).unwrap();
    let step = |_| {
        trainee.step(&clips).unwrap();
        trainee.state.clone()
    };
    (0..steps).map(step).collect()
}

/// From half of the steps on a kernel of few values is what it will be at the end, and the chip is in
/// the loop: its whole thresholds, its noise, its memory.
#[test]
fn levels_hold_still_while_the_network_learns() {
    for arm in ["ternary", "int-5", "rgc-rounded", "po2-2"] {
        let text = text("interpolation", &format!("{arm:?}"));
        let states = gone(&text, 12);
        let (free, held) = states.split_at(5);
        for two in free.windows(2) {
            assert_ne!(two[0].kernel.0, two[1].kernel.0, "{arm} does not learn");
        }
        assert!(free.iter().all(|state| state.chip[1] == 0.0));
        for state in held {
            assert_eq!(state.kernel.0, held[0].kernel.0, "{arm}, {}", state.step);
            assert!(state.chip[1] > 0.0 && state.words.is_some());
        }
        assert_ne!(held[0].network.0, held[5].network.0);
        let task = task(&text);
        let mut trainee = Trainee::blank((&task, &task.arms[0]), (0.05, 1));
        let memory = |trainee: &Trainee<'_>| {
            let applied = trainee.applied().unwrap().unwrap();
            trainee.sensor(&applied.kernels, 0.1).memory
        };
        assert_eq!(memory(&trainee), MemoryRule::FilteredStep);
        trainee.state = held[6].clone();
        assert_eq!(memory(&trainee), MemoryRule::FilteredSnap);
        // The held weights are the levels, not something that is rounded to them.
        let applied = trainee.applied().unwrap().unwrap();
        let levels = applied.kernels[0].weights();
        for (latent, level) in trainee.state.kernel.0.iter().zip(levels) {
            assert!((latent - level).abs() < 1e-12, "{arm}");
        }
    }
}

/// Where events have a price, thresholds are learned, and go on when kernels hold still.
#[test]
fn a_price_of_events_moves_thresholds_to_the_end() {
    let text = text("interpolation", "\"ternary\"");
    let states = gone(&format!("{text}[sparsity]\nweight = 1e-4\n"), 12);
    for two in states.windows(2) {
        assert_ne!(two[0].threshold, two[1].threshold, "{}", two[1].step);
    }
    assert_eq!(states[6].kernel, states[11].kernel);
    // That of a kernel which is given too: a high price makes it rise.
    let text = self::text("interpolation", "\"dvs\"");
    let states = gone(&format!("{text}[sparsity]\nweight = 1\n"), 12);
    for two in states.windows(2) {
        assert!(two[0].threshold < two[1].threshold, "{}", two[1].step);
    }
}

/// What was learned at a price is what is judged and exported, not thresholds for the target.
#[test]
fn what_is_priced_is_judged_as_it_was_learned() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("interpolation", "\"dvs\", \"rgc\"").replace("steps = 12", "steps = 60");
    let text = format!("{text}[rates]\nkernel = 0.05\n[sparsity]\nweight = 1\n");
    let record = run(folder.path(), &text, false);
    for arm in ["dvs", "rgc"] {
        let learned = record.kernels.iter().rfind(|at| at.arm == arm).unwrap();
        assert_eq!(learned.step, 60);
        let path = folder.path().join("arms").join(format!("{arm}-0.05-1"));
        let sensor = Description::open(path.join("sensor.toml")).unwrap();
        assert_eq!(sensor.channels[0].thresholds[0].on, learned.on[0], "{arm}");
        for form in [Form::Trained, Form::Silicon] {
            let own = |row: &&amacrine_learn::record::Row| row.arm == arm && row.form == form;
            let (events, cells) = { record.rows.iter().filter(own) }
                .fold((0, 0), |(e, c), row| (e + row.events, c + row.cells));
            assert!(
                cells > 0 && events as f64 / cells as f64 * 2.0 < 0.05,
                "{arm} {form:?}"
            );
        }
    }
}

/// Thresholds that follow the target come back to it, on clips that were never seen and without being
/// set on them.
#[test]
fn thresholds_follow_the_target_on_other_clips() {
    let task = task(&text("interpolation", "\"dvs\"").replace("steps = 12", "steps = 300"));
    let clips = clips(&task);
    let mut trainee = Trainee::new((&task, &task.arms[0]), (0.05, 1), &clips).unwrap();
    trainee.state.threshold *= 3.0;
    let rate = |trainee: &Trainee<'_>| {
        let batch = Batch::new(&clips, 100_000..100_128);
        let kernels = trainee.applied().unwrap().unwrap().kernels;
        let sensor = trainee.sensor(&kernels, trainee.state.threshold);
        let light = batch.light(task.sensor.light_noise, amacrine::rng::Hash::new(8));
        let times = task.scenes.times();
        let model = Model::<f32>::new(sensor, batch.size(), 1).unwrap();
        let lit = Light::new(&light, &times, batch.size()).unwrap();
        model.forward(lit).unwrap().rate()
    };
    let far = rate(&trainee);
    for _ in 0..300 {
        trainee.step(&clips).unwrap();
    }
    let near = rate(&trainee);
    assert!(far < 0.6 * near, "{far} and then {near}");
    assert!((0.5..2.0).contains(&(near / 0.05)), "{near}");
}

/// A kernel of few values learns as a free one does. Levels that swing, and a latent kernel that
/// wanders off while they do not follow, cost a third of it.
#[test]
fn few_values_cost_little() {
    let text = |arm: &str| {
        format!(
            "goal = \"interpolation\"\narms = [{arm:?}]\nsteps = 300\nbatch = 4\ncrop = 16\n\
            targets = [0.05]\nseeds = [1]\nchip = \"none\"\n[network]\nwidths = [8, 12]\n\
            convolutions = 1\n[rates]\nnetwork = 2e-3\nkernel = 5e-3\n[scenes]\npan = 1\n"
        )
    };
    let loss = |arm: &str| gone(&text(arm), 300)[299].means[0];
    let free = loss("rgc");
    for arm in ["ternary", "int-5", "rgc-rounded"] {
        let few = loss(arm);
        println!("{arm}: {few:.5}, rgc: {free:.5}");
        assert!(few < 1.05 * free, "{arm}: {few}, and free {free}");
    }
}

/// What is not in a checkpoint is not needed: each form of a kernel goes on from its state alone.
#[test]
fn a_step_is_a_function_of_the_state() {
    for arm in ["dog", "mesh", "rgc", "rgc-2x2", "int-5"] {
        let task = task(&text("interpolation", &format!("{arm:?}")));
        let clips = clips(&task);
        let of = ((&task, &task.arms[0]), (0.05, 1));
        let mut straight = Trainee::new(of.0, of.1, &clips).unwrap();
        for _ in 0..task.steps {
            let mut other = Trainee::blank(of.0, of.1);
            other.state = straight.state.clone();
            straight.step(&clips).unwrap();
            other.step(&clips).unwrap();
            assert!(straight.state == other.state, "{arm}, {}", other.state.step);
        }
    }
}

fn run(folder: &Path, text: &str, resume: bool) -> Record {
    let task = task(text);
    let run = Run::new(&task, folder, resume).unwrap();
    for job in run.jobs() {
        run.train(&job, &mut |_| {}).unwrap();
    }
    run.record().unwrap()
}

/// Everything in a folder, by its place.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let own = files(&path).into_iter();
            all.extend(own.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            all.push((name, fs::read(path).unwrap()));
        }
    }
    all.sort();
    all
}

#[test]
fn ten_stops_end_as_none() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("interpolation", "\"none\", \"ternary\"");
    let straight = folder.path().join("straight");
    run(&straight, &text, false);
    let stopped = folder.path().join("stopped");
    let task = task(&text);
    for stop in 1..=10 {
        let run = Run::new(&task, &stopped, true).unwrap();
        let mut steps = 0;
        let ended = catch_unwind(AssertUnwindSafe(|| {
            for job in run.jobs() {
                let mut seen = |_: &State| {
                    steps += 1;
                    // Somewhere between two checkpoints.
                    assert!(steps < 2 + stop % 3, "stopped");
                };
                run.train(&job, &mut seen).unwrap();
            }
        }));
        drop(ended);
    }
    // The rest side by side.
    let last = Run::new(&task, &stopped, true).unwrap();
    let ended = AtomicUsize::new(0);
    last.train_all(&last.jobs(), 2, &|_, progress| {
        if let Progress::Ended(done) = progress {
            done.unwrap();
            ended.fetch_add(1, Ordering::Relaxed);
        }
    });
    assert_eq!(ended.into_inner(), last.jobs().len());
    last.record().unwrap();
    let (a, b) = (files(&straight), files(&stopped));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&a), names(&b));
    for ((name, a), (_, b)) in a.iter().zip(&b) {
        assert!(a == b, "{name} differs");
    }
    // A folder with a run in it is not begun anew.
    let begun = Run::new(&task, &stopped, false);
    assert!(matches!(begun, Err(TrainError::Begun { .. })));
    // Arms, targets and seeds may be added: what is done stays.
    let more = text.replace("\"none\", ", "\"none\", \"dvs\", ");
    let more = self::task(&format!(
        "# more\n{}",
        more.replace("seeds = [1]", "seeds = [1, 2]")
    ));
    let run = Run::new(&more, &stopped, true).unwrap();
    assert_eq!(run.jobs().len(), 6);
    for job in run.jobs() {
        let mut steps = 0;
        run.train(&job, &mut |_| steps += 1).unwrap();
        assert_eq!(
            steps == 0,
            job.seed == 1 && job.arm.name != "dvs",
            "{job:?}"
        );
    }
    // Nor is it gone on with by another task.
    let other = self::task(&text.replace("steps = 12", "steps = 13"));
    let run = Run::new(&other, &stopped, true).unwrap();
    let refused = run.train(&run.jobs()[1], &mut |_| {}).unwrap_err();
    assert!(
        refused.to_string().contains("made with another task file"),
        "{refused}"
    );
    fs::remove_file(stopped.join("arms/ternary-0.05-1/finished.json")).unwrap();
    let refused = run.train(&run.jobs()[1], &mut |_| {}).unwrap_err();
    assert!(
        refused.to_string().contains("made with another task file"),
        "{refused}"
    );
    // What is damaged or of another version is not taken either.
    let run = Run::new(&task, &stopped, true).unwrap();
    let path = stopped.join("arms/ternary-0.05-1/checkpoint");
    let whole = fs::read(&path).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    for (bytes, says) in [
        (&damaged[..], "a damaged checkpoint"),
        (&whole[..whole.len() - 5], "a damaged checkpoint"),
        (
            &b"amacrine-learn checkpoint 9\n"[..],
            "a checkpoint of another version",
        ),
        (&b"PK"[..], "no checkpoint of amacrine-learn"),
    ] {
        fs::write(&path, bytes).unwrap();
        let refused = run.train(&run.jobs()[1], &mut |_| {}).unwrap_err();
        assert!(refused.to_string().contains(says), "{refused}");
    }
}

/// The events of some frames, by the frame at which each is known, its place and its sign.
fn seen(sensor: &mut dyn Sensor, frames: &[Frame]) -> Vec<(usize, u16, u16, bool)> {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    for frame in frames {
        sensor.watch(frame, &mut packet).unwrap();
    }
    let times: Vec<Micros> = { frames.iter() }
        .map(|frame| Micros::from_seconds(frame.seconds))
        .collect();
    let at = |event: &amacrine::event::Event| {
        let frame = times.iter().position(|t| *t >= event.t).unwrap();
        (frame, event.y, event.x, event.polarity == Polarity::On)
    };
    let mut events: Vec<_> = packet.events.iter().map(at).collect();
    events.sort_unstable();
    events
}

/// The sensor file of the chip's form and the program file are one sensor: in exact arithmetic they
/// make the same events, each of them.
#[test]
fn the_exported_program_is_the_exported_chip_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("interpolation", "\"ternary\", \"int-5\"");
    run(folder.path(), &text, false);
    let task = task(&text);
    let (_, held_out) = Photographs::bundled().unwrap().split();
    let size = Size::new(24, 24);
    let clips = Clips::new(&held_out, &Motion::default(), size, task.scenes.frames, 2).unwrap();
    let batch = Batch::new(&clips, 0..4);
    let light = batch.light(0.5, amacrine::rng::Hash::new(0));
    let times = task.scenes.times();
    for arm in ["ternary", "int-5"] {
        let place = folder.path().join("arms").join(format!("{arm}-0.05-1"));
        let sensor = Description::open(place.join("sensor-chip.toml")).unwrap();
        assert!(sensor.channels[0].thresholds[0].sigma == 0.0);
        let program = fs::read_to_string(place.join("program.scamp")).unwrap();
        let program = Expanded::from_text("program.scamp", &program, &Device::scamp5()).unwrap();
        let mut events = 0;
        for clip in light.chunks(times.len() * size.pixels()) {
            let frame = |(n, light): (usize, &[f32])| Frame {
                index: n as u64,
                seconds: times[n],
                light: Plane::from_shape_fn((24, 24), |(y, x)| f64::from(light[24 * y + x])).into(),
            };
            let frames: Vec<Frame> = { clip.chunks(size.pixels()).enumerate() }
                .map(frame)
                .collect();
            let exact = Arithmetic::Number(Format::F64);
            let chip = program.chip(exact, size, program.settings()).unwrap();
            let by_program = seen(&mut program.all_events(chip), &frames);
            let mut float = Reference::in_format(Format::F64, sensor.clone(), size, 0).unwrap();
            assert_eq!(by_program, seen(&mut float, &frames), "{arm}");
            events += by_program.len();
        }
        assert!(events > 100, "{arm}: {events}");
    }
}

#[test]
fn what_is_judged_is_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let text = text(
        "interpolation",
        "\"blend\", \"none\", \"ternary\", \"int-5\", \"rgc-k2\"",
    );
    let record = run(folder.path(), &text, false);
    let of = |arm: &str, form: Form| {
        let rows = record
            .rows
            .iter()
            .filter(|row| row.arm == arm && row.form == form);
        rows.collect::<Vec<_>>()
    };
    // The threshold of a form is set on the form: as near to the target as whole LSB allow.
    for (arm, form) in [
        ("ternary", Form::Quantised),
        ("ternary", Form::Silicon),
        ("int-5", Form::Silicon),
    ] {
        let rows = of(arm, form);
        let events: u64 = rows.iter().map(|row| row.events).sum();
        let cells: u64 = rows.iter().map(|row| row.cells).sum();
        let rate = events as f64 / cells as f64;
        let part = rate / 0.05;
        assert!((0.67..1.5).contains(&part), "{arm} {form:?}: {rate}");
    }
    for arm in ["ternary", "int-5", "rgc-k2"] {
        let rows = of(arm, Form::Trained);
        assert_eq!(rows.len(), 6);
        let sum = |of: fn(&amacrine_learn::record::Row) -> u64| {
            rows.iter().map(|r| of(r)).sum::<u64>() as f64
        };
        let rate = sum(|r| r.events) / sum(|r| r.cells);
        assert!((rate / 0.05 - 1.0).abs() < 0.03, "{arm}: {rate}");
        // Ten bits of address and one of sign; one more tells two kinds apart.
        let word = if arm == "rgc-k2" { 12.0 } else { 11.0 };
        assert_eq!(sum(|r| r.bits), word * sum(|r| r.events));
    }
    // The program in exact arithmetic is the float model of its sensor: what the network is told is
    // alike, so what it says is.
    for arm in ["ternary", "int-5"] {
        let (float, exact) = (of(arm, Form::Quantised), of(arm, Form::Exact));
        assert_eq!(float.len(), 6);
        assert!(float.iter().any(|row| row.events > 0));
        for (a, b) in float.iter().zip(&exact) {
            assert_eq!(
                (a.events, a.psnr, a.ssim),
                (b.events, b.psnr, b.ssim),
                "{arm}"
            );
        }
        let silicon = of(arm, Form::Silicon);
        assert!(
            silicon
                .iter()
                .zip(&exact)
                .any(|(a, b)| a.events != b.events)
        );
        let place = folder.path().join("arms").join(format!("{arm}-0.05-1"));
        let program = fs::read_to_string(place.join("program.scamp")).unwrap();
        assert!(program.contains("threshold"));
        let levels = fs::read(place.join("kernel-0.npy")).unwrap();
        let levels = amacrine::kernel::Kernel::from_npy(&levels).unwrap();
        assert!(levels.weights().iter().all(|w| w.fract() == 0.0));
    }
    // Events tell more than none, even after a few steps, and the network begins as the blend.
    let mean = |arm: &str| {
        let rows = of(arm, Form::Trained);
        rows.iter().filter_map(|row| row.psnr).sum::<f64>() / rows.len() as f64
    };
    assert!(
        (mean("none") - mean("blend")).abs() < 1.0,
        "{} {}",
        mean("none"),
        mean("blend")
    );
}

/// What a video shows is what a run is known by, not its name; its place is the task file's.
#[test]
fn another_video_of_the_same_name_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let film = |dark: u8| {
        let light = ndarray::Array3::from_shape_fn((20, 32, 32), |(t, y, x)| {
            ((3 * t + 7 * y + 5 * x) % 200) as u8 / dark
        });
        ndarray_npy::write_npy(folder.path().join("film.npy"), &light).unwrap();
    };
    let path = folder.path().join("task.toml");
    let text = text("interpolation", "\"none\"");
    let text = text.replace("pan = 1", "frames = 3\nvideo = \"film.npy\"");
    fs::write(&path, text).unwrap();
    let task = Task::open(&path).unwrap();
    let at = folder.path().join("run");
    let train = |resume| {
        let run = Run::new(&task, &at, resume).unwrap();
        run.train(&run.jobs()[0], &mut |_| {})
    };
    film(1);
    train(false).unwrap();
    train(true).unwrap();
    film(2);
    let refused = train(true).unwrap_err().to_string();
    assert!(refused.contains("other photographs"), "{refused}");
}

/// A run is known by what its task says, whatever the file is called; and is one process's at a time.
#[test]
fn a_run_goes_on_from_a_copy_of_its_task_and_is_locked() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("interpolation", "\"none\"");
    run(folder.path(), &text, false);
    let copy = text.replace("seeds = [1]", "seeds = [1, 2]");
    let copy = Task::parse("copy.toml", &copy).unwrap();
    let again = Run::new(&copy, folder.path(), true).unwrap();
    assert!(again.is_done(&again.jobs()[0]).unwrap());
    assert!(!again.is_done(&again.jobs()[1]).unwrap());
    let other = Run::new(&copy, folder.path(), true).unwrap();
    let lock = again.lock().unwrap();
    assert!(matches!(other.lock(), Err(TrainError::Busy { .. })));
    drop(lock);
    drop(other.lock().unwrap());
}

/// What times are told by beforehand: a kernel with a long program, and every search of a price.
#[test]
fn what_is_told_beforehand_is_of_the_longest() {
    let text = text("interpolation", "\"int-5\"");
    for (price, kernels) in [("", 0), ("[price]\nwords = 1e-6\n", 75)] {
        let task = task(&format!("{text}{price}"));
        let clips = clips(&task);
        let trainee = Trainee::new((&task, &task.arms[0]), (0.05, 1), &clips).unwrap();
        assert_eq!(trainee.try_search(&clips).unwrap(), kernels);
        let dense = trainee.dense().unwrap().applied().unwrap().unwrap();
        let weights = dense.kernels[0].weights().iter();
        assert!(weights.filter(|weight| **weight != 0.0).count() > 15);
    }
    let task = task(&text);
    let clips = clips(&task).kept(100, false);
    assert_eq!(clips.bytes_of(10), 10 * 9 * 16 * 16);
    assert_eq!(clips.bytes_of(1000), 100 * 9 * 16 * 16);
}

/// A network that is trained on with the chip's events does better on them than the one before.
#[test]
fn a_retrained_decoder_knows_the_chip() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("interpolation", "\"int-5\"")
        .replace("steps = 12", "steps = 60")
        .replace("checkpoint = 2", "checkpoint = 60")
        .replace("[0.05]", "[0.2]");
    let text = format!("{text}[retrain]\nsteps = 60\nclips = 16\n");
    let record = run(folder.path(), &text, false);
    let mean = |form: Form, decoder: Decoder| {
        let rows = { record.rows.iter() }.filter(|row| (row.form, row.decoder) == (form, decoder));
        let all: Vec<f64> = rows.filter_map(|row| row.psnr).collect();
        assert_eq!(all.len(), 6, "{form:?} {decoder:?}");
        all.iter().sum::<f64>() / 6.0
    };
    for form in [Form::Quantised, Form::Exact, Form::Silicon] {
        let (own, retrained) = (mean(form, Decoder::Own), mean(form, Decoder::Retrained));
        assert!(retrained > own, "{form:?}: {own} and then {retrained}");
    }
    // A tie may fall either way: the two are alike, not always the same.
    let [few, exact] = [Form::Quantised, Form::Exact].map(|form| mean(form, Decoder::Retrained));
    assert!((few - exact).abs() < 0.05, "{few} {exact}");
}

/// The kernel that stands for a mesh, as the forward pass has it.
fn as_trained(sensor: &Description) -> Description {
    let mut sensor = sensor.clone();
    for channel in &mut sensor.channels {
        let Some(mesh) = channel.surrounds.take() else {
            continue;
        };
        let mut point = Plane::zeros((41, 41));
        point[(20, 20)] = 1.0;
        let one = mesh.sheets[0];
        let mut sheet = amacrine::mesh::Steady::new(one.sheet, Size::new(41, 41)).unwrap();
        let mut kernel = sheet.solve(&point).unwrap() * one.gain + point * mesh.centre;
        kernel = kernel.slice(ndarray::s![15..26, 15..26]).to_owned();
        channel.kernels = vec![amacrine::kernel::Kernel::new(kernel).unwrap()];
    }
    sensor
}

/// The sensor file is read back to the bit, and makes the events of the forward pass.
#[test]
fn the_exported_sensor_is_the_trained_one() {
    let folder = tempfile::tempdir().unwrap();
    let arms = "\"rgc\", \"rgc-k2\", \"rgc-2x2\", \"fs-dvs\", \"dog\", \"mesh\"";
    let text = format!(
        "{}[sensor]\nmismatch = 0\nrefractory-us = 1000\n",
        text("interpolation", arms)
    );
    run(folder.path(), &text, false);
    let task = task(&text);
    let (_, held_out) = Photographs::bundled().unwrap().split();
    let size = Size::new(24, 24);
    let clips = Clips::new(&held_out, &Motion::default(), size, task.scenes.frames, 2).unwrap();
    let batch = Batch::new(&clips, 0..1);
    let light = batch.light(0.0, amacrine::rng::Hash::new(0));
    let times = task.scenes.times();
    for arm in &task.arms {
        let name = format!("{}-0.05-1", arm.name);
        let path = folder.path().join("arms").join(&name).join("sensor.toml");
        let sensor = Description::open(&path).unwrap();
        let again = Description::parse(
            "again.toml",
            &amacrine_learn::train::sensor_text(&sensor, "test"),
            &|_| Err(std::io::ErrorKind::NotFound.into()),
        );
        assert_eq!(sensor, again.unwrap());
        if arm.name == "mesh" {
            // Trained as the kernel that stands for it, built as resistors.
            let mesh = sensor.channels[0].surrounds.as_ref().unwrap();
            assert!(mesh.sheets[0].gain < 0.0 && mesh.centre > 0.0);
        }
        let model = Model::<f32>::new(as_trained(&sensor), size, 5).unwrap();
        let seen = model
            .forward(Light::new(&light, &times, size).unwrap())
            .unwrap();
        let mut reference = Reference::with_number(F32, sensor, size, 5).unwrap();
        let mut packet = Packet::new(size, reference.channels());
        for (n, light) in light.chunks(size.pixels()).enumerate() {
            let frame = Frame {
                index: n as u64,
                seconds: times[n],
                light: Plane::from_shape_fn((24, 24), |(y, x)| f64::from(light[24 * y + x])).into(),
            };
            reference.watch(&frame, &mut packet).unwrap();
        }
        assert!(seen.events() > 0, "{name}");
        let (built, trained) = (packet.events.len() as f64, seen.events() as f64);
        // What a kernel cuts off of a surround is little.
        let off = if arm.name == "mesh" { 0.02 } else { 0.0 };
        assert!(
            (built / trained - 1.0).abs() <= off,
            "{name}: {built}, {trained}"
        );
    }
}

#[test]
fn what_cannot_be_trained_says_why() {
    let wrong = |text: &str, says: &str| {
        let faults = Task::parse("wrong.toml", text).unwrap_err().to_string();
        assert!(faults.contains(says), "{faults}\nand not: {says}");
    };
    let whole = text("interpolation", "\"dvs\"");
    for (from, to, says) in [
        ("[0.05]", "[1.5]", "a target of 1.5 events a pixel and pair"),
        ("[0.05]", "[0]", "a target of 0 events"),
        ("\"dvs\"", "\"dvss\"", "dvs"),
        ("\"dvs\"", "\"dvs\", \"dvs\"", "takes part twice"),
        ("\"dvs\"", "\"po2-9\"", "cannot be \"po2-9\""),
        (
            "\"dvs\"",
            "\"ternary:zero:d4\"",
            "cannot begin with a point",
        ),
        ("[0.05]", "[0.05, 0.05]", "the target 0.05 takes part twice"),
        (
            "[0.05]",
            "[1e-5]",
            "less than one event in all held-out clips",
        ),
        (
            "seeds = [1]",
            "seeds = [1, 2, 1]",
            "the seed 1 takes part twice",
        ),
        ("crop = 16", "crop = 17", "not a multiple of 2"),
        ("steps = 12", "stepps = 12", "steps"),
        ("pan = 1", "frames = 8", "none in the middle"),
        (
            "pan = 1",
            "gain = [1.2, 0.7]",
            "`gain` is the least and the most",
        ),
        ("pan = 1", "gamma = [1]", "gamma"),
        ("steps = 12", "loss = \"l2\"\nsteps = 12", "charbonnier"),
        (
            "pan = 1",
            "video = \"a.mp4\"\nphotographs = \"b\"",
            "stands in place of photographs",
        ),
    ] {
        wrong(&whole.replace(from, to), says);
    }
    wrong(
        &format!("{whole}[sensor]\nrefractory-us = 5000\n"),
        "longer than a pair of frames",
    );
    wrong(&text("flow", "\"none\""), "flow is told from events alone");

    // Arms are named by their levels too.
    let arms = "\"po2-2\", \"int-4:zero\", \"ternary:mirror\"";
    let named = task(&text("interpolation", arms)).arms;
    assert_eq!(named.len(), 3);
    assert_eq!(
        amacrine_learn::train::name(&named[1], 0.05, 1),
        "int-4-zero-0.05-1"
    );

    // A rate that these scenes cannot make.
    let still = task(
        &whole
            .replace("pan = 1", "pan = 0.2")
            .replace("[0.05]", "[1]"),
    );
    let mut seen = still.clone();
    seen.sensor.refractory_us = 4000.0;
    let clips = clips(&seen);
    let mut trainee = Trainee::blank((&seen, &seen.arms[0]), (1.0, 1));
    // A threshold that the controller cannot bring down in time.
    trainee.state.threshold = 1e6;
    let stopped = (0..400).find_map(|_| trainee.step(&clips).err()).unwrap();
    assert!(stopped.to_string().contains("are the target"), "{stopped}");
    // What is not a number is told with its name and its step.
    let mut trainee = Trainee::new((&seen, &seen.arms[0]), (0.05, 1), &clips).unwrap();
    trainee.step(&clips).unwrap();
    trainee.state.network.0[3] = f32::NAN;
    let stopped = trainee.step(&clips).unwrap_err();
    assert!(
        matches!(stopped, TrainError::NotFinite { step: 1, .. })
            && (stopped.to_string())
                .contains("convolution 1 of the network's level 1, on the way down is NaN"),
        "{stopped}"
    );
}
