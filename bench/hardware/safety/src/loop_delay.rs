//! Measurement of the loop's delay, from a command to its read-back, by each rise of the drive from silence.
//!
//! Frames rendered and samples captured are both counted in the callbacks, so a starved computer that reads late
//! changes nothing. The shape of the rise is known and its gain is not: the result is the delay at which some gain
//! leaves the least residual.

use std::collections::VecDeque;

use serde::Serialize;

use crate::commanded_envelope::CommandedEnvelope;

/// Delay from a command to its read-back, as the program sees it, with the buffers of both directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopDelay {
    /// The delay, s.
    pub seconds: f64,
    /// Standard error, s.
    pub standard_error_s: f64,
}

/// Largest difference between the loop's delay and the measured one at which a bench is armed, s.
pub const DELAY_WITHIN_S: f64 = 0.005;

/// Step between the delays tried, s.
const STEP_S: f64 = 1e-3;
/// Delays below zero that are tried, steps, so that the least residual lies between two.
const BELOW: i64 = 2;
/// Time from the beginning of a rise to the first look, and between two looks, s.
const LOOK_S: f64 = 0.025;
/// Time after which the search for a delay in a rise is given up, s.
const GIVE_UP_S: f64 = 1.0;
/// Fewest readings that show a delay.
const FEWEST: usize = 12;
/// Standard error below which a delay is known, s.
const KNOWN_S: f64 = 5e-4;
/// Share of the largest command below which the read-back counts as absent.
const COME_BACK: f64 = 0.2;
/// Factor by which neighbouring readings, which share samples and hum, widen the error.
const SHARED: f64 = 2.0;

/// Reading, with the count of frames at its block's arrival.
#[derive(Debug, Clone, Copy)]
struct Read {
    sample: i64,
    ahead: i64,
    volts: f64,
}

/// Watches a drive for rises from silence, and measures the loop's delay by each.
#[derive(Debug, Clone)]
pub(crate) struct DelayMeter {
    rate_hz: f64,
    step: i64,
    /// Longest delay tried, steps.
    longest: i64,
    /// Rendered frames and the envelope commanded there, V peak, from the last silent frame on; empty before a silent
    /// frame.
    commands: VecDeque<(i64, f64)>,
    readings: Vec<Read>,
    /// Next look, frames after the beginning of the rise; `None` once the delay is known or given up.
    next_look: Option<i64>,
}

impl DelayMeter {
    /// Makes a meter of delays up to `longest_s` at `rate_hz`.
    pub(crate) fn new(rate_hz: f64, longest_s: f64) -> Self {
        Self {
            rate_hz,
            step: ((STEP_S * rate_hz) as i64).max(1),
            longest: (longest_s / STEP_S).ceil() as i64,
            commands: VecDeque::new(),
            readings: Vec::new(),
            next_look: None,
        }
    }

    fn frames(&self, seconds: f64) -> i64 {
        (seconds * self.rate_hz) as i64
    }

    /// Takes the envelope commanded at the latest rendered frame, V peak.
    pub(crate) fn command(&mut self, frame: u64, envelope_v: f64) {
        let frame = frame as i64;
        if envelope_v == 0.0 {
            self.commands.clear();
            self.readings.clear();
            self.commands.push_back((frame, 0.0));
            self.next_look = Some(3 * self.frames(LOOK_S));
            return;
        }
        if self.next_look.is_none() {
            return;
        }
        match self.commands.back_mut() {
            Some(last) if last.0 == frame => last.1 = envelope_v,
            Some(_) => self.commands.push_back((frame, envelope_v)),
            // The drive was not silent before: the start of its rise is unknown.
            None => {}
        }
    }

    /// Returns whether the drive is rising and may still show the delay.
    pub(crate) fn is_rising(&self) -> bool {
        self.next_look.is_some() && self.commands.len() > 1
    }

    /// Takes the envelope read back at `sample`, V peak; `ahead` is the number of frames rendered less those captured
    /// when its block arrived. Returns the delay once this rise has shown it.
    pub(crate) fn reading(&mut self, sample: u64, ahead: i64, volts: f64) -> Option<LoopDelay> {
        let look = self.next_look?;
        let (&(first_frame, _), &(rendered, _)) = (self.commands.front()?, self.commands.back()?);
        let sample = sample as i64;
        if rendered == first_frame
            || self
                .readings
                .last()
                .is_some_and(|last| last.sample >= sample)
        {
            return None;
        }
        self.readings.push(Read {
            sample,
            ahead,
            volts,
        });
        if rendered - first_frame < look {
            return None;
        }
        let delay = self.look();
        let is_given_up = rendered - first_frame > self.frames(GIVE_UP_S);
        self.next_look = (delay.is_none() && !is_given_up).then_some(look + self.frames(LOOK_S));
        delay
    }

    /// Returns the delay, if the readings so far show it.
    fn look(&self) -> Option<LoopDelay> {
        let most = |volts: &mut dyn Iterator<Item = f64>| volts.fold(0.0, f64::max);
        let read_v = most(&mut self.readings.iter().map(|reading| reading.volts));
        let commanded_v = most(&mut self.commands.iter().map(|command| command.1));
        if self.readings.len() < FEWEST || read_v < COME_BACK * commanded_v {
            return None;
        }
        let ahead = self.usual_ahead();
        let residual = |steps: i64| self.residual_v2(ahead - steps * self.step);
        let (best, least) = (-BELOW..=self.longest)
            .map(|steps| (steps, residual(steps)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        if best == -BELOW || best == self.longest {
            return None;
        }
        // A parabola through the least residual and its neighbours.
        let (lower, upper) = (residual(best - 1), residual(best + 1));
        let curvature = 0.5 * (lower + upper) - least;
        let variance_v2 = least / (self.readings.len() - 2) as f64;
        let error_steps = SHARED * (variance_v2 / curvature).sqrt();
        let steps = best as f64 + 0.25 * (lower - upper) / curvature;
        let step_s = self.step as f64 / self.rate_hz;
        (error_steps * step_s < KNOWN_S).then_some(LoopDelay {
            seconds: steps * step_s,
            standard_error_s: error_steps * step_s,
        })
    }

    /// Returns the median of the frames rendered less those captured, which an occasional late callback does not move.
    fn usual_ahead(&self) -> i64 {
        let mut leads: Vec<i64> = self.readings.iter().map(|reading| reading.ahead).collect();
        leads.sort_unstable();
        leads[leads.len() / 2]
    }

    /// Returns the residual sum of squares at the best gain, with sample s showing the command at frame s + `lead`, V².
    fn residual_v2(&self, lead: i64) -> f64 {
        let (mut read2, mut product, mut commanded2) = (0.0, 0.0, 0.0);
        let first_frame = self.commands.front().map_or(0, |command| command.0);
        let mut commanded = CommandedEnvelope::new(&self.commands);
        for reading in &self.readings {
            let frame = reading.sample + lead;
            // Up to the first frame the drive is silent.
            let commanded_v = if frame > first_frame {
                commanded.at(frame)
            } else {
                0.0
            };
            read2 += reading.volts * reading.volts;
            product += reading.volts * commanded_v;
            commanded2 += commanded_v * commanded_v;
        }
        if commanded2 > 0.0 {
            (read2 - product * product / commanded2).max(0.0)
        } else {
            read2
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    const RATE_HZ: f64 = 192e3;
    /// Frames rendered before the input began.
    const HEAD_START: i64 = 77_777;
    const SILENCE_S: f64 = 0.7;

    /// A drive with a raised-cosine ramp, polled every 2 ms.
    struct Bench {
        block: i64,
        ramp_s: f64,
        mean_v: f64,
        index: f64,
        modulation_hz: f64,
        gain: f64,
        delay_s: f64,
        /// Interval of the late input blocks, and the frames by which they are late.
        late: (i64, i64),
        hum_v: f64,
    }

    const TONE: Bench = Bench {
        block: 256,
        ramp_s: 0.05,
        mean_v: 2.0,
        index: 0.0,
        modulation_hz: 6.0,
        gain: 1.0,
        delay_s: 0.012,
        late: (i64::MAX, 0),
        hum_v: 0.0,
    };

    impl Bench {
        fn commanded_v(&self, frame: i64) -> f64 {
            let elapsed_s = frame as f64 / RATE_HZ - SILENCE_S;
            let ramp = 0.5 * (1.0 - (PI * (elapsed_s / self.ramp_s).clamp(0.0, 1.0)).cos());
            let phase = TAU * self.modulation_hz * elapsed_s;
            ramp * self.mean_v * (1.0 + self.index * phase.sin())
        }

        /// Returns the delay found, and the time at which it is found, s after the beginning of the rise.
        fn measurement(&self) -> Option<(LoopDelay, f64)> {
            let mut meter = DelayMeter::new(RATE_HZ, 0.1);
            // Rendered frames wait in buffers for the whole delay; a block arrives once it is complete.
            let lead = HEAD_START;
            let ahead = HEAD_START + (self.delay_s * RATE_HZ) as i64;
            (0..1000).find_map(|poll: i64| {
                let captured = poll * 384 / self.block * self.block;
                let late = if poll % self.late.0 == 1 {
                    self.late.1
                } else {
                    0
                };
                let rendered = captured + ahead;
                meter.command(rendered as u64, self.commanded_v(rendered));
                let hum_v = self.hum_v * (TAU * 50.0 * captured as f64 / RATE_HZ).sin();
                let read_v = self.gain * self.commanded_v(captured + lead) + hum_v;
                let after_s = rendered as f64 / RATE_HZ - SILENCE_S;
                meter
                    .reading(captured as u64, ahead + late, read_v.abs())
                    .map(|delay| (delay, after_s))
            })
        }
    }

    #[test]
    fn a_delay_is_found_within_a_millisecond_in_a_fifth_of_a_second() {
        for delay_s in [0.001, 0.0123, 0.04, 0.08] {
            for block in [64, 256, 1024, 2048] {
                for gain in [1.0, 0.5, 1.9] {
                    for (index, modulation_hz) in [(0.0, 6.0), (0.95, 6.0), (0.95, 40.0)] {
                        // Between two callbacks the envelope is not known.
                        if index > 0.0 && modulation_hz * block as f64 > 0.1 * RATE_HZ {
                            continue;
                        }
                        let bench = Bench {
                            block,
                            gain,
                            index,
                            modulation_hz,
                            delay_s,
                            mean_v: 24.0,
                            ..TONE
                        };
                        let Some((delay, after_s)) = bench.measurement() else {
                            panic!("{delay_s} s, {block} frames, {gain}, {modulation_hz} Hz")
                        };
                        let error_s = delay.seconds - delay_s;
                        assert!(
                            error_s.abs() < 1e-3 && after_s < 0.25,
                            "{delay_s} s, {block} frames, {gain}, {modulation_hz} Hz: {error_s} s off after {after_s} s"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_slow_ramp_takes_longer_and_a_slow_computer_changes_nothing() {
        let slow = Bench {
            ramp_s: 0.5,
            ..TONE
        };
        let (delay, _) = slow.measurement().unwrap();
        assert!((delay.seconds - 0.012).abs() < 1e-3, "{delay:?}");
        let starved = Bench {
            late: (5, 8_000),
            ..TONE
        };
        let (delay, _) = starved.measurement().unwrap();
        assert!((delay.seconds - 0.012).abs() < 1e-3, "{delay:?}");
    }

    #[test]
    fn a_missing_or_buried_read_back_shows_no_delay() {
        let silent = Bench { gain: 0.0, ..TONE };
        assert_eq!(silent.measurement(), None);
        let noisy = Bench { hum_v: 2.0, ..TONE };
        assert_eq!(noisy.measurement(), None);
        // Longer than all delays tried.
        let long = Bench {
            delay_s: 0.15,
            ..TONE
        };
        assert_eq!(long.measurement(), None);
    }
}
