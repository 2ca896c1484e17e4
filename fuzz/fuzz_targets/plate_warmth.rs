//! `readers::plate_warmth`.
#![no_main]

#[expect(dead_code, reason = "the other targets' readers")]
#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    readers::plate_warmth(bytes);
});
