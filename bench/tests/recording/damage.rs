//! No damage of a recording's files makes its reader panic, and what is whole is read.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

use crate::support::{FORMAT_2, manifest, ramp, read_all, write_data};
use proptest::prelude::*;
use recording::wav::WavReader;
use recording::writer::Ending;
use recording::{
    FORCE_FILE, MANIFEST_FILE, POSITION_FILE, RecordingReader, RecordingWriter, SIGNALS_FILE,
};

const FILES: [&str; 4] = [MANIFEST_FILE, SIGNALS_FILE, FORCE_FILE, POSITION_FILE];

/// Copies a recording; made once, for its syncs take long.
fn recording(folder: &Path) {
    static CONTENTS: LazyLock<[Vec<u8>; 4]> = LazyLock::new(|| {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path().join("r");
        let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
        write_data(&mut writer);
        writer.write_gap(1).unwrap();
        writer.finish(Ending::Completed).unwrap();
        FILES.map(|name| fs::read(folder.join(name)).unwrap())
    });
    fs::create_dir(folder).unwrap();
    for (name, contents) in FILES.iter().zip(&*CONTENTS) {
        fs::write(folder.join(name), contents).unwrap();
    }
}

fn read_everything(folder: &Path) {
    let Ok(mut reader) = RecordingReader::open(folder) else {
        return;
    };
    let mut block = Vec::new();
    while reader.read_block(100, &mut block).is_ok_and(|n| n > 0) {}
    let _ = reader
        .force()
        .map(|mut rows| (rows.by_ref().count(), rows.warnings()));
    let _ = reader
        .position()
        .map(|mut rows| (rows.by_ref().count(), rows.warnings()));
}

proptest! {
    #[test]
    fn any_byte_changed_removed_or_added_anywhere(
        name in prop::sample::select(&FILES),
        // Half of the damage in the first bytes, where the headers are.
        at in prop_oneof![0.0..0.01, 0.0..1.0],
        byte: u8,
        kind in 0..4,
    ) {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path().join("r");
        recording(&folder);
        let path = folder.join(name);
        let mut bytes = fs::read(&path).unwrap();
        let at = (at * bytes.len() as f64) as usize;
        match kind {
            0 => bytes[at] = byte,
            1 => bytes.truncate(at),
            2 => drop(bytes.remove(at)),
            _ => bytes.insert(at, byte),
        }
        fs::write(&path, bytes).unwrap();
        read_everything(&folder);
    }

    #[test]
    fn a_truncated_file_gives_every_whole_frame(kept in 0usize..8000) {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path().join("r");
        recording(&folder);
        let path = folder.join(SIGNALS_FILE);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..58 + kept]).unwrap();
        let (reader, samples) = read_all(&folder);
        prop_assert_eq!(samples, ramp(0, kept / 8));
        prop_assert!(!reader.warnings().is_empty());
    }

    #[test]
    fn no_bytes_make_the_header_reader_panic(
        mut bytes in prop::collection::vec(any::<u8>(), 0..200),
        chunks in prop::collection::vec((prop::sample::select(vec![*b"fmt ", *b"data", *b"LIST"]), 0u32..60), 0..4),
        begins_well: bool,
    ) {
        if begins_well && bytes.len() >= 12 {
            bytes[..4].copy_from_slice(b"RIFF");
            bytes[8..12].copy_from_slice(b"WAVE");
            let mut at = 12;
            for (id, size) in chunks {
                if let Some(place) = bytes.get_mut(at..at + 8) {
                    place[..4].copy_from_slice(&id);
                    place[4..].copy_from_slice(&size.to_le_bytes());
                }
                at += 8 + size as usize + size as usize % 2;
            }
        }
        if let Ok((mut reader, _)) = WavReader::new(Cursor::new(bytes)) {
            let mut block = Vec::new();
            while reader.read_block(7, &mut block).is_ok_and(|n| n > 0) {}
        }
    }
}
