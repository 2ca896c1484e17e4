//! Parts and words of names.

/// Returns the words of a name, lower case: parted by signs, digits, and capitals after small letters.
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last = ' ';
    for c in name.chars() {
        let is_boundary = !c.is_alphabetic() || (c.is_uppercase() && last.is_lowercase());
        if is_boundary {
            words.push(String::new());
        }
        if c.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        last = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Returns the last part of a name: of `S.force.Fn` and `/daq/Fn` that is `Fn`.
pub(crate) fn leaf(name: &str) -> String {
    let name = name
        .rsplit_once('[')
        .map_or(name, |(stem, _)| if stem.is_empty() { name } else { stem });
    // The slash of a unit parts no names.
    let parts: Vec<&str> = name.split_inclusive(['/', '.', '@']).collect();
    let is_end = |index: usize| {
        index + 1 == parts.len()
            || !(parts[index].ends_with("m/") && parts[index + 1].starts_with('s'))
    };
    let last = (0..parts.len())
        .rev()
        .find(|index| !parts[*index].trim_matches(['/', '.', '@', ' ']).is_empty());
    let Some(last) = last else {
        return name.to_owned();
    };
    let mut first = last;
    while first > 0 && !is_end(first - 1) {
        first -= 1;
    }
    parts[first..=last]
        .concat()
        .trim_end_matches(['/', '.', '@'])
        .to_owned()
}
