//! Files of a part: a table of its instances with all findings in its metadata, and the time series.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use analysis::RecordingSeries;
use analysis::findings::RecordingFindings;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use parquet::file::reader::{FileReader, SerializedFileReader};
use recording::disk::OnPath;
use sha2::{Digest, Sha256};

use crate::key::Key;
use crate::parts_error::PartsError;
use crate::stored_file::{decode, encode, write};

/// Key of the findings in the metadata of a part.
const FINDINGS: &str = "findings";
/// Key of their sum.
const SUM: &str = "findings_sha256";
/// Largest length of findings and of series, bytes.
const LIMIT_BYTES: u64 = 1 << 32;

/// Returns the metadata of a part.
pub(crate) fn metadata(
    key: &Key,
    findings: &RecordingFindings,
) -> Result<Vec<(String, String)>, String> {
    let bytes = compress(&encode(findings)?).map_err(|error| error.to_string())?;
    let sum = format!("{:x}", Sha256::digest(&bytes));
    let pairs = [
        ("friction_bench", crate::VERSION.to_owned()),
        ("key", key.to_string()),
        (SUM, sum),
        (FINDINGS, STANDARD.encode(&bytes)),
    ];
    Ok(pairs
        .into_iter()
        .map(|(name, text)| (name.to_owned(), text))
        .collect())
}

/// Reads the findings of the part at `path`.
pub(crate) fn read(path: &Path) -> Result<RecordingFindings, PartsError> {
    let damaged = |reason| PartsError::damaged(path, reason);
    let file = File::open(path).with_path("read", path)?;
    let reader = SerializedFileReader::new(file)
        .map_err(|_| damaged("it is cut off, or no Parquet file"))?;
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let value = |name: &str| {
        let mut pairs = pairs.into_iter().flatten();
        pairs.find(|pair| pair.key == name)?.value.as_deref()
    };
    let (text, sum) = value(FINDINGS)
        .zip(value(SUM))
        .ok_or_else(|| damaged("it has no findings: another program wrote it"))?;
    let bytes = STANDARD.decode(text).unwrap_or_default();
    if format!("{:x}", Sha256::digest(&bytes)) != sum {
        return Err(damaged("its findings do not have their sum"));
    }
    decompress(&bytes)
        .and_then(|bytes| decode(&bytes))
        .map_err(damaged)
}

/// Writes the time series of a part.
pub(crate) fn write_series(path: &Path, series: &RecordingSeries) -> Result<(), PartsError> {
    let error = |reason| PartsError::Encode {
        path: path.to_owned(),
        reason,
    };
    let bytes = encode(series).map_err(error)?;
    let bytes = compress(&bytes).map_err(|reason| error(reason.to_string()))?;
    Ok(write(path, &bytes)?)
}

/// Reads the time series of a part.
pub(crate) fn read_series(path: &Path) -> Result<RecordingSeries, PartsError> {
    let bytes = std::fs::read(path).with_path("read", path)?;
    let series = decompress(&bytes).and_then(|bytes| decode(&bytes));
    series.map_err(|reason| PartsError::damaged(path, reason))
}

/// Compresses bytes; the same bytes always give the same result.
fn compress(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes)?;
    encoder.finish()
}

fn decompress(bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
    let mut content = Vec::new();
    let decoder = GzDecoder::new(bytes);
    match decoder.take(LIMIT_BYTES).read_to_end(&mut content) {
        Ok(_) => Ok(content),
        Err(_) => Err("it is cut off, or its bytes were changed"),
    }
}
