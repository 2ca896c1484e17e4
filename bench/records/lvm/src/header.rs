//! Headers of the file and of its segments.

use std::collections::BTreeMap;

use text_tables::Separator;
use text_tables::layout::{Split, number, time_s};

use crate::error::LvmError;

/// Tag that ends a header.
pub(crate) const END: &str = "***End_of_Header***";
/// Tags around a block of another program.
pub(crate) const SPECIAL: [&str; 2] = ["***Start_Special***", "***End_Special***"];
/// First name of the line of names.
pub(crate) const X_NAME: &str = "X_Value";

/// Columns of x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum XColumns {
    /// No column; the first cell is empty.
    No,
    /// One before all channels.
    One,
    /// One before each channel.
    Multi,
}

/// Header of a file.
#[derive(Debug, Clone)]
pub(crate) struct FileHeader {
    pub(crate) split: Split,
    pub(crate) x_columns: XColumns,
    /// Decimal sign, where it is stated.
    pub(crate) has_commas: Option<bool>,
    /// Tags with their values.
    pub(crate) tags: BTreeMap<String, String>,
}

impl FileHeader {
    /// Reads the lines up to the end of the header.
    ///
    /// # Errors
    /// [`LvmError::Unread`] for a form that is not read.
    pub(crate) fn read(lines: &[String]) -> Result<Self, LvmError> {
        let split = split(lines)?;
        let mut tags = BTreeMap::new();
        for line in lines {
            if let [tag, value, ..] = split.cells(line).as_slice()
                && !value.is_empty()
            {
                tags.insert(tag.to_string(), value.to_string());
            }
        }
        let tag = |name: &str| tags.get(name).map(String::as_str);
        let x_columns = match tag("X_Columns") {
            Some("No") => XColumns::No,
            Some("One") | None => XColumns::One,
            Some("Multi") => XColumns::Multi,
            Some(other) => {
                return Err(LvmError::Unread {
                    content: format!("`X_Columns {other}` in the file's header"),
                    remedy: "save it with X_Columns No, One or Multi",
                });
            }
        };
        // A cell of its own separator is empty.
        let is_comma = |line: &String| line.starts_with("Decimal_Separator") && line.contains(",");
        let has_commas = match split {
            Split::At(Separator::Comma) => match tag("Decimal_Separator") {
                Some(".") => Some(false),
                Some(",") => return Err(two_commas()),
                _ if lines
                    .iter()
                    .any(|line| line.matches(',').count() > 1 && is_comma(line)) =>
                {
                    return Err(two_commas());
                }
                _ => None,
            },
            _ => tag("Decimal_Separator").map(|sign| sign == ","),
        };
        Ok(Self {
            split,
            x_columns,
            has_commas,
            tags,
        })
    }
}

fn two_commas() -> LvmError {
    LvmError::Unread {
        content: "a file in which commas separate cells and are decimal signs too".to_owned(),
        remedy: "save it with tabs between cells",
    }
}

/// Returns the separator, which also follows the tag that states it.
fn split(lines: &[String]) -> Result<Split, LvmError> {
    let stated = lines.iter().find_map(|line| line.strip_prefix("Separator"));
    let Some(stated) = stated else {
        return Ok(Split::At(Separator::Tab));
    };
    let separator = Separator::ALL
        .into_iter()
        .find(|separator| stated.starts_with(separator.character()));
    separator.map(Split::At).ok_or_else(|| LvmError::Unread {
        content: format!("`Separator{stated}` in the file's header"),
        remedy: "save it with tabs between cells",
    })
}

/// Column of a segment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SegmentColumn {
    pub(crate) name: String,
    /// Index of its cell in a row.
    pub(crate) cell: usize,
    /// Whether it is one of x.
    pub(crate) is_x: bool,
    pub(crate) unit: Option<String>,
    /// Interval of samples, where x is time, s.
    pub(crate) interval_s: Option<f64>,
    /// Greatest error of the interval, by the digits that it is written with, s.
    pub(crate) interval_error_s: f64,
    /// x of the first sample, s.
    pub(crate) x0_s: f64,
    /// Date and time of x = 0, s.
    pub(crate) clock_s: Option<f64>,
    /// Number of samples that the header states.
    pub(crate) samples: Option<u64>,
}

/// Reads the lines of a segment's header and its line of names.
pub(crate) fn segment_columns(
    file: &FileHeader,
    lines: &[String],
    names: &str,
) -> Vec<SegmentColumn> {
    let mut tags: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for line in lines {
        let mut cells = file.split.cells(line).into_iter().map(String::from);
        if let Some(tag) = cells.next() {
            tags.insert(tag, cells.collect());
        }
    }
    let names: Vec<String> = file
        .split
        .cells(names)
        .into_iter()
        .map(String::from)
        .collect();
    let stated = tags.get("Channels").and_then(|cells| cells.first());
    let stated = stated.and_then(|count| count.parse::<usize>().ok());
    let step = if file.x_columns == XColumns::Multi {
        2
    } else {
        1
    };
    let named = names.len().saturating_sub(1) + usize::from(step == 2);
    let named = match names.last().map(String::as_str) {
        Some("Comment") => named.saturating_sub(1),
        _ => named,
    };
    let channels = stated.unwrap_or(named / step).min(named / step);
    let value = |tag: &str, channel: usize| {
        let cells = tags.get(tag)?;
        // With a column of x for each channel, values stand above the channels' columns.
        let is_spread = step == 2 && cells.get(1).is_none_or(String::is_empty);
        let cell = cells.get(if is_spread { 2 * channel } else { channel })?;
        (!cell.is_empty()).then_some(cell.as_str())
    };
    let decimal = |tag: &str, channel| {
        let text = value(tag, channel)?;
        let mut numbers = file.split.numbers();
        if text.contains(',') {
            numbers.assume_commas();
        }
        number(text, &mut numbers).ok()
    };
    let x_cell = |channel: usize| match file.x_columns {
        XColumns::No => None,
        XColumns::One => (channel == 0).then_some(0),
        XColumns::Multi => Some(2 * channel),
    };
    let mut columns: Vec<SegmentColumn> = Vec::new();
    for channel in 0..channels {
        let is_time = value("X_Dimension", channel).is_none_or(|x| x == "Time");
        let clock = value("Time", channel).map(|time| time.replace(',', "."));
        let clock = value("Date", channel).zip(clock);
        let base = SegmentColumn {
            name: String::new(),
            cell: 0,
            is_x: false,
            unit: value("Y_Unit_Label", channel).map(str::to_owned),
            interval_s: decimal("Delta_X", channel).filter(|step| is_time && *step > 0.0),
            interval_error_s: value("Delta_X", channel).map_or(0.0, last_digit) / 2.0,
            x0_s: decimal("X0", channel)
                .filter(|x0| x0.is_finite())
                .unwrap_or(0.0),
            clock_s: clock.and_then(|(date, time)| time_s(&format!("{date} {time}"))),
            samples: value("Samples", channel).and_then(|count| count.parse().ok()),
        };
        let mut add = |cell: usize, is_x: bool, base: SegmentColumn| {
            let text = names.get(cell).map_or("", String::as_str);
            let name = match (text, is_x) {
                ("", true) => X_NAME.to_owned(),
                ("", false) => format!("channel {}", channel + 1),
                (text, _) => text.to_owned(),
            };
            let name = unique(name, &columns);
            columns.push(SegmentColumn {
                name,
                cell,
                is_x,
                ..base
            });
        };
        if let Some(cell) = x_cell(channel) {
            let stated = value("X_Unit_Label", channel).map(str::to_owned);
            let unit = stated.or_else(|| is_time.then(|| "s".to_owned()));
            let (interval_s, samples) = (None, None);
            let x = SegmentColumn {
                unit,
                interval_s,
                samples,
                ..base.clone()
            };
            add(cell, true, x);
        }
        add(step * channel + 1, false, base);
    }
    columns
}

/// Returns the value of the last digit of a number: 1e-6 of `0.000977`.
fn last_digit(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = mantissa
        .split_once(['.', ','])
        .map_or(0, |(_, decimals)| decimals.len());
    let exponent: i32 = exponent.parse().unwrap_or(0);
    10f64.powi(exponent.saturating_sub(i32::try_from(decimals).unwrap_or(0)))
}

/// Returns a name that no earlier column has: `x.1` for the second `x`.
fn unique(name: String, columns: &[SegmentColumn]) -> String {
    let is_taken = |name: &str| columns.iter().any(|column| column.name == name);
    if !is_taken(&name) {
        return name;
    }
    (1..)
        .map(|n| format!("{name}.{n}"))
        .find(|name| !is_taken(name))
        .unwrap_or(name)
}
