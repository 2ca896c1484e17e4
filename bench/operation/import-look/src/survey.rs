//! Reading of a file by stretches.

use std::ops::Range;
use std::path::Path;

use num_complex::Complex64;
use source_files::{ArrayInfo, Attribute, Element, SourceError, SourceFile, Vector};

use crate::excerpt::{Excerpt, Piece, plan};
use crate::names;
use crate::nature::{Nature, nature};
use crate::portrait::{FilePortrait, SinglePortrait, VectorPortrait};
use crate::rates::{RateScalar, Rates, Times};
use crate::time_axis::{TimeUnit, time_axis};

/// Most vectors of a file that are looked at, and most columns of one array.
const MOST_VECTORS: usize = 256;
const MOST_COLUMNS: u64 = 24;
/// Values at the start of a vector by which an array of times is known.
const HEAD: u64 = 4_096;
/// Most characters of a text that are shown.
const MOST_CHARACTERS: usize = 60;

/// Looks at a file; `progress` is called with the number of vectors done and the number of all.
///
/// # Errors
/// The file cannot be opened, or not read where it was looked at.
pub(crate) fn survey(
    path: &Path,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<FilePortrait, SourceError> {
    let mut file = SourceFile::open(path)?;
    let infos = file.arrays().to_vec();
    let is_single = |info: &ArrayInfo| info.count() == 1 || !info.element.is_numeric();
    let mut singles = Vec::new();
    for info in infos.iter().filter(|info| is_single(info)) {
        singles.push(single(&mut file, info));
    }
    let attributes: Vec<SinglePortrait> = file
        .attributes()
        .map(|(name, value)| attribute(name, value))
        .collect();
    singles.extend(attributes);

    let all: Vec<(usize, String)> = infos
        .iter()
        .enumerate()
        .filter(|(_, info)| !is_single(info) && info.count() > 0)
        .flat_map(|(index, info)| {
            column_names(info)
                .into_iter()
                .map(move |name| (index, name))
        })
        .collect();
    let more = all.len().saturating_sub(MOST_VECTORS);
    let named = &all[..all.len() - more];
    let mut vectors = Vec::new();
    for (index, name) in named {
        vectors.push((file.locate(name)?, &infos[*index]));
    }

    let mut rates = Rates {
        file_hz: file.stated_rate_hz(),
        scalars: singles
            .iter()
            .filter_map(|single| RateScalar::new(&single.name, single.number?))
            .collect(),
        times: Vec::new(),
    };
    for (vector, _) in &vectors {
        rates.times.extend(times(&mut file, vector)?);
    }
    let lengths: Vec<u64> = vectors.iter().map(|(vector, _)| vector.len()).collect();
    let mut portraits = Vec::new();
    for (done, (vector, info)) in vectors.iter().enumerate() {
        progress(done, vectors.len());
        let rate = rates.rate(vector.name(), vector.len(), vector.rate_hz(), &lengths);
        let excerpt = excerpt(&mut file, vector)?;
        let extremes = excerpt.extremes();
        let nature = nature(
            &excerpt,
            extremes.as_ref(),
            rate.as_ref().map(|rate| rate.hz),
            may_be_time(vector),
        );
        portraits.push(VectorPortrait {
            name: vector.name().to_owned(),
            element: info.element.to_string(),
            is_complex: vector.is_complex(),
            shape: shape(info),
            length: vector.len(),
            unit: vector.unit().map(str::to_owned),
            // A vector of times has the rate that it states.
            rate: rate.filter(|_| !matches!(nature, Nature::Time(_))),
            extremes,
            nature,
            course: excerpt.course(),
        });
    }
    Ok(FilePortrait {
        path: path.to_owned(),
        format: file.format().to_string(),
        notes: file.notes().to_vec(),
        vectors: portraits,
        singles,
        more,
    })
}

/// Returns the shape as `1000 × 3`.
fn shape(info: &ArrayInfo) -> String {
    let lengths: Vec<String> = info.shape.iter().map(u64::to_string).collect();
    match lengths.is_empty() {
        true => "1".to_owned(),
        false => lengths.join(" × "),
    }
}

/// Returns the names of the vectors of an array along its longest axis.
fn column_names(info: &ArrayInfo) -> Vec<String> {
    let long = info.shape.iter().filter(|length| **length != 1).count();
    if long <= 1 {
        let name = if info.name.is_empty() {
            "[:]"
        } else {
            &info.name
        };
        return vec![name.to_owned()];
    }
    let axis = (0..info.shape.len())
        .max_by_key(|axis| (info.shape[*axis], info.shape.len() - axis))
        .unwrap_or(0);
    let others: Vec<u64> = (0..info.shape.len())
        .filter(|other| *other != axis)
        .map(|other| info.shape[other])
        .collect();
    let count = others
        .iter()
        .fold(1, |count: u64, length| count.saturating_mul(*length));
    let name = |column: u64| {
        let mut rest = column;
        let mut indices: Vec<String> = Vec::new();
        for other in (0..info.shape.len()).rev() {
            if other == axis {
                indices.push(":".to_owned());
            } else {
                indices.push((rest % info.shape[other]).to_string());
                rest /= info.shape[other];
            }
        }
        indices.reverse();
        format!("{}[{}]", info.name, indices.join(","))
    };
    (0..count.min(MOST_COLUMNS)).map(name).collect()
}

fn single(file: &mut SourceFile, info: &ArrayInfo) -> SinglePortrait {
    let number = if info.element.is_numeric() || info.element == Element::Text {
        file.scalar(&info.name).ok()
    } else {
        None
    };
    let text = match (&info.unreadable, number) {
        (Some(class), _) => format!("object of the class {class}: not looked into"),
        (None, Some(number)) => statistics::significant(number),
        (None, None) => match file.text(&info.name) {
            Ok(Some(text)) => shortened(&text),
            _ => String::new(),
        },
    };
    SinglePortrait {
        name: info.name.clone(),
        element: info.element.to_string(),
        shape: shape(info),
        number,
        unit: info.unit.clone(),
        text,
    }
}

fn attribute(name: &str, value: &Attribute) -> SinglePortrait {
    let (number, text) = match value {
        Attribute::Number(number) => (Some(*number), statistics::significant(*number)),
        Attribute::Text(text) => (text.trim().parse().ok(), shortened(text)),
    };
    SinglePortrait {
        name: name.to_owned(),
        element: "attribute".to_owned(),
        shape: String::new(),
        number,
        unit: None,
        text,
    }
}

fn shortened(text: &str) -> String {
    let mut characters = text.trim().chars();
    let start: String = characters.by_ref().take(MOST_CHARACTERS).collect();
    let end = if characters.next().is_some() {
        "…"
    } else {
        ""
    };
    format!("\"{}{end}\"", escaping::escaped_line(&start))
}

/// Returns whether no unit of another quantity is stated.
fn may_be_time(vector: &Vector) -> bool {
    let unit = vector
        .unit()
        .map(str::to_owned)
        .or_else(|| names::unit_in_name(vector.name()));
    unit.is_none_or(|unit| TimeUnit::parse(&unit).is_some() || vector.element() == Element::Time)
}

/// Returns the vector as an array of times, if it begins as one and ends as one.
fn times(file: &mut SourceFile, vector: &Vector) -> Result<Option<Times>, SourceError> {
    let length = vector.len();
    if vector.is_complex() || length < 8 || !may_be_time(vector) {
        return Ok(None);
    }
    let mut head = Vec::new();
    file.read(vector, 0..length.min(HEAD), &mut head)?;
    let Some(axis) = time_axis(&head) else {
        return Ok(None);
    };
    let mut end = Vec::new();
    file.read(vector, length - 1..length, &mut end)?;
    let interval = (end[0] - head[0]) / (length - 1) as f64;
    // An encoder moves on at a steady pace for a while, but not to the end.
    if !((interval / axis.interval - 1.0).abs() < 0.2) {
        return Ok(None);
    }
    let unit = vector
        .unit()
        .map(str::to_owned)
        .or_else(|| names::unit_in_name(vector.name()));
    let stated = unit.and_then(|unit| TimeUnit::parse(&unit));
    let (likely, _) = axis.likely_unit(length);
    let unit = match vector.element() {
        Element::Time => TimeUnit::Seconds,
        _ => stated.unwrap_or(likely),
    };
    let is_named = matches!(names::role(vector.name()), Some((names::Role::Time, _)));
    let is_certain = is_named || stated.is_some() || axis.jitter < 1e-3;
    Ok(unit.seconds().filter(|_| is_certain).map(|seconds| Times {
        name: vector.name().to_owned(),
        length,
        rate_hz: 1.0 / (interval * seconds),
        unit,
    }))
}

/// Reads the stretches of a vector; of complex values the magnitudes.
fn excerpt(file: &mut SourceFile, vector: &Vector) -> Result<Excerpt, SourceError> {
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
) -> Result<Vec<f64>, SourceError> {
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
