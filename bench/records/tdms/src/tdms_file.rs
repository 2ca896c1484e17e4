//! A file: its segments joined to channels, and samples read from it.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use crate::channel::Channel;
use crate::error::TdmsError;
use crate::lead_in::{LEAD_IN_BYTES, LeadIn, Start};
use crate::metadata::{self, ListedObject, Samples, Storage};
use crate::pieces::{Piece, Stretch, pieces};
use crate::scale::Scales;
use crate::value::{SampleType, Value};

/// Most bytes of metadata in one segment; LabVIEW writes some hundred.
const MOST_METADATA_BYTES: u64 = 64 << 20;
/// Bytes that are read at once.
const BLOCK_BYTES: u64 = 1 << 20;

/// A TDMS file, open for reading.
pub struct TdmsFile<R> {
    source: R,
    properties: BTreeMap<String, Value>,
    channels: Vec<Channel>,
    is_truncated: bool,
}

impl<R> fmt::Debug for TdmsFile<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TdmsFile")
            .field("channels", &self.channels)
            .field("is_truncated", &self.is_truncated)
            .finish_non_exhaustive()
    }
}

/// Objects as the segments read so far list them.
#[derive(Default)]
struct Objects {
    /// Path, and what is known of the object.
    known: Vec<Object>,
    by_path: HashMap<String, usize>,
    /// Objects with samples in the current segment, in their order in the chunk.
    current: Vec<usize>,
}

#[derive(Default)]
struct Object {
    path: String,
    properties: BTreeMap<String, Value>,
    storage: Option<Arc<Storage>>,
    pieces: Vec<Piece>,
}

impl Objects {
    /// Takes over a segment's list.
    fn update(&mut self, listed: Vec<ListedObject>, has_new_list: bool) -> Result<(), String> {
        if has_new_list {
            self.current.clear();
        }
        for ListedObject {
            path,
            samples,
            properties,
        } in listed
        {
            let index = *self.by_path.entry(path.clone()).or_insert_with(|| {
                self.known.push(Object {
                    path: path.clone(),
                    ..Object::default()
                });
                self.known.len() - 1
            });
            let Some(object) = self.known.get_mut(index) else {
                continue;
            };
            object.properties.extend(properties);
            let has_samples = match samples {
                Samples::None => false,
                Samples::AsBefore if object.storage.is_none() => {
                    return Err(format!(
                        "{path} has samples as before, and there were none before"
                    ));
                }
                Samples::AsBefore => true,
                Samples::Stored(storage) => {
                    object.storage = Some(Arc::new(storage));
                    true
                }
            };
            match (has_samples, self.current.contains(&index)) {
                (true, false) => self.current.push(index),
                (false, true) => self.current.retain(|other| *other != index),
                (true, true) | (false, false) => {}
            }
        }
        Ok(())
    }

    /// Adds the pieces of a segment; returns whether its last chunk is cut.
    fn add_samples(&mut self, stretch: Stretch) -> Result<bool, String> {
        let storages: Vec<Arc<Storage>> = self
            .current
            .iter()
            .filter_map(|index| self.known.get(*index)?.storage.clone())
            .collect();
        let (pieces, is_cut) = pieces(&storages, stretch)?;
        for (index, pieces) in self.current.iter().zip(pieces) {
            if let Some(object) = self.known.get_mut(*index) {
                object.pieces.extend(pieces);
            }
        }
        Ok(is_cut)
    }
}

impl<R: Read + Seek> TdmsFile<R> {
    /// Reads the metadata of all segments.
    ///
    /// # Errors
    /// [`TdmsError`] for a file of another format, or damaged metadata, with the segment and the place. A last segment that is cut is
    /// no error: [`Self::is_truncated`].
    pub fn open(mut source: R) -> Result<Self, TdmsError> {
        let length = source.seek(SeekFrom::End(0))?;
        let mut objects = Objects::default();
        let mut is_truncated = false;
        let (mut byte, mut segment) = (0, 0);
        while byte < length {
            segment += 1;
            let damaged = |byte: u64, defect: String| TdmsError::Damaged {
                segment,
                byte,
                defect,
            };
            if length - byte < LEAD_IN_BYTES && segment > 1 {
                is_truncated = true;
                break;
            }
            let lead_in = match lead_in(&mut source, byte)? {
                Start::Segment(lead_in) => lead_in,
                Start::Index => return Err(TdmsError::Index),
                Start::Other if segment == 1 => return Err(other_format(&mut source)?),
                Start::Other => {
                    return Err(damaged(byte, "no segment begins here".to_owned()));
                }
            };
            let content = byte + LEAD_IN_BYTES;
            let stated_end = lead_in
                .segment_bytes
                .map(|bytes| content.saturating_add(bytes));
            let end = stated_end.unwrap_or(length).min(length);
            let is_unfinished = stated_end.is_none_or(|stated| stated > length);
            is_truncated |= is_unfinished;
            let samples_begin = content.saturating_add(lead_in.metadata_bytes);
            if samples_begin > end {
                if is_unfinished {
                    break;
                }
                return Err(damaged(
                    byte,
                    "metadata longer than their segment".to_owned(),
                ));
            }
            if lead_in.has_metadata {
                let listed = listed_objects(&mut source, content, &lead_in)
                    .map_err(|problem| problem.into_error(&damaged))?;
                objects
                    .update(listed, lead_in.has_new_list)
                    .map_err(|defect| damaged(content, defect))?;
            }
            if lead_in.has_samples {
                let stretch = Stretch {
                    begin: samples_begin,
                    end,
                    is_interleaved: lead_in.is_interleaved,
                    is_big_endian: lead_in.is_big_endian,
                    is_unfinished,
                };
                is_truncated |= objects
                    .add_samples(stretch)
                    .map_err(|defect| damaged(samples_begin, defect))?;
            }
            byte = end;
        }
        if segment == 0 {
            return Err(TdmsError::OtherFormat { first: Vec::new() });
        }
        Ok(Self::joined(source, objects, is_truncated))
    }

    fn joined(source: R, objects: Objects, is_truncated: bool) -> Self {
        let mut properties = BTreeMap::new();
        let mut group_properties: HashMap<String, BTreeMap<String, Value>> = HashMap::new();
        let mut channels = Vec::new();
        for object in objects.known {
            let mut names = path_names(&object.path).into_iter();
            match (names.next(), names.next()) {
                (None, _) => properties = object.properties,
                (Some(group), None) => {
                    group_properties.insert(group, object.properties);
                }
                (Some(group), Some(name)) => channels.push((group, name, object)),
            }
        }
        let channels = channels.into_iter().map(|(group, name, object)| {
            // A channel without scales takes those of its group, then of the file.
            let has_scales = |properties: &BTreeMap<String, Value>| {
                properties.keys().any(|key| key.starts_with("NI_Scale["))
            };
            let scaled = [
                Some(&object.properties),
                group_properties.get(&group),
                Some(&properties),
            ];
            let scales = scaled.into_iter().flatten().find(|p| has_scales(p));
            let mut begin = 0;
            let begins = object
                .pieces
                .iter()
                .map(|piece| {
                    let first = begin;
                    begin += piece.values;
                    first
                })
                .collect();
            Channel {
                scales: scales.map_or_else(|| Ok(Scales::default()), Scales::read),
                sample_type: object.storage.as_deref().map(|storage| match storage {
                    Storage::Plain { sample_type, .. } => *sample_type,
                    Storage::Daqmx { .. } => SampleType::Daqmx,
                }),
                group,
                name,
                properties: object.properties,
                pieces: object.pieces,
                begins,
            }
        });
        Self {
            channels: channels.collect(),
            source,
            properties,
            is_truncated,
        }
    }

    /// Returns the file's own properties.
    #[must_use]
    pub fn properties(&self) -> &BTreeMap<String, Value> {
        &self.properties
    }

    /// Returns the channels in the order of the file.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Returns whether the file ends within a segment or a chunk, as after a crash or a copy that was cut.
    #[must_use]
    pub fn is_truncated(&self) -> bool {
        self.is_truncated
    }

    /// Appends samples of a channel, in its unit, to `samples`; `stretch` counts samples from 0 and may end beyond the last.
    ///
    /// # Errors
    /// [`TdmsError`] for a channel that does not exist or is not made of real numbers, and for a disk that does not return its data.
    pub fn read(
        &mut self,
        name: &str,
        stretch: Range<u64>,
        samples: &mut Vec<f64>,
    ) -> Result<(), TdmsError> {
        let channel = self
            .channels
            .iter()
            .find(|channel| channel.name() == name)
            .ok_or_else(|| TdmsError::NoChannel {
                name: name.to_owned(),
            })?;
        let unsupported = |reason: String| TdmsError::Unsupported {
            channel: name.to_owned(),
            reason,
        };
        let scales = channel.scales.clone().map_err(unsupported)?;
        let is_number = |sample_type| {
            !matches!(
                sample_type,
                SampleType::Text | SampleType::Complex64 | SampleType::Complex128
            )
        };
        if let Some(other) = channel.sample_type.filter(|kind| !is_number(*kind)) {
            return Err(unsupported(format!("its samples are of type {other:?}")));
        }
        let first = channel
            .begins
            .partition_point(|begin| *begin <= stretch.start);
        let pieces = channel.pieces.iter().zip(&channel.begins);
        for (piece, begin) in pieces.skip(first.saturating_sub(1)) {
            if *begin >= stretch.end {
                break;
            }
            let from = stretch.start.saturating_sub(*begin).min(piece.values);
            let to = (stretch.end - begin).min(piece.values);
            read_piece(&mut self.source, piece, from..to, &scales, samples)?;
        }
        Ok(())
    }
}

/// Reads rows of a piece, a block at a time.
fn read_piece<R: Read + Seek>(
    source: &mut R,
    piece: &Piece,
    rows: Range<u64>,
    scales: &Scales,
    samples: &mut Vec<f64>,
) -> Result<(), TdmsError> {
    let rows_per_block = (BLOCK_BYTES / piece.row_bytes).max(1);
    let mut stored = Vec::with_capacity(piece.fields.len());
    let mut block = Vec::new();
    let mut row = rows.start;
    while row < rows.end {
        let count = rows_per_block.min(rows.end - row);
        source.seek(SeekFrom::Start(piece.byte + row * piece.row_bytes))?;
        // The last row of an interleaved channel may end with its own sample.
        block.clear();
        source
            .by_ref()
            .take(count * piece.row_bytes)
            .read_to_end(&mut block)?;
        for bytes in block.chunks(piece.row_bytes as usize).take(count as usize) {
            stored.clear();
            for field in piece.fields.iter() {
                let number = bytes
                    .get(field.offset as usize..)
                    .and_then(|bytes| field.sample_type.number(bytes, piece.is_big_endian));
                let number = match (number, field.bit) {
                    (Some(number), Some(bit)) => f64::from(number as u32 >> bit & 1),
                    (number, _) => number.unwrap_or(f64::NAN),
                };
                stored.push((field.scale_id, number));
            }
            samples.push(scales.apply(&stored));
        }
        row += count;
    }
    Ok(())
}

fn lead_in<R: Read + Seek>(source: &mut R, byte: u64) -> Result<Start, TdmsError> {
    let mut bytes = [0; LEAD_IN_BYTES as usize];
    source.seek(SeekFrom::Start(byte))?;
    let mut read = Vec::new();
    source.by_ref().take(LEAD_IN_BYTES).read_to_end(&mut read)?;
    if read.len() < bytes.len() {
        return Ok(Start::Other);
    }
    bytes.copy_from_slice(&read);
    Ok(Start::read(&bytes))
}

fn other_format<R: Read + Seek>(source: &mut R) -> Result<TdmsError, TdmsError> {
    source.seek(SeekFrom::Start(0))?;
    let mut first = Vec::new();
    source.by_ref().take(8).read_to_end(&mut first)?;
    Ok(TdmsError::OtherFormat { first })
}

/// Why a segment's metadata cannot be read.
enum Problem {
    Disk(std::io::Error),
    Defect(u64, String),
}

impl Problem {
    fn into_error(self, damaged: &dyn Fn(u64, String) -> TdmsError) -> TdmsError {
        match self {
            Self::Disk(error) => error.into(),
            Self::Defect(byte, defect) => damaged(byte, defect),
        }
    }
}

fn listed_objects<R: Read + Seek>(
    source: &mut R,
    content: u64,
    lead_in: &LeadIn,
) -> Result<Vec<ListedObject>, Problem> {
    if lead_in.metadata_bytes > MOST_METADATA_BYTES {
        let defect = format!("{} bytes of metadata", lead_in.metadata_bytes);
        return Err(Problem::Defect(content, defect));
    }
    let mut bytes = Vec::new();
    source
        .seek(SeekFrom::Start(content))
        .and_then(|_| {
            source
                .by_ref()
                .take(lead_in.metadata_bytes)
                .read_to_end(&mut bytes)
        })
        .map_err(Problem::Disk)?;
    metadata::read(&bytes, lead_in.is_big_endian)
        .map_err(|(byte, defect)| Problem::Defect(content + byte, defect))
}

/// Returns the names in a path such as `/'group'/'channel'`, in which `''` is a quote.
fn path_names(path: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut rest = path;
    while let Some(quoted) = rest.trim_start_matches('/').strip_prefix('\'') {
        let mut name = String::new();
        let mut characters = quoted.char_indices().peekable();
        let mut end = quoted.len();
        while let Some((index, character)) = characters.next() {
            if character != '\'' {
                name.push(character);
            } else if characters.next_if(|(_, next)| *next == '\'').is_some() {
                name.push('\'');
            } else {
                end = index + 1;
                break;
            }
        }
        names.push(name);
        rest = quoted.get(end..).unwrap_or("");
    }
    names
}
