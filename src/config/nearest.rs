//! Suggestions: which of the known names did the writer mean?

/// The longest name that is looked at, in characters.
const LONGEST: usize = 64;

/// The known name nearest to `name`, if one is near enough to be what was meant: at most one
/// edit in three letters and never all of them, a change of case counting as none.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().count();
    let limit = 1.max(length / 3);
    // What is longer is no slip of the pen; comparing takes the product of the lengths.
    if length > LONGEST {
        return None;
    }
    known
        .into_iter()
        .filter(|candidate| candidate.len() <= 4 * LONGEST)
        .map(|candidate| {
            let lower = distance(&name.to_lowercase(), &candidate.to_lowercase());
            let letters = distance(&letters(name), &letters(candidate));
            (lower, letters, distance(name, candidate), candidate)
        })
        .filter(|&(lower, ..)| lower <= limit && lower < length)
        .min_by_key(|&(lower, letters, exact, candidate)| {
            (lower.min(letters), letters, exact, candidate.len())
        })
        .map(|(.., candidate)| candidate)
}

/// A name in lower case, without what stands between its words.
fn letters(name: &str) -> String {
    let letters = name.chars().filter(|c| !matches!(c, '-' | '_' | ' '));
    letters.flat_map(char::to_lowercase).collect()
}

/// "did you mean `x`?", where something is near.
pub fn suggestion<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, known).map(|near| format!("did you mean `{near}`?"))
}

/// "did you mean `x`? ", to stand before what else there is; nothing where nothing is near.
pub fn asked<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    suggestion(name, known).map_or_else(String::new, |question| question + " ")
}

/// "did you mean `x`?", or what else can be done.
pub fn suggestion_or<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    otherwise: &str,
) -> String {
    suggestion(name, known).unwrap_or_else(|| otherwise.to_owned())
}

/// Edits (insert, delete, replace, swap two neighbours) from one word to the other.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
    table[0] = (0..=b.len()).collect();
    for i in 1..=a.len() {
        table[i][0] = i;
        for j in 1..=b.len() {
            let replaced = table[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(table[i - 1][j] + 1).min(table[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(table[i - 2][j - 2] + 1);
            }
            table[i][j] = least;
        }
    }
    table[a.len()][b.len()]
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
        assert_eq!(distance("mvo", "mov"), 1);
    }

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let known = ["movx", "mov2x", "MOV", "mov", "where", "WHERE"];
        assert_eq!(nearest("mvx", known), Some("movx"));
        assert_eq!(nearest("Mov", known), Some("mov"));
        assert_eq!(nearest("WHERe", known), Some("WHERE"));
        assert_eq!(nearest("mvo", known), Some("mov"));
        assert_eq!(nearest("display", known), None);
        assert_eq!(nearest("rgc4", ["rgc", "rgc-4"]), Some("rgc-4"));
        assert_eq!(nearest("rgc", ["rgc-4", "rg"]), Some("rg"));
        assert_eq!(nearest("Q", ["A", "B"]), None, "nothing of it is left");
    }
}
