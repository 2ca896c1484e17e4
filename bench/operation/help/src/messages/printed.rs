//! Message index for a terminal and as a chapter of the handbook.

use std::cell::Cell;
use std::fmt::Write;

use clap::Args;
use textwrap::WordSplitter;

use crate::messages::{MessageGroup, ProgramMessage, index};

/// Width of the index on a terminal.
const WIDTH: usize = 96;
/// Indentation of meaning and remedy.
const INDENT: &str = "    ";
/// Fewest letters of a message that is found whole in a pasted line, and least part of the longest such message.
const FEWEST_LETTERS: usize = 8;
const LEAST_OF_LONGEST: f64 = 0.4;
/// Most messages that are shown where none has all words.
const MOST_NEAREST: usize = 5;

/// `messages`; without words it prints all messages.
#[derive(Debug, Clone, Args)]
pub struct MessagesOptions {
    /// Message to look up, or words of it; numbers are ignored, so that text can be pasted from the screen [default: all].
    #[arg(value_name = "WORDS")]
    pub words: Vec<String>,
}

/// Returns messages as lines for a terminal: all without `words`; those that a pasted line contains whole; or else those that contain
/// all words, or most of them, since a line of the screen has words beside the message. `None` if no message has half of them.
///
/// ```
/// let line = " TRIPPED  normal force 5.30 N over the limit of 5.00 N · x to re-arm   simulated  UNCALIBRATED";
/// let found = help::messages::text(&[line.to_owned()]).unwrap();
/// assert!(found.contains("safety.max_normal_n") && !found.contains("e-stop pressed"));
/// let nearest = help::messages::text(&["the force is over the limit by far".to_owned()]).unwrap();
/// assert!(nearest.starts_with("No message has all"));
/// assert_eq!(help::messages::text(&["unheard-of".to_owned()]), None);
/// ```
#[must_use]
pub fn text(words: &[String]) -> Option<String> {
    let query: Vec<String> = words.iter().flat_map(|text| telling(text)).collect();
    let groups = index();
    if query.is_empty() {
        return Some(printed(&groups, true, |_, _| true));
    }
    let length = |message: &ProgramMessage| contained_letters(message, &query);
    let longest = groups
        .iter()
        .flat_map(|group| &group.messages)
        .map(length)
        .max();
    let longest = longest.filter(|letters| *letters >= FEWEST_LETTERS);
    if let Some(longest) = longest {
        let is_whole = |_: &MessageGroup, message: &ProgramMessage| {
            length(message) as f64 >= LEAST_OF_LONGEST * longest as f64
        };
        return Some(printed(&groups, false, is_whole));
    }
    let least = least_share(&groups, &query)?;
    if least >= 1.0 {
        return Some(printed(&groups, false, |group, message| {
            share(group, message, &query) >= least
        }));
    }
    let left = Cell::new(MOST_NEAREST);
    let nearest = printed(&groups, false, |group, message| {
        let is_near = left.get() > 0 && share(group, message, &query) >= least;
        left.set(left.get() - usize::from(is_near));
        is_near
    });
    Some(format!(
        "No message has all of these words. The nearest:\n\n{nearest}"
    ))
}

/// Returns the chosen messages of all groups, with the groups' introductions if `has_intro`.
fn printed(
    groups: &[MessageGroup],
    has_intro: bool,
    is_chosen: impl Fn(&MessageGroup, &ProgramMessage) -> bool,
) -> String {
    let mut written = String::new();
    for group in groups {
        let messages = group.messages.iter();
        let chosen: Vec<_> = messages
            .filter(|message| is_chosen(group, message))
            .collect();
        if chosen.is_empty() {
            continue;
        }
        let line = "=".repeat(group.title.chars().count());
        let _ = writeln!(written, "{}\n{line}\n", group.title);
        if has_intro {
            written.push_str(&paragraph(&group.intro, ""));
            written.push('\n');
        }
        for message in chosen {
            written.push_str(&paragraph(&message.says, ""));
            if let Some(brief) = &message.brief {
                written.push_str(&paragraph(&format!("on the screen: {brief}"), INDENT));
            }
            written.push_str(&paragraph(&message.means, INDENT));
            written.push_str(&paragraph(&format!("→ {}", message.remedy), INDENT));
            written.push('\n');
        }
    }
    written.trim_end().to_owned() + "\n"
}

/// Returns the letters of a message that the query contains whole, in its text or its short form: the words between its values, in
/// their order; 0 if it is not contained.
fn contained_letters(message: &ProgramMessage, query: &[String]) -> usize {
    let forms = [Some(&message.says), message.brief.as_ref()];
    let letters = |form: &String| {
        let pieces: Vec<Vec<String>> = form.split('…').map(telling).collect();
        let mut rest = query;
        for piece in pieces.iter().filter(|piece| !piece.is_empty()) {
            let Some(start) = rest.windows(piece.len()).position(|words| words == piece) else {
                return 0;
            };
            rest = &rest[start + piece.len()..];
        }
        let words = pieces.iter().flatten();
        words.map(|word| word.chars().count()).sum()
    };
    forms.into_iter().flatten().map(letters).max().unwrap_or(0)
}

/// Returns a text in lines for a terminal, each indented.
fn paragraph(text: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).break_words(false);
    let options = options.word_splitter(WordSplitter::NoHyphenation);
    let options = options.initial_indent(indent).subsequent_indent(indent);
    textwrap::fill(text.trim(), options) + "\n"
}

/// Returns the words of a message that do not vary: those without digits.
fn telling(text: &str) -> Vec<String> {
    // The screen writes micro as the Greek letter.
    let text = text.replace('\u{b5}', "\u{3bc}");
    let words = text.split_whitespace().map(str::to_lowercase);
    let trimmed = words.map(|word| word.trim_matches(|c: char| !c.is_alphanumeric()).to_owned());
    trimmed
        .filter(|word| !word.is_empty() && !word.contains(|c: char| c.is_ascii_digit()))
        .collect()
}

/// Returns the greatest share of the query that any message has; `None` if none has half of it.
fn least_share(groups: &[MessageGroup], query: &[String]) -> Option<f64> {
    let shares = groups.iter().flat_map(|group| {
        let messages = group.messages.iter();
        messages.map(|message| share(group, message, query))
    });
    let greatest = shares.fold(0.0, f64::max);
    (greatest >= 0.5).then_some(greatest)
}

/// Returns the share of the query's letters that are in words of a message; 1 for no query.
fn share(group: &MessageGroup, message: &ProgramMessage, query: &[String]) -> f64 {
    let ProgramMessage {
        says,
        brief,
        means,
        remedy,
        ..
    } = message;
    let brief = brief.as_deref().unwrap_or_default();
    let content = format!("{} {says} {brief} {means} {remedy}", group.title).to_lowercase();
    let content = content.replace('\u{b5}', "\u{3bc}");
    let letters = |words: &mut dyn Iterator<Item = &String>| -> usize {
        words.map(|word| word.chars().count()).sum()
    };
    let matched_letters = letters(&mut query.iter().filter(|word| content.contains(word.as_str())));
    let total = letters(&mut query.iter());
    if total == 0 {
        return 1.0;
    }
    matched_letters as f64 / total as f64
}

/// Returns the index as a chapter of the handbook, in Markdown.
#[must_use]
pub fn chapter() -> String {
    let mut page = String::from(
        "# Every message\n\n\
         <!-- Written by a test from bench/operation/help/messages.toml: FRICTION_BENCH_WRITE_HANDBOOK=1 -->\n\n\
         What the program says, what it means, and what to do. `…` stands for a value. On the bench's own computer\n\
         `friction-bench messages` looks a message up: paste it, or type a few of its words.\n\n\
         ```sh\nfriction-bench messages \"normal force 5.30 N over the limit of 5.00 N\"\n```\n",
    );
    for group in index() {
        let _ = writeln!(page, "\n## {}\n\n{}\n", group.title, group.intro);
        for message in &group.messages {
            let says = if message.says.chars().any(char::is_alphanumeric) {
                format!("`{}`", message.says.replace('`', "'"))
            } else {
                format!(
                    "*The device's or the system's own words* ({})",
                    plain(&message.of)
                )
            };
            let brief = message.brief.as_deref();
            let brief =
                brief.map_or_else(String::new, |brief| format!(" (on the screen `{brief}`)"));
            let _ = writeln!(
                page,
                "- {says}{brief}  \n  {} **{}**",
                message.means, message.remedy
            );
        }
    }
    page
}

/// Returns the name of the variant as words.
fn plain(path: &str) -> String {
    let name = path.rsplit("::").next().unwrap_or(path);
    let mut words = String::new();
    for character in name.chars() {
        if character.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(character.to_lowercase());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_like_many_messages_shows_a_few() {
        let nearest = text(&["the trial is broken because of the sensor".to_owned()]).unwrap();
        assert!(nearest.starts_with("No message has all"), "{nearest}");
        let shown = nearest.matches("→ ").count();
        assert!((1..=MOST_NEAREST).contains(&shown), "{shown}");
    }

    #[test]
    fn the_index_is_read_and_each_message_is_whole() {
        for group in index() {
            assert!(!group.sources.is_empty() || group.rows.is_some() || !group.lines.is_empty());
            for message in &group.messages {
                for text in [&message.says, &message.means, &message.remedy] {
                    assert!(!text.trim().is_empty(), "{message:?}");
                }
                for text in [&message.means, &message.remedy] {
                    let ends = [".", "\"", "?"].iter().any(|end| text.ends_with(end));
                    assert!(ends, "no end: {text}");
                }
            }
        }
    }

    #[test]
    fn a_message_that_is_looked_up_alone_refers_to_no_other_on_the_page() {
        for group in index() {
            for message in &group.messages {
                for text in [&message.means, &message.remedy] {
                    let refers = ["As above", "The same ", " above.", "above:", " below."]
                        .iter()
                        .any(|words| text.starts_with(words) || text.ends_with(words));
                    assert!(!refers, "{message:?}");
                }
            }
        }
    }

    #[test]
    fn every_message_is_in_both_texts_and_fits_the_terminal() {
        let (list, page) = (text(&[]).unwrap(), chapter());
        let flat = list.split_whitespace().collect::<Vec<_>>().join(" ");
        for message in index().iter().flat_map(|group| &group.messages) {
            assert!(flat.contains(&message.remedy), "{message:?}");
            assert!(page.contains(&message.means), "{message:?}");
        }
        for line in list.lines() {
            let long_word = !line.trim_start().contains(' ');
            assert!(line.chars().count() <= WIDTH || long_word, "{line}");
        }
    }

    #[test]
    fn a_message_is_found_by_its_words_on_the_screen() {
        for (line, words) in [
            (
                " TRIPPED  e-stop pressed or its wire cut · x to re-arm   simulated  UNCALIBRATED",
                "a cut wire",
            ),
            (
                "TRIPPED  stopped by the operator · x to re-arm",
                "sent the program a signal",
            ),
            (
                "! practice 1 rejected: finger off for 0.26 s, exploration 1",
                "never laid down",
            ),
            ("P1 ✗ finger off for 0.26 s", "never laid down"),
            (
                "now  REJECTED: force 0.49 N, band 0.50–0.80 · repeats in 6 s",
                "too lightly",
            ),
            (
                "4 instances, 5 needed, outside the plate's central part",
                "usable modulation periods",
            ),
            (
                "friction-bench: sub-01 already has my/sub-01/ses-01 in my: --resume goes on with it, --new-session begins another",
                "another visit",
            ),
            ("consent is not recorded: c", "have the sheet signed"),
            (
                "the force sensor's port is gone: no such device",
                "go on with --resume",
            ),
            (
                "the force sensor was not read for a quarter of a second · x to re-arm",
                "did not run",
            ),
            (
                "5000 g weigh 49.03 N, more than safety.max_normal_n = 5 N allows on the sensor: use masses up to 509 g",
                "in milligrams",
            ),
            ("0 g is not a mass: masses are above 0", "zero or negative"),
            ("250 is not an age: 1 to 120 whole years", "in whole years"),
            (
                "0.6366 μm, but the other points predict 0.9000 μm: peak, not RMS",
                "peak amplitude",
            ),
            (
                "condition slow gives at most 10 instances a trial",
                "a perfect finger",
            ),
        ] {
            let found = text(&[line.to_owned()]).unwrap();
            assert!(found.contains(words), "{line}: {found}");
            assert!(found.matches("→ ").count() <= 3, "{line}: {found}");
        }
        for line in [
            "drive reads back 3.1 V although disarmed",
            "exploration 2: mean normal force 0.93 N, outside 0.50 to 0.80 N",
            "E-STOP pressed",
            "input xrun at 3.204 s: the card or the computer was too slow; the recording marks the lost samples",
            "safety limits loosened: max_amplitude_um = 9",
            "the pickup's sensitivity is 1.9983 times the one in force (2.1 µm/V): peak-to-peak for amplitude?",
        ] {
            let matches = text(&[line.to_owned()]).unwrap();
            assert!(matches.lines().count() < 40, "{matches}");
        }
    }
}
