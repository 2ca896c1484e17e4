//! Samples of a piece, read from the file a block at a time.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

use crate::pieces::Piece;
use crate::scale::Scales;

/// Bytes that are read at once.
const BLOCK_BYTES: u64 = 1 << 20;
/// Longest distance of runs that are read together with the bytes between them.
const SMALL_RUN_BYTES: u64 = 64 << 10;

/// Numbers of a channel, to which samples are appended.
#[derive(Debug)]
pub(crate) enum Numbers<'a> {
    Real {
        scales: &'a Scales,
        values: &'a mut Vec<f64>,
    },
    /// Real and imaginary parts.
    Complex(&'a mut Vec<[f64; 2]>),
}

/// Reads rows of a piece.
pub(crate) fn read_rows<R: Read + Seek>(
    source: &mut R,
    piece: &Piece,
    rows: Range<u64>,
    numbers: &mut Numbers<'_>,
) -> io::Result<()> {
    let mut block = Vec::new();
    let mut row = rows.start;
    while row < rows.end {
        let end = block_end(piece, row).min(rows.end);
        let begin = piece.byte_of(row);
        // The last row contains the channel's own numbers, and perhaps no others.
        let last = piece.byte_of(end - 1) + own_bytes(piece);
        source.seek(SeekFrom::Start(begin))?;
        block.clear();
        let length = last - begin;
        if source.by_ref().take(length).read_to_end(&mut block)? as u64 != length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let places = (row..end).map(|row| (piece.byte_of(row) - begin) as usize);
        decode(piece, &block, places, numbers);
        row = end;
    }
    Ok(())
}

/// Returns the end of the rows that are read together, beginning with `row`.
fn block_end(piece: &Piece, row: u64) -> u64 {
    let rows_left = piece.run_values - row % piece.run_values;
    if piece.runs > 1 && piece.run_bytes <= SMALL_RUN_BYTES {
        let runs = BLOCK_BYTES / piece.run_bytes.max(1);
        row + rows_left + (runs.max(1) - 1) * piece.run_values
    } else {
        row + rows_left.min((BLOCK_BYTES / piece.row_bytes).max(1))
    }
}

/// Returns the bytes from a row's begin to the end of the channel's last number in it.
fn own_bytes(piece: &Piece) -> u64 {
    let ends = piece.fields.iter().map(|field| {
        let size = field.sample_type.size().unwrap_or(0);
        field.offset + size
    });
    ends.max().unwrap_or(0)
}

fn decode(
    piece: &Piece,
    block: &[u8],
    places: impl Iterator<Item = usize>,
    numbers: &mut Numbers<'_>,
) {
    let is_big_endian = piece.is_big_endian;
    match (numbers, &*piece.fields) {
        (Numbers::Complex(values), [field, ..]) => values.extend(places.map(|place| {
            let bytes = block.get(place + field.offset as usize..);
            let value = bytes.and_then(|bytes| field.sample_type.complex(bytes, is_big_endian));
            value.unwrap_or([f64::NAN; 2])
        })),
        (Numbers::Real { scales, values }, fields) => {
            let mut stored = vec![(None, f64::NAN); fields.len()];
            values.extend(places.map(|place| {
                for (field, stored) in fields.iter().zip(&mut stored) {
                    let bytes = block.get(place + field.offset as usize..);
                    let number =
                        bytes.and_then(|bytes| field.sample_type.number(bytes, is_big_endian));
                    let number = number.unwrap_or(f64::NAN);
                    let number = match field.bit {
                        Some(bit) => (number as i64 >> bit & 1) as f64,
                        None => number,
                    };
                    *stored = (field.scale_id, number);
                }
                scales.apply(&stored)
            }));
        }
        (Numbers::Complex(_), []) => {}
    }
}
