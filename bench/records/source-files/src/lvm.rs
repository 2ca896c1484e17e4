//! LVM of LabVIEW: channels and columns of x, tags as attributes.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;

use lvm_files::{LvmColumn, LvmError, LvmFile};
use text_lines::TextForm;

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::{SourceError, SourceFault};
use crate::format::{ArrayReader, Format, Place, Values};

/// Opens an LVM file.
pub(crate) fn open(file: File, head: &[u8]) -> Result<Box<dyn ArrayReader>, SourceError> {
    let file = LvmFile::open(file, TextForm::find(head)).map_err(refusal)?;
    let attribute = |(tag, value): (String, String)| (format!("@{tag}"), Attribute::of_cell(value));
    Ok(Box::new(LvmReader {
        arrays: file.columns().iter().map(info).collect(),
        attributes: file.tags().into_iter().map(attribute).collect(),
        file,
    }))
}

struct LvmReader {
    file: LvmFile,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
}

fn info(column: &LvmColumn) -> ArrayInfo {
    let element = Element::Float { bits: 64 };
    ArrayInfo {
        unit: column.unit.clone(),
        rate_hz: column.rate_hz,
        start_s: column.rate_hz.map(|_| column.start_s),
        ..ArrayInfo::new(&column.name, element, vec![column.length])
    }
}

fn refusal(error: LvmError) -> SourceError {
    match error {
        LvmError::Line(error) => error.into(),
        LvmError::Unread { content, remedy } => SourceFault::Unread { content, remedy }.into(),
        LvmError::Damaged { line, defect } => SourceError::damaged(format!("line {line}"), defect),
        LvmError::Cell {
            line,
            column,
            cell,
            reason,
        } => SourceError::at(
            format!("line {line}, column `{column}`"),
            SourceFault::Cell { cell, reason },
        ),
    }
}

impl ArrayReader for LvmReader {
    fn format(&self) -> Format {
        Format::Lvm
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
        self.file.notes()
    }

    fn read(
        &mut self,
        index: usize,
        _place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let mut found = Vec::new();
        self.file.read(index, range, &mut found).map_err(refusal)?;
        for value in found {
            values.push(value);
        }
        Ok(())
    }
}
