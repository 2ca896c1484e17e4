//! Several faults of one rehearsal.

use crate::fault_kind::FaultKind;
use crate::rehearsed_fault::RehearsedFault;

/// Two faults of one kind that overlap in time.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{fault} at {later_s} s begins before that at {earlier_s} s has ended")]
pub struct OverlapError {
    /// The fault.
    pub fault: FaultKind,
    /// Beginning of the earlier fault, s.
    pub earlier_s: f64,
    /// Beginning of the later fault, s.
    pub later_s: f64,
}

/// Requires that no two faults of one kind overlap, as they could not be told apart.
///
/// # Errors
/// [`OverlapError`] with both beginnings.
pub fn require_apart(faults: &[RehearsedFault]) -> Result<(), OverlapError> {
    let mut sorted: Vec<_> = faults.iter().filter(|fault| fault.fault.ends()).collect();
    sorted.sort_by(|a, b| {
        (a.fault, a.at_s)
            .partial_cmp(&(b.fault, b.at_s))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let overlap = sorted.windows(2).find(|pair| {
        let ends_s = pair[0].until_s.unwrap_or(f64::INFINITY);
        pair[0].fault == pair[1].fault && pair[1].at_s < ends_s
    });
    overlap.map_or(Ok(()), |pair| {
        Err(OverlapError {
            fault: pair[0].fault,
            earlier_s: pair[0].at_s,
            later_s: pair[1].at_s,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlap_of(texts: &[&str]) -> Result<(), OverlapError> {
        let faults: Vec<_> = texts.iter().map(|text| text.parse().unwrap()).collect();
        require_apart(&faults)
    }

    #[test]
    fn one_fault_ends_before_it_begins_again() {
        assert_eq!(
            overlap_of(&[
                "estop@3s-4s",
                "estop@1s-2s",
                "estop-cut@1s",
                "xrun@1s",
                "xrun@1s"
            ]),
            Ok(())
        );
        assert_eq!(overlap_of(&["estop@1s-2s", "estop@2s"]), Ok(()));
        let overlap = overlap_of(&["estop@3s", "estop@1s"]).unwrap_err();
        assert_eq!((overlap.earlier_s, overlap.later_s), (1.0, 3.0));
        assert!(overlap_of(&["estop@1s-4s", "estop@3s-5s"]).is_err());
    }
}
