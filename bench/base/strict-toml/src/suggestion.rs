//! Suggestions for unknown words.

/// Similarity below which a suggestion would mislead.
const LIKE_ENOUGH: f64 = 0.7;
/// Similarity from which on a word is suggested although half of its letters differ, as where two are exchanged.
const ALIKE: f64 = 0.8;

/// Returns the word of `known` most similar to `word`: the closest spelling, or else the only one that contains it or is
/// contained in it. `None` if no word is similar.
///
/// ```
/// let known = ["huloux2021", "demo"];
/// assert_eq!(strict_toml::nearest("2021", &known).as_deref(), Some("huloux2021"));
/// assert_eq!(strict_toml::nearest("xyzzy", &known), None);
/// ```
pub fn nearest<S: AsRef<str>>(word: &str, known: &[S]) -> Option<String> {
    let spelt = known
        .iter()
        .map(|known| known.as_ref())
        .map(|known| (strsim::jaro_winkler(word, known), known))
        .filter(|(similarity, known)| {
            *similarity >= LIKE_ENOUGH && (*similarity >= ALIKE || has_most_letters(word, known))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known);
    spelt.or_else(|| containing(word, known)).map(str::to_owned)
}

/// Returns whether fewer than half of the letters of the longer word differ.
fn has_most_letters(word: &str, known: &str) -> bool {
    let letters = word.chars().count().max(known.chars().count());
    2 * strsim::osa_distance(word, known) < letters
}

/// Returns the only word of `known` that contains `word` or is contained in it. Words under three letters are ignored,
/// since too many others contain them.
fn containing<'a, S: AsRef<str>>(word: &str, known: &'a [S]) -> Option<&'a str> {
    const SHORTEST: usize = 3;
    if word.len() < SHORTEST {
        return None;
    }
    let mut matches = known
        .iter()
        .map(AsRef::as_ref)
        .filter(|known| known.contains(word) || (known.len() >= SHORTEST && word.contains(known)));
    let first = matches.next();
    first.filter(|_| matches.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_word_spelt_most_like_it_is_suggested() {
        let known = ["nominal", "noisy", "population"];
        assert_eq!(nearest("nominl", &known).as_deref(), Some("nominal"));
        assert_eq!(nearest("popluation", &known).as_deref(), Some("population"));
        assert_eq!(nearest("xyzzy", &known), None);
    }

    /// Regression test: `ask = ["name"]` was answered by "did you mean `age`?".
    #[test]
    fn a_short_word_with_two_letters_in_common_is_not_suggested() {
        let known = ["age", "sex", "handedness"];
        assert_eq!(nearest("name", &known), None);
        assert_eq!(nearest("agee", &known).as_deref(), Some("age"));
        assert_eq!(
            nearest("bear", &["bare", "loaded"]).as_deref(),
            Some("bare")
        );
    }

    #[test]
    fn a_part_of_one_word_suggests_it_and_a_part_of_two_suggests_neither() {
        let known = ["contact_area_m2", "sigma_t_m", "sigma_q0_rad_per_m"];
        assert_eq!(nearest("area", &known).as_deref(), Some("contact_area_m2"));
        assert_eq!(nearest("_m", &known), None);
        let known = ["left_area", "right_area"];
        assert_eq!(nearest("area", &known), None);
    }
}
