//! `readers::field_box`.
#![no_main]

#[expect(dead_code, reason = "the other targets' readers")]
#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    readers::field_box(bytes);
});
