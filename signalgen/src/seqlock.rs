//! Sequence lock: the output callback publishes the drive's state, and any thread reads it consistently.

use std::sync::{
    Arc,
    atomic::{AtomicU32, AtomicU64, Ordering, fence},
};

use crate::{
    generator::{DrivePhase, DriveState, StepState},
    limiter::TripCause,
};

/// Published state, field by field in atomics: the writer never waits, and a reader that meets a write retries.
#[derive(Debug, Default)]
struct Slot {
    /// Number of half-writes: odd while a write is under way.
    sequence: AtomicU64,
    frames: AtomicU64,
    phase: AtomicU32,
    envelope_v: AtomicU64,
    carrier_hz: AtomicU64,
    /// Index of the step plus one; 0 without a step.
    step: AtomicU32,
    step_first_frame: AtomicU64,
    programs: AtomicU32,
    refusals: AtomicU32,
}

/// The single writing side.
#[derive(Debug)]
pub(crate) struct StatePublisher(Arc<Slot>);

/// A reading side; clones read the same state.
#[derive(Clone, Debug)]
pub(crate) struct PublishedState(Arc<Slot>);

/// Returns the two sides of a state that is [`DriveState::default`] until the first publication.
pub(crate) fn channel() -> (StatePublisher, PublishedState) {
    let slot = Arc::new(Slot::default());
    (StatePublisher(Arc::clone(&slot)), PublishedState(slot))
}

impl StatePublisher {
    /// Publishes a state. Takes `&mut self` because two simultaneous writers would tear the state.
    pub(crate) fn publish(&mut self, state: &DriveState) {
        let slot = &*self.0;
        let sequence = slot.sequence.load(Ordering::Relaxed);
        slot.sequence
            .store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        slot.frames.store(state.frames, Ordering::Relaxed);
        slot.phase
            .store(encode_phase(state.phase), Ordering::Relaxed);
        slot.envelope_v
            .store(state.envelope_v.to_bits(), Ordering::Relaxed);
        slot.carrier_hz
            .store(state.carrier_hz.to_bits(), Ordering::Relaxed);
        let (step, first_frame) = match state.step {
            Some(step) => (u32::from(step.index) + 1, step.first_frame),
            None => (0, 0),
        };
        slot.step.store(step, Ordering::Relaxed);
        slot.step_first_frame.store(first_frame, Ordering::Relaxed);
        slot.programs.store(state.programs, Ordering::Relaxed);
        slot.refusals.store(state.refusals, Ordering::Relaxed);
        slot.sequence
            .store(sequence.wrapping_add(2), Ordering::Release);
    }
}

impl PublishedState {
    /// Returns the latest published state; waits while a write is under way.
    pub(crate) fn read(&self) -> DriveState {
        loop {
            if let Some(state) = self.try_read() {
                return state;
            }
            std::hint::spin_loop();
        }
    }

    /// Returns the latest published state, or `None` while a write is under way: for callbacks, which must not wait.
    pub(crate) fn try_read(&self) -> Option<DriveState> {
        let slot = &*self.0;
        let sequence = slot.sequence.load(Ordering::Acquire);
        if !sequence.is_multiple_of(2) {
            return None;
        }
        let step = slot.step.load(Ordering::Relaxed);
        let first_frame = slot.step_first_frame.load(Ordering::Relaxed);
        let state = DriveState {
            frames: slot.frames.load(Ordering::Relaxed),
            phase: decode_phase(slot.phase.load(Ordering::Relaxed)),
            envelope_v: f64::from_bits(slot.envelope_v.load(Ordering::Relaxed)),
            carrier_hz: f64::from_bits(slot.carrier_hz.load(Ordering::Relaxed)),
            step: step
                .checked_sub(1)
                .and_then(|index| u16::try_from(index).ok())
                .map(|index| StepState { index, first_frame }),
            programs: slot.programs.load(Ordering::Relaxed),
            refusals: slot.refusals.load(Ordering::Relaxed),
        };
        fence(Ordering::Acquire);
        (slot.sequence.load(Ordering::Relaxed) == sequence).then_some(state)
    }
}

const PHASES: [DrivePhase; 9] = [
    DrivePhase::Silent,
    DrivePhase::RampingIn,
    DrivePhase::Steady,
    DrivePhase::RampingOut,
    DrivePhase::EmergencyRamp,
    DrivePhase::EmergencyStopped,
    DrivePhase::Tripped(TripCause::NotFinite),
    DrivePhase::Tripped(TripCause::OverRange),
    DrivePhase::Tripped(TripCause::ForeignProgram),
];

fn encode_phase(phase: DrivePhase) -> u32 {
    match phase {
        DrivePhase::Silent => 0,
        DrivePhase::RampingIn => 1,
        DrivePhase::Steady => 2,
        DrivePhase::RampingOut => 3,
        DrivePhase::EmergencyRamp => 4,
        DrivePhase::EmergencyStopped => 5,
        DrivePhase::Tripped(TripCause::NotFinite) => 6,
        DrivePhase::Tripped(TripCause::OverRange) => 7,
        DrivePhase::Tripped(TripCause::ForeignProgram) => 8,
    }
}

fn decode_phase(code: u32) -> DrivePhase {
    PHASES[code as usize % PHASES.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a state with all fields computed from one number, so that a torn read is detectable.
    fn state(n: u64) -> DriveState {
        DriveState {
            frames: n,
            phase: PHASES[n as usize % PHASES.len()],
            envelope_v: n as f64 * 0.5,
            carrier_hz: n as f64 * 3.0,
            step: (!n.is_multiple_of(3)).then_some(StepState {
                index: n as u16,
                first_frame: n + 1,
            }),
            programs: n as u32,
            refusals: !(n as u32),
        }
    }

    #[test]
    fn every_phase_survives() {
        let (mut publisher, reader) = channel();
        for n in 0..100 {
            publisher.publish(&state(n));
            assert_eq!(reader.read(), state(n));
        }
    }

    #[test]
    fn readers_never_see_half_a_state() {
        let (mut publisher, reader) = channel();
        publisher.publish(&state(0));
        std::thread::scope(|scope| {
            let last = 200_000;
            for _ in 0..2 {
                let reader = reader.clone();
                scope.spawn(move || {
                    let mut newest = 0;
                    while newest < last {
                        let snapshot = reader.read();
                        assert_eq!(snapshot, state(snapshot.frames));
                        assert!(snapshot.frames >= newest);
                        newest = snapshot.frames;
                    }
                });
            }
            for n in 1..=last {
                publisher.publish(&state(n));
            }
        });
    }
}
