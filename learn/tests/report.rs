//! The report of a run that was made up: what is known of it is what it says.

use amacrine::{
    elementary::log2,
    rng::{self, Hash},
};
use amacrine_learn::{
    record::{Decoder, Form, KernelAt, Record, Remark, Row, VERSION},
    report::{FILE, Metric, Report},
};

const TARGETS: [f64; 3] = [0.02, 0.05, 0.1];

/// A quality of 20 dB and 3 for each doubling of the bits, `more` for the arm, and noise of the
/// photograph, the seed and the clip.
fn row(arm: &str, target: f64, seed: u64, clip: u64, more: f64) -> Row {
    let noise = |reason: u64, of: u64, size: f64| {
        let hash = Hash::new(3).with(reason).with(of);
        size * rng::normal(hash.uniform(), hash.nth(1).uniform())
    };
    let photograph = clip % 6;
    let cells = 18_432;
    let events = (target * cells as f64) as u64;
    let name = arm
        .bytes()
        .fold(Hash::new(9), |hash, byte| hash.with(byte.into()));
    let own = name.with(seed).bits();
    let quality = 20.0
        + 3.0 * log2(target / 0.02)
        + more
        + noise(1, photograph, 2.0)
        + noise(2, own, 0.05)
        + noise(4, own ^ clip ^ (target * 1e6) as u64, 0.2);
    Row {
        arm: arm.to_owned(),
        target,
        seed,
        form: Form::Trained,
        decoder: Decoder::Own,
        photograph: format!("{photograph}.jpg"),
        clip,
        events,
        bits: 17 * events,
        cells,
        psnr: Some(quality),
        ssim: Some(quality / 40.0),
        epe: None,
        off_by_1: None,
        off_by_3: None,
    }
}

fn rows(arm: &str, more: f64) -> Vec<Row> {
    let mut rows = Vec::new();
    for target in TARGETS {
        for (seed, clip) in (0..3).flat_map(|seed| (0..24).map(move |clip| (seed, clip))) {
            rows.push(row(arm, target, seed, clip, more));
        }
    }
    rows
}

fn kernel(seed: u64, step: u64, ring: f64) -> KernelAt {
    let own = ring + 0.002 * seed as f64;
    let around = |y, x| if (y, x) == (1, 1) { 1.0 } else { own };
    KernelAt {
        arm: "fs-dvs".to_owned(),
        target: 0.05,
        seed,
        step,
        loss: 0.1,
        rate: 0.05,
        words: None,
        kernels: vec![
            (0..3)
                .map(|y| (0..3).map(|x| around(y, x)).collect())
                .collect(),
        ],
        on: vec![9.0],
        off: vec![9.0],
    }
}

/// `rgc` wins 1 dB, `same` nothing; on silicon 0.6 dB are left of what `rgc` wins.
fn record() -> Record {
    let mut all = rows("dvs", 0.0);
    all.extend(rows("rgc", 1.0));
    all.extend(rows("same", 0.0));
    let silicon = rows("rgc", 0.6).into_iter().map(|row| Row {
        form: Form::Silicon,
        ..row
    });
    all.extend(silicon);
    let none = rows("none", -4.0)
        .into_iter()
        .filter(|row| row.target == TARGETS[0]);
    all.extend(none.map(|row| Row {
        events: 0,
        bits: 0,
        target: 0.0,
        ..row
    }));
    let steps = |ring: &'static [f64]| {
        (0..3).flat_map(move |seed| (0..).zip(ring).map(move |(n, r)| kernel(seed, 100 * n, *r)))
    };
    Record {
        version: VERSION,
        task: "made up".to_owned(),
        goal: "interpolation".to_owned(),
        steps: 200,
        batch: 8,
        crop: 32,
        parameters: 1234,
        rows: all,
        kernels: steps(&[0.0, -0.02, -0.05]).collect(),
        remarks: Vec::new(),
    }
}

#[test]
fn seeds_that_have_not_run_to_the_end_are_left_out() {
    let whole = Report::new(record());
    let mut more = record();
    // Another seed, with which one arm has run, and much better.
    let begun = more.rows.iter().filter(|row| row.arm == "dvs");
    let begun = begun.map(|row| Row {
        seed: 99,
        psnr: row.psnr.map(|psnr| psnr + 5.0),
        ..row.clone()
    });
    let begun: Vec<Row> = begun.collect();
    more.rows.extend(begun.clone());
    let report = Report::new(more);
    assert_eq!(report.record(), whole.record());
    let table = report.table();
    let first = table.lines().next().unwrap();
    assert!(
        first.ends_with("; seed 99 is left out: not all arms have run with it"),
        "{first}"
    );
    assert!(!whole.table().contains("left out"));
    // Where no seed has all, each counts as far as it went.
    let rows = begun
        .into_iter()
        .chain(record().rows.into_iter().filter(|row| row.arm != "dvs"));
    let none = Report::new(Record {
        rows: rows.collect(),
        ..record()
    });
    assert!(!none.table().contains("left out"));
}

#[test]
fn differences_are_those_at_equal_bits() {
    let report = Report::new(record());
    assert_eq!(report.arms(), ["dvs", "rgc", "same", "none"]);
    assert_eq!(report.metrics(), [Metric::Psnr, Metric::Ssim]);
    let won = report.difference("rgc", "dvs", Metric::Psnr).unwrap();
    assert!(
        (won.mean - 1.0).abs() < 0.15 && won.shown(Metric::Psnr),
        "{won:?}"
    );
    assert!(won.interval[0] < won.mean && won.mean < won.interval[1]);
    assert_eq!((won.photographs, won.seeds), (6, 3));
    // Photographs differ by 2 dB, but alike for both arms.
    assert!(won.interval[1] - won.interval[0] < 0.6, "{won:?}");
    let none = report.difference("same", "dvs", Metric::Psnr).unwrap();
    assert!(!none.shown(Metric::Psnr), "{none:?}");
    assert_eq!(report.difference("none", "dvs", Metric::Psnr), None);
    // The other way round it is the other sign.
    let lost = report.difference("dvs", "rgc", Metric::Psnr).unwrap();
    assert!((lost.mean + won.mean).abs() < 1e-12);
    // An arm that spends twice the bits for the same quality loses what a doubling brings.
    let mut record = record();
    for row in record.rows.iter_mut().filter(|row| row.arm == "same") {
        row.bits *= 2;
    }
    let dear = Report::new(record)
        .difference("same", "dvs", Metric::Psnr)
        .unwrap();
    assert!(
        (dear.mean + 3.0).abs() < 0.2 && dear.shown(Metric::Psnr),
        "{dear:?}"
    );
}

#[test]
fn one_target_each_is_compared_where_bits_are_alike() {
    let mut record = record();
    record.rows.retain(|row| row.target == TARGETS[1]);
    let report = |record: &Record| Report::new(record.clone());
    let won = report(&record)
        .difference("rgc", "dvs", Metric::Psnr)
        .unwrap();
    assert!((won.mean - 1.0).abs() < 0.15, "{won:?}");
    for row in record.rows.iter_mut().filter(|row| row.arm == "rgc") {
        row.bits += row.bits / 2;
    }
    assert_eq!(report(&record).difference("rgc", "dvs", Metric::Psnr), None);
}

#[test]
fn the_chip_keeps_a_part() {
    let report = Report::new(record());
    let [kept] = &report.kept()[..] else { panic!() };
    assert_eq!((kept.arm.as_str(), kept.stages.len()), ("rgc", 2));
    let verdict = kept.verdict(Metric::Psnr).unwrap();
    assert!(
        verdict.contains("of the +0.9") && verdict.ends_with("frozen: at least half"),
        "{verdict}"
    );
    // With a decoder that was trained on it keeps more.
    let mut both = record();
    let again: Vec<Row> = { both.rows.iter() }
        .filter(|row| row.form == Form::Silicon)
        .map(|row| Row {
            decoder: Decoder::Retrained,
            psnr: row.psnr.map(|psnr| psnr + 0.3),
            ..row.clone()
        })
        .collect();
    both.rows.extend(again);
    let kept = Report::new(both).kept().remove(0);
    let [(_, frozen), (Decoder::Retrained, retrained)] = &kept.won[..] else {
        panic!("{:?}", kept.won)
    };
    assert!((retrained.mean - frozen.mean - 0.3).abs() < 1e-9);
    let verdict = kept.verdict(Metric::Psnr).unwrap();
    assert!(
        verdict.contains("with the decoder retrained: at least half"),
        "{verdict}"
    );
    let report = Report::new(record());
    let kept = report.kept().remove(0);
    let change = kept.stages[1].change.as_ref().unwrap();
    assert!((change.mean + 0.4).abs() < 0.1, "{change:?}");
    let mut weak = record();
    for row in weak.rows.iter_mut().filter(|row| row.form == Form::Silicon) {
        row.psnr = row.psnr.map(|psnr| psnr - 0.5);
    }
    let verdict = Report::new(weak).kept()[0].verdict(Metric::Psnr).unwrap();
    assert!(verdict.contains("dB less than half"), "{verdict}");
    let mut level = record();
    for row in level.rows.iter_mut().filter(|row| row.arm == "rgc") {
        row.psnr = row.psnr.map(|psnr| psnr - 1.0);
    }
    let verdict = Report::new(level).kept()[0].verdict(Metric::Psnr).unwrap();
    assert!(verdict.contains("is not shown"), "{verdict}");
}

/// What has not taken part is named, and what silicon makes is told all the same.
#[test]
fn who_did_not_take_part_is_named() {
    let verdict = |without: &str| {
        let mut record = record();
        let silicon: Vec<Row> = { record.rows.iter() }
            .filter(|row| row.arm == "same")
            .map(|row| Row {
                form: Form::Silicon,
                ..row.clone()
            })
            .collect();
        record.rows.extend(silicon);
        record.rows.retain(|row| row.arm != without);
        let kept = Report::new(record).kept();
        let same = kept.iter().find(|kept| kept.arm == "same").unwrap();
        same.verdict(Metric::Psnr).unwrap()
    };
    let told = verdict("rgc");
    assert!(
        told.starts_with("same: `rgc` did not take part") && told.ends_with("on silicon, in PSNR dB against `dvs`, -0.02 (-0.07 to +0.06) with the decoder frozen"),
        "{told}"
    );
    let told = verdict("dvs");
    assert_eq!(
        told,
        "same: `dvs` did not take part, so there is nothing to compare it with"
    );
    let told = verdict("nobody");
    assert!(
        told.contains("that the float kernel `rgc` wins over `dvs`"),
        "{told}"
    );
}

/// Of a flow, what is counted over the clip is called so; and a remark of all targets is said once.
#[test]
fn what_is_over_the_clip_is_called_so() {
    let mut flow = record();
    for row in &mut flow.rows {
        row.epe = row.psnr.take();
        row.ssim = None;
        (row.off_by_1, row.off_by_3) = (Some(0.5), Some(0.25));
    }
    let remark = |target: f64, seed: u64, arm: &str, what: &str| Remark {
        of: format!("{arm}-{target}-{seed}"),
        arm: arm.to_owned(),
        seed,
        what: what.to_owned(),
    };
    for (target, seed) in TARGETS.iter().flat_map(|t| (0..3).map(move |s| (*t, s))) {
        flow.remarks
            .push(remark(target, seed, "same", "no program: it is made up"));
    }
    flow.remarks
        .push(remark(0.02, 1, "rgc", "its surround is lost"));
    let report = Report::new(flow);
    let (table, page) = (report.table(), report.page());
    for label in ["1PE % over the clip", "3PE % over the clip", "EPE px/frame"] {
        assert!(table.contains(label) && page.contains(label), "{table}");
    }
    // A column is as wide as its label.
    let lines: Vec<&str> = table.lines().filter(|line| line.contains("25.0")).collect();
    let head = table.lines().find(|line| line.starts_with("arm")).unwrap();
    let end = head.find("3PE % over the clip").unwrap() + "3PE % over the clip".len();
    assert!(lines.iter().all(|line| line.len() == end), "{table}");
    assert_eq!(
        report.remarks(),
        [
            "same: no program: it is made up",
            "rgc-0.02-1: its surround is lost"
        ]
    );
}

/// The chip is shown a part of the clips: what is kept is a part of what is won on these.
#[test]
fn what_is_kept_and_what_is_won_are_of_the_same_clips() {
    let few = |row: &Row| row.clip < 8;
    let mut uneven = record();
    uneven
        .rows
        .retain(|row| row.form == Form::Trained || few(row));
    for row in uneven
        .rows
        .iter_mut()
        .filter(|row| row.arm == "rgc" && !few(row))
    {
        row.psnr = row.psnr.map(|psnr| psnr - 0.9);
    }
    let mut shown = uneven.clone();
    shown.rows.retain(few);
    let kept = Report::new(uneven).kept().remove(0);
    let alone = Report::new(shown);
    assert_eq!(kept.float, alone.difference("rgc", "dvs", Metric::Psnr));
    let share = kept.won[0].1.mean / kept.float.unwrap().mean;
    assert!((0.4..0.8).contains(&share), "{share}");
}

/// What is told as 0 has no sign, and is neither better nor worse, however sure it is.
#[test]
fn what_rounds_to_nothing_is_not_better() {
    let flow = |arm: &str, epe: f64| {
        let of_arm = |row: Row| Row {
            arm: arm.to_owned(),
            psnr: None,
            ssim: None,
            epe: Some(epe),
            ..row
        };
        rows("dvs", 0.0).into_iter().map(of_arm).collect::<Vec<_>>()
    };
    for (epe, says) in [
        (0.4998, "0.000, from 0.000 to 0.000: not shown"),
        (0.5002, "0.000, from 0.000 to 0.000: not shown"),
        (0.4988, "-0.001, from -0.001 to -0.001: better"),
        (0.5012, "+0.001, from +0.001 to +0.001: worse"),
    ] {
        let report = Report::new(Record {
            goal: "flow".to_owned(),
            rows: [flow("dvs", 0.5), flow("rgc", epe)].concat(),
            kernels: Vec::new(),
            ..record()
        });
        let (table, page) = (report.table(), report.page());
        let line = format!("rgc minus dvs  {says}");
        assert!(table.contains(&line) && page.contains(says), "{table}");
    }
    // The surround of `fs-dvs` likewise.
    let mut none = record();
    for (ring, kernel) in [-4e-5, -5e-5, -6e-5]
        .iter()
        .zip(none.kernels.iter_mut().rev())
    {
        for (n, weight) in kernel.kernels[0].iter_mut().flatten().enumerate() {
            *weight = if n == 4 { 1.0 } else { *ring };
        }
    }
    let last = none.kernels.split_off(none.kernels.len() - 3);
    none.kernels = { (0..).zip(last) }
        .map(|(seed, own)| KernelAt {
            seed,
            step: 200,
            ..own
        })
        .collect();
    let told = Report::new(none).table();
    assert!(
        told.contains("? not shown; its surround weighs 0.000 of its centre"),
        "{told}"
    );
}

/// One photograph or one seed says nothing of others, however many clips there are.
#[test]
fn one_of_a_kind_shows_nothing() {
    let mut one_photograph = record();
    one_photograph.rows.retain(|row| row.photograph == "0.jpg");
    let mut one_seed = record();
    one_seed.rows.retain(|row| row.seed == 0);
    let mut one_of_both = one_seed.clone();
    one_of_both.rows.retain(|row| row.photograph == "0.jpg");
    let says = [
        (one_photograph, "over seeds alone", "only one photograph"),
        (one_seed, "over photographs alone", "only one seed"),
        (one_of_both, ", no interval: not shown", "only one seed"),
    ];
    for (record, interval, note) in says {
        let report = Report::new(record);
        let difference = report.difference("rgc", "dvs", Metric::Psnr).unwrap();
        assert!(!difference.shown(Metric::Psnr), "{difference:?}");
        let (table, page) = (report.table(), report.page());
        let line = { table.lines() }.find(|line| line.starts_with("rgc minus dvs"));
        let line = line.unwrap();
        assert!(
            line.contains(interval) && line.ends_with("not shown"),
            "{line}"
        );
        assert!(table.contains(note) && page.contains(note), "{table}");
        assert!(
            !table.contains("better") && !table.contains("worse"),
            "{table}"
        );
        assert!(!table.contains("at least half"), "{table}");
    }
    assert!(!Report::new(record()).table().contains("only one"));
}

/// What is missing is said: a metric that does not fit, a target without an event.
#[test]
fn what_is_missing_is_said() {
    let mut bare = record();
    for row in &mut bare.rows {
        row.ssim = None;
        if row.arm == "same" && row.target == TARGETS[0] {
            (row.events, row.bits) = (0, 0);
        }
    }
    let table = Report::new(bare).table();
    assert!(table.contains("SSIM is not reported"), "{table}");
    assert!(
        table.contains("same: no event on the held-out clips, where 0.02 per pixel and pair"),
        "{table}"
    );
    let whole = Report::new(record()).table();
    assert!(
        !whole.contains("is not reported") && !whole.contains("no event on the held-out clips")
    );
}

#[test]
fn the_surround_has_an_interval_over_seeds() {
    let found = Report::new(record()).surround().unwrap();
    // Eight weights of -0.05, -0.048 and -0.046.
    let seeds = [-0.4, -0.384, -0.368];
    assert!(
        found
            .seeds
            .iter()
            .zip(seeds)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    );
    let half = 4.303 * 0.016 / 3f64.sqrt();
    assert!((found.interval[0] + 0.384 + half).abs() < 1e-9, "{found:?}");
    assert!(found.answer().starts_with("yes"));
    let mut record = record();
    record.kernels.retain(|one| one.seed == 0);
    let one = Report::new(record.clone()).surround().unwrap();
    assert_eq!(one.answer(), "not shown");
    let table = Report::new(record.clone()).table();
    assert!(
        table.contains("of its centre, and one seed gives no interval\n"),
        "{table}"
    );
    record.kernels.clear();
    assert_eq!(Report::new(record).surround(), None);
}

#[test]
fn table_and_page_tell_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE);
    let record = record();
    std::fs::write(&path, serde_json::to_string(&record).unwrap()).unwrap();
    let report = Report::read(folder.path()).unwrap();
    assert_eq!(report.record(), &record);
    let table = report.table();
    println!("{table}");
    for text in [
        "4 arms, 3 seeds, 200 steps of 8 clips of 32x32; judged on 24 clips of 6 held-out photographs",
        "PSNR dB",
        "rgc minus dvs",
        "not shown",
        "program, silicon",
        "centre and surround? yes",
    ] {
        assert!(table.contains(text), "{text} in\n{table}");
    }
    let line = |what: &str| {
        table
            .lines()
            .find(|line| line.starts_with(what))
            .unwrap()
            .to_owned()
    };
    assert!(
        line("rgc minus dvs").ends_with("better"),
        "{}",
        line("rgc minus dvs")
    );
    assert!(line("same minus rgc").ends_with("worse"));
    assert!(line("same minus dvs").ends_with("not shown"));
    let page = report.page();
    if let Some(keep) = std::env::var_os("REPORT_PAGE") {
        std::fs::write(keep, &page).unwrap();
    }
    assert!(page.contains("default-src 'none'") && !page.contains("<script"));
    for text in [
        "What made up has learned",
        "Kernels on their way",
        "rgc minus dvs",
        "step 100",
    ] {
        let shown = text == "step 100" || page.contains(text);
        assert!(shown, "{text}");
    }
    assert!(report.way("fs-dvs").is_some() && report.way("dvs").is_none());
    assert_eq!(
        Report::read(folder.path()).unwrap().page(),
        page,
        "the same each time"
    );
}

#[test]
fn records_that_cannot_be_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE);
    let read = || Report::read(folder.path()).unwrap_err().to_string();
    assert!(read().contains(FILE));
    // What has begun has kept its task: the record comes with the first arm.
    let task = folder.path().join("task.toml");
    std::fs::write(&task, "").unwrap();
    assert!(read().ends_with("learn.json: nothing was measured yet"));
    std::fs::remove_file(&task).unwrap();
    std::fs::write(&path, "{").unwrap();
    assert!(read().contains("no record of a run"));
    let write =
        |record: &Record| std::fs::write(&path, serde_json::to_string(record).unwrap()).unwrap();
    write(&Record {
        version: VERSION + 1,
        ..record()
    });
    assert!(
        read().ends_with("version 2 of the record; this program reads version 1"),
        "{}",
        read()
    );
    write(&Record {
        rows: Vec::new(),
        ..record()
    });
    assert!(read().ends_with("nothing was measured yet"));
}
