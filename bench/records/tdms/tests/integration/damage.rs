//! Damaged files: read or refused, without a panic, in bounded time and memory.

use std::io::Cursor;

use proptest::prelude::*;
use tdms_files::TdmsFile;

use crate::files;

/// Most samples that a test reads of one channel.
const MOST: u64 = 100_000;

fn read_all(bytes: Vec<u8>) {
    let length = bytes.len() as u64;
    let Ok(mut file) = TdmsFile::open(Cursor::new(bytes)) else {
        return;
    };
    for index in 0..file.channels().len() {
        let samples = file.channels()[index].length();
        assert!(samples <= 8 * length, "{samples} samples in {length} bytes");
        let mut values = Vec::new();
        if file
            .read_complex(index, 0..samples.min(MOST), &mut values)
            .is_ok()
        {
            assert_eq!(values.len() as u64, samples.min(MOST));
        }
    }
}

/// A place in a file, and the byte there instead; or the file's end.
#[derive(Debug, Clone)]
enum Damage {
    Byte(prop::sample::Index, u8),
    Word(prop::sample::Index, u32),
    Cut(prop::sample::Index),
}

fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<prop::sample::Index>;
    let words = prop_oneof![
        Just(0),
        Just(u32::MAX),
        Just(0x7fff_ffff),
        0..64_u32,
        any::<u32>()
    ];
    prop_oneof![
        4 => (place(), any::<u8>()).prop_map(|(place, byte)| Damage::Byte(place, byte)),
        4 => (place(), words).prop_map(|(place, word)| Damage::Word(place, word)),
        1 => place().prop_map(Damage::Cut),
    ]
}

/// Returns the number of damaged files: few, or as many as `FRICTION_BENCH_DAMAGED_FILES` says.
fn cases() -> u32 {
    let stated = std::env::var("FRICTION_BENCH_DAMAGED_FILES").ok();
    stated.and_then(|cases| cases.parse().ok()).unwrap_or(2000)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_are_read_or_refused(
        file in any::<prop::sample::Index>(),
        damages in prop::collection::vec(damage(), 1..6),
    ) {
        let files = files::all();
        let (_, mut bytes) = files[file.index(files.len())].clone();
        for damage in damages {
            if bytes.is_empty() {
                break;
            }
            match damage {
                Damage::Byte(place, byte) => {
                    let place = place.index(bytes.len());
                    bytes[place] = byte;
                }
                Damage::Word(place, word) => {
                    let place = place.index(bytes.len());
                    let end = (place + 4).min(bytes.len());
                    bytes[place..end].copy_from_slice(&word.to_le_bytes()[..end - place]);
                }
                Damage::Cut(place) => bytes.truncate(place.index(bytes.len())),
            }
        }
        read_all(bytes);
    }
}
