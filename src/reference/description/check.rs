//! Checks a sensor file, and builds its description.

use crate::{
    config::{Faults, Node, Read, Section},
    kernel::Kernel,
    photoreceptor::Response,
    plane::Plane,
    reference::{noise::Noise, surround::Surrounds},
    unit::counted,
};

use super::{
    channel::{Channel, Threshold},
    kernels::scaled,
    keys::{FILE, REFRACTORY, SENSOR, THRESHOLD},
    reader::{ReadFile, Reader, wrong},
    rules::{Border, MemoryRule, PolarityRule, Refractory, RefractoryRule},
    sensor::Description,
    soundness,
};

impl Description {
    /// Whether a text is that of a sensor file, which has a `channel`, or would be but for what is
    /// wrong with it.
    #[must_use]
    pub fn is_meant(text: &str) -> bool {
        let has = |line: &str| line.trim_start().starts_with("[[channel]]");
        text.lines().any(has)
            || text
                .parse::<toml::Table>()
                .is_ok_and(|it| it.contains_key("channel"))
    }

    /// Reads the text of a sensor file called `file`; `read` opens the kernel files it names.
    ///
    /// # Errors
    /// What is wrong, each with its line and column.
    pub fn parse(file: &str, text: &str, read: &ReadFile<'_>) -> Result<Self, Faults> {
        FILE.read(file, text, |root| Reader { file, read }.sensor(root))
    }
}

impl Reader<'_> {
    pub(super) fn sensor(&self, root: Node<'_>) -> Read<Description> {
        let section = Section::new(root, &SENSOR);
        let memory = section.needed_word("memory", MemoryRule::ALL)?;
        let refractory = refractory(memory, section.get("refractory"))?;
        let shared = shared(memory, &section)?;
        let polarity = polarity(memory, &section)?;
        let noise = match section.get("noise") {
            Some(noise) => noise_of(memory, refractory, noise)?,
            None => Noise::NONE,
        };
        let channels = section.tables("channel").into_iter();
        let channels = channels.map(|channel| self.channels(memory, &channel));
        let channels = channels.collect::<Read<Vec<_>>>()?.concat();
        let many = soundness::channels(channels.len());
        many.map_err(|odd| odd.at(section.place_of("channel")))?;
        let border = section.word("border", Border::ALL)?;
        let name = section.maybe_text("name");
        Ok(Description {
            name: name.unwrap_or_else(|| stem(self.file).to_owned()),
            response: Response::read(section.need("response")?)?,
            memory,
            shared,
            polarity,
            border: border.unwrap_or_default(),
            refractory,
            noise,
            channels,
        })
    }

    /// One kind of cell; or as many as its file has kernels.
    fn channels(&self, memory: MemoryRule, section: &Section<'_>) -> Read<Vec<Channel>> {
        let four = section.get("pattern").is_some();
        let log_temporal = section.flag("log-temporal");
        soundness::log_temporal(memory, log_temporal)
            .map_err(|odd| odd.at(section.place_of("log-temporal")))?;
        let gain = section.number("gain")?;
        let surrounds = match section.get("mesh") {
            None => None,
            Some(mesh) => {
                let fits = soundness::mesh(memory, four, log_temporal);
                fits.map_err(|odd| odd.at(mesh.place()))?;
                Some(Surrounds::read(mesh, gain)?)
            }
        };
        let kernel_place = section.place_of("kernel");
        let stack = match section.get("kernel") {
            Some(kernel) => self.stack(kernel)?,
            None => None,
        };
        // A stack of four is what a pattern asks for.
        let (stack, four_in_one) = match stack {
            Some(stack) if four && stack.len() == 4 => (None, Some(stack)),
            stack => (stack.filter(|_| !four), None),
        };
        let kernels = match section.get("kernel") {
            Some(_) if stack.is_some() => stack.clone().unwrap_or_default(),
            Some(_) if four_in_one.is_some() => four_in_one.unwrap_or_default(),
            Some(kernel) => self.kernels(kernel, four)?,
            None => vec![
                Kernel::new(Plane::ones((1, 1)))
                    .map_err(|e| wrong(kernel_place, e.to_string(), ""))?,
            ],
        };
        let kinds = stack.as_ref().map(Vec::len);
        let thresholds = thresholds(section.need("threshold")?, four, kinds)?;
        let names = names(section.get("name"), kinds)?;
        let memory_kernel =
            self.memory_kernel(memory, section.get("memory-kernel"), gain, section.place())?;
        let kernels = match &surrounds {
            // The gain is in the mesh.
            Some(_) => kernels,
            None => kernels
                .iter()
                .map(|kernel| scaled(kernel, gain, kernel_place))
                .collect::<Read<_>>()?,
        };
        let whole = Channel {
            name: None,
            kernels,
            surrounds,
            thresholds,
            memory_kernel,
            log_temporal,
        };
        let Some(kinds) = kinds else {
            let name = names.into_iter().next();
            return Ok(vec![Channel { name, ..whole }]);
        };
        let each = (0..kinds).map(|k| Channel {
            name: names.get(k).cloned(),
            kernels: vec![whole.kernels[k].clone()],
            thresholds: vec![whole.thresholds[k]],
            ..whole.clone()
        });
        Ok(each.collect())
    }
}

fn refractory(memory: MemoryRule, section: Option<Node<'_>>) -> Read<Refractory> {
    let Some(node) = section else {
        return Ok(memory.unstated_refractory());
    };
    let section = Section::new(node, &REFRACTORY);
    let rule = section.word("rule", RefractoryRule::ALL)?;
    let rule = rule.unwrap_or_default();
    soundness::refractory(memory, rule).map_err(|odd| odd.at(node.place()))?;
    let us = section.number("us")?;
    Ok(Refractory { us, rule })
}

fn shared(memory: MemoryRule, section: &Section<'_>) -> Read<bool> {
    let shared = section.flag("shared");
    let fits = soundness::shared(memory, shared);
    fits.map_err(|odd| odd.at(section.place_of("shared")))?;
    Ok(shared)
}

fn polarity(memory: MemoryRule, section: &Section<'_>) -> Read<PolarityRule> {
    let rule = section.word("polarity", PolarityRule::ALL)?;
    let rule = rule.unwrap_or_default();
    let fits = soundness::polarity(memory, rule);
    fits.map_err(|odd| odd.at(section.place_of("polarity")))?;
    Ok(rule)
}

fn noise_of(memory: MemoryRule, refractory: Refractory, node: Node<'_>) -> Read<Noise> {
    let noise = Noise::stated(node)?;
    let place = Section::new(node, &Noise::TABLE).place_of("leak-hz");
    soundness::leak(memory, refractory.rule, &noise).map_err(|odd| odd.at(place))?;
    Ok(noise)
}

/// What the kinds of a channel are called: as they are listed, or numbered from 0.
fn names(given: Option<Node<'_>>, kinds: Option<usize>) -> Read<Vec<String>> {
    let Some(node) = given else {
        return Ok(Vec::new());
    };
    let texts = |list: Vec<Node<'_>>| -> Vec<String> {
        let texts = list.into_iter().filter_map(Node::as_text);
        texts.map(str::to_owned).collect()
    };
    match (node.as_text(), node.as_list(), kinds) {
        (Some(name), _, None) => Ok(vec![name.to_owned()]),
        (Some(name), _, Some(kinds)) => Ok((0..kinds).map(|k| format!("{name} {k}")).collect()),
        (_, Some(list), Some(kinds)) if list.len() == kinds => Ok(texts(list)),
        (_, Some(_), None) => Err(wrong(
            node.place(),
            "a list of names, and this channel is one kind of cells",
            "give one name, such as name = \"a\"; a list is for a kernel file of several kernels",
        )),
        (_, list, kinds) => Err(wrong(
            node.place(),
            format!(
                "{} for {}",
                counted(list.map_or(0, |list| list.len()), "name"),
                counted(kinds.unwrap_or(1), "kernel")
            ),
            "give one name, or a list of as many as the file has kernels",
        )),
    }
}

/// One threshold, or four for a pattern, or one for each of the kinds of a file.
fn thresholds(node: Node<'_>, four: bool, kinds: Option<usize>) -> Read<Vec<Threshold>> {
    if let Some(kinds) = kinds {
        return match node.as_list() {
            None => Ok(vec![Threshold::read(node)?; kinds]),
            Some(list) if list.len() == kinds => list.into_iter().map(Threshold::read).collect(),
            Some(list) => Err(wrong(
                node.place(),
                format!(
                    "{} for {}",
                    counted(list.len(), "threshold"),
                    counted(kinds, "kernel")
                ),
                "give one for all of them, or one for each",
            )),
        };
    }
    let all = match (node.as_list(), four) {
        (None, false) => vec![node],
        (Some(several), true) if several.len() == 4 => several,
        (Some(_), false) => {
            return Err(wrong(
                node.place(),
                "several thresholds in one channel",
                "add pattern = \"2x2\" for four thresholds, or give one",
            ));
        }
        (_, true) => {
            return Err(wrong(
                node.place(),
                "pattern = \"2x2\" needs four thresholds",
                "give threshold = [{ … }, { … }, { … }, { … }]",
            ));
        }
    };
    all.into_iter().map(Threshold::read).collect()
}

impl Threshold {
    /// The threshold that a checked table states.
    ///
    /// # Errors
    /// When a number is missing.
    pub fn read(node: Node<'_>) -> Read<Self> {
        let section = Section::new(node, &THRESHOLD);
        Ok(Self {
            on: section.number("on")?,
            off: section.number("off")?,
            sigma: section.number("sigma")?,
        })
    }
}

fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    name.strip_suffix(".toml").unwrap_or(name)
}
