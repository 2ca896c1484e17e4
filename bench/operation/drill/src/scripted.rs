//! Script in place of the operator: prints events, and responds to each request after a delay.

use std::io::Write;

use operator_ui::console::{Front, Headless};
use tui::action::AttemptName;
use tui::drill_view::{DrillStep, DrillView};
use tui::{Action, Event};

/// Polls between a request and the response.
const REACTION: u32 = 100;
/// Polls after which the response is repeated.
const AGAIN: u32 = 5_000;

/// Scripted operator that responds to each request.
pub struct Scripted<W> {
    lines: Headless<W>,
    view: DrillView,
    /// Polls since the request.
    polls: u32,
    is_finished: bool,
}

impl<W: Write> Scripted<W> {
    /// Creates a scripted operator that prints to `out`.
    pub fn new(out: W) -> Self {
        Self {
            lines: Headless::new(out),
            view: DrillView::default(),
            polls: 0,
            is_finished: false,
        }
    }
}

impl<W: Write + Send> Front for Scripted<W> {
    fn show(&mut self, event: Event) {
        match event {
            Event::Drill(view) => {
                if view.asked != self.view.asked || view.exercise != self.view.exercise {
                    self.polls = 0;
                }
                self.view = view;
            }
            Event::Finished { .. } => self.is_finished = true,
            event => self.lines.show(event),
        }
    }

    fn action(&mut self) -> Option<Action> {
        if self.is_finished {
            return Some(Action::Quit);
        }
        self.polls += 1;
        if self.polls == REACTION + AGAIN {
            self.polls = 0;
        }
        if self.polls != REACTION {
            return None;
        }
        match self.view.asked {
            DrillStep::Watch | DrillStep::Act => None,
            DrillStep::Acknowledge => Some(Action::Ready),
            DrillStep::Rearm => Some(Action::Rearm),
            DrillStep::Resume => Some(Action::Resume),
            DrillStep::Repeat => Some(Action::Redo(AttemptName::default())),
            DrillStep::Quit => Some(Action::Quit),
        }
    }

    fn is_unread(&self) -> bool {
        self.lines.is_unread()
    }
}
