//! Any text as a protocol file: an error or a protocol.
#![no_main]

use libfuzzer_sys::fuzz_target;
use protocols::Protocol;

fuzz_target!(|text: &str| {
    let _ = Protocol::parse(text, "protocol.toml");
});
