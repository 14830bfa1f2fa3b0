//! Errors of scenes: one variant for each cause, each with what to do about it.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::time::frame_rate::{MOST_FPS, Shown};
use crate::{
    config::asked,
    memory::TooMuch,
    plane::Size,
    unit::{counted, frame_rate},
};

/// Why a scene cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneError {
    /// The file cannot be opened or read.
    #[error("{path}: {cause}")]
    #[diagnostic(help(
        "{}give a file or a folder that exists and can be read, `bundled` for the clip that comes with amacrine, or `pattern:NAME`",
        asked(&path.to_string_lossy(), ["bundled"])
    ))]
    Unreadable {
        /// The file or folder of the scene.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },

    /// A file, folder or clip with nothing in it.
    #[error("{path}: there is no {missing} in it")]
    #[diagnostic(help("give a clip with at least one frame; was it written to the end?"))]
    Empty {
        /// Which file or folder.
        path: PathBuf,
        /// What was looked for.
        missing: &'static str,
    },

    /// A file name whose extension is not known.
    #[error("{path}: {} is no known kind of scene", kind(path))]
    #[diagnostic(help(
        "known: .y4m .mp4 .gif .apng .png .pgm .npy, a folder of .png or .pgm pictures, \
         pattern:NAME; {}",
        way_in(path)
    ))]
    UnknownKind {
        /// The file or folder of the scene.
        path: PathBuf,
    },

    /// The first bytes say another kind of file than the name.
    #[error("{path}: the name says {stated}, but the content is {found}")]
    #[diagnostic(help("rename the file to match its content, or write it again"))]
    Disguised {
        /// The file or folder of the scene.
        path: PathBuf,
        /// The kind that the name promises.
        stated: &'static str,
        /// What the first bytes are.
        found: &'static str,
    },

    /// A field of a file's header that cannot be understood.
    #[error("{path}: header field {field}: got {got}, expected {want}")]
    #[diagnostic(help("write the file anew; for video: ffmpeg -i FILE -pix_fmt gray clip.y4m"))]
    Header {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Name of the field.
        field: &'static str,
        /// Its value in the file.
        got: String,
        /// What it should be.
        want: &'static str,
    },

    /// A y4m colour space without a luma plane that can be read.
    #[error("{path}: colour space C{got} cannot be read")]
    #[diagnostic(help(
        "known: mono, 420, 420jpeg, 420mpeg2, 420paldv, 411, 422, 440, 444, 444alpha, and mono, 420p, \
         422p, 444p with 9, 10, 12, 14 or 16 bits; ffmpeg -i FILE -pix_fmt gray clip.y4m makes mono"
    ))]
    ColourSpace {
        /// The file or folder of the scene.
        path: PathBuf,
        /// What its header says.
        got: String,
    },

    /// Video of half frames.
    #[error("{path}: interlaced video (I{got}): each frame mixes lines of two moments")]
    #[diagnostic(help("{}", apart(got)))]
    Interlaced {
        /// The file or folder of the scene.
        path: PathBuf,
        /// What its header says.
        got: String,
    },

    /// An `.npy` whose numbers cannot be taken as light.
    #[error("{path}: numbers of type {got} cannot be read as light")]
    #[diagnostic(help(
        "known: f2 f4 f8 u1 u2 u4 u8 i1 i2 i4 i8, little or big end first; in numpy: a.astype('<f8')"
    ))]
    NumberType {
        /// The file or folder of the scene.
        path: PathBuf,
        /// The type string (`descr`) in its header.
        got: String,
    },

    /// An `.npy` with other than three axes.
    #[error(
        "{path}: shape ({}), expected three axes: (frames, height, width), or one channel of (frames, 1, height, width)",
        join(shape)
    )]
    #[diagnostic(help("in numpy: {}", three_axes(shape)))]
    Axes {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Its shape.
        shape: Vec<u64>,
    },

    /// An `.npy` whose frames do not stand one after another.
    #[error(
        "{path}: numbers stand column by column (Fortran order), so frames cannot be read one by one"
    )]
    #[diagnostic(help("in numpy: np.save(path, np.ascontiguousarray(a))"))]
    FortranOrder {
        /// The file or folder of the scene.
        path: PathBuf,
    },

    /// A whole number too large to be light exactly.
    #[error("{path}: frame {frame}, y {y}, x {x}: {value} has no exact 64-bit real")]
    #[diagnostic(help("light must be below 2^53; save the clip as f8"))]
    Inexact {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Number of the frame, from 0.
        frame: u64,
        /// Row of the pixel, from 0 at the top.
        y: usize,
        /// Column of the pixel, from 0 on the left.
        x: usize,
        /// The number.
        value: i128,
    },

    /// More or fewer bytes than the header says.
    #[error("{path}: {got} bytes of numbers, but the header says {want}")]
    #[diagnostic(help("the file was cut short or added to: write it anew"))]
    Length {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Bytes after the header.
        got: u64,
        /// Bytes that the header promises.
        want: u128,
    },

    /// Frames without pixels.
    #[error("{path}: frames of {size} have no pixels")]
    #[diagnostic(help("width and height must be at least 1"))]
    NoPixels {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Their size.
        size: Size,
    },

    /// Frames larger than any sensor.
    #[error("{path}: frames of {size} are larger than {most} pixels, or 65536 a side")]
    #[diagnostic(help("is the header damaged? if not, scale the clip down first"))]
    TooLarge {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Their size.
        size: Size,
        /// The most pixels that are read.
        most: usize,
    },

    /// Frames that do not fit into the memory that there may be.
    #[error(transparent)]
    #[diagnostic(transparent)]
    NoRoom(#[from] TooMuch),

    /// More frames than any scene has.
    #[error("{path}: more than {most} frames")]
    #[diagnostic(help("cut the scene into shorter ones"))]
    TooManyFrames {
        /// Which file, folder or pattern.
        path: PathBuf,
        /// The most that are read.
        most: u64,
    },

    /// Frames that are drawn from few bytes, or none, and would never end.
    #[error("{path}: {frames} frames of {size} are more than {most} pixels in all")]
    #[diagnostic(help("make the frames fewer or smaller"))]
    TooLong {
        /// Which file or pattern.
        path: PathBuf,
        /// How many frames.
        frames: u64,
        /// Their size.
        size: Size,
        /// The most pixels that are drawn.
        most: u64,
    },

    /// A file that is read again is not what was read first.
    #[error(
        "the scene {path} changed while the sweep ran: the points were computed from its earlier content"
    )]
    #[diagnostic(help(
        "restore the scene and run the same command again, or run the new scene with another --output"
    ))]
    Changed {
        /// The file, or the picture of a folder.
        path: PathBuf,
    },

    /// A name that cannot be opened, since it is no text.
    #[error("{path}: this name is no UTF-8")]
    #[diagnostic(help("rename the file, or link to it"))]
    NotUtf8 {
        /// The file or folder of the scene.
        path: PathBuf,
    },

    /// Neither a file nor a folder.
    #[error("{path}: neither a file nor a folder")]
    #[diagnostic(help(
        "a scene is read twice, so it cannot be a pipe or device: write it into a file first"
    ))]
    NoFile {
        /// What it is called.
        path: PathBuf,
    },

    /// A name with a place for numbers or for anything, as ffmpeg and shells have it.
    #[error("{path}: there is no such file, and patterns of file names are not expanded")]
    #[diagnostic(help("give the folder that the pictures are in, or one file"))]
    NoPattern {
        /// What it is called.
        path: PathBuf,
    },

    /// No frame rate in the file.
    #[error("{path}: the file does not say how many frames there are per second")]
    #[diagnostic(help("say it: --fps N"))]
    NoRate {
        /// The file or folder of the scene.
        path: PathBuf,
    },

    /// A frame rate that is no rate.
    #[error("{} frames per second is no rate", Shown(*fps))]
    #[diagnostic(help("give a number above 0, and at most {}, such as --fps 240", MOST_FPS))]
    BadRate {
        /// What was asked.
        fps: f64,
    },

    /// Frames that are not evenly spaced in time.
    #[error(
        "{path}: frame {frame}, at {seconds:.6} s, comes {gap:.6} s after the one before, where {usual:.6} s are usual"
    )]
    #[diagnostic(help(
        "frames must be evenly spaced: ffmpeg -i FILE -vf fps={0} -pix_fmt gray clip.y4m resamples them; --fps {0} shows all for equal times, which changes the speed of motion",
        frame_rate(usual.recip())
    ))]
    Uneven {
        /// The file or folder of the scene.
        path: PathBuf,
        /// The frame whose distance from the one before is furthest from the usual one.
        frame: u64,
        /// When it is, in seconds.
        seconds: f64,
        /// Its distance from the frame before, in seconds.
        gap: f64,
        /// The median distance, in seconds.
        usual: f64,
    },

    /// The file ends inside a frame.
    #[error("{path}: the file ends inside frame {frame}: {got} of {want} bytes")]
    #[diagnostic(help("the clip was cut short: copy or write it anew"))]
    Truncated {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Which frame.
        frame: u64,
        /// Bytes that are there.
        got: u64,
        /// Bytes of a whole frame.
        want: u64,
    },

    /// A PNM with something behind its picture.
    #[error(
        "{path}: behind its picture there {}",
        if *is_another { "is another picture" } else { "are bytes that are no part of it" }
    )]
    #[diagnostic(help(
        "one file is one picture: a folder of them is a clip (mkdir FRAMES; ffmpeg -f pgm_pipe -i FILE FRAMES/%06d.png); where it has one alone, write it anew"
    ))]
    Behind {
        /// The file.
        path: PathBuf,
        /// Whether that is another picture.
        is_another: bool,
    },

    /// Something else where a y4m frame should begin.
    #[error("{path}: frame {frame} begins with {got:?}, expected \"FRAME\"")]
    #[diagnostic(help("the clip is damaged or its header has the wrong size: write it anew"))]
    NoFrame {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Which frame.
        frame: u64,
        /// What stands there.
        got: String,
    },

    /// A frame of another size than the first.
    #[error("{path}: frame {frame} is {got}, the first is {want}")]
    #[diagnostic(help("all frames of a scene must have one size: scale or crop them first"))]
    OddSize {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Which frame.
        frame: u64,
        /// The size that was found.
        got: Size,
        /// The size of the first.
        want: Size,
    },

    /// Something other than a picture in a folder of pictures.
    #[error(
        "{path}: not a picture in a known format, and no file in a folder of pictures is skipped"
    )]
    #[diagnostic(help(
        "a folder may hold .png, .pgm, .ppm and .pnm pictures and hidden files: {}",
        way_out(path, *fps)
    ))]
    NotAPicture {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Frames per second, where the file is one that says so (`fps.txt`).
        fps: Option<f64>,
    },

    /// A picture or animation that cannot be decoded.
    #[error("{path}: frame {frame} cannot be decoded: {cause}")]
    #[diagnostic(help("the file is damaged or cut short: copy or write it anew"))]
    Picture {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Which frame.
        frame: u64,
        /// What the decoder said.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },

    /// Light that is not a finite number.
    #[error("{path}: frame {frame}, y {y}, x {x}: light is {value}, expected a finite number")]
    #[diagnostic(help("find where it comes from; in numpy: np.argwhere(~np.isfinite(a))"))]
    NotFinite {
        /// The file or folder of the scene.
        path: PathBuf,
        /// Which frame.
        frame: u64,
        /// Row of the pixel, from 0 at the top.
        y: usize,
        /// Column of the pixel, from 0 on the left.
        x: usize,
        /// The value.
        value: f64,
    },

    /// This build cannot read mp4.
    #[error("{path}: this build cannot read mp4 (it was made without the feature \"mp4\")")]
    #[diagnostic(help("build with --features mp4, or: ffmpeg -i FILE -pix_fmt gray clip.y4m"))]
    NoMp4 {
        /// The file or folder of the scene.
        path: PathBuf,
    },

    /// An mp4 that ends before the table of its frames.
    #[error(
        "{path}: the file ends early, at byte {length} of at least {end}: {what} begins at byte {start} and is cut off, and no table of its frames (moov) is whole"
    )]
    #[diagnostic(help(
        "copy or download it again, or finish the recording: without that table nothing can be read"
    ))]
    EndsEarly {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        length: u64,
        /// How many it should have, at least.
        end: u64,
        /// Where the box begins that is cut off.
        start: u64,
        /// What it is called.
        what: String,
    },

    /// An mp4 that is damaged, or not H.264 in 8 or 10 bits.
    #[error("{path}: {what}")]
    #[diagnostic(help(
        "only progressive H.264 in 8 or 10 bits, grey, 4:2:0 or 4:2:2, is read from mp4; anything else: ffmpeg -i FILE -pix_fmt gray clip.y4m (interlaced video with -vf yadif)"
    ))]
    Mp4 {
        /// The file or folder of the scene.
        path: PathBuf,
        /// What was wrong with it.
        what: String,
    },

    /// No pattern of that name.
    #[error("pattern:{got}: there is no pattern {got:?}")]
    #[diagnostic(help("{near}known: {known}"))]
    UnknownPattern {
        /// The name given.
        got: String,
        /// All names.
        known: String,
        /// Which of them was meant, if one is near: a question.
        near: String,
    },

    /// No parameter of that name.
    #[error("pattern:{pattern}: there is no parameter {got:?}")]
    #[diagnostic(help("{near}known, with their defaults: {known}"))]
    UnknownParameter {
        /// Which pattern.
        pattern: String,
        /// The key given.
        got: String,
        /// All keys with their defaults.
        known: String,
        /// Which of them was meant, if one is near: a question.
        near: String,
    },

    /// A parameter with a value that it cannot have.
    #[error("pattern:{pattern}: {given}: expected {want}")]
    #[diagnostic(help("write pattern:{pattern}?key=value&key=value; {default}"))]
    Parameter {
        /// Which pattern.
        pattern: String,
        /// The parameter and its value, as given.
        given: String,
        /// What it may be.
        want: String,
        /// What it is when not given.
        default: String,
    },

    /// Two frames too far apart to be bridged.
    #[error("more than {most} steps between source frames {pair} and {}", pair + 1)]
    #[diagnostic(help(
        "give a larger contrast per step (`--upsample`, or `upsample` in a study), such as 0.1; in the library also a larger offset, or more steps"
    ))]
    TooManySteps {
        /// The first of the two frames.
        pair: u64,
        /// The most steps allowed.
        most: u32,
    },

    /// More frames than there may be in all.
    #[error("upsampling needs more than {most} frames up to source frame {frame}")]
    #[diagnostic(help(
        "give a larger contrast per step (`--upsample`, or `upsample` in a study), such as 0.1, or a shorter clip; in the library also a larger offset"
    ))]
    Endless {
        /// The source frame that was to come next.
        frame: u64,
        /// The most frames in all.
        most: u64,
    },

    /// Light without a logarithm.
    #[error(
        "source frame {frame}, y {y}, x {x}: light {value} + offset {offset} is not above 0, so it has no logarithm"
    )]
    #[diagnostic(help("give a larger offset, or bound the steps in light instead of in contrast"))]
    NoLogarithm {
        /// Which frame.
        frame: u64,
        /// Row of the pixel, from 0 at the top.
        y: usize,
        /// Column of the pixel, from 0 on the left.
        x: usize,
        /// The light there.
        value: f64,
        /// What is added to it.
        offset: f64,
    },

    /// Samples cannot be what the caller says.
    #[error("{path}: {what}")]
    #[diagnostic(help("{help}"))]
    Coding {
        /// The scene.
        path: PathBuf,
        /// What was asked for.
        what: String,
        /// What to do.
        help: &'static str,
    },

    /// A bound of the upsampling that bounds nothing.
    #[error("upsampling: {name} is {got}, expected {want}")]
    #[diagnostic(help(
        "give a contrast (`--upsample`, or `upsample` in a study) such as 0.1, which suits 8-bit video; in the library also an offset, such as 1"
    ))]
    BadBound {
        /// Which setting.
        name: &'static str,
        /// Its value.
        got: f64,
        /// What it may be.
        want: &'static str,
    },

    /// A slice in which no frame is.
    #[error(
        "the slice {slice} holds no frame: the scene has {} at {} frames/s",
        frames.map_or_else(|| "frames before and after it,".to_owned(), |all| counted(all, "frame")),
        frame_rate(*fps)
    )]
    #[diagnostic(help(
        "give a slice of the scene: in times, such as 1s..2.5s, or in numbers of frames from 0, such as 10..50"
    ))]
    EmptySlice {
        /// The slice, as it is written.
        slice: String,
        /// Frames of the scene; none where it goes on behind the slice.
        frames: Option<u64>,
        /// Frames per second of the scene.
        fps: f64,
    },

    /// A part that does not lie in the picture.
    #[error("the crop {crop} does not lie within pictures of {size}")]
    #[diagnostic(help(
        "give a part of the picture: WIDTHxHEIGHT in its middle, or WIDTHxHEIGHT+X+Y from its left and its top"
    ))]
    CropOutside {
        /// The part, as it is written.
        crop: String,
        /// The picture.
        size: Size,
    },

    /// Pixels that would become smaller.
    #[error("pictures of {from} cannot be enlarged to {size}")]
    #[diagnostic(help(
        "give a size that is not larger in either direction: pixels can be averaged, not invented"
    ))]
    Enlarged {
        /// The size that was asked for.
        size: Size,
        /// That of the pictures.
        from: Size,
    },
}

impl SceneError {
    /// The file at `path` cannot be read.
    pub(super) fn unreadable(path: impl Into<PathBuf>, cause: io::Error) -> Self {
        Self::Unreadable {
            path: path.into(),
            cause,
        }
    }
}

/// How a file of another kind becomes a scene.
fn way_in(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let text = match ending.to_str().unwrap_or_default() {
        "npz" => "an .npz holds arrays by name; in numpy: np.save('clip.npy', np.load(FILE)[NAME])",
        "tif" | "tiff" => {
            "of a TIFF of many pages, ffmpeg reads the first only; in Python: np.save('clip.npy', tifffile.imread(FILE))"
        }
        "yuv" | "raw" | "rgb" | "gray" => {
            "of raw video the size and the kind of pixels must be said: ffmpeg -f rawvideo -pix_fmt yuv420p -s WIDTHxHEIGHT -r FPS -i FILE -pix_fmt gray clip.y4m"
        }
        _ => "anything else: ffmpeg -i FILE -pix_fmt gray clip.y4m",
    };
    text.to_owned()
}

/// What other simulators put beside pictures: vid2e the first two, ESIM the last.
const TIMES: [&str; 3] = ["fps.txt", "timestamps.txt", "images.csv"];

/// What to do about a file in a folder of pictures that is none of those that are read.
fn way_out(path: &Path, fps: Option<f64>) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if TIMES.iter().any(|times| name.eq_ignore_ascii_case(times)) {
        let fps = fps.map_or("FPS".to_owned(), frame_rate);
        return format!(
            "times are not read from it, since pictures of a folder are evenly spaced: move it out, and give --fps {fps}"
        );
    }
    let ending = path.extension().unwrap_or_default();
    let known = [
        "jpg", "jpeg", "bmp", "tif", "tiff", "webp", "exr", "jp2", "heic", "avif",
    ];
    if !known.iter().any(|kind| ending.eq_ignore_ascii_case(kind)) {
        return "move this one out".to_owned();
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    format!(
        "of .{0} pictures make a clip: ffmpeg -framerate FPS -pattern_type glob -i '{1}/*.{0}' -pix_fmt gray clip.y4m",
        ending.display(),
        folder.display()
    )
}

/// How an array of other axes becomes a clip.
fn three_axes(shape: &[u64]) -> &'static str {
    match shape {
        [_, _] => "one picture is a[None, :, :]",
        [_, _, _, 1] => "a clip of one channel is a[..., 0]",
        [_, _, _, 3] => {
            "gray of a clip of colour is a @ [0.299, 0.587, 0.114] (RGB; Rec. 601, as other scenes)"
        }
        [_, _, _, 4] => "gray of a clip of colour is a[..., :3] @ [0.299, 0.587, 0.114] (RGB)",
        [_, 3, _, _] => {
            "gray of a clip of colour is np.tensordot(a, [0.299, 0.587, 0.114], (1, 0)) (RGB; Rec. 601, as other scenes)"
        }
        _ => "one picture is a[None, :, :]; a clip of colour needs gray first",
    }
}

/// The ending of a file name, as the user would say it.
fn kind(path: &Path) -> String {
    match path.extension() {
        Some(ending) => format!(".{}", ending.display()),
        None => "a file without an ending".into(),
    }
}

fn join(shape: &[u64]) -> String {
    let words: Vec<_> = shape.iter().map(u64::to_string).collect();
    words.join(", ")
}

/// How the lines of interlaced video are taken apart.
fn apart(got: &str) -> &'static str {
    if got == "m" {
        "ffmpeg reads no y4m of mixed frames: take the lines apart in the video that it was made from, ffmpeg -i VIDEO -vf yadif -pix_fmt gray clip.y4m"
    } else {
        "take the lines apart first: ffmpeg -i FILE -vf yadif -pix_fmt gray clip.y4m"
    }
}
