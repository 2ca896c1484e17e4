//! Exercise on an opened bench: passes observations to the exercise, and its orders to the bench and the screen.

use std::sync::Arc;
use std::time::Duration;

use console::{Front, safety_event};
use crossbeam_channel::{Receiver, Sender};
use devices::Gauges;
use devices::drive_control::DriveControl;
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
pub(crate) struct Company {
    /// The operator's front end.
    pub front: Box<dyn Front>,
    /// Page of the drill.
    pub page: Page,
    /// The exercise.
    pub exercise: Exercise,
    /// Whether the operator has left the drill.
    pub left: bool,
    /// Time of the latest poll, s.
    pub now_s: f64,
}

impl Company {
    /// Takes an action of the operator; returns the order to the bench.
    pub fn act(&mut self, action: Action) -> Option<Order> {
        let restarts = self.exercise.asked() == tui::drill_view::DrillStep::Quit
            || matches!(
                self.exercise.fault().row().remedy,
                rehearsal::Remedy::Restart(_)
            ) && self.exercise.asked() == tui::drill_view::DrillStep::Acknowledge;
        match action {
            Action::Interrupt => self.left = true,
            Action::Quit if !restarts => self.left = true,
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
    pub gauges: Arc<Gauges>,
    pub stop: StopFlag,
    /// Raised when the screen has ended or a signal requests the end.
    pub over: StopFlag,
    pub program: Program,
    pub hand: Option<FaultHand>,
    pub panels: Panels,
    pub company: Option<Company>,
    pub back: Sender<Company>,
    pub signs: Signs,
    pub safety: Option<(SafetyState, bool)>,
    pub phase: Option<PhaseKind>,
    pub screen_due_ns: u64,
    pub number: u32,
    pub numbers: u32,
}

impl DrillTask {
    fn obey(&mut self, order: Order, fault: rehearsal::FaultKind) {
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
        company: &mut Company,
        now_ns: u64,
        safety: &SafetyState,
        sounds: bool,
    ) {
        let seen = Some((safety.clone(), sounds));
        let due = now_ns >= self.screen_due_ns;
        if self.safety != seen || due {
            let left = self.signals.dose.get();
            company
                .front
                .show(safety_event(safety, sounds, left.as_ref()));
            self.safety = seen;
        }
        let kind = if company.exercise.is_paused() {
            PhaseKind::Paused
        } else {
            PhaseKind::Monitoring
        };
        if self.phase.replace(kind) != Some(kind) {
            company.front.show(Event::Phase(PhaseView {
                trial: self.number,
                trials: self.numbers,
                ..PhaseView::new(kind)
            }));
        }
        if due {
            self.screen_due_ns = now_ns + SCREEN_PERIOD_NS;
            for event in self.panels.events(now_ns, &self.gauges) {
                company.front.show(event);
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
        let Some(mut company) = self.company.take() else {
            return Ok(());
        };
        company.now_s = now_ns as f64 * 1e-9;
        let safety = self.signals.state.get().unwrap_or_default();
        self.drive.poll(&safety);
        let batches: Vec<Batch> = self.batches.try_iter().collect();
        for batch in batches {
            self.signs.take(&batch, &self.gauges);
            self.panels.take(&batch);
            for text in batch.warnings {
                company.front.show(Event::Log {
                    level: LogLevel::Warning,
                    text,
                });
            }
        }
        let sounds = self.drive.sounds();
        let flag = self.signs.flag();
        let fault = company.exercise.fault();
        let order = company.exercise.poll(Sight {
            now_s: company.now_s,
            safety: &safety,
            sounds,
            flag: flag.as_deref(),
        });
        if let Some(order) = order {
            self.obey(order, fault);
        }
        self.show_bench(&mut company, now_ns, &safety, sounds);
        company.show();
        while let Some(action) = company.front.action() {
            if let Some(order) = company.act(action) {
                self.obey(order, fault);
            }
        }
        let done =
            company.exercise.outcome().is_some() || company.left || company.front.is_unread();
        if done || self.over.is_raised() {
            self.stop.raise();
        }
        self.company = Some(company);
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        if let Some(company) = self.company.take() {
            let _ = self.back.send(company);
        }
        Ok(())
    }
}
