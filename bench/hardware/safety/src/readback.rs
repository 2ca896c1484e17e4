//! Comparison of the drive's read-back with the commanded envelope, on the sample clock: detects an amplifier that is
//! off, an unplugged cable, a changed gain.
//!
//! The delay from a command to its read-back is not known exactly, but it is the same for all samples: of the delays
//! within the loop's latency, those that have failed to explain at least half of the latest readings at some moment
//! since the drive was armed are excluded, and one must remain. Otherwise half the gain of a modulated drive could pass
//! for a delay that changes with the modulation. Of the readings at which half the gain would show, at least half must
//! fit too, or it could hide behind the many that are low. Both sides are counted in frames, so a starved computer that
//! reads late and in bursts changes nothing. If the loop's delay was measured, only delays near it are tried.

use std::collections::VecDeque;

use crate::commanded_envelope::CommandedEnvelope;
use crate::delay::{Comparison, Delay};
use crate::loop_delay::DELAY_WITHIN_S;
use crate::safety_limits::HALF_GAIN;

/// Length of the readings judged together, s; half of them must fit.
const WINDOW_S: f64 = 0.04;
/// Fewest readings judged together, for a card with buffers longer than the window.
const FEWEST_READINGS: usize = 4;
/// Most readings judged together.
const MOST_READINGS: usize = u64::BITS as usize;
/// Step between the delays tried, s. A command also counts half a step before and after.
const STEP_S: f64 = 0.0005;
/// Time in which the delay may change by a step, as with separate clocks of output and input, s.
const DRIFT_S: f64 = 1.0;
/// Least time between two changes of the delay that the card does not report, s.
const SLIP_S: f64 = 5.0;

/// Readings that no delay explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadbackMisfit {
    /// The latest reading, V peak.
    pub measured_v: f64,
    /// Least and greatest command within the loop's latency, V peak.
    pub commanded_v: (f64, f64),
}

/// Latest commands and readings, compared.
///
/// ```
/// use safety::Readback;
///
/// // 1 kHz, a latency of at most 0.1 s, 20 % and 0.5 V of tolerance.
/// let mut readback = Readback::new(1e3, 0.1, 0.2, 0.5);
/// for frame in 0..1000 {
///     readback.command(frame, 20.0);
///     assert_eq!(readback.reading(frame, 0, 20.5), None);
/// }
/// // The amplifier goes off.
/// let misfit = (1000..1100).find_map(|frame| {
///     readback.command(frame, 20.0);
///     readback.reading(frame, 0, 0.0)
/// });
/// assert_eq!(misfit.unwrap().commanded_v, (20.0, 20.0));
/// ```
#[derive(Debug, Clone)]
pub struct Readback {
    tolerance: f64,
    floor_v: f64,
    window: i64,
    latency: i64,
    step: i64,
    /// Envelope at rendered frames, V peak.
    commands: VecDeque<(i64, f64)>,
    /// Envelope at samples read, V peak.
    readings: VecDeque<(i64, f64)>,
    /// Frames rendered less those captured when each of `readings` arrived.
    aheads: VecDeque<i64>,
    /// Shortest and longest delay around the measured one; `None` if the delay was not measured.
    measured: Option<(i64, i64)>,
    /// Whether the drive is rising and has not yet shown the delay: all delays within the loop's latency are then
    /// tried, so that an unexpected delay is not taken for a failed amplifier.
    rising: bool,
    /// Delays that have explained all readings since the last reset, the shortest first; empty before the first
    /// reading.
    delays: Vec<Delay>,
    drift: i64,
    slip: i64,
    /// Samples at which `delays` were last widened, and last rebuilt after all others had failed.
    widened: i64,
    slipped: Option<i64>,
}

impl Readback {
    /// Compares at `rate_hz`, for a path of at most `latency_s`; a reading fits a command if it differs by less than
    /// the share `tolerance` and `floor_v` together.
    pub fn new(rate_hz: f64, latency_s: f64, tolerance: f64, floor_v: f64) -> Self {
        let frames = |s: f64| (s * rate_hz) as i64;
        Self {
            tolerance,
            floor_v,
            window: frames(WINDOW_S),
            latency: frames(latency_s),
            step: frames(STEP_S).max(1),
            commands: VecDeque::new(),
            readings: VecDeque::new(),
            aheads: VecDeque::new(),
            measured: None,
            rising: false,
            delays: Vec::new(),
            drift: frames(DRIFT_S),
            slip: frames(SLIP_S),
            widened: 0,
            slipped: None,
        }
    }

    /// Tries only delays within [`DELAY_WITHIN_S`] of the measured one, `delay_s` at `rate_hz`.
    #[must_use]
    pub fn with_measured_delay(mut self, delay_s: f64, rate_hz: f64) -> Self {
        let frames = |s: f64| (s * rate_hz).round() as i64;
        let longest = frames(delay_s + DELAY_WITHIN_S);
        self.measured = Some((frames(delay_s - DELAY_WITHIN_S), longest));
        self.latency = self.latency.max(longest);
        self
    }

    /// Notes whether the drive is rising and has not yet shown its delay; once it has, or the search is given up, only
    /// delays around the measured one remain.
    pub(crate) fn set_rising(&mut self, rising: bool) {
        if std::mem::replace(&mut self.rising, rising) && !rising && self.measured.is_some() {
            let (least, most) = self.possible_leads(0);
            self.delays
                .retain(|delay| (least..=most).contains(&delay.lead));
        }
    }

    /// Takes the envelope commanded at the latest rendered frame, V peak.
    pub fn command(&mut self, frame: u64, envelope_v: f64) {
        let frame = frame as i64;
        match self.commands.back_mut() {
            // Between two callbacks the envelope may still be set to zero.
            Some(last) if last.0 == frame => last.1 = envelope_v,
            _ => self.commands.push_back((frame, envelope_v)),
        }
        let horizon = frame - self.latency - 2 * self.window;
        while self.commands.len() > 2 && self.commands[1].0 < horizon {
            self.commands.pop_front();
        }
    }

    /// Takes the envelope read back at `sample`, V peak, with the number of frames rendered less those captured,
    /// `ahead`, when it arrived; returns a misfit if the latest readings do not agree with the commands.
    pub fn reading(&mut self, sample: u64, ahead: i64, volts: f64) -> Option<ReadbackMisfit> {
        let sample = sample as i64;
        if self.readings.back().is_some_and(|last| last.0 >= sample) {
            return None;
        }
        self.readings.push_back((sample, volts));
        self.aheads.push_back(ahead);
        while self.readings.len() > MOST_READINGS
            || self.readings.len() > FEWEST_READINGS && self.readings[1].0 <= sample - self.window
        {
            self.readings.pop_front();
            self.aheads.pop_front();
        }
        let &(rendered, _) = self.commands.back()?;
        if self.readings.len() < FEWEST_READINGS {
            return None;
        }
        if self.has_delay(sample, rendered) {
            return None;
        }
        let late = |&&(frame, _): &&(i64, f64)| frame >= rendered - self.latency;
        let commands = self.commands.iter().filter(late).map(|&(_, volts)| volts);
        Some(ReadbackMisfit {
            measured_v: volts,
            commanded_v: (
                commands.clone().fold(f64::INFINITY, f64::min),
                commands.fold(0.0, f64::max),
            ),
        })
    }

    /// Permits another delay, as after the card lost frames.
    pub fn slip(&mut self) {
        self.slipped = None;
    }

    /// Drops all readings, as before arming: they give no information about later ones.
    pub fn forget_readings(&mut self) {
        self.readings.clear();
        self.aheads.clear();
        self.delays.clear();
        self.slipped = None;
    }

    /// Returns whether a delay that has explained all earlier readings explains the latest ones, and excludes the
    /// delays that do not. `rendered` is the latest frame rendered when `sample` was read.
    fn has_delay(&mut self, sample: i64, rendered: i64) -> bool {
        let mut delays = std::mem::take(&mut self.delays);
        let readings = self.readings.len() as u32;
        let has_candidates = !delays.is_empty();
        if let Some(&(reading_sample, volts)) = self.readings.back() {
            let mut commanded = CommandedEnvelope::new(&self.commands);
            for delay in &mut delays {
                delay.vote(self.compare(&mut commanded, reading_sample + delay.lead, volts));
            }
        }
        self.widen(&mut delays, sample);
        delays.retain(|delay| delay.explains(readings));
        if delays.is_empty() {
            if has_candidates {
                if self
                    .slipped
                    .is_some_and(|slip_sample| sample - slip_sample < self.slip)
                {
                    return false;
                }
                self.slipped = Some(sample);
            }
            let (least, most) = self.possible_leads(rendered - sample);
            let possible = (0..=most - least).step_by(self.step as usize);
            delays.extend(possible.map(|shorter| self.voted_delay(most - shorter)));
            delays.retain(|delay| delay.explains(readings));
        }
        self.delays = delays;
        !self.delays.is_empty()
    }

    /// Widens the delays by as much as the clocks of the two directions may differ.
    fn widen(&mut self, delays: &mut Vec<Delay>, sample: i64) {
        let (least, most) = self.possible_leads(0);
        let count = ((most - least) / self.step) as usize;
        if let (Some(&shortest), Some(&longest)) = (delays.first(), delays.last())
            && sample - self.widened >= self.drift
        {
            self.widened = sample;
            if delays.len() < count {
                delays.insert(0, self.voted_delay(shortest.lead + self.step));
                delays.push(self.voted_delay(longest.lead - self.step));
            }
        }
    }

    /// Returns the least and the greatest lead of a possible delay: around the measured one, for any time of the latest
    /// callbacks, or up to the loop's latency before `newest`, the frames rendered less the sample read.
    fn possible_leads(&self, newest: i64) -> (i64, i64) {
        let range = (self.aheads.iter().min(), self.aheads.iter().max());
        match (self.measured.filter(|_| !self.rising), range) {
            (Some((shortest, longest)), (Some(&least), Some(&most))) => {
                (least - longest, most - shortest)
            }
            _ => (newest - self.latency, newest),
        }
    }

    /// Returns the delay of `lead` frames with all readings judged.
    fn voted_delay(&self, lead: i64) -> Delay {
        let mut delay = Delay::new(lead);
        let mut commanded = CommandedEnvelope::new(&self.commands);
        for &(reading_sample, volts) in &self.readings {
            delay.vote(self.compare(&mut commanded, reading_sample + lead, volts));
        }
        delay
    }

    fn compare(&self, commanded: &mut CommandedEnvelope<'_>, frame: i64, volts: f64) -> Comparison {
        let (mut low_v, mut high_v) = (f64::INFINITY, 0.0_f64);
        for at_frame in [frame - self.step / 2, frame, frame + self.step / 2] {
            let level_v = commanded.at(at_frame);
            (low_v, high_v) = (low_v.min(level_v), high_v.max(level_v));
        }
        let least_v = low_v * (1.0 - self.tolerance) - self.floor_v;
        let most_v = high_v * (1.0 + self.tolerance) + self.floor_v;
        Comparison {
            fits: (least_v..=most_v).contains(&volts),
            tells: HALF_GAIN * high_v < least_v,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE_HZ: f64 = 192e3;
    /// A callback of 1024 frames.
    const BLOCK: u64 = 1024;
    /// Frames rendered before the input began.
    const HEAD_START: u64 = 77_777;

    /// The published drive: 24 V, 6 Hz, 95 %.
    fn published_v(frame: u64) -> f64 {
        24.0 * (1.0 + 0.95 * (TAU * 6.0 * frame as f64 / RATE_HZ).sin())
    }

    fn tone_v(_: u64) -> f64 {
        20.0
    }

    /// Runs blocks until a misfit; `path` maps the commanded volts at a time, s, to the volts read back `delay_s`
    /// later.
    fn first_misfit_s(
        commanded_v: fn(u64) -> f64,
        delay_s: f64,
        seconds: f64,
        path: impl Fn(f64, &dyn Fn(f64) -> f64) -> f64,
    ) -> Option<f64> {
        let mut readback = Readback::new(RATE_HZ, 0.1, 0.25, 1.0);
        let at_s = |time_s: f64| commanded_v((time_s.max(0.0) * RATE_HZ) as u64);
        (1..(seconds * RATE_HZ) as u64 / BLOCK).find_map(|block| {
            let frame = block * BLOCK;
            readback.command(HEAD_START + frame, commanded_v(frame));
            let time_s = frame as f64 / RATE_HZ;
            readback
                .reading(
                    frame,
                    HEAD_START as i64,
                    path(time_s, &|time_s| at_s(time_s - delay_s)),
                )
                .map(|_| time_s)
        })
    }

    #[test]
    fn the_commanded_drive_matches_at_any_delay() {
        for commanded_v in [published_v, tone_v] {
            for delay_s in [0.0, 0.003, 0.02, 0.06, 0.099] {
                // 5 % of gain, half a volt of hum.
                let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                    1.05 * sent_v(time_s) + 0.5 * (TAU * 50.0 * time_s).sin()
                };
                assert_eq!(first_misfit_s(commanded_v, delay_s, 3.0, path), None);
            }
        }
    }

    /// Fault 16.
    /// Hazard 18.
    #[test]
    fn an_amplifier_that_goes_off_is_seen_within_50_ms_at_any_phase() {
        for commanded_v in [published_v, tone_v] {
            for delay_s in [0.0, 0.02, 0.06] {
                for phase in 0..40 {
                    let fault_s = 1.0 + f64::from(phase) / 240.0;
                    let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                        if time_s < fault_s {
                            sent_v(time_s)
                        } else {
                            0.0
                        }
                    };
                    let misfit_s = first_misfit_s(commanded_v, delay_s, 2.0, path).unwrap();
                    assert!(
                        (0.0..0.045).contains(&(misfit_s - fault_s)),
                        "{delay_s} s, {phase}: {}",
                        misfit_s - fault_s
                    );
                }
            }
        }
    }

    /// Fault 16.
    /// Hazards 3, 6.
    #[test]
    fn a_changed_gain_is_seen_at_the_next_crest() {
        for gain in [0.5, 2.0] {
            for phase in 0..40 {
                let fault_s = 1.0 + f64::from(phase) / 240.0;
                let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                    sent_v(time_s) * if time_s < fault_s { 1.0 } else { gain }
                };
                let misfit_s = first_misfit_s(published_v, 0.02, 3.0, path).unwrap();
                assert!(
                    misfit_s > fault_s && misfit_s - fault_s < 0.21,
                    "{gain}, {phase}"
                );
            }
            let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                sent_v(time_s) * if time_s < 1.0 { 1.0 } else { gain }
            };
            let misfit_s = first_misfit_s(tone_v, 0.02, 3.0, path).unwrap();
            assert!(misfit_s - 1.0 < 0.045, "{gain}");
        }
    }

    #[test]
    fn frames_lost_on_the_way_out_are_no_misfit() {
        for lost_s in [0.001, 0.005, 0.026] {
            let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                sent_v(if time_s < 1.03 {
                    time_s
                } else {
                    time_s - lost_s
                })
            };
            assert_eq!(
                first_misfit_s(published_v, 0.02, 2.0, path),
                None,
                "{lost_s}"
            );
        }
    }

    #[test]
    fn half_the_gain_does_not_pass_for_a_delay() {
        // Modulation so fast that at each moment some delay would explain half the gain; it begins with a tone.
        let commanded_v = |frame: u64| {
            let time_s = (frame as f64 / RATE_HZ - 0.2).max(0.0);
            24.0 * (1.0 + 0.95 * (TAU * 20.0 * time_s).sin())
        };
        for phase in 0..40 {
            let fault_s = 1.0 + f64::from(phase) / 800.0;
            let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                sent_v(time_s) * if time_s < fault_s { 1.0 } else { 0.5 }
            };
            let misfit_s = first_misfit_s(commanded_v, 0.02, 2.0, path);
            assert!(
                misfit_s.is_some_and(|s| s > fault_s && s - fault_s < 0.11),
                "{phase}: {misfit_s:?}"
            );
        }
    }

    #[test]
    fn clocks_that_differ_by_1000_ppm_are_followed() {
        for ppm in [-900.0, 900.0] {
            let path =
                |time_s: f64, sent_v: &dyn Fn(f64) -> f64| sent_v(time_s * (1.0 + 1e-6 * ppm));
            assert_eq!(
                first_misfit_s(published_v, 0.05, 20.0, path),
                None,
                "{ppm} ppm"
            );
        }
    }

    #[test]
    fn frames_that_the_output_loses_now_and_then_are_no_fault() {
        for lost_s in [0.005, 0.01, 0.025] {
            // Every six seconds the output falls further behind, up to the loop's latency.
            let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                sent_v(time_s - (time_s / 6.0).floor().min(3.0) * lost_s)
            };
            assert_eq!(
                first_misfit_s(published_v, 0.01, 20.0, path),
                None,
                "{lost_s} s"
            );
        }
    }
}
