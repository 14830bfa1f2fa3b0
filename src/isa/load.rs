//! Reading a chip: `device.toml`, `primitives.toml`, `macros.scamp`, and what it extends.
//!
//! The shipped chips are part of the program text, so that it runs anywhere; a folder on disk
//! is read when it is asked for. Every check says which file, which place, and what to do.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{Arc, LazyLock},
};

use serde::Deserialize;
use toml::Spanned;

use super::{
    Analog, Clock, Device, Digital, Evidence, Figure, HostKind, HostRow, Kind, Macro, Operand,
    PrimitiveRow, Quantity, Registers, Roles, Signature, Value, macros, row,
    signature::Parameter,
    text::{Fault, Faults, Place, nearest, suggestion, suggestion_or},
};

/// Why a chip cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LoadError {
    /// No such chip.
    #[error("there is no chip `{name}`")]
    #[diagnostic(help(
        "give the name of a shipped chip ({shipped}) or a folder that holds a device.toml"
    ))]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        shipped: String,
    },
    /// A file cannot be read.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(help(
        "a chip is a folder with device.toml, primitives.toml and macros.scamp; one that extends another needs device.toml alone"
    ))]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A file says something wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wrong(#[from] Faults),
}

/// The texts of one folder.
struct Folder {
    name: String,
    device: String,
    primitives: Option<String>,
    macros: Option<String>,
}

/// A shipped chip: name, `device.toml`, `primitives.toml`, `macros.scamp`.
type Shipped = (
    &'static str,
    &'static str,
    Option<&'static str>,
    Option<&'static str>,
);

const SHIPPED: &[Shipped] = &[
    (
        "scamp5",
        include_str!("../../isa/scamp5/device.toml"),
        Some(include_str!("../../isa/scamp5/primitives.toml")),
        Some(include_str!("../../isa/scamp5/macros.scamp")),
    ),
    (
        "scamp5-wide",
        include_str!("../../isa/scamp5-wide/device.toml"),
        None,
        None,
    ),
];

/// `a` extends `b` extends `c` …, at most.
const CHAIN: usize = 8;

impl Device {
    /// The chip itself: SCAMP-5.
    ///
    /// # Panics
    /// Never: a test loads every shipped chip.
    #[must_use]
    pub fn scamp5() -> Self {
        // Its files are parsed once.
        static SCAMP5: LazyLock<Device> =
            LazyLock::new(|| shipped("scamp5").expect("the shipped chip is checked by a test"));
        SCAMP5.clone()
    }

    /// Names of the shipped chips.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, ..)| *name)
    }

    /// A shipped chip by name, or any other from its folder.
    ///
    /// # Errors
    /// When there is no such chip, or its files are wrong.
    pub fn find(name: &str) -> Result<Self, LoadError> {
        if name == "scamp5" {
            return Ok(Self::scamp5());
        }
        if SHIPPED.iter().any(|(shipped, ..)| *shipped == name) {
            return shipped(name);
        }
        let folder = Path::new(name);
        if folder.is_dir() {
            return Self::load(folder);
        }
        Err(unknown(name))
    }

    /// A chip from its folder. What it `extends` is a folder beside it, or a shipped chip.
    ///
    /// # Errors
    /// When its files cannot be read or are wrong.
    pub fn load(folder: &Path) -> Result<Self, LoadError> {
        assemble(&layers(disk_folder(folder)?, folder.parent())?)
    }
}

fn shipped(name: &str) -> Result<Device, LoadError> {
    assemble(&layers(shipped_folder(name)?, None)?)
}

fn unknown(name: &str) -> LoadError {
    LoadError::Unknown {
        name: name.to_owned(),
        shipped: Device::shipped().collect::<Vec<_>>().join(", "),
    }
}

fn shipped_folder(name: &str) -> Result<Folder, LoadError> {
    let found = SHIPPED.iter().find(|(shipped, ..)| *shipped == name);
    let (name, device, primitives, macros) = found.ok_or_else(|| unknown(name))?;
    Ok(Folder {
        name: format!("isa/{name}"),
        device: (*device).to_owned(),
        primitives: primitives.map(str::to_owned),
        macros: macros.map(str::to_owned),
    })
}

fn disk_folder(folder: &Path) -> Result<Folder, LoadError> {
    let read = |file: &str| {
        let path = folder.join(file);
        fs::read_to_string(&path).map_err(|cause| LoadError::Unreadable { path, cause })
    };
    let maybe = |file: &str| {
        if folder.join(file).exists() {
            read(file).map(Some)
        } else {
            Ok(None)
        }
    };
    Ok(Folder {
        name: folder.display().to_string(),
        device: read("device.toml")?,
        primitives: maybe("primitives.toml")?,
        macros: maybe("macros.scamp")?,
    })
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DeviceFile {
    name: Spanned<String>,
    title: String,
    extends: Option<Spanned<String>>,
    registers: Option<RegistersFile>,
    #[serde(default)]
    figure: BTreeMap<Spanned<String>, BTreeMap<Spanned<String>, Spanned<Quantity>>>,
    #[serde(default)]
    host: Vec<HostFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistersFile {
    analogue: Option<Vec<Spanned<String>>>,
    news: Option<Spanned<String>>,
    digital: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    aliases: BTreeMap<Spanned<String>, Spanned<String>>,
    roles: Option<RolesFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RolesFile {
    mask: Spanned<String>,
    propagated: Spanned<String>,
    north: Spanned<String>,
    east: Spanned<String>,
    south: Spanned<String>,
    west: Spanned<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HostFile {
    name: Spanned<HostKind>,
    forms: Vec<Spanned<String>>,
    meaning: String,
    call: Spanned<Quantity>,
    item: Option<Spanned<Quantity>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PrimitivesFile {
    primitive: Vec<RowFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowFile {
    name: Spanned<Kind>,
    forms: Vec<Spanned<String>>,
    equation: String,
    words: Spanned<u64>,
    clock: Clock,
    source: String,
    evidence: Evidence,
}

/// One folder, read as TOML.
struct Layer {
    folder: Folder,
    device: DeviceFile,
    primitives: Vec<RowFile>,
}

impl Layer {
    fn wrong(&self, file: &str, faults: Vec<Fault>) -> Result<(), Faults> {
        let text = match file {
            "device.toml" => Some(&self.folder.device),
            "primitives.toml" => self.folder.primitives.as_ref(),
            _ => self.folder.macros.as_ref(),
        };
        let text = text.map_or("", String::as_str);
        Faults::check(&format!("{}/{file}", self.folder.name), text, faults)
    }
}

/// The chip's folder and those that it extends, the innermost first.
fn layers(top: Folder, beside: Option<&Path>) -> Result<Vec<Layer>, LoadError> {
    let mut layers = vec![layer(top)?];
    let mut beside = beside.map(Path::to_owned);
    loop {
        let last = &layers[layers.len() - 1];
        let Some(base) = last.device.extends.clone() else {
            break;
        };
        let name = base.get_ref();
        if layers.len() == CHAIN || layers.iter().any(|l| l.device.name.get_ref() == name) {
            let fault = Fault::error(
                base.span().into(),
                format!("`{name}` comes back to itself"),
                "this chip extends itself",
            )
            .help("a chip extends one that is complete without it");
            last.wrong("device.toml", vec![fault])?;
        }
        let on_disk = beside.as_ref().map(|b| b.join(name));
        let folder = match on_disk {
            Some(path) if path.join("device.toml").exists() => disk_folder(&path)?,
            _ if Device::shipped().any(|s| s == name) => {
                beside = None;
                shipped_folder(name)?
            }
            _ => {
                let fault = Fault::error(
                    base.span().into(),
                    format!("there is no chip `{name}` to extend"),
                    "neither a shipped chip nor a folder beside this one",
                )
                .help(suggestion_or(
                    name,
                    Device::shipped(),
                    "name a shipped chip, or a folder beside this one",
                ));
                last.wrong("device.toml", vec![fault])?;
                break;
            }
        };
        layers.push(layer(folder)?);
    }
    layers.reverse();
    Ok(layers)
}

fn layer(folder: Folder) -> Result<Layer, LoadError> {
    let device = from_toml(&format!("{}/device.toml", folder.name), &folder.device)?;
    let primitives = match &folder.primitives {
        Some(text) => {
            let file: PrimitivesFile =
                from_toml(&format!("{}/primitives.toml", folder.name), text)?;
            file.primitive
        }
        None => Vec::new(),
    };
    Ok(Layer {
        folder,
        device,
        primitives,
    })
}

/// TOML with a fault that has a place.
fn from_toml<T: serde::de::DeserializeOwned>(file: &str, text: &str) -> Result<T, Faults> {
    toml::from_str(text).map_err(|error| Faults::one(file, text, toml_fault(&error)))
}

/// What TOML said, as a fault.
pub(crate) fn toml_fault(error: &toml::de::Error) -> Fault {
    let place = error.span().map_or(Place::new(0, 0), Place::from);
    let message = error.message();
    // "unknown field `x`, expected one of `a`, `b`": the names are between backticks.
    let mut quoted = message.split('`').skip(1).step_by(2);
    let help = message
        .starts_with("unknown")
        .then(|| quoted.next().and_then(|name| nearest(name, quoted)))
        .flatten()
        .map(|near| format!("did you mean `{near}`?"));
    Fault::error(place, message, "here").help(help.unwrap_or_else(|| {
        "see isa/README.md or the shipped files for what can stand here".to_owned()
    }))
}

/// All checks, one after the other; each can rely on those before it.
fn assemble(layers: &[Layer]) -> Result<Device, LoadError> {
    let figures = figures(layers)?;
    let registers = registers(layers)?;
    let primitives = primitive_rows(layers)?;
    let hosts = host_rows(layers)?;
    let (macros, owners) = all_macros(layers)?;
    let (top, below) = (&layers[layers.len() - 1], &layers[..layers.len() - 1]);
    let base = if below.is_empty() {
        None
    } else {
        Some(Arc::new(assemble(below)?))
    };
    let device = Device {
        name: top.device.name.get_ref().clone(),
        title: top.device.title.clone(),
        registers,
        figures,
        primitives,
        hosts,
        macros,
        base,
    };
    for (at, layer) in layers.iter().enumerate() {
        let own = device.macros.iter().zip(&owners).filter(|(_, o)| **o == at);
        let faults = own.flat_map(|(it, _)| macros::check(&device, it)).collect();
        layer.wrong("macros.scamp", faults)?;
    }
    Ok(device)
}

fn figures(layers: &[Layer]) -> Result<Vec<Quantity>, Faults> {
    let mut found: BTreeMap<Figure, Quantity> = BTreeMap::new();
    for layer in layers {
        let mut faults = Vec::new();
        for (section, entries) in &layer.device.figure {
            for (key, entry) in entries {
                let figure = Figure::ALL
                    .iter()
                    .find(|f| f.key() == (section.get_ref(), key.get_ref()));
                let Some(&figure) = figure else {
                    let known: Vec<String> = Figure::ALL
                        .iter()
                        .map(|f| format!("{}.{}", f.key().0, f.key().1))
                        .collect();
                    let name = format!("{}.{}", section.get_ref(), key.get_ref());
                    faults.push(
                        Fault::error(
                            key.span().into(),
                            format!("unknown figure `{name}`"),
                            "this key",
                        )
                        .help(
                            suggestion(&name, known.iter().map(String::as_str))
                                .unwrap_or_else(|| format!("known are {}", known.join(", "))),
                        ),
                    );
                    continue;
                };
                if let Some(fault) = wrong_quantity(figure, entry) {
                    faults.push(fault);
                }
                found.insert(figure, entry.get_ref().clone());
            }
        }
        layer.wrong("device.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    let missing: Vec<String> = Figure::ALL
        .iter()
        .filter(|figure| !found.contains_key(figure))
        .map(|figure| format!("{}.{} ({})", figure.key().0, figure.key().1, figure.unit()))
        .collect();
    if !missing.is_empty() {
        faults.push(
            Fault::error(
                top.device.name.span().into(),
                format!(
                    "{} figures are missing: {}",
                    missing.len(),
                    missing.join(", ")
                ),
                "this chip",
            )
            .help("state each under [figure.<section>], or extend a chip that does"),
        );
    }
    if let (Some(low), Some(high)) = (found.get(&Figure::Lowest), found.get(&Figure::Highest))
        && low.value >= high.value
    {
        faults.push(
            Fault::error(
                top.device.name.span().into(),
                format!(
                    "range.low ({}) is not below range.high ({})",
                    low.value, high.value
                ),
                "this chip",
            )
            .help("swap them"),
        );
    }
    top.wrong("device.toml", faults)?;
    Ok(found.into_values().collect())
}

fn wrong_quantity(figure: Figure, entry: &Spanned<Quantity>) -> Option<Fault> {
    let Quantity {
        value,
        unit,
        source,
        ..
    } = entry.get_ref();
    let (section, key) = figure.key();
    let wrong = if unit != figure.unit() {
        format!(
            "`{section}.{key}` is stated in `{}`, not in `{unit}`",
            figure.unit()
        )
    } else if !figure.domain().holds(*value) {
        format!(
            "`{section}.{key}` is {}, not {value}",
            figure.domain().expected()
        )
    } else if source.trim().is_empty() {
        format!("`{section}.{key}` has no source")
    } else {
        return None;
    };
    Some(
        Fault::error(entry.span().into(), wrong, "this figure").help(
            "write { value = …, unit = …, source = …, evidence = measured|quoted|modelled|guess }",
        ),
    )
}

fn registers(layers: &[Layer]) -> Result<Registers, Faults> {
    let top = &layers[layers.len() - 1];
    let parts = || {
        layers
            .iter()
            .rev()
            .filter_map(|l| l.device.registers.as_ref())
    };
    let missing = |what: &str| -> Result<Registers, Faults> {
        let fault = Fault::error(
            top.device.name.span().into(),
            format!("`registers.{what}` is missing"),
            "this chip",
        )
        .help("state it, or extend a chip that does");
        Err(Faults::one(
            &format!("{}/device.toml", top.folder.name),
            &top.folder.device,
            fault,
        ))
    };
    let Some(analog) = parts().find_map(|r| r.analogue.as_ref()) else {
        return missing("analogue");
    };
    let Some(digital) = parts().find_map(|r| r.digital.as_ref()) else {
        return missing("digital");
    };
    let Some(news) = parts().find_map(|r| r.news.as_ref()) else {
        return missing("news");
    };
    let Some(roles) = parts().find_map(|r| r.roles.as_ref()) else {
        return missing("roles");
    };
    let mut faults = wrong_lists(top, analog, digital);
    let mut find = |list: &[Spanned<String>], name: &Spanned<String>, what: &str| -> u8 {
        let at = list.iter().position(|n| n.get_ref() == name.get_ref());
        if at.is_none() {
            let names = list.iter().map(|n| n.get_ref().as_str());
            faults.push(
                Fault::error(
                    name.span().into(),
                    format!("`{}` is not {what} register", name.get_ref()),
                    "this name",
                )
                .help(suggestion_or(name.get_ref(), names, "name one of the list")),
            );
        }
        at.unwrap_or(0) as u8
    };
    let news = Analog(find(analog, news, "an analogue"));
    let mut bit = |name: &Spanned<String>| Digital(find(digital, name, "a one-bit"));
    let roles = Roles {
        mask: bit(&roles.mask),
        propagated: bit(&roles.propagated),
        enable: [
            bit(&roles.north),
            bit(&roles.east),
            bit(&roles.south),
            bit(&roles.west),
        ],
    };
    let mut aliases: Vec<(String, Digital)> = Vec::new();
    for part in parts() {
        for (alias, name) in &part.aliases {
            if !aliases.iter().any(|(known, _)| known == alias.get_ref()) {
                aliases.push((alias.get_ref().clone(), bit(name)));
            }
        }
    }
    let owner = layers.iter().rev().find(|l| l.device.registers.is_some());
    owner.unwrap_or(top).wrong("device.toml", faults)?;
    let plain = |list: &[Spanned<String>]| list.iter().map(|n| n.get_ref().clone()).collect();
    Ok(Registers {
        analog: plain(analog),
        news,
        digital: plain(digital),
        aliases,
        roles,
    })
}

/// Names that stand twice, and lists that are empty or too long.
fn wrong_lists(top: &Layer, analog: &[Spanned<String>], digital: &[Spanned<String>]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for name in analog.iter().chain(digital) {
        if seen.contains(&name.get_ref().as_str()) {
            faults.push(
                Fault::error(
                    name.span().into(),
                    format!("two registers are called `{}`", name.get_ref()),
                    "the second",
                )
                .help("every register has a name of its own"),
            );
        }
        seen.push(name.get_ref());
    }
    for (what, list) in [("analogue", analog), ("one-bit", digital)] {
        if list.is_empty() || list.len() > 64 {
            faults.push(
                Fault::error(
                    top.device.name.span().into(),
                    format!("{} {what} registers; there can be 1 to 64", list.len()),
                    "this chip",
                )
                .help("list their names"),
            );
        }
    }
    faults
}

/// Parses the forms of a row.
fn forms(
    list: &[Spanned<String>],
    faults: &mut Vec<Fault>,
    fits: impl Fn(&Signature) -> bool,
) -> Vec<Signature> {
    let mut parsed = Vec::new();
    for form in list {
        match Signature::parse(form.get_ref()) {
            Ok(signature) if fits(&signature) => parsed.push(signature),
            Ok(signature) => faults.push(
                Fault::error(
                    form.span().into(),
                    format!("the instruction cannot be made from `{signature}`"),
                    "this form",
                )
                .help("keep the parameters of the shipped row"),
            ),
            Err(fault) => faults.push(Fault {
                place: form.span().into(),
                ..fault
            }),
        }
    }
    parsed
}

fn primitive_rows(layers: &[Layer]) -> Result<Vec<PrimitiveRow>, Faults> {
    let mut rows: BTreeMap<Kind, PrimitiveRow> = BTreeMap::new();
    for layer in layers {
        let mut faults = Vec::new();
        for row in &layer.primitives {
            let kind = *row.name.get_ref();
            let built = PrimitiveRow {
                kind,
                forms: forms(&row.forms, &mut faults, |form| can_be_built(kind, form)),
                equation: row.equation.clone(),
                words: *row.words.get_ref(),
                clock: row.clock,
                source: row.source.clone(),
                evidence: row.evidence,
            };
            if !(1..=64).contains(&built.words) {
                faults.push(
                    Fault::error(
                        row.words.span().into(),
                        format!("a primitive takes 1 to 64 words, not {}", built.words),
                        "here",
                    )
                    .help("one word is the rule"),
                );
            }
            rows.insert(kind, built);
        }
        layer.wrong("primitives.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    for kind in Kind::ALL {
        if !rows.contains_key(kind) {
            faults.push(
                Fault::error(
                    top.device.name.span().into(),
                    format!("the primitive {kind:?} has no row"),
                    "this chip",
                )
                .help("write it into primitives.toml, or extend a chip that has it"),
            );
        }
    }
    top.wrong("device.toml", faults)?;
    Ok(rows.into_values().collect())
}

fn host_rows(layers: &[Layer]) -> Result<Vec<HostRow>, Faults> {
    let mut rows: BTreeMap<HostKind, HostRow> = BTreeMap::new();
    for layer in layers {
        let mut faults = Vec::new();
        for row in &layer.device.host {
            for quantity in std::iter::once(&row.call).chain(&row.item) {
                let Quantity { value, unit, .. } = quantity.get_ref();
                if unit != "us" || !value.is_finite() || *value < 0.0 {
                    faults.push(
                        Fault::error(
                            quantity.span().into(),
                            "a host operation costs zero or more microseconds (`us`)",
                            "this figure",
                        )
                        .help("write { value = …, unit = \"us\", source = …, evidence = … }"),
                    );
                }
            }
            let built = HostRow {
                kind: *row.name.get_ref(),
                forms: forms(&row.forms, &mut faults, |_| true),
                meaning: row.meaning.clone(),
                call: row.call.get_ref().clone(),
                item: row.item.as_ref().map(|i| i.get_ref().clone()),
            };
            rows.insert(built.kind, built);
        }
        layer.wrong("device.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    for kind in HostKind::ALL {
        if !rows.contains_key(kind) {
            faults.push(
                Fault::error(
                    top.device.name.span().into(),
                    format!("the host operation {kind:?} has no row"),
                    "this chip",
                )
                .help("write it as [[host]], or extend a chip that has it"),
            );
        }
    }
    top.wrong("device.toml", faults)?;
    Ok(rows.into_values().collect())
}

/// The macros of all layers, and the layer that each is from; one of the same heading
/// replaces the one before.
fn all_macros(layers: &[Layer]) -> Result<(Vec<Macro>, Vec<usize>), Faults> {
    let (mut all, mut owners): (Vec<Macro>, Vec<usize>) = (Vec::new(), Vec::new());
    for (at, layer) in layers.iter().enumerate() {
        let Some(text) = &layer.folder.macros else {
            continue;
        };
        let list = match macros::parse(text) {
            Ok(list) => list,
            Err(faults) => {
                layer.wrong("macros.scamp", faults)?;
                continue;
            }
        };
        for it in list {
            if let Some(old) = all.iter().position(|m| m.replaces(&it)) {
                all[old] = it;
                owners[old] = at;
            } else {
                all.push(it);
                owners.push(at);
            }
        }
    }
    Ok((all, owners))
}

/// Tries a form once, with values that fit.
fn can_be_built(kind: Kind, form: &Signature) -> bool {
    let example = |p: &Parameter| vec![example(p.operand); p.count.0.max(1)];
    let bound: Vec<Vec<Value>> = form.parameters.iter().map(example).collect();
    row::build(kind, &form.name, &bound).is_some()
}

fn example(operand: Operand) -> Value {
    use super::{Bit, Direction, Source};
    match operand {
        Operand::Areg | Operand::Target | Operand::Source => {
            Value::Source(Source::Register(Analog(0)))
        }
        Operand::Dreg | Operand::Bit => Value::Bit(Bit::Register(Digital(0))),
        Operand::Direction | Operand::Directions => Value::Directions(vec![Direction::North]),
        Operand::Number(..) | Operand::Integer(..) | Operand::Literal(_) => Value::Number(0.0),
        Operand::Word => Value::Word(String::new()),
    }
}
