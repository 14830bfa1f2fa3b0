//! What a run says of its arms, its task and its memory: why the chip has no program, what few values take,
//! rates that are not the target, a task that has changed, what is more than may be held.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use amacrine::{
    gradient::{Clips as Light, Model},
    program::Program,
    reference::Description,
};
use amacrine_learn::{
    record::{Form, Record},
    report::Report,
    scene::{FEWEST, Photographs},
    task::Task,
    train::{Batch, Run, no_program},
};

const PROGRAM: &str = env!("CARGO_BIN_EXE_amacrine-learn");

fn text(arms: &str) -> String {
    format!(
        "goal = \"interpolation\"\narms = [{arms}]\nsteps = 8\nbatch = 2\ncrop = 16\n\
        targets = [0.05]\nseeds = [1]\ncheckpoint = 4\n[network]\nwidths = [4, 6]\n\
        convolutions = 1\n[test]\nclips = 4\ncrop = 24\n[scenes]\npan = 1\n"
    )
}

fn task(text: &str) -> Task {
    Task::parse("small.toml", text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn run(folder: &Path, text: &str) -> Record {
    let task = task(text);
    let run = Run::new(&task, folder, false).unwrap();
    for job in run.jobs() {
        run.train(&job, &mut |_| {}).unwrap();
    }
    run.record().unwrap()
}

fn remarks(record: &Record, arm: &str) -> Vec<String> {
    let own = record.remarks.iter().filter(|remark| remark.arm == arm);
    own.map(|remark| remark.what.clone()).collect()
}

#[test]
fn why_there_is_no_program_is_known_beforehand() {
    let log = "[sensor]\nresponse = { log = { white = 255, offset = 0.002 } }\n";
    let lin_log = "[sensor]\nresponse = { lin-log = { knee = 20 } }\n";
    for (arm, sensor, says) in [
        ("rgc-k2", "", "2 kinds of cells"),
        ("rgc-2x2", "", "2x2 pattern"),
        ("mesh", "", "resistors"),
        ("fs-dvs", "", "its response is logarithmic"),
        ("dvs", log, "a response of `log`"),
        ("dvs", lin_log, "a response of `lin-log`"),
        ("ternary", log, "trained without the chip in the loop"),
        (
            "dvs",
            "[sensor]\nrefractory-us = 1000\n",
            "a refractory period",
        ),
    ] {
        let task = task(&format!("{}{sensor}", text(&format!("{arm:?}"))));
        let why = no_program(&task, &task.arms[0]).unwrap();
        assert!(
            why.starts_with("no program: ") && why.contains(says),
            "{why}"
        );
    }
    let linear = "[sensor]\nresponse = { linear = 1023 }\n";
    for (arm, sensor) in [("none", ""), ("ternary", ""), ("dvs", linear)] {
        let task = task(&format!("{}{sensor}", text(&format!("{arm:?}"))));
        assert_eq!(no_program(&task, &task.arms[0]), None, "{arm}");
    }
}

/// The chip sees light as it is: of a sensor that does not there is neither a row nor a file of the chip,
/// nor is it trained with one; and the report says so.
#[test]
fn a_logarithmic_task_has_nothing_of_the_chip() {
    let folder = tempfile::tempdir().unwrap();
    let sensor = "[sensor]\nresponse = { log = { white = 255, offset = 0.002 } }\n";
    let record = run(
        folder.path(),
        &format!("{}{sensor}", text("\"dvs\", \"ternary\"")),
    );
    assert!(record.rows.iter().all(|row| row.form == Form::Trained));
    assert!(record.kernels.iter().all(|at| at.words.is_none()));
    for arm in ["dvs", "ternary"] {
        let place = folder.path().join("arms").join(format!("{arm}-0.05-1"));
        let built = Description::open(place.join("sensor.toml")).unwrap();
        assert_eq!(built.memory, amacrine::reference::MemoryRule::FilteredStep);
        assert!(!place.join("program.scamp").exists());
        assert!(!place.join("sensor-chip.toml").exists());
        assert!(remarks(&record, arm)[0].starts_with("no program: "));
    }
    let report = Report::new(record);
    for told in [report.table(), report.page()] {
        assert!(told.contains("dvs: no program: the task"), "{told}");
    }
}

/// A program of a light whose white is another is that of the same sensor in the light's own unit.
#[test]
fn another_white_makes_the_same_program() {
    let program = |sensor: &str| {
        let folder = tempfile::tempdir().unwrap();
        let record = run(folder.path(), &format!("{}{sensor}", text("\"ternary\"")));
        let place = folder.path().join("arms/ternary-0.05-1/program.scamp");
        let silicon = record.rows.iter().filter(|row| row.form == Form::Silicon);
        let events: Vec<u64> = silicon.map(|row| row.events).collect();
        (fs::read_to_string(place).unwrap(), events)
    };
    let usual = program("");
    assert_eq!(usual.1.len(), 4);
    let own = "[sensor]\nresponse = { linear = 510 }\n";
    assert_eq!(program(own), usual);
}

/// What few values take from a kernel is told where the library tells it, and the program says it too.
#[test]
fn a_surround_that_is_lost_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let record = run(folder.path(), &text("\"csdvs\", \"ternary\""));
    let lost = "rounded to ternary for the program: the surround is lost";
    let told = remarks(&record, "csdvs");
    assert!(told.iter().any(|told| told.starts_with(lost)), "{told:?}");
    assert!(
        !remarks(&record, "ternary")
            .iter()
            .any(|told| told.contains("lost"))
    );
    let place = folder.path().join("arms/csdvs-0.05-1");
    let program = fs::read_to_string(place.join("program.scamp")).unwrap();
    assert!(program.contains(&format!("//! # {lost}")), "{program}");
    assert!(
        program.starts_with("//! title = \"csdvs-0.05-1\""),
        "{program}"
    );
    Program::parse("program.scamp", &program).unwrap();
    let chip = fs::read_to_string(place.join("sensor-chip.toml")).unwrap();
    assert!(chip.contains(&format!("# {lost}")), "{chip}");
    for sign in ["-0.0,", "-0.0]"] {
        assert!(!program.contains(sign) && !chip.contains(sign), "{chip}");
    }
    Description::open(place.join("sensor-chip.toml")).unwrap();
    // What a sensor file cannot say is said in it.
    let sensor = fs::read_to_string(place.join("sensor.toml")).unwrap();
    assert!(sensor.contains("noise of 0.5"), "{sensor}");
    let report = Report::new(record);
    for told in [report.table(), report.page()] {
        assert!(told.contains(&format!("csdvs: {lost}")), "{told}");
    }
}

/// A memory that snaps makes one event a pair at most. Whatever is asked for, no threshold is below
/// what the chip can hold, and what it makes is told.
#[test]
fn no_arm_of_the_chip_is_judged_below_one_lsb() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("\"ternary\"").replace("[0.05]", "[1]");
    let record = run(folder.path(), &text);
    let place = folder.path().join("arms/ternary-1-1");
    let on = |file: &str| {
        let sensor = Description::open(place.join(file)).unwrap();
        sensor.channels[0].thresholds[0].on
    };
    let program = fs::read_to_string(place.join("program.scamp")).unwrap();
    let lsb = program.split("const threshold = ").nth(1).unwrap();
    let lsb: f64 = lsb.split(';').next().unwrap().parse().unwrap();
    let one = on("sensor-chip.toml") / lsb;
    let learned = on("sensor.toml") * 255.0;
    assert!(learned > 0.99 * one, "{learned} where one LSB is {one}");
    let last = record.kernels.last().unwrap();
    assert!(last.on[0] * 255.0 > 0.99 * one, "{last:?}");
    let told = remarks(&record, "ternary");
    assert!(
        told.iter().any(|told| told
            .starts_with("asked for 1 events a pixel and pair, it makes 0.")
            && told.contains("whole LSB")),
        "{told:?}"
    );
}

/// Light of 8 bits moves many cells by the same step. A threshold on it would be met in one precision and
/// missed in another.
#[test]
fn thresholds_lie_between_the_steps_of_the_light() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("\"dvs\", \"csdvs\", \"int-5\"").replace("[0.05]", "[0.05, 0.3]");
    let text = format!("{text}[sensor]\nmismatch = 0\nlight-noise = 0\n");
    let text = text.replace("pan = 1", "gain = [1, 1]\ngamma = [1, 1]");
    let record = run(folder.path(), &text);
    let task = task(&text);
    let run = Run::new(&task, folder.path(), true).unwrap();
    let batch = Batch::new(run.held_out(), 0..4);
    let light = batch.light(0.0, amacrine::rng::Hash::new(0));
    let light: Vec<f64> = light.into_iter().map(f64::from).collect();
    let times = task.scenes.times();
    for job in run.jobs() {
        let name = amacrine_learn::train::name(job.arm, job.target, job.seed);
        let path = folder.path().join("arms").join(&name).join("sensor.toml");
        let sensor = Description::open(&path).unwrap();
        let model = Model::<f64>::new(sensor, batch.size(), 0).unwrap();
        let lit = Light::new(&light, &times, batch.size()).unwrap();
        let events = model.forward(lit).unwrap().events();
        let own = |row: &&amacrine_learn::record::Row| {
            (row.form, &row.arm, row.target) == (Form::Trained, &job.arm.name, job.target)
        };
        let told: u64 = record.rows.iter().filter(own).map(|row| row.events).sum();
        assert_eq!(events, told, "{name}");
    }
}

fn learn(at: &Path, arguments: &str) -> Output {
    let mut command = Command::new(PROGRAM);
    command.current_dir(at).args(arguments.split_whitespace());
    command.output().unwrap()
}

/// What went wrong, however its lines are broken.
fn flat(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    text.replace(|c: char| c.is_whitespace() || "│×╰─▶".contains(c), "")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn with_task(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    fs::write(&path, text).unwrap();
    (folder, path)
}

/// The folder has the task; another one is refused by the key that differs, one that only saves at other
/// times is not.
#[test]
fn a_run_keeps_its_task() {
    let text = text("\"dvs\"");
    let (folder, path) = with_task(&text);
    let at = folder.path();
    // It is the only one in its folder.
    let output = learn(at, "mine.toml -o .");
    assert_eq!(output.status.code(), Some(2), "{}", flat(&output));
    assert!(
        flat(&output).contains("thereis`mine.toml`"),
        "{}",
        flat(&output)
    );
    let output = learn(at, "mine.toml -o r");
    assert!(output.status.success(), "{}", flat(&output));
    let kept = at.join("r/task.toml");
    let copy = Task::open(&kept).unwrap();
    assert_eq!(copy.changed(&Task::open(&path).unwrap()), None);
    let copy = fs::read_to_string(&kept).unwrap();
    assert!(
        copy.starts_with(&text) && copy.contains("as in mine.toml"),
        "{copy}"
    );
    for (from, to, says) in [
        ("steps = 8", "steps = 9", "`steps`was8andis9"),
        (
            "pan = 1",
            "pan = 1\nclips = 7",
            "`scenes.clips`was8192andis7",
        ),
    ] {
        fs::write(&path, text.replace(from, to)).unwrap();
        let output = learn(at, "mine.toml -o r --resume");
        assert!(!output.status.success());
        assert!(flat(&output).contains(says), "{}", flat(&output));
        assert_eq!(fs::read_to_string(&kept).unwrap(), copy);
    }
    fs::remove_file(at.join("r/arms/dvs-0.05-1/finished.json")).unwrap();
    fs::write(&path, text.replace("checkpoint = 4", "checkpoint = 3")).unwrap();
    let output = learn(at, "mine.toml -o r --resume");
    assert!(output.status.success(), "{}", flat(&output));
    // What is broken says what to remove.
    fs::write(at.join("r/arms/dvs-0.05-1/finished.json"), "{").unwrap();
    let output = learn(at, "mine.toml -o r --resume");
    assert!(
        flat(&output).contains("remover/arms/dvs-0.05-1:"),
        "{}",
        flat(&output)
    );
}

/// More than may be held is refused before any of it is there, with what would make it less; what a dry
/// run tells of arms is a part of what it tells of all.
#[test]
fn what_does_not_fit_is_refused_before_it_is_there() {
    let big = text("\"dvs\"")
        .replace("batch = 2", "batch = 1024")
        .replace("crop = 16", "crop = 256")
        .replace("[4, 6]", "[64, 64]");
    let (folder, path) = with_task(&big);
    let at = folder.path();
    for arguments in [
        "mine.toml -o r --dry-run --max-memory 2G",
        "--max-memory=2G mine.toml -o r",
    ] {
        let output = learn(at, arguments);
        assert_eq!(output.status.code(), Some(2), "{}", flat(&output));
        let told = flat(&output);
        assert!(
            told.contains("mine.toml:trainingwouldhold")
                && told.contains("--max-memoryallows2.0GiB"),
            "{told}"
        );
        assert!(told.contains("`batch`,`crop`"), "{told}");
        assert!(!at.join("r").exists());
    }
    fs::write(&path, text("\"blend\", \"dvs\"")).unwrap();
    let output = learn(at, "mine.toml -o r --dry-run --max-memory 2G --threads 1");
    let told = said(&output);
    let megabytes = |line: &str| -> f64 {
        let number = line
            .split(" MB")
            .next()
            .unwrap()
            .rsplit(' ')
            .next()
            .unwrap();
        number.parse().unwrap()
    };
    let line = |what: &str| told.lines().find(|line| line.contains(what)).unwrap();
    assert!(line("  blend ").contains(" 0 weights, "), "{told}");
    let [blend, dvs, all] =
        ["  blend ", "  dvs ", "in all, 1 at a time"].map(|of| megabytes(line(of)));
    assert!(blend < dvs && dvs <= all, "{told}");
}

/// Options of every verb stand before it too, as `amacrine learn` hands them over.
#[test]
fn options_of_every_verb_may_stand_first() {
    let (folder, _) = with_task(&text("\"none\""));
    let at = folder.path();
    let first = learn(at, "--threads=1 --max-memory=1000000000 mine.toml -o r");
    assert!(first.status.success(), "{}", flat(&first));
    let report = learn(at, "--threads=1 --max-memory=1000000000 report r");
    assert!(report.status.success(), "{}", flat(&report));
}

/// A dead time that costs most events is told once, with what it costs and one that does not; where it
/// costs few, and where nothing learns by a gradient, nothing is.
#[test]
fn a_dead_time_that_costs_most_events_is_told() {
    let told = |arms: &str, targets: &str, us: u64| {
        let text = text(arms).replace("[0.05]", targets);
        let (folder, _) = with_task(&format!("{text}[sensor]\nrefractory-us = {us}\n"));
        let output = learn(folder.path(), "mine.toml -o r --dry-run");
        assert!(output.status.success(), "{}", flat(&output));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let warning = told("\"dvs\", \"rgc\", \"fs-dvs\"", "[0.01, 0.5, 0.9]", 4000);
    assert_eq!(warning.matches("Warning: ").count(), 1, "{warning}");
    let costs = "the dead time of 4000 us costs most events of rgc on the task's first clips, ";
    assert!(
        warning.starts_with(&format!("Warning: {costs}")),
        "{warning}"
    );
    let number = |after: &str, before: &str| -> f64 {
        let rest = warning.split(after).nth(1).unwrap();
        rest.split(before).next().unwrap().parse().unwrap()
    };
    let most = number(" at 0.5 events a pixel and pair, ", " % at 0.9 events");
    assert!((50.0..100.0).contains(&most), "{warning}");
    assert!(!warning.contains("at 0.01 events"), "{warning}");
    let shorter = number("refractory-us = ", ", which costs ");
    assert!((50.0..=2000.0).contains(&shorter), "{warning}");
    let less = number(", which costs ", " %\n");
    assert!((1.0..=50.0).contains(&less), "{warning}");
    // Taken, it is not told of.
    assert_eq!(told("\"rgc\"", "[0.9]", shorter as u64), "");
    assert_eq!(told("\"rgc\"", "[0.01]", 4000), "");
    assert_eq!(told("\"dvs\"", "[0.9]", 4000), "");
}

/// The same picture on both sides is told, whatever the two are called.
#[test]
fn a_photograph_on_both_sides_is_told() {
    let (folder, _) = with_task(&text("\"none\""));
    let at = folder.path();
    fs::create_dir(at.join("same")).unwrap();
    for n in 0..FEWEST as u8 {
        let own = image::GrayImage::from_fn(64, 64, |x, y| image::Luma([(x * y) as u8]));
        own.save(at.join(format!("same/{n}.png"))).unwrap();
    }
    let photographs = Photographs::folder(&at.join("same")).unwrap();
    let (training, held_out) = photographs.split();
    let (own, _) = held_out.shared(&training).unwrap();
    let output = learn(at, "mine.toml -o r --photos same --dry-run");
    let told = flat(&output);
    assert!(output.status.success(), "{told}");
    assert!(
        told.contains(&format!("Warning:thephotographs{own},whichisheldout")),
        "{told}"
    );
    let (training, held_out) = Photographs::bundled().unwrap().split();
    assert_eq!(held_out.shared(&training), None);
}
