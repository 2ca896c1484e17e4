//! Tables of forces, and of the finger's place.

use super::Draft;
use crate::map_text::{Reason, check, number, sure};
use crate::nature::Nature;
use crate::portrait::{RateOrigin, VectorPortrait};
use crate::roles::{Chosen, Roles, is_upside_down};
use crate::scales::{lateral_newtons, metres, newtons};
use crate::slow::Slow;

/// Times that a stream takes over: its file and length, and whether they are the drive's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference {
    file: usize,
    length: u64,
}

impl Draft<'_> {
    /// Adds the forces, and returns the times that the finger's place follows.
    pub(super) fn forces(&mut self, roles: &Roles<'_>) -> Option<Reference> {
        // Envelopes have one clock as the samples of a drive have.
        let electrical = match (&roles.signals, &roles.envelopes) {
            (Some((drive, _)), _) => Some(drive.clone()),
            (None, Some(pair)) => Some(Chosen {
                file: pair.file,
                vector: pair.drive.first(),
                reason: String::new(),
                is_sure: true,
            }),
            (None, None) => None,
        };
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
            self.tare(normal.vector, scale);
            self.clock(normal, electrical.as_ref());
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
            let (scale, reason) = lateral_newtons(lateral.vector);
            self.map.key("newtons_per_unit", &number(scale), reason);
            self.tare(lateral.vector, scale);
            let drive = electrical.as_ref().filter(|_| !is_alike);
            let one_clock = drive.and_then(|drive| one_clock(lateral, drive));
            match (is_alike, &roles.normal, one_clock) {
                (true, ..) => self.map.comment("rate, clock, offset_s and ppm are those of the normal force: as many values in one file"),
                (false, _, Some(reason)) => self.map.key("clock", "\"same\"", reason),
                (false, Some(_), None) => self.map.comment("clock, offset_s and ppm are those of the normal force; write clock = \"own\" and offset_s if it began at another time"),
                (false, None, None) => self.clock(lateral, electrical.as_ref()),
            }
            reference = reference.or(Some(Reference {
                file: lateral.file,
                length: lateral.vector.length,
            }));
        }
        reference.or(drive)
    }

    fn tare(&mut self, vector: &VectorPortrait, newtons_per_unit: f64) {
        match &vector.nature {
            Nature::Slow(Slow::Steps(steps)) => {
                let text = format!("it rests at {} where nothing touches", statistics::significant((steps.rest * 1e4).round() / 1e4 + 0.0));
                let reason = Reason {
                    text,
                    is_sure: steps.is_rest_certain,
                };
                self.map.key("tare", "\"no contact\"", reason);
            }
            _ if offset_n(vector, newtons_per_unit) != 0.0 => {
                let newtons = offset_n(vector, newtons_per_unit);
                let text = "the array states an offset, which the tare takes; or \"no contact\" if there are stretches without contact";
                self.map.key("tare", &number(-newtons), check(text));
            }
            _ => self.map.key("tare", "\"none\"", check("no rest is seen: write \"no contact\" if the recording has stretches without contact")),
        }
    }

    fn clock(&mut self, chosen: &Chosen<'_>, drive: Option<&Chosen<'_>>) {
        let Some(drive) = drive else { return };
        if let Some(reason) = one_clock(chosen, drive) {
            self.map.key("clock", "\"same\"", reason);
            return;
        }
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

    pub(super) fn place(&mut self, roles: &Roles<'_>, reference: Option<Reference>) {
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
        let (scale, mut reason) = metres(vector, table == "velocity");
        let has_offset = vector
            .scaling
            .as_ref()
            .is_some_and(|scaling| scaling.offset != 0.0);
        if has_offset && table == "velocity" {
            reason = check(format!(
                "{}; no map states the offset: take it off the array",
                reason.text
            ));
        }
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
}

/// Returns the offset of an array in N, as its attributes state it; 0 without one.
fn offset_n(vector: &VectorPortrait, newtons_per_unit: f64) -> f64 {
    vector.scaling.as_ref().map_or(0.0, |scaling| {
        // The scale holds the factor, and the offset is in scaled units.
        newtons_per_unit / scaling.factor * scaling.offset
    })
}

/// Returns the reason for which a stream has the drive's clock; `None` where nothing shows it.
fn one_clock(chosen: &Chosen<'_>, drive: &Chosen<'_>) -> Option<Reason> {
    let (stream, lead) = (chosen.vector, drive.vector);
    if chosen.file != drive.file {
        return None;
    }
    if lead.length == stream.length {
        return Some(sure(
            "as many values as the drive, in one file: one converter",
        ));
    }
    let (rate, lead_rate) = (stream.rate.as_ref()?, lead.rate.as_ref()?);
    let is_stated = rate.origin != RateOrigin::Duration && lead_rate.origin != RateOrigin::Duration;
    if is_stated && (rate.hz / lead_rate.hz - 1.0).abs() < 1e-6 {
        return Some(sure("the drive's rate, in one file: one converter"));
    }
    let (start, lead_start) = (stream.start?, lead.start?);
    let apart_s = (start.begin_s - lead_start.begin_s).abs();
    let longest_s = lead.length as f64 / lead_rate.hz;
    let tick_s = 1.5 / rate.hz.min(lead_rate.hz);
    let are_times = [rate, lead_rate]
        .iter()
        .all(|rate| matches!(rate.origin, RateOrigin::Times(_)));
    match (start.is_of_day, lead_start.is_of_day) {
        (true, true) if apart_s < tick_s => Some(sure(
            "it starts with the drive, in one file: synchronous converters",
        )),
        (true, true) if are_times && apart_s < longest_s => Some(sure(
            "its times are those of the drive's clock, in one file",
        )),
        (true, false) | (false, true) if are_times && apart_s < longest_s => Some(check(format!(
            "its times begin {} s apart from the drive's, in one file: one clock, or \"own\" with offset_s and ppm = \"found\"?",
            statistics::significant((apart_s * 1e6).round() / 1e6)
        ))),
        (false, false) if apart_s < tick_s => Some(check(
            "its times begin at 0 as the drive's do, in one file: write \"own\" with offset_s and ppm = \"found\" if two programs recorded them",
        )),
        _ => None,
    }
}
