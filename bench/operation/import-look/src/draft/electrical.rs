//! Tables of drive and pickup, or of their envelopes.

use super::Draft;
use crate::map_text::{Reason, check, number, quoted, sure};
use crate::names::UnitMeaning;
use crate::nature::{Nature, frequency_text, grouped};
use crate::roles::{Chosen, EnvelopeArrays, EnvelopePair};
use crate::scales::{pickup_scale, unit};

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
