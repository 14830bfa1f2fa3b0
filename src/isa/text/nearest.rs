//! Suggestions: which of the known names did the writer mean?

/// The known name nearest to `name`, if one is near enough to be what was meant: at most one
/// edit in three letters, a change of case counting as none.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = 1.max(name.chars().count() / 3);
    known
        .into_iter()
        .map(|candidate| {
            let lower = distance(&name.to_lowercase(), &candidate.to_lowercase());
            (lower, distance(name, candidate), candidate)
        })
        .filter(|&(lower, _, _)| lower <= limit)
        .min_by_key(|&(lower, exact, candidate)| (lower, exact, candidate.len()))
        .map(|(_, _, candidate)| candidate)
}

/// "did you mean `x`?", where something is near.
pub fn suggestion<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, known).map(|near| format!("did you mean `{near}`?"))
}

/// Edits (insert, delete, replace) from one word to the other.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        row[0] = left;
        for (j, &y) in b.iter().enumerate() {
            let above = row[j + 1];
            left = (diagonal + usize::from(x != y))
                .min(above + 1)
                .min(left + 1);
            diagonal = above;
            row[j + 1] = left;
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", ""), 3);
        assert_eq!(distance("sub", "sub"), 0);
    }

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let known = ["movx", "mov2x", "MOV", "mov", "where", "WHERE"];
        assert_eq!(nearest("mvx", known), Some("movx"));
        assert_eq!(nearest("Mov", known), Some("mov"));
        assert_eq!(nearest("WHERe", known), Some("WHERE"));
        assert_eq!(nearest("display", known), None);
    }
}
