//! Limits that the watch enforces, and the ranges in which it can detect faults.

use std::fmt;

use crate::loop_delay::DELAY_WITHIN_S;
use crate::plate_heat::PlateHeat;

/// Least and greatest plausible sensitivity of either axis of a force sensor that reads newtons: a calibration is never
/// off by more than these factors.
pub const SENSITIVITY: [f64; 2] = [0.5, 2.0];

/// Shortest and longest time for which a dead-man switch may be open while the plate is driven, s.
pub const DEAD_MAN_RELEASE_S: [f64; 2] = [0.05, 0.5];

/// Gain of a faulty amplifier that the watch must distinguish from a sound one.
pub(crate) const HALF_GAIN: f64 = 0.5;
/// Margin between half the gain and the accepted read-back, as a share of the crest: the fault shows for a good part of
/// a period.
const MARGIN: f64 = 0.05;

/// Longest delay of a real loop, s: three buffers of 4096 frames out and one in at 192 kHz wait for 85 ms, and
/// converters and USB add a few. The published modulation has a period of 167 ms: a delay as long as a period of the
/// modulation could explain half the gain at any moment.
const LONGEST_LATENCY_S: f64 = 0.1;

/// Limits that the watch enforces; from `[safety]` in `bench.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyLimits {
    /// Largest normal force, pressing or pulling, N.
    pub max_normal_n: f64,
    /// Largest lateral force in either direction, N.
    pub max_lateral_n: f64,
    /// Largest relative difference of the read-back from the commanded envelope.
    pub readback_tolerance: f64,
    /// Read-back below which the drive counts as silent, V peak.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, ns.
    pub loop_latency_ns: u64,
    /// Measured delay from a command to its read-back, s; `None` if it was not measured and is learnt at each arming.
    pub measured_delay_s: Option<f64>,
    /// Largest amplitude of the plate that the pickup may read, m.
    pub max_amplitude_m: f64,
    /// Thermal constants of the plate and its limit.
    pub heat: PlateHeat,
    /// Driving time allowed within an hour, until an [`Allowance`](crate::Allowance) arrives, s.
    pub driving_s_per_hour: f64,
    /// Time for which the dead-man switch may be open while the plate is driven, ns; `None` on a bench without one.
    pub dead_man_release_ns: Option<u64>,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Longest silence of the sound card or of the force sensor, ns.
    pub silence_ns: u64,
    /// Source of time on this bench.
    pub pace: Pace,
}

/// Source of time on a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// The clock of a sound card: silence is a fault at once.
    Card,
    /// A simulated apparatus, which a busy computer may hold up: no finger is on its plate.
    Simulated,
}

/// A limit so loose that the watch could miss the fault that it guards against.
#[derive(Debug, Clone, PartialEq)]
pub struct BlindLimit {
    /// Key in `[safety]`.
    pub key: &'static str,
    /// The value, in `unit`.
    pub value: f64,
    /// Smallest and largest value that the watch arms with.
    pub range: [f64; 2],
    /// Unit; empty for a share.
    pub unit: &'static str,
    /// Fault that would go undetected.
    pub unseen: &'static str,
}

impl std::error::Error for BlindLimit {}

impl fmt::Display for BlindLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            key,
            value,
            range: [low, high],
            unit,
            unseen,
        } = self;
        let space = if unit.is_empty() { "" } else { " " };
        write!(
            f,
            "safety.{key} = {value}{space}{unit} could hide {unseen}: the bench arms only with {low} to {high}{space}{unit}"
        )
    }
}

/// A drive too small to show a failed amplifier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaintDrive {
    /// Largest voltage that the drive reaches, V peak.
    pub crest_v: f64,
    /// Mean of its envelope, V peak.
    pub mean_v: f64,
    /// `readback_tolerance`.
    pub tolerance: f64,
    /// `readback_floor_v`, V.
    pub floor_v: f64,
}

impl FaintDrive {
    /// Returns the least read-back at the crest that the watch accepts, V.
    fn accepted_v(&self) -> f64 {
        self.crest_v * (1.0 - self.tolerance) - self.floor_v
    }
}

impl std::error::Error for FaintDrive {}

impl fmt::Display for FaintDrive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            crest_v,
            mean_v,
            tolerance,
            floor_v,
        } = self;
        if 2.0 * floor_v > *mean_v {
            return write!(
                f,
                "safety.readback_floor_v = {floor_v} V is more than half of the drive's mean of {mean_v:.2} V: \
                 the watch could take a driven plate for a silent one; drive with {:.2} V or more, or lower it",
                2.0 * floor_v
            );
        }
        write!(
            f,
            "half the gain would read {:.2} V at this drive's crest of {crest_v:.2} V, too close to the {:.2} V from which \
             the watch accepts it ({crest_v:.2} V × (1 − {tolerance}) − {floor_v} V): drive with a crest over {:.2} V, or \
             lower safety.readback_floor_v or safety.readback_tolerance",
            HALF_GAIN * crest_v,
            self.accepted_v(),
            floor_v / (1.0 - HALF_GAIN - MARGIN - tolerance),
        )
    }
}

/// A modulation so fast that a delay of the loop could hide a changed gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HiddenByDelay {
    /// Frequency of the modulation, Hz.
    pub modulation_hz: f64,
    /// Span of the delays that the watch tries, s.
    pub span_s: f64,
    /// Whether they are the delays around a measured one.
    pub measured: bool,
}

impl std::error::Error for HiddenByDelay {}

impl fmt::Display for HiddenByDelay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            modulation_hz,
            span_s,
            measured,
        } = self;
        let (period_ms, span_ms) = (1e3 / modulation_hz, 1e3 * span_s);
        let remedy = if *measured {
            "modulate more slowly"
        } else {
            "measure the delay with `friction-bench calibrate channels`, lower safety.loop_latency_s, or modulate more slowly"
        };
        write!(
            f,
            "a modulation of {modulation_hz} Hz repeats every {period_ms:.1} ms, and the loop's delay is known to {span_ms:.0} ms \
             only: half the gain could pass for a delay; {remedy}"
        )
    }
}

/// Time without a heartbeat after which the hardware's one-shot disables the amplifier, ns.
const ONE_SHOT_NS: u64 = 100_000_000;

impl SafetyLimits {
    /// Returns the longest time that the watch may be away before the drive counts as unwatched, ns: as long as the
    /// one-shot waits, or longer if time may be held up.
    #[must_use]
    pub fn longest_absence_ns(&self) -> u64 {
        self.silence_ns.max(ONE_SHOT_NS)
    }

    /// Requires a modulation with a period longer than the span of the delays that the watch tries. Simulated hardware
    /// is exempt, because a busy computer may hold it up.
    ///
    /// # Errors
    /// If one of these delays could hide half the gain.
    pub fn require_tells_delays(&self, modulation_hz: f64) -> Result<(), HiddenByDelay> {
        let measured = self.measured_delay_s.is_some();
        let span_s = if measured {
            2.0 * DELAY_WITHIN_S
        } else {
            self.loop_latency_ns as f64 * 1e-9
        };
        if self.pace == Pace::Simulated || modulation_hz * span_s <= 1.0 {
            return Ok(());
        }
        Err(HiddenByDelay {
            modulation_hz,
            span_s,
            measured,
        })
    }

    /// Requires limits under which the watch detects the faults that it guards against.
    ///
    /// # Errors
    /// The first limit under which it could not.
    pub fn require_sighted(&self) -> Result<(), BlindLimit> {
        let seconds = |ns: u64| ns as f64 * 1e-9;
        let [latency_s, silence_s] = match self.pace {
            Pace::Card => [[0.005, LONGEST_LATENCY_S], [0.05, 0.1]],
            Pace::Simulated => [[0.005, 1.0], [0.05, 1.0]],
        };
        let force_n = [0.1, 6.0];
        let release_ns = self.dead_man_release_ns;
        [
            (
                "readback_tolerance",
                self.readback_tolerance,
                [0.01, 0.4],
                "",
                "half the gain",
            ),
            (
                "readback_floor_v",
                self.readback_floor_v,
                [0.0, 2.0],
                "V",
                "a welded relay",
            ),
            (
                "loop_latency_s",
                seconds(self.loop_latency_ns),
                latency_s,
                "s",
                "a changed gain behind a delay",
            ),
            (
                "silence_s",
                seconds(self.silence_ns),
                silence_s,
                "s",
                "a card or a force sensor that went silent",
            ),
            (
                "max_normal_n",
                self.max_normal_n,
                force_n,
                "N",
                "a finger that presses too hard",
            ),
            (
                "max_lateral_n",
                self.max_lateral_n,
                force_n,
                "N",
                "a finger that is dragged",
            ),
            (
                "dead_man_release_s",
                release_ns.map_or(DEAD_MAN_RELEASE_S[0], seconds),
                DEAD_MAN_RELEASE_S,
                "s",
                "a hand that let go",
            ),
        ]
        .into_iter()
        .find(|&(_, value, [low, high], _, _)| !(low..=high).contains(&value))
        .map_or(Ok(()), |(key, value, range, unit, unseen)| {
            Err(BlindLimit {
                key,
                value,
                range,
                unit,
                unseen,
            })
        })
    }

    /// Requires a drive under which the watch can distinguish a dead amplifier, and one with half its gain, from a
    /// sound one. A condition without a drive, at 0 V, requires nothing of the amplifier.
    ///
    /// # Errors
    /// If the drive is too faint for this floor and tolerance.
    pub fn require_sees(&self, mean_v: f64, crest_v: f64) -> Result<(), FaintDrive> {
        let drive = FaintDrive {
            crest_v,
            mean_v,
            tolerance: self.readback_tolerance,
            floor_v: self.readback_floor_v,
        };
        let is_distinguishable = (HALF_GAIN + MARGIN) * crest_v < drive.accepted_v();
        let is_visible = is_distinguishable && 2.0 * self.readback_floor_v <= mean_v;
        if crest_v == 0.0 || is_visible {
            Ok(())
        } else {
            Err(drive)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn defaults() -> SafetyLimits {
        include!("../tests/integration/fixture/limits.rs")
    }

    #[test]
    fn limits_that_blind_the_watch_are_named_with_their_range() {
        assert_eq!(defaults().require_sighted(), Ok(()));
        type Edit = (&'static str, fn(&mut SafetyLimits));
        let edits: [Edit; 16] = [
            ("readback_tolerance", |l| l.readback_tolerance = 1.0),
            ("readback_tolerance", |l| l.readback_tolerance = 0.41),
            ("readback_tolerance", |l| l.readback_tolerance = f64::NAN),
            ("readback_tolerance", |l| l.readback_tolerance = -0.25),
            ("readback_floor_v", |l| l.readback_floor_v = 20.0),
            ("readback_floor_v", |l| l.readback_floor_v = -1.0),
            ("loop_latency_s", |l| l.loop_latency_ns = 1_000_000_000),
            ("loop_latency_s", |l| l.loop_latency_ns = 0),
            ("silence_s", |l| l.silence_ns = 250_000_000),
            ("silence_s", |l| l.silence_ns = 20_000_000),
            ("max_normal_n", |l| l.max_normal_n = 20.0),
            ("max_normal_n", |l| l.max_normal_n = f64::INFINITY),
            ("max_lateral_n", |l| l.max_lateral_n = 6.1),
            ("max_lateral_n", |l| l.max_lateral_n = 0.0),
            ("dead_man_release_s", |l| {
                l.dead_man_release_ns = Some(600_000_000);
            }),
            ("dead_man_release_s", |l| l.dead_man_release_ns = Some(0)),
        ];
        for (key, edit) in edits {
            let mut limits = defaults();
            edit(&mut limits);
            assert_eq!(limits.require_sighted().unwrap_err().key, key, "{limits:?}");
        }
    }

    #[test]
    fn only_a_simulated_bench_may_be_held_up() {
        let mut limits = defaults();
        limits.silence_ns = 1_000_000_000;
        limits.loop_latency_ns = 1_000_000_000;
        assert!(limits.require_sighted().is_err());
        limits.pace = Pace::Simulated;
        assert_eq!(limits.require_sighted(), Ok(()));
        limits.silence_ns += 1_000_000;
        assert!(limits.require_sighted().is_err());
    }

    #[test]
    fn a_delay_as_long_as_the_modulations_period_hides_nothing_because_it_is_not_armed() {
        let mut limits = defaults();
        assert_eq!(limits.require_tells_delays(10.0), Ok(()));
        let refused = limits.require_tells_delays(12.5).unwrap_err();
        assert!(!refused.measured);
        assert!(refused.to_string().contains("every 80.0 ms"), "{refused}");
        limits.measured_delay_s = Some(0.012);
        assert_eq!(limits.require_tells_delays(100.0), Ok(()));
        assert!(limits.require_tells_delays(101.0).unwrap_err().measured);
        assert!(limits.require_tells_delays(f64::NAN).is_err());
        limits.pace = Pace::Simulated;
        assert_eq!(limits.require_tells_delays(500.0), Ok(()));
    }

    #[test]
    fn a_drive_that_cannot_show_half_the_gain_is_refused_with_the_arithmetic() {
        let limits = defaults();
        assert_eq!(limits.require_sees(24.0, 46.8), Ok(()));
        assert_eq!(limits.require_sees(2.6, 5.07), Ok(()));
        let refused = limits.require_sees(2.5, 4.875).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "half the gain would read 2.44 V at this drive's crest of 4.88 V, too close to the 2.66 V from which the watch \
             accepts it (4.88 V × (1 − 0.25) − 1 V): drive with a crest over 5.00 V, or lower safety.readback_floor_v or \
             safety.readback_tolerance"
        );
        let refused = limits.require_sees(1.9, 30.0).unwrap_err();
        assert!(refused.to_string().contains("half of the drive's mean"));
        assert_eq!(limits.require_sees(0.0, 0.0), Ok(()));
        assert!(limits.require_sees(f64::NAN, f64::NAN).is_err());
    }
}
