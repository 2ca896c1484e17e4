//! What session and window say to each other: one JSON document a line.

use serde::{Deserialize, Serialize};

use crate::motion::Motion;

/// Version of these messages.
pub const FORMAT: u32 = 1;

/// A message of the session to the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToWindow {
    /// The window is taken as this session's.
    Welcome {
        /// Version of the messages.
        format: u32,
    },
    /// The window is not wanted.
    Refused {
        /// Why.
        why: String,
    },
    /// What is to be seen from now on.
    Show(Box<Shown>),
    /// The bench's clock and the finger, many times a second.
    Beat(Beat),
    /// The session is over.
    Bye,
}

/// A message of the window to the session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FromWindow {
    /// The window, which is ready.
    Ready(Display),
    /// The window is alive, whether there is anything to say or not.
    Alive,
    /// How an exploration was shown.
    Explored(FrameReport),
    /// What the operator should know.
    Trouble {
        /// In words.
        text: String,
    },
    /// Whether the participant can follow it.
    Unfit {
        /// Why not, in words; `None` when they can again.
        why: Option<String>,
    },
}

/// The monitor that the window is on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// Version of the messages.
    pub format: u32,
    /// Name of the monitor.
    pub monitor: String,
    /// Width, pixels.
    pub width_px: u32,
    /// Height, pixels.
    pub height_px: u32,
    /// Width of a pixel, m, as matched on the ruler page.
    pub pixel_m: f64,
    /// Time between two pictures of the monitor, s.
    pub refresh_s: f64,
    /// Whether nobody can see it: the picture goes to memory, and its times say nothing of a monitor's.
    pub virtual_display: bool,
}

impl Display {
    /// Returns the display in words, for the operator.
    #[must_use]
    pub fn in_words(&self) -> String {
        let kind = if self.virtual_display {
            "virtual display"
        } else {
            "monitor"
        };
        format!(
            "{kind} {}, {} × {} at {:.0} Hz, {:.4} mm a pixel",
            self.monitor,
            self.width_px,
            self.height_px,
            1.0 / self.refresh_s,
            1e3 * self.pixel_m
        )
    }
}

/// The bench's clock at a moment, and the finger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beat {
    /// Time on the bench's clock, s.
    pub audio_s: f64,
    /// The same moment, or a little later, on the clock that all processes of this computer share, s.
    pub shared_s: f64,
    /// Where the finger is along the plate, m; `None` if the participant is not to see it.
    pub finger_m: Option<f64>,
}

/// What is to be seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// The instruction.
    pub title: String,
    /// What comes after it.
    pub then: Option<String>,
    /// Whether it is time for that.
    pub now: bool,
    /// Which trial of how many.
    pub progress: Option<String>,
    /// Time on the bench's clock that is counted down to, s.
    pub until_s: Option<f64>,
    /// The mean force of an exploration.
    pub feedback: Option<Feedback>,
    /// The plate with its marks and the slider.
    pub track: Option<Track>,
    /// What is shown instead when the session falls silent.
    pub silent: String,
}

/// The mean force of an exploration, against the band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// Force and judgement in words.
    pub words: String,
    /// The force, N; `None` if it is not known.
    pub mean_n: Option<f64>,
    /// The band, N.
    pub band_n: Option<(f64, f64)>,
    /// The band's ends in words.
    pub ends: (String, String),
}

/// The plate, with its marks and the slider.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Length of the plate, m.
    pub plate_m: f64,
    /// The slider's way.
    pub motion: Motion,
    /// Words at the marks of start and end.
    pub marks: (String, String),
    /// Whether the finger is to be placed at the start.
    pub place: bool,
}

/// How an exploration was shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameReport {
    /// Time on the bench's clock at which the slider left its start, s.
    pub start_s: f64,
    /// Number of frames while it moved.
    pub frames: u32,
    /// Median time between two frames, s.
    pub interval_p50_s: f64,
    /// 99th percentile of the times between two frames, s.
    pub interval_p99_s: f64,
    /// Longest time between two frames, s.
    pub interval_max_s: f64,
    /// Pictures of the monitor that showed no new frame.
    pub dropped: u32,
    /// Median over the frames of the greatest distance between the slider on the screen and where it ought to have been at
    /// any moment of the frame, m.
    pub slider_error_p50_m: f64,
    /// The greatest of these, m.
    pub slider_error_max_m: f64,
    /// The slider's way during one picture of the monitor, m.
    pub frame_m: f64,
}
