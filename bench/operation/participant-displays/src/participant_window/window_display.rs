//! The participant's window on a Unix socket: a display that never blocks, and the task that communicates with the
//! window.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender};
use live::window_screen::page_content;
use participant_window::message::{Beat, Content};
use participant_window::place;
pub use participant_window::place::default_socket;
use participant_window::seat::{Seat, SeatEvent};
use protocols::Texts;
use serde::Serialize;
use serde_json::{Map, Value};
use tasks::{Slot, Task};
use tui::event::LogLevel;

use crate::ParticipantDisplay;
use journal::{Entry, EntrySender};

/// Maximum number of queued notices for the operator; further ones are dropped.
const MOST_NOTICES: usize = 64;
/// Time within which an open window connects to a new session.
const AT_ONCE: Duration = Duration::from_millis(1200);

/// State shared by display and task.
#[derive(Default)]
struct Shared {
    content: Slot<Content>,
    beat: Slot<Beat>,
    /// Reason that no window is connected.
    loss: Slot<Option<String>>,
}

/// The participant's window, as a session sees it.
pub struct WindowDisplay {
    shared: Arc<Shared>,
    last_content: Option<Content>,
    show_finger: bool,
    notices: Receiver<(LogLevel, String)>,
    /// State of the task until the task takes it.
    task: Option<PendingTask>,
}

/// State handed over to the task.
struct PendingTask {
    seat: Seat,
    tx: Sender<(LogLevel, String)>,
    events: Vec<SeatEvent>,
}

impl WindowDisplay {
    /// Opens the socket and waits for a window, which shows in these texts that there is nothing to do yet. Calls
    /// `announce` with the socket if no window connects at once.
    ///
    /// # Errors
    /// When the socket is another session's or its folder is not private to this user, or when no window connects.
    pub fn open(
        socket: &Path,
        texts: &Texts,
        patience: Duration,
        announce: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<Self> {
        let (tx, notices) = crossbeam_channel::bounded(MOST_NOTICES);
        let mut seat = Seat::open(socket)?;
        seat.show(Content {
            title: texts.wait.to_string(),
            silent: texts.paused.to_string(),
            ..Content::default()
        });
        let events = await_window(&mut seat, AT_ONCE).or_else(|| {
            announce(socket).ok()?;
            await_window(&mut seat, patience)
        });
        let Some(events) = events else {
            anyhow::bail!(
                "no participant's window connected to {} within {} s: start `friction-bench participant` in another \
                 terminal first, with the same --socket if one is given here, and leave its ruler page",
                socket.display(),
                patience.as_secs()
            );
        };
        Ok(Self {
            shared: Arc::default(),
            last_content: None,
            show_finger: false,
            notices,
            task: Some(PendingTask { seat, tx, events }),
        })
    }
}

/// Waits for a window; returns its events.
fn await_window(seat: &mut Seat, patience: Duration) -> Option<Vec<SeatEvent>> {
    let start = Instant::now();
    while start.elapsed() < patience {
        let events = seat.look(place::shared_s());
        if events
            .iter()
            .any(|event| matches!(event, SeatEvent::Arrival(_)))
        {
            return Some(events);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    None
}

impl ParticipantDisplay for WindowDisplay {
    fn name(&self) -> String {
        "participant's window".to_owned()
    }

    fn show(&mut self, view: &tui::ScreenView) {
        self.show_finger = view.show_finger;
        let content = page_content(view, self.last_content.as_ref());
        if self.last_content.as_ref() != Some(&content) {
            self.shared.content.set(content.clone());
            self.last_content = Some(content);
        }
    }

    fn beat(&mut self, audio_s: f64, position_m: Option<f64>) {
        self.shared.beat.set(Beat {
            audio_s,
            shared_s: place::shared_s(),
            finger_m: position_m.filter(|_| self.show_finger),
        });
    }

    fn loss(&mut self) -> Option<String> {
        self.shared.loss.get().flatten()
    }

    fn notices(&mut self) -> Vec<(LogLevel, String)> {
        self.notices.try_iter().collect()
    }

    fn task(&mut self, journal: &EntrySender) -> Option<Box<dyn Task>> {
        let PendingTask { seat, tx, events } = self.task.take()?;
        let mut task = WindowTask {
            seat,
            shared: self.shared.clone(),
            tx,
            journal: journal.clone(),
            beat: None,
            is_virtual: false,
        };
        events.into_iter().for_each(|event| task.take(event));
        Some(Box::new(task))
    }
}

/// Task at the socket.
struct WindowTask {
    seat: Seat,
    shared: Arc<Shared>,
    tx: Sender<(LogLevel, String)>,
    journal: EntrySender,
    beat: Option<Beat>,
    is_virtual: bool,
}

impl WindowTask {
    fn say(&self, level: LogLevel, text: String) {
        let _dropped_when_nobody_reads = self.tx.try_send((level, text));
    }

    fn keep(&self, event: &str, data: &impl Serialize) {
        let mut entry = Map::from_iter([("event".to_owned(), Value::from(event))]);
        if let Ok(Value::Object(data)) = serde_json::to_value(data) {
            entry.extend(data);
        }
        entry.insert("virtual_display".to_owned(), self.is_virtual.into());
        let t_s = self.beat.map_or(0.0, |beat| beat.audio_s);
        self.journal.send(Entry::Display { t_s, data: entry });
    }

    fn take(&mut self, event: SeatEvent) {
        match event {
            SeatEvent::Arrival(display) => {
                self.is_virtual = display.virtual_display;
                self.shared.loss.set(None);
                self.say(
                    LogLevel::Info,
                    format!("the participant's window is on {}", display.in_words()),
                );
                self.keep("window_opened", &display);
            }
            SeatEvent::Departure { reason } => self.shared.loss.set(Some(reason)),
            SeatEvent::Unfit { reason } => {
                self.keep(
                    "window_unfit",
                    &Map::from_iter([("why".to_owned(), reason.clone().into())]),
                );
                self.shared.loss.set(reason);
            }
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
        if let Some(content) = self.shared.content.get() {
            self.seat.show(content);
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
