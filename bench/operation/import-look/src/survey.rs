//! Reading of a file by stretches.

mod reading;
mod times;

use std::path::Path;

use source_files::{ArrayInfo, Attribute, Element, SourceError, SourceFile, Vector};

use crate::nature::{Nature, nature};
use crate::portrait::{
    FilePortrait, RateOrigin, SinglePortrait, StatedRate, StreamStart, VectorPortrait,
};
use crate::rates::{RateScalar, Rates};
use crate::stated;
use reading::excerpt;
use times::{may_be_time, times};

/// Most vectors of a file that are looked at, and most columns of one array.
const MOST_VECTORS: usize = 256;
const MOST_COLUMNS: u64 = 24;
/// Most characters of a text that are shown.
const MOST_CHARACTERS: usize = 60;

/// Looks at a file; `progress` is called with the number of vectors done and the number of all.
///
/// # Errors
/// The file cannot be opened.
pub(crate) fn survey(
    path: &Path,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<FilePortrait, Box<SourceError>> {
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
        scalars: rate_scalars(&singles, &vectors),
        times: Vec::new(),
    };
    let scalar_hz: Vec<f64> = rates.scalars.iter().map(|scalar| scalar.hz).collect();
    let every: Vec<(&Vector, f64)> = vectors
        .iter()
        .map(|(vector, info)| {
            let is_whole = matches!(info.element, Element::Integer { .. });
            let scaling = stated::scaling(&info.name, is_whole, &singles);
            (vector, scaling.map_or(1.0, |scaling| scaling.factor))
        })
        .collect();
    rates.times = times(&mut file, &every, &scalar_hz);
    let lengths: Vec<u64> = vectors.iter().map(|(vector, _)| vector.len()).collect();
    let mut portraits = Vec::new();
    for (done, (vector, info)) in vectors.iter().enumerate() {
        progress(done, vectors.len());
        let recording_rates = rates.within_recording(vector.name());
        let rate = recording_rates.rate(vector.name(), vector.len(), vector.rate_hz(), &lengths);
        let mut portrait = VectorPortrait {
            name: vector.name().to_owned(),
            element: info.element.to_string(),
            is_complex: vector.is_complex(),
            shape: shape(info),
            length: vector.len(),
            unit: vector.unit().map(str::to_owned),
            times_unit: rates.times_unit(vector.name()),
            ..VectorPortrait::default()
        };
        match excerpt(&mut file, vector) {
            Ok(excerpt) => {
                let rate_hz = rate.as_ref().map(|rate| rate.hz);
                portrait.extremes = excerpt.extremes();
                portrait.nature = nature(
                    &excerpt,
                    portrait.extremes.as_ref(),
                    rate_hz,
                    may_be_time(vector),
                );
                portrait.course = excerpt.course();
                portrait.leap = excerpt.leap();
                let is_whole = matches!(info.element, Element::Integer { .. })
                    || excerpt.values().all(|value| value.fract() == 0.0);
                portrait.is_whole = is_whole;
                portrait.scaling = stated::scaling(&info.name, is_whole, &singles);
                if let (Nature::Time(axis), Some(scaling)) =
                    (&mut portrait.nature, &portrait.scaling)
                {
                    axis.interval *= scaling.factor;
                }
                portrait.unit = portrait
                    .unit
                    .or_else(|| portrait.scaling.as_ref()?.unit.clone());
                if matches!(portrait.nature, Nature::Slow(_)) {
                    portrait.fine = rate_hz.and_then(|rate_hz| excerpt.fine(rate_hz));
                }
            }
            Err(error) => portrait.nature = Nature::Unread(error.to_string()),
        }
        portrait.start = start(&singles, info, rate.as_ref());
        // A vector of times has the rate that it states.
        portrait.rate = rate.filter(|_| !matches!(portrait.nature, Nature::Time(_)));
        portraits.push(portrait);
    }
    Ok(FilePortrait {
        path: path.to_owned(),
        format: file.format().to_string(),
        notes: stated::notes(&file),
        vectors: portraits,
        singles: stated::without_invented(singles, &file),
        more,
    })
}

/// Smallest number of seconds that may be a date, s.
const TIME_OF_DAY_S: f64 = 1e8;

/// Returns the scalars that state rates.
fn rate_scalars(singles: &[SinglePortrait], vectors: &[(Vector, &ArrayInfo)]) -> Vec<RateScalar> {
    let names: Vec<(&str, u64)> = vectors
        .iter()
        .map(|(vector, _)| (vector.name(), vector.len()))
        .collect();
    singles
        .iter()
        .filter_map(|single| RateScalar::new(&single.name, single.number?, &names))
        .collect()
}

/// Returns the start of a vector's samples, as its times or an attribute of it state.
fn start(
    singles: &[SinglePortrait],
    info: &ArrayInfo,
    rate: Option<&StatedRate>,
) -> Option<StreamStart> {
    if let Some(RateOrigin::Times(times)) = rate.map(|rate| &rate.origin) {
        return Some(times.start);
    }
    let attribute = |name: &str| {
        let name = format!("/{}@{name}", info.name);
        singles.iter().find(|single| single.name == name)?.number
    };
    let begin_s = attribute("wf_start_time")?;
    Some(StreamStart {
        begin_s: begin_s + attribute("wf_start_offset").unwrap_or(0.0),
        is_of_day: true,
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
        .filter(|index| *index != axis)
        .map(|index| info.shape[index])
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
        (Some(content), _) if info.remedy.is_some() => {
            format!("{content}, not read: {}", info.remedy.unwrap_or_default())
        }
        (Some(class), _) => format!("object of the class {class}: not looked into"),
        (None, Some(number)) => printed(number),
        (None, None) => match file.text(&info.name) {
            Ok(Some(text)) => shortened(&text),
            _ => first_text(file, info),
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

/// Returns the first cell that makes a column of numbers one of texts.
fn first_text(file: &SourceFile, info: &ArrayInfo) -> String {
    match file.locate(&info.name) {
        Err(SourceError {
            place: Some(place),
            fault,
            ..
        }) => format!("{place}: {fault}"),
        _ => String::new(),
    }
}

fn attribute(name: &str, value: &Attribute) -> SinglePortrait {
    let (number, text) = match value {
        Attribute::Number(number) => (Some(*number), printed(*number)),
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

/// Returns a number in few digits; a time of the day, in seconds, with all of them.
fn printed(number: f64) -> String {
    if number.is_finite() && (TIME_OF_DAY_S..1e15).contains(&number.abs()) {
        return number.to_string();
    }
    statistics::significant(number)
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
