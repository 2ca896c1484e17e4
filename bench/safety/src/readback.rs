//! Comparison of the drive's read-back with the commanded envelope, on the sample clock: detects an amplifier that is
//! off, an unplugged cable, a changed gain.
//!
//! The delay from a command to its read-back is not known exactly, but it is the same for all samples: some delay
//! within the loop's latency must explain at least half of the latest readings. Both sides are counted in frames, so a
//! starved computer that reads late and in bursts changes nothing.

use std::collections::VecDeque;

/// Length of the readings that are judged together, s; half of them must fit.
const WINDOW_S: f64 = 0.04;
/// Fewest readings that are judged together, for a card whose buffers are longer than the window.
const FEWEST_READINGS: usize = 4;
/// Step between the delays that are tried, and tolerance in time of a command, s.
const STEP_S: f64 = 0.001;

/// Readings that no delay explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
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
///     assert_eq!(readback.reading(frame, 20.5), None);
/// }
/// // The amplifier goes off.
/// let misfit = (1000..1100).find_map(|frame| {
///     readback.command(frame, 20.0);
///     readback.reading(frame, 0.0)
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
        }
    }

    /// Takes the envelope that is commanded at the latest rendered frame, V peak.
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

    /// Takes the envelope that is read back at `sample`, V peak; returns a misfit if the latest readings are not what
    /// was commanded.
    pub fn reading(&mut self, sample: u64, volts: f64) -> Option<Misfit> {
        let sample = sample as i64;
        if self.readings.back().is_some_and(|last| last.0 >= sample) {
            return None;
        }
        self.readings.push_back((sample, volts));
        while self.readings.len() > FEWEST_READINGS && self.readings[1].0 <= sample - self.window {
            self.readings.pop_front();
        }
        let &(rendered, _) = self.commands.back()?;
        if self.readings.len() < FEWEST_READINGS {
            return None;
        }
        let explained = |delay: i64| {
            let shift = rendered - sample - delay;
            let fits = self
                .readings
                .iter()
                .filter(|&&(at, volts)| self.fits(at + shift, volts));
            2 * fits.count() >= self.readings.len()
        };
        let mut delays = (0..=self.latency).step_by(self.step as usize);
        if delays.any(explained) {
            return None;
        }
        let late = |&&(frame, _): &&(i64, f64)| frame >= rendered - self.latency;
        let commands = self.commands.iter().filter(late).map(|&(_, volts)| volts);
        Some(Misfit {
            measured_v: volts,
            commanded_v: (
                commands.clone().fold(f64::INFINITY, f64::min),
                commands.fold(0.0, f64::max),
            ),
        })
    }

    /// Drops all readings, as before arming: they say nothing about what follows.
    pub fn forget_readings(&mut self) {
        self.readings.clear();
    }

    fn fits(&self, frame: i64, volts: f64) -> bool {
        let about = [-self.step, 0, self.step].map(|off| self.commanded_v(frame + off));
        let low_v = about.into_iter().fold(f64::INFINITY, f64::min);
        let high_v = about.into_iter().fold(0.0, f64::max);
        volts >= low_v * (1.0 - self.tolerance) - self.floor_v
            && volts <= high_v * (1.0 + self.tolerance) + self.floor_v
    }

    /// Returns the envelope commanded at `frame`, V peak: linear between two known commands, outside of them the
    /// nearest.
    fn commanded_v(&self, frame: i64) -> f64 {
        let after = self.commands.partition_point(|&(at, _)| at < frame);
        match (
            after
                .checked_sub(1)
                .and_then(|before| self.commands.get(before)),
            self.commands.get(after),
        ) {
            (Some(&(from, low)), Some(&(to, high))) => {
                low + (high - low) * (frame - from) as f64 / (to - from) as f64
            }
            (Some(&(_, volts)), None) | (None, Some(&(_, volts))) => volts,
            (None, None) => 0.0,
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

    /// Runs blocks until a misfit; `path` makes of the commanded volts at a time, s, those read back `delay_s` later.
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
                .reading(frame, path(time_s, &|time_s| at_s(time_s - delay_s)))
                .map(|_| time_s)
        })
    }

    #[test]
    fn what_was_commanded_fits_whatever_the_delay() {
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

    #[test]
    fn an_amplifier_that_goes_off_is_seen_within_50_ms_at_any_phase() {
        for commanded_v in [published_v, tone_v] {
            for delay_s in [0.0, 0.02, 0.06] {
                for phase in 0..40 {
                    let off_s = 1.0 + f64::from(phase) / 240.0;
                    let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                        if time_s < off_s { sent_v(time_s) } else { 0.0 }
                    };
                    let seen_s = first_misfit_s(commanded_v, delay_s, 2.0, path).unwrap();
                    assert!(
                        (0.0..0.045).contains(&(seen_s - off_s)),
                        "{delay_s} s, {phase}: {}",
                        seen_s - off_s
                    );
                }
            }
        }
    }

    #[test]
    fn a_changed_gain_is_seen_at_the_next_crest() {
        for gain in [0.5, 2.0] {
            for phase in 0..40 {
                let off_s = 1.0 + f64::from(phase) / 240.0;
                let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                    sent_v(time_s) * if time_s < off_s { 1.0 } else { gain }
                };
                let seen_s = first_misfit_s(published_v, 0.02, 3.0, path).unwrap();
                assert!(seen_s > off_s && seen_s - off_s < 0.21, "{gain}, {phase}");
            }
            let path = |time_s: f64, sent_v: &dyn Fn(f64) -> f64| {
                sent_v(time_s) * if time_s < 1.0 { 1.0 } else { gain }
            };
            let seen_s = first_misfit_s(tone_v, 0.02, 3.0, path).unwrap();
            assert!(seen_s - 1.0 < 0.045, "{gain}");
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
}
