//! Damaged files of a recording never make its reader panic, and intact parts are read.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

use crate::support::{FORMAT_2, manifest, ramp, read_all, write_data};
use proptest::prelude::*;
use recording::writer::Ending;
use recording::{
    FORCE_FILE, ForceRow, MANIFEST_FILE, POSITION_FILE, PositionRow, RecordingReader,
    RecordingWriter, SIGNALS_FILE,
};
use wav_files::WavReader;

const FILES: [&str; 4] = [MANIFEST_FILE, SIGNALS_FILE, FORCE_FILE, POSITION_FILE];

/// Writes a complete recording into `folder` and returns the contents of its [`FILES`]; made once, because its syncs are
/// slow.
fn recording(folder: &Path) -> &'static [Vec<u8>; 4] {
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
    &CONTENTS
}

/// Output of the reader for each stream, bit for bit, up to its first error; `None` if the stream or the recording does
/// not open.
#[derive(Debug, Default, PartialEq)]
struct Streams {
    signals: Option<Vec<u32>>,
    force: Option<Vec<[u64; 3]>>,
    position: Option<Vec<[u64; 2]>>,
}

fn read_everything(folder: &Path) -> Streams {
    let Ok(mut reader) = RecordingReader::open(folder) else {
        return Streams::default();
    };
    let (mut signals, mut block) = (Vec::new(), Vec::new());
    while reader.read_block(100, &mut block).is_ok_and(|n| n > 0) {
        signals.extend(block.iter().map(|sample| sample.to_bits()));
    }
    let force = reader.force().map(|mut rows| {
        let bits = |row: ForceRow| [row.time_s, row.normal_n, row.lateral_n].map(f64::to_bits);
        let read = rows.by_ref().map_while(Result::ok).map(bits).collect();
        let _ = rows.warnings();
        read
    });
    let position = reader.position().map(|mut rows| {
        let bits = |row: PositionRow| [row.time_s, row.position_m].map(f64::to_bits);
        let read = rows.by_ref().map_while(Result::ok).map(bits).collect();
        let _ = rows.warnings();
        read
    });
    Streams {
        signals: Some(signals),
        force: force.ok(),
        position: position.ok(),
    }
}

proptest! {
    /// Fault 38.
    #[test]
    fn any_byte_changed_removed_or_added_anywhere(
        name in prop::sample::select(&FILES),
        // Half of the damage is in the first bytes, where the headers are.
        position in prop_oneof![0.0..0.01, 0.0..1.0],
        byte: u8,
        kind in 0..4,
    ) {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path().join("r");
        let contents = recording(&folder);
        let intact = read_everything(&folder);
        let path = folder.join(name);
        let mut bytes = fs::read(&path).unwrap();
        let position = (position * bytes.len() as f64) as usize;
        match kind {
            0 => bytes[position] = byte,
            1 => bytes.truncate(position),
            2 => drop(bytes.remove(position)),
            _ => bytes.insert(position, byte),
        }
        fs::write(&path, &bytes).unwrap();
        let read = read_everything(&folder);

        // Reading changes no file.
        for (file, contents) in FILES.iter().zip(contents) {
            let expected = if *file == name { &bytes } else { contents };
            prop_assert_eq!(&fs::read(folder.join(file)).unwrap(), expected, "{}", file);
        }
        prop_assert_eq!(fs::read_dir(&folder).unwrap().count(), FILES.len());
        // Damage to one stream does not affect the others.
        if name == FORCE_FILE || name == POSITION_FILE {
            prop_assert_eq!(&read.signals, &intact.signals);
        }
        if name == FORCE_FILE {
            prop_assert_eq!(&read.position, &intact.position);
        }
        if name == POSITION_FILE {
            prop_assert_eq!(&read.force, &intact.force);
        }
        if name == SIGNALS_FILE && read.signals.is_some() {
            prop_assert_eq!((&read.force, &read.position), (&intact.force, &intact.position));
        }
    }

    /// Fault 38.
    #[test]
    fn a_truncated_file_gives_every_whole_frame(length in 0usize..8000) {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path().join("r");
        recording(&folder);
        let path = folder.join(SIGNALS_FILE);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..58 + length]).unwrap();
        let (reader, samples) = read_all(&folder);
        prop_assert_eq!(samples, ramp(0, length / 8));
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
            let mut offset = 12;
            for (id, size) in chunks {
                if let Some(place) = bytes.get_mut(offset..offset + 8) {
                    place[..4].copy_from_slice(&id);
                    place[4..].copy_from_slice(&size.to_le_bytes());
                }
                offset += 8 + size as usize + size as usize % 2;
            }
        }
        if let Ok((mut reader, _)) = WavReader::new(Cursor::new(bytes)) {
            let mut block = Vec::new();
            while reader.read_block(7, &mut block).is_ok_and(|n| n > 0) {}
        }
    }
}
