//! Who watches the bench: the operator's dashboard, or lines of text. Both are fed by one stream of events.

use std::io::Write;
use std::sync::mpsc::{Receiver, Sender, SyncSender};

use anyhow::Context;
use tui::event::{LogLevel, PhaseKind};
use tui::{Action, Event};

use crate::schedule::{RaiseOnDrop, StopFlag};

/// Takes events and gives the operator's wishes; neither ever waits.
pub trait Front: Send {
    /// Shows an event, or drops it when the screen stands still.
    fn show(&mut self, event: Event);
    /// The operator's next wish.
    fn action(&mut self) -> Option<Action>;

    /// Nobody reads any more what is shown.
    fn is_unread(&self) -> bool {
        false
    }
}

/// Events waiting for a screen that stands still; beyond this they are dropped.
const WAITING_EVENTS: usize = 4096;

/// The operator's dashboard, on a thread of its own.
pub struct Dashboard {
    events: SyncSender<Event>,
    actions: Receiver<Action>,
}

/// The dashboard's thread; joining it waits until the terminal is put back.
pub struct DashboardThread(std::thread::JoinHandle<Result<(), tui::shell::ShellError>>);

impl Dashboard {
    /// Opens the dashboard on this process's terminal. When it ends, for whatever reason, the bench stops in good order.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn open(stop: StopFlag) -> anyhow::Result<(Self, DashboardThread)> {
        let (events, shown) = std::sync::mpsc::sync_channel(WAITING_EVENTS);
        let (asked, actions): (Sender<Action>, _) = std::sync::mpsc::channel();
        let thread = std::thread::Builder::new()
            .name("dashboard".to_owned())
            .spawn(move || {
                let _raise_on_unwind = RaiseOnDrop(stop);
                tui::shell::run_operator(&shown, &asked)
            })
            .context("cannot start the dashboard's thread")?;
        Ok((Self { events, actions }, DashboardThread(thread)))
    }
}

impl DashboardThread {
    /// Waits for the terminal.
    ///
    /// # Errors
    /// What the terminal failed with.
    pub fn join(self) -> anyhow::Result<()> {
        match self.0.join() {
            Ok(outcome) => outcome.context("the dashboard"),
            Err(_) => anyhow::bail!("the dashboard panicked"),
        }
    }
}

impl Front for Dashboard {
    fn show(&mut self, event: Event) {
        let _dropped_when_the_screen_stands_still = self.events.try_send(event);
    }

    fn action(&mut self) -> Option<Action> {
        self.actions.try_recv().ok()
    }
}

/// Progress as lines of text, for scripts and logs. The protocol's own rules decide; nobody is asked.
pub struct Headless<W> {
    out: W,
    unread: bool,
    phase: Option<(PhaseKind, u32, u32)>,
    tripped: Option<String>,
}

impl<W: Write> Headless<W> {
    /// Prints to `out`.
    pub fn new(out: W) -> Self {
        Self {
            out,
            unread: false,
            phase: None,
            tripped: None,
        }
    }

    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        // A reader who went away does not end a session; whoever runs for its lines alone looks at `unread`.
        self.unread |= writeln!(self.out, "{text}").is_err();
    }
}

impl<W: Write + Send> Front for Headless<W> {
    fn show(&mut self, event: Event) {
        match event {
            Event::Phase(phase) => {
                let now = (phase.kind, phase.trial, phase.attempt);
                let sort = if phase.practice { "practice" } else { "trial" };
                if phase.kind == PhaseKind::Baseline && phase.trial > 0 && self.phase != Some(now) {
                    let again = if phase.attempt > 1 {
                        format!(", attempt {}", phase.attempt)
                    } else {
                        String::new()
                    };
                    self.line(format_args!(
                        "{sort} {} of {}{again}",
                        phase.trial, phase.trials
                    ));
                }
                self.phase = Some(now);
            }
            Event::Verdict(verdict) => {
                let force = verdict
                    .mean_normal_n
                    .map(|n| format!(", mean force {n:.2} N"))
                    .unwrap_or_default();
                if verdict.accepted {
                    self.line(format_args!(
                        "  accepted: {} instances{force}",
                        verdict.instances
                    ));
                } else {
                    self.line(format_args!(
                        "  again: {}{force}",
                        verdict.reasons.join("; ")
                    ));
                }
            }
            Event::Safety {
                state: tui::event::SafetyState::Tripped,
                reason,
            } if self.tripped != reason => {
                self.tripped = reason;
                let why = self.tripped.clone().unwrap_or_default();
                self.line(format_args!("  STOPPED: {why}"));
            }
            Event::Log { level, text } => match level {
                LogLevel::Info => self.line(format_args!("  {text}")),
                LogLevel::Warning => self.line(format_args!("  warning: {text}")),
                LogLevel::Error => self.line(format_args!("  error: {text}")),
            },
            _ => {}
        }
    }

    fn action(&mut self) -> Option<Action> {
        None
    }

    fn is_unread(&self) -> bool {
        self.unread
    }
}
