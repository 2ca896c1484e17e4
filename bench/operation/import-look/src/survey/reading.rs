//! Values of a vector, read by stretches.

use std::ops::Range;

use num_complex::Complex64;
use source_files::{SourceError, SourceFile, Vector};

use crate::excerpt::{Excerpt, Piece, plan};

/// Reads the stretches of a vector; of complex values the magnitudes.
pub(super) fn excerpt(file: &mut SourceFile, vector: &Vector) -> Result<Excerpt, Box<SourceError>> {
    let mut pieces = Vec::new();
    for range in plan(vector.len()) {
        let start = range.start;
        pieces.push(Piece {
            start,
            values: values(file, vector, range)?,
        });
    }
    Ok(Excerpt {
        length: vector.len(),
        pieces,
    })
}

fn values(
    file: &mut SourceFile,
    vector: &Vector,
    range: Range<u64>,
) -> Result<Vec<f64>, Box<SourceError>> {
    let mut values = Vec::new();
    if vector.is_complex() {
        let mut complex: Vec<Complex64> = Vec::new();
        file.read_complex(vector, range, &mut complex)?;
        values.extend(complex.iter().map(|value| value.norm()));
    } else {
        file.read(vector, range, &mut values)?;
    }
    Ok(values)
}
