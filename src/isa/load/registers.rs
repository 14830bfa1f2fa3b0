//! The registers of a chip.

use crate::config::{Fault, Faults, Place, suggestion_or};
use crate::isa::names::is_writable;
use crate::limit::ALIASES;
use crate::order::Order;

use super::{
    super::{Analog, Digital, LeftOut, Registers, Roles},
    file::{Placed, ROLE_KEYS, RegistersFile},
    keys::NAME,
    layers::Layer,
};

/// A part of `[registers]`, and whether the chip's own file states it.
#[derive(Clone, Copy)]
struct Stated<'a, T> {
    value: &'a T,
    own: bool,
}

/// A list of registers.
type List<'a> = Stated<'a, Placed<Vec<Placed<String>>>>;

impl List<'_> {
    fn position(&self, name: &str) -> Option<u8> {
        let mut all = self.value.value.iter();
        all.position(|it| it.value == name).map(|at| at as u8)
    }

    fn names(&self) -> Vec<String> {
        let all = self.value.value.iter();
        all.map(|name| name.value.clone()).collect()
    }
}

/// The part that is stated last.
fn last<'a, T>(
    layers: &'a [Layer],
    key: &str,
    of: impl Fn(&'a RegistersFile) -> Option<&'a T>,
) -> Result<Stated<'a, T>, Faults> {
    let top = layers.len() - 1;
    let stated = |(at, layer): (usize, &'a Layer)| {
        let value = of(layer.device.registers.as_ref()?)?;
        Some(Stated {
            value,
            own: at == top,
        })
    };
    let found = layers.iter().enumerate().rev().find_map(stated);
    found.ok_or_else(|| {
        let chip = &layers[top];
        let what = format!("`registers.{key}` is missing");
        let fault = Fault::error(chip.device.name.place, what, "this chip")
            .help("state it, or extend a chip that does");
        let file = format!("{}/device.toml", chip.folder.name);
        Faults::one(&file, &chip.folder.device, fault)
    })
}

/// The registers of the last layer, and the other names that it has no register for. What the layers
/// below say is right for them: a fault stands in the file of the last.
pub(super) fn registers(layers: &[Layer]) -> Result<(Registers, Vec<LeftOut>), Faults> {
    let top = &layers[layers.len() - 1];
    let analog = last(layers, "analogue", |it| it.analogue.as_ref())?;
    let digital = last(layers, "digital", |it| it.digital.as_ref())?;
    let news = last(layers, "news", |it| it.news.as_ref())?;
    let mut roles = Vec::new();
    for (at, key) in ROLE_KEYS.iter().enumerate() {
        let key = format!("roles.{key}");
        roles.push(last(layers, &key, |it| it.roles[at].as_ref())?);
    }
    let mut faults = wrong_lists(&analog, &digital, top.device.name.place);
    let news = Analog(news_of(&analog, &news, &mut faults));
    let roles = roles_of(&digital, &roles, &mut faults);
    let (aliases, left_out) = aliases(layers, (&analog, &digital), &mut faults);
    top.wrong("device.toml", faults)?;
    let registers = Registers {
        analog: analog.names(),
        news,
        digital: digital.names(),
        aliases,
        roles,
    };
    Ok((registers, left_out))
}

/// The number of the register that neighbours can reach.
fn news_of(analog: &List<'_>, news: &Stated<'_, Placed<String>>, faults: &mut Vec<Fault>) -> u8 {
    let name = &news.value.value;
    let found = analog.position(name);
    if found.is_none() {
        faults.push(if news.own {
            none(news.value, "an analogue", analog)
        } else {
            let what = format!("`{name}` is what neighbours can reach, and no register here");
            Fault::error(analog.value.place, what, "this list")
                .help("add it, or say which it is: news = … under [registers]")
        });
    }
    found.unwrap_or(0)
}

/// The fault of a name that is not in a list.
fn none(name: &Placed<String>, what: &str, list: &List<'_>) -> Fault {
    let names = list.value.value.iter().map(|it| it.value.as_str());
    let help = suggestion_or(&name.value, names, "name one of the list");
    let what = format!("`{}` is not {what} register", name.value);
    Fault::error(name.place, what, "this name").help(help)
}

/// The registers with a role, each its own; `roles`: in the order of the keys.
fn roles_of(
    digital: &List<'_>,
    roles: &[Stated<'_, Placed<String>>],
    faults: &mut Vec<Fault>,
) -> Roles {
    let mut lost: Vec<String> = Vec::new();
    for (at, (key, role)) in ROLE_KEYS.iter().zip(roles).enumerate() {
        let name = role.value;
        if digital.position(&name.value).is_none() {
            if role.own {
                faults.push(none(name, "a one-bit", digital));
            } else {
                lost.push(format!("{} ({key})", name.value));
            }
        }
        let mut before = ROLE_KEYS.iter().zip(&roles[..at]);
        let same = before.find(|(_, other)| other.value.value == name.value);
        // What comes from below stands in another file: the one that is new here is at fault.
        if let Some((other, first)) = same
            && (role.own || first.own)
        {
            let place = if role.own { name } else { first.value }.place;
            let what = format!("`{}` is both `{other}` and `{key}`", name.value);
            let help = "each of the six has a register of its own: macros set one and leave the others; what is not stated is as on the chip below";
            faults.push(Fault::error(place, what, "the second").help(help));
        }
    }
    if !lost.is_empty() {
        let what = format!(
            "the hardware itself uses {}, and no register here has the name",
            lost.join(", ")
        );
        let help = "add it, or say which has that part: [registers.roles]";
        faults.push(Fault::error(digital.value.place, what, "this list").help(help));
    }
    let bit = |at: usize| {
        let name = roles.get(at).map(|role| role.value.value.as_str());
        let number = name.and_then(|name| digital.position(name));
        Digital(number.unwrap_or(0))
    };
    Roles {
        mask: bit(0),
        propagated: bit(1),
        enable: [bit(2), bit(3), bit(4), bit(5)],
    }
}

type Aliases = Vec<(String, Digital)>;

/// Other names, those of the last layer first, and the ones from below that have no register here.
fn aliases(
    layers: &[Layer],
    (analog, digital): (&List<'_>, &List<'_>),
    faults: &mut Vec<Fault>,
) -> (Aliases, Vec<LeftOut>) {
    let (mut aliases, mut left_out): (Aliases, Vec<LeftOut>) = (Vec::new(), Vec::new());
    let top = layers.len() - 1;
    for (at, layer) in layers.iter().enumerate().rev() {
        let own = at == top;
        for (alias, of) in { layer.device.registers.iter() }.flat_map(|it| &it.aliases) {
            let name = &alias.value;
            let is_register = [analog, digital]
                .iter()
                .any(|it| it.position(name).is_some());
            if own && let Some(fault) = wrong_alias(alias, is_register) {
                faults.push(fault);
            }
            // One more than there can be tells enough.
            let is_known = aliases.iter().any(|(known, _)| known == name)
                || left_out.iter().any(|it| it.name == *name);
            if is_known || is_register || aliases.len() > ALIASES {
                continue;
            }
            match digital.position(&of.value) {
                Some(register) => aliases.push((name.clone(), Digital(register))),
                None if own => faults.push(none(of, "a one-bit", digital)),
                None => left_out.push(LeftOut::alias(name, &of.value)),
            }
        }
    }
    if aliases.len() > ALIASES {
        let what = format!("too many other names: {ALIASES} aliases at most");
        let place = layers[top].device.name.place;
        faults.push(Fault::error(place, what, "this chip").help("leave some out"));
    }
    (aliases, left_out)
}

/// What is wrong with another name.
fn wrong_alias(alias: &Placed<String>, is_register: bool) -> Option<Fault> {
    let name = &alias.value;
    if !is_writable(name) {
        let what = format!("`aliases` cannot have \"{name}\"");
        return Some(Fault::error(alias.place, what, "this name").help(format!("give {NAME}")));
    }
    let what = format!("`{name}` is a register, and another name of one");
    is_register
        .then(|| Fault::error(alias.place, what, "this name").help("give one of them another name"))
}

/// Names that stand twice, and lists that are empty or too long.
fn wrong_lists(analog: &List<'_>, digital: &List<'_>, chip: Place) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    let mut lists = [analog, digital];
    // What comes from below stands first: the name that is new here is at fault.
    lists.order_by_key(|list| list.own);
    let all = { lists.into_iter() }
        .flat_map(|list| list.value.value.iter().map(move |name| (name, list.own)));
    for (name, own) in all {
        if own && seen.contains(&name.value.as_str()) {
            let what = format!("two registers are called `{}`", name.value);
            faults.push(
                Fault::error(name.place, what, "the second")
                    .help("every register has a name of its own"),
            );
        }
        seen.push(&name.value);
    }
    for (what, list) in [("analogue", analog), ("one-bit", digital)] {
        let count = list.value.value.len();
        if list.own && (count == 0 || count > 64) {
            let what = format!("{count} {what} registers; there can be 1 to 64");
            faults.push(Fault::error(chip, what, "this chip").help("list their names"));
        }
    }
    faults
}
