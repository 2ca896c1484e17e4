//! Reading of a map: its tables, turned into streams.

use std::collections::BTreeSet;

use interval_rules::Rule;

use crate::check::{Check, RawClocking, RawTime};
use crate::map::{
    Body, Carrier, Centre, Electrical, ImportMap, Intervals, Modulation, Plate, PlateConstants,
};
use crate::map_error::{MapError, MapErrors};
use crate::pattern::{FilePattern, KNOWN_GROUPS, Template};
use crate::raw::{
    RawDrive, RawEnvelopes, RawIntervals, RawLateral, RawMap, RawModulation, RawNormal, RawPickup,
    RawPlate,
};
use crate::streams::{
    ArraySource, Clock, Drive, Envelopes, Lateral, LateralTare, LockInFilter, Normal, NormalTare,
    Pickup, PickupConversion, PickupQuantity, PickupScale, Position, Quantity, Rate, TimeBase,
    Travel,
};
use crate::value::{
    CarrierWord, CentreWord, FoundWord, LateralTareWord, NormalTareWord, NumberOr, ScaleWord,
};

/// Version of the map's layout.
const FORMAT: u32 = 1;

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

    fn pattern(&mut self, raw: &RawMap) -> Option<FilePattern> {
        let stream_files = self.stream_files(raw);
        let parsed = match &raw.files {
            Some(text) => FilePattern::parse(text),
            None => match stream_files.first() {
                Some((_, template)) => FilePattern::from_template(template),
                None => {
                    self.missing(
                        None,
                        "files",
                        r"write a regular expression for the files' names, such as files = 'S(?<participant>\d+)_T(?<trial>\d+)\.mat'",
                    );
                    return None;
                }
            },
        };
        let pattern = match parsed {
            Ok(pattern) => pattern,
            Err(fault) => {
                self.wrong("files", fault);
                return None;
            }
        };
        let groups: BTreeSet<String> = pattern.groups().map(str::to_owned).collect();
        let used: BTreeSet<String> = stream_files
            .iter()
            .flat_map(|(_, template)| template.placeholders().map(str::to_owned))
            .collect();
        for (key, template) in &stream_files {
            for name in template
                .placeholders()
                .filter(|name| !groups.contains(*name))
            {
                let known: Vec<String> = groups.iter().cloned().collect();
                let meant = strict_toml::nearest(name, &known);
                let meant = meant
                    .map(|meant| format!(", did you mean {{{meant}}}?"))
                    .unwrap_or_default();
                self.wrong(
                    key,
                    format!("names {{{name}}}, which `files` does not capture{meant}"),
                );
            }
        }
        let known = KNOWN_GROUPS.map(str::to_owned);
        for group in groups
            .iter()
            .filter(|group| !known.contains(group) && !used.contains(*group))
        {
            let meant = strict_toml::nearest(group, &known);
            let meant = meant
                .map(|meant| format!(", did you mean `{meant}`?"))
                .unwrap_or_default();
            self.wrong(
                "files",
                format!(
                    "captures `{group}`, which nothing uses{meant}; known: {}",
                    KNOWN_GROUPS.join(", ")
                ),
            );
        }
        Some(pattern)
    }

    /// Returns the names of files with placeholders, the streams' first, with their keys.
    fn stream_files(&mut self, raw: &RawMap) -> Vec<(&'static str, Template)> {
        let names = [
            (
                "drive.file",
                raw.drive.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "envelopes.file",
                raw.envelopes
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "normal.file",
                raw.normal.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "lateral.file",
                raw.lateral.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "pickup.file",
                raw.pickup.as_ref().and_then(|table| table.file.as_deref()),
            ),
            (
                "position.file",
                raw.position
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "velocity.file",
                raw.velocity
                    .as_ref()
                    .and_then(|table| table.file.as_deref()),
            ),
            (
                "intervals.marks",
                raw.intervals
                    .as_ref()
                    .and_then(|table| table.marks.as_deref()),
            ),
            (
                "baseline.file",
                raw.baseline.as_ref().map(|table| table.file.as_str()),
            ),
        ];
        let parsed =
            |(key, text): (&'static str, Option<&str>)| Some((key, Template::parse(text?).ok()?));
        names.into_iter().filter_map(parsed).collect()
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
                let hz = self.within("carrier.hz", hz, (1.0, 1e7), "Hz")?;
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
            NumberOr::Number(value) => check.within(key, value, range, unit).map(Quantity::Stated),
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
        let arrays = "write [\"X\", \"Y\"], the name of a complex array, or { amplitude = \"R\", phase_rad = \"theta\" }";
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
                self.within("envelopes.low_pass.tau_s", filter.tau_s, (1e-9, 10.0), "s")
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
            mass.and_then(|mass| self.within("plate.modal_mass_kg", mass, (1e-9, 1e3), "kg"));
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
                    .and_then(|hz| self.within("plate.resonance_hz", hz, (1.0, 1e7), "Hz"));
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
                        .within("plate.quality", quality, (0.5, 1e7), "")
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

    fn normal(&mut self, table: RawNormal, drive_time: Option<&TimeBase>) -> Option<Normal> {
        let source = self.source("normal", table.file.as_deref(), table.from);
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
        let clock = self.clock("normal", clock, None);
        // Samples on the drive's clock are its own samples unless another rate is stated.
        let following = drive_time.filter(|_| clock.is_none_or(|clock| clock.is_drives));
        let time = self.time("normal", time, following);
        let newtons_per_unit = self.scale("normal", "newtons_per_unit", table.newtons_per_unit);
        let tare = match table.tare {
            None | Some(NumberOr::Word(NormalTareWord::None)) => Some(NormalTare::Stated(0.0)),
            Some(NumberOr::Word(NormalTareWord::NoContact)) => Some(NormalTare::NoContact),
            Some(NumberOr::Number(value)) => {
                self.finite("normal.tare", value).map(NormalTare::Stated)
            }
        };
        Some(Normal {
            source: source?,
            time: time?,
            clock: clock?,
            newtons_per_unit: newtons_per_unit?,
            tare: tare?,
        })
    }

    fn lateral(
        &mut self,
        table: RawLateral,
        normal: Option<&(TimeBase, Clock)>,
    ) -> Option<Lateral> {
        let source = self.source("lateral", table.file.as_deref(), table.from);
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
        let time = self.time("lateral", time, normal.map(|(time, _)| time));
        let clock = self.clock("lateral", clock, normal.map(|(_, clock)| *clock));
        let newtons_per_unit = self.scale("lateral", "newtons_per_unit", table.newtons_per_unit);
        let tare = match table.tare {
            None | Some(NumberOr::Word(LateralTareWord::None)) => Some(LateralTare::Stated(0.0)),
            Some(NumberOr::Word(LateralTareWord::NoContact)) => Some(LateralTare::NoContact),
            Some(NumberOr::Word(LateralTareWord::SymmetricStrokes)) => {
                Some(LateralTare::SymmetricStrokes)
            }
            Some(NumberOr::Number(value)) => {
                self.finite("lateral.tare", value).map(LateralTare::Stated)
            }
        };
        Some(Lateral {
            source: source?,
            time: time?,
            clock: clock?,
            newtons_per_unit: newtons_per_unit?,
            tare: tare?,
        })
    }

    fn place(
        &mut self,
        table: &'static str,
        (source, time, clock, travel): (Option<ArraySource>, RawTime, RawClocking, Option<Travel>),
        normal: Option<&(TimeBase, Clock)>,
    ) -> Option<Position> {
        let time = self.time(table, time, normal.map(|(time, _)| time));
        let clock = self.clock(table, clock, normal.map(|(_, clock)| *clock));
        Some(Position {
            source: source?,
            time: time?,
            clock: clock?,
            travel: travel?,
        })
    }

    fn intervals(&mut self, raw: Option<RawIntervals>) -> Option<Intervals> {
        let Some(raw) = raw else {
            return Some(Intervals::Rules {
                unloaded: None,
                exploration: None,
            });
        };
        if let Some(marks) = &raw.marks {
            for (key, rule) in [
                ("unloaded", &raw.unloaded),
                ("exploration", &raw.exploration),
            ] {
                if rule.is_some() {
                    self.wrong(
                        &format!("intervals.{key}"),
                        "and `marks` both state intervals: delete one",
                    );
                }
            }
            let marks = self.template("intervals.marks", Some(marks)).ok()??;
            return Some(Intervals::Marks(marks));
        }
        let rule = |check: &mut Self, key: &str, text: Option<&str>| match text.map(Rule::parse) {
            None => Some(None),
            Some(Ok(rule)) => Some(Some(rule)),
            Some(Err(error)) => {
                check.wrong(key, format!("= {error}"));
                None
            }
        };
        let unloaded = rule(self, "intervals.unloaded", raw.unloaded.as_deref());
        let exploration = rule(self, "intervals.exploration", raw.exploration.as_deref());
        Some(Intervals::Rules {
            unloaded: unloaded?,
            exploration: exploration?,
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
