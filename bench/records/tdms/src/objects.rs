//! Objects of a file, as its segments list them one after the other.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::channel::Channel;
use crate::chunk::{Chunk, Stored};
use crate::error::{SegmentDefect, UnreadContent};
use crate::metadata::{ListedObject, Samples, Storage};
use crate::pieces::{Piece, Stretch, pieces};
use crate::scale::Scales;
use crate::value::{SampleType, Value};

/// Most pieces of all channels; a file in that many is read for minutes and takes hundreds of megabytes.
const MOST_PIECES: usize = 1 << 21;

/// Objects as the segments read so far list them.
#[derive(Default)]
pub(crate) struct Objects {
    known: Vec<Object>,
    by_path: HashMap<String, usize>,
    /// Objects of the current segment, in their order in the chunk.
    current: Vec<usize>,
    /// Layout of the current objects' samples, and whether they are interleaved.
    chunk: Option<(Chunk, bool)>,
    piece_count: usize,
}

#[derive(Default)]
struct Object {
    path: String,
    properties: BTreeMap<String, Value>,
    storage: Option<Arc<Storage>>,
    /// Is in the current list.
    is_listed: bool,
    /// Has samples in the current segment.
    has_samples: bool,
    pieces: Vec<Piece>,
}

impl Objects {
    /// Takes over a segment's list.
    ///
    /// # Errors
    /// A description of an object that refers to samples which no segment describes.
    pub fn update(&mut self, listed: Vec<ListedObject>, has_new_list: bool) -> Result<(), String> {
        self.chunk = None;
        if has_new_list {
            for index in self.current.drain(..) {
                if let Some(object) = self.known.get_mut(index) {
                    object.is_listed = false;
                }
            }
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
            match samples {
                Samples::AsBefore if object.storage.is_none() => {
                    return Err(format!(
                        "{path} has samples as before, and there were none before"
                    ));
                }
                Samples::AsBefore => object.has_samples = true,
                Samples::None => object.has_samples = false,
                Samples::Stored(storage) => {
                    object.has_samples = true;
                    object.storage = Some(Arc::new(storage));
                }
            }
            // An object without samples keeps its place for a later segment.
            if !object.is_listed {
                object.is_listed = true;
                self.current.push(index);
            }
        }
        Ok(())
    }

    /// Adds the samples of a segment; returns whether its last chunk is cut.
    ///
    /// # Errors
    /// A description of samples that cannot be located.
    pub fn add_samples(
        &mut self,
        stretch: Stretch,
        is_interleaved: bool,
    ) -> Result<bool, SegmentDefect> {
        let chunk = match self.chunk.take() {
            Some((chunk, interleaved)) if interleaved == is_interleaved => chunk,
            _ => self.layout(is_interleaved)?,
        };
        let segment = pieces(&chunk, stretch)?;
        self.chunk = Some((chunk, is_interleaved));
        let with_samples = self.current.iter().filter(|index| {
            let object = self.known.get(**index);
            object.is_some_and(|object| object.has_samples)
        });
        let with_samples: Vec<usize> = with_samples.copied().collect();
        for (number, piece) in segment.pieces {
            let index = with_samples.get(number).copied();
            let Some(object) = index.and_then(|index| self.known.get_mut(index)) else {
                continue;
            };
            let last = object.pieces.last_mut();
            if !last.is_some_and(|last| last.continues_with(&piece)) {
                object.pieces.push(piece);
                self.piece_count += 1;
            }
        }
        if self.piece_count > MOST_PIECES {
            return Err(SegmentDefect::Unread {
                path: "the file".to_owned(),
                unread: UnreadContent {
                    content: format!("a file in more than {MOST_PIECES} pieces"),
                    remedy: "defragment it in LabVIEW (TDMS Defragment)",
                },
            });
        }
        Ok(segment.is_cut)
    }

    fn layout(&self, is_interleaved: bool) -> Result<Chunk, SegmentDefect> {
        let objects = self.current.iter().filter_map(|index| {
            let object = self.known.get(*index)?;
            object.has_samples.then_some(())?;
            let path = &object.path;
            let storage = object.storage.as_deref()?;
            Some(Stored { path, storage })
        });
        Chunk::new(&objects.collect::<Vec<_>>(), is_interleaved)
    }

    /// Returns the file's properties, and its channels.
    pub fn into_channels(self) -> (BTreeMap<String, Value>, Vec<Channel>) {
        let mut properties = BTreeMap::new();
        let mut group_properties: HashMap<String, BTreeMap<String, Value>> = HashMap::new();
        let mut channels = Vec::new();
        for object in self.known {
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
                properties
                    .keys()
                    .any(|key| key.starts_with("NI_Scale[") || key == "NI_Number_Of_Scales")
            };
            let scaled = [
                Some(&object.properties),
                group_properties.get(&group),
                Some(&properties),
            ];
            let scales = scaled.into_iter().flatten().find(|p| has_scales(p));
            let mut begin = 0;
            let begins = object.pieces.iter().map(|piece| {
                let first = begin;
                begin += piece.values();
                first
            });
            Channel {
                begins: begins.collect(),
                scales: scales.map_or_else(|| Ok(Scales::default()), Scales::read),
                sample_type: object.storage.as_deref().map(sample_type),
                group,
                name,
                properties: object.properties,
                pieces: object.pieces,
            }
        });
        let channels = channels.collect();
        (properties, channels)
    }
}

fn sample_type(storage: &Storage) -> SampleType {
    match storage {
        Storage::Plain { sample_type, .. } => *sample_type,
        Storage::Daqmx { scalers, .. } => match scalers.as_slice() {
            [scaler] => scaler.sample_type,
            _ => SampleType::Daqmx,
        },
    }
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
