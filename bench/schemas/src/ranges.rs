//! Ranges of numbers, obtained from the reader that enforces them.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};
use toml::{Table, Value};

use crate::places::{Place, numbers};
use crate::readers::{Answer, Reader};

/// Number outside every range, with either sign.
const BEYOND: f64 = 1e300;

/// Smallest and largest allowed number of a key.
type Range = (f64, f64);

/// Adds to a schema the ranges that its reader enforces. A range that depends on another key, such as that of a position
/// on a plate, is not stated: it changes with the other numbers.
pub(crate) fn with_ranges(mut schema: Json, reader: &Reader) -> Json {
    let pairs: Vec<(&Table, Table)> = reader
        .documents
        .iter()
        .map(|document| (document, otherwise(document, reader)))
        .collect();
    let mut of_pointers: BTreeMap<String, Vec<Option<Range>>> = BTreeMap::new();
    for place in numbers(&schema) {
        let ends = ends(&schema, &place);
        let range = pairs.iter().find_map(|(document, other)| {
            let range = range_in(document, reader, &place, ends)?;
            (range_in(other, reader, &place, ends) == Some(range)).then_some(range)
        });
        of_pointers.entry(place.pointer).or_default().push(range);
    }
    for (pointer, ranges) in of_pointers {
        // A table that is used in several places allows the union of their ranges.
        let all: Option<Vec<Range>> = ranges.into_iter().collect();
        let widest =
            all.and_then(|all| all.into_iter().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))));
        if let (Some(range), Some(Json::Object(number))) = (widest, schema.pointer_mut(&pointer)) {
            state(range, number);
        }
    }
    schema
}

/// Returns numbers outside every range: the ends of an integer's type, or extremely large numbers.
fn ends(schema: &Json, place: &Place) -> Range {
    let number = schema.pointer(&place.pointer);
    let of_type = number.filter(|number| number["type"] == "integer");
    let end = |key: &str| of_type.and_then(|number| number[key].as_f64());
    (
        end("minimum").unwrap_or(-BEYOND),
        end("maximum").unwrap_or(BEYOND),
    )
}

fn state((low, high): Range, number: &mut Map<String, Json>) {
    let whole = number.get("type") == Some(&json!("integer"));
    let written = |value: f64| {
        if whole {
            json!(value as i64)
        } else {
            json!(value)
        }
    };
    number.insert("minimum".to_owned(), written(low));
    number.insert("maximum".to_owned(), written(high));
}

/// Returns the range of the number at a place of a document; for a list, if all entries have the same range.
fn range_in(document: &Table, reader: &Reader, place: &Place, ends: Range) -> Option<Range> {
    let entries = match (place.in_list, at(document, &place.path)) {
        (true, Some(Value::Array(entries))) => entries.len(),
        (true, _) => 0,
        (false, _) => 1,
    };
    let mut of_entries = (0..entries).map(|entry| {
        let mut path = place.path.clone();
        if place.in_list {
            path.push(entry.to_string());
        }
        asked(document, reader, &path, ends)
    });
    let first = of_entries.next()??;
    of_entries
        .all(|other| other == Some(first))
        .then_some(first)
}

/// Answer of the reader to a number outside every range.
enum Told {
    Taken,
    Refused,
    /// The number as checked, and its range.
    Outside(f64, Range),
}

/// Returns the range that the reader names for numbers far below and far above it.
fn asked(document: &Table, reader: &Reader, path: &[String], ends: Range) -> Option<Range> {
    let (least, greatest) = ends;
    let told = |number: f64| told(document, reader, path, number);
    match (told(least), told(greatest)) {
        (Told::Outside(below, range), Told::Outside(above, other)) if range == other => {
            match above == greatest {
                true if below == least => Some(range),
                // Both signs are allowed.
                true if below == greatest => Some((-range.1, range.1)),
                _ => None,
            }
        }
        (Told::Outside(below, range), Told::Refused) if below == least => Some(range),
        (Told::Refused, Told::Outside(above, range)) if above == greatest => Some(range),
        (Told::Taken, Told::Outside(above, range)) if above == greatest && range.0 <= least => {
            Some((least, range.1))
        }
        _ => None,
    }
}

fn told(document: &Table, reader: &Reader, path: &[String], number: f64) -> Told {
    let mut tried = document.clone();
    let whole = number.abs() < BEYOND;
    let number = match whole {
        true => Value::Integer(number as i64),
        false => Value::Float(number),
    };
    if put(&mut tried, path, number).is_none() {
        return Told::Refused;
    }
    // An error names a list as a whole, or an entry of it.
    let names = |key: &str| {
        let list = path.split_last().map(|(_, list)| list.join("."));
        key == path.join(".") || list.is_some_and(|list| key == list)
    };
    match (reader.read)(&tried.to_string()) {
        Answer::Taken => Told::Taken,
        Answer::OutOfRange(refused) if names(&refused.key) => {
            Told::Outside(refused.value, (refused.low, refused.high))
        }
        Answer::OutOfRange(_) | Answer::Refused => Told::Refused,
    }
}

/// Returns the document with every number changed to a nearby one that the reader accepts, if there is one.
fn otherwise(document: &Table, reader: &Reader) -> Table {
    let mut numbers = Vec::new();
    leaves(
        &Value::Table(document.clone()),
        &mut Vec::new(),
        &mut numbers,
    );
    let mut other = document.clone();
    for (path, value) in numbers {
        let taken = changes(value).into_iter().find_map(|near| {
            let mut changed = other.clone();
            put(&mut changed, &path, near)?;
            ((reader.read)(&changed.to_string()) == Answer::Taken).then_some(changed)
        });
        other = taken.unwrap_or(other);
    }
    other
}

/// Returns nearby numbers, as integer and float, since the key may be of either type.
fn changes(value: f64) -> Vec<Value> {
    let small = if value == 0.0 { 1e-3 } else { 0.1 * value };
    let mut near = vec![Value::Float(value - small), Value::Float(value + small)];
    if value.fract() == 0.0 {
        let whole = value as i64;
        near.extend([Value::Integer(whole + 1), Value::Integer(whole - 1)]);
    }
    near
}

/// Collects the numbers of a document with their paths.
fn leaves(value: &Value, path: &mut Vec<String>, found: &mut Vec<(Vec<String>, f64)>) {
    let mut below = |key: String, value: &Value| {
        path.push(key);
        leaves(value, path, found);
        path.pop();
    };
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                below(key.clone(), value);
            }
        }
        Value::Array(entries) => {
            for (index, value) in entries.iter().enumerate() {
                below(index.to_string(), value);
            }
        }
        Value::Float(number) => found.push((path.clone(), *number)),
        Value::Integer(number) => found.push((path.clone(), *number as f64)),
        _ => {}
    }
}

/// Sets a value at a path of existing tables.
fn put(document: &mut Table, path: &[String], value: Value) -> Option<()> {
    let (key, tables) = path.split_last()?;
    let Some((first, rest)) = tables.split_first() else {
        document.insert(key.clone(), value);
        return Some(());
    };
    let holder = rest
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

fn at<'a>(document: &'a Table, path: &[String]) -> Option<&'a Value> {
    let (first, rest) = path.split_first()?;
    rest.iter().try_fold(document.get(first)?, |value, key| {
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
    use crate::readers;

    /// Returns the schemas that state ranges, with their readers.
    fn all() -> [(Json, Reader); 3] {
        [
            (crate::schema_of("bench").unwrap(), readers::bench()),
            (crate::schema_of("protocol").unwrap(), readers::protocol()),
            (crate::schema_of("scenario").unwrap(), readers::scenario()),
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
    fn what_a_schema_states_is_what_the_reader_keeps() {
        let mut ends_checked = 0;
        for (schema, reader) in all() {
            for place in numbers(&schema) {
                let stated = schema.pointer(&place.pointer).unwrap();
                let path = entry(&place);
                for (end, sign) in [("minimum", -1), ("maximum", 1)] {
                    let (at, beyond) = match stated.get(end) {
                        None => continue,
                        Some(whole) if whole.is_i64() => {
                            let whole = whole.as_i64().unwrap();
                            let Some(beyond) = whole.checked_add(sign) else {
                                continue;
                            };
                            (Value::Integer(whole), Value::Integer(beyond))
                        }
                        Some(number) => {
                            let number = number.as_f64().unwrap();
                            let off = sign as f64 * (1e-12 + 1e-6 * number.abs());
                            (Value::Float(number), Value::Float(number + off))
                        }
                    };
                    let answer = |document: &Table, value: &Value| {
                        let mut document = document.clone();
                        put(&mut document, &path, value.clone())?;
                        Some((reader.read)(&document.to_string()))
                    };
                    let in_it = |answer: Answer| match answer {
                        Answer::OutOfRange(range) => !path.join(".").starts_with(&range.key),
                        Answer::Taken | Answer::Refused => true,
                    };
                    let kept = reader.documents.iter().any(|document| {
                        answer(document, &at).is_some_and(in_it)
                            && answer(document, &beyond).is_some_and(|of| of != Answer::Taken)
                    });
                    let reached = reader
                        .documents
                        .iter()
                        .any(|document| answer(document, &at).is_some());
                    assert!(kept || !reached, "{end} of {}: {stated}", path.join("."));
                    ends_checked += usize::from(reached);
                }
            }
        }
        assert!(ends_checked > 300, "{ends_checked}");
    }

    /// A range that depends on another key would be wrong in some other file.
    #[test]
    fn no_other_key_decides_a_range_that_is_stated() {
        let mut tried = 0;
        // Scenarios would take a minute.
        for (schema, reader) in all().into_iter().take(2) {
            let mut seen = BTreeSet::new();
            for document in &reader.documents {
                let stated = |place: &Place| {
                    let number = schema.pointer(&place.pointer).unwrap();
                    number.get("maximum").is_some()
                };
                let places: Vec<(Vec<String>, Range, Range)> = numbers(&schema)
                    .iter()
                    .filter(|place| stated(place) && !seen.contains(&entry(place)))
                    .filter_map(|place| {
                        let ends = ends_of_type(&schema, place);
                        let range = asked(document, &reader, &entry(place), ends)?;
                        Some((entry(place), ends, range))
                    })
                    .collect();
                seen.extend(places.iter().map(|(path, ..)| path.clone()));
                let mut others = Vec::new();
                let whole = Value::Table(document.clone());
                leaves(&whole, &mut Vec::new(), &mut others);
                for (other, value) in &others {
                    let taken = changes(*value).into_iter().find_map(|near| {
                        let mut changed = document.clone();
                        put(&mut changed, other, near)?;
                        ((reader.read)(&changed.to_string()) == Answer::Taken).then_some(changed)
                    });
                    let Some(changed) = taken else { continue };
                    for (path, ends, range) in places.iter().filter(|(path, ..)| path != other) {
                        let now = asked(&changed, &reader, path, *ends);
                        assert!(
                            now.is_none_or(|now| now == *range),
                            "{} decides the range of {}",
                            other.join("."),
                            path.join(".")
                        );
                        tried += 1;
                    }
                }
            }
        }
        assert!(tried > 3_000, "{tried}");
    }

    /// Returns ends that differ from every stated range, since a schema states a range in place of the type's ends.
    fn ends_of_type(schema: &Json, place: &Place) -> Range {
        match schema.pointer(&place.pointer).unwrap()["type"] == "integer" {
            true => (0.0, f64::from(u16::MAX)),
            false => (-BEYOND, BEYOND),
        }
    }
}
