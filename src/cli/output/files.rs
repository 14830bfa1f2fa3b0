//! The files of one command: what it reads, what it writes, and that these are not the same.
//!
//! A verb's arguments are [`Input`], [`Named`] and [`Output`], never plain paths, so that
//! `check` finds them all before the verb begins. What is only known later (a kernel that a
//! sensor file names, one file for each kind) goes through `reads` and `writes`.

use std::{
    ffi::OsStr,
    fmt, fs, io,
    ops::Deref,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use clap::{
    Arg, ArgMatches, Command,
    builder::{
        MapValueParser, PathBufValueParser, TryMapValueParser, TypedValueParser, ValueParserFactory,
    },
};
use miette::miette;
use serde::{Serialize, Serializer};

use super::{content::Content, print};
use crate::{
    event::{
        Dropped, Packet,
        file::{self, Compression, FileError, Format, Head, Writer},
    },
    isa::Device,
    picture::{Drawing, raster, unknown_letters, write_png, write_svg},
    save::{self, OutputKind, SaveError},
    scene,
    unit::counted,
};

/// A file or a folder that is read.
#[derive(Clone, Debug, Default)]
pub struct Input(PathBuf);

/// What is read and is not always a file: a pattern, the name of a kernel, a chip, a readout.
/// Where it is a path, its name is UTF-8.
#[derive(Clone, Debug)]
pub struct Named(String);

/// What is written, and what will be in it; `-` is standard output.
#[derive(Clone, Debug)]
pub struct Output {
    path: PathBuf,
    content: Content,
}

impl Deref for Input {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Deref for Named {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl Deref for Output {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

impl AsRef<Path> for Input {
    fn as_ref(&self) -> &Path {
        self
    }
}

impl AsRef<Path> for Output {
    fn as_ref(&self) -> &Path {
        self
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

// With --json, names that are no UTF-8 have been refused.
impl Serialize for Input {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0.display())
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl Serialize for Output {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.path.display())
    }
}

impl ValueParserFactory for Input {
    type Parser = MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

    fn value_parser() -> Self::Parser {
        PathBufValueParser::new().map(Self)
    }
}

impl ValueParserFactory for Named {
    type Parser = TryMapValueParser<PathBufValueParser, fn(PathBuf) -> Result<Self, String>>;

    fn value_parser() -> Self::Parser {
        PathBufValueParser::new().try_map(|path| {
            let text = path.into_os_string().into_string();
            text.map(Self)
                .map_err(|_| "this name is no UTF-8: rename the file, or link to it".to_owned())
        })
    }
}

/// The parser of an output's name: `#[arg(value_parser = Content::Events)]`.
impl TypedValueParser for Content {
    type Value = Output;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Output, clap::Error> {
        let path = PathBufValueParser::new().parse_ref(command, argument, value)?;
        Ok(Output::new(path, *self))
    }
}

impl Output {
    fn new(path: PathBuf, content: Content) -> Self {
        let path = if path == Path::new("-") {
            save::STDOUT.into()
        } else {
            path
        };
        Self { path, content }
    }

    /// An output that a verb hears of while it runs, checked.
    pub(in crate::cli) fn late(path: &Path, content: Content) -> miette::Result<Self> {
        let output = Self::new(path.to_owned(), content);
        output.check_ending(&output.kind()?)?;
        let files = files();
        files.check_written(&output.path, &Id::of_written(&output.path)?)?;
        Ok(output)
    }

    /// What it is, where it is not a folder to be filled.
    fn kind(&self) -> miette::Result<OutputKind> {
        let kind = save::output_kind(&self.path);
        let bytes = self.path.as_os_str().as_encoded_bytes();
        let slash = { bytes.last() }.is_some_and(|&last| std::path::is_separator(last.into()));
        match kind {
            Ok(OutputKind::File { .. }) if slash => Err(io::ErrorKind::IsADirectory.into()),
            kind => kind,
        }
        .map_err(|cause| self.cannot(cause).into())
    }

    fn cannot(&self, cause: io::Error) -> SaveError {
        let path = self.path.clone();
        SaveError { path, cause }
    }

    /// Whether it is written through, so that its name need not say what is in it.
    pub(in crate::cli) fn is_node(&self) -> bool {
        !matches!(save::output_kind(&self.path), Ok(OutputKind::File { .. }))
    }

    /// The ending that says what is written, in small letters.
    pub(in crate::cli) fn ending(&self) -> &'static str {
        let endings = self.content.endings();
        let own = self.path.extension().unwrap_or_default();
        let own = endings
            .iter()
            .find(|ending| own.eq_ignore_ascii_case(ending));
        own.or(endings.first()).copied().unwrap_or_default()
    }

    /// The format of events.
    pub(in crate::cli) fn format(&self) -> Result<Format, FileError> {
        match Format::from_path(&self.path) {
            Err(_) if self.is_node() => Ok(Content::STREAM),
            format => format,
        }
    }

    /// The formats of events that the name may mean, if it means any.
    pub(in crate::cli) fn says(&self) -> Option<Vec<Format>> {
        let said = Format::named(&self.path);
        (!said.is_empty()).then_some(said)
    }

    /// A file of events, written as they come.
    pub(super) fn writer(&self, head: &Head) -> Result<Writer, FileError> {
        Writer::create(&self.path, self.format()?, Compression::default(), head)
    }

    /// Writes events.
    pub(in crate::cli) fn write(&self, packet: &Packet) -> Result<(), FileError> {
        let compression = Compression::default();
        file::write_as(&self.path, self.format()?, compression, packet)?;
        self.warn_of_drops(packet.dropped)
    }

    /// Says what was lost on the way to this file of events, where the file cannot.
    pub(super) fn warn_of_drops(&self, dropped: Dropped) -> Result<(), FileError> {
        if let Some(note) = untold(dropped, self.format()?) {
            super::print::complain(&format!("warning: {}: {note}\n", self.display()));
        }
        Ok(())
    }

    /// Writes a drawing.
    pub(in crate::cli) fn draw(&self, drawing: &Drawing) -> Result<(), SaveError> {
        if self.ending() == "svg" {
            write_svg(&self.path, drawing)
        } else {
            self.warn_of(&unknown_letters(drawing.texts()), "; an .svg has all");
            write_png(&self.path, &raster(drawing, 2))
        }
    }

    /// Says that a picture of pixels has a question mark in place of a letter of its texts, where it
    /// has.
    pub(in crate::cli) fn warn_of_letters<'a>(&self, texts: impl IntoIterator<Item = &'a str>) {
        self.warn_of(&unknown_letters(texts), "");
    }

    fn warn_of(&self, letters: &[char], or: &str) {
        /// Of more letters only the number is told.
        const TOLD: usize = 8;
        let (told, more) = letters.split_at(letters.len().min(TOLD));
        let told: Vec<String> = told.iter().map(|letter| format!("`{letter}`")).collect();
        let who = match (&told[..], more.len()) {
            ([], _) => return,
            ([one], 0) => format!("{one} is"),
            (told, 0) => format!("{} are", told.join(", ")),
            (told, more) => format!("{} and {more} more are", told.join(", ")),
        };
        super::print::complain(&format!(
            "warning: {}: {who} drawn as ?: the typeface of pictures has Latin letters{or}\n",
            self.path.display()
        ));
    }

    /// Refuses a name that says something else than what will be in it.
    fn check_ending(&self, kind: &OutputKind) -> miette::Result<()> {
        if self.content == Content::Events {
            self.format()?;
        }
        let endings = self.content.endings();
        let own = self.path.extension().unwrap_or_default();
        let fits = endings
            .iter()
            .any(|ending| own.eq_ignore_ascii_case(ending));
        if fits || endings.is_empty() || !matches!(kind, OutputKind::File { .. }) {
            return Ok(());
        }
        let known: Vec<_> = endings.iter().map(|e| format!(".{e}")).collect();
        let known = match known.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, others)) => format!("{} or {last}", others.join(", ")),
            None => String::new(),
        };
        let found = match own.to_string_lossy() {
            own if own.is_empty() => "has no ending".to_owned(),
            own => format!("ends in `.{own}`"),
        };
        Err(miette!(
            help = format!("give a name that ends in {known}"),
            "{} {found}: {} is written as {known}",
            self.path.display(),
            self.content.name()
        ))
    }
}

/// What a file of this format does not say of what was lost before it.
pub(in crate::cli) fn untold(dropped: Dropped, format: Format) -> Option<String> {
    (dropped.total() > 0 && !format.has_remarks()).then(|| {
        let lost = counted(dropped.total(), "event");
        format!("{lost} lost on the way to this file: {format} has no room to say so, npy has")
    })
}

/// What makes two names the same thing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Id {
    /// Something that is there: device and inode.
    #[cfg_attr(not(unix), expect(dead_code))]
    There(u64, u64),
    /// A file that is not there yet: its whole name.
    New(PathBuf),
    /// Standard output, a pipe or a terminal.
    Stdout,
    /// What may be written from several sides, such as `/dev/null`.
    Shared,
}

impl Id {
    /// That of a file that is read. Other things, and what is not there, have none.
    fn of_read(path: &Path) -> Option<Self> {
        let found = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        Some(Self::of_metadata(&found, path))
    }

    fn of_written(path: &Path) -> Result<Self, SaveError> {
        let cannot = |cause| SaveError {
            path: path.to_owned(),
            cause,
        };
        Ok(match save::output_kind(path).map_err(cannot)? {
            OutputKind::Stdout => Self::Stdout,
            OutputKind::Node => match fs::metadata(path) {
                Ok(found) if !is_character_device(&found) => Self::of_metadata(&found, path),
                _ => Self::Shared,
            },
            OutputKind::File { target } => match fs::metadata(&target) {
                Ok(found) => Self::of_metadata(&found, &target),
                Err(_) => Self::New(whole(&target).map_err(cannot)?),
            },
        })
    }

    #[cfg(unix)]
    fn of_metadata(found: &fs::Metadata, _: &Path) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::There(found.dev(), found.ino())
    }

    #[cfg(not(unix))]
    fn of_metadata(_: &fs::Metadata, path: &Path) -> Self {
        Self::New(fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()))
    }
}

#[cfg(unix)]
fn is_character_device(found: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_character_device(_: &fs::Metadata) -> bool {
    true
}

/// The whole name of a file that is not there, nor perhaps its folder.
fn whole(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::IsADirectory)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = match fs::metadata(folder) {
        Ok(found) if found.is_dir() => fs::canonicalize(folder)?,
        Ok(_) => return Err(io::ErrorKind::NotADirectory.into()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => whole(folder).or_else(|e| {
            // `new/..` is where `new` will be.
            match (folder.file_name(), folder.parent().and_then(Path::parent)) {
                (None, Some(above)) => whole(&above.join("x")).map(|mut x| {
                    x.pop();
                    x
                }),
                _ => Err(e),
            }
        })?,
        Err(e) => return Err(e),
    };
    Ok(folder.join(name))
}

/// What this command reads and writes, as far as that is known.
#[derive(Debug, Default)]
struct Files {
    read: Vec<(PathBuf, Id)>,
    written: Vec<(PathBuf, Id)>,
}

static FILES: Mutex<Files> = Mutex::new(Files {
    read: Vec::new(),
    written: Vec::new(),
});

/// Files that this command was to write and has not: what stands there is what stood there before. Where
/// the system does not number files, nothing is known of that.
pub(super) fn unwritten() -> Vec<String> {
    let files = files();
    let missing = files.written.iter().filter(|(path, id)| {
        let is_file = matches!(save::output_kind(path), Ok(OutputKind::File { .. }));
        cfg!(unix) && is_file && Id::of_written(path).is_ok_and(|now| now == *id)
    });
    missing
        .map(|(path, _)| path.display().to_string())
        .collect()
}

fn files() -> MutexGuard<'static, Files> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Files {
    /// Notes a file that is read, or each of a folder's.
    fn read(&mut self, path: &Path) -> miette::Result<()> {
        if let Some(image) = path.to_str().and_then(scene::image_of_pattern) {
            return self.read_file(Path::new(image));
        }
        if let Ok(entries) = fs::read_dir(path) {
            for entry in entries.flatten() {
                self.read_file(&entry.path())?;
            }
            return Ok(());
        }
        self.read_file(path)
    }

    fn read_file(&mut self, path: &Path) -> miette::Result<()> {
        let Some(id) = Id::of_read(path) else {
            return Ok(());
        };
        if let Some((output, _)) = self.written.iter().find(|(_, other)| *other == id) {
            return Err(both(path, output));
        }
        self.read.push((path.to_owned(), id));
        Ok(())
    }

    /// Notes what is written.
    fn write(&mut self, path: &Path) -> miette::Result<()> {
        let id = Id::of_written(path)?;
        self.check_written(path, &id)?;
        if let Some((other, _)) = self.written.iter().find(|(_, other)| *other == id)
            && id != Id::Shared
        {
            let shown = path.display();
            let message = if other == path {
                format!("{shown} is asked for twice")
            } else {
                format!("{shown} and {} are the same", other.display())
            };
            return Err(miette!(
                help = "give each output a name of its own",
                "{message}"
            ));
        }
        self.written.push((path.to_owned(), id));
        Ok(())
    }

    fn check_written(&self, path: &Path, id: &Id) -> miette::Result<()> {
        match self.read.iter().find(|(_, other)| other == id) {
            Some((input, _)) => Err(both(input, path)),
            None => Ok(()),
        }
    }
}

fn both(input: &Path, output: &Path) -> miette::Report {
    let (read, written) = (input.display(), output.display());
    let message = if input == output {
        format!("{read} is to be read and to be written")
    } else {
        format!("{written} is {read}, which is to be read")
    };
    miette!(
        help = "give what is written another name; nothing has been touched",
        "{message}"
    )
}

/// Notes a file, or a folder of files, that a verb reads by the word of another file.
///
/// # Errors
/// When it is one that is written.
pub(in crate::cli) fn reads(path: &Path) -> miette::Result<()> {
    files().read(path)
}

/// Notes files that a verb writes besides its outputs.
///
/// # Errors
/// When one of them is read, or two are the same, or one cannot be written.
pub(in crate::cli) fn writes<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
) -> miette::Result<()> {
    let mut files = files();
    paths.into_iter().try_for_each(|path| {
        files.write(path.as_ref())?;
        Ok(save::check_writable(path.as_ref())?)
    })
}

/// Looks at all files that a command names, before anything is read.
///
/// # Errors
/// When something that is written is also read, or is written twice, or has a name that says
/// something else, or cannot be written; or a name cannot stand in the JSON that is asked for.
pub(in crate::cli) fn check(command: &Command, matches: &ArgMatches) -> miette::Result<()> {
    if let Some((name, matches)) = matches.subcommand() {
        let verb = command.find_subcommand(name);
        return verb.map_or(Ok(()), |verb| check(verb, matches));
    }
    let ids = || {
        command
            .get_arguments()
            .map(|argument| argument.get_id().as_str())
    };
    let inputs: Vec<&Input> = ids().flat_map(|id| all(matches, id)).collect();
    let named: Vec<&Named> = ids().flat_map(|id| all(matches, id)).collect();
    let outputs: Vec<&Output> = ids().flat_map(|id| all(matches, id)).collect();
    let json = matches.try_get_one::<bool>("json");
    let json = json.ok().flatten().copied().unwrap_or(false);

    let paths = inputs.iter().map(|input| &input.0);
    let mut paths = paths.chain(outputs.iter().map(|output| &output.path));
    if let Some(path) = paths.find(|path| json && path.to_str().is_none()) {
        return Err(miette!(
            help = "rename the file, link to it, or leave --json out",
            "{}: JSON holds no name that is no UTF-8",
            path.display()
        ));
    }
    let mut files = files();
    files.written.extend(standard());
    for output in &outputs {
        match output.content {
            Content::Folder => {
                if fs::metadata(&output.path).is_ok_and(|found| !found.is_dir()) {
                    let cause = io::ErrorKind::NotADirectory.into();
                    return Err(output.cannot(cause).into());
                }
                continue;
            }
            // Whether this or others of its name are written is for the verb to say.
            Content::Converted => {}
            _ => {
                output.check_ending(&output.kind()?)?;
                files.write(&output.path)?;
            }
        }
        if output.kind()? == OutputKind::Stdout {
            if json {
                return Err(miette!(
                    help = "give the output a file, or leave --json out",
                    "standard output cannot take both an output and the JSON"
                ));
            }
            print::aside();
        }
    }
    for input in inputs {
        files.read(&input.0)?;
    }
    for name in named {
        files.read(Path::new(&name.0))?;
        for folder in Device::folders_extended(Path::new(&name.0)) {
            files.read(&folder)?;
        }
    }
    drop(files);
    check_apart(command, matches, &outputs)?;
    // `sweep --verify` reads its folder.
    let verifies = matches.try_contains_id("verify").unwrap_or(false);
    // Before the work, not behind it.
    for output in outputs {
        match output.content {
            Content::Folder if verifies => {}
            Content::Folder => save::check_folder_writable(&output.path)?,
            Content::Converted => {}
            _ => save::check_writable(&output.path)?,
        }
    }
    Ok(())
}

/// Refuses a picture, or a folder of them, in the folder of pictures that is the scene: it would be
/// shown as one of its frames.
fn check_apart(command: &Command, matches: &ArgMatches, outputs: &[&Output]) -> miette::Result<()> {
    let scenes = command.get_arguments().map(Arg::get_id);
    let scenes = scenes.filter(|id| matches!(id.as_str(), "scene" | "image"));
    for scene in scenes.flat_map(|id| all::<Named>(matches, id.as_str())) {
        let Ok(folder) = fs::canonicalize(&scene.0) else {
            continue;
        };
        if !folder.is_dir() {
            continue;
        }
        let lands = |output: &&&Output| {
            let at = match output.content {
                Content::Folder => Some(output.path.as_path()),
                Content::Converted => None,
                _ => output.path.parent(),
            };
            // A name alone lies here.
            let at = at.map(|at| {
                if at == Path::new("") {
                    Path::new(".")
                } else {
                    at
                }
            });
            at.and_then(|at| fs::canonicalize(at).ok())
                .is_some_and(|at| at == folder)
        };
        if let Some(output) = outputs.iter().find(lands) {
            return Err(miette!(
                help = "write it somewhere else; nothing has been touched",
                "{} lies in {}, whose pictures are the scene",
                output.path.display(),
                scene.0
            ));
        }
    }
    Ok(())
}

/// The values of one argument, if it is of this kind.
fn all<'a, T: Clone + Send + Sync + 'static>(
    matches: &'a ArgMatches,
    id: &str,
) -> impl Iterator<Item = &'a T> + use<'a, T> {
    let values = matches.try_get_many::<T>(id);
    values.ok().flatten().into_iter().flatten()
}

/// Standard output and standard error, where they are files: no output is to be one of them.
#[cfg(unix)]
fn standard() -> Vec<(PathBuf, Id)> {
    use std::os::fd::AsFd;
    let id = |fd: std::os::fd::BorrowedFd<'_>, name: &str| {
        let file = fs::File::from(fd.try_clone_to_owned().ok()?);
        let found = file.metadata().ok().filter(fs::Metadata::is_file)?;
        let path = PathBuf::from(name);
        Some((path.clone(), Id::of_metadata(&found, &path)))
    };
    let out = id(io::stdout().as_fd(), "standard output");
    let err = id(io::stderr().as_fd(), "standard error");
    out.into_iter().chain(err).collect()
}

#[cfg(not(unix))]
fn standard() -> Vec<(PathBuf, Id)> {
    Vec::new()
}
