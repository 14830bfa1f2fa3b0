//! `amacrine show`: pictures of a packet, and the text of what comes with the program.

use miette::miette;

use super::{
    arguments::{
        budget,
        recording::{self, Recording},
    },
    list,
    output::{
        content::Content,
        files::{Input, Output},
    },
};
use crate::{
    event::Packet,
    memory::Need,
    picture::{
        view::{self, Look, View},
        write_frames,
    },
    unit::{Micros, counted},
};

/// What `show` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  amacrine show out/events.npy -o picture.png
  amacrine show out/events.npy -o rate.svg --view rate
  amacrine show out/events.npy -o events.gif --window 20ms
  amacrine show out/events.npy -o events.mcap --window 20ms
  amacrine show sensor rgc-4
  amacrine show scene bundled")]
pub struct Arguments {
    /// Event file to draw; or, before NAME, a kind of thing to print
    ///
    /// Kinds are sensor, program, kernel, study, readout, chip, pattern and
    /// scene.
    file: Input,
    /// Name of the thing to print (see `amacrine list sensors`)
    ///
    /// Excludes all options of a picture.
    #[arg(conflicts_with_all = ["output", "view", "from", "to", "window", "at", "title", "hold", "json", "size", "stream"])]
    name: Option<String>,
    #[command(flatten)]
    recording: Recording,
    /// Write the picture to this file: .png, .svg, .gif, .apng or .mcap
    ///
    /// .gif and .apng are animations, window by window: of frames, as .apng also of surfaces and
    /// kinds. .mcap is a recording of events and pictures, window by window, for viewers of
    /// ROS 2.
    #[arg(short, long, value_name = "PICTURE", value_parser = Content::View)]
    output: Option<Output>,
    /// View to draw [default: overview; frame for an animation or a recording]
    #[arg(long, value_enum)]
    view: Option<Shown>,
    /// Leave out events up to this time
    ///
    /// An event at the time of a frame belongs to the window that ends there. (`convert --slice`
    /// keeps events at its start.)
    #[arg(long, value_name = "TIME")]
    from: Option<Micros>,
    /// Leave out events after this time; an event at this time stays
    #[arg(long, value_name = "TIME")]
    to: Option<Micros>,
    /// Length of a frame, and time constant of a time surface [default: 20ms]
    #[arg(long, value_name = "TIME")]
    window: Option<Micros>,
    /// End of the frame, and time of the surface [default: the end of the busiest window]
    #[arg(long, value_name = "TIME")]
    at: Option<Micros>,
    /// Title of the picture [default: the name of the file]
    #[arg(long)]
    title: Option<String>,
    /// Time for which an animation shows each frame [default: 100ms]
    #[arg(long, value_name = "TIME")]
    hold: Option<Micros>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shown {
    /// All other views on one page
    Overview,
    /// Events of a window, pixel by pixel
    Frame,
    /// Time surface: how long ago each pixel's last event was
    Surface,
    /// Events in x, y and time
    Cloud,
    /// ON and OFF events per second
    Rate,
    /// Times between successive events of a cell
    Intervals,
    /// One frame for each kind of cell (which ganglion cell of a pixel)
    Kinds,
}

impl Arguments {
    /// The view of a picture that does not move.
    fn view(&self) -> Shown {
        self.view.unwrap_or(Shown::Overview)
    }

    /// The length of a frame.
    fn window(&self) -> Micros {
        self.window.unwrap_or(Micros(20_000))
    }

    /// How long a frame is shown.
    fn hold(&self) -> Micros {
        self.hold.unwrap_or(Micros(100_000))
    }

    /// Refuses options that change nothing of this picture.
    fn check_options(&self, to: &Output, moving: bool) -> miette::Result<()> {
        let output = to.display();
        let whole = matches!(self.view(), Shown::Cloud | Shown::Rate | Shown::Intervals);
        let recorded = to.ending() == "mcap";
        let (option, why, help) = if self.hold.is_some() && (recorded || !moving) {
            let help = "leave --hold out, or give a name that ends in .gif or .apng";
            ("hold", format!("for {output}, which is no animation"), help)
        } else if self.at.is_some() && moving {
            let help = "leave --at out, or give a name that ends in .png or .svg";
            ("at", format!("for {output}, which has every window"), help)
        } else if self.title.is_some() && recorded {
            let help = "leave --title out";
            ("title", format!("for {output}, which has none"), help)
        } else if whole && (self.at.is_some() || self.window.is_some()) {
            let option = if self.at.is_some() { "at" } else { "window" };
            let help = "leave it out (--from and --to choose the time), or take a view of a window: overview, frame, surface or kinds";
            (
                option,
                "for this view, which shows all of the packet at once".to_owned(),
                help,
            )
        } else {
            return Ok(());
        };
        Err(miette!(help = help, "--{option} has no effect {why}"))
    }

    /// Bytes that an event takes.
    fn each(&self, moving: bool) -> u128 {
        match self.view() {
            Shown::Overview | Shown::Intervals if !moving => EACH_BY_CELL,
            _ => EACH,
        }
    }

    /// A picture of the whole packet does not move, and a GIF holds few colours.
    fn can_move(&self, to: &Output) -> miette::Result<()> {
        let output = to.display();
        if to.ending() == "gif" && self.hold() < Micros(10_000) {
            return Err(miette!(
                help = "give --hold 10ms or more, or a name that ends in .apng",
                "{output}: a GIF counts its time in hundredths of a second"
            ));
        }
        if to.ending() == "gif" && self.hold() > Micros(655_350_000) {
            return Err(miette!(
                help = "give --hold 655s or less, or a name that ends in .apng",
                "{output}: a frame of a GIF lasts 655.35 s at most"
            ));
        }
        match self.view {
            None | Some(Shown::Frame) if to.ending() == "mcap" => Ok(()),
            _ if to.ending() == "mcap" => Err(miette!(
                help = "leave --view out",
                "{output}: it holds events and frames of them, no other view"
            )),
            Some(Shown::Surface | Shown::Kinds) if to.ending() == "gif" => Err(miette!(
                help = "give a name that ends in .apng, or leave --view out",
                "{output}: a GIF has too few colours for this view"
            )),
            None | Some(Shown::Frame | Shown::Surface | Shown::Kinds) => Ok(()),
            Some(Shown::Overview) => Err(miette!(
                help = "leave --view out for frames, or give a name that ends in .png or .svg",
                "{output}: an overview has all views on one page, it does not move"
            )),
            Some(Shown::Cloud | Shown::Rate | Shown::Intervals) => Err(miette!(
                help = "give a name that ends in .png or .svg; frames, surfaces and kinds move",
                "{output}: this view shows all of the packet at once, it does not move"
            )),
        }
    }
}

impl Shown {
    const fn view(self) -> View {
        match self {
            Self::Overview => View::Overview,
            Self::Frame => View::Frame,
            Self::Surface => View::Surface,
            Self::Cloud => View::Cloud,
            Self::Rate => View::Rate,
            Self::Intervals => View::Intervals,
            Self::Kinds => View::Kinds,
        }
    }
}

/// The most pages that an animation has.
const PAGES: u64 = 2000;

/// The most windows of a recording: 5 h at 20 ms.
const WINDOWS: u64 = 1_000_000;

/// Bytes of an event: as it was read; of views of intervals by its cell, too.
const EACH: u128 = 24;
const EACH_BY_CELL: u128 = 48;

/// Bytes of the page, as it is drawn and as it is packed.
const PAGE: u128 = 20 << 20;

/// Bytes of a pixel: times, counts and colours, as numbers and as drawn.
const PIXEL: u128 = 40;

/// Runs the verb.
///
/// # Errors
/// When the file cannot be read, the picture's name says no kind of picture, or it cannot be
/// written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let file = arguments.file.display().to_string();
    if let Some(name) = &arguments.name {
        return list::show(&file, name);
    }
    list::check_no_kind(&file)?;
    let Some(output) = &arguments.output else {
        let named = list::kind_with(&file).map_or(String::new(), |kind| {
            format!("; for the text of what comes with the program, `amacrine show {kind} {file}`")
        });
        return Err(miette!(
            help = format!("add -o PICTURE (--output): .png, .svg, .gif, .apng or .mcap{named}"),
            "{file}: no picture to write was named"
        ));
    };
    let recorded = output.ending() == "mcap";
    if recorded && cfg!(not(feature = "mcap")) {
        return Err(miette!(
            help = "build with --features mcap, or give a name that ends in .apng",
            "this amacrine was built without MCAP"
        ));
    }
    let moving = ["gif", "apng", "mcap"].contains(&output.ending());
    if arguments.window().0 == 0 {
        return Err(miette!(
            help = "give a time such as 20ms",
            "--window 0: a frame needs some time"
        ));
    }
    if moving {
        arguments.can_move(output)?;
    }
    arguments.check_options(output, moving)?;
    let each = arguments.each(moving);
    let loaded = arguments.recording.read(&arguments.file, 0, each)?;
    let size_known = loaded.size_known;
    let mut packet = loaded.packet;
    check(&packet, each, arguments)?;
    cut(&mut packet, arguments)?;
    let name = arguments.file.display().to_string();
    let title = arguments.title.as_ref().unwrap_or(&name);
    let frames = if moving {
        Some(animate(&packet, title, output, arguments)?)
    } else {
        let look = Look {
            title,
            view: arguments.view().view(),
            window: arguments.window(),
            at: arguments.at,
        };
        output.draw(&view::draw(&packet, &look)?)?;
        None
    };
    let events = packet.events.len();
    if arguments.json {
        let said = serde_json::json!({
            "file": arguments.file,
            "output": output,
            "events": events,
            "width": packet.size.width,
            "height": packet.size.height,
            "size_known": size_known,
            "frames": frames,
        });
        super::say(&format!("{said}\n"));
    } else {
        let frames = frames.map_or(String::new(), |n| format!(" in {}", counted(n, "frame")));
        let output = output.display();
        let of = match recording::guessed(size_known) {
            "" => String::new(),
            note => format!(" of {}{note}", packet.size),
        };
        super::say(&format!(
            "wrote    {output}: {}{of}{frames}\n",
            counted(events, "event")
        ));
    }
    Ok(())
}

/// Refuses pictures for which there is no room: a file may say that its sensor is of any size.
fn check(packet: &Packet, each: u128, arguments: &Arguments) -> miette::Result<()> {
    let kinds = match arguments.view() {
        Shown::Kinds | Shown::Overview => u128::from(packet.channels),
        Shown::Frame | Shown::Surface | Shown::Cloud | Shown::Rate | Shown::Intervals => 1,
    };
    let pixels = PIXEL * kinds * packet.size.pixels() as u128;
    let events = each * packet.events.len() as u128;
    let need = Need::new()
        .and("pictures of the sensor's size", pixels)
        .and("the page", PAGE)
        .and("events", events);
    let what = format!("a picture of {}", packet.size);
    let help = "show one kind of cell, or a file that says the true size of its sensor";
    budget::check(&need, &what, help)
}

/// Leaves only what was asked for.
fn cut(packet: &mut Packet, arguments: &Arguments) -> miette::Result<()> {
    let (first, last) = packet.span;
    let from = arguments.from.unwrap_or(first);
    let to = arguments.to.unwrap_or(last);
    if from > to || from > last || to < first {
        return Err(miette!(
            help = "give times within the packet, the first before the last",
            "from {from} to {to}: nothing is in between; the packet was watched from {first} to {last}"
        ));
    }
    if arguments.from.is_some() {
        packet.events.retain(|e| e.t > from);
    }
    if arguments.to.is_some() {
        packet.events.retain(|e| e.t <= to);
    }
    packet.span = (from, to);
    if let Some(at) = arguments.at.filter(|at| !(from..=to).contains(at)) {
        return Err(miette!(
            help = "give a time within what is shown, or leave --at out for the busiest window",
            "--at {at}: what is shown was watched from {from} to {to}"
        ));
    }
    Ok(())
}

/// Writes an animation; of how many frames.
fn animate(
    packet: &Packet,
    title: &str,
    output: &Output,
    arguments: &Arguments,
) -> miette::Result<u64> {
    let (from, to) = packet.span;
    let window = arguments.window();
    let pages = to.0.saturating_sub(from.0).div_ceil(window.0);
    let most = if output.ending() == "mcap" {
        WINDOWS
    } else {
        PAGES
    };
    if pages > most {
        return Err(miette!(
            help = "make --window longer, or show a part with --from and --to",
            "{pages} frames of {window}: at most {most} are written"
        ));
    }
    if pages == 0 {
        return Err(miette!(
            help = "give a packet that was watched for some time, or --from and --to",
            "the packet was watched for no time: there is no frame to show"
        ));
    }
    #[cfg(feature = "mcap")]
    if output.ending() == "mcap" {
        return Ok(view::mcap::write(output, packet, window)?);
    }
    let hold = arguments.hold().seconds();
    let names = match arguments.view() {
        Shown::Kinds => &packet.names[..],
        _ => &[],
    };
    let names = names.iter().map(String::as_str);
    output.warn_of_letters([title].into_iter().chain(names));
    match arguments.view() {
        Shown::Surface | Shown::Kinds => {
            let look = Look {
                title,
                view: arguments.view().view(),
                window,
                at: None,
            };
            let pages = view::pages(packet, look, from, to)?;
            write_frames(output, pages, hold)?;
        }
        Shown::Overview | Shown::Frame | Shown::Cloud | Shown::Rate | Shown::Intervals => {
            let frames = view::frames(packet, title, from, to, window)?;
            write_frames(output, frames, hold)?;
        }
    }
    Ok(pages)
}
