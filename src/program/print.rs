//! Formatting a tree as text, always the same way: one statement a line, four blanks a level,
//! comments and single blank lines kept.

use std::fmt::{self, Write as _};

use super::syntax::{Comment, Item, Kernel, Node, Syntax};

impl fmt::Display for Syntax {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in &self.header {
            writeln!(f, "//!{line}")?;
        }
        if !self.header.is_empty() && !self.items.is_empty() {
            writeln!(f)?;
        }
        items(f, &self.items, 0)?;
        let above = !self.header.is_empty() || !self.items.is_empty();
        if above && !self.footer.is_empty() {
            writeln!(f)?;
        }
        for line in &self.footer {
            writeln!(f, "//={line}")?;
        }
        Ok(())
    }
}

fn items(f: &mut fmt::Formatter<'_>, list: &[Item], level: usize) -> fmt::Result {
    for (i, item) in list.iter().enumerate() {
        if item.blank_before && i > 0 {
            writeln!(f)?;
        }
        write!(f, "{:indent$}", "", indent = 4 * level)?;
        match &item.node {
            Node::Comment(it) => comment(f, it)?,
            Node::Statement(statement) => write!(f, "{statement}")?,
            Node::Const { name, value, .. } => write!(f, "const {name} = {value};")?,
            Node::Init(body) => block(f, "init", body, level)?,
            Node::Frame(body) => block(f, "frame", body, level)?,
            Node::Repeat { times, body } => block(f, &format!("repeat {times}"), body, level)?,
            Node::Kernel(Kernel { body, .. }) => {
                writeln!(f, "scamp5_kernel_begin();")?;
                items(f, body, level)?;
                write!(f, "{:indent$}scamp5_kernel_end();", "", indent = 4 * level)?;
            }
        }
        if let Some(it) = &item.trailing {
            f.write_char(' ')?;
            comment(f, it)?;
        }
        writeln!(f)?;
    }
    Ok(())
}

fn block(f: &mut fmt::Formatter<'_>, heading: &str, body: &[Item], level: usize) -> fmt::Result {
    writeln!(f, "{heading} {{")?;
    items(f, body, level + 1)?;
    write!(f, "{:indent$}}}", "", indent = 4 * level)
}

fn comment(f: &mut fmt::Formatter<'_>, it: &Comment) -> fmt::Result {
    match it {
        Comment::Line(text) => write!(f, "//{text}"),
        Comment::Block(text) => write!(f, "/*{text}*/"),
    }
}
