//! Detection of offsets, mains hum and foreign tones on drive and pickup while a bench runs. The demodulation rejects them, but
//! they cost range, and point to a faulty cable, ground or supply.

use std::sync::Arc;
use std::time::Duration;

use config::Config;
use crossbeam_channel::{Receiver, Sender, TryRecvError};
use devices::acquisition::RecordingCommand;
use devices::excerpt::Excerpt;
use metrology::disturbance::{Disturbance, Sort, disturbances};
use metrology::spectrum::Spectrum;
use recording::manifest::EventKind;
use tasks::{Slot, Task};

/// Length of an excerpt, s, and resolution of its spectrum, Hz.
const EXCERPT_S: f64 = 0.25;
const RESOLUTION_HZ: f64 = 10.0;
/// Time between two excerpts, ns.
const PERIOD_NS: u64 = 2_500_000_000;
/// Number of detections before a disturbance is reported: a ramp or a stop can resemble one once.
const LEAST_DETECTIONS: u32 = 2;
/// Number of missed detections after which a disturbance is over.
const MOST_MISSES: u32 = 2;

/// The detection task.
pub struct Interference {
    recording: Sender<RecordingCommand>,
    frames: usize,
    input_channels: u16,
    excerpt: Option<Receiver<Vec<f32>>>,
    due_ns: Option<u64>,
    /// Present carrier, if it can change, Hz.
    carrier_hz: Arc<Slot<f64>>,
    watch: DisturbanceWatch,
}

impl Interference {
    /// Creates a task for the channels of `config` at a carrier of `carrier_hz`. The acquisition at the other end of
    /// `recording` delivers the samples and takes the warnings.
    #[must_use]
    pub fn new(recording: Sender<RecordingCommand>, config: &Config, carrier_hz: f64) -> Self {
        let rate_hz = f64::from(config.audio.rate_hz);
        let channels = &config.channels;
        Self {
            recording,
            frames: (EXCERPT_S * rate_hz) as usize,
            input_channels: config.audio.input_channels,
            excerpt: None,
            due_ns: None,
            carrier_hz: Arc::default(),
            watch: DisturbanceWatch {
                inputs: [
                    ("drive", usize::from(channels.drive.index)),
                    ("pickup", usize::from(channels.pickup.index)),
                ],
                stream_channels: usize::from(config.audio.input_channels),
                rate_hz,
                carrier_hz,
                suspects: Vec::new(),
            },
        }
    }

    /// Uses the carrier published in `carrier_hz`.
    #[must_use]
    pub fn following(self, carrier_hz: Arc<Slot<f64>>) -> Self {
        Self { carrier_hz, ..self }
    }

    fn send(&self, command: RecordingCommand) {
        // The channel is closed only when the bench stops.
        let _ = self.recording.send(command);
    }
}

impl Task for Interference {
    fn name(&self) -> &'static str {
        "interference"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(50)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let Some(excerpt) = &self.excerpt else {
            if now_ns >= *self.due_ns.get_or_insert(now_ns) {
                self.due_ns = Some(now_ns + PERIOD_NS);
                let (to, excerpt) = crossbeam_channel::bounded(1);
                self.excerpt = Some(excerpt);
                let next = Excerpt::next(self.frames, self.input_channels, to);
                self.send(RecordingCommand::Excerpt(next));
            }
            return Ok(());
        };
        match excerpt.try_recv() {
            Ok(samples) => {
                self.excerpt = None;
                if let Some(carrier_hz) = self.carrier_hz.get() {
                    self.watch.carrier_hz = carrier_hz;
                }
                for Notice { text, is_new } in self.watch.look(&samples) {
                    let kind = EventKind::Interference;
                    self.send(if is_new {
                        RecordingCommand::Warn(kind, text)
                    } else {
                        RecordingCommand::Event(kind, Some(text))
                    });
                }
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => self.excerpt = None,
        }
        Ok(())
    }
}

/// A present disturbance.
#[derive(Debug, PartialEq, Eq)]
struct Notice {
    text: String,
    /// Whether the disturbance is not yet reported to the operator.
    is_new: bool,
}

/// A disturbance suspected on an input.
struct Suspect {
    input: &'static str,
    disturbance: Disturbance,
    detections: u32,
    misses: u32,
}

/// Separates lasting disturbances from single events.
struct DisturbanceWatch {
    inputs: [(&'static str, usize); 2],
    stream_channels: usize,
    rate_hz: f64,
    carrier_hz: f64,
    suspects: Vec<Suspect>,
}

impl DisturbanceWatch {
    /// Examines interleaved samples; returns the disturbances that were also present in earlier excerpts.
    fn look(&mut self, samples: &[f32]) -> Vec<Notice> {
        let mut notices = Vec::new();
        for (input, channel) in self.inputs {
            let spectrum = Spectrum::read(
                samples,
                self.stream_channels,
                channel,
                self.rate_hz,
                RESOLUTION_HZ,
            );
            // Non-finite samples have a flag of their own.
            let Ok(spectrum) = spectrum else { continue };
            let disturbances = disturbances(&spectrum, self.carrier_hz, self.rate_hz);
            notices.extend(self.take(input, &disturbances));
        }
        notices
    }

    fn take(&mut self, input: &'static str, disturbances: &[Disturbance]) -> Vec<Notice> {
        for suspect in self.suspects.iter_mut().filter(|s| s.input == input) {
            let recurrence = disturbances
                .iter()
                .find(|d| d.is_again(&suspect.disturbance));
            match recurrence {
                Some(recurrence) => {
                    suspect.disturbance = *recurrence;
                    suspect.detections += 1;
                    suspect.misses = 0;
                }
                None => suspect.misses += 1,
            }
        }
        let lasting = self
            .suspects
            .iter()
            .filter(|s| s.input == input && s.detections >= LEAST_DETECTIONS && s.misses == 0);
        let notices = lasting.map(|s| Notice {
            text: format!("{input}: {}{}", s.disturbance, remedy(s.disturbance.sort)),
            is_new: s.detections == LEAST_DETECTIONS,
        });
        let notices = notices.collect();
        self.suspects.retain(|s| s.misses < MOST_MISSES);
        for &disturbance in disturbances {
            let is_known = |s: &Suspect| s.input == input && s.disturbance.is_again(&disturbance);
            if !self.suspects.iter().any(is_known) {
                self.suspects.push(Suspect {
                    input,
                    disturbance,
                    detections: 1,
                    misses: 0,
                });
            }
        }
        notices
    }
}

fn remedy(sort: Sort) -> &'static str {
    match sort {
        Sort::Offset => ": look at the input's coupling and the amplifier's bias",
        Sort::Hum => ": look at grounds and shields",
        Sort::InBand => ": find its source before the next trial",
        Sort::OutOfBand => ": a switching supply or another generator may be near",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn watch() -> DisturbanceWatch {
        DisturbanceWatch {
            inputs: [("drive", 0), ("pickup", 1)],
            stream_channels: 2,
            rate_hz: 192e3,
            carrier_hz: 35e3,
            suspects: Vec::new(),
        }
    }

    /// Returns a quarter of a second of a drive, with a tone on the pickup.
    fn samples(hz: f64, amplitude: f64) -> Vec<f32> {
        (0..48_000)
            .flat_map(|n| {
                let t_s = f64::from(n) / 192e3;
                let carrier = 0.3 * (TAU * 35e3 * t_s).cos();
                [carrier, carrier + amplitude * (TAU * hz * t_s).sin()].map(|x| x as f32)
            })
            .collect()
    }

    /// Fault 12.
    #[test]
    fn what_lasts_is_told_of_once_and_recorded_as_long_as_it_lasts() {
        let mut watch = watch();
        let (clean, hum) = (samples(50.0, 0.0), samples(50.0, 0.03));
        let mut news = |samples: &[f32]| -> Vec<bool> {
            let notices = watch.look(samples);
            let text =
                "pickup: mains hum at 50 Hz, -30 dB of full scale: look at grounds and shields";
            assert!(
                notices.iter().all(|notice| notice.text == text),
                "{notices:?}"
            );
            notices.iter().map(|notice| notice.is_new).collect()
        };
        assert!(news(&clean).is_empty());
        // A single detection may be a ramp.
        assert!(news(&hum).is_empty());
        assert_eq!(news(&hum), [true]);
        assert_eq!(news(&hum), [false]);
        assert!(news(&clean).is_empty());
        assert_eq!(news(&hum), [false]);
        assert_eq!((news(&clean), news(&clean)), (vec![], vec![]));
        assert_eq!((news(&hum), news(&hum)), (vec![], vec![true]));
        // Invalid samples change no count.
        assert!(news(&vec![f32::NAN; 96_000]).is_empty());
        assert!(news(&[]).is_empty());
    }

    #[test]
    fn sources_are_distinguished() {
        let mut watch = watch();
        let words = |watch: &mut DisturbanceWatch, hz| {
            let tone = samples(hz, 0.03);
            watch.look(&tone);
            let notices = watch.look(&tone);
            assert!(
                notices.iter().all(|n| n.is_new) && notices.len() == 1,
                "{notices:?}"
            );
            notices[0].text.clone()
        };
        assert!(words(&mut watch, 34_000.0).contains("biases Z_m"));
        assert!(words(&mut watch, 12_000.0).contains("a foreign tone at 12000 Hz"));
        assert!(words(&mut watch, 12_100.0).contains("12100 Hz"));
    }
}
