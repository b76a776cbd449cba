//! "Did you mean …?" for misspelt names.

/// The candidate nearest to `word`, if it is likely a misspelling: at most a third of the letters (rounded up) differ.
pub(super) fn closest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let limit = word.chars().count().div_ceil(3);
    candidates
        .into_iter()
        .map(|c| (distance(word, c), c))
        .filter(|(d, _)| *d <= limit)
        .min()
        .map(|(_, c)| c)
}

/// `Did you mean …? ` with a trailing space; empty without a suggestion.
pub fn sentence<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, candidates)
        .map(|c| format!("Did you mean `{c}`? "))
        .unwrap_or_default()
}

/// Edit distance of `a` and `b`: letters inserted, removed, replaced, or two neighbours swapped; case is ignored. Words
/// are cut at 64 characters.
fn distance(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|word| word.chars().take(64).collect::<String>().to_lowercase());
    strsim::osa_distance(&a, &b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_recognised_and_another_word_is_not() {
        assert_eq!(closest("coverag", ["base_m", "coverage"]), Some("coverage"));
        assert_eq!(closest("SRM", ["srm", "bsm"]), Some("srm"));
        assert_eq!(closest("fourier", ["srm", "bsm"]), None);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(closest("smr", ["bsm", "srm"]), Some("srm"));
        assert_eq!(closest("xyz", ["abz"]), None);
        assert_eq!(distance("", "abc"), 3);
    }
}
