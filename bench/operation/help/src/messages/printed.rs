//! Message index for a terminal and as a chapter of the handbook.

use std::fmt::Write;

use clap::Args;
use textwrap::WordSplitter;

use crate::messages::{MessageGroup, ProgramMessage, index};

/// Width of the index on a terminal.
const WIDTH: usize = 96;
/// Indentation of meaning and remedy.
const INDENT: &str = "    ";
/// Most messages that are shown where none has all words.
const MOST_NEAREST: usize = 5;

/// `messages`; without words it prints all messages.
#[derive(Debug, Clone, Args)]
pub struct MessagesOptions {
    /// Message to look up, or words of it; numbers are ignored, so that text can be pasted from the screen [default: all].
    #[arg(value_name = "WORDS")]
    pub words: Vec<String>,
}

/// Returns the messages that contain all `words`, or else those that contain most of them, since a line of the screen has words
/// beside the message; as lines for a terminal. `None` if no message has half of them.
///
/// ```
/// let found = help::messages::text(&["normal force 5.30 N over".to_owned()]).unwrap();
/// assert!(found.contains("safety.max_normal_n") && !found.contains("e-stop pressed"));
/// let line = "TRIPPED  normal force 5.30 N over the limit of 5.00 N · x to re-arm  simulated";
/// let nearest = help::messages::text(&[line.to_owned()]).unwrap();
/// assert!(nearest.starts_with("No message has all") && nearest.contains("safety.max_normal_n"));
/// assert_eq!(help::messages::text(&["unheard-of".to_owned()]), None);
/// ```
#[must_use]
pub fn text(words: &[String]) -> Option<String> {
    let query: Vec<String> = words.iter().flat_map(|text| telling(text)).collect();
    let mut written = String::new();
    let least = least_share(&query)?;
    if least < 1.0 {
        written.push_str("No message has all of these words. The nearest:\n\n");
    }
    let mut left = if least < 1.0 {
        MOST_NEAREST
    } else {
        usize::MAX
    };
    for group in index() {
        let matches: Vec<_> = group
            .messages
            .iter()
            .filter(|message| share(&group, message, &query) >= least)
            .take(left)
            .collect();
        left -= matches.len();
        if matches.is_empty() {
            continue;
        }
        let line = "=".repeat(group.title.chars().count());
        let _ = writeln!(written, "{}\n{line}\n", group.title);
        if query.is_empty() {
            written.push_str(&paragraph(&group.intro, ""));
            written.push('\n');
        }
        for message in matches {
            written.push_str(&paragraph(&message.says, ""));
            if let Some(brief) = &message.brief {
                written.push_str(&paragraph(&format!("on the screen: {brief}"), INDENT));
            }
            written.push_str(&paragraph(&message.means, INDENT));
            written.push_str(&paragraph(&format!("→ {}", message.remedy), INDENT));
            written.push('\n');
        }
    }
    (!written.is_empty()).then(|| written.trim_end().to_owned() + "\n")
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
    let words = text.split_whitespace().map(str::to_lowercase);
    let trimmed = words.map(|word| word.trim_matches(|c: char| !c.is_alphanumeric()).to_owned());
    trimmed
        .filter(|word| !word.is_empty() && !word.contains(|c: char| c.is_ascii_digit()))
        .collect()
}

/// Returns the greatest share of the query that any message has; `None` if none has half of it.
fn least_share(query: &[String]) -> Option<f64> {
    let groups = index();
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
    let letters = |words: &mut dyn Iterator<Item = &String>| -> usize {
        words.map(|word| word.chars().count()).sum()
    };
    let held = letters(&mut query.iter().filter(|word| content.contains(word.as_str())));
    let total = letters(&mut query.iter());
    if total == 0 {
        return 1.0;
    }
    held as f64 / total as f64
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
        for line in [
            "drive reads back 3.1 V although disarmed",
            "exploration 2: mean normal force 0.93 N, outside 0.50 to 0.80 N",
            "E-STOP pressed",
            "REJECTED: force 0.49 N, band 0.50–0.80",
            "4 instances, 5 needed, outside the plate's central part",
            "input xrun at 3.204 s: the card or the computer was too slow; the recording marks the lost samples",
            "safety limits loosened: max_amplitude_um = 9",
            "the pickup's sensitivity is 1.9983 times the one in force (2.1 µm/V): peak-to-peak for amplitude?",
        ] {
            let matches = text(&[line.to_owned()]).unwrap();
            assert!(matches.lines().count() < 40, "{matches}");
        }
    }
}
