//! Limits of the drive, and limits at which the safety watch stops it.

use serde::{Deserialize, Serialize};

use super::refusal::{Refused, require_range};

/// `[limits]`: limits of the drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest peak voltage that this bench may request, V; at most the generator's compiled-in limit.
    pub drive_v: f64,
    /// Length of the raised-cosine ramp of every start and stop, s.
    #[serde(default = "Limits::default_ramp_s")]
    pub ramp_s: f64,
    /// Largest amplitude of the plate that the pickup may read, µm; 5 µm by default, an assumption: the published drive moves
    /// the unloaded plate by 2.0 µm in the mean and 3.9 µm at its crest.
    #[serde(default = "Limits::default_amplitude_um")]
    pub amplitude_um: f64,
    /// Largest temperature of the plate's surface, estimated from its drive, °C; 40 °C by default, below the 41 to 43 °C that
    /// IEC 60601-1 allows for contact.
    #[serde(default = "Limits::default_surface_c")]
    pub surface_c: f64,
    /// Driving time allowed per person within any hour, s. 0, the default, allows twice the protocol's driving time within an
    /// hour and at least 120 s; without a protocol, twice the driving time of the published one, 729.6 s (assumptions).
    #[serde(default)]
    pub driving_s_per_hour: f64,
    /// Reason for driving at a carrier below 20 kHz, which is audible; refused without a reason.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub audible_carrier_because: Option<String>,
    /// Reason for driving above 23.35 V peak although no meter has checked the bench's volts; refused without a reason.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unchecked_volts_because: Option<String>,
}

/// Largest drive without a check of the bench's volts by an independent meter, V peak: half of the 46.7 V peak up to which IEC
/// 61010-1 (6.3.1) regards a dry contact as not hazardous, because confusing peak with peak to peak makes a constant wrong by a
/// factor of two.
pub const UNCHECKED_V: f64 = 23.35;

/// A drive too high for a bench without a check of its volts by a meter.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "{crest_v:.1} V peak are asked for, and no independent meter has checked the volts of this bench: one wrong constant in \
     both volts_per_unit would pass unseen; run `friction-bench calibrate output --meter NAME`, drive with at most \
     {UNCHECKED_V} V peak, or state the reason in limits.unchecked_volts_because"
)]
pub struct UncheckedVolts {
    /// Largest voltage that the drive reaches, V peak.
    pub crest_v: f64,
}

/// Frequency below which people hear a carrier, Hz.
pub const AUDIBLE_HZ: f64 = 20e3;
/// Frequency below which children, young adults and pets may hear a carrier, Hz.
pub const HEARD_BY_SOME_HZ: f64 = 25e3;

/// An audible carrier on a bench without a stated reason for it.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "a carrier of {carrier_hz:.0} Hz is audible, and at this level harms the ears: drive at {AUDIBLE_HZ} Hz or more, or state \
     the reason in limits.audible_carrier_because"
)]
pub struct AudibleCarrier {
    /// The carrier, Hz.
    pub carrier_hz: f64,
}

impl Limits {
    /// Twice the driving time of the published protocol, s: the driving time allowed within an hour unless the configuration or
    /// a protocol sets another (an assumption).
    pub const PUBLISHED_DRIVING_S_PER_HOUR: f64 = 729.6;

    /// Returns the driving time allowed within an hour if no protocol sets it, s.
    #[must_use]
    pub fn driving_s_per_hour(&self) -> f64 {
        if self.driving_s_per_hour > 0.0 {
            self.driving_s_per_hour
        } else {
            Self::PUBLISHED_DRIVING_S_PER_HOUR
        }
    }

    pub(super) fn check(&self) -> Result<(), Refused> {
        let most_v = signalgen::HARD_LIMIT_V;
        require_range("limits.drive_v", self.drive_v, 0.0, most_v, "V")?;
        require_range("limits.ramp_s", self.ramp_s, 0.005, 1.0, "s")?;
        require_range("limits.amplitude_um", self.amplitude_um, 0.01, 20.0, "µm")?;
        require_range("limits.surface_c", self.surface_c, 30.0, 43.0, "°C")?;
        let driving_s = self.driving_s_per_hour;
        require_range("limits.driving_s_per_hour", driving_s, 0.0, 3600.0, "s")?;
        for (key, reason, claim) in [
            (
                "limits.audible_carrier_because",
                &self.audible_carrier_because,
                "people may hear the carrier",
            ),
            (
                "limits.unchecked_volts_because",
                &self.unchecked_volts_because,
                "the volts need no check against a meter",
            ),
        ] {
            if reason.as_ref().is_some_and(|why| why.trim().is_empty()) {
                let why = format!("{key} is empty: state why {claim}");
                return Err(Refused::new(key, why));
            }
        }
        Ok(())
    }

    /// Requires a drive that is harmless even if an unchecked constant is off by a factor of two, or a reason.
    ///
    /// # Errors
    /// [`UncheckedVolts`] above [`UNCHECKED_V`] without a reason.
    pub fn require_unchecked(&self, crest_v: f64) -> Result<(), UncheckedVolts> {
        if crest_v <= UNCHECKED_V || self.unchecked_volts_because.is_some() {
            Ok(())
        } else {
            Err(UncheckedVolts { crest_v })
        }
    }

    /// Returns the line that every screen shows for a bench that needs no check of its volts; `None` for other benches.
    pub(crate) fn unchecked_in_words(&self) -> Option<String> {
        let why = self.unchecked_volts_because.as_ref()?;
        Some(format!(
            "volts without the check of a meter, because: {why}"
        ))
    }

    /// Requires an inaudible carrier, or a reason.
    ///
    /// # Errors
    /// [`AudibleCarrier`] below [`AUDIBLE_HZ`] without a reason.
    pub fn require_inaudible(&self, carrier_hz: f64) -> Result<(), AudibleCarrier> {
        if carrier_hz >= AUDIBLE_HZ || self.audible_carrier_because.is_some() {
            Ok(())
        } else {
            Err(AudibleCarrier { carrier_hz })
        }
    }

    /// Returns the warning for a carrier that some people may hear; `None` if it is inaudible.
    ///
    /// ```
    /// # let config = config::Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
    /// assert!(config.limits.hearing_in_words(23e3).unwrap().contains("children"));
    /// assert_eq!(config.limits.hearing_in_words(35e3), None);
    /// ```
    #[must_use]
    pub fn hearing_in_words(&self, carrier_hz: f64) -> Option<String> {
        match &self.audible_carrier_because {
            Some(why) if carrier_hz < AUDIBLE_HZ => Some(format!(
                "audible carrier of {carrier_hz:.0} Hz, because: {why}"
            )),
            _ if carrier_hz < HEARD_BY_SOME_HZ => Some(format!(
                "children, young adults and pets may hear a carrier of {carrier_hz:.0} Hz"
            )),
            _ => None,
        }
    }

    pub(crate) fn default_surface_c() -> f64 {
        40.0
    }

    pub(crate) fn default_amplitude_um() -> f64 {
        5.0
    }

    fn default_ramp_s() -> f64 {
        0.05
    }
}

/// `[safety]`: limits beyond which the safety watch stops the drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Safety {
    /// Normal force that stops the drive, N.
    pub max_normal_n: f64,
    /// Lateral force in either direction that stops the drive, N. 3 N by default, an assumption: the published
    /// explorations press with 0.65 N (Huloux 2021, section IV), so a finger reaches it only with a friction
    /// coefficient over 4.
    pub max_lateral_n: f64,
    /// Allowed relative difference of the read-back from the command.
    pub readback_tolerance: f64,
    /// Read-back below which the drive counts as silent, V.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, s.
    pub loop_latency_s: f64,
    /// Delay from a command to its read-back, measured by `calibrate channels`, s; never read from `bench.toml`.
    #[serde(skip)]
    pub measured_delay_s: Option<f64>,
    /// Time without data from the card or the force sensor that stops the drive, s.
    pub silence_s: f64,
    /// Longest time since the last press of the e-stop for which a bench on real hardware may be driven, h.
    pub estop_test_hours: f64,
    /// Dead-man switch that must be held while the plate is driven; not required by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dead_man: Option<DeadManSwitch>,
    /// Time for which the dead-man switch may be released before the drive stops, s.
    pub dead_man_release_s: f64,
    /// Hardware stops that the preflight does not require; empty by default.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub waived: Vec<HardwareStop>,
    /// Name of the person who waived these hardware stops; required with `waived`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waived_by: Option<String>,
}

/// Kind of dead-man switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum DeadManSwitch {
    /// A contact on `gpio.dead_man` that is closed while held: a push button, or a three-position enabling device, which opens
    /// when it is released or clenched.
    Button,
}

/// A line that stops the drive without the computer. The preflight requires each one unless it is waived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum HardwareStop {
    /// The e-stop loop.
    Estop,
    /// The heartbeat to the amplifier's one-shot.
    Heartbeat,
}

impl std::fmt::Display for HardwareStop {
    /// Writes the line's key in `[gpio]`, which is also its name in `waived`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Estop => "estop",
            Self::Heartbeat => "heartbeat",
        })
    }
}

impl Default for Safety {
    fn default() -> Self {
        Self {
            max_normal_n: 3.0,
            max_lateral_n: 3.0,
            readback_tolerance: 0.25,
            readback_floor_v: 1.0,
            loop_latency_s: 0.1,
            measured_delay_s: None,
            silence_s: 0.05,
            estop_test_hours: 24.0,
            dead_man: None,
            dead_man_release_s: 0.2,
            waived: Vec::new(),
            waived_by: None,
        }
    }
}

/// Lowest and highest force limit of a bench, N: a lower limit prevents exploration, a higher one allows injury of the finger
/// (an assumption).
const FORCE_LIMITS_N: [f64; 2] = [0.1, 20.0];

impl Safety {
    /// Returns the largest allowed normal and lateral force, N.
    #[must_use]
    pub fn max_forces_n(&self) -> [f64; 2] {
        [self.max_normal_n, self.max_lateral_n]
    }

    /// Returns the name of the person who waived `line`; `None` if the preflight requires it.
    #[must_use]
    pub fn waiver_of(&self, line: HardwareStop) -> Option<&str> {
        self.waived_by
            .as_deref()
            .filter(|_| self.waived.contains(&line))
    }

    /// Returns the line that every screen shows for a bench with waived hardware stops; `None` if none is waived.
    ///
    /// ```
    /// # use config::{HardwareStop, Safety};
    /// let safety = Safety {
    ///     waived: vec![HardwareStop::Estop, HardwareStop::Heartbeat],
    ///     waived_by: Some("A. Tester".to_owned()),
    ///     ..Safety::default()
    /// };
    /// assert_eq!(
    ///     safety.waiver_in_words().as_deref(),
    ///     Some("hardware stops waived by A. Tester: estop, heartbeat")
    /// );
    /// assert_eq!(Safety::default().waiver_in_words(), None);
    /// ```
    #[must_use]
    pub fn waiver_in_words(&self) -> Option<String> {
        let name = self
            .waived_by
            .as_ref()
            .filter(|_| !self.waived.is_empty())?;
        let lines: Vec<String> = self.waived.iter().map(ToString::to_string).collect();
        Some(format!(
            "hardware stops waived by {name}: {}",
            lines.join(", ")
        ))
    }

    /// Returns the line that every screen shows for a bench with a dead-man switch; `None` if none is used.
    ///
    /// ```
    /// # use config::{DeadManSwitch, Safety};
    /// let safety = Safety { dead_man: Some(DeadManSwitch::Button), ..Safety::default() };
    /// assert_eq!(
    ///     safety.dead_man_in_words().as_deref(),
    ///     Some("dead-man switch in use: released for 0.2 s it stops the drive")
    /// );
    /// ```
    #[must_use]
    pub fn dead_man_in_words(&self) -> Option<String> {
        self.dead_man.map(|_| {
            format!(
                "dead-man switch in use: released for {} s it stops the drive",
                self.dead_man_release_s
            )
        })
    }

    pub(super) fn check(&self) -> Result<(), Refused> {
        self.check_waiver()?;
        let [least_n, most_n] = FORCE_LIMITS_N;
        for (key, limit_n) in [
            ("safety.max_normal_n", self.max_normal_n),
            ("safety.max_lateral_n", self.max_lateral_n),
        ] {
            require_range(key, limit_n, least_n, most_n, "N")?;
        }
        require_range(
            "safety.readback_tolerance",
            self.readback_tolerance,
            0.01,
            1.0,
            "",
        )?;
        require_range(
            "safety.readback_floor_v",
            self.readback_floor_v,
            0.0,
            20.0,
            "V",
        )?;
        require_range(
            "safety.loop_latency_s",
            self.loop_latency_s,
            0.005,
            1.0,
            "s",
        )?;
        require_range("safety.silence_s", self.silence_s, 0.02, 1.0, "s")?;
        let hours = self.estop_test_hours;
        require_range("safety.estop_test_hours", hours, 0.1, 168.0, "h")?;
        let [least_s, most_s] = ::safety::DEAD_MAN_RELEASE_S;
        let release_s = self.dead_man_release_s;
        require_range("safety.dead_man_release_s", release_s, least_s, most_s, "s")
    }

    fn check_waiver(&self) -> Result<(), Refused> {
        let is_repeated =
            |line: &HardwareStop| self.waived.iter().filter(|w| *w == line).count() > 1;
        if let Some(line) = self.waived.iter().find(|line| is_repeated(line)) {
            let why = format!("safety.waived names {line} twice");
            return Err(Refused::new("safety.waived", why));
        }
        let has_name = self
            .waived_by
            .as_ref()
            .is_some_and(|name| !name.trim().is_empty());
        if !self.waived.is_empty() && !has_name {
            let why =
                "safety.waived needs safety.waived_by, the name of the person who answers for it"
                    .to_owned();
            let key = if self.waived_by.is_some() {
                "safety.waived_by"
            } else {
                "safety.waived"
            };
            return Err(Refused::new(key, why));
        }
        Ok(())
    }
}
