//! Words of warnings and errors about a recording in memory: its arguments in place of the files of a folder.

use analysis::findings::RecordingFindings;

/// Begin of the place of a row in a message; the number of its line follows.
const LINE: &str = "in line ";
/// Line of the first row of a file, below its header.
const FIRST_LINE: u64 = 2;

/// Phrases of messages about files, and the phrases about arguments that replace them, in this order: the longer first.
const PHRASES: [(&str, &str); 45] = [
    (
        "time_s was rounded, as a spreadsheet does that saves what it shows; take the file as the program of the sensor wrote it",
        "the times were rounded; pass them as the sensor gave them",
    ),
    ("force.csv is missing", "`normal` and `lateral` are missing"),
    ("position.csv is missing", "`position` is missing"),
    (
        "neither signals.wav nor envelopes.parquet",
        "neither `drive` nor `pickup`",
    ),
    ("force.csv: normal_n", "`normal`"),
    ("force.csv: lateral_n", "`lateral`"),
    ("position.csv: position_m", "`position`"),
    ("force.csv: its ", "`normal`, `lateral`: their "),
    ("force.csv: it ends", "`normal`, `lateral`: they end"),
    ("force.csv", "`normal`, `lateral`"),
    ("position.csv", "`position`"),
    ("normal_n", "`normal`"),
    ("lateral_n", "`lateral`"),
    ("position_m", "`position`"),
    (
        "time_s counts from the first sample of signals.wav",
        "times count from the first sample of `drive`",
    ),
    ("signals.wav has", "the arrays have"),
    ("that of signals.wav", "that of `drive` and `pickup`"),
    (
        "exchange channels.drive.index and channels.pickup.index",
        "exchange the two arguments",
    ),
    (
        "are equal in each row: one column was read twice; name the other one",
        "are equal throughout: one array was passed twice; pass the other one",
    ),
    (
        "the columns are exchanged; exchange their names",
        "they are exchanged; exchange the two arguments",
    ),
    ("signals.wav: ", ""),
    ("as recording.toml says", "as stated"),
    ("but recording.toml states", "but `pickup_scale` states"),
    (
        "recording.toml ([standard_errors], [room])",
        "`standard_errors` and `room`",
    ),
    (
        "recording.toml: the trial has no `end`",
        "`manifest`: the trial has no `end`",
    ),
    ("recording.toml: ", ""),
    (
        "which a recording with `[channels]` needs; a recording of forces alone has neither `carrier_hz` nor `[channels]` nor `[plate]`",
        "which drive and pickup need: pass it",
    ),
    (
        "its cable, its index and the program that wrote the file",
        "its cable and the program that recorded it",
    ),
    (
        "the program that wrote the file filled it up",
        "the program that recorded them filled them up",
    ),
    (
        "the program that wrote the file",
        "the program that recorded it",
    ),
    ("or the column was filled in", "or the array was filled in"),
    ("the gains of both columns", "the gains of both"),
    (
        "the file was copied in part, or the sensor fell silent; compare it with the original",
        "the array was cut, or the sensor fell silent; compare it with the original",
    ),
    ("delete these rows", "leave these readings out"),
    (
        "no row can be read below its header",
        "no reading can be used",
    ),
    (" rows", " readings"),
    ("to time_s", "to the times"),
    ("multiply time_s", "multiply the times"),
    ("time_s of", "the times of"),
    (
        "time_s, its start and its clock",
        "the times, their start and their clock",
    ),
    ("channels.drive.volts_per_unit", "drive_volts_per_unit"),
    ("check volts_per_unit", "check drive_volts_per_unit"),
    ("channels.drive.", "drive."),
    ("channels.pickup.", "pickup_scale."),
    ("channels.rate_hz", "rate_hz"),
];

/// Returns a message about the files of a recording in the words of the arguments that take their place, as of `analyze` in Python.
#[must_use]
pub fn in_arguments(message: &str) -> String {
    let message = PHRASES
        .iter()
        .fold(message.to_owned(), |message, (of_file, of_argument)| {
            message.replace(of_file, of_argument)
        });
    with_indices(&message)
}

/// Returns the warnings about a recording: those about one in memory name its arguments.
#[must_use]
pub fn warnings(findings: &RecordingFindings) -> Vec<String> {
    let texts = findings.flaws.iter().map(ToString::to_string);
    match findings.provenance.in_memory {
        false => texts.collect(),
        true => texts.map(|text| in_arguments(&text)).collect(),
    }
}

/// Returns a message in which the lines of rows are the indices of readings, from 0.
fn with_indices(message: &str) -> String {
    let mut parts = message.split(LINE);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let digits = part.bytes().take_while(u8::is_ascii_digit).count();
        let (number, rest) = part.split_at(digits);
        match number.parse::<u64>() {
            Ok(line) => text += &format!("at index {}{rest}", line.saturating_sub(FIRST_LINE)),
            Err(_) => text += &format!("{LINE}{part}"),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// Sources of the messages that a recording in memory can have.
    const SOURCES: [&str; 3] = [
        "../analysis/src/flaw.rs",
        "../plausibility/src/implausible.rs",
        "../../records/recording/src/read_error.rs",
    ];
    /// Words of folders.
    const FILE_WORDS: [&str; 12] = [
        ".csv",
        ".wav",
        ".toml",
        "normal_n",
        "lateral_n",
        "position_m",
        "time_s",
        " line",
        "column",
        "the file",
        " row",
        "channels.",
    ];
    /// Beginnings of messages about files that arrays do not have.
    const FOLDERS_ALONE: [&str; 6] = [
        "stimulus.csv: ",
        "{file}: {rows} rows cannot be read",
        "{file}: zeros instead of text",
        "the copy of the session's protocol",
        "the session was resumed with an edited protocol",
        "envelopes.parquet in place of signals.wav",
    ];

    /// Returns the texts of `#[error("…")]` in a source.
    fn texts(source: &str) -> Vec<String> {
        let mut texts = Vec::new();
        for attribute in source.split("#[error(").skip(1) {
            let start = attribute.trim_start();
            if let Some(text) = start.strip_prefix('"') {
                let end = text.find("\",").or_else(|| text.find("\"\n"));
                let end = end.into_iter().chain(text.find("\")]")).min().unwrap();
                // A backslash joins lines.
                let lines = text[..end].split("\\\n").map(str::trim_start);
                texts.push(lines.collect());
            }
        }
        texts
    }

    #[test]
    fn no_warning_about_arrays_names_a_file() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut seen = 0;
        for source in SOURCES {
            let source = fs::read_to_string(package.join(source)).unwrap();
            let warnings = source.rsplit("pub enum Warning").next().unwrap();
            for text in texts(warnings) {
                if FOLDERS_ALONE.iter().any(|begin| text.starts_with(begin)) {
                    continue;
                }
                seen += 1;
                for (file, column) in [("force.csv", "lateral_n"), ("position.csv", "position_m")] {
                    let text = text.replace("{file}", file).replace("{column}", column);
                    let text = text
                        .replace("{MANIFEST_FILE}", "recording.toml")
                        .replace("{SIGNALS_FILE}", "signals.wav")
                        .replace("{first_line}", "9");
                    let words = in_arguments(&text);
                    let found = FILE_WORDS.iter().find(|word| words.contains(**word));
                    assert_eq!(found, None, "{words}");
                }
            }
        }
        assert!(seen > 50, "{seen}");
    }

    #[test]
    fn sentences_about_arguments_stay_sentences() {
        for (of_files, of_arguments) in [
            (
                "force.csv: 3 rows have a value that is NaN or infinite, the first in line 9",
                "`normal`, `lateral`: 3 readings have a value that is NaN or infinite, the first at index 7",
            ),
            (
                "force.csv: it ends at 1 s, and the recording at 2 s: the file was copied in part, or the sensor fell silent; compare it \
                 with the original",
                "`normal`, `lateral`: they end at 1 s, and the recording at 2 s: the array was cut, or the sensor fell silent; compare it \
                 with the original",
            ),
            (
                "position.csv: position_m falls in every exploration stated as left_to_right, and grows in every one",
                "`position` falls in every exploration stated as left_to_right, and grows in every one",
            ),
            (
                "position.csv: its rows are 200 ms apart",
                "`position`: its readings are 200 ms apart",
            ),
        ] {
            assert_eq!(in_arguments(of_files), of_arguments);
        }
    }
}
