//! Large files: opened at once, in memory that does not grow with them.

use std::fs::File;
use std::io::Write;

use tdms_files::TdmsFile;

use crate::writer::{Bytes, F64, I16, Index, METADATA, NEW_LIST, RAW, Segment};

/// A file with holes, of two channels in chunks of 12 bytes: some 400 million chunks.
#[test]
fn a_file_of_many_small_chunks_takes_little_memory() {
    const CHUNK: u64 = 12;
    const CHUNKS: u64 = 5_000_000_000 / CHUNK;
    let mut start = Segment {
        mask: METADATA | NEW_LIST | RAW,
        is_big_endian: false,
        objects: vec![
            ("/'g'/'a'", Index::Plain(I16, 2), vec![]),
            ("/'g'/'b'", Index::Plain(F64, 1), vec![]),
        ],
        samples: vec![],
    }
    .bytes();
    let metadata = start.len() as u64 - 28;
    let stated = Bytes::new(false).u64(metadata + CHUNK * CHUNKS);
    start[12..20].copy_from_slice(&stated.bytes);
    let path = tempfile::NamedTempFile::new().unwrap();
    let mut file = path.reopen().unwrap();
    file.write_all(&start).unwrap();
    file.set_len(start.len() as u64 + CHUNK * (CHUNKS - 1))
        .unwrap();
    let last = Bytes::new(false).i16s([7, 8]).f64s([2.5]);
    std::io::Seek::seek(&mut file, std::io::SeekFrom::End(0)).unwrap();
    file.write_all(&last.bytes).unwrap();

    let mut file = TdmsFile::open(File::open(path.path()).unwrap()).unwrap();
    assert!(!file.is_truncated());
    assert_eq!(file.channels()[0].length(), 2 * CHUNKS);
    let mut values = Vec::new();
    file.read(0, 2 * CHUNKS - 5..2 * CHUNKS, &mut values)
        .unwrap();
    assert_eq!(values, [0.0, 0.0, 0.0, 7.0, 8.0]);
    values.clear();
    file.read(1, CHUNKS - 100_000..CHUNKS, &mut values).unwrap();
    assert_eq!(values.len(), 100_000);
    assert_eq!(values.last(), Some(&2.5));
}

/// A file that a program wrote a sample at a time, each in a segment of its own.
#[test]
fn segments_that_repeat_join_into_one_piece() {
    let first = Segment {
        mask: METADATA | NEW_LIST | RAW,
        is_big_endian: false,
        objects: vec![
            ("/'g'/'a'", Index::Plain(I16, 1), vec![]),
            ("/'g'/'b'", Index::Plain(I16, 1), vec![]),
        ],
        samples: vec![0; 4],
    };
    let mut bytes = first.bytes();
    for n in 1..50_000_u32 {
        let next = Segment {
            mask: RAW,
            objects: vec![],
            samples: Bytes::new(false).u32(n).bytes,
            is_big_endian: false,
        };
        bytes.extend(next.bytes());
    }
    let mut file = TdmsFile::open(std::io::Cursor::new(bytes)).unwrap();
    assert!(format!("{file:?}").len() < 5_000, "the pieces did not join");
    let mut values = Vec::new();
    file.read(0, 0..50_000, &mut values).unwrap();
    let expected = (0..50_000_u32).map(|n| f64::from(n as u16 as i16));
    assert!(values.into_iter().eq(expected));
}
