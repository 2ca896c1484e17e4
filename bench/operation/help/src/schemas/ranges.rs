//! Ranges of numbers, obtained from the reader that enforces them.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};
use toml::{Table, Value};

use crate::schemas::places::{Place, numbers};
use crate::schemas::readers::{Answer, Reader};

/// Number outside every range, with either sign.
const EXTREME: f64 = 1e300;

/// Smallest and largest allowed number of a key.
type Range = (f64, f64);

/// Adds to a schema the ranges that its reader enforces. A range that depends on another key, such as that of a position
/// on a plate, is not stated: it changes with the other numbers.
pub(crate) fn with_ranges(mut schema: Json, reader: &Reader) -> Json {
    let pairs: Vec<(&Table, Table)> = reader
        .documents
        .iter()
        .map(|document| (document, variant(document, reader)))
        .collect();
    let mut pointer_ranges: BTreeMap<String, Vec<Option<Range>>> = BTreeMap::new();
    for place in numbers(&schema) {
        let ends = ends(&schema, &place);
        let range = pairs.iter().find_map(|(document, variant)| {
            let range = range_at(document, reader, &place, ends)?;
            (range_at(variant, reader, &place, ends) == Some(range)).then_some(range)
        });
        pointer_ranges.entry(place.pointer).or_default().push(range);
    }
    for (pointer, ranges) in pointer_ranges {
        // A table that is used in several places allows the union of their ranges.
        let intervals: Option<Vec<Range>> = ranges.into_iter().collect();
        let widest = intervals.and_then(|intervals| {
            intervals
                .into_iter()
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        });
        if let (Some(range), Some(Json::Object(number))) = (widest, schema.pointer_mut(&pointer)) {
            state(range, number);
        }
    }
    schema
}

/// Returns numbers outside every range: the ends of an integer's type, or extremely large numbers.
fn ends(schema: &Json, place: &Place) -> Range {
    let number = schema.pointer(&place.pointer);
    let integer = number.filter(|number| number["type"] == "integer");
    let end = |key: &str| integer.and_then(|number| number[key].as_f64());
    (
        end("minimum").unwrap_or(-EXTREME),
        end("maximum").unwrap_or(EXTREME),
    )
}

fn state((low, high): Range, number: &mut Map<String, Json>) {
    let is_integer = number.get("type") == Some(&json!("integer"));
    let json_number = |value: f64| {
        if is_integer {
            json!(value as i64)
        } else {
            json!(value)
        }
    };
    number.insert("minimum".to_owned(), json_number(low));
    number.insert("maximum".to_owned(), json_number(high));
}

/// Returns the range of the number at a place of a document; for a list, if all entries have the same range.
fn range_at(document: &Table, reader: &Reader, place: &Place, ends: Range) -> Option<Range> {
    let entries = match (place.in_list, value_at(document, &place.path)) {
        (true, Some(Value::Array(entries))) => entries.len(),
        (true, _) => 0,
        (false, _) => 1,
    };
    let mut entry_ranges = (0..entries).map(|entry| {
        let mut path = place.path.clone();
        if place.in_list {
            path.push(entry.to_string());
        }
        enforced_range(document, reader, &path, ends)
    });
    let first = entry_ranges.next()??;
    entry_ranges
        .all(|range| range == Some(first))
        .then_some(first)
}

/// Answer of the reader to a number outside every range.
enum RangeCheck {
    Taken,
    Refused,
    /// The number as checked, and its range.
    Outside(f64, Range),
}

/// Returns the range that the reader names for numbers far below and far above it.
fn enforced_range(
    document: &Table,
    reader: &Reader,
    path: &[String],
    ends: Range,
) -> Option<Range> {
    let (least, greatest) = ends;
    let check = |number: f64| check_number(document, reader, path, number);
    match (check(least), check(greatest)) {
        (RangeCheck::Outside(below, range), RangeCheck::Outside(above, upper_range))
            if range == upper_range =>
        {
            match above == greatest {
                true if below == least => Some(range),
                // Both signs are allowed.
                true if below == greatest => Some((-range.1, range.1)),
                _ => None,
            }
        }
        (RangeCheck::Outside(below, range), RangeCheck::Refused) if below == least => Some(range),
        (RangeCheck::Refused, RangeCheck::Outside(above, range)) if above == greatest => {
            Some(range)
        }
        (RangeCheck::Taken, RangeCheck::Outside(above, range))
            if above == greatest && range.0 <= least =>
        {
            Some((least, range.1))
        }
        _ => None,
    }
}

fn check_number(document: &Table, reader: &Reader, path: &[String], number: f64) -> RangeCheck {
    let mut candidate = document.clone();
    let is_integer = number.abs() < EXTREME;
    let number = match is_integer {
        true => Value::Integer(number as i64),
        false => Value::Float(number),
    };
    if put(&mut candidate, path, number).is_none() {
        return RangeCheck::Refused;
    }
    // An error names a list as a whole, or an entry of it.
    let is_named = |key: &str| {
        let list = path.split_last().map(|(_, list)| list.join("."));
        key == path.join(".") || list.is_some_and(|list| key == list)
    };
    match (reader.read)(&candidate.to_string()) {
        Answer::Taken => RangeCheck::Taken,
        Answer::OutOfRange(error) if is_named(&error.key) => {
            RangeCheck::Outside(error.value, (error.low, error.high))
        }
        Answer::OutOfRange(_) | Answer::Refused => RangeCheck::Refused,
    }
}

/// Returns the document with every number changed to a nearby one that the reader accepts, if there is one.
fn variant(document: &Table, reader: &Reader) -> Table {
    let mut numbers = Vec::new();
    leaves(
        &Value::Table(document.clone()),
        &mut Vec::new(),
        &mut numbers,
    );
    let mut variant = document.clone();
    for (path, value) in numbers {
        let neighbour = neighbours(value).into_iter().find_map(|number| {
            let mut candidate = variant.clone();
            put(&mut candidate, &path, number)?;
            ((reader.read)(&candidate.to_string()) == Answer::Taken).then_some(candidate)
        });
        variant = neighbour.unwrap_or(variant);
    }
    variant
}

/// Returns nearby numbers, as integer and float, since the key may be of either type.
fn neighbours(value: f64) -> Vec<Value> {
    let small = if value == 0.0 { 1e-3 } else { 0.1 * value };
    let mut numbers = vec![Value::Float(value - small), Value::Float(value + small)];
    if value.fract() == 0.0 {
        let integer = value as i64;
        numbers.extend([Value::Integer(integer + 1), Value::Integer(integer - 1)]);
    }
    numbers
}

/// Collects the numbers of a document with their paths.
fn leaves(value: &Value, path: &mut Vec<String>, numbers: &mut Vec<(Vec<String>, f64)>) {
    let mut descend = |key: String, value: &Value| {
        path.push(key);
        leaves(value, path, numbers);
        path.pop();
    };
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                descend(key.clone(), value);
            }
        }
        Value::Array(entries) => {
            for (index, value) in entries.iter().enumerate() {
                descend(index.to_string(), value);
            }
        }
        Value::Float(number) => numbers.push((path.clone(), *number)),
        Value::Integer(number) => numbers.push((path.clone(), *number as f64)),
        _ => {}
    }
}

/// Sets a value at a path of existing tables.
fn put(document: &mut Table, path: &[String], value: Value) -> Option<()> {
    let (key, tables) = path.split_last()?;
    let Some((first, tail)) = tables.split_first() else {
        document.insert(key.clone(), value);
        return Some(());
    };
    let holder = tail
        .iter()
        .try_fold(document.get_mut(first)?, |value, key| match value {
            Value::Array(entries) => entries.get_mut(key.parse::<usize>().ok()?),
            value => value.get_mut(key),
        })?;
    match holder {
        Value::Table(table) => drop(table.insert(key.clone(), value)),
        Value::Array(entries) => *entries.get_mut(key.parse::<usize>().ok()?)? = value,
        _ => return None,
    }
    Some(())
}

fn value_at<'a>(document: &'a Table, path: &[String]) -> Option<&'a Value> {
    let (first, tail) = path.split_first()?;
    tail.iter().try_fold(document.get(first)?, |value, key| {
        match (value, key.parse::<usize>()) {
            (Value::Array(entries), Ok(index)) => entries.get(index),
            (value, _) => value.get(key),
        }
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::schemas::readers;

    /// Returns the schemas that state ranges, with their readers.
    fn ranged_schemas() -> [(Json, Reader); 3] {
        [
            (crate::schemas::schema("bench").unwrap(), readers::bench()),
            (
                crate::schemas::schema("protocol").unwrap(),
                readers::protocol(),
            ),
            (
                crate::schemas::schema("scenario").unwrap(),
                readers::scenario(),
            ),
        ]
    }

    fn entry(place: &Place) -> Vec<String> {
        let mut path = place.path.clone();
        if place.in_list {
            path.push("0".to_owned());
        }
        path
    }

    /// The ends of a range are allowed, and numbers just outside are not.
    #[test]
    fn the_reader_enforces_the_ranges_of_a_schema() {
        let mut ends_checked = 0;
        for (schema, reader) in ranged_schemas() {
            for place in numbers(&schema) {
                let property = schema.pointer(&place.pointer).unwrap();
                let path = entry(&place);
                for (end, sign) in [("minimum", -1), ("maximum", 1)] {
                    let (limit, outside) = match property.get(end) {
                        None => continue,
                        Some(integer) if integer.is_i64() => {
                            let integer = integer.as_i64().unwrap();
                            let Some(outside) = integer.checked_add(sign) else {
                                continue;
                            };
                            (Value::Integer(integer), Value::Integer(outside))
                        }
                        Some(number) => {
                            let number = number.as_f64().unwrap();
                            let step = sign as f64 * (1e-12 + 1e-6 * number.abs());
                            (Value::Float(number), Value::Float(number + step))
                        }
                    };
                    let answer = |document: &Table, value: &Value| {
                        let mut document = document.clone();
                        put(&mut document, &path, value.clone())?;
                        Some((reader.read)(&document.to_string()))
                    };
                    let is_in_range = |answer: Answer| match answer {
                        Answer::OutOfRange(range) => !path.join(".").starts_with(&range.key),
                        Answer::Taken | Answer::Refused => true,
                    };
                    let is_enforced = reader.documents.iter().any(|document| {
                        answer(document, &limit).is_some_and(is_in_range)
                            && answer(document, &outside)
                                .is_some_and(|answer| answer != Answer::Taken)
                    });
                    let is_reached = reader
                        .documents
                        .iter()
                        .any(|document| answer(document, &limit).is_some());
                    assert!(
                        is_enforced || !is_reached,
                        "{end} of {}: {property}",
                        path.join(".")
                    );
                    ends_checked += usize::from(is_reached);
                }
            }
        }
        assert!(ends_checked > 300, "{ends_checked}");
    }

    /// A range that depends on another key would be wrong in some other file.
    #[test]
    fn no_other_key_decides_a_range_that_is_stated() {
        let mut checks = 0;
        // Scenarios would take a minute.
        for (schema, reader) in ranged_schemas().into_iter().take(2) {
            let mut paths = BTreeSet::new();
            for document in &reader.documents {
                let has_range = |place: &Place| {
                    let number = schema.pointer(&place.pointer).unwrap();
                    number.get("maximum").is_some()
                };
                let places: Vec<(Vec<String>, Range, Range)> = numbers(&schema)
                    .iter()
                    .filter(|place| has_range(place) && !paths.contains(&entry(place)))
                    .filter_map(|place| {
                        let ends = ends_of_type(&schema, place);
                        let range = enforced_range(document, &reader, &entry(place), ends)?;
                        Some((entry(place), ends, range))
                    })
                    .collect();
                paths.extend(places.iter().map(|(path, ..)| path.clone()));
                let mut leaf_values = Vec::new();
                let root = Value::Table(document.clone());
                leaves(&root, &mut Vec::new(), &mut leaf_values);
                for (leaf, value) in &leaf_values {
                    let neighbour = neighbours(*value).into_iter().find_map(|number| {
                        let mut candidate = document.clone();
                        put(&mut candidate, leaf, number)?;
                        ((reader.read)(&candidate.to_string()) == Answer::Taken)
                            .then_some(candidate)
                    });
                    let Some(candidate) = neighbour else { continue };
                    for (path, ends, range) in places.iter().filter(|(path, ..)| path != leaf) {
                        let candidate_range = enforced_range(&candidate, &reader, path, *ends);
                        assert!(
                            candidate_range.is_none_or(|r| r == *range),
                            "{} decides the range of {}",
                            leaf.join("."),
                            path.join(".")
                        );
                        checks += 1;
                    }
                }
            }
        }
        assert!(checks > 3_000, "{checks}");
    }

    /// Returns ends that differ from every stated range, since a schema states a range in place of the type's ends.
    fn ends_of_type(schema: &Json, place: &Place) -> Range {
        match schema.pointer(&place.pointer).unwrap()["type"] == "integer" {
            true => (0.0, f64::from(u16::MAX)),
            false => (-EXTREME, EXTREME),
        }
    }
}
