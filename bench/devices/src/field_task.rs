//! The task that reads the slow inputs beside the audio: force, position, the participant's button. Its readings are on
//! the host's clock; the acquisition places them on the audio clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crossbeam_channel::Sender;

use crate::encoder::{Placed, PositionEncoder, Watched};
use crate::gauges::Gauges;
use safety::InputLine;
use safety::{Press, SafetyCommand, Signals, Trip};
pub use sources::position::POSITION_HZ;
use sources::{ForceSource, LineFaults, Moment, SourceGone, SourceHealth, TimedForce};
use tasks::{Clock, Mailbox, Task};

/// A reading of a slow input, on the host's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldReading {
    /// A sample of the force sensor.
    Force(TimedForce),
    /// Faults of the force sensor within the burst that was just read, or before it.
    ForceFaults {
        /// When the last sample before the burst acted.
        since: Moment,
        /// When its own last one did, or when it came if it has none.
        at: Moment,
        /// Faults since the reading before.
        faults: LineFaults,
    },
    /// A reading of the encoder.
    Position {
        /// Host time, s.
        host_s: f64,
        /// Position along the plate, m; NaN while jumps have left it unknown.
        position_m: f64,
        /// Number of encoder states missed since the last position.
        missed: u64,
        /// Whether the last position is too far away to have been left since.
        jumped: bool,
    },
}

impl FieldReading {
    /// Returns from when on what the reading tells may have been so.
    pub fn since(&self) -> Moment {
        match self {
            Self::ForceFaults { since, .. } => *since,
            _ => self.at(),
        }
    }

    /// Returns the moment of the reading.
    pub fn at(&self) -> Moment {
        match self {
            Self::Force(force) => force.at,
            Self::ForceFaults { at, .. } => *at,
            Self::Position { host_s, .. } => Moment::Host(*host_s),
        }
    }
}

/// Time after which a contact has stopped bouncing, ns.
const BOUNCE_NS: u64 = 30_000_000;

/// The task that reads force sensor, encoder and button.
pub struct Field {
    force: Option<Box<dyn ForceSource>>,
    /// When the last force acted.
    force_at: Option<Moment>,
    encoder: Option<PositionEncoder>,
    button: Option<Box<dyn InputLine>>,
    readings: Sender<FieldReading>,
    pressed: Arc<AtomicBool>,
    signals: Arc<Signals>,
    gauges: Arc<Gauges>,
    safety: Mailbox<SafetyCommand>,
    clock: Arc<dyn Clock>,
    button_high: bool,
    button_changed_ns: u64,
}

impl Field {
    /// Makes a task for those inputs that are wired. It raises `pressed` at each press of the button; the reader lowers
    /// it.
    #[expect(
        clippy::too_many_arguments,
        reason = "the composition root names each once"
    )]
    pub fn new(
        force: Option<Box<dyn ForceSource>>,
        encoder: Option<PositionEncoder>,
        button: Option<Box<dyn InputLine>>,
        readings: Sender<FieldReading>,
        pressed: Arc<AtomicBool>,
        signals: Arc<Signals>,
        gauges: Arc<Gauges>,
        safety: Mailbox<SafetyCommand>,
        clock: Arc<dyn Clock>,
    ) -> Self {
        Self {
            force,
            force_at: None,
            encoder,
            button,
            readings,
            pressed,
            signals,
            gauges,
            safety,
            clock,
            button_high: false,
            button_changed_ns: 0,
        }
    }

    fn read_force(&mut self, now_ns: u64) {
        let Some(source) = &mut self.force else {
            return;
        };
        let (since, mut last) = (self.force_at, self.force_at);
        let (mut arrived, mut hardest) = (0, None::<Press>);
        let clock = &self.clock;
        let polled = source.poll(&|| seconds(clock.now_ns()), &mut |force| {
            last = Some(force.at);
            let press = Press {
                normal_n: force.normal_n,
                lateral_n: force.lateral_n,
                raw_n: force.raw_n,
                saturated: force.normal_saturated,
                at_ns: now_ns,
            };
            hardest = Some(hardest.map_or(press, |hardest| hardest.or_harder(press)));
            arrived += 1;
            // The acquisition ends only when the bench stops.
            let _ = self.readings.send(FieldReading::Force(force));
        });
        self.signals.force_polled_ns.set(now_ns);
        if let Some(press) = hardest {
            self.signals.press.set(press);
        }
        let mut health = self.gauges.field.get().unwrap_or_default();
        let SourceHealth {
            faults: so_far,
            drift_ppm,
        } = source.health();
        let faults = so_far.since(&health.force);
        // Bytes before the first sample are the end of a frame that began before the port was opened.
        if faults != LineFaults::default() && health.force_samples > 0 {
            let now = Moment::Host(seconds(now_ns));
            let at = last.filter(|_| arrived > 0).unwrap_or(now);
            let since = since.unwrap_or(at);
            let _ = self
                .readings
                .send(FieldReading::ForceFaults { since, at, faults });
        }
        self.force_at = last;
        health.force = so_far;
        health.drift_ppm = drift_ppm;
        health.force_samples += arrived;
        self.gauges.field.set(health);
        self.signals.nonsense.set(source.nonsense(now_ns));
        if let Err(error) = polled {
            let message = error.to_string();
            self.safety
                .send(SafetyCommand::Trip(Trip::Fault { message }));
            self.force = None;
        }
    }

    fn read_encoder(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let Some(encoder) = &mut self.encoder else {
            return Ok(());
        };
        let clock = &self.clock;
        let mut placed = false;
        let polled = encoder.poll(now_ns, &|| seconds(clock.now_ns()), &mut |position| {
            placed = true;
            let Placed {
                host_s,
                watched: Watched { position_m, jumped },
                missed,
            } = position;
            // The acquisition ends only when the bench stops.
            let _ = self.readings.send(FieldReading::Position {
                host_s,
                position_m,
                missed,
                jumped,
            });
        });
        if placed {
            let mut health = self.gauges.field.get().unwrap_or_default();
            health.encoder_skipped = encoder.missed();
            self.gauges.field.set(health);
        }
        match polled {
            Ok(()) => Ok(()),
            Err(SourceGone::Line(error)) => Err(error.into()),
            Err(gone) => {
                let message = gone.to_string();
                self.safety
                    .send(SafetyCommand::Trip(Trip::Fault { message }));
                self.encoder = None;
                Ok(())
            }
        }
    }

    fn read_button(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let Some(button) = &mut self.button else {
            return Ok(());
        };
        let high = button.is_high()?;
        let mut health = self.gauges.field.get().unwrap_or_default();
        let mut news = health.button_pressed != Some(high);
        health.button_pressed = Some(high);
        if high != self.button_high && now_ns.saturating_sub(self.button_changed_ns) >= BOUNCE_NS {
            self.button_high = high;
            self.button_changed_ns = now_ns;
            if high {
                self.pressed.store(true, Ordering::Release);
                news = true;
                health.button_presses += 1;
                health.button_press_ns = Some(now_ns);
            }
        }
        if news {
            self.gauges.field.set(health);
        }
        Ok(())
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

impl Task for Field {
    fn name(&self) -> &'static str {
        "field"
    }

    fn period(&self) -> Duration {
        Duration::from_micros(100)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        self.read_force(now_ns);
        self.read_encoder(now_ns)?;
        self.read_button(now_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use safety::GpioError;
    use tasks::SystemClock;

    /// A line that the test sets.
    struct Level(Arc<AtomicBool>);

    impl InputLine for Level {
        fn is_high(&mut self) -> Result<bool, GpioError> {
            Ok(self.0.load(Ordering::Relaxed))
        }
    }

    #[test]
    fn a_short_press_stays_counted_with_its_time() {
        let (level, pressed) = <(Arc<AtomicBool>, Arc<AtomicBool>)>::default();
        let gauges: Arc<Gauges> = Arc::default();
        let mut field = Field::new(
            None,
            None,
            Some(Box::new(Level(level.clone()))),
            crossbeam_channel::unbounded().0,
            pressed.clone(),
            Arc::default(),
            gauges.clone(),
            Mailbox::default(),
            Arc::new(SystemClock::start()),
        );
        let mut at = |ms: u64, high: bool| {
            level.store(high, Ordering::Relaxed);
            field.poll(ms * 1_000_000).unwrap();
            let now = gauges.field.get().unwrap();
            (now.button_pressed, now.button_presses, now.button_press_ns)
        };
        assert_eq!(at(100, false), (Some(false), 0, None));
        assert_eq!(at(110, true), (Some(true), 1, Some(110_000_000)));
        // It bounces.
        assert_eq!(at(112, false).1, 1);
        assert_eq!(at(113, true).1, 1);
        assert_eq!(at(160, false), (Some(false), 1, Some(110_000_000)));
        assert_eq!(at(900, false), (Some(false), 1, Some(110_000_000)));
        assert_eq!(at(910, true), (Some(true), 2, Some(910_000_000)));
        assert!(pressed.load(Ordering::Acquire));
    }
}
