//! JSON objects that carry a checksum of themselves.
//!
//! The checksum is the SHA-256 of everything else as compact JSON with sorted keys: white space
//! and the order of keys play no part, every value does.

use std::collections::BTreeMap;

use serde_json::Value as Json;
use sha2::{Digest, Sha256};

use crate::study::sweep::scene::cached_scene::hex;

/// The keys of an object, sorted.
pub(super) type Fields = BTreeMap<String, Json>;

/// The key of the checksum.
const CHECKSUM: &str = "checksum";

/// The object with its checksum.
pub(super) fn sealed(mut fields: Fields) -> Fields {
    let checksum = checksum(&fields);
    fields.insert(CHECKSUM.to_owned(), checksum.into());
    fields
}

/// An object as it was read, whatever its checksum says.
pub(super) fn parse(bytes: &[u8]) -> Result<Fields, String> {
    if bytes.is_empty() {
        return Err("it is empty".to_owned());
    }
    serde_json::from_slice(bytes).map_err(|e| format!("it is not a JSON object: {e}"))
}

/// The object without its checksum, which must be right.
pub(super) fn unsealed(mut fields: Fields) -> Result<Fields, String> {
    match fields.remove(CHECKSUM) {
        None => Err("it has no checksum".to_owned()),
        Some(said) if said.as_str() == Some(&checksum(&fields)) => Ok(fields),
        Some(_) => Err("its checksum is not that of its content".to_owned()),
    }
}

fn checksum(fields: &Fields) -> String {
    // Keys are text: nothing here can fail.
    let text = serde_json::to_string(fields).unwrap_or_default();
    hex(&Sha256::digest(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    fn fields(value: &Json) -> Fields {
        parse(value.to_string().as_bytes()).unwrap()
    }

    #[test]
    fn every_value_counts_and_their_order_does_not() {
        let whole = sealed(fields(
            &json!({"a": 0.1, "b": null, "c": "x", "d": {"e": 1}}),
        ));
        let text = serde_json::to_string(&whole).unwrap();
        assert!(unsealed(parse(text.as_bytes()).unwrap()).is_ok());
        let mut turned: Vec<String> = whole
            .iter()
            .map(|(name, value)| format!("  {name:?}:\t{value}"))
            .collect();
        turned.reverse();
        let turned = format!("{{\n{}\n}}", turned.join(" ,\n"));
        assert!(unsealed(parse(turned.as_bytes()).unwrap()).is_ok());
        for (from, to) in [
            ("0.1", "0.10000000000000002"),
            ("0.1", "-0.1"),
            ("null", "0"),
            ("null", "\"\""),
            ("\"x\"", "\"y\""),
            ("\"e\":1", "\"e\":1.0"),
            ("\"e\":1", "\"e\":1,\"f\":2"),
            ("\"b\":null,", ""),
            ("checksum", "chexsum"),
        ] {
            let other = text.replacen(from, to, 1);
            assert_ne!(other, text);
            assert!(
                unsealed(parse(other.as_bytes()).unwrap()).is_err(),
                "{from} as {to}"
            );
        }
    }

    proptest! {
        /// A number is read as the bits that were written.
        #[test]
        fn numbers_survive_to_the_bit(bits: u64) {
            let number = f64::from_bits(bits);
            prop_assume!(number.is_finite());
            let text = json!({ "a": number }).to_string();
            let read = parse(text.as_bytes()).unwrap()["a"].as_f64().unwrap();
            prop_assert_eq!(read.to_bits(), bits);
        }
    }
}
