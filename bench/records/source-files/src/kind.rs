//! Kinds of files, found by their first bytes.

use text_lines::Encoding;

use crate::error::SourceFault;

/// Kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// HDF5, MATLAB v7.3 included.
    Hdf5,
    /// TDMS.
    Tdms,
    /// MATLAB v5 to v7.
    Matlab5,
    /// MATLAB v4.
    Matlab4,
    /// NumPy's array.
    Npy,
    /// Archive, as NumPy's.
    Zip,
    /// WAV, RF64, BW64, Wave64.
    Wav,
    /// FLAC.
    Flac,
    /// Parquet.
    Parquet,
    /// Measurement file of LabVIEW.
    Lvm,
    /// Text.
    Text,
}

/// Signature of HDF5, at the start or after 512, 1024, 2048, … bytes.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Offsets beyond which HDF5's signature is not sought.
const HDF5_OFFSETS: std::ops::Range<u32> = 9..31;

/// First bytes of the kinds that are read.
const KINDS: [(&[u8], Kind); 11] = [
    (HDF5, Kind::Hdf5),
    (b"TDSm", Kind::Tdms),
    (b"\x93NUMPY", Kind::Npy),
    (b"PK\x03\x04", Kind::Zip),
    (b"PK\x05\x06", Kind::Zip),
    (b"RIFF", Kind::Wav),
    (b"RF64", Kind::Wav),
    (b"BW64", Kind::Wav),
    (b"riff\x2e\x91\xcf\x11", Kind::Wav),
    (b"fLaC", Kind::Flac),
    (b"PAR1", Kind::Parquet),
];

/// First bytes and names of kinds.
type Starts = &'static [(&'static [u8], &'static str)];

/// Remedies for kinds that are not read, with their first bytes and names.
const FOREIGN: [(&str, Starts); 11] = [
    (
        "name the .tdms file next to it",
        &[(b"TDSh", "the index of a TDMS file")],
    ),
    (
        "save it without encryption",
        &[(b"PARE", "an encrypted Parquet file")],
    ),
    ("save it as WAV", &[(b"RIFX", "a big-endian WAV file")]),
    (
        "save it as WAV with 32-bit float samples",
        &[
            (b"FORM", "an AIFF file"),
            (b"caff", "a file of Apple's Core Audio"),
            (b".snd", "a Sun audio file"),
        ],
    ),
    (
        "save the original recording as WAV or FLAC",
        &[(b"OggS", "an Ogg file"), (b"ID3", "an MP3 file")],
    ),
    (
        "unpack it, and name the file in it",
        &[
            (b"\x1f\x8b", "a gzip archive"),
            (b"BZh", "a bzip2 archive"),
            (b"\xfd7zXZ", "an xz archive"),
            (b"7z\xbc\xaf", "a 7-Zip archive"),
            (b"Rar!", "a RAR archive"),
            (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
        ],
    ),
    (
        "save the sheet as CSV",
        &[(b"\xd0\xcf\x11\xe0", "an old Excel or Office file")],
    ),
    (
        "save it as Parquet or CSV",
        &[
            (b"ARROW1", "an Arrow (Feather) file"),
            (b"ORC", "an ORC file"),
        ],
    ),
    (
        "save it as netCDF of version 4, or as CSV",
        &[
            (b"\x0eCDF", "a netCDF file of version 3"),
            (b"CDF\x01", "a netCDF file of version 3"),
            (b"CDF\x02", "a netCDF file of version 3"),
            (b"CDF\x05", "a netCDF file of version 3"),
        ],
    ),
    (
        "name the file of the data",
        &[(b"\x89PNG", "a picture"), (b"%PDF", "a PDF file")],
    ),
    (
        "save the arrays with numpy.savez",
        &[(b"\x80\x04\x95", "a pickle of Python")],
    ),
];

/// Finds the kind of a file from its first bytes; `has_bytes` looks at later ones.
///
/// # Errors
/// The file is empty or of a kind that is not read.
pub(crate) fn find(
    head: &[u8],
    mut has_bytes: impl FnMut(u64, &[u8]) -> bool,
) -> Result<Kind, SourceFault> {
    if head.is_empty() {
        return Err(foreign("an empty file", "copy it again"));
    }
    if let Some((_, kind)) = KINDS.iter().find(|(start, _)| head.starts_with(start)) {
        return Ok(*kind);
    }
    for (remedy, kinds) in FOREIGN {
        if let Some((_, kind)) = kinds.iter().find(|(start, _)| head.starts_with(start)) {
            return Err(foreign(kind, remedy));
        }
    }
    let mut powers = HDF5_OFFSETS.map(|power| 1u64 << power);
    if !is_text(head) && powers.any(|offset| has_bytes(offset, HDF5)) {
        return Ok(Kind::Hdf5);
    }
    if is_matlab5(head) {
        return Ok(Kind::Matlab5);
    }
    if is_matlab4(head) {
        return Ok(Kind::Matlab4);
    }
    let bare = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    if bare.starts_with(lvm_files::MARK) {
        return Ok(Kind::Lvm);
    }
    if Encoding::find(head) != Encoding::Utf8 || is_text(head) {
        return Ok(Kind::Text);
    }
    let start: Vec<String> = head
        .iter()
        .take(8)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let kind = format!(
        "binary data of an unknown kind, beginning with {}",
        start.join(" ")
    );
    Err(SourceFault::Foreign {
        kind,
        remedy: "save it as MATLAB, HDF5, TDMS, NPY, WAV, CSV or Parquet",
    })
}

/// Creates the refusal of a kind that is not read.
pub(crate) fn foreign(kind: &str, remedy: &'static str) -> SourceFault {
    SourceFault::Foreign {
        kind: kind.to_owned(),
        remedy,
    }
}

/// Returns whether the bytes are text: no control character but tabs, line ends and form feeds.
fn is_text(head: &[u8]) -> bool {
    let is_control = |byte: &u8| {
        *byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | b'\x0c' | b'\x1a' | b'\x1b')
    };
    !head.iter().any(|byte| is_control(byte) || *byte == 0x7f)
}

/// Returns whether the bytes are the header of MATLAB v5 to v7: 124 of text, then version and byte order.
fn is_matlab5(head: &[u8]) -> bool {
    let has_order = matches!(
        head.get(124..128),
        Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])
    );
    has_order || head.starts_with(b"MATLAB 5.0 MAT-file")
}

/// Returns whether the bytes are the header of a matrix of MATLAB v4.
fn is_matlab4(head: &[u8]) -> bool {
    let Some(words) = head.first_chunk::<20>() else {
        return false;
    };
    let (words, _) = words.as_chunks::<4>();
    [i32::from_le_bytes, i32::from_be_bytes]
        .into_iter()
        .any(|word| {
            let words: Vec<i32> = words.iter().map(|bytes| word(*bytes)).collect();
            let [kind, rows, columns, imaginary, name] = words[..] else {
                return false;
            };
            let digits = [kind / 1000, kind / 100 % 10, kind / 10 % 10, kind % 10];
            (0..5000).contains(&kind)
                && digits[1] == 0
                && digits[2] <= 5
                && digits[3] <= 2
                && rows >= 0
                && columns >= 0
                && (0..=1).contains(&imaginary)
                && (1..=256).contains(&name)
        })
}
