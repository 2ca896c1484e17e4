//! Exercise on an opened bench: passes observations to the exercise, and its orders to the bench and the screen.

use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender};
use devices::DeviceReadings;
use devices::drive_control::DriveControl;
use operator_ui::console::{Front, safety_event};
use recording::pipeline::Batch;
use safety::{SafetyState, Signals, Trip};
use signalgen::Program;
use tasks::{StopFlag, Task};
use tui::event::{LogLevel, PhaseKind, PhaseView};
use tui::{Action, Event};

use crate::exercise::{Exercise, Order, Sight};
use crate::page::Page;
use crate::panels::Panels;
use crate::signs::Signs;
use crate::{Deed, FaultHand};

/// Period of screen updates, ns.
const SCREEN_PERIOD_NS: u64 = 16_000_000;

/// State passed from one exercise to the next.
pub(crate) struct ExerciseState {
    /// The operator's front end.
    pub front: Box<dyn Front>,
    /// Page of the drill.
    pub page: Page,
    /// The exercise.
    pub exercise: Exercise,
    /// Whether the operator has left the drill.
    pub has_left: bool,
    /// Time of the latest poll, s.
    pub now_s: f64,
}

impl ExerciseState {
    /// Takes an action of the operator; returns the order to the bench.
    pub fn act(&mut self, action: Action) -> Option<Order> {
        let restarts = self.exercise.current_step() == tui::drill_view::DrillStep::Quit
            || matches!(
                self.exercise.fault().row().remedy,
                faults::Remedy::Restart(_)
            ) && self.exercise.current_step() == tui::drill_view::DrillStep::Acknowledge;
        match action {
            Action::Interrupt => self.has_left = true,
            Action::Quit if !restarts => self.has_left = true,
            _ => return self.exercise.act(action, self.now_s),
        }
        None
    }

    /// Shows the page again if it has changed.
    pub fn show(&mut self) {
        if let Some(view) = self.page.news(&self.exercise) {
            self.front.show(Event::Drill(view));
        }
    }
}

/// Parts of the bench that the task uses.
pub(crate) struct DrillTask {
    pub batches: Receiver<Batch>,
    pub drive: DriveControl,
    pub signals: Arc<Signals>,
    pub gauges: Arc<DeviceReadings>,
    pub stop: StopFlag,
    /// Raised when the screen has ended or a signal requests the end.
    pub quit: StopFlag,
    pub program: Program,
    pub hand: Option<FaultHand>,
    pub panels: Panels,
    pub state: Option<ExerciseState>,
    pub sender: Sender<ExerciseState>,
    pub signs: Signs,
    pub safety: Option<(SafetyState, bool)>,
    pub phase: Option<PhaseKind>,
    pub screen_due_ns: u64,
    pub number: u32,
    pub numbers: u32,
}

impl DrillTask {
    fn obey(&mut self, order: Order, fault: faults::FaultKind) {
        match order {
            Order::Drive => self.drive.start(self.program),
            Order::Pause => self.drive.disarm(),
            Order::Stop => self.drive.trip(Trip::Operator),
            Order::Rearm => self.drive.rearm(),
            Order::Begin => {
                self.signs.begin(fault);
                self.deed(Deed::Begin(fault));
            }
            Order::End => self.deed(Deed::End(fault)),
        }
    }

    fn deed(&mut self, deed: Deed) {
        if let Some(hand) = &mut self.hand {
            hand(deed);
        }
    }

    fn show_bench(
        &mut self,
        state: &mut ExerciseState,
        now_ns: u64,
        safety: &SafetyState,
        sounds: bool,
    ) {
        let bench_state = Some((safety.clone(), sounds));
        let is_due = now_ns >= self.screen_due_ns;
        if self.safety != bench_state || is_due {
            let left = self.signals.dose.get();
            state
                .front
                .show(safety_event(safety, sounds, left.as_ref()));
            let before = std::mem::replace(&mut self.safety, bench_state);
            let is_news = before.is_none_or(|(before, _)| before != *safety);
            if let SafetyState::Tripped { trip } = safety
                && is_news
            {
                state.front.show(Event::Log {
                    level: LogLevel::Error,
                    text: format!("drive stopped: {trip}"),
                });
            }
        }
        let kind = if state.exercise.is_paused() {
            PhaseKind::Paused
        } else {
            PhaseKind::Monitoring
        };
        if self.phase.replace(kind) != Some(kind) {
            state.front.show(Event::Phase(PhaseView {
                trial: self.number,
                trials: self.numbers,
                stopped: state.exercise.is_rearmed(),
                ..PhaseView::new(kind)
            }));
        }
        if is_due {
            self.screen_due_ns = now_ns + SCREEN_PERIOD_NS;
            for event in self.panels.events(now_ns, &self.gauges) {
                state.front.show(event);
            }
        }
    }
}

impl Task for DrillTask {
    fn name(&self) -> &'static str {
        "drill"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let Some(mut state) = self.state.take() else {
            return Ok(());
        };
        state.now_s = now_ns as f64 * 1e-9;
        let safety = self.signals.state.get().unwrap_or_default();
        self.drive.poll(&safety);
        let batches: Vec<Batch> = self.batches.try_iter().collect();
        for batch in batches {
            self.signs.take(&batch, &self.gauges);
            self.panels.take(&batch);
            for text in batch.warnings {
                state.front.show(Event::Log {
                    level: LogLevel::Warning,
                    text,
                });
            }
        }
        let sounds = self.drive.sounds();
        let flag = self.signs.flag();
        let fault = state.exercise.fault();
        let order = state.exercise.poll(Sight {
            now_s: state.now_s,
            safety: &safety,
            sounds,
            flag: flag.as_deref(),
        });
        if let Some(order) = order {
            self.obey(order, fault);
        }
        self.show_bench(&mut state, now_ns, &safety, sounds);
        state.show();
        while let Some(action) = state.front.action() {
            if let Some(order) = state.act(action) {
                self.obey(order, fault);
            }
        }
        let is_done =
            state.exercise.outcome().is_some() || state.has_left || state.front.is_unread();
        if is_done || self.quit.is_raised() {
            self.stop.raise();
        }
        self.state = Some(state);
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        if let Some(state) = self.state.take() {
            let _ = self.sender.send(state);
        }
        Ok(())
    }
}
