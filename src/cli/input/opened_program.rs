//! The one door through which verbs read a program: file, chip, constants.

use std::path::Path;

use miette::miette;

use crate::{
    array::Register,
    bundled::Kind,
    cli::{
        complain,
        list::{bundled, meant},
        output::files::{Input, Named},
    },
    config::on_one_line,
    isa::{Device, Figure},
    program::{
        Expansion, Overrides, Program, Runnable, Syntax, included_files, is_cpp, vendor_text,
    },
    source,
};

/// Which program, on which chip.
#[derive(Debug, Default, clap::Args)]
pub struct Source {
    /// Program file, or a name that `amacrine list programs` prints; bare statements are a whole
    /// program
    program: Input,
    /// Name of a shipped chip, or folder of your own [default: as the program's settings say]
    #[arg(long)]
    chip: Option<Named>,
    /// Constant of the program to set; may be repeated
    #[arg(long = "const", value_name = "NAME=VALUE", value_parser = constant)]
    constants: Vec<(String, f64)>,
}

/// A program, and what it became on a chip.
pub struct Opened {
    pub program: Program,
    pub device: Device,
    /// What it became; nothing where its host decides.
    pub expansion: Expansion,
    /// Whether its host decides in the run, beside the array, what the array does.
    pub decides: bool,
    /// The constants that were set.
    pub overrides: Overrides,
}

impl Opened {
    /// That there is nothing in a program, where there is not.
    pub fn nothing(&self) -> Option<String> {
        let code = &self.expansion.code;
        let is_empty = !self.decides && code.init.is_empty() && code.frame.is_empty();
        is_empty.then(|| {
            format!(
                "{}: no statement is in it, and no word runs",
                self.program.file
            )
        })
    }

    /// Shows the warnings of its expansion.
    fn warn(&self) {
        if let Some(nothing) = self.nothing() {
            complain(&format!("warning: {nothing}\n"));
        }
        if let Some(warnings) = self.program.warnings(&self.expansion) {
            complain(&format!("{:?}\n", miette!(warnings)));
        }
    }
}

/// `name=value`, for the command line.
pub(in crate::cli) fn constant(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}` is not NAME=VALUE"))?;
    let value = value
        .trim()
        .parse()
        .map_err(|_| format!("`{value}` is not a number"))?;
    Ok((name.trim().to_owned(), value))
}

impl Source {
    /// A program on a chip, with constants.
    pub const fn new(program: Input, chip: Option<Named>, constants: Vec<(String, f64)>) -> Self {
        Self {
            program,
            chip,
            constants,
        }
    }

    /// Whether it is the program as it is written: on its own chip, with its own constants.
    pub const fn is_as_written(&self) -> bool {
        self.chip.is_none() && self.constants.is_empty()
    }

    /// The program's words as text, below the lines of a head that they need: the chip, where it is
    /// not the one that is meant without, and the names of the kinds.
    pub fn words(&self, opened: &Opened) -> String {
        let settings = &opened.program.settings;
        let chip = self.chip.as_deref().or(settings.chip.as_deref());
        let chip = chip.filter(|chip| *chip != "scamp5");
        let chip = chip.map(|chip| format!("//! chip = {}\n", on_one_line(chip)));
        let Expansion { code, bare, .. } = &opened.expansion;
        [
            chip.unwrap_or_default(),
            settings.names_line(),
            vendor_text(code, *bare, &opened.device),
        ]
        .concat()
    }

    /// The folder that the program's own paths are relative to.
    pub fn folder(&self) -> &Path {
        self.program.parent().unwrap_or(Path::new(""))
    }

    /// Reads the text, whatever is wrong with it.
    pub fn read(&self) -> miette::Result<Program> {
        if let Some(file) = bundled(Kind::Program, &self.program) {
            return Ok(Program::read(&file.path(), file.text));
        }
        let file = self.program.display().to_string();
        let help = "give the path of a program, or a name that `amacrine list programs` prints";
        let help = meant(Kind::Program, &self.program, help);
        let text = if is_cpp(&file) {
            source::code(&self.program, &help)?
        } else {
            source::text(&self.program, &help)?
        };
        let includes = included_files(&text, self.folder());
        Ok(Program::read_with(&file, &text, &includes))
    }

    /// The program in canonical form, on its chip, with the constants that are set.
    /// Vendor C++ is run for that; its warnings are shown.
    pub fn canonical(&self) -> miette::Result<Syntax> {
        let program = self.read()?;
        if !program.is_vendor() {
            let unused = [
                self.chip.as_ref().map(|_| "chip"),
                self.constants.first().map(|_| "const"),
            ];
            if let Some(option) = unused.into_iter().flatten().next() {
                return Err(miette!(
                    help = format!("leave --{option} out"),
                    "--{option} has no effect with --format: {} is printed as it is written",
                    program.file
                ));
            }
            return Ok(Program::parse(&program.file, &program.text)?.syntax);
        }
        let opened = self.open(&[])?;
        Ok(opened
            .program
            .canonical(&opened.device, &self.overrides())?)
    }

    /// Reads the program and expands it on its chip, some of whose numbers may be others.
    /// Warnings are shown.
    pub fn open(&self, figures: &[(Figure, f64)]) -> miette::Result<Opened> {
        self.open_with(figures, &[])
    }

    /// As [`Source::open`], with more constants.
    pub fn open_with(
        &self,
        figures: &[(Figure, f64)],
        constants: &[(String, f64)],
    ) -> miette::Result<Opened> {
        let (program, device, overrides) = self.on_chip(figures, constants)?;
        let expansion = program.expand(&device, &overrides)?;
        let opened = Opened {
            program,
            device,
            expansion,
            decides: false,
            overrides,
        };
        opened.warn();
        Ok(opened)
    }

    /// As [`Source::open_with`], for whoever can run a program with its host beside the array: one
    /// whose host decides there what the array does, or any of vendor C++ if it is asked for.
    /// `before` takes the steps that are known before the run, where there are any; registers of the
    /// names in `set` are written before it.
    pub fn open_to_run(
        &self,
        figures: &[(Figure, f64)],
        constants: &[(String, f64)],
        set: &[&str],
        (host, before): (bool, bool),
    ) -> miette::Result<Opened> {
        let (program, device, overrides) = self.on_chip(figures, constants)?;
        if host && !program.is_vendor() {
            return Err(miette!(
                help = "leave --host out",
                "{}: --host is for vendor C++, and this is a program of the frame language",
                program.file
            ));
        }
        let Runnable { expansion, decides } = program.layout(&device, &overrides)?;
        let decides = decides && !(before && expansion.is_some());
        let mut expansion = expansion.unwrap_or_default();
        let set = set.iter().map(|name| Register::named_to_set(&device, name));
        let set: Vec<Register> = set.collect::<Result<_, _>>()?;
        expansion.drop_unwritten(&device, |cell| set.contains(&Register::from(*cell)));
        let opened = Opened {
            program,
            device,
            expansion,
            decides,
            overrides,
        };
        if !decides {
            opened.warn();
        }
        Ok(Opened {
            decides: decides || host,
            ..opened
        })
    }

    /// The program, its chip, and all constants.
    fn on_chip(
        &self,
        figures: &[(Figure, f64)],
        constants: &[(String, f64)],
    ) -> miette::Result<(Program, Device, Overrides)> {
        let program = self.read()?;
        let mut device = match (self.chip.as_deref(), program.settings.chip.as_deref()) {
            (Some(chip), _) => Device::find(chip)?,
            (None, Some(chip)) => Device::find_for(chip, &program.file, self.folder())?,
            (None, None) => Device::scamp5(),
        };
        for (figure, value) in figures {
            device = device.what_if(*figure, *value)?;
        }
        let given = || self.constants.iter().chain(constants).map(|(name, _)| name);
        if let Some((_, twice)) =
            { given().enumerate() }.find(|(n, name)| given().take(*n).any(|other| other == *name))
        {
            return Err(miette!(
                help = "give each constant once",
                "the constant `{twice}` is set twice"
            ));
        }
        let mut overrides = self.overrides();
        overrides.extend(constants.iter().cloned());
        Ok((program, device, overrides))
    }

    /// The constants that are set.
    pub fn overrides(&self) -> Overrides {
        self.constants.iter().cloned().collect()
    }
}
