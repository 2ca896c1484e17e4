//! Frequency over time: sweeps and stepped tones with continuous phase.

use thiserror::Error;

/// Law of a sweep's frequency over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweepLaw {
    /// Equal hertz per second.
    Linear,
    /// Equal octaves per second.
    Logarithmic,
}

/// Largest number of tones in a program. They travel to the audio callback by value, because a list on the heap would be freed
/// there.
pub const MAX_TONES: usize = 128;

/// A list with no tones, or with more than [`MAX_TONES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{count} tones: a stepped program has 1 to {MAX_TONES}")]
pub struct ToneCountError {
    /// Number of tones in the list.
    pub count: usize,
}

/// Frequencies of a stepped-tone program, 1 to [`MAX_TONES`].
///
/// ```
/// use signalgen::{ToneCountError, ToneList};
///
/// let tones = ToneList::new(&[34_900.0, 35_000.0, 35_100.0])?;
/// assert_eq!(tones.first_hz(), 34_900.0);
/// assert_eq!(ToneList::new(&[]), Err(ToneCountError { count: 0 }));
/// # Ok::<(), ToneCountError>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct ToneList {
    frequencies_hz: [f64; MAX_TONES],
    count: usize,
}

impl ToneList {
    /// Creates a list of tones, Hz, in playing order.
    ///
    /// # Errors
    /// If the list is empty or longer than [`MAX_TONES`].
    pub fn new(frequencies_hz: &[f64]) -> Result<Self, ToneCountError> {
        let count = frequencies_hz.len();
        let mut tones = [0.0; MAX_TONES];
        match tones.get_mut(..count) {
            Some(list) if count > 0 => list.copy_from_slice(frequencies_hz),
            _ => return Err(ToneCountError { count }),
        }
        Ok(Self {
            frequencies_hz: tones,
            count,
        })
    }

    /// Returns the frequencies, Hz.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.frequencies_hz[..self.count]
    }

    /// Returns the frequency of the first tone, Hz.
    #[must_use]
    pub fn first_hz(&self) -> f64 {
        self.frequencies_hz[0]
    }

    fn last_hz(&self) -> f64 {
        self.frequencies_hz[self.count - 1]
    }
}

impl std::fmt::Debug for ToneList {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.as_slice()).finish()
    }
}

/// Motion of the carrier's frequency in the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CarrierMotion {
    /// Holds the frequency.
    Hold,
    /// Changes to this frequency, Hz, and stays there.
    Jump(f64),
    /// Glides through a frame of this mean frequency, Hz.
    Glide(f64),
    /// Ends the program, at this frequency, Hz.
    Over(f64),
}

/// Frequency plan of a program at full amplitude, advanced frame by frame.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a boxed tone list would be freed in the audio callback"
)]
pub(crate) enum Timeline {
    /// One frequency throughout the program.
    Constant,
    /// A sweep.
    Sweep(Glide),
    /// Tones in sequence.
    Steps(Steps),
}

impl Timeline {
    #[inline]
    pub(crate) fn advance(&mut self) -> CarrierMotion {
        match self {
            Self::Constant => CarrierMotion::Hold,
            Self::Sweep(glide) => glide.advance(),
            Self::Steps(steps) => steps.advance(),
        }
    }

    #[inline]
    pub(crate) fn step_index(&self) -> Option<u16> {
        match self {
            Self::Steps(steps) => steps.tone_index,
            Self::Constant | Self::Sweep(_) => None,
        }
    }
}

/// A sweep; frame `n` begins at the law's frequency at time n/rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glide {
    course: Course,
    to_hz: f64,
    frames: u64,
    elapsed_frames: u64,
}

/// Law of a sweep as the mean frequency over frame `n`, so that the phase follows the law's integral, not a staircase.
#[derive(Clone, Copy, Debug)]
enum Course {
    /// `first_mean_hz + n · hz_per_frame`.
    Linear {
        first_mean_hz: f64,
        hz_per_frame: f64,
    },
    /// `first_mean_hz · exp(n · log_per_frame)`.
    Logarithmic {
        first_mean_hz: f64,
        log_per_frame: f64,
    },
}

impl Glide {
    pub(crate) fn new(from_hz: f64, to_hz: f64, law: SweepLaw, frames: u64) -> Self {
        let frames = frames.max(1);
        let course = match law {
            SweepLaw::Linear => {
                let hz_per_frame = (to_hz - from_hz) / frames as f64;
                Course::Linear {
                    first_mean_hz: from_hz + 0.5 * hz_per_frame,
                    hz_per_frame,
                }
            }
            SweepLaw::Logarithmic => {
                let log_per_frame = (to_hz / from_hz).ln() / frames as f64;
                let mean_of_first = if log_per_frame == 0.0 {
                    1.0
                } else {
                    log_per_frame.exp_m1() / log_per_frame
                };
                Course::Logarithmic {
                    first_mean_hz: from_hz * mean_of_first,
                    log_per_frame,
                }
            }
        };
        Self {
            course,
            to_hz,
            frames,
            elapsed_frames: 0,
        }
    }

    fn advance(&mut self) -> CarrierMotion {
        if self.elapsed_frames == self.frames {
            return CarrierMotion::Over(self.to_hz);
        }
        let n = self.elapsed_frames as f64;
        self.elapsed_frames += 1;
        CarrierMotion::Glide(match self.course {
            Course::Linear {
                first_mean_hz,
                hz_per_frame,
            } => first_mean_hz + n * hz_per_frame,
            Course::Logarithmic {
                first_mean_hz,
                log_per_frame,
            } => first_mean_hz * (n * log_per_frame).exp(),
        })
    }
}

/// Tones in sequence, each for `dwell_frames` frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    tones: ToneList,
    dwell_frames: u64,
    left_frames: u64,
    tone_index: Option<u16>,
    next: usize,
}

impl Steps {
    pub(crate) fn new(tones: ToneList, dwell_frames: u64) -> Self {
        Self {
            tones,
            dwell_frames: dwell_frames.max(1),
            left_frames: 0,
            tone_index: None,
            next: 0,
        }
    }

    fn advance(&mut self) -> CarrierMotion {
        if self.left_frames > 0 {
            self.left_frames -= 1;
            return CarrierMotion::Hold;
        }
        match self.tones.as_slice().get(self.next) {
            Some(&frequency_hz) => {
                self.tone_index = u16::try_from(self.next).ok();
                self.next += 1;
                self.left_frames = self.dwell_frames - 1;
                CarrierMotion::Jump(frequency_hz)
            }
            None => {
                self.tone_index = None;
                CarrierMotion::Over(self.tones.last_hz())
            }
        }
    }
}
