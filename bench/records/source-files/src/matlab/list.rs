//! Arrays in the variables of a file.

use file_sections::Sources;

use super::node::{Content, Elements, Node, Numeric};
use super::objects::{Objects, REFERENCE};
use crate::array::{ArrayInfo, Element};
use crate::error::SourceError;
use crate::numbers::NumberType;

/// Maximum depth of structures, cells and objects in one another.
const MOST_DEPTH: usize = 32;

/// Maximum number of arrays that are listed, and of parts that are visited for it.
const MOST_ARRAYS: usize = 20_000;
const MOST_VISITS: usize = 1_000_000;

/// Maximum number of words of a reference to one object.
const MOST_REFERENCE_WORDS: u64 = 64;

/// Field of a structure in place of a value that an enumeration names.
const ENUMERATION: &str = "EnumerationInstanceTag";

/// Milliseconds, in seconds.
const MILLISECOND_S: f64 = 1e-3;

/// Content of an array that is listed.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    /// Index of the source that has it.
    pub(crate) source: usize,
    /// The content.
    pub(crate) values: Values,
}

/// Values of an array that is listed.
#[derive(Debug, Clone)]
pub(crate) enum Values {
    /// Numbers, and the factor by which they are multiplied.
    Numbers { numeric: Numeric, scale: f64 },
    /// Text.
    Text(Content),
    /// Values that are not read.
    Unread,
}

/// Arrays of a file.
pub(crate) struct Lister<'a> {
    pub(crate) sources: &'a mut Sources,
    pub(crate) is_big_endian: bool,
    pub(crate) objects: Objects,
    /// Source of the objects' properties.
    pub(crate) objects_source: usize,
    pub(crate) arrays: Vec<ArrayInfo>,
    pub(crate) found: Vec<Found>,
    pub(crate) visits: usize,
}

impl Lister<'_> {
    /// Returns whether the list is as long as it becomes.
    pub(crate) fn is_full(&self) -> bool {
        self.arrays.len() >= MOST_ARRAYS || self.visits >= MOST_VISITS
    }

    /// Adds the arrays of a variable or of a part of one.
    pub(crate) fn add(
        &mut self,
        name: &str,
        node: &Node,
        source: usize,
        depth: usize,
    ) -> Result<(), SourceError> {
        self.visits += 1;
        if depth > MOST_DEPTH || self.is_full() {
            return Ok(());
        }
        match node {
            Node::Numeric(numeric) => {
                if let Some(reference) = self.reference(numeric, source)? {
                    let class = self
                        .objects
                        .class(&reference)
                        .unwrap_or("object")
                        .to_owned();
                    return self.object(name, &class, &reference, depth);
                }
                let element = match numeric.is_logical {
                    true => Element::Logical,
                    false => numeric.class.element(numeric.imaginary.is_some()),
                };
                self.push_numbers(name, element, numeric, source, 1.0);
            }
            Node::Text { shape, content } => {
                self.arrays
                    .push(ArrayInfo::new(name, Element::Text, shape.clone()));
                self.found.push(Found {
                    source,
                    values: Values::Text(*content),
                });
            }
            Node::Cells { shape, cells } => {
                for (i, cell) in cells.iter().enumerate() {
                    let name = format!("{name}[{}]", subscript(i as u64, shape));
                    self.add(&name, cell, source, depth + 1)?;
                }
            }
            Node::Structures {
                shape,
                names,
                fields,
            } => {
                if names.iter().any(|name| name == ENUMERATION) {
                    self.push_unread(name, "enumeration");
                    return Ok(());
                }
                let is_single = shape.iter().all(|length| *length == 1);
                for (i, fields) in fields.chunks(names.len().max(1)).enumerate() {
                    let stem = match is_single {
                        true => name.to_owned(),
                        false => format!("{name}[{}]", subscript(i as u64, shape)),
                    };
                    for (field, node) in names.iter().zip(fields) {
                        self.add(&format!("{stem}.{field}"), node, source, depth + 1)?;
                    }
                }
            }
            Node::Object { class, reference } => self.object(name, class, reference, depth)?,
            Node::Other { class } => {
                if class != "empty array" {
                    self.push_unread(name, class);
                }
            }
        }
        Ok(())
    }

    /// Returns the reference to an object that a property consists of.
    fn reference(
        &mut self,
        numeric: &Numeric,
        source: usize,
    ) -> Result<Option<Vec<u32>>, SourceError> {
        let Content {
            offset,
            encoding,
            count,
        } = numeric.real;
        let is_short = (5..=MOST_REFERENCE_WORDS).contains(&count);
        if encoding.number != NumberType::U32 || !is_short || source != self.objects_source {
            return Ok(None);
        }
        let bytes = self.elements(source).bytes(offset, 4 * count)?;
        let words = bytes.chunks_exact(4);
        let words: Vec<u32> = words.map(|word| encoding.decode(word) as u32).collect();
        Ok((words[0] == REFERENCE).then_some(words))
    }

    fn push_numbers(
        &mut self,
        name: &str,
        element: Element,
        numeric: &Numeric,
        source: usize,
        scale: f64,
    ) {
        self.arrays
            .push(ArrayInfo::new(name, element, numeric.shape.clone()));
        self.found.push(Found {
            source,
            values: Values::Numbers {
                numeric: numeric.clone(),
                scale,
            },
        });
    }

    fn push_unread(&mut self, name: &str, class: &str) {
        self.arrays.push(ArrayInfo::opaque(name, class));
        self.found.push(Found {
            source: 0,
            values: Values::Unread,
        });
    }

    /// Adds the arrays of an object: the variables of a table, the values of a map, the properties of any other.
    fn object(
        &mut self,
        name: &str,
        class: &str,
        reference: &[u32],
        depth: usize,
    ) -> Result<(), SourceError> {
        let properties = self.objects.properties(reference).map(|properties| {
            let owned = |(name, node): (&str, &Node)| (name.to_owned(), node.clone());
            properties.into_iter().map(owned).collect::<Vec<_>>()
        });
        let before = self.arrays.len();
        if let Some(properties) = properties {
            let property = |name: &str| {
                let found = properties.iter().find(|(property, _)| property == name);
                found.map(|(_, node)| node)
            };
            let source = self.objects_source;
            match (class, property("any"), property("serialization")) {
                ("table", ..) => {
                    self.columns(name, property("data"), property("varnames"), None, depth)?;
                }
                ("timetable", Some(any), _) => self.timetable(name, any, depth)?,
                ("containers.Map", _, Some(map)) => {
                    self.columns(name, field(map, "values"), field(map, "keys"), None, depth)?;
                }
                ("duration", ..) => {
                    let element = Element::Float { bits: 64 };
                    self.time(name, element, property("millis"), source);
                }
                ("datetime", ..) => self.time(name, Element::Time, property("data"), source),
                ("string" | "categorical", ..) => {}
                _ => {
                    for (property, node) in &properties {
                        self.add(&format!("{name}.{property}"), node, source, depth + 1)?;
                    }
                }
            }
        }
        if self.arrays.len() == before {
            self.push_unread(name, class);
        }
        Ok(())
    }

    /// Adds columns with their names and units.
    fn columns(
        &mut self,
        name: &str,
        columns: Option<&Node>,
        names: Option<&Node>,
        units: Option<&Node>,
        depth: usize,
    ) -> Result<(), SourceError> {
        let (Some(Node::Cells { cells, .. }), Some(names)) = (columns, names) else {
            return Ok(());
        };
        let names = self.texts(names)?;
        let units = match units {
            Some(units @ Node::Cells { .. }) => self.texts(units)?,
            _ => Vec::new(),
        };
        for (i, (column, node)) in names.iter().zip(cells).enumerate() {
            let before = self.arrays.len();
            let name = format!("{name}.{column}");
            self.add(&name, node, self.objects_source, depth + 1)?;
            let unit = units.get(i).filter(|unit| !unit.is_empty());
            for info in &mut self.arrays[before..] {
                info.unit = unit.cloned().or(info.unit.take());
            }
        }
        Ok(())
    }

    /// Returns the texts in a cell array, or one text.
    fn texts(&mut self, node: &Node) -> Result<Vec<String>, SourceError> {
        let nodes = match node {
            Node::Cells { cells, .. } => cells.as_slice(),
            node => std::slice::from_ref(node),
        };
        let mut texts = Vec::new();
        for node in nodes {
            texts.push(match node {
                Node::Text { content, .. } => {
                    self.elements(self.objects_source).characters(*content)?
                }
                Node::Other { .. } => String::new(),
                _ => texts.len().to_string(),
            });
        }
        Ok(texts)
    }

    /// Adds the variables of a timetable and its times.
    fn timetable(&mut self, name: &str, any: &Node, depth: usize) -> Result<(), SourceError> {
        let before = self.arrays.len();
        let dimension = match field(any, "dimNames") {
            Some(names) => self.texts(names)?.into_iter().next(),
            None => None,
        };
        let times = format!("{name}.{}", dimension.as_deref().unwrap_or("Time"));
        let mut steps = None;
        match field(any, "rowTimes") {
            Some(rows @ Node::Structures { .. }) => steps = self.steps(rows)?,
            Some(rows) => self.add(&times, rows, self.objects_source, depth + 1)?,
            None => {}
        }
        let units = field(any, "varUnits");
        self.columns(
            name,
            field(any, "data"),
            field(any, "varNames"),
            units,
            depth,
        )?;
        if let Some((rate_hz, start_s)) = steps {
            for info in &mut self.arrays[before..] {
                (info.rate_hz, info.start_s) = (Some(rate_hz), Some(start_s));
            }
        }
        Ok(())
    }

    /// Returns the rate of a timetable's rows, Hz, and the time of the first one, s, where their steps are equal.
    fn steps(&mut self, rows: &Node) -> Result<Option<(f64, f64)>, SourceError> {
        let is_rate = match field(rows, "specifiedAsRate") {
            Some(Node::Numeric(is_rate)) => self.single(is_rate)? == Some(1.0),
            _ => false,
        };
        let rate_hz = match (is_rate, field(rows, "sampleRate")) {
            (true, Some(Node::Numeric(rate))) => self.single(rate)?,
            _ => self
                .seconds(field(rows, "stepSize"))?
                .map(|step_s| 1.0 / step_s),
        };
        let start_s = self.seconds(field(rows, "origin"))?.unwrap_or(0.0);
        let rate_hz = rate_hz.filter(|rate_hz| rate_hz.is_finite() && *rate_hz > 0.0);
        Ok(rate_hz.map(|rate_hz| (rate_hz, start_s)))
    }

    /// Returns the seconds of a duration or of a point in time.
    fn seconds(&mut self, node: Option<&Node>) -> Result<Option<f64>, SourceError> {
        let reference = match node {
            Some(Node::Object { reference, .. }) => Some(reference.clone()),
            Some(Node::Numeric(numeric)) => self.reference(numeric, self.objects_source)?,
            _ => None,
        };
        let properties = reference.and_then(|reference| self.objects.properties(&reference));
        let milliseconds = properties.and_then(|properties| {
            properties.into_iter().find_map(|(name, node)| match node {
                Node::Numeric(numeric) if name == "millis" || name == "data" => {
                    Some(numeric.clone())
                }
                _ => None,
            })
        });
        let milliseconds = match milliseconds {
            Some(numeric) => self.single(&numeric)?,
            None => None,
        };
        Ok(milliseconds.map(|milliseconds| milliseconds * MILLISECOND_S))
    }

    /// Adds times in milliseconds.
    fn time(&mut self, name: &str, element: Element, node: Option<&Node>, source: usize) {
        if let Some(Node::Numeric(numeric)) = node {
            let real = Numeric {
                imaginary: None,
                ..numeric.clone()
            };
            self.push_numbers(name, element, &real, source, MILLISECOND_S);
            if let Some(info) = self.arrays.last_mut() {
                info.unit = Some("s".to_owned());
            }
        }
    }

    /// Reads a single number of the objects' store.
    fn single(&mut self, numeric: &Numeric) -> Result<Option<f64>, SourceError> {
        if numeric.real.count != 1 {
            return Ok(None);
        }
        let size = numeric.real.encoding.number.bytes() as u64;
        let bytes = self
            .elements(self.objects_source)
            .bytes(numeric.real.offset, size)?;
        Ok(Some(numeric.real.encoding.decode(&bytes)))
    }

    fn elements(&mut self, source: usize) -> Elements<'_> {
        Elements {
            source: self.sources.get(source),
            is_big_endian: self.is_big_endian,
            nodes: 0,
        }
    }
}

/// Returns a field of a single structure.
fn field<'a>(node: &'a Node, name: &str) -> Option<&'a Node> {
    let Node::Structures { names, fields, .. } = node else {
        return None;
    };
    let place = names.iter().position(|field| field == name)?;
    fields.get(place)
}

/// Returns the indices of an element, by columns: one for a vector.
fn subscript(index: u64, shape: &[u64]) -> String {
    let long = shape.iter().filter(|length| **length != 1).count();
    if long <= 1 {
        return index.to_string();
    }
    let mut rest = index;
    let indices = shape.iter().map(|length| {
        let index = rest % length;
        rest /= length;
        index.to_string()
    });
    indices.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_counted_by_columns() {
        assert_eq!(subscript(4, &[1, 9]), "4");
        assert_eq!(subscript(4, &[9, 1]), "4");
        assert_eq!(subscript(4, &[3, 2]), "1,1");
        assert_eq!(subscript(5, &[2, 2, 2]), "1,0,1");
        assert_eq!(subscript(0, &[1, 1]), "0");
    }
}
