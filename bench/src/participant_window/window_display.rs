//! The participant's window on a Unix socket: a display that never waits, and the task that does its talking.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender};
use participant_window::message::{Beat, Shown};
use participant_window::place;
use participant_window::seat::{Seat, SeatEvent};
use serde::Serialize;
use serde_json::{Map, Value};
use tasks::{Slot, Task};
use tui::event::LogLevel;

use super::shown::shown;
use crate::displays::ParticipantDisplay;
use crate::journal::Entry;

/// Notices that wait for the operator at most; a window that says more is not heard.
const MOST_NOTICES: usize = 64;

/// What display and task share.
#[derive(Default)]
struct Shared {
    shown: Slot<Shown>,
    beat: Slot<Beat>,
    /// Why no window is there.
    lost: Slot<Option<String>>,
}

/// The participant's window, as a session sees it.
pub struct WindowDisplay {
    shared: Arc<Shared>,
    shown: Option<Shown>,
    show_finger: bool,
    notices: Receiver<(LogLevel, String)>,
    /// Until the task takes it.
    seat: Option<(Seat, Sender<(LogLevel, String)>)>,
}

/// Returns the socket where session and window meet when none is named.
#[must_use]
pub fn default_socket() -> PathBuf {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    place::socket(runtime, &std::env::temp_dir())
}

impl WindowDisplay {
    /// Opens the socket for a window, which may come then or later.
    ///
    /// # Errors
    /// When the socket is another session's, or not in a folder that is this user's alone.
    pub fn open(socket: &Path) -> anyhow::Result<Self> {
        let (said, notices) = crossbeam_channel::bounded(MOST_NOTICES);
        let shared = Arc::<Shared>::default();
        shared.lost.set(Some(
            "there is none yet: `friction-bench participant` opens it".to_owned(),
        ));
        Ok(Self {
            shared,
            shown: None,
            show_finger: false,
            notices,
            seat: Some((Seat::open(socket)?, said)),
        })
    }
}

impl ParticipantDisplay for WindowDisplay {
    fn name(&self) -> String {
        "participant's window".to_owned()
    }

    fn show(&mut self, view: &tui::ParticipantView) {
        self.show_finger = view.show_finger;
        let shown = shown(view, self.shown.as_ref());
        if self.shown.as_ref() != Some(&shown) {
            self.shared.shown.set(shown.clone());
            self.shown = Some(shown);
        }
    }

    fn beat(&mut self, audio_s: f64, position_m: Option<f64>) {
        self.shared.beat.set(Beat {
            audio_s,
            shared_s: place::shared_s(),
            finger_m: position_m.filter(|_| self.show_finger),
        });
    }

    fn lost(&mut self) -> Option<String> {
        self.shared.lost.get().flatten()
    }

    fn notices(&mut self) -> Vec<(LogLevel, String)> {
        self.notices.try_iter().collect()
    }

    fn task(&mut self, journal: &Sender<Entry>) -> Option<Box<dyn Task>> {
        let (seat, said) = self.seat.take()?;
        Some(Box::new(WindowTask {
            seat,
            shared: self.shared.clone(),
            said,
            journal: journal.clone(),
            beat: None,
            is_virtual: false,
        }))
    }
}

/// The task at the socket.
struct WindowTask {
    seat: Seat,
    shared: Arc<Shared>,
    said: Sender<(LogLevel, String)>,
    journal: Sender<Entry>,
    beat: Option<Beat>,
    is_virtual: bool,
}

impl WindowTask {
    fn say(&self, level: LogLevel, text: String) {
        let _dropped_when_nobody_reads = self.said.try_send((level, text));
    }

    fn keep(&self, event: &str, data: &impl Serialize) {
        let mut entry = Map::from_iter([("event".to_owned(), Value::from(event))]);
        if let Ok(Value::Object(data)) = serde_json::to_value(data) {
            entry.extend(data);
        }
        entry.insert("virtual_display".to_owned(), self.is_virtual.into());
        let t_s = self.beat.map_or(0.0, |beat| beat.audio_s);
        // The journal's end is seen by its own task.
        let _ = self.journal.send(Entry::Display { t_s, data: entry });
    }

    fn take(&mut self, event: SeatEvent) {
        match event {
            SeatEvent::Taken(display) => {
                self.is_virtual = display.virtual_display;
                self.shared.lost.set(None);
                self.say(
                    LogLevel::Info,
                    format!("the participant's window is on {}", display.in_words()),
                );
                self.keep("window_opened", &display);
            }
            SeatEvent::Left { why } => self.shared.lost.set(Some(why)),
            SeatEvent::Explored(report) => {
                if report.slider_error_max_m > 3.0 * report.frame_m {
                    self.say(
                        LogLevel::Warning,
                        format!(
                            "the slider on the participant's window was up to {:.1} mm off: {} of {} frames did not come in \
                             time; close other programs",
                            1e3 * report.slider_error_max_m,
                            report.dropped,
                            report.frames.saturating_add(report.dropped)
                        ),
                    );
                }
                self.keep("exploration_shown", &report);
            }
            SeatEvent::Trouble { text } => {
                self.say(
                    LogLevel::Warning,
                    format!("the participant's window: {text}"),
                );
                self.keep(
                    "window_trouble",
                    &Map::from_iter([("text".to_owned(), Value::from(text))]),
                );
            }
        }
    }
}

impl Task for WindowTask {
    fn name(&self) -> &'static str {
        "participant's window"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(4)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        for event in self.seat.look(place::shared_s()) {
            self.take(event);
        }
        if let Some(shown) = self.shared.shown.get() {
            self.seat.show(shown);
        }
        let beat = self.shared.beat.get();
        if beat != self.beat {
            self.beat = beat;
            if let Some(beat) = beat {
                self.seat.beat(beat);
            }
        }
        Ok(())
    }
}
