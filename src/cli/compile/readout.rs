//! The readout of a compiled program: the ways to read its events, what each costs, and the one
//! that it takes.

use std::fmt::Write as _;

use miette::miette;
use serde_json::json;

use super::{Arguments, Asked};
use crate::{
    array::Arithmetic,
    cli::{arguments::light, output::readout_table},
    compile::{CellKind, EventReadout, SensorProgram},
    event::Packet,
    isa::{Device, Figure},
    number::Format,
    photoreceptor::Response,
    program::{
        Cost, Overrides, Program,
        readout::{Demand, Plan, Scans, Way, choose},
    },
    rig::{self, Larger, guard::Warning},
    scene::Observation,
    study::{design, feasibility::time, together::CHIPS},
    unit::counted,
};

/// How a program reads its events out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Asking {
    /// The cheapest that loses no event. With --scene: of the scene, on four chips of the model and
    /// without a chip's errors (another scene or chip may lose some); with --events-per-frame: of
    /// that number; else all slots
    #[default]
    Auto,
    /// Event by event, with slots for the busiest frame
    Slots,
    /// Whole bit planes
    Planes,
    /// The rows of the bit planes in which the scene has events
    Region,
    /// The bounding box of the events, without the events
    Box,
    /// The approximate number of events, without the events
    Counts,
    /// A sum of the drive over the array, without the events
    Sums,
    /// Whether there is an event, without the events
    Any,
}

/// The ways to read a program's events, and the one that it takes.
pub(super) struct Readouts {
    plans: Vec<Plan>,
    chosen: usize,
    /// Words of a frame, as the least and the most time, us.
    array_us: [f64; 2],
    /// The most events of one sign and kind in a frame.
    busiest: Option<u64>,
    /// Who says how many events there are.
    basis: String,
    not_known: Vec<&'static str>,
    /// What was seen of the scene on which events were counted.
    observation: Observation,
}

/// What is always unknown.
const LINK: &str = "the host's processing and the link to a computer have no public figure, and are in none of these times";

/// Weighs the ways to read a program's events, and chooses.
pub(super) fn planned(
    arguments: &Arguments,
    asked: &Asked,
    program: &SensorProgram,
    kinds: &[CellKind],
    device: &Device,
) -> miette::Result<(EventReadout, Readouts)> {
    let parsed = Program::parse("compiled", &program.text)?;
    let code = parsed.expand(device, &Overrides::default())?.code;
    let array_us =
        time::array_us(&code.frame, device).unwrap_or([Cost::of(&code.frame, device).array_us; 2]);
    let mut not_known = vec![LINK];
    let rows = device.value(Figure::Height) as usize;
    let cells = device.value(Figure::Width) as usize * rows * kinds.len();
    let observation = Observation::new();
    let (demand, basis) = if let Some(events) = arguments.events_per_frame {
        if events > cells as u64 {
            let help = format!("give at most {cells}: a cell has one event in a frame at most");
            return Err(miette!(
                help = help,
                "--events-per-frame {events}, of {} on {rows} x {} pixels",
                counted(kinds.len(), "kind"),
                device.value(Figure::Width)
            ));
        }
        not_known.push("the rows in which events lie: give --scene instead for a region");
        let demand = Demand::expected(events);
        (Some(demand), format!("--events-per-frame {events}"))
    } else if let Some(scene) = &arguments.scene {
        let demand = watched((arguments, &observation), asked, program, kinds, device)?;
        let basis =
            format!("{scene}, the most on {CHIPS} chips of the model and without a chip's errors");
        (Some(demand), basis)
    } else {
        not_known.push("how many events a frame has: give --events-per-frame N or --scene");
        (None, "nobody".to_owned())
    };
    let scans = Scans::new(&code.frame, device);
    let plans = scans.plans(demand.as_ref(), device);
    let at = |way: Way| plans.iter().position(|plan| plan.way == way);
    let slots = || at(Way::BusiestFrame).or_else(|| at(Way::AsProgrammed));
    let chosen = match arguments.readout {
        Asking::Auto if demand.is_none() => slots(),
        Asking::Auto => choose(&plans),
        Asking::Slots => slots(),
        Asking::Planes => at(Way::BitPlanes),
        Asking::Region => at(Way::Region),
        Asking::Box => at(Way::BoundingBox),
        Asking::Counts => at(Way::EventCounts),
        Asking::Sums => at(Way::Sums),
        Asking::Any => at(Way::AnyEvent),
    };
    let chosen = chosen.ok_or_else(|| {
        miette!(
            help = "give --scene, whose events are counted, or --readout planes",
            "it is not stated in which rows the events lie"
        )
    })?;
    let readout = EventReadout::from(&plans[chosen]);
    let readouts = Readouts {
        chosen,
        array_us,
        busiest: demand.as_ref().map(Demand::busiest),
        basis,
        not_known,
        plans,
        observation,
    };
    Ok((readout, readouts))
}

/// Opens the scene on which events will be counted and drops it again: what is wrong with it is said
/// before the search.
///
/// # Errors
/// When it cannot be opened, or is larger than the chip's array.
pub(super) fn check_scene(arguments: &Arguments, device: &Device) -> miette::Result<()> {
    let Some(name) = arguments.scene.as_deref() else {
        return Ok(());
    };
    // A pipe can be read once.
    let about = std::fs::metadata(name);
    if about.is_ok_and(|about| !about.is_file() && !about.is_dir()) {
        return Ok(());
    }
    let unseen = Observation::new();
    let scene = arguments.samples.open(Some(name), &unseen)?;
    Ok(Larger::check(
        &format!("--scene {name}"),
        scene.size(),
        device,
    )?)
}

/// What the events of the program on a scene ask for, every one of them: on several chips, which
/// differ, and without a chip's errors.
fn watched(
    (arguments, observation): (&Arguments, &Observation),
    asked: &Asked,
    program: &SensorProgram,
    kinds: &[CellKind],
    device: &Device,
) -> miette::Result<Demand> {
    let name = arguments.scene.as_deref().unwrap_or_default();
    let mut scene = arguments.samples.open(Some(name), observation)?;
    let size = scene.size();
    Larger::check(&format!("--scene {name}"), size, device)?;
    // Whole rows, so that no event goes missing for want of a slot.
    let all = EventReadout::BitPlanes(0, u16::MAX);
    let text = program.text_with(kinds, &asked.title, device, all);
    let compiled = design::Compiled::from_text(&asked.title, program.clone(), &text, device)?;
    let seeds = (0..CHIPS).map(|n| arguments.seed.wrapping_add(n));
    let silicon = seeds.map(|seed| Arithmetic::Silicon { seed });
    let exact = Arithmetic::Number(Format::F64);
    let chips = std::iter::once(exact).chain(silicon);
    let mut chips = chips
        .map(|chip| compiled.chip(chip, size, compiled.settings()))
        .collect::<Result<Vec<_>, _>>()?;
    let mut frames = 0;
    let packets = rig::watch(&mut *scene, &mut rig::each(&mut chips), |_| frames += 1)?;
    light::warn(&Warning::of_scene(observation, Response::IDENTITY));
    if packets.iter().all(|packet| packet.events.is_empty()) {
        light::warn(&[Warning::no_events(name, Some(frames))]);
    }
    let demands = packets.iter().map(|packet| Demand::new(packet, frames));
    let nothing = || Demand::new(&Packet::new(size, 1), frames);
    Ok(demands.reduce(Demand::and).unwrap_or_else(nothing))
}

impl Readouts {
    /// How long the chosen readout takes, and what comes of it.
    pub(super) fn time(&self) -> String {
        let plan = &self.plans[self.chosen];
        let what = match plan.way {
            Way::AsProgrammed => "all slots",
            way => way.in_words(),
        };
        let [us, fps] = [
            readout_table::between(plan.us, 1),
            readout_table::between(plan.frames_s(self.array_us), 0),
        ];
        format!("{us} us on the host with {what}: {fps} frames/s")
    }

    pub(super) fn json(&self) -> serde_json::Value {
        let plan = |(at, plan): (usize, &Plan)| {
            json!({
                "plan": plan.way,
                "calls": plan.calls,
                "slots": plan.slots,
                "rows": plan.rows.as_ref().map(|rows| [*rows.start(), *rows.end()]),
                "us": plan.us,
                "frames_s": plan.frames_s(self.array_us),
                "carries": plan.way.carries(),
                "lost": plan.lost,
                "is_chosen": at == self.chosen,
            })
        };
        let plans: Vec<_> = self.plans.iter().enumerate().map(plan).collect();
        json!({
            "chosen": self.plans[self.chosen].way,
            "expected_by": self.basis,
            "busiest": self.busiest,
            "plans": plans,
            "not_known": self.not_known,
            "light": light::json(&self.observation),
        })
    }

    /// The table for people, and what is not known.
    pub(super) fn table(&self) -> String {
        let row = |(at, plan): (usize, &Plan)| readout_table::Row {
            way: plan.way,
            slots: plan.slots,
            us: plan.us,
            frames_s: plan.frames_s(self.array_us),
            lost: plan.lost,
            is_chosen: at == self.chosen,
        };
        let mut text = readout_table::table(self.plans.iter().enumerate().map(row));
        if let Some(busiest) = self.busiest {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "for {} of one sign and kind in the busiest frame ({}); exposure is in no frame rate",
                counted(busiest, "event"),
                self.basis
            );
        }
        text.push_str(&light::line(&self.observation));
        for what in &self.not_known {
            let _ = writeln!(text, "not known: {what}");
        }
        text
    }
}
