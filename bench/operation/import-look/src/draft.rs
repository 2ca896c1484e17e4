//! The map of files by their looks.

use std::collections::BTreeMap;

use crate::file_pattern::FileFamily;
use crate::map_text::{MapText, Reason, check, number, quoted, sure};
use crate::names::{self, RateWord, UnitMeaning};
use crate::nature::{Nature, frequency_text, grouped};
use crate::portrait::{FilePortrait, RateOrigin, VectorPortrait};
use crate::roles::{Chosen, EnvelopeArrays, EnvelopePair, Roles, is_upside_down, roles};
use crate::slow::Slow;

/// Names of files by their streams: one of each family is looked at.
#[derive(Debug)]
pub(crate) struct Family {
    pub files: FileFamily,
    pub portrait: FilePortrait,
}

/// Purpose of a family of files other than streams of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Streams,
    Participants,
    Marks,
    Baseline,
    Sweep,
}

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

/// Returns the file whose names `files` describes: that of the drive, or of the first stream.
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

/// Names of files of the plate alone.
const BASELINES: &[&str] = &[
    "noload",
    "unloaded",
    "baseline",
    "freeplate",
    "nofinger",
    "blank",
    "empty",
    "notouch",
];

fn purpose(family: &Family) -> Purpose {
    let portrait = &family.portrait;
    let vectors = portrait.vectors.iter().map(|vector| vector.name.as_str());
    let columns: Vec<String> = vectors
        .chain(portrait.singles.iter().map(|single| single.name.as_str()))
        .map(|name| names::leaf(name).to_lowercase())
        .collect();
    let has = |name: &str| columns.iter().any(|column| column == name);
    let short: Vec<String> = columns
        .iter()
        .map(|column| names::words(column).first().cloned().unwrap_or_default())
        .collect();
    let begins = |name: &str| short.iter().any(|word| word == name);
    let is_sweep = (begins("f") || begins("freq") || begins("frequency"))
        && ((begins("g") && begins("b"))
            || (begins("r") && begins("x"))
            || (begins("mag") && begins("phase")));
    let stem = family.files.names[0].rsplit('/').next().unwrap_or_default();
    let stem: String = names::words(stem.split('.').next().unwrap_or_default()).concat();
    if has("start_s") && has("end_s") && has("kind") {
        Purpose::Marks
    } else if has("participant_id") || has("participant") {
        Purpose::Participants
    } else if is_sweep
        && portrait
            .vectors
            .iter()
            .all(|vector| !matches!(vector.nature, Nature::Carrier(_)))
    {
        Purpose::Sweep
    } else if BASELINES.iter().any(|word| stem.contains(word)) {
        Purpose::Baseline
    } else {
        Purpose::Streams
    }
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

    fn signals(&mut self, drive: &Chosen<'_>, pickup: &Chosen<'_>) {
        let Nature::Carrier(carrier) = &drive.vector.nature else {
            return;
        };
        let rate_hz = drive.vector.rate_hz();
        self.map.table("carrier");
        let text = format!(
            "the drive's spectrum has {}",
            frequency_text(carrier.frequency_hz, rate_hz)
        );
        self.map
            .key("hz", "\"found\"", sure(text.replace('\u{a0}', " ")));
        self.map.table("modulation");
        match &carrier.modulation {
            Some(modulation) => {
                let text = match rate_hz {
                    Some(_) => {
                        format!("the drive's envelope has {:.2} Hz", modulation.frequency_hz)
                    }
                    None => "the drive's envelope is modulated".to_owned(),
                };
                self.map.key("hz", "\"found\"", sure(text));
                self.map.key(
                    "index",
                    "\"found\"",
                    sure(format!("the drive's envelope has {:.3}", modulation.index)),
                );
            }
            None => {
                self.map.key(
                    "hz",
                    "0.0",
                    check("no modulation was seen in the stretch looked at"),
                );
                self.map.key(
                    "index",
                    "0.0",
                    check("no modulation was seen in the stretch looked at"),
                );
            }
        }
        self.map.table("drive");
        self.source(drive, self.main);
        self.rate(drive.vector);
        match drive.vector.unit_meaning() {
            Some(UnitMeaning::Volts(volts)) => {
                let text = format!(
                    "stated in {}: is it the amplifier's output, not its input?",
                    unit(drive.vector)
                );
                self.map.key("volts_per_unit", &number(volts), check(text));
            }
            _ => {
                let text = format!(
                    "no unit is stated; its crests are {}: write the actuators' volts for 1",
                    grouped(carrier.amplitude).replace('\u{a0}', " ")
                );
                self.map.key("volts_per_unit", "1.0", check(text));
            }
        }
        self.map.table("pickup");
        self.source(pickup, drive.file);
        let (quantity, scale, reason) = pickup_scale(pickup.vector);
        self.map.key("quantity", &quoted(quantity), reason.clone());
        match scale {
            Some(scale) => self.map.key(
                "metres_per_unit",
                &number(scale),
                sure(format!("stated in {}", unit(pickup.vector))),
            ),
            None => {
                let text = "no unit of a motion is stated: the scale with which the unloaded plate has the modal mass, or write the number";
                self.map
                    .key("metres_per_unit", "\"from modal mass\"", check(text));
            }
        }
        self.map.key(
            "phase_rad",
            "\"found\"",
            sure("from the unloaded plate, with the converter's skew in it"),
        );
    }

    fn envelopes(&mut self, pair: &EnvelopePair<'_>) {
        let first = pair.drive.first();
        self.map.table("carrier");
        let stated = self.number_named(&[
            "carrier",
            "carrierhz",
            "fcarrier",
            "fc",
            "reffreq",
            "fref",
            "frequency",
            "freq",
            "demodfreq",
        ]);
        match stated.filter(|(_, hz)| (1e3..=1e6).contains(hz)) {
            Some((name, hz)) => self.map.key(
                "hz",
                &number(hz),
                check(format!("`{name}` states it, by its name")),
            ),
            None => self.map.key(
                "hz",
                "35000.0",
                check("no file states it: write the lock-in amplifier's frequency"),
            ),
        }
        self.map.table("modulation");
        self.map.key("hz", "\"found\"", sure("from the envelope"));
        self.map
            .key("index", "\"found\"", sure("from the envelope"));
        self.map.table("envelopes");
        let reason = || Reason {
            text: pair.reason.clone(),
            is_sure: pair.is_sure,
        };
        self.map.key("drive", &arrays(&pair.drive), reason());
        self.map.key("pickup", &arrays(&pair.pickup), reason());
        self.rate(first);
        match first.unit_meaning() {
            Some(UnitMeaning::Volts(volts)) => {
                let text = format!(
                    "stated in {}: is it the amplifier's output, not its input?",
                    unit(first)
                );
                self.map.key("volts_per_unit", &number(volts), check(text));
            }
            _ => self.map.key(
                "volts_per_unit",
                "1.0",
                check("no unit is stated: write the actuators' volts for 1"),
            ),
        }
        let (quantity, scale, reason) = pickup_scale(pair.pickup.first());
        self.map.key("quantity", &quoted(quantity), reason);
        match scale {
            Some(scale) => self.map.key(
                "metres_per_unit",
                &number(scale),
                sure(format!("stated in {}", unit(pair.pickup.first()))),
            ),
            None => self.map.key(
                "metres_per_unit",
                "\"from modal mass\"",
                check("no unit of a motion is stated: or write the number"),
            ),
        }
        self.map.key(
            "convention",
            "\"exp(+iwt)\"",
            check("files do not state it; most lock-in amplifiers have it"),
        );
        self.map.key(
            "rms",
            "true",
            check("files do not state it; most lock-in amplifiers write RMS"),
        );
        let text = "a low-pass of the instrument is undone where the map states it: low_pass = { order = 4, tau_s = 1.0e-4 }";
        self.map.comment(text);
        self.map
            .key("phase_rad", "\"found\"", sure("from the unloaded plate"));
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
                self.map.key("tare", "\"no contact\"", sure(text));
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
                && !used.iter().any(|other| std::ptr::eq(*other, *vector))
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

fn unit(vector: &VectorPortrait) -> String {
    vector.unit_text().unwrap_or_default()
}

fn arrays(arrays: &EnvelopeArrays<'_>) -> String {
    match arrays {
        EnvelopeArrays::Complex(vector) => quoted(&vector.name),
        EnvelopeArrays::Parts(real, imaginary) => {
            format!("[{}, {}]", quoted(&real.name), quoted(&imaginary.name))
        }
        EnvelopeArrays::Polar(amplitude, phase) => {
            format!(
                "{{ amplitude = {}, phase_rad = {} }}",
                quoted(&amplitude.name),
                quoted(&phase.name)
            )
        }
    }
}

/// Returns the quantity of a pickup, and its scale in SI units if the unit states it.
fn pickup_scale(vector: &VectorPortrait) -> (&'static str, Option<f64>, Reason) {
    let stated = || sure(format!("stated in {}", unit(vector)));
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) => ("displacement", Some(scale), stated()),
        Some(UnitMeaning::MetresPerSecond(scale)) => ("velocity", Some(scale), stated()),
        Some(UnitMeaning::MetresPerSquareSecond(scale)) => ("acceleration", Some(scale), stated()),
        Some(UnitMeaning::Coulombs(_)) => ("charge", None, stated()),
        _ => {
            let words = names::words(&names::leaf(&vector.name)).concat();
            let by_name = |parts: &[&str]| parts.iter().any(|part| words.contains(part));
            if by_name(&["vel", "ldv", "vibrometer", "polytec"]) {
                (
                    "velocity",
                    None,
                    check("by its name; a vibrometer may also give displacement"),
                )
            } else if by_name(&["acc"]) {
                ("acceleration", None, check("by its name"))
            } else {
                (
                    "displacement",
                    None,
                    check("no unit is stated: displacement, velocity, acceleration or charge"),
                )
            }
        }
    }
}

/// Returns newtons per unit with the sign that makes pressing positive.
fn newtons(vector: &VectorPortrait, is_upside_down: Option<bool>) -> (f64, Reason) {
    let sign = if is_upside_down == Some(true) {
        -1.0
    } else {
        1.0
    };
    let direction = match is_upside_down {
        Some(true) => "; it falls at contact, so its sign is turned",
        Some(false) => "",
        None => "; its direction is not seen",
    };
    match vector.unit_meaning() {
        Some(UnitMeaning::Newtons(scale)) => {
            let text = format!("stated in {}{direction}", unit(vector));
            (
                sign * scale,
                Reason {
                    text,
                    is_sure: is_upside_down.is_some(),
                },
            )
        }
        Some(UnitMeaning::Volts(_)) => (
            sign,
            check(format!(
                "stated in {}: write the sensor's newtons per volt{direction}",
                unit(vector)
            )),
        ),
        _ => {
            let largest = vector.extremes.as_ref().map_or(0.0, |extremes| {
                extremes.greatest.abs().max(extremes.least.abs())
            });
            let text = format!(
                "no unit is stated; its largest value is {}{direction}",
                statistics::significant(largest)
            );
            (sign, check(text))
        }
    }
}

fn has_force_unit(vector: &VectorPortrait) -> bool {
    matches!(vector.unit_meaning(), Some(UnitMeaning::Newtons(_)))
}

/// Returns metres, or m/s, per unit.
fn metres(vector: &VectorPortrait, is_velocity: bool) -> (f64, Reason) {
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) if !is_velocity => (
            scale,
            sure(format!(
                "stated in {}; left to right is growing position",
                unit(vector)
            )),
        ),
        Some(UnitMeaning::MetresPerSecond(scale)) if is_velocity => {
            (scale, sure(format!("stated in {}", unit(vector))))
        }
        _ => match &vector.nature {
            Nature::Slow(Slow::Counts(counts)) => {
                let text = format!(
                    "counts of an encoder over {} counts: write the metres of one",
                    grouped(counts.travel.range).replace('\u{a0}', " ")
                );
                (1e-6, check(text))
            }
            _ => {
                let range = vector
                    .extremes
                    .as_ref()
                    .map_or(0.0, |extremes| extremes.greatest - extremes.least);
                // A finger travels 1 to 50 cm, at up to 0.5 m/s.
                match range {
                    range if (0.01..=1.0).contains(&range) => (
                        1.0,
                        check(format!(
                            "no unit is stated; its range of {range:.3} is that of metres"
                        )),
                    ),
                    range if (10.0..=1_000.0).contains(&range) => (
                        1e-3,
                        check(format!(
                            "no unit is stated; its range of {range:.1} is that of millimetres"
                        )),
                    ),
                    range => (
                        1.0,
                        check(format!(
                            "no unit is stated; its range is {}",
                            statistics::significant(range)
                        )),
                    ),
                }
            }
        },
    }
}

/// Largest force of a finger in experiments, N.
const MOST_OF_FINGER_N: f64 = 20.0;
/// Parts of a course over which a speed is taken: few enough for a stroke, many for even counts of samples.
const SPEED_PARTS: usize = 8;
/// Speeds of a rule about the median speed of the strokes.
const SPEED_BAND: (f64, f64) = (0.7, 1.3);

/// Returns the rule of explorations by the speed of the strokes.
fn exploration(vector: &VectorPortrait, is_velocity: bool) -> (String, Reason) {
    let default = || {
        (
            "40 to 60 mm/s for 0.5 s".to_owned(),
            check("the speeds of the published study: write those of your strokes"),
        )
    };
    let (scale, scale_reason) = metres(vector, is_velocity);
    let Some(rate_hz) = vector.rate_hz() else {
        return default();
    };
    let part_s = vector.length as f64 / rate_hz / vector.course.len().max(1) as f64;
    let speeds: Vec<f64> = match is_velocity {
        true => vector.course.iter().map(|v| (v * scale).abs()).collect(),
        false => vector
            .course
            .windows(SPEED_PARTS + 1)
            .map(|parts| {
                ((parts[SPEED_PARTS] - parts[0]) * scale / part_s / SPEED_PARTS as f64).abs()
            })
            .collect(),
    };
    let fastest = speeds
        .iter()
        .copied()
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max);
    let moving = speeds.into_iter().filter(|speed| *speed > 0.2 * fastest);
    let Some(median) = statistics::median(moving).filter(|median| (1e-6..=2.0).contains(median))
    else {
        return default();
    };
    let mm = |share: f64| two_digits(1e3 * share * median);
    let rule = format!(
        "{} to {} mm/s for 0.5 s",
        mm(SPEED_BAND.0),
        mm(SPEED_BAND.1)
    );
    let text = format!(
        "the strokes' median speed is {} mm/s",
        two_digits(1e3 * median)
    );
    (
        rule,
        Reason {
            text,
            is_sure: scale_reason.is_sure,
        },
    )
}

fn two_digits(value: f64) -> String {
    statistics::significant(format!("{value:.1e}").parse().unwrap_or(value))
}
