//! Messages between session and window: one JSON document per line.

use serde::{Deserialize, Serialize};

use crate::motion::Motion;

/// Version of these messages.
pub const FORMAT: u32 = 1;

/// A message of the session to the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToWindow {
    /// The session accepts the window.
    Welcome {
        /// Version of the messages.
        format: u32,
    },
    /// The session rejects the window.
    Refused {
        /// The reason.
        why: String,
    },
    /// Contents of the window from now on.
    Show(Box<Content>),
    /// The bench's clock and the finger's position, many times a second.
    Beat(Beat),
    /// The session is over.
    Bye,
}

/// A message of the window to the session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FromWindow {
    /// The window is ready.
    Ready(Display),
    /// Sign of life, sent regularly.
    Alive,
    /// Report on the frames of an exploration.
    Explored(FrameReport),
    /// A warning for the operator.
    Trouble {
        /// The text.
        text: String,
    },
    /// Whether the participant can follow the window.
    Unfit {
        /// The reason why not; `None` when they can again.
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
    /// Refresh period of the monitor, s.
    pub refresh_s: f64,
    /// Whether the display is virtual: the picture goes to memory, and frame times say nothing about a monitor.
    pub virtual_display: bool,
}

impl Display {
    /// Describes the display for the operator.
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

/// The bench's clock and the finger's position at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beat {
    /// Time on the bench's clock, s.
    pub audio_s: f64,
    /// The same moment, or a little later, on the clock shared by all processes of this computer, s.
    pub shared_s: f64,
    /// Position of the finger along the plate, m; `None` if the participant is not to see it.
    pub finger_m: Option<f64>,
}

/// Contents of the window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Content {
    /// The instruction.
    pub title: String,
    /// The instruction that follows it.
    pub then: Option<String>,
    /// Whether the following instruction applies now.
    pub now: bool,
    /// Number of the trial and of all trials, in words.
    pub progress: Option<String>,
    /// End of the countdown on the bench's clock, s.
    pub until_s: Option<f64>,
    /// The mean force of an exploration.
    pub feedback: Option<Feedback>,
    /// The plate with its marks and the slider.
    pub track: Option<Track>,
    /// Text shown instead when the session falls silent.
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
    /// The slider's motion.
    pub motion: Motion,
    /// Words at the marks of start and end.
    pub marks: (String, String),
    /// Whether the finger is to be placed at the start.
    pub place: bool,
}

/// Report on the frames of an exploration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameReport {
    /// Time on the bench's clock at which the slider left its start, s.
    pub start_s: f64,
    /// Number of frames during the motion.
    pub frames: u32,
    /// Median time between two frames, s.
    pub interval_p50_s: f64,
    /// 99th percentile of the times between two frames, s.
    pub interval_p99_s: f64,
    /// Longest time between two frames, s.
    pub interval_max_s: f64,
    /// Monitor refreshes without a new frame.
    pub dropped: u32,
    /// Median over the frames of the largest distance between the drawn and the ideal position of the slider during the
    /// frame, m.
    pub slider_error_p50_m: f64,
    /// Maximum of these distances, m.
    pub slider_error_max_m: f64,
    /// Distance that the slider moves during one refresh of the monitor, m.
    pub frame_m: f64,
}
