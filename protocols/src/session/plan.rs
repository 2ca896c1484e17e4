//! The order of a session's trials.

use super::error::SessionError;
use crate::order;
use crate::protocol::{Condition, Order, Protocol};
use participants::ParticipantId;

/// A trial of a session.
#[derive(Clone, Debug)]
pub(super) struct PlannedTrial {
    /// Whether it is a practice trial.
    pub(super) practice: bool,
    /// Its condition.
    pub(super) condition: Condition,
}

/// Returns all trials of a session: practice trials through the conditions as listed, then the others in the protocol's
/// order.
///
/// # Errors
/// [`SessionError::NoParticipantNumber`] for a counterbalanced order.
pub(super) fn plan(
    protocol: &Protocol,
    participant: &ParticipantId,
    seed: u64,
) -> Result<Vec<PlannedTrial>, SessionError> {
    let number = match (protocol.trials.order, participant.number()) {
        (Order::Counterbalanced, None) => {
            return Err(SessionError::NoParticipantNumber {
                participant: participant.clone(),
            });
        }
        (_, number) => number.unwrap_or(0),
    };
    let conditions = protocol.conditions.len();
    let order = order::conditions(
        protocol.trials.order,
        conditions,
        protocol.trials.per_condition,
        number,
        seed,
        order::stream(participant.as_str()),
    );
    let practice = (0..protocol.trials.practice as usize).map(|i| (true, i % conditions));
    let main = order.into_iter().map(|condition| (false, condition));
    Ok(practice
        .chain(main)
        .map(|(practice, condition)| PlannedTrial {
            practice,
            condition: protocol.conditions[condition].clone(),
        })
        .collect())
}
