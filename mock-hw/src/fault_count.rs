//! Count of the frames that a fault still affects.

/// Decrements `count`; returns whether it was above 0.
pub(crate) fn take_one(count: &mut u32) -> bool {
    let is_due = *count > 0;
    *count = count.saturating_sub(1);
    is_due
}
