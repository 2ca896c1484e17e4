//! The map of files by their looks.

mod electrical;

use std::collections::BTreeMap;

use crate::file_pattern::FileFamily;
use crate::map_text::{MapText, Reason, check, number, quoted, sure};
use crate::names::{self, RateWord};
use crate::nature::{Nature, grouped};
use crate::portrait::{FilePortrait, RateOrigin, VectorPortrait};
use crate::purpose::{Family, Purpose, purpose};
use crate::roles::{Chosen, EnvelopeArrays, Roles, is_upside_down, roles};
use crate::scales::{exploration, has_force_unit, metres, newtons};
use crate::slow::Slow;

/// Map without any stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "no array looks like drive and pickup, complex envelopes, or a force: list the arrays with `friction-bench import --look`, \
     and write the map by hand as the handbook's chapter \"Recordings you already have\" shows"
)]
pub struct NoStreams;

/// Drafts a map of families of files.
///
/// # Errors
/// No array looks like a stream of a recording.
pub(crate) fn draft(families: Vec<Family>) -> Result<MapText, NoStreams> {
    let (streams, others): (Vec<_>, Vec<_>) = families
        .into_iter()
        .map(|family| (purpose(&family), family))
        .partition(|(purpose, _)| *purpose == Purpose::Streams);
    let (names, portraits): (Vec<FileFamily>, Vec<FilePortrait>) = streams
        .into_iter()
        .map(|(_, family)| (family.files, family.portrait))
        .unzip();
    let roles = roles(&portraits);
    let main = main_file(&roles).ok_or(NoStreams)?;
    let mut draft = Draft {
        map: MapText::default(),
        names: &names,
        portraits: &portraits,
        main,
    };
    draft.heading();
    match (&roles.signals, &roles.envelopes) {
        (Some((drive, pickup)), _) => draft.signals(drive, pickup),
        (None, Some(pair)) => draft.envelopes(pair),
        (None, None) => {}
    }
    let reference = draft.forces(&roles);
    draft.place(&roles, reference);
    if roles.signals.is_some() || roles.envelopes.is_some() {
        draft.plate(
            &roles,
            others
                .iter()
                .find(|(purpose, _)| *purpose == Purpose::Sweep)
                .map(|(_, family)| family),
        );
    }
    if roles.signals.is_some()
        && let Some((_, family)) = others
            .iter()
            .find(|(purpose, _)| *purpose == Purpose::Baseline)
    {
        draft.map.table("baseline");
        let (name, reason) =
            draft.other_file(&family.files, "named as a recording of the plate alone");
        draft.map.key("file", &name, reason);
    }
    if roles.signals.is_none() && roles.envelopes.is_none() {
        draft.contact(&roles);
    }
    draft.intervals(
        &roles,
        others
            .iter()
            .find(|(purpose, _)| *purpose == Purpose::Marks)
            .map(|(_, family)| family),
    );
    if let Some((_, family)) = others
        .iter()
        .find(|(purpose, _)| *purpose == Purpose::Participants)
    {
        draft.map.table("participants");
        draft.map.key(
            "table",
            &quoted(&family.files.names[0]),
            sure("it has a column of participants"),
        );
    }
    draft.rest(&roles);
    Ok(draft.map)
}

/// Returns the file that stands for `files`: that of the drive, or of the first stream.
fn main_file(roles: &Roles<'_>) -> Option<usize> {
    let signals = roles.signals.as_ref().map(|(drive, _)| drive.file);
    let envelopes = roles.envelopes.as_ref().map(|pair| pair.file);
    let forces = roles
        .normal
        .as_ref()
        .or(roles.lateral.as_ref())
        .map(|chosen| chosen.file);
    signals.or(envelopes).or(forces)
}

/// A map under way.
struct Draft<'a> {
    map: MapText,
    names: &'a [FileFamily],
    portraits: &'a [FilePortrait],
    /// Index of the family that `files` describes.
    main: usize,
}

/// Times that a stream takes over: its file and length, and whether they are the drive's.
#[derive(Debug, Clone, Copy)]
struct Reference {
    file: usize,
    length: u64,
}

impl Draft<'_> {
    fn heading(&mut self) {
        let family = &self.names[self.main];
        let portrait = &self.portraits[self.main];
        let others = match family.names.len() - 1 {
            0 => String::new(),
            1 => " and 1 file with a name like it".to_owned(),
            count => format!(" and {count} files with names like it"),
        };
        self.map.comment(format!(
            "Guessed from {} ({}){others}: only the first was looked at.",
            family.names[0], portrait.format
        ));
        self.map.comment(
            "Check the lines marked CHECK, then try it: friction-bench import MAP --dry-run",
        );
        for note in &portrait.notes {
            self.map.comment(format!("Note: {note}"));
        }
        self.map
            .key("format", "1", sure("version of this map's format"));
        let (reason, is_sure) = family.reason();
        self.map.key(
            "files",
            &quoted(&family.pattern()),
            Reason {
                text: reason,
                is_sure,
            },
        );
    }

    /// Adds the forces, and returns the times that the finger's place follows.
    fn forces(&mut self, roles: &Roles<'_>) -> Option<Reference> {
        let drive = roles.signals.as_ref().map(|(drive, _)| Reference {
            file: drive.file,
            length: drive.vector.length,
        });
        let mut reference: Option<Reference> = None;
        if let Some(normal) = &roles.normal {
            self.map.table("normal");
            self.source(normal, self.main);
            self.rate(normal.vector);
            let (scale, reason) = newtons(normal.vector, is_upside_down(normal.vector));
            self.map.key("newtons_per_unit", &number(scale), reason);
            self.tare(normal.vector);
            self.clock(normal, drive);
            reference = Some(Reference {
                file: normal.file,
                length: normal.vector.length,
            });
        }
        if let Some(lateral) = &roles.lateral {
            self.map.table("lateral");
            self.source(lateral, self.main);
            let is_alike = reference.is_some_and(|reference| {
                reference.file == lateral.file && reference.length == lateral.vector.length
            });
            if !is_alike {
                self.rate(lateral.vector);
            }
            let (scale, reason) = newtons(lateral.vector, Some(false));
            let reason = Reason {
                text: format!("{}; its sign turns with the direction", reason.text),
                ..reason
            };
            self.map.key("newtons_per_unit", &number(scale), reason);
            self.tare(lateral.vector);
            match is_alike {
                true => self.map.comment("rate, clock, offset_s and ppm are those of the normal force: as many values in one file"),
                false => self.clock(lateral, drive),
            }
            reference = reference.or(Some(Reference {
                file: lateral.file,
                length: lateral.vector.length,
            }));
        }
        reference.or(drive)
    }

    fn tare(&mut self, vector: &VectorPortrait) {
        match &vector.nature {
            Nature::Slow(Slow::Steps(steps)) => {
                let text = format!("it rests at {} where nothing touches", statistics::significant((steps.rest * 1e4).round() / 1e4 + 0.0));
                let reason = Reason {
                    text,
                    is_sure: steps.is_rest_certain,
                };
                self.map.key("tare", "\"no contact\"", reason);
            }
            _ => self.map.key("tare", "\"none\"", check("no rest is seen: write \"no contact\" if the recording has stretches without contact")),
        }
    }

    fn clock(&mut self, chosen: &Chosen<'_>, drive: Option<Reference>) {
        let Some(drive) = drive else { return };
        if drive.file == chosen.file && drive.length == chosen.vector.length {
            self.map.key(
                "clock",
                "\"same\"",
                sure("as many values as the drive, in one file: one converter"),
            );
        } else {
            self.map.key(
                "clock",
                "\"own\"",
                sure("another rate or another file than the drive's"),
            );
            self.map
                .key("offset_s", "\"found\"", sure("from contact and friction"));
            self.map
                .key("ppm", "\"found\"", sure("from contact and friction"));
        }
    }

    fn place(&mut self, roles: &Roles<'_>, reference: Option<Reference>) {
        let (table, chosen) = match (&roles.position, &roles.velocity) {
            (Some(position), _) => ("position", position),
            (None, Some(velocity)) => ("velocity", velocity),
            (None, None) => return,
        };
        self.map.table(table);
        self.source(chosen, self.main);
        let vector = chosen.vector;
        let is_alike = reference.is_some_and(|reference| {
            reference.file == chosen.file && reference.length == vector.length
        });
        match is_alike {
            true => self.map.comment(
                "rate and clock are those of the stream above with as many values in one file",
            ),
            false => self.rate(vector),
        }
        let (scale, reason) = metres(vector, table == "velocity");
        self.map.key("metres_per_unit", &number(scale), reason);
        if let Nature::Slow(Slow::Counts(counts)) = &vector.nature
            && let Some(bits) = counts.wrap_bits
        {
            self.map.key(
                "wrap_bits",
                &bits.to_string(),
                sure(format!("the counts leap by 2^{bits}")),
            );
        }
    }

    fn plate(&mut self, roles: &Roles<'_>, sweep: Option<&Family>) {
        self.map.table("plate");
        let mass = self.number_named(&["modalmass", "modalmasskg", "mp", "platemass", "mass", "m"]);
        match mass.filter(|(_, mass)| (1e-5..=10.0).contains(mass)) {
            Some((name, mass)) => self.map.key(
                "modal_mass_kg",
                &number(mass),
                check(format!("`{name}` states it, by its name")),
            ),
            None => self.map.key(
                "modal_mass_kg",
                "8.0e-3",
                check("no file states it: write your plate's, in kg"),
            ),
        }
        if let Some(sweep) = sweep {
            self.map.key(
                "sweep",
                &quoted(&sweep.files.names[0]),
                sure("a frequency with two columns of an admittance or impedance"),
            );
        } else {
            let carrier =
                roles
                    .signals
                    .as_ref()
                    .and_then(|(drive, _)| match &drive.vector.nature {
                        Nature::Carrier(carrier) => {
                            drive.vector.rate_hz().map(|_| carrier.frequency_hz)
                        }
                        _ => None,
                    });
            let hz = number(carrier.map_or(35_000.0, f64::round));
            self.map.key(
                "resonance_hz",
                &hz,
                check("no file states it: the carrier is near it; or sweep = \"FILE\""),
            );
            self.map.key(
                "force_factor_n_per_v",
                "0.1",
                check("no file states it: write the actuators' force per volt"),
            );
        }
    }

    fn contact(&mut self, roles: &Roles<'_>) {
        self.map.table("contact");
        let forces = [&roles.normal, &roles.lateral].into_iter().flatten();
        let largest = forces.filter_map(|chosen| {
            let extremes = chosen.vector.extremes.as_ref()?;
            let size = extremes.greatest.abs().max(extremes.least.abs());
            has_force_unit(chosen.vector).then(|| size * newtons(chosen.vector, None).0.abs())
        });
        let largest_n = largest.fold(0.0, f64::max);
        let reason =
            check("a finger or another body? \"other\" turns the ranges off that hold for fingers");
        self.map.key(
            "body",
            if largest_n > MOST_OF_FINGER_N {
                "\"other\""
            } else {
                "\"finger\""
            },
            reason,
        );
    }

    fn intervals(&mut self, roles: &Roles<'_>, marks: Option<&Family>) {
        self.map.table("intervals");
        if let Some(marks) = marks {
            let (name, reason) =
                self.other_file(&marks.files, "it has the columns kind, start_s and end_s");
            self.map.key("marks", &name, reason);
            return;
        }
        if let Some(normal) = &roles.normal {
            let is_clear = match &normal.vector.nature {
                Nature::Slow(Slow::Steps(steps)) if has_force_unit(normal.vector) => {
                    newtons(normal.vector, None).0.abs() * steps.up.max(steps.down) > 0.2
                }
                _ => false,
            };
            let text = "the finger presses with more; a sensor's noise is less";
            let reason = if is_clear {
                sure(text)
            } else {
                check(format!("{text}: is it so here?"))
            };
            self.map
                .key("unloaded", "\"normal < 0.05 N for 0.3 s\"", reason);
        } else {
            self.map.comment("unloaded needs a normal force or marks: without it, the plate is not read without a finger");
        }
        match (roles.position.as_ref(), roles.velocity.as_ref()) {
            (Some(chosen), _) | (None, Some(chosen)) => {
                let (rule, reason) = exploration(chosen.vector, roles.position.is_none());
                self.map.key("exploration", &quoted(&rule), reason);
            }
            (None, None) => self
                .map
                .comment("exploration needs a position, a velocity, or marks"),
        }
    }

    /// Adds the arrays that no line uses.
    fn rest(&mut self, roles: &Roles<'_>) {
        let chosen = [
            &roles.normal,
            &roles.lateral,
            &roles.position,
            &roles.velocity,
        ];
        let mut used: Vec<&VectorPortrait> = chosen
            .into_iter()
            .flatten()
            .map(|chosen| chosen.vector)
            .collect();
        used.extend(
            roles
                .signals
                .iter()
                .flat_map(|(drive, pickup)| [drive.vector, pickup.vector]),
        );
        for arrays in roles
            .envelopes
            .iter()
            .flat_map(|pair| [&pair.drive, &pair.pickup])
        {
            match arrays {
                EnvelopeArrays::Complex(a) => used.push(a),
                EnvelopeArrays::Parts(a, b) | EnvelopeArrays::Polar(a, b) => used.extend([*a, *b]),
            }
        }
        let is_rest = |vector: &&VectorPortrait| {
            !matches!(vector.nature, Nature::Time(_) | Nature::Ramp(_))
                && !used.iter().any(|stream| std::ptr::eq(*stream, *vector))
        };
        let rest: Vec<&VectorPortrait> = self
            .portraits
            .iter()
            .flat_map(|file| &file.vectors)
            .filter(is_rest)
            .collect();
        if !rest.is_empty() {
            self.map.comment("Not used:");
        }
        for vector in rest {
            self.map
                .comment(format!("  {}: {}", vector.name, vector.nature_text()));
        }
    }

    /// Adds the file, where it is another one than `file`, and the array.
    fn source(&mut self, chosen: &Chosen<'_>, file: usize) {
        if chosen.file != file {
            let (name, reason) = self.other_file(&self.names[chosen.file], "the array is in it");
            self.map.key("file", &name, reason);
        }
        let reason = Reason {
            text: chosen.reason.clone(),
            is_sure: chosen.is_sure,
        };
        self.map.key("from", &quoted(&chosen.vector.name), reason);
    }

    /// Returns the name of another family of files as a value, with placeholders.
    fn other_file(&self, family: &FileFamily, text: &str) -> (String, Reason) {
        match family.template(&self.names[self.main]) {
            Some(name) => (quoted(&name), sure(text)),
            None => {
                let text = format!(
                    "{text}; a part of its name is not captured by files: put {{participant}} and {{trial}} in its place"
                );
                (quoted(&family.names[0]), check(text))
            }
        }
    }

    fn rate(&mut self, vector: &VectorPortrait) {
        let Some(rate) = &vector.rate else {
            self.map.key(
                "rate_hz",
                "1000.0",
                check("no file states it: write the rate of the samples"),
            );
            return;
        };
        let hz = grouped(rate.hz).replace('\u{a0}', " ");
        match &rate.origin {
            RateOrigin::File => self.map.key(
                "rate_hz",
                "\"file\"",
                sure(format!("the file states {hz} Hz")),
            ),
            RateOrigin::Scalar(name, RateWord::Rate) => {
                self.map.key(
                    "rate_hz",
                    &quoted(name),
                    sure(format!("the scalar `{name}` is {hz}")),
                );
            }
            RateOrigin::Scalar(name, RateWord::Interval) => {
                self.map.key(
                    "rate_hz",
                    &number(rate.hz),
                    check(format!(
                        "the scalar `{name}` states the interval, by its name"
                    )),
                );
            }
            RateOrigin::Times(name, unit) => {
                self.map.key(
                    "time",
                    &quoted(name),
                    sure(format!("an array of times of the same length, {hz} Hz")),
                );
                match unit.seconds() {
                    Some(seconds) if seconds != 1.0 => {
                        self.map.key(
                            "seconds_per_unit",
                            &number(seconds),
                            sure(format!("its times are in {}", unit.symbol())),
                        );
                    }
                    _ => {}
                }
            }
            RateOrigin::Duration => {
                let text = "no file states it: with this rate it lasts as long as the other arrays";
                self.map.key("rate_hz", &number(rate.hz), check(text));
            }
        }
    }

    /// Returns a single number of the streams' files by the words of its name.
    fn number_named(&self, words: &[&str]) -> Option<(String, f64)> {
        let singles = self.portraits.iter().flat_map(|file| &file.singles);
        let numbers: BTreeMap<String, (String, f64)> = singles
            .filter_map(|single| {
                let joined = names::words(&names::leaf(&single.name)).concat();
                single
                    .number
                    .map(|number| (joined, (single.name.clone(), number)))
            })
            .collect();
        words.iter().find_map(|word| numbers.get(*word).cloned())
    }
}

/// Largest force of a finger in experiments, N.
const MOST_OF_FINGER_N: f64 = 20.0;
