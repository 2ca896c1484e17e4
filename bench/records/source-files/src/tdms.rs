//! TDMS: channels as `group/channel`, properties as attributes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};
use std::ops::Range;

use num_complex::Complex64;
use tdms_files::{Channel, SampleType, TdmsError, TdmsFile, Value};

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::{SourceError, SourceFault};
use crate::format::{ArrayReader, Format, Place, Values};

/// Seconds from 1904, which TDMS counts from, to 1970 (UTC).
const SECONDS_TO_1970: f64 = 2_082_844_800.0;
/// Most attributes of a file that are kept.
const MOST_ATTRIBUTES: usize = 50_000;

/// Opens a TDMS file.
pub(crate) fn open(mut file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
    file.seek(SeekFrom::Start(0))?;
    let file = TdmsFile::open(BufReader::new(file)).map_err(refusal)?;
    let mut attributes = BTreeMap::new();
    add(&mut attributes, "/", file.properties());
    for channel in file.channels() {
        add(
            &mut attributes,
            &format!("/{}", channel.name()),
            channel.properties(),
        );
    }
    let mut notes = Vec::new();
    if file.is_truncated() {
        notes.push(
            "the file ends within a segment, as after a crash or a cut copy: its channels are read as far as they go"
                .to_owned(),
        );
    }
    Ok(Box::new(TdmsReader {
        arrays: file.channels().iter().map(info).collect(),
        file,
        attributes,
        notes,
    }))
}

struct TdmsReader {
    file: TdmsFile<BufReader<File>>,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

fn add(
    attributes: &mut BTreeMap<String, Attribute>,
    object: &str,
    properties: &BTreeMap<String, Value>,
) {
    for (name, value) in properties {
        let is_scale = name.starts_with("NI_Scale[");
        if is_scale || attributes.len() >= MOST_ATTRIBUTES {
            continue;
        }
        let value = match value {
            Value::Number(number) => Attribute::Number(*number),
            Value::Text(text) => Attribute::Text(text.clone()),
        };
        attributes.insert(format!("{object}@{name}"), value);
    }
}

fn info(channel: &Channel) -> ArrayInfo {
    let shape = vec![channel.length()];
    let mut info = ArrayInfo::new(channel.name(), element(channel), shape);
    info.unit = channel.unit().map(str::to_owned);
    info.rate_hz = channel.rate_hz();
    // The waveform begins at a time of the day, where the file states one.
    let begin_s = channel.start_time_s().unwrap_or(0.0);
    info.start_s = info.rate_hz.map(|_| begin_s + channel.start_s());
    info.unreadable = match channel.sample_type() {
        Some(SampleType::Text) => None,
        _ => channel.unread().map(|unread| unread.content),
    };
    info
}

fn element(channel: &Channel) -> Element {
    let integer = |bits, is_signed| Element::Integer { bits, is_signed };
    match channel.sample_type() {
        _ if channel.is_scaled() => Element::Float { bits: 64 },
        Some(SampleType::I8) => integer(8, true),
        Some(SampleType::I16) => integer(16, true),
        Some(SampleType::I32) => integer(32, true),
        Some(SampleType::I64) => integer(64, true),
        Some(SampleType::U8) => integer(8, false),
        Some(SampleType::U16) => integer(16, false),
        Some(SampleType::U32) => integer(32, false),
        Some(SampleType::U64) => integer(64, false),
        Some(SampleType::F32) => Element::Float { bits: 32 },
        Some(SampleType::Boolean) => Element::Logical,
        Some(SampleType::Timestamp) => Element::Time,
        Some(SampleType::Complex64) => Element::Complex { bits: 32 },
        Some(SampleType::Complex128) => Element::Complex { bits: 64 },
        Some(SampleType::Text) => Element::Text,
        Some(
            SampleType::F64
            | SampleType::Daqmx
            | SampleType::Other(_)
            | SampleType::OtherOfDaqmx(_),
        )
        | None => Element::Float { bits: 64 },
    }
}

fn refusal(error: TdmsError) -> SourceError {
    match error {
        TdmsError::Io(error) => error.into(),
        TdmsError::OtherFormat { .. } => {
            SourceError::damaged("byte 0", "it does not begin as a TDMS file does")
        }
        TdmsError::Index => SourceFault::Foreign {
            kind: "the index of a TDMS file".to_owned(),
            remedy: "name the .tdms file next to it",
        }
        .into(),
        TdmsError::Damaged {
            segment,
            byte,
            defect,
        } => SourceError::damaged(format!("segment {segment}, byte {byte}"), defect),
        TdmsError::NoChannel { index } => {
            SourceError::damaged(format!("channel {index}"), "it is missing")
        }
        TdmsError::Unsupported { channel, unread } => {
            let tdms_files::UnreadContent { content, remedy } = unread;
            SourceError::at(
                format!("channel `{channel}`"),
                SourceFault::Unread { content, remedy },
            )
        }
        TdmsError::Complex { channel: name } => SourceFault::Complex { name }.into(),
    }
}

impl ArrayReader for TdmsReader {
    fn format(&self) -> Format {
        Format::Tdms
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    /// Returns the rate of all channels that state one, if they agree.
    fn stated_rate_hz(&self) -> Option<f64> {
        let mut rates = self.arrays.iter().filter_map(|info| info.rate_hz);
        let first = rates.next()?;
        rates.all(|rate| rate == first).then_some(first)
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn read(
        &mut self,
        index: usize,
        _place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let info = self.arrays.get(index);
        let is_time = info.is_some_and(|info| info.element == Element::Time);
        let origin_s = if is_time { SECONDS_TO_1970 } else { 0.0 };
        match values {
            Values::Real(values) => {
                let before = values.len();
                self.file.read(index, range, values).map_err(refusal)?;
                for value in values.iter_mut().skip(before) {
                    *value -= origin_s;
                }
            }
            Values::Complex(values) => {
                let mut parts = Vec::new();
                self.file
                    .read_complex(index, range, &mut parts)
                    .map_err(refusal)?;
                let parts = parts.into_iter();
                values.extend(parts.map(|[re, im]| Complex64::new(re - origin_s, im)));
            }
        }
        Ok(())
    }
}
