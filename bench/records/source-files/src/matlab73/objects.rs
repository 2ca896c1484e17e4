//! Objects of MATLAB's classes: tables, timetables, maps, times and texts are looked into; others are named, and their properties
//! listed.

use hdf5_reader::Dataset;

use super::{Value, Variables, mcos};
use crate::array::{ArrayInfo, Element};
use crate::error::SourceError;
use crate::hdf5::guard::guarded;
use crate::hdf5::listing::{Content, Text};

/// Most numbers of a variable that is an array of objects, and of a `string`.
const MOST_NUMBERS: u64 = 100_000;
/// Seconds of a millisecond, MATLAB's unit of time.
const MILLISECOND_S: f64 = 1e-3;

/// Times of a timetable's rows that are equally spaced.
struct Rate {
    first_s: f64,
    step_s: f64,
}

impl Variables {
    /// Returns whether a value's numbers refer to objects.
    pub(super) fn refers(&self, value: &Value) -> bool {
        let numbers = value.numbers(MOST_NUMBERS).ok().flatten();
        let referred = numbers.as_deref().and_then(mcos::references);
        referred.is_some_and(|(_, numbers)| {
            let mut numbers = numbers.iter();
            numbers.all(|number| self.objects.get(*number).is_some())
        })
    }

    /// Adds the objects of a variable.
    pub(super) fn objects(
        &mut self,
        name: &str,
        dataset: &Dataset,
        class: &str,
        depth: usize,
    ) -> Result<(), SourceError> {
        let value = Value::dataset(dataset.clone());
        let numbers = guarded(&format!("array `{name}`"), || value.numbers(MOST_NUMBERS))?;
        let referred = numbers.as_deref().and_then(mcos::references);
        let Some((_, numbers)) = referred else {
            return self.opaque(name, class);
        };
        if numbers.is_empty() {
            return self.opaque(name, &format!("{class}, empty"));
        }
        let is_single = numbers.len() == 1;
        for (index, number) in numbers.into_iter().enumerate() {
            let object = self
                .objects
                .get(number)
                .filter(|object| !object.class.is_empty());
            let Some(object) = object.cloned().filter(|_| !self.open.contains(&number)) else {
                self.opaque(name, class)?;
                continue;
            };
            self.open.push(number);
            let indexed = format!("{name}[{index}]");
            let name = if is_single { name } else { &indexed };
            let added = self.object(name, &object, depth);
            self.open.pop();
            added?;
        }
        Ok(())
    }

    fn object(
        &mut self,
        name: &str,
        object: &mcos::Object,
        depth: usize,
    ) -> Result<(), SourceError> {
        let properties = object.properties.iter();
        let found = properties
            .filter_map(|(name, cell)| Some((name.clone(), self.cells.get(*cell)?.clone())));
        let properties: Vec<(String, Value)> = found.collect();
        let property = |name: &str| {
            let found = properties.iter().find(|(other, _)| other == name);
            found.map(|(_, value)| value)
        };
        let place = format!("array `{name}`");
        let class = object.class.as_str();
        let added = match class {
            "string" => property("any").map(|any| self.string(name, any, &place)),
            "datetime" => property("data").map(|data| self.time(name, data)),
            "duration" => property("millis").map(|millis| self.duration(name, millis)),
            "table" => {
                let columns = property("data").zip(property("varnames"));
                let units = property("props").and_then(|props| props.field("VariableUnits"));
                columns
                    .map(|(data, names)| self.columns(name, [data, names], units.as_ref(), depth))
            }
            "timetable" => property("any").map(|any| self.timetable(name, any, depth)),
            "containers.Map" => property("serialization").map(|map| self.map(name, map, depth)),
            "categorical" => None,
            _ => {
                let before = self.listing.arrays.len();
                for (property, value) in &properties {
                    self.value(&format!("{name}.{property}"), value, depth + 1)?;
                }
                if self.listing.arrays.len() == before {
                    self.opaque(name, class)?;
                }
                return Ok(());
            }
        };
        // Properties with the class's own values are not stored.
        let is_categorical = class == "categorical";
        let rest = if is_categorical { "" } else { ", empty" };
        added.unwrap_or_else(|| self.opaque(name, &format!("{class}{rest}")))
    }

    fn string(&mut self, name: &str, any: &Value, place: &str) -> Result<(), SourceError> {
        let words = guarded(place, || match any {
            Value::Dataset(dataset) if dataset.num_elements()? <= MOST_NUMBERS => {
                let raw = dataset.read_raw_bytes()?;
                let (words, _) = raw.as_chunks::<8>();
                Ok(words.iter().map(|word| u64::from_le_bytes(*word)).collect())
            }
            _ => Ok(Vec::new()),
        })?;
        match mcos::strings(&words) {
            Some(strings) => {
                let info = ArrayInfo::new(name, Element::Text, vec![1, strings.len() as u64]);
                let text = Text::Known(strings.join("\n"));
                self.listing.add(info, Content::Text(text))
            }
            None => self.opaque(name, "string"),
        }
    }

    /// Adds points in time, stored as ms since 1970: the sum of two doubles, which a complex number holds.
    fn time(&mut self, name: &str, data: &Value) -> Result<(), SourceError> {
        let column = data
            .column()
            .filter(|_| !super::is_empty(&data.attributes()));
        match column {
            Some(column) => {
                let info = ArrayInfo::new(name, Element::Time, Vec::new());
                self.listing
                    .add_column(info, column.summed().scaled(MILLISECOND_S))
            }
            None => self.opaque(name, "datetime, empty"),
        }
    }

    fn duration(&mut self, name: &str, millis: &Value) -> Result<(), SourceError> {
        let column = millis
            .column()
            .filter(|_| !super::is_empty(&millis.attributes()));
        match column {
            Some(column) => {
                let mut info = ArrayInfo::new(name, Element::Float { bits: 64 }, Vec::new());
                info.unit = Some("s".to_owned());
                self.listing.add_column(info, column.scaled(MILLISECOND_S))
            }
            None => self.opaque(name, "duration, empty"),
        }
    }

    /// Adds the columns of a table: a cell array of values, and one of names.
    fn columns(
        &mut self,
        name: &str,
        [data, names]: [&Value; 2],
        units: Option<&Value>,
        depth: usize,
    ) -> Result<(), SourceError> {
        let names = self.texts(names);
        let units = units.map(|units| self.texts(units)).unwrap_or_default();
        let values = self.values(data);
        if values.is_empty() || values.len() != names.len() {
            return self.opaque(name, "table, empty");
        }
        for (index, (column, value)) in names.iter().zip(&values).enumerate() {
            let before = self.listing.arrays.len();
            self.value(&format!("{name}.{column}"), value, depth + 1)?;
            let unit = units.get(index).filter(|unit| !unit.is_empty());
            for (info, _) in self.listing.arrays.iter_mut().skip(before) {
                info.unit = unit.cloned().or(info.unit.take());
            }
        }
        Ok(())
    }

    fn timetable(&mut self, name: &str, any: &Value, depth: usize) -> Result<(), SourceError> {
        let (Some(data), Some(names)) = (any.field("data"), any.field("varNames")) else {
            return self.opaque(name, "timetable");
        };
        let before = self.listing.arrays.len();
        let dimension = any.field("dimNames").map(|names| self.texts(&names));
        let dimension = dimension.and_then(|names| names.into_iter().next());
        let time = format!("{name}.{}", dimension.as_deref().unwrap_or("Time"));
        let rows = any.field("numRows").and_then(|rows| rows.number());
        let times = any.field("rowTimes");
        let rate = times.as_ref().and_then(|times| self.rate(times));
        match (rate, times) {
            (Some(rate), _) => {
                let rows = rows.unwrap_or(0.0) as u64;
                let mut info = ArrayInfo::new(time, Element::Float { bits: 64 }, vec![rows, 1]);
                info.unit = Some("s".to_owned());
                let Rate {
                    first_s: first,
                    step_s: step,
                } = rate;
                self.listing.add(info, Content::Ramp { first, step })?;
            }
            (None, Some(Value::Group(_))) => self.opaque(&time, "times of rows")?,
            (None, Some(times)) => self.value(&time, &times, depth + 1)?,
            (None, None) => {}
        }
        let own = self.listing.arrays.len();
        let units = any.field("varUnits");
        self.columns(name, [&data, &names], units.as_ref(), depth)?;
        if let Some((info, Content::Ramp { first, step })) = self.listing.arrays.get(before) {
            debug_assert!(info.rate_hz.is_none());
            let (rate_hz, start_s) = (1.0 / step, *first);
            for (info, _) in self.listing.arrays.iter_mut().skip(own) {
                info.rate_hz = Some(rate_hz);
                info.start_s = Some(start_s);
            }
        }
        Ok(())
    }

    /// Returns the equal steps of a timetable's rows, if it states them.
    fn rate(&self, times: &Value) -> Option<Rate> {
        let seconds = |value: &Value| {
            let Value::Dataset(_) = value else {
                return None;
            };
            let numbers = value.numbers(MOST_NUMBERS).ok()??;
            let (_, objects) = mcos::references(&numbers)?;
            let object = self.objects.get(*objects.first()?)?;
            let key = if object.class == "datetime" {
                "data"
            } else {
                "millis"
            };
            let Some((_, cell)) = object.properties.iter().find(|(name, _)| name == key) else {
                // Properties with the class's own value, 0 ms, are not stored.
                return Some(0.0);
            };
            let column = self.cells.get(*cell)?.column()?.summed();
            Some(column.first().ok()?? * MILLISECOND_S)
        };
        let first_s = seconds(&times.field("origin")?)?;
        let is_rate = times.field("specifiedAsRate")?.number()? != 0.0;
        let step_s = match is_rate {
            true => 1.0 / times.field("sampleRate")?.number()?,
            false => seconds(&times.field("stepSize")?)?,
        };
        (step_s.is_finite() && step_s > 0.0).then_some(Rate { first_s, step_s })
    }

    /// Adds the values of a map by their keys.
    fn map(&mut self, name: &str, map: &Value, depth: usize) -> Result<(), SourceError> {
        let (Some(keys), Some(values)) = (map.field("keys"), map.field("values")) else {
            return self.opaque(name, "containers.Map");
        };
        let keys = self.texts(&keys);
        let values = self.values(&values);
        if values.is_empty() || keys.len() != values.len() {
            return self.opaque(name, "containers.Map, empty");
        }
        for (key, value) in keys.iter().zip(&values) {
            self.value(&format!("{name}.{key}"), value, depth + 1)?;
        }
        Ok(())
    }

    /// Returns the values of a cell array; none for another value.
    fn values(&self, cells: &Value) -> Vec<Value> {
        match cells {
            Value::Dataset(dataset) => self.cells(dataset).unwrap_or_default(),
            Value::Group(_) => Vec::new(),
        }
    }

    /// Returns the texts of a cell array, numbers as texts; an empty text for another value.
    fn texts(&self, cells: &Value) -> Vec<String> {
        let text = |value: &Value| match value {
            Value::Dataset(dataset) if value.class().as_deref() == Some("char") => {
                let text = Text::Characters(Dataset::clone(dataset)).read();
                let is_empty = super::attribute(&value.attributes(), "MATLAB_empty").is_some();
                text.ok()
                    .flatten()
                    .filter(|_| !is_empty)
                    .unwrap_or_default()
            }
            value => value
                .number()
                .map(|number| number.to_string())
                .unwrap_or_default(),
        };
        self.values(cells).iter().map(text).collect()
    }
}
