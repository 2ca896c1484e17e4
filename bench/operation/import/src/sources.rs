//! Source files of a recording, opened, with their sums.

use std::collections::BTreeMap;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use import_map::{
    ArraySource, Electrical, ImportMap, Intervals, NamedFile, Rate, Template, TimeBase,
};
use num_complex::Complex64;
use rayon::prelude::*;
use recording::manifest::ImportedSource;
use sha2::{Digest, Sha256};
use source_files::{SourceFile, Vector};

use crate::refusal::ImportRefusal;

/// Values read at a time.
pub(crate) const BLOCK: u64 = 1 << 16;
/// Relative difference beyond which two rates differ.
const SAME_RATE: f64 = 1e-3;

/// Source files of a recording.
pub(crate) struct Sources<'a> {
    folder: &'a Path,
    /// Files that the map's pattern matches: one, or the parts of the recording.
    file: &'a NamedFile,
    files: BTreeMap<String, SourceFile>,
    other_files: BTreeMap<String, String>,
}

/// Array of a stream: of a source file, or of several that follow each other.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    /// Files, relative to the map's folder, in their order.
    pub files: Vec<String>,
    /// Array of each file.
    vectors: Vec<Vector>,
    length: u64,
}

impl Column {
    /// Returns the number of values.
    pub fn len(&self) -> u64 {
        self.length
    }

    /// Returns the name of the array, with its files.
    pub fn name(&self) -> String {
        format!("{} in {}", self.vectors[0].name(), self.place())
    }

    /// Returns the time of the first sample that the file states, s.
    pub fn start_s(&self) -> Option<f64> {
        self.vectors[0].start_s()
    }

    /// Returns the names of the files.
    pub fn place(&self) -> String {
        match self.files.as_slice() {
            [first, .., last] => format!("{first} to {last}"),
            files => files.concat(),
        }
    }

    /// Returns the overlap of a stretch with each file: the index of the file, and the stretch within its array.
    fn pieces(&self, range: Range<u64>) -> Vec<(usize, Range<u64>)> {
        let mut first = 0;
        let mut pieces = Vec::new();
        for (index, vector) in self.vectors.iter().enumerate() {
            let end = first + vector.len();
            let piece = range.start.max(first)..range.end.min(end);
            if piece.start < piece.end {
                pieces.push((index, piece.start - first..piece.end - first));
            }
            first = end;
        }
        pieces
    }
}

impl<'a> Sources<'a> {
    /// Creates the sources of a recording.
    pub fn new(folder: &'a Path, file: &'a NamedFile) -> Self {
        Self {
            folder,
            file,
            files: BTreeMap::new(),
            other_files: BTreeMap::new(),
        }
    }

    /// Returns the names of a stream's files, in their order: those that the map's pattern matches, or, of a template, one for each
    /// part that it names.
    pub fn file_names(&self, source: Option<&Template>) -> Vec<String> {
        file_names(self.file, source)
    }

    /// Returns the name of a file that a recording has once.
    pub fn file_name(&self, template: &Template) -> String {
        template.fill(&self.file.captures)
    }

    fn open(&mut self, file: &str) -> Result<&mut SourceFile, ImportRefusal> {
        if !self.files.contains_key(file) {
            let opened = SourceFile::open(&self.folder.join(file))?;
            self.files.insert(file.to_owned(), opened);
        }
        match self.files.get_mut(file) {
            Some(opened) => Ok(opened),
            None => unreachable!("the file was inserted"),
        }
    }

    /// Opens every file that a map names, so that their sums are known before they are read.
    pub fn open_all(&mut self, map: &ImportMap) -> Result<(), ImportRefusal> {
        let mut templates: Vec<Option<&Template>> = Vec::new();
        match &map.electrical {
            Electrical::Signals {
                drive,
                pickup,
                baseline,
                ..
            } => {
                templates.extend([drive.source.file.as_ref(), pickup.source.file.as_ref()]);
                templates.extend(baseline.as_ref().map(Some));
            }
            Electrical::Envelopes { envelopes, .. } => templates.push(envelopes.file.as_ref()),
            Electrical::Stimulus(Some(drive)) => templates.push(drive.source.file.as_ref()),
            Electrical::Stimulus(None) => {}
        }
        templates.extend(
            map.normal
                .as_ref()
                .map(|normal| normal.source.file.as_ref()),
        );
        templates.extend(
            map.lateral
                .as_ref()
                .map(|lateral| lateral.source.file.as_ref()),
        );
        templates.extend(
            map.position
                .as_ref()
                .map(|position| position.source.file.as_ref()),
        );
        for template in templates {
            for file in self.file_names(template) {
                self.open(&file)?;
            }
        }
        if let Intervals::Marks(template) = &map.intervals {
            let file = self.file_name(template);
            self.text(&file, "text-tables")?;
        }
        Ok(())
    }

    /// Finds the array of a stream.
    pub fn column(&mut self, source: &ArraySource) -> Result<Column, ImportRefusal> {
        let files = self.file_names(source.file.as_ref());
        self.column_in(&files, &source.name)
    }

    /// Finds an array by its name in files that follow each other.
    pub fn column_in(&mut self, files: &[String], name: &str) -> Result<Column, ImportRefusal> {
        let vectors = files
            .iter()
            .map(|file| Ok(self.open(file)?.locate(name)?))
            .collect::<Result<Vec<Vector>, ImportRefusal>>()?;
        Ok(Column {
            files: files.to_vec(),
            length: vectors.iter().map(Vector::len).sum(),
            vectors,
        })
    }

    /// Appends a stretch of an array.
    pub fn read(
        &mut self,
        column: &Column,
        range: Range<u64>,
        values: &mut Vec<f64>,
    ) -> Result<(), ImportRefusal> {
        for (index, piece) in column.pieces(range) {
            self.open(&column.files[index])?
                .read(&column.vectors[index], piece, values)?;
        }
        Ok(())
    }

    /// Appends a stretch of a complex array.
    pub fn read_complex(
        &mut self,
        column: &Column,
        range: Range<u64>,
        values: &mut Vec<Complex64>,
    ) -> Result<(), ImportRefusal> {
        for (index, piece) in column.pieces(range) {
            self.open(&column.files[index])?
                .read_complex(&column.vectors[index], piece, values)?;
        }
        Ok(())
    }

    /// Calls `take` with consecutive blocks of an array and the index of each block's first value.
    pub fn for_each_block(
        &mut self,
        column: &Column,
        mut take: impl FnMut(u64, &[f64]) -> Result<(), ImportRefusal>,
    ) -> Result<(), ImportRefusal> {
        let mut values = Vec::new();
        for start in (0..column.len()).step_by(BLOCK as usize) {
            values.clear();
            self.read(
                column,
                start..(start + BLOCK).min(column.len()),
                &mut values,
            )?;
            take(start, &values)?;
        }
        Ok(())
    }

    /// Returns the rate of a stream, Hz; `table` names its table in errors.
    pub fn rate_hz(
        &mut self,
        rate: &Rate,
        column: &Column,
        table: &str,
    ) -> Result<f64, ImportRefusal> {
        let key = format!("{table}.rate_hz");
        let mut hz = f64::NAN;
        for (index, file) in column.files.iter().enumerate() {
            let part_hz = self.part_rate_hz(rate, column, index, &key)?;
            if index == 0 {
                hz = part_hz;
            } else if (part_hz / hz - 1.0).abs() > SAME_RATE {
                return Err(ImportRefusal::OtherRate {
                    key,
                    stated_hz: hz,
                    file: file.clone(),
                    file_hz: part_hz,
                });
            }
        }
        if !(hz.is_finite() && hz > 0.0) {
            return Err(ImportRefusal::Rate {
                key,
                hz,
                remedy: "a rate is a positive number in Hz",
            });
        }
        Ok(hz)
    }

    /// Returns the rate of a stream in one of its files, Hz.
    fn part_rate_hz(
        &mut self,
        rate: &Rate,
        column: &Column,
        index: usize,
        key: &str,
    ) -> Result<f64, ImportRefusal> {
        let file = &column.files[index];
        let main = self.main_of(index).to_owned();
        let stated_hz = column.vectors[index]
            .rate_hz()
            .or(self.open(file)?.stated_rate_hz());
        let hz = match rate {
            Rate::Hz(hz) => *hz,
            Rate::File => stated_hz.ok_or_else(|| ImportRefusal::NoRate {
                key: key.to_owned(),
                file: file.clone(),
            })?,
            Rate::Scalar(name) => match self.open(file)?.scalar(name) {
                Err(_) if *file != main => self.open(&main)?.scalar(name)?,
                result => result?,
            },
        };
        match stated_hz {
            Some(file_hz) if (hz / file_hz - 1.0).abs() > SAME_RATE => {
                Err(ImportRefusal::OtherRate {
                    key: key.to_owned(),
                    stated_hz: hz,
                    file: file.clone(),
                    file_hz,
                })
            }
            _ => Ok(hz),
        }
    }

    /// Returns the path that the map's pattern matches for a part of a stream; a stream in one file takes the first.
    fn main_of(&self, index: usize) -> &str {
        self.file.paths().nth(index).unwrap_or(&self.file.path)
    }

    /// Finds the array of a stream's times, and its unit, s; `table` names the stream's table in errors.
    pub fn time_column(
        &mut self,
        (column, table): (&Column, &str),
        name: &str,
        seconds_per_unit: Option<f64>,
    ) -> Result<(Column, f64), ImportRefusal> {
        let mains = self.file_names(None);
        let times = match self.column_in(&column.files, name) {
            Err(_) if column.files != mains => self.column_in(&mains, name)?,
            result => result?,
        };
        if times.len() != column.len() {
            return Err(ImportRefusal::Lengths {
                first: times.name(),
                first_length: times.len(),
                second: column.name(),
                second_length: column.len(),
            });
        }
        self.require_later(&times)?;
        let stated_s = times.vectors[0].seconds_per_unit();
        match (seconds_per_unit, stated_s) {
            (None, Some(unit_s)) if unit_s != 1.0 => Err(ImportRefusal::TimeUnit {
                name: times.name(),
                unit_s,
                key: format!("{table}.seconds_per_unit"),
            }),
            _ => Ok((times, seconds_per_unit.unwrap_or(1.0))),
        }
    }

    /// Requires that the times of each file are later than those of the one before.
    fn require_later(&mut self, times: &Column) -> Result<(), ImportRefusal> {
        let mut end = 0;
        for (pair, vector) in times.files.windows(2).zip(&times.vectors) {
            end += vector.len();
            if end == 0 || end == times.len() {
                continue;
            }
            let mut border = Vec::new();
            self.read(times, end - 1..end + 1, &mut border)?;
            if border[1] <= border[0] {
                return Err(ImportRefusal::PartTimes {
                    first: pair[0].clone(),
                    end: border[0],
                    second: pair[1].clone(),
                    start: border[1],
                });
            }
        }
        Ok(())
    }

    /// Returns the time of a stream's first sample that its file states beside a rate, s; `None` if it states none, or if the samples
    /// have times of their own.
    pub fn start_s(
        &mut self,
        time: &TimeBase,
        source: &ArraySource,
    ) -> Result<Option<f64>, ImportRefusal> {
        Ok(match time {
            TimeBase::Rate(_) => self.column(source)?.start_s(),
            TimeBase::Column { .. } => None,
        })
    }

    /// Refuses an array with too few values to have a rate.
    fn require_samples(column: &Column) -> Result<(), ImportRefusal> {
        if column.len() < 2 {
            return Err(ImportRefusal::Short {
                name: column.name(),
                length: column.len(),
            });
        }
        Ok(())
    }

    /// Returns the refusal of times that go back, at the first sample that is not after the one before.
    fn backwards(&mut self, times: &Column, table: &str) -> ImportRefusal {
        let mut growth = Growth::new(table);
        let scan = self.for_each_block(times, |start, block| {
            (start..)
                .zip(block)
                .try_for_each(|(sample, time)| growth.take(sample, *time))
        });
        scan.err()
            .unwrap_or_else(|| growth.refusal(times.len() - 1))
    }

    /// Returns the mean rate of a stream of at least two samples, Hz.
    pub fn mean_rate_hz(
        &mut self,
        base: &TimeBase,
        column: &Column,
        table: &str,
    ) -> Result<f64, ImportRefusal> {
        Self::require_samples(column)?;
        let (times, unit_s) = match base {
            TimeBase::Rate(rate) => return self.rate_hz(rate, column, table),
            TimeBase::Column {
                name,
                seconds_per_unit,
            } => self.time_column((column, table), name, *seconds_per_unit)?,
        };
        let last = times.len() - 1;
        let mut ends = Vec::new();
        self.read(&times, 0..1, &mut ends)?;
        self.read(&times, last..last + 1, &mut ends)?;
        let span_s = (ends[1] - ends[0]) * unit_s;
        if span_s.is_nan() || span_s <= 0.0 {
            return Err(self.backwards(&times, table));
        }
        Ok(last as f64 / span_s)
    }

    /// Returns the constant rate of a stream and the time of its first sample, s.
    pub fn even_times(
        &mut self,
        base: &TimeBase,
        column: &Column,
        table: &str,
    ) -> Result<(f64, f64), ImportRefusal> {
        Self::require_samples(column)?;
        let (times, unit_s) = match base {
            TimeBase::Rate(rate) => return Ok((self.rate_hz(rate, column, table)?, 0.0)),
            TimeBase::Column {
                name,
                seconds_per_unit,
            } => self.time_column((column, table), name, *seconds_per_unit)?,
        };
        let key = format!("{table}.time");
        let count = times.len();
        let mut ends = Vec::new();
        self.read(&times, 0..1, &mut ends)?;
        self.read(&times, count - 1..count, &mut ends)?;
        let (first, step) = (ends[0], (ends[1] - ends[0]) / (count - 1) as f64);
        if !(step > 0.0 && step.is_finite()) {
            return Err(self.backwards(&times, table));
        }
        self.for_each_block(&times, |start, values| {
            for (sample, time) in (start..).zip(values) {
                let deviation = (time - first) / step - sample as f64;
                if deviation.abs() > 0.5 || deviation.is_nan() {
                    return Err(ImportRefusal::Uneven {
                        key: key.clone(),
                        sample,
                        deviation,
                    });
                }
            }
            Ok(())
        })?;
        let rate_hz = 1.0 / (step * unit_s);
        let whole_hz = rate_hz.round();
        // Times are printed with a few digits; rates are whole numbers.
        let is_whole = (rate_hz / whole_hz - 1.0).abs() < 1e-6;
        Ok((if is_whole { whole_hz } else { rate_hz }, first * unit_s))
    }

    /// Adds a file that is read as a whole, such as a table of marks, to the sources; returns its text.
    pub fn text(&mut self, file: &str, reader: &str) -> Result<String, ImportRefusal> {
        let path = self.folder.join(file);
        let text = bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES);
        let text = text.map_err(|error| ImportRefusal::system(&path, &error))?;
        self.other_files.insert(file.to_owned(), reader.to_owned());
        Ok(text)
    }

    /// Returns the sources that were read, with their sums from `sums`.
    pub fn origins(&self, sums: &mut Sums) -> Result<Vec<ImportedSource>, ImportRefusal> {
        let opened = self.files.iter();
        let opened = opened.map(|(file, source)| (file, source.format().reader().to_owned()));
        let others = self
            .other_files
            .iter()
            .map(|(file, reader)| (file, reader.clone()));
        let mut origins = Vec::new();
        for (file, reader) in opened.chain(others) {
            origins.push(ImportedSource {
                file: file.clone(),
                sha256: sums.sum(&self.folder.join(file))?,
                reader,
            });
        }
        origins.sort_by(|a, b| a.file.cmp(&b.file));
        Ok(origins)
    }

    /// Returns the sentences that the readers have for a user.
    pub fn notes(&self) -> Vec<String> {
        let notes = self.files.iter().flat_map(|(file, source)| {
            source
                .notes()
                .iter()
                .map(move |note| format!("{file}: {note}"))
        });
        notes.collect()
    }
}

/// Times of a stream, which grow from sample to sample.
pub(crate) struct Growth<'a> {
    table: &'a str,
    last: f64,
}

impl<'a> Growth<'a> {
    /// Creates the check of the times of a stream's table.
    pub fn new(table: &'a str) -> Self {
        Self {
            table,
            last: f64::NEG_INFINITY,
        }
    }

    /// Requires that the time of a sample is after the one before.
    pub fn take(&mut self, sample: u64, time: f64) -> Result<(), ImportRefusal> {
        if time == self.last {
            return Err(ImportRefusal::EqualTimes {
                key: format!("{}.time", self.table),
                sample,
            });
        }
        if time.is_nan() || time < self.last {
            return Err(self.refusal(sample));
        }
        self.last = time;
        Ok(())
    }

    fn refusal(&self, sample: u64) -> ImportRefusal {
        ImportRefusal::Backwards {
            key: format!("{}.time", self.table),
            sample,
        }
    }
}

/// Returns the names of a stream's files, in their order: those that the map's pattern matches, or, of a template, one for each part
/// that it names.
pub(crate) fn file_names(file: &NamedFile, source: Option<&Template>) -> Vec<String> {
    let Some(template) = source else {
        return file.paths().map(str::to_owned).collect();
    };
    let continuation = file.continuation.iter().map(|part| &part.captures);
    let captures = std::iter::once(&file.captures).chain(continuation);
    let mut names: Vec<String> = captures.map(|captures| template.fill(captures)).collect();
    names.dedup();
    names
}

/// SHA-256 sums of files, each computed once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sums {
    by_path: BTreeMap<PathBuf, String>,
}

impl Sums {
    /// Computes the sums of files in parallel; one that cannot be read is left out.
    pub fn compute(paths: Vec<PathBuf>) -> Self {
        let sums = paths.into_par_iter().filter_map(|path| {
            let sum = file_sum(&path).ok()?;
            Some((path, sum))
        });
        Self {
            by_path: sums.collect(),
        }
    }

    /// Returns the sum of a file in hexadecimal if it was computed.
    pub fn known(&self, path: &Path) -> Option<&str> {
        self.by_path.get(path).map(String::as_str)
    }

    /// Returns the sum of a file in hexadecimal.
    pub fn sum(&mut self, path: &Path) -> Result<String, ImportRefusal> {
        if let Some(sum) = self.by_path.get(path) {
            return Ok(sum.clone());
        }
        let sum = file_sum(path).map_err(|error| ImportRefusal::system(path, &error))?;
        self.by_path.insert(path.to_owned(), sum.clone());
        Ok(sum)
    }
}

fn file_sum(path: &Path) -> std::io::Result<String> {
    let mut file = bounded_files::open(path)?;
    let mut digest = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hexadecimal(&digest.finalize())),
            n => digest.update(&buffer[..n]),
        }
    }
}

/// Returns the SHA-256 of bytes in hexadecimal.
pub(crate) fn sum(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
