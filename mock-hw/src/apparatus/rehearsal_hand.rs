//! Rehearsed faults: injected at their times, or immediately from any thread.

use std::sync::{Arc, Mutex, PoisonError};

use faults::{FaultKind, RehearsedFault};
use mock_world::plant::LoadedAxis;

use super::fault_panel::FaultPanel;
use super::mass_set::MassSet;
use crate::host::ConverterDirection;
use crate::serial::ForceFault;

/// Standard gravity, m/s² (ISO 80000-3), for loads given in newtons and placed as masses.
const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Lengths of a bouncing contact's states, alternately closed and open, as fractions of the bounce time: no evenly spaced
/// sampling sees the same state each time.
const BOUNCE: [f64; 9] = [0.11, 0.06, 0.17, 0.04, 0.09, 0.15, 0.05, 0.13, 0.20];

/// A change to the apparatus.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FaultStep {
    /// The fault begins, with its argument.
    Begin(FaultKind, Option<f64>),
    /// The fault ends.
    End(FaultKind),
    /// A contact of the e-stop opens or closes.
    Contact { open: bool },
}

/// Handle that injects faults by name; any thread may hold a clone. Each takes effect with the next period.
#[derive(Debug, Clone, Default)]
pub struct RehearsalHand(Arc<Mutex<Vec<FaultStep>>>);

impl RehearsalHand {
    /// Begins a fault, with `argument` or the table's default.
    pub fn begin(&self, fault: FaultKind, argument: Option<f64>) {
        self.ask(FaultStep::Begin(fault, argument));
    }

    /// Ends a lasting fault; other faults are unaffected.
    pub fn end(&self, fault: FaultKind) {
        self.ask(FaultStep::End(fault));
    }

    fn ask(&self, step: FaultStep) {
        let mut queue = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        queue.push(step);
    }
}

/// Schedule of the injected faults.
pub(super) struct Timetable {
    /// Times from the start of the sound card, s, latest first; equal times in the order of naming.
    schedule: Vec<(f64, FaultStep)>,
    hand: RehearsalHand,
    panel: FaultPanel,
    masses: MassSet,
    /// Simulated time at which the sound card started, ns.
    started_ns: Option<u64>,
}

impl Timetable {
    pub(super) fn new(faults: &[RehearsedFault], panel: FaultPanel, masses: MassSet) -> Self {
        let mut timetable = Self {
            schedule: Vec::new(),
            hand: RehearsalHand::default(),
            panel,
            masses,
            started_ns: None,
        };
        for fault in faults {
            timetable.add(fault.at_s, FaultStep::Begin(fault.fault, fault.argument));
            if let Some(until_s) = fault.until_s {
                timetable.add(until_s, FaultStep::End(fault.fault));
            }
        }
        timetable
    }

    /// Returns the handle that injects faults immediately.
    pub(super) fn hand(&self) -> RehearsalHand {
        self.hand.clone()
    }

    fn add(&mut self, at_s: f64, step: FaultStep) {
        let place = self.schedule.partition_point(|(due_s, _)| *due_s > at_s);
        self.schedule.insert(place, (at_s, step));
    }

    /// Executes the entries due in the period that begins at `now_ns`; time counts from the start of the sound card.
    pub(super) fn carry_out(&mut self, now_ns: u64, runs: bool) {
        if self.started_ns.is_none() && runs {
            self.started_ns = Some(now_ns);
        }
        let now_s = self.started_ns.map_or(f64::NEG_INFINITY, |started_ns| {
            1e-9 * (now_ns - started_ns) as f64
        });
        let queue =
            std::mem::take(&mut *self.hand.0.lock().unwrap_or_else(PoisonError::into_inner));
        for step in queue {
            self.do_now(step, now_s);
        }
        while let Some((_, step)) = self.schedule.pop_if(|(due_s, _)| *due_s <= now_s) {
            self.do_now(step, now_s);
        }
    }

    fn do_now(&mut self, step: FaultStep, now_s: f64) {
        match step {
            FaultStep::Begin(fault, argument) => {
                let amount = RehearsedFault {
                    fault,
                    at_s: 0.0,
                    until_s: None,
                    argument,
                }
                .amount();
                self.begin(fault, amount.unwrap_or_default(), now_s);
            }
            FaultStep::End(fault) => self.end(fault),
            FaultStep::Contact { open } => self.panel.press_estop(open),
        }
    }

    fn begin(&mut self, fault: FaultKind, amount: f64, now_s: f64) {
        let panel = &self.panel;
        // The table's range ensures a whole count.
        let count = amount as u32;
        match fault {
            FaultKind::EstopBounce => self.bounce(1e-3 * amount, now_s.max(0.0)),
            FaultKind::Xrun => panel.xrun(ConverterDirection::Input, count.into()),
            FaultKind::XrunOutput => panel.xrun(ConverterDirection::Output, count.into()),
            FaultKind::Nan => panel.spoil_frames(count.into()),
            FaultKind::CardLostInput => panel.lose_card(ConverterDirection::Input),
            FaultKind::CardLostOutput => panel.lose_card(ConverterDirection::Output),
            FaultKind::ForceUnplugged => panel.unplug_force(),
            FaultKind::ForceDropped => panel.force(ForceFault::Drop(count)),
            FaultKind::ForceCorrupted => panel.force(ForceFault::Corrupt(count)),
            FaultKind::ForceRepeated => panel.force(ForceFault::Repeat(count)),
            FaultKind::AmplifierGain => panel.set_amplifier_gain(0.01 * amount),
            FaultKind::Press => self
                .masses
                .place(LoadedAxis::Normal, amount / GRAVITY_M_PER_S2),
            FaultKind::Drag => self
                .masses
                .place(LoadedAxis::Lateral, amount / GRAVITY_M_PER_S2),
            FaultKind::Estop
            | FaultKind::EstopCut
            | FaultKind::AmplifierOff
            | FaultKind::RelayWelded
            | FaultKind::GpioRemoved
            | FaultKind::InputStops
            | FaultKind::OutputStops
            | FaultKind::ForceSilent
            | FaultKind::ForceOtherDevice
            | FaultKind::ForceSaturated
            | FaultKind::ButtonHeld => self.set(fault, true),
        }
    }

    fn end(&mut self, fault: FaultKind) {
        match fault {
            FaultKind::Press | FaultKind::Drag => self.masses.remove(),
            FaultKind::AmplifierGain => self.panel.set_amplifier_gain(1.0),
            FaultKind::EstopBounce => {
                self.schedule
                    .retain(|(_, step)| !matches!(step, FaultStep::Contact { .. }));
                self.panel.press_estop(false);
            }
            fault => self.set(fault, false),
        }
    }

    /// Begins or ends a fault that is either present or absent; ignores other faults.
    fn set(&self, fault: FaultKind, is_present: bool) {
        let panel = &self.panel;
        match fault {
            FaultKind::Estop => panel.press_estop(is_present),
            FaultKind::EstopCut => panel.cut_estop_wire(is_present),
            FaultKind::AmplifierOff => panel.switch_off_amplifier(is_present),
            FaultKind::RelayWelded => panel.weld_relay(is_present),
            FaultKind::GpioRemoved => panel.remove_gpio(is_present),
            FaultKind::InputStops => panel.halt_audio(ConverterDirection::Input, is_present),
            FaultKind::OutputStops => panel.halt_audio(ConverterDirection::Output, is_present),
            FaultKind::ForceSilent => panel.force(ForceFault::Silent(is_present)),
            FaultKind::ForceOtherDevice => panel.force(ForceFault::OtherDevice(is_present)),
            FaultKind::ForceSaturated => panel.force(ForceFault::Saturated(is_present)),
            FaultKind::ButtonHeld => panel.hold_button(is_present),
            _ => {}
        }
    }

    /// Makes the e-stop contact bounce for `for_s`, and leaves it open.
    fn bounce(&mut self, for_s: f64, now_s: f64) {
        self.panel.press_estop(true);
        let (mut at_s, mut open) = (now_s, true);
        for share in BOUNCE {
            at_s += share * for_s;
            open = !open;
            self.add(at_s, FaultStep::Contact { open });
        }
        self.add(now_s + for_s, FaultStep::Contact { open: true });
    }
}
