//! Reading of a map: its tables, turned into streams.

use crate::check::{Check, RawClocking, RawTime};
use crate::map::{Body, Carrier, Centre, Electrical, ImportMap, Modulation, Plate, PlateConstants};
use crate::map_error::{MapError, MapErrors};
use crate::raw::{RawDrive, RawEnvelopes, RawMap, RawModulation, RawPickup, RawPlate};
use crate::streams::{
    Clock, Drive, Envelopes, LockInFilter, Pickup, PickupConversion, PickupQuantity, PickupScale,
    Quantity, Rate, TimeBase, Travel,
};
use crate::value::{CarrierWord, CentreWord, FoundWord, NumberOr, ScaleWord};

/// Version of the map's layout.
const FORMAT: u32 = 1;
/// Greatest time between two channels of one converter, s: ten times that of a slow multiplexer.
const GREATEST_SKEW_S: f64 = 0.01;

impl ImportMap {
    /// Reads and checks a map; `file` names it in errors.
    ///
    /// # Errors
    /// All errors of the map: unknown keys with the nearest known one, values out of range, missing keys.
    pub fn parse(text: &str, file: &str) -> Result<Self, MapErrors> {
        let draft = strict_toml::read::<RawMap>(text, file);
        let mut errors: Vec<MapError> = draft.errors.iter().cloned().map(MapError::from).collect();
        // Rules are checked only of a file that could be read, because stand-ins would cause further errors.
        let Some(raw) = draft.value.filter(|_| errors.is_empty()) else {
            return Err(MapErrors(errors));
        };
        let mut check = Check {
            text,
            file,
            errors: Vec::new(),
        };
        let map = check.map(raw);
        errors.append(&mut check.errors);
        match map.filter(|_| errors.is_empty()) {
            Some(map) => Ok(map),
            None => Err(MapErrors(errors)),
        }
    }
}

impl Check<'_> {
    fn map(&mut self, raw: RawMap) -> Option<ImportMap> {
        if raw.format != FORMAT {
            self.wrong(
                "format",
                format!(
                    "= {} is not read by this version; write format = {FORMAT}",
                    raw.format
                ),
            );
        }
        let pattern = self.pattern(&raw);
        let electrical = self.electrical(&raw);
        let drive_time = match &electrical {
            Some(Electrical::Signals { drive, .. } | Electrical::Stimulus(Some(drive))) => {
                Some(drive.time.clone())
            }
            Some(Electrical::Envelopes { envelopes, .. }) => Some(envelopes.time.clone()),
            _ => None,
        };
        let normal_table = raw.normal.clone();
        let normal = raw
            .normal
            .map(|normal| self.normal(normal, drive_time.as_ref()));
        let reference = normal.as_ref().and_then(Option::as_ref);
        let reference = reference.map(|normal| (normal.time.clone(), normal.clock));
        let is_normal_wrong = normal.as_ref().is_some_and(Option::is_none);
        let reference = match is_normal_wrong {
            // A wrong [normal] is reported once.
            true => Some((TimeBase::Rate(Rate::File), OWN_CLOCK)),
            false => reference,
        };
        let lateral = raw
            .lateral
            .map(|lateral| self.lateral(lateral, reference.as_ref()));
        let reference = reference.or_else(|| {
            let lateral = lateral.as_ref()?.as_ref()?;
            Some((lateral.time.clone(), lateral.clock))
        });
        let place = match (raw.position, raw.velocity) {
            (Some(_), Some(_)) => {
                self.wrong(
                    "velocity",
                    "and [position] both state the place of the finger: delete one",
                );
                None
            }
            (Some(table), None) => {
                let source = self.source("position", table.file.as_deref(), table.from);
                let time = RawTime {
                    rate_hz: table.rate_hz,
                    time: table.time,
                    seconds_per_unit: table.seconds_per_unit,
                };
                let clock = RawClocking {
                    clock: table.clock,
                    offset_s: table.offset_s,
                    ppm: table.ppm,
                };
                let metres = self.scale("position", "metres_per_unit", table.metres_per_unit);
                let bits = table.wrap_bits.filter(|bits| !(2..=63).contains(bits));
                if let Some(bits) = bits {
                    self.wrong(
                        "position.wrap_bits",
                        format!(
                            "= {bits} is outside 2 to 63: write the number of bits of the counter"
                        ),
                    );
                }
                let travel = metres.map(|metres_per_unit| Travel::Position {
                    metres_per_unit,
                    wrap_bits: table.wrap_bits,
                });
                Some(self.place(
                    "position",
                    (source, time, clock, travel),
                    reference.as_ref(),
                ))
            }
            (None, Some(table)) => {
                let source = self.source("velocity", table.file.as_deref(), table.from);
                let time = RawTime {
                    rate_hz: table.rate_hz,
                    time: table.time,
                    seconds_per_unit: table.seconds_per_unit,
                };
                let clock = RawClocking {
                    clock: table.clock,
                    offset_s: table.offset_s,
                    ppm: table.ppm,
                };
                let metres = self.scale(
                    "velocity",
                    "metres_per_unit",
                    Some(table.metres_per_unit.unwrap_or(1.0)),
                );
                let travel = metres.map(|metres_per_s_per_unit| Travel::Velocity {
                    metres_per_s_per_unit,
                });
                Some(self.place(
                    "velocity",
                    (source, time, clock, travel),
                    reference.as_ref(),
                ))
            }
            (None, None) => None,
        };
        let intervals = self.intervals(raw.intervals);
        if matches!(electrical, Some(Electrical::Stimulus(_)))
            && normal_table.is_none()
            && lateral.is_none()
        {
            self.missing(
                None,
                "drive",
                "a recording needs [drive] and [pickup], [envelopes], or [normal] and [lateral]",
            );
        }
        Some(ImportMap {
            pattern: pattern?,
            electrical: electrical?,
            normal: all_or_none(normal)?,
            lateral: all_or_none(lateral)?,
            position: all_or_none(place)?,
            body: raw.contact.map_or(Body::default(), |contact| contact.body),
            intervals: intervals?,
            participants: raw.participants.map(|participants| participants.table),
        })
    }

    fn electrical(&mut self, raw: &RawMap) -> Option<Electrical> {
        match (&raw.drive, &raw.pickup, &raw.envelopes) {
            (None, None, Some(table)) => self.envelopes(raw, table),
            (_, _, Some(_)) => {
                self.wrong(
                    "envelopes",
                    "stands in place of [drive] and [pickup]: delete the one or the others",
                );
                None
            }
            (Some(drive), Some(pickup), None) => self.signals(raw, drive, pickup),
            (Some(drive), None, None) if raw.plate.is_none() => {
                let drive = self.drive(drive)?;
                Some(Electrical::Stimulus(Some(drive)))
            }
            (Some(_), None, None) => {
                self.missing(None, "pickup", "write the table [pickup]; without a pickup, delete [plate]: friction is then all that the recording gives");
                None
            }
            (None, Some(_), None) => {
                self.missing(None, "drive", "write the table [drive]: the impedance is the drive's force over the plate's velocity");
                None
            }
            (None, None, None) => {
                for (table, is_there) in [
                    ("carrier", raw.carrier.is_some()),
                    ("plate", raw.plate.is_some()),
                ] {
                    if is_there {
                        self.wrong(
                            table,
                            "needs [drive] and [pickup], or [envelopes]: delete it, or write those",
                        );
                    }
                }
                Some(Electrical::Stimulus(None))
            }
        }
    }

    fn signals(
        &mut self,
        raw: &RawMap,
        drive: &RawDrive,
        pickup: &RawPickup,
    ) -> Option<Electrical> {
        let carrier = self.carrier(raw);
        let modulation = self.modulation(raw.modulation.as_ref());
        let drive = self.drive(drive);
        let source = self.source("pickup", pickup.file.as_deref(), pickup.from.clone());
        let conversion = self.conversion(
            "pickup",
            pickup.quantity,
            pickup.metres_per_unit,
            pickup.skew_s,
            pickup.phase_rad,
        );
        let plate = self.plate(raw.plate.as_ref());
        if let (Some(Carrier::Follows), Some(plate)) = (carrier, &plate)
            && matches!(
                plate.constants,
                PlateConstants::Stated { quality: None, .. }
            )
        {
            self.missing(Some("plate"), "quality", "a carrier that moves needs the plate's impedance at each frequency: write the quality factor, or sweep");
            return None;
        }
        let baseline = match &raw.baseline {
            None => None,
            Some(baseline) => self.template("baseline.file", Some(&baseline.file)).ok()?,
        };
        Some(Electrical::Signals {
            carrier: carrier?,
            modulation: modulation?,
            drive: drive?,
            pickup: Pickup {
                source: source?,
                conversion: conversion?,
            },
            plate: plate?,
            baseline,
        })
    }

    fn drive(&mut self, table: &RawDrive) -> Option<Drive> {
        let source = self.source("drive", table.file.as_deref(), table.from.clone());
        let time = RawTime {
            rate_hz: table.rate_hz.clone(),
            time: table.time.clone(),
            seconds_per_unit: table.seconds_per_unit,
        };
        let time = self.time("drive", time, None);
        let volts_per_unit = self.scale("drive", "volts_per_unit", table.volts_per_unit);
        Some(Drive {
            source: source?,
            time: time?,
            volts_per_unit: volts_per_unit?,
        })
    }

    fn carrier(&mut self, raw: &RawMap) -> Option<Carrier> {
        let hz = raw.carrier.as_ref().and_then(|carrier| carrier.hz);
        let remedy = "write a number in Hz, \"found\", or \"follows\" for a carrier that moves within the recording";
        match self.require("carrier", "hz", hz, remedy)? {
            NumberOr::Word(CarrierWord::Found) => Some(Carrier::Constant(Quantity::Found)),
            NumberOr::Word(CarrierWord::Follows) => Some(Carrier::Follows),
            NumberOr::Number(hz) => {
                let hz = self.number("carrier.hz", hz, (1.0, 1e7), "Hz")?;
                Some(Carrier::Constant(Quantity::Stated(hz)))
            }
        }
    }

    fn modulation(&mut self, raw: Option<&RawModulation>) -> Option<Modulation> {
        let hz = raw.and_then(|modulation| modulation.hz);
        let index = raw.and_then(|modulation| modulation.index);
        let hz = self.require(
            "modulation",
            "hz",
            hz,
            "write a number in Hz, 0 without modulation, or \"found\"",
        );
        let index = self.require(
            "modulation",
            "index",
            index,
            "write a number from 0 to 1, or \"found\"",
        );
        let quantity = |check: &mut Self, key: &str, value, range, unit: &str| match value {
            NumberOr::Word(FoundWord::Found) => Some(Quantity::Found),
            NumberOr::Number(value) => check.number(key, value, range, unit).map(Quantity::Stated),
        };
        let hz = hz.and_then(|hz| quantity(self, "modulation.hz", hz, (0.0, 1e4), "Hz"));
        let index =
            index.and_then(|index| quantity(self, "modulation.index", index, (0.0, 1.0), ""));
        Some(Modulation {
            hz: hz?,
            index: index?,
        })
    }

    fn conversion(
        &mut self,
        table: &'static str,
        quantity: Option<PickupQuantity>,
        metres_per_unit: Option<NumberOr<ScaleWord>>,
        skew_s: Option<NumberOr<FoundWord>>,
        phase_rad: Option<NumberOr<FoundWord>>,
    ) -> Option<PickupConversion> {
        let quantity = self.require(
            table,
            "quantity",
            quantity,
            "write displacement, velocity, acceleration or charge",
        );
        let remedy = "write the displacement in metres per unit of the array (of a velocity m/s, of an acceleration m/s²), or \"from modal mass\"";
        let scale = match self.require(table, "metres_per_unit", metres_per_unit, remedy) {
            None => None,
            Some(NumberOr::Word(ScaleWord::FromModalMass)) => Some(PickupScale::FromModalMass),
            Some(NumberOr::Number(value)) => self
                .scale(table, "metres_per_unit", Some(value))
                .map(PickupScale::MetresPerUnit),
        };
        let skew = self.quantity(&format!("{table}.skew_s"), skew_s);
        let stated_s = skew.and_then(Quantity::stated).unwrap_or(0.0);
        if stated_s.abs() > GREATEST_SKEW_S {
            self.wrong(
                &format!("{table}.skew_s"),
                "is no skew of one converter, which takes its channels within microseconds: write it in seconds, 4 µs as 4e-6",
            );
        }
        let phase = self.quantity(&format!("{table}.phase_rad"), phase_rad);
        Some(PickupConversion {
            quantity: quantity?,
            scale: scale?,
            skew_s: skew?,
            phase_rad: phase?,
        })
    }

    fn envelopes(&mut self, raw: &RawMap, table: &RawEnvelopes) -> Option<Electrical> {
        let carrier_hz = match self.carrier(raw) {
            Some(Carrier::Constant(Quantity::Stated(hz))) => Some(hz),
            Some(_) => {
                self.wrong("carrier.hz", "is not in envelopes: write the frequency in Hz at which the lock-in amplifier measured");
                None
            }
            None => None,
        };
        let modulation = self.modulation(raw.modulation.as_ref());
        let file = self.template("envelopes.file", table.file.as_deref());
        let arrays = "write [\"X\", \"Y\"], the name of a complex array, or { amplitude = \"R\", phase_rad = \"theta\" } (phase_deg for degrees)";
        let drive = self.require("envelopes", "drive", table.drive.clone(), arrays);
        let pickup = self.require("envelopes", "pickup", table.pickup.clone(), arrays);
        let time = RawTime {
            rate_hz: table.rate_hz.clone(),
            time: table.time.clone(),
            seconds_per_unit: table.seconds_per_unit,
        };
        let time = self.time("envelopes", time, None);
        let volts_per_unit = self.scale("envelopes", "volts_per_unit", table.volts_per_unit);
        let conversion = self.conversion(
            "envelopes",
            table.quantity,
            table.metres_per_unit,
            table.skew_s,
            table.phase_rad,
        );
        let convention = self.require(
            "envelopes",
            "convention",
            table.convention,
            "write exp(+iwt) or exp(-iwt)",
        );
        let is_rms = self.require(
            "envelopes",
            "rms",
            table.rms,
            "write true if the instrument writes RMS values, false if peak values",
        );
        let low_pass = match &table.low_pass {
            None => Some(None),
            Some(filter) => {
                let order = filter.order;
                if !(1..=8).contains(&order) {
                    self.wrong(
                        "envelopes.low_pass.order",
                        format!("= {order} is outside 1 to 8"),
                    );
                }
                self.number("envelopes.low_pass.tau_s", filter.tau_s, (1e-9, 10.0), "s")
                    .map(|tau_s| Some(LockInFilter { order, tau_s }))
            }
        };
        let plate = self.plate(raw.plate.as_ref());
        if raw.baseline.is_some() {
            self.wrong(
                "baseline",
                "is read with [drive] and [pickup] alone: delete it",
            );
        }
        Some(Electrical::Envelopes {
            carrier_hz: carrier_hz?,
            modulation: modulation?,
            envelopes: Envelopes {
                file: file.ok()?,
                drive: drive?,
                pickup: pickup?,
                time: time?,
                volts_per_unit: volts_per_unit?,
                conversion: conversion?,
                convention: convention?,
                is_rms: is_rms?,
                low_pass: low_pass?,
            },
            plate: plate?,
        })
    }

    fn plate(&mut self, raw: Option<&RawPlate>) -> Option<Plate> {
        let mass = raw.and_then(|plate| plate.modal_mass_kg);
        let mass = self.require("plate", "modal_mass_kg", mass, "write the modal mass in kg");
        let mass =
            mass.and_then(|mass| self.number("plate.modal_mass_kg", mass, (1e-9, 1e3), "kg"));
        let raw = raw?;
        let centre = match raw.centre_m {
            None | Some(NumberOr::Word(CentreWord::MiddleOfTravel)) => Some(Centre::MiddleOfTravel),
            Some(NumberOr::Number(value)) => {
                self.finite("plate.centre_m", value).map(Centre::Stated)
            }
        };
        let constants = match &raw.sweep {
            Some(file) => {
                for (key, is_there) in [
                    ("resonance_hz", raw.resonance_hz.is_some()),
                    ("quality", raw.quality.is_some()),
                ] {
                    if is_there {
                        self.wrong(
                            &format!("plate.{key}"),
                            "and `sweep` both state the resonance: delete one",
                        );
                    }
                }
                let factor = match raw.force_factor_n_per_v {
                    None => Some(None),
                    stated => self
                        .scale("plate", "force_factor_n_per_v", stated)
                        .map(Some),
                };
                factor.map(|force_factor_n_per_v| PlateConstants::Sweep {
                    file: file.clone(),
                    force_factor_n_per_v,
                })
            }
            None => {
                let remedy =
                    "write it, or sweep = \"FILE\" with a sweep that was measured elsewhere";
                let resonance = self.require("plate", "resonance_hz", raw.resonance_hz, remedy);
                let resonance = resonance
                    .and_then(|hz| self.number("plate.resonance_hz", hz, (1.0, 1e7), "Hz"));
                let remedy = "write the actuators' force per volt in N/V, or sweep = \"FILE\" with a sweep that was measured elsewhere";
                let factor = self.require(
                    "plate",
                    "force_factor_n_per_v",
                    raw.force_factor_n_per_v,
                    remedy,
                );
                let factor = factor
                    .and_then(|factor| self.scale("plate", "force_factor_n_per_v", Some(factor)));
                let quality = match raw.quality {
                    None => Some(None),
                    Some(quality) => self
                        .number("plate.quality", quality, (0.5, 1e7), "")
                        .map(Some),
                };
                resonance.zip(factor).zip(quality).map(
                    |((resonance_hz, force_factor_n_per_v), quality)| PlateConstants::Stated {
                        resonance_hz,
                        quality,
                        force_factor_n_per_v,
                    },
                )
            }
        };
        Some(Plate {
            modal_mass_kg: mass?,
            constants: constants?,
            centre: centre?,
        })
    }
}

/// Clock of which nothing is stated.
const OWN_CLOCK: Clock = Clock {
    is_drives: false,
    offset_s: Quantity::Stated(0.0),
    ppm: Quantity::Stated(0.0),
};

/// Turns a table that is wrong into `None`, and an absent one into `Some(None)`.
fn all_or_none<T>(table: Option<Option<T>>) -> Option<Option<T>> {
    match table {
        None => Some(None),
        Some(table) => table.map(Some),
    }
}
