//! What statements do with the light of a frame.

use crate::{
    config::Place,
    program::syntax::{Item, Kernel, Node},
};

/// Where light is captured first.
pub(super) fn capture(items: &[Item]) -> Option<Place> {
    items.iter().find_map(|it| match &it.node {
        Node::Kernel(Kernel { body, .. }) | Node::Repeat { body, .. } => capture(body),
        Node::Statement(statement) => {
            let words = ["get_image", "getpix", "scamp5_get_image"];
            // `respix(y)` reads the reset level, no light.
            let reads = words.contains(&statement.name.as_str())
                || statement.arguments.iter().any(|it| it.to_string() == "PIX");
            reads.then_some(it.place)
        }
        _ => None,
    })
}

/// Whether something captures light, or resets the photodiodes.
pub(super) fn light(items: &[Item]) -> bool {
    items.iter().any(|it| match &it.node {
        Node::Kernel(Kernel { body, .. }) | Node::Repeat { body, .. } => light(body),
        Node::Statement(statement) => {
            let captures = ["get_image", "getpix", "respix", "rpix", "scamp5_get_image"];
            captures.contains(&statement.name.as_str())
                || statement.arguments.iter().any(|it| it.to_string() == "PIX")
        }
        _ => false,
    })
}
