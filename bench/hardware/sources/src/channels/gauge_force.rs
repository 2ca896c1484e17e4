//! Force source for gauges on inputs of the sound card.

use config::{Correction, Gauges};
use safety::Nonsense;
use signalgen::InputTap;

use super::decimator::Decimator;
use super::stuck::StuckWatch;
use crate::correct::Corrector;
use crate::force_source::{ForceSource, LineFaults, Moment, SourceHealth, TimedForce};
use crate::loss::SourceGone;
use crate::nonsense::NonsenseWatch;

/// Bytes per sample, for the count of bytes without a reading.
const SAMPLE_BYTES: u64 = 4;
/// Largest number of blocks per poll, so that a card faster than the reader cannot block it. Further blocks wait in the ring,
/// and count as lost when it overflows.
const MOST_BLOCKS: usize = 1024;

/// A force sensor on inputs of the sound card.
pub struct GaugeForce {
    tap: InputTap,
    decimator: Decimator,
    newtons_per_unit: [Vec<f64>; 2],
    clip_units: f32,
    /// The sensor's own delay, frames.
    late_frames: f64,
    corrector: Corrector,
    stuck: StuckWatch,
    samples: Vec<f32>,
    /// Number of non-finite samples.
    not_finite: u64,
    nonsense: NonsenseWatch,
    /// Bytes and readings of the latest poll.
    polled: (u64, u64),
}

impl GaugeForce {
    /// Creates a source for the inputs of `gauges`, delivered by `tap`, on a card that runs at `card_hz`; `latency_s` is the
    /// sensor's own delay, s.
    #[must_use]
    pub fn new(
        tap: InputTap,
        gauges: &Gauges,
        card_hz: f64,
        latency_s: f64,
        correction: Correction,
        range_n: Option<f64>,
    ) -> Self {
        let count = gauges.inputs.len();
        let late: Vec<f64> = (0..count)
            .map(|input| input as f64 * gauges.skew_s * card_hz)
            .collect();
        Self {
            tap,
            decimator: Decimator::new((card_hz / gauges.rate_hz).round() as usize, &late),
            newtons_per_unit: gauges.newtons_per_unit(),
            clip_units: gauges.clip_units as f32,
            late_frames: latency_s * card_hz,
            corrector: Corrector::new(correction, range_n),
            stuck: StuckWatch::new(count, card_hz),
            samples: Vec::new(),
            not_finite: 0,
            nonsense: NonsenseWatch::default(),
            polled: (0, 0),
        }
    }
}

impl ForceSource for GaugeForce {
    fn poll(
        &mut self,
        _now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone> {
        let (mut readings, mut bytes_unread) = (0, 0);
        for _ in 0..MOST_BLOCKS {
            let Some(block) = self.tap.pop_block(&mut self.samples) else {
                break;
            };
            self.stuck.take(&self.samples);
            let stuck = self.stuck.is_stuck();
            let (newtons, clip_units) = (&self.newtons_per_unit, self.clip_units);
            let (corrector, late_frames) = (&self.corrector, self.late_frames);
            let clips = |value: f32| value.abs() >= clip_units;
            let first = block.first_frame;
            let invalid_count = self.decimator.take(first, &self.samples, clips, |value| {
                if stuck {
                    return;
                }
                let raw_n = [0, 1].map(|axis: usize| {
                    let gauges = newtons[axis].iter().zip(&value.values);
                    gauges.map(|(newtons, value)| newtons * value).sum()
                });
                let moment = Moment::Card(value.frame as f64 - late_frames);
                readings += 1;
                take(corrector.force(moment, raw_n, [value.clipped; 2]));
            });
            self.not_finite += invalid_count;
            if stuck {
                bytes_unread += SAMPLE_BYTES * self.samples.len() as u64;
            } else {
                bytes_unread += SAMPLE_BYTES * invalid_count;
            }
        }
        self.polled = (bytes_unread, readings);
        Ok(())
    }

    fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: LineFaults {
                corrupt: self.not_finite,
                lost: self.decimator.lost(),
                ..LineFaults::default()
            },
            clock: None,
            pace: None,
        }
    }

    fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = self.polled;
        self.nonsense.take(now_ns, bytes, readings)
    }
}

#[cfg(test)]
mod tests {
    use signalgen::TapFeed;

    use super::*;

    const RATE_HZ: f64 = 48_000.0;

    fn gauges() -> Gauges {
        Gauges {
            inputs: vec![2, 3, 4],
            newtons_per_v: vec![vec![2.0, 2.0, 0.0], vec![0.0, -1.0, 5.0]],
            volts_per_unit: vec![1.0, 1.0, 2.0],
            ..Gauges::default()
        }
    }

    fn source(latency_s: f64) -> (TapFeed, GaugeForce) {
        let (feed, tap) = InputTap::with_feed(3, 96_000);
        let source = GaugeForce::new(
            tap,
            &gauges(),
            RATE_HZ,
            latency_s,
            Correction::default(),
            None,
        );
        (feed, source)
    }

    /// Returns one second of constant voltages with noise at the least significant bit.
    fn second(first: u64, levels_v: [f32; 3]) -> Vec<f32> {
        let noise = |n: u64| if n.is_multiple_of(2) { 1e-6 } else { -1e-6 };
        (first..first + 48_000)
            .flat_map(|n| levels_v.map(|volts| volts + noise(n)))
            .collect()
    }

    fn polled(source: &mut GaugeForce) -> Vec<TimedForce> {
        let mut forces = Vec::new();
        source
            .poll(&|| 0.0, &mut |force| forces.push(force))
            .unwrap();
        forces
    }

    #[test]
    fn the_matrix_and_the_gains_make_newtons_and_the_delay_is_taken_off() {
        let (mut feed, mut source) = source(0.001);
        feed.feed(0, &second(0, [0.1, 0.2, -0.05]));
        let forces = polled(&mut source);
        assert!(forces.len() > 3900, "{}", forces.len());
        for force in &forces {
            assert!((force.normal_n - 0.6).abs() < 1e-6, "{}", force.normal_n);
            assert!((force.lateral_n + 0.7).abs() < 1e-6, "{}", force.lateral_n);
            let Moment::Card(frame) = force.moment else {
                panic!("not on the card's clock");
            };
            assert_eq!((frame + 48.0) % 12.0, 0.0);
        }
        assert_eq!(source.health(), SourceHealth::default());
        assert_eq!(source.nonsense(1), Nonsense::default());
    }

    /// Fault 46.
    #[test]
    fn a_gauge_at_its_end_saturates_both_axes() {
        let (mut feed, mut source) = source(0.0);
        feed.feed(0, &second(0, [0.1, -0.9995, 0.0]));
        let forces = polled(&mut source);
        assert!(
            forces
                .iter()
                .all(|force| force.normal_saturated && force.lateral_saturated)
        );
    }

    /// Fault 46.
    #[test]
    fn an_input_that_never_changes_is_no_reading() {
        let (mut feed, mut source) = source(0.0);
        feed.feed(0, &second(0, [0.1, 0.1, 0.1]));
        assert!(!polled(&mut source).is_empty());
        let mut muted = second(48_000, [0.1, 0.1, 0.1]);
        muted.chunks_exact_mut(3).for_each(|frame| frame[1] = 0.0);
        for (block, part) in muted.chunks(3 * 480).enumerate() {
            feed.feed(48_000 + 480 * block as u64, part);
            let forces = polled(&mut source);
            assert_eq!(forces.is_empty(), block >= 3, "{block}");
        }
        assert!(source.nonsense(1).bytes > 256);
    }

    /// Fault 46.
    #[test]
    fn samples_that_are_no_numbers_never_make_a_force() {
        let (mut feed, mut source) = source(0.0);
        let mut frames = second(0, [0.1, 0.1, 0.1]);
        frames
            .iter_mut()
            .skip(1)
            .step_by(300)
            .for_each(|value| *value = f32::NAN);
        feed.feed(0, &frames);
        assert_eq!(polled(&mut source), []);
        assert_eq!(source.health().faults.corrupt, 480);
        assert!(source.nonsense(1).bytes > 256);
    }
}
