//! Tables of drive and pickup, or of their envelopes.

use super::Draft;
use crate::map_text::{Reason, check, number, quoted, sure};
use crate::names::Role;
use crate::nature::{Nature, frequency_text, grouped};
use crate::portrait::VectorPortrait;
use crate::roles::{Chosen, EnvelopeArrays, EnvelopePair, Roles};
use crate::scales::{pickup_scale, scaled, unit};
use crate::units::UnitMeaning;

impl Draft<'_> {
    pub(super) fn signals(&mut self, drive: &Chosen<'_>, pickup: &Chosen<'_>) {
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
        self.volts(
            drive.vector,
            &format!(
                "; its crests are {}",
                grouped(carrier.amplitude).replace('\u{a0}', " ")
            ),
        );
        self.map.table("pickup");
        self.source(pickup, drive.file);
        self.motion(pickup.vector);
        self.map.key(
            "phase_rad",
            "\"found\"",
            sure("from the unloaded plate, with the converter's skew in it"),
        );
    }

    pub(super) fn envelopes(&mut self, pair: &EnvelopePair<'_>) {
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
        let is_degrees = pair.phases.as_ref().is_some_and(|unit| unit.is_degrees);
        for (key, envelope) in [("drive", &pair.drive), ("pickup", &pair.pickup)] {
            let unit = pair
                .phases
                .as_ref()
                .filter(|_| matches!(envelope, EnvelopeArrays::Polar(..)));
            let text = unit.map_or(String::new(), |unit| format!("; {}", unit.reason));
            let reason = Reason {
                text: format!("{}{text}", pair.reason),
                is_sure: pair.is_sure && unit.is_none_or(|unit| unit.is_sure),
            };
            self.map.key(key, &arrays(envelope, is_degrees), reason);
        }
        self.rate(first);
        self.volts(first, "");
        self.motion(pair.pickup.first());
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

    /// Adds the actuators' volts for 1.
    fn volts(&mut self, vector: &VectorPortrait, size: &str) {
        let (volts, text) = match vector.unit_meaning() {
            Some(UnitMeaning::Volts(volts)) => {
                let (volts, reason) = scaled(vector, volts, format!("stated in {}", unit(vector)));
                (
                    volts,
                    format!(
                        "{}: is it the amplifier's output, not its input?",
                        reason.text
                    ),
                )
            }
            meaning => {
                let (volts, reason) = scaled(vector, 1.0, "no unit is stated".to_owned());
                let text = match (meaning, vector.unit_text(), &vector.scaling) {
                    (_, Some(unit), _) => format!("stated in {unit}, which is no voltage"),
                    (_, _, Some(_)) => reason.text,
                    (_, _, None) => "no unit is stated".to_owned(),
                };
                (
                    volts,
                    format!("{text}{size}: write the actuators' volts for 1"),
                )
            }
        };
        self.map.key("volts_per_unit", &number(volts), check(text));
    }

    /// Adds the quantity of the pickup and its scale.
    fn motion(&mut self, vector: &VectorPortrait) {
        let (quantity, reason, scale) = pickup_scale(vector);
        self.map.key("quantity", &quoted(quantity), reason);
        match scale {
            Some((scale, reason)) => self.map.key("metres_per_unit", &number(scale), reason),
            None => {
                let text = "no unit of a motion is stated: the scale with which the unloaded plate has the modal mass, or write the number";
                self.map
                    .key("metres_per_unit", "\"from modal mass\"", check(text));
            }
        }
    }

    /// Adds a line to be checked where arrays of a high rate are left out, though a recording has drive and pickup
    /// among such.
    pub(super) fn left_out(&mut self, roles: &Roles<'_>) {
        if roles.signals.is_some() || roles.envelopes.is_some() {
            return;
        }
        let forces = [&roles.normal, &roles.lateral].into_iter().flatten();
        let longest = forces.map(|chosen| chosen.vector.length).max().unwrap_or(0);
        let is_fast = |vector: &&VectorPortrait| {
            let is_signal = !matches!(
                vector.nature,
                Nature::Time(_)
                    | Nature::Ramp(_)
                    | Nature::Constant
                    | Nature::Lost
                    | Nature::Unread(_)
            );
            let is_named = matches!(vector.role(), Some((Role::Drive | Role::Pickup, _)));
            let is_long = vector.length >= LEAST_OF_FAST && vector.length >= 4 * longest;
            is_signal
                && (matches!(vector.nature, Nature::Carrier(_))
                    || vector.rate_hz().is_some_and(|hz| hz >= FAST_HZ)
                    || is_long
                    || (is_named && vector.rate.is_none() && vector.length >= longest))
        };
        let fast: Vec<&VectorPortrait> = self
            .portraits
            .iter()
            .flat_map(|file| &file.vectors)
            .filter(is_fast)
            .collect();
        let has_partner = |vector: &&&VectorPortrait| {
            fast.iter()
                .filter(|candidate| candidate.length == vector.length)
                .count()
                > 1
        };
        let names: Vec<String> = fast
            .iter()
            .filter(has_partner)
            .take(6)
            .map(|vector| format!("`{}`", vector.name))
            .collect();
        if !names.is_empty() {
            self.map.check(format!(
                "drive and pickup are left out: none of {} shows a carrier of a plate. If two of them are drive and pickup, correct \
                 their rate and add [carrier], [modulation], [drive], [pickup] and [plate]; if not, delete this line",
                names.join(", ")
            ));
        }
    }
}

/// Least rate of samples of a carrier, Hz, and least length of an array of such.
const FAST_HZ: f64 = 40e3;
const LEAST_OF_FAST: u64 = 20_000;

fn arrays(arrays: &EnvelopeArrays<'_>, is_degrees: bool) -> String {
    match arrays {
        EnvelopeArrays::Complex(vector) => quoted(&vector.name),
        EnvelopeArrays::Parts(real, imaginary) => {
            format!("[{}, {}]", quoted(&real.name), quoted(&imaginary.name))
        }
        EnvelopeArrays::Polar(amplitude, phase) => {
            let unit = if is_degrees { "deg" } else { "rad" };
            format!(
                "{{ amplitude = {}, phase_{unit} = {} }}",
                quoted(&amplitude.name),
                quoted(&phase.name)
            )
        }
    }
}
