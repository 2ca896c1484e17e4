//! Task that reads the slow inputs: force, position and the participant's button. Its readings are on the host's clock;
//! the acquisition places them on the audio clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::encoder::{Placed, PositionEncoder, Watched};
pub use crate::field_reading::FieldReading;
use crate::gauges::DeviceReadings;
use crate::reading_queue::ReadingSender;
use safety::{GpioError, InputLine};
use safety::{LostDevice, Press, SafetyCommand, Signals, Trip};
pub use sources::position::POSITION_HZ;
use sources::{ForceSource, LineFaults, Moment, SourceGone, SourceHealth};
use tasks::{Clock, Mailbox, Task};

/// Time without a poll after which arrivals say nothing about a clock, ns: the program was frozen, and perhaps the
/// card.
const ABSENCE_NS: u64 = 100_000_000;
/// Time after such an absence in which the maps of the clocks settle again, ns.
const SETTLES_NS: u64 = 10_000_000_000;

/// Time after which a contact has stopped bouncing, ns.
const BOUNCE_NS: u64 = 30_000_000;
/// Time after its first reading within which a sensor may restart without a trip, ns: many restart as their port is
/// opened.
const GREETING_NS: u64 = 5_000_000_000;

/// Time between two trips of a line that goes on failing, ns: a bench that is re-armed meanwhile stops again.
const FAILING_NS: u64 = 100_000_000;

/// Source with a clock that disagrees with the arrival of its readings.
#[derive(Debug, thiserror::Error)]
#[error(
    "the {0} restarted, or its clock jumped: look at its supply and its cable, and re-arm; readings from now on are \
     placed correctly"
)]
struct SensorRestarted(&'static str);

/// Task that reads force sensor, encoder and button.
pub struct Field {
    force: Option<Box<dyn ForceSource>>,
    /// Time at which the last force acted.
    force_at: Option<Moment>,
    encoder: Option<PositionEncoder>,
    button: Option<Box<dyn InputLine>>,
    readings: ReadingSender,
    pressed: Arc<AtomicBool>,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    safety: Mailbox<SafetyCommand>,
    clock: Arc<dyn Clock>,
    /// Time of the last poll, ns.
    polled_ns: Option<u64>,
    /// Time from which on the sources' clocks are judged, ns.
    judged_from_ns: u64,
    /// Arrival of the first force and of the first position, ns.
    first_ns: [Option<u64>; 2],
    position_restarts: u64,
    /// Whether the encoder's lines fail.
    is_encoder_failing: bool,
    /// Time of the last trip by a line that fails, ns.
    line_tripped_ns: Option<u64>,
    button_high: bool,
    button_changed_ns: u64,
}

impl Field {
    /// Makes a task for the inputs that are wired. It raises `pressed` at each press of the button; the reader lowers
    /// it.
    #[expect(
        clippy::too_many_arguments,
        reason = "the composition root names each once"
    )]
    pub fn new(
        force: Option<Box<dyn ForceSource>>,
        encoder: Option<PositionEncoder>,
        button: Option<Box<dyn InputLine>>,
        readings: ReadingSender,
        pressed: Arc<AtomicBool>,
        signals: Arc<Signals>,
        gauges: Arc<DeviceReadings>,
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
            polled_ns: None,
            judged_from_ns: 0,
            first_ns: [None; 2],
            position_restarts: 0,
            is_encoder_failing: false,
            line_tripped_ns: None,
            button_high: false,
            button_changed_ns: 0,
        }
    }

    fn read_force(&mut self, now_ns: u64) {
        let Some(source) = &mut self.force else {
            return;
        };
        let (since, mut last) = (self.force_at, self.force_at);
        let (mut count, mut press_peak) = (0, None::<Press>);
        let clock = &self.clock;
        let polled = source.poll(&|| seconds(clock.now_ns()), &mut |force| {
            last = Some(force.moment);
            let press = Press {
                normal_n: force.normal_n,
                lateral_n: force.lateral_n,
                raw_n: force.raw_n,
                saturated: force.normal_saturated,
                at_ns: now_ns,
            };
            press_peak = Some(press_peak.map_or(press, |press_peak| press_peak.or_harder(press)));
            count += 1;
            self.readings.send(FieldReading::Force(force));
        });
        self.signals.force_polled_ns.set(now_ns);
        if let Some(press) = press_peak {
            self.signals.press.set(press);
        }
        let mut health = self.gauges.field.get().unwrap_or_default();
        let SourceHealth {
            faults: so_far,
            clock: force_clock,
            pace: force_pace,
        } = source.health();
        let faults = so_far.since(&health.force);
        // Bytes before the first sample are the end of a frame that began before the port was opened.
        if faults != LineFaults::default() && health.force_samples > 0 {
            let now = Moment::Host(seconds(now_ns));
            let moment = last.filter(|_| count > 0).unwrap_or(now);
            let since = since.unwrap_or(moment);
            self.readings.send(FieldReading::ForceFaults {
                since,
                moment,
                faults,
            });
        }
        if count > 0 {
            let misplaced = force_clock.is_some_and(|clock| clock.misplaces());
            if let Some(moment) = last.filter(|_| misplaced) {
                self.readings.send(FieldReading::ClockFaults {
                    moment,
                    position_restarts: 0,
                    misplaced: count,
                });
            }
        }
        let [first_ns, _] = &mut self.first_ns;
        let restarted = greeted(first_ns, now_ns, count > 0) && faults.restarted > 0;
        let card = self.gauges.card_clock.get().unwrap_or_default();
        let excess_ppm = force_clock
            .and_then(|clock| clock.excess_ppm(&card))
            .or(force_pace.map(|pace| 1e6 * (pace - 1.0)))
            .filter(|_| now_ns >= self.judged_from_ns);
        let card_ppm = card.fast_ppm().unwrap_or_default();
        let polled = polled.and_then(|()| {
            excess_ppm.map_or(Ok(()), |fast_ppm| Err(source.off_rate(fast_ppm, card_ppm)))
        });
        self.force_at = last;
        health.force = so_far;
        health.force_clock = force_clock;
        health.force_pace = force_pace;
        health.force_samples += count;
        health.force_stated_hz = source.stated_hz();
        self.gauges.field.set(health);
        self.signals.nonsense.set(source.nonsense(now_ns));
        if restarted {
            self.trip(&SensorRestarted("force sensor"));
        }
        if let Err(error) = polled {
            self.lose(LostDevice::ForceSensor, &error);
            self.force = None;
        }
    }

    fn trip(&self, reason: &dyn std::error::Error) {
        let message = reason.to_string();
        self.safety
            .send(SafetyCommand::Trip(Trip::Fault { message }));
    }

    /// Stops the drive for a line that cannot be read. A line that can be read again is in use again: a chip that is plugged in
    /// comes back under its number.
    fn trip_line(&mut self, error: &GpioError, now_ns: u64) {
        let since_ns = self
            .line_tripped_ns
            .map(|last_ns| now_ns.saturating_sub(last_ns));
        if since_ns.is_none_or(|since_ns| since_ns >= FAILING_NS) {
            self.line_tripped_ns = Some(now_ns);
            let message = error.to_string();
            self.safety
                .send(SafetyCommand::Trip(Trip::Gpio { message }));
        }
    }

    /// Stops the drive for the loss of a device that is not opened again.
    fn lose(&self, device: LostDevice, reason: &SourceGone) {
        self.signals.losses.report(device);
        self.trip(reason);
    }

    fn read_encoder(&mut self, now_ns: u64) {
        let Some(encoder) = &mut self.encoder else {
            return;
        };
        let clock = &self.clock;
        let (mut count, mut last) = (0, None);
        let polled = encoder.poll(now_ns, &|| seconds(clock.now_ns()), &mut |position| {
            count += 1;
            last = Some(Moment::Host(position.host_s));
            let Placed {
                host_s,
                watched: Watched { position_m, jumped },
                missed,
            } = position;
            self.readings.send(FieldReading::Position {
                host_s,
                position_m,
                missed,
                jumped,
            });
        });
        let SourceHealth {
            faults,
            clock,
            pace,
        } = encoder.health();
        let previous = std::mem::replace(&mut self.position_restarts, faults.restarted);
        let position_restarts = faults.restarted - previous;
        if count > 0 {
            let mut health = self.gauges.field.get().unwrap_or_default();
            health.encoder_skipped = encoder.missed();
            health.position_clock = clock;
            self.gauges.field.set(health);
        }
        let misplaces = clock.is_some_and(|clock| clock.misplaces());
        let misplaced = if misplaces { count } else { 0 };
        if position_restarts + misplaced > 0 {
            let moment = last.unwrap_or(Moment::Host(seconds(now_ns)));
            self.readings.send(FieldReading::ClockFaults {
                moment,
                position_restarts,
                misplaced,
            });
        }
        let [_, first_ns] = &mut self.first_ns;
        if greeted(first_ns, now_ns, count > 0) && position_restarts > 0 {
            self.trip(&SensorRestarted("encoder's counter"));
        }
        let card = self.gauges.card_clock.get().unwrap_or_default();
        let excess_ppm = clock
            .and_then(|clock| clock.excess_ppm(&card))
            .or(pace.map(|pace| 1e6 * (pace - 1.0)))
            .filter(|_| now_ns >= self.judged_from_ns);
        let polled = polled.and_then(|()| match excess_ppm {
            Some(fast_ppm) => Err(SourceGone::Clock {
                source_name: "encoder's counter",
                fast_ppm,
                card_ppm: card.fast_ppm().unwrap_or_default(),
            }),
            None => Ok(()),
        });
        match polled {
            Ok(()) => {
                if std::mem::take(&mut self.is_encoder_failing) {
                    // Its counts were not read meanwhile.
                    self.readings.send(FieldReading::ClockFaults {
                        moment: Moment::Host(seconds(now_ns)),
                        position_restarts: 1,
                        misplaced: 0,
                    });
                }
            }
            Err(SourceGone::Line(error)) => {
                self.is_encoder_failing = true;
                self.trip_line(&error, now_ns);
            }
            Err(loss) => {
                self.lose(LostDevice::Encoder, &loss);
                self.encoder = None;
            }
        }
    }

    fn read_button(&mut self, now_ns: u64) {
        let Some(button) = &mut self.button else {
            return;
        };
        let high = match button.is_high() {
            Ok(high) => high,
            Err(error) => return self.trip_line(&error, now_ns),
        };
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
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

/// Notes the arrival of the first reading; returns whether it was so long ago that a restart is a fault.
fn greeted(first_ns: &mut Option<u64>, now_ns: u64, arrived: bool) -> bool {
    if arrived {
        first_ns.get_or_insert(now_ns);
    }
    first_ns.is_some_and(|first_ns| now_ns.saturating_sub(first_ns) >= GREETING_NS)
}

impl Task for Field {
    fn name(&self) -> &'static str {
        "field"
    }

    fn period(&self) -> Duration {
        Duration::from_micros(100)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let previous_ns = self.polled_ns.replace(now_ns).unwrap_or(now_ns);
        if now_ns.saturating_sub(previous_ns) > ABSENCE_NS {
            self.judged_from_ns = now_ns + SETTLES_NS;
        }
        let suspended_ns = self.clock.suspended_ns();
        self.signals
            .suspended_ns
            .store(suspended_ns, Ordering::Relaxed);
        self.read_force(now_ns);
        self.read_encoder(now_ns);
        self.read_button(now_ns);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading_queue::reading_queue;
    use impedance::clock_alignment::ClockState;
    use safety::{GpioError, Nonsense};
    use sources::TimedForce;
    use tasks::SystemClock;

    /// Line that fails while the test has it fail.
    struct Failing(Arc<AtomicBool>);

    impl InputLine for Failing {
        fn is_high(&mut self) -> Result<bool, GpioError> {
            if self.0.load(Ordering::Relaxed) {
                let why = "the chip is removed".to_owned();
                return Err(GpioError::Device { why });
            }
            Ok(false)
        }
    }

    /// Line set by the test.
    struct Level(Arc<AtomicBool>);

    impl InputLine for Level {
        fn is_high(&mut self) -> Result<bool, GpioError> {
            Ok(self.0.load(Ordering::Relaxed))
        }
    }

    /// Sensor with a clock and faults set by the test.
    struct Clocked(ClockState, LineFaults);

    impl ForceSource for Clocked {
        fn poll(
            &mut self,
            now_s: &dyn Fn() -> f64,
            take: &mut dyn FnMut(TimedForce),
        ) -> Result<(), SourceGone> {
            take(TimedForce {
                moment: Moment::Host(now_s()),
                normal_n: 0.0,
                lateral_n: 0.0,
                raw_n: [0.0; 2],
                normal_saturated: false,
                lateral_saturated: false,
            });
            Ok(())
        }

        fn health(&self) -> SourceHealth {
            SourceHealth {
                faults: self.1,
                clock: Some(self.0),
                pace: None,
            }
        }

        fn nonsense(&mut self, _now_ns: u64) -> Nonsense {
            Nonsense::default()
        }
    }

    /// Returns the trips and the readings of ten seconds with a sensor that runs fast by `fast_ppm`, arrives off its
    /// clock by `residual_s` and restarts at `restarts_s`.
    fn ten_seconds(
        fast_ppm: f64,
        residual_s: f64,
        restarts_s: u64,
    ) -> (Vec<String>, Vec<FieldReading>) {
        let clock = |fast_ppm: f64, residual_s| ClockState {
            drift_ppm: -fast_ppm,
            span_s: 60.0,
            settled: true,
            residual_s: Some(residual_s),
        };
        let (gauges, safety) = <(Arc<DeviceReadings>, Mailbox<SafetyCommand>)>::default();
        let signals: Arc<Signals> = Arc::default();
        gauges.card_clock.set(clock(-200.0, 0.0));
        let (readings, received) = reading_queue();
        let mut field = Field::new(
            None,
            None,
            None,
            readings,
            Arc::default(),
            Arc::clone(&signals),
            gauges,
            safety.clone(),
            Arc::new(SystemClock::start()),
        );
        for second in 1..=10 {
            let restarted = u64::from(second >= restarts_s);
            let faults = LineFaults {
                restarted,
                ..LineFaults::default()
            };
            if second == 1 || field.force.is_some() {
                field.force = Some(Box::new(Clocked(clock(fast_ppm, residual_s), faults)));
            }
            field.poll(second * 1_000_000_000).unwrap();
        }
        let is_lost = signals.losses.includes(LostDevice::ForceSensor);
        assert_eq!(
            is_lost,
            field.force.is_none(),
            "a sensor that is not read any more is lost"
        );
        let mut trips = Vec::new();
        while let Some(command) = safety.take() {
            let SafetyCommand::Trip(trip) = command else {
                panic!("{command:?}");
            };
            trips.push(trip.to_string());
        }
        (trips, received.try_iter().collect())
    }

    /// Fault 24.
    #[test]
    fn a_clock_beyond_one_percent_of_the_cards_trips_once_by_its_name() {
        let (trips, readings) = ten_seconds(11_000.0, 0.0, 99);
        let [trip] = &trips[..] else {
            panic!("{trips:?}");
        };
        assert!(
            trip.contains("the clock of the force sensor runs 1.1")
                && trip.contains("(+11")
                && trip.contains("over the limit of 1 %")
                && trip.contains("(the card itself: -200 ppm"),
            "{trip}"
        );
        assert_eq!(readings.len(), 1, "nothing is read of it any more");
        assert_eq!(ten_seconds(9_000.0, 0.0, 99).0, Vec::<String>::new());
        assert_eq!(ten_seconds(-9_000.0, 0.0, 99).0, Vec::<String>::new());
    }

    /// Fault 48.
    #[test]
    fn a_restart_trips_by_name_unless_the_sensor_has_only_just_begun() {
        let (trips, readings) = ten_seconds(0.0, 0.0, 8);
        assert_eq!(trips, [SensorRestarted("force sensor").to_string()]);
        let flagged = |reading: &FieldReading| matches!(reading, FieldReading::ForceFaults { .. });
        assert!(readings.iter().any(flagged));
        assert_eq!(ten_seconds(0.0, 0.0, 3).0, Vec::<String>::new());
    }

    /// Fault 24.
    #[test]
    fn readings_that_arrive_where_their_clock_does_not_place_them_are_flagged() {
        let misplaced = |residual_s| {
            let (trips, readings) = ten_seconds(0.0, residual_s, 99);
            assert_eq!(trips, Vec::<String>::new());
            let flags = readings.iter().filter(|reading| {
                matches!(reading, FieldReading::ClockFaults { misplaced: 1, .. })
            });
            flags.count()
        };
        assert_eq!((misplaced(1.9e-3), misplaced(2.1e-3)), (0, 10));
    }

    /// Fault 18.
    #[test]
    fn a_line_that_fails_trips_until_it_can_be_read_again() {
        let (fails, safety) = <(Arc<AtomicBool>, Mailbox<SafetyCommand>)>::default();
        let mut field = Field::new(
            None,
            None,
            Some(Box::new(Failing(fails.clone()))),
            reading_queue().0,
            Arc::default(),
            Arc::default(),
            Arc::default(),
            safety.clone(),
            Arc::new(SystemClock::start()),
        );
        let mut trips_of = |range_ms: std::ops::Range<u64>, is_failing: bool| {
            fails.store(is_failing, Ordering::Relaxed);
            range_ms.for_each(|ms| field.poll(ms * 1_000_000).unwrap());
            let commands = std::iter::from_fn(|| safety.take());
            let is_gpio = |command: &SafetyCommand| matches!(command, SafetyCommand::Trip(Trip::Gpio { message }) if message.contains("removed"));
            commands
                .map(|command| assert!(is_gpio(&command), "{command:?}"))
                .count()
        };
        assert_eq!(trips_of(0..100, false), 0);
        assert_eq!(trips_of(100..350, true), 3);
        assert_eq!(trips_of(350..900, false), 0);
        assert_eq!(trips_of(900..910, true), 1);
    }

    #[test]
    fn a_short_press_stays_counted_with_its_time() {
        let (level, pressed) = <(Arc<AtomicBool>, Arc<AtomicBool>)>::default();
        let gauges: Arc<DeviceReadings> = Arc::default();
        let mut field = Field::new(
            None,
            None,
            Some(Box::new(Level(level.clone()))),
            reading_queue().0,
            pressed.clone(),
            Arc::default(),
            gauges.clone(),
            Mailbox::default(),
            Arc::new(SystemClock::start()),
        );
        let mut button_at = |ms: u64, high: bool| {
            level.store(high, Ordering::Relaxed);
            field.poll(ms * 1_000_000).unwrap();
            let now = gauges.field.get().unwrap();
            (now.button_pressed, now.button_presses, now.button_press_ns)
        };
        assert_eq!(button_at(100, false), (Some(false), 0, None));
        assert_eq!(button_at(110, true), (Some(true), 1, Some(110_000_000)));
        // It bounces.
        assert_eq!(button_at(112, false).1, 1);
        assert_eq!(button_at(113, true).1, 1);
        assert_eq!(button_at(160, false), (Some(false), 1, Some(110_000_000)));
        assert_eq!(button_at(900, false), (Some(false), 1, Some(110_000_000)));
        assert_eq!(button_at(910, true), (Some(true), 2, Some(910_000_000)));
        assert!(pressed.load(Ordering::Acquire));
    }
}
