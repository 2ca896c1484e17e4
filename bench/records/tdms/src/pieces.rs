//! Places of a channel's samples in the file.
//!
//! A segment repeats its chunk, the samples of each object once, until its end; the last chunk may be cut. A channel's samples are
//! therefore runs of equal length at equal distances: a piece describes all runs of a segment, and of the segments after it that
//! continue its pattern, so that a long file of short chunks takes little memory.

use std::sync::Arc;

use crate::chunk::{Chunk, Field, Place};

/// Runs of rows, with one sample of a channel in each row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Place of the first row, bytes in the file.
    pub byte: u64,
    /// From row to row of a run, bytes.
    pub row_bytes: u64,
    /// Rows of a run.
    pub run_values: u64,
    pub runs: u64,
    /// From run to run, bytes; without meaning for a single run.
    pub run_bytes: u64,
    pub is_big_endian: bool,
    pub fields: Arc<[Field]>,
}

impl Piece {
    pub fn values(&self) -> u64 {
        self.run_values.saturating_mul(self.runs)
    }

    /// Returns the place of a row, bytes in the file.
    pub fn byte_of(&self, row: u64) -> u64 {
        let run = row / self.run_values;
        self.byte + run * self.run_bytes + row % self.run_values * self.row_bytes
    }

    /// Adds the runs of `next` if they continue the pattern; returns whether they do.
    pub fn continues_with(&mut self, next: &Self) -> bool {
        let is_alike = self.row_bytes == next.row_bytes
            && self.run_values == next.run_values
            && self.is_big_endian == next.is_big_endian
            && self.fields == next.fields;
        let Some(distance) = next.byte.checked_sub(self.byte) else {
            return false;
        };
        let run_bytes = match self.runs {
            1 => distance,
            _ => self.run_bytes,
        };
        let is_regular = run_bytes.checked_mul(self.runs) == Some(distance)
            && (next.runs == 1 || next.run_bytes == run_bytes);
        if is_alike && is_regular {
            self.run_bytes = run_bytes;
            self.runs += next.runs;
        }
        is_alike && is_regular
    }
}

/// Stretch of the file that contains a segment's samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    pub begin: u64,
    pub end: u64,
    pub is_big_endian: bool,
    /// The segment's writer did not finish it.
    pub is_unfinished: bool,
}

impl Stretch {
    fn piece(
        &self,
        place: &Place,
        begin: u64,
        run_values: u64,
        runs: u64,
        run_bytes: u64,
    ) -> Piece {
        Piece {
            byte: self.begin + begin,
            row_bytes: place.row_bytes,
            run_values,
            runs,
            run_bytes,
            is_big_endian: self.is_big_endian,
            fields: Arc::clone(&place.fields),
        }
    }
}

/// Pieces of a segment.
#[derive(Debug)]
pub(crate) struct SegmentPieces {
    /// Number of the object in the chunk, and a piece of its samples, in the order of the samples.
    pub pieces: Vec<(usize, Piece)>,
    /// The last chunk is incomplete.
    pub is_cut: bool,
}

/// Returns the pieces of a segment.
///
/// # Errors
/// A description of the contradiction between chunk and segment.
pub(crate) fn pieces(chunk: &Chunk, stretch: Stretch) -> Result<SegmentPieces, String> {
    let mut pieces = Vec::new();
    let available = stretch.end.saturating_sub(stretch.begin);
    if chunk.bytes == 0 {
        return if available == 0 || stretch.is_unfinished {
            Ok(SegmentPieces {
                pieces,
                is_cut: available > 0,
            })
        } else {
            Err(format!(
                "{available} bytes of samples that no channel lists"
            ))
        };
    }
    let chunks = available / chunk.bytes;
    let remainder = available % chunk.bytes;
    let cut_begin = chunks * chunk.bytes;
    for (object, place) in chunk.places.iter().enumerate() {
        let Some(place) = place else { continue };
        if chunks > 0 && place.values > 0 {
            let piece = if place.fills(chunk) {
                stretch.piece(
                    place,
                    place.begin,
                    place.values.saturating_mul(chunks),
                    1,
                    0,
                )
            } else {
                stretch.piece(place, place.begin, place.values, chunks, chunk.bytes)
            };
            pieces.push((object, piece));
        }
        let (begin, values) = if chunk.is_sequential_when_cut(stretch.is_unfinished) {
            let reached = remainder.saturating_sub(place.begin);
            (place.begin, (reached / place.row_bytes).min(place.values))
        } else {
            // A finished segment with a part of a chunk contains that part of each object.
            (
                chunk.begin_in_part(place, remainder),
                chunk.values_in_part(place, remainder),
            )
        };
        if values > 0 {
            pieces.push((
                object,
                stretch.piece(place, cut_begin + begin, values, 1, 0),
            ));
        }
    }
    Ok(SegmentPieces {
        pieces,
        is_cut: remainder > 0,
    })
}
