//! `amacrine voxels`: an event file as the tensors that networks take.

use clap::builder::RangedU64ValueParser;
use miette::{Diagnostic as _, miette};
use serde_json::json;

use super::{
    arguments::{
        budget,
        recording::{self, Recording},
    },
    output::{
        content::Content,
        files::{Input, Output},
        progress::Progress,
    },
};
use crate::{
    event::{
        Event,
        file::{self, Reader},
        tensor::{
            Alignment, Container, Layers, MOST_BINS, Normalise, Precision, Share, Sides,
            TensorFile, VoxelStream, Voxels, Windows,
        },
    },
    memory::{Bytes, Need},
    plane::Size,
    unit::{Micros, counted, exact_seconds},
};

/// What `voxels` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine voxels events.npy -o voxels.npy --window 50ms\n  amacrine voxels events.npy -o voxels.npz --window 100ms --every 50ms --bins 9 --polarity split --half\n  amacrine voxels events.npy -o voxels.h5 --window 50ms --normalise std --align centred\n\nThe array has the shape (windows, kinds, sides, bins, H, W); sides is 1, or with --polarity split OFF and then ON. A window has the events after its start and up to its end; the first window also has those at its start. An event at the time of a frame is thus in the window that ends with it. Files of any length are read block by block; only windows that overlap are in memory."
)]
pub struct Arguments {
    /// Event file
    file: Input,
    #[command(flatten)]
    recording: Recording,
    /// Write the array: .npy, .npz (with the names of the kinds) or .h5
    #[arg(short, long, value_name = "VOXELS", value_parser = Content::Tensor)]
    output: Output,
    /// Number of bins in a window
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_BINS as u64))]
    bins: usize,
    /// Length of a window
    #[arg(long, value_name = "TIME")]
    window: Micros,
    /// Time from which windows are counted
    ///
    /// The first window ends one --every later; with --align centred it has its middle there.
    /// Default: the last multiple of --every before or at the start of the recording.
    #[arg(long, value_name = "TIME")]
    from: Option<Micros>,
    /// Time from one window to the next [default: the length of a window]
    #[arg(long, value_name = "TIME")]
    every: Option<Micros>,
    /// Position of a window about its time: causal or centred
    ///
    /// `causal` ends at that time. `centred` has its middle there, with half of --window before and
    /// after it, each end to the nearest microsecond.
    #[arg(long, default_value = "causal", value_name = "WHERE", value_parser = parsed::<Alignment>)]
    align: Alignment,
    /// Polarity: signed or split
    ///
    /// `signed` adds ON and subtracts OFF; `split` has a plane for each.
    #[arg(long, default_value = "signed", value_name = "HOW", value_parser = parsed::<Sides>)]
    polarity: Sides,
    /// Weights of an event: bilinear or whole
    ///
    /// `bilinear` shares an event between the two nearest bins; the middle of the first bin is at
    /// the start of the window, that of the last at its end. `whole` divides the window into bins
    /// of equal length, and counts an event in the bin that it falls in; an event at the end of a
    /// bin belongs to that bin.
    #[arg(long, default_value = "bilinear", value_name = "HOW", value_parser = parsed::<Share>)]
    share: Share,
    /// Normalisation of a window, for each kind: none, std or max
    ///
    /// `std` is that of E2VID: voxels that are not 0 get a mean of 0 and a deviation of 1; where
    /// these are all equal, or only one, they become 0. `max` divides by the largest magnitude.
    #[arg(long, default_value = "none", value_name = "HOW", value_parser = parsed::<Normalise>)]
    normalise: Normalise,
    /// Write numbers of 16 bits in place of 32
    #[arg(long)]
    half: bool,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// A name, for the command line, which shows no help beside a message.
fn parsed<T>(text: &str) -> Result<T, String>
where
    T: std::str::FromStr,
    T::Err: miette::Diagnostic,
{
    text.parse().map_err(|error: T::Err| {
        let known = error
            .help()
            .map_or(String::new(), |help| format!(": {help}"));
        format!("{error}{known}")
    })
}

/// Runs the verb.
///
/// # Errors
/// When the file cannot be read, the windows are none, or the array cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let every = arguments.every.unwrap_or(arguments.window);
    let windows = Windows::new(arguments.window.seconds(), every.seconds(), arguments.align)?;
    let container = match arguments.output.ending() {
        "npz" => Container::Npz,
        "h5" | "hdf5" => Container::Hdf5,
        _ => Container::Npy,
    };
    let precision = if arguments.half {
        Precision::Half
    } else {
        Precision::Single
    };
    // Once for the size, the kinds and the end, where the file does not say them.
    let about = Extent::of(arguments)?;
    let (size, channels) = (about.size, about.channels);
    let windows = match arguments.from {
        Some(from) if from > about.end => {
            return Err(miette!(
                help = "give a time before its end, or leave --from out",
                "--from {} s: {} ends at {} s",
                exact_seconds(from.0),
                arguments.file.display(),
                exact_seconds(about.end.0)
            ));
        }
        Some(from) => windows.from(from),
        None => windows.reaching(about.start),
    };
    let mut how = Voxels::new(arguments.bins, windows)?;
    how.share = arguments.share;
    how.sides = arguments.polarity;
    how.normalise = arguments.normalise;
    arguments.check_memory(&how, size, channels)?;
    let shape = how.shape(size, channels);
    arguments.check_disk(&how, &about, container, precision)?;
    let layers = Layers {
        shape: shape.to_vec(),
        precision,
        kinds: about.names.clone(),
    };
    let mut file = TensorFile::create(&arguments.output, container, layers)?;
    let mut stream = VoxelStream::new(how, size, channels);
    let mut reader = Reader::open(&arguments.file, &arguments.recording.opening(None))?;
    let progress = Progress::new("windows", Some(windows.count(about.end)));
    let mut block: Vec<Event> = Vec::new();
    let mut write = |window: &[f32]| {
        progress.tick();
        file.push(window).map_err(miette::Report::from)
    };
    while reader.next_block(&mut block)? {
        stream.pass(&block, &mut write)?;
    }
    while let Some(window) = stream.next_left(about.end) {
        write(&window)?;
    }
    let count = file.finish()?;
    progress.finish();
    let between = stream.between();
    if between > 0 {
        super::complain(&format!(
            "warning: {} lie{} between windows, in none of them: --every {every} is longer than --window {}\n",
            counted(between, "event"),
            if between == 1 { "s" } else { "" },
            arguments.window
        ));
    }
    if arguments.json {
        let mut all = vec![count];
        all.extend(shape.iter().map(|n| *n as u64));
        let said = json!({
            "file": arguments.file,
            "output": arguments.output,
            "shape": all,
            "from_us": how.windows.bounds(0).0,
            "dtype": if arguments.half { "float16" } else { "float32" },
            "between_windows": between,
            "kinds": about.names,
            "size_known": about.size_known,
        });
        super::say(&format!("{said}\n"));
        return Ok(());
    }
    let [kinds, sides, bins, height, width] = shape;
    super::say(&format!(
        "wrote    {}: ({count}, {kinds}, {sides}, {bins}, {height}, {width}): windows, kinds, sides, bins, rows, columns{}{}\n",
        arguments.output.display(),
        match how.windows.bounds(0).0 {
            0 => String::new(),
            from => format!("; the first window begins at {} s", exact_seconds(from)),
        },
        recording::guessed(about.size_known)
    ));
    Ok(())
}

/// What is to be known of the file before its voxels.
struct Extent {
    size: Size,
    channels: u8,
    names: Vec<String>,
    start: Micros,
    end: Micros,
    size_known: bool,
}

impl Extent {
    fn of(arguments: &Arguments) -> miette::Result<Self> {
        let mut reader = Reader::open(&arguments.file, &arguments.recording.opening(None))?;
        let mut block: Vec<Event> = Vec::new();
        let (mut first, mut last) = (None, Micros(0));
        // Only the events themselves say where they end and what they reach.
        while reader.next_block(&mut block)? {
            first = first.or_else(|| block.first().map(|event| event.t));
            last = block.last().map_or(last, |event| event.t);
        }
        let stated = reader.about().span.map(|(start, _)| start);
        let (packet, size_known) = {
            let (loaded, damage, _) = file::up_to(&mut reader, 0);
            if let Some(damage) = damage {
                return Err(damage.into());
            }
            (loaded.packet, loaded.size_known)
        };
        if packet.size.pixels() == 0 {
            return Err(recording::sizeless(&arguments.file));
        }
        Ok(Self {
            size: packet.size,
            channels: packet.channels,
            names: packet.names,
            // A span may be stated that begins after the first event.
            start: { stated.into_iter().chain(first) }
                .min()
                .unwrap_or_default(),
            end: last.max(packet.span.1),
            size_known,
        })
    }
}

impl Arguments {
    /// Refuses windows for which there is no room in memory.
    fn check_memory(&self, how: &Voxels, size: Size, channels: u8) -> miette::Result<()> {
        let every = self.every.unwrap_or(self.window);
        let overlap = u128::from(self.window.0.div_ceil(every.0.max(1)) + 1);
        // Sums of shares may need 64 bits.
        let sum = match self.share {
            Share::Bilinear if self.bins > 1 => 8,
            _ => 4,
        };
        let each = how.len(size, channels) as u128;
        // One more as it is written.
        let need = Need::new().and("windows that overlap", each * (sum * overlap + 4));
        budget::check(
            &need,
            &format!("voxels of {size}"),
            "take fewer bins, or windows that overlap less",
        )
    }

    /// Refuses an array for which there is no room on its disk.
    fn check_disk(
        &self,
        how: &Voxels,
        about: &Extent,
        container: Container,
        precision: Precision,
    ) -> miette::Result<()> {
        let temporary = std::env::temp_dir().join("voxels");
        let place: &std::path::Path = match container {
            Container::Npy if self.output.is_node() => &temporary,
            Container::Npy => &self.output,
            // Whole before it is packed.
            Container::Npz => &temporary,
            // Packed chunk by chunk: nobody knows how small that gets.
            Container::Hdf5 => return Ok(()),
        };
        let windows = how.windows.count(about.end);
        let each = how.len(about.size, about.channels) as u128 * precision.bytes();
        budget::check_disk(
            place,
            u128::from(windows) * each,
            &format!("{windows} windows of {}", Bytes(each)),
            "take longer windows, fewer of them (--every), fewer bins, or 16 bits (--half)",
        )
    }
}
