//! Calls of decoders that panic on some damaged files.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread is in a decoder.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

static SILENT: Once = Once::new();

/// Calls a function of a decoder; `None` if it panics, of which nothing is reported.
pub fn guarded<T>(call: impl FnOnce() -> T) -> Option<T> {
    SILENT.call_once(|| {
        let report = take_hook();
        set_hook(Box::new(move |info| {
            if !IS_GUARDED.get() {
                report(info);
            }
        }));
    });
    let was_guarded = IS_GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    IS_GUARDED.set(was_guarded);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_a_decoder_is_no_result() {
        assert_eq!(guarded(|| 1), Some(1));
        assert_eq!(guarded(|| panic!("damaged") as u8), None);
        assert!(!IS_GUARDED.get());
    }
}
