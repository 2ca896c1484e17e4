//! Any text as `recording.toml`: an error, or a manifest that is written and read back alike.
#![no_main]

use friction_bench::recording::Manifest;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(manifest) = Manifest::parse(text, "recording.toml") {
        let written = manifest.to_toml().expect("what was read can be written");
        let again =
            Manifest::parse(&written, "recording.toml").expect("what was written can be read");
        assert_eq!(again, manifest);
    }
});
