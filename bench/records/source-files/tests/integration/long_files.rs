//! Long files, read by stretches in little memory.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::FileExt;
use std::path::Path;

use source_files::SourceFile;

/// Maximum memory of this process, bytes.
const MOST_MEMORY_BYTES: u64 = 200 << 20;

/// Bytes of the long files, of which only the ends are on the disk.
const LONG_BYTES: u64 = 4 << 30;

/// Requires that this process took little memory.
pub fn require_little_memory() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap();
    let peak: u64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
    assert!(peak * 1024 < MOST_MEMORY_BYTES, "{peak} kB");
}

/// Returns the last values of a vector, after others from its start.
pub fn last_values(path: &Path, name: &str) -> Vec<f64> {
    let mut source = SourceFile::open(path).unwrap_or_else(|error| panic!("{error}"));
    let vector = source.locate(name).unwrap();
    let mut values = Vec::new();
    source.read(&vector, 0..100_000, &mut values).unwrap();
    values.clear();
    source
        .read(&vector, vector.len() - 3..vector.len(), &mut values)
        .unwrap();
    values
}

/// Writes a header, a gap without bytes on the disk, and the last values.
fn write_gap(path: &Path, header: &[u8], values: &[f64]) {
    let file = File::create(path).unwrap();
    file.write_all_at(header, 0).unwrap();
    let end: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    file.write_all_at(&end, header.len() as u64 + LONG_BYTES - end.len() as u64)
        .unwrap();
}

#[test]
fn the_end_of_four_gigabytes_is_read_in_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let ends = [1.5, 2.5, 3.5, 4.5, 5.5, 6.5];
    let rows = LONG_BYTES / 16;
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 2), }}");
    let npy = [
        b"\x93NUMPY\x01\x00",
        &(text.len() as u16).to_le_bytes()[..],
        text.as_bytes(),
    ]
    .concat();
    let path = folder.path().join("long.npy");
    write_gap(&path, &npy, &ends);
    assert_eq!(last_values(&path, "[:,0]"), [1.5, 3.5, 5.5]);
    let mut rf64 = b"RF64\xff\xff\xff\xffWAVEds64".to_vec();
    rf64.extend(28u32.to_le_bytes());
    rf64.extend((LONG_BYTES + 72).to_le_bytes());
    rf64.extend(LONG_BYTES.to_le_bytes());
    rf64.extend([0; 12]);
    rf64.extend(b"fmt \x10\0\0\0\x03\0\x02\0");
    rf64.extend(400_000u32.to_le_bytes());
    rf64.extend(6_400_000u32.to_le_bytes());
    rf64.extend(b"\x10\0\x40\0data\xff\xff\xff\xff");
    let path = folder.path().join("long.rf64");
    write_gap(&path, &rf64, &ends);
    assert_eq!(last_values(&path, "[:,1]"), [2.5, 4.5, 6.5]);
    require_little_memory();
}

#[test]
fn a_long_table_is_read_in_little_memory() {
    // Rows of 200 MB; a campaign writes as many as 4 GB have.
    let rows: u64 =
        std::env::var("FRICTION_BENCH_TABLE_ROWS").map_or(7_500_000, |rows| rows.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let mut file = std::io::BufWriter::new(File::create(&path).unwrap());
    writeln!(file, "t,drive,pickup").unwrap();
    for row in 0..rows {
        writeln!(
            file,
            "{}.{:05},{}.25,-{}.5",
            row / 100_000,
            row % 100_000,
            row % 17,
            row % 19
        )
        .unwrap();
    }
    drop(file);
    let last = rows - 1;
    let expected = [last - 2, last - 1, last].map(|row| -((row % 19) as f64 + 0.5));
    assert_eq!(last_values(&path, "pickup"), expected);
    require_little_memory();
}
