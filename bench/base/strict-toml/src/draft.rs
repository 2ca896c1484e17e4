//! Reading of a file as far as possible: after each error the faulty key is replaced by a stand-in, and reading goes on.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::place::line_at;
use crate::toml_error::TomlError;
use crate::toml_file::{Failure, attempt};

/// Largest number of errors reported of one file.
const MOST_ERRORS: usize = 50;

/// Stand-in for a missing table.
const TABLE: &str = "{}";
/// Values that may stand in for a missing one: the first of the key's type is taken.
const STAND_INS: [&str; 6] = ["1", "0.5", "\"x\"", "true", "[]", TABLE];

/// A file that was read as far as possible.
#[derive(Debug)]
pub struct Draft<T> {
    /// The value, with stand-ins for missing and wrong keys; `None` if no stand-in makes the file readable.
    pub value: Option<T>,
    /// Errors, by line; those of missing keys, which have no line, are last.
    pub errors: Vec<TomlError>,
    /// Dotted paths of the keys with stand-ins.
    stand_ins: Vec<String>,
}

impl<T> Draft<T> {
    /// Returns whether the file itself determines the table of the key at the dotted `path`: none of its keys is a
    /// stand-in.
    pub fn determines(&self, path: &str) -> bool {
        let table = first_part(path);
        !self.stand_ins.iter().any(|key| first_part(key) == table)
    }
}

fn first_part(path: &str) -> &str {
    path.split('.').next().unwrap_or(path)
}

/// Reads `text` into `T` as far as possible, with all its errors; `file` only names the file in errors. See
/// [`parse`](crate::parse) for the requirements on `T`.
pub fn read<T: DeserializeOwned>(text: &str, file: &str) -> Draft<T> {
    let mut repair = Repair {
        sheet: Sheet::new(text),
        errors: Vec::new(),
        stand_ins: Vec::new(),
        file,
    };
    let value = repair.read();
    repair
        .errors
        .sort_by_key(|error| error.line().unwrap_or(usize::MAX));
    Draft {
        value,
        errors: repair.errors,
        stand_ins: repair.stand_ins,
    }
}

struct Repair<'a> {
    sheet: Sheet,
    errors: Vec<TomlError>,
    stand_ins: Vec<String>,
    file: &'a str,
}

impl Repair<'_> {
    fn read<T: DeserializeOwned>(&mut self) -> Option<T> {
        while self.errors.len() < MOST_ERRORS {
            let failure = match self.attempt() {
                Ok(value) => return Some(value),
                Err(failure) => *failure,
            };
            match &failure.error {
                TomlError::MissingKey { table, key, .. } => {
                    let (table, key) = (table.clone(), key.clone());
                    self.report(&failure.error, &path(table.as_deref(), &key));
                    if !self.stand_in::<T>(table.as_deref(), &key) {
                        return None;
                    }
                }
                error => {
                    let found = failure.offset.filter(|_| self.sheet.is_toml());
                    let Some(key) = found.and_then(|offset| self.sheet.entry_at(offset)) else {
                        // Once a key was repaired, the text may be the repair's.
                        if self.errors.is_empty() {
                            self.errors.push(failure.error);
                        }
                        return None;
                    };
                    let mut error = error.clone();
                    error.move_to(self.sheet.line_in_file(key.range.start));
                    if self.errors.contains(&error) {
                        return None;
                    }
                    self.stand_ins.push(match &error {
                        // The key that was meant is missing only because it is misspelt.
                        TomlError::UnknownKey {
                            nearest: Some(meant),
                            ..
                        } => path(parent(&key.path), meant),
                        _ => key.path,
                    });
                    self.errors.push(error);
                    self.sheet.blank(key.range);
                }
            }
        }
        None
    }

    fn attempt<T: DeserializeOwned>(&self) -> Result<T, Box<Failure>> {
        attempt(&self.sheet.text(), self.file)
    }

    /// Adds the error of a missing key, unless the key or its whole table was reported before.
    fn report(&mut self, error: &TomlError, path: &str) {
        let is_within = |key: &String| {
            path == key
                || path
                    .strip_prefix(key.as_str())
                    .is_some_and(|rest| rest.starts_with('.'))
        };
        if !self.stand_ins.iter().any(is_within) {
            self.errors.push(error.clone());
        }
    }

    /// Adds a value of the right type for a missing key; returns whether one was found.
    fn stand_in<T: DeserializeOwned>(&mut self, table: Option<&str>, key: &str) -> bool {
        self.stand_ins.push(path(table, key));
        let mut candidates: Vec<String> = STAND_INS.map(str::to_owned).into();
        while !candidates.is_empty() {
            let candidate = candidates.remove(0);
            let before = self.sheet.clone();
            let Some(inserted) = self.sheet.insert(table, key, &candidate) else {
                return false;
            };
            let Err(failure) = self.attempt::<T>() else {
                return true;
            };
            let is_refused = failure
                .offset
                .is_some_and(|offset| inserted.contains(&self.sheet.line_index(offset)));
            match failure.error {
                TomlError::UnknownValue { allowed, .. } if is_refused => {
                    // The first allowed word is of the type.
                    candidates.clear();
                    candidates.extend(allowed.first().map(|word| format!("{word:?}")));
                }
                // The key is missing from another entry of an array too.
                TomlError::MissingKey {
                    table: lacking,
                    key: again,
                    ..
                } if lacking.as_deref() == table && again == key => return false,
                TomlError::MissingKey { .. } => return true,
                _ if !is_refused => return true,
                _ => {}
            }
            self.sheet = before;
        }
        false
    }
}

fn path(table: Option<&str>, key: &str) -> String {
    table.map_or_else(|| key.to_owned(), |table| format!("{table}.{key}"))
}

/// Returns the path of the table of a key.
fn parent(path: &str) -> Option<&str> {
    path.rsplit_once('.').map(|(table, _)| table)
}

/// A file's lines in the course of a repair, each with its line in the file.
#[derive(Clone)]
struct Sheet {
    lines: Vec<(usize, String)>,
}

/// A key with its value; elements of an array without their index.
struct Entry {
    path: String,
    range: Range<usize>,
}

impl Sheet {
    fn new(text: &str) -> Self {
        let lines = text.split('\n').map(str::to_owned);
        Self {
            lines: (1..).zip(lines).collect(),
        }
    }

    fn text(&self) -> String {
        let lines: Vec<&str> = self.lines.iter().map(|(_, line)| line.as_str()).collect();
        lines.join("\n")
    }

    fn is_toml(&self) -> bool {
        DeTable::parse(&self.text()).is_ok()
    }

    /// Returns the index of the line with the byte at `offset`.
    fn line_index(&self, offset: usize) -> usize {
        line_at(&self.text(), offset) - 1
    }

    fn line_in_file(&self, offset: usize) -> usize {
        let index = self.line_index(offset);
        self.lines.get(index).map_or(1, |(line, _)| *line)
    }

    /// Inserts a key at the beginning of its table, in each entry without it if the table is an array; returns the indices
    /// of the new lines, or `None` if the table has no header.
    fn insert(&mut self, table: Option<&str>, key: &str, value: &str) -> Option<Vec<usize>> {
        let mut inserted = Vec::new();
        if value == TABLE {
            // Below a header, missing keys can be inserted.
            self.lines.push((1, format!("[{}]", path(table, key))));
            return Some(vec![self.lines.len() - 1]);
        }
        let Some(table) = table else {
            self.lines.insert(0, (1, format!("{key} = {value}")));
            return Some(vec![0]);
        };
        let mut index = 0;
        while index < self.lines.len() {
            if header(&self.lines[index].1) == Some(table) && !self.has_key(index, key) {
                let line = self.lines[index].0;
                self.lines
                    .insert(index + 1, (line, format!("{key} = {value}")));
                inserted.push(index + 1);
            }
            index += 1;
        }
        (!inserted.is_empty()).then_some(inserted)
    }

    /// Returns whether the table with its header at `index` has the key.
    fn has_key(&self, index: usize, key: &str) -> bool {
        let entries = self.lines[index + 1..].iter().map(|(_, line)| line);
        entries
            .take_while(|line| header(line).is_none())
            .any(|line| {
                line.split_once('=')
                    .is_some_and(|(name, _)| name.trim() == key)
            })
    }

    /// Returns the innermost key with the byte at `offset` in itself or in its value.
    fn entry_at(&self, offset: usize) -> Option<Entry> {
        let text = self.text();
        let root = DeTable::parse(&text).ok()?;
        innermost(root.get_ref(), offset, "")
    }

    /// Replaces a key and its value by blanks; of a table's header, the whole table.
    fn blank(&mut self, range: Range<usize>) {
        let first = self.line_index(range.start);
        if header(&self.lines[first].1).is_some() {
            for (i, (_, line)) in self.lines.iter_mut().enumerate().skip(first) {
                if i > first && header(line).is_some() {
                    break;
                }
                line.clear();
            }
            return;
        }
        let mut bytes = self.text().into_bytes();
        for byte in &mut bytes[range] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        for ((_, line), blanked) in self.lines.iter_mut().zip(text.split('\n')) {
            blanked.clone_into(line);
        }
    }
}

/// Returns the name in a table's header.
fn header(line: &str) -> Option<&str> {
    let name = line.trim_start().strip_prefix('[')?;
    let name = name.strip_prefix('[').unwrap_or(name);
    name.split_once(']').map(|(name, _)| name.trim())
}

fn innermost(table: &DeTable<'_>, offset: usize, parent: &str) -> Option<Entry> {
    table.iter().find_map(|(key, value)| {
        let path = path(
            Some(parent).filter(|parent| !parent.is_empty()),
            key.get_ref(),
        );
        let range = key.span().start..value.span().end.max(key.span().end);
        let inner = match value.get_ref() {
            DeValue::Table(inner) => innermost(inner, offset, &path),
            DeValue::Array(entries) => entries.iter().find_map(|entry| match entry.get_ref() {
                DeValue::Table(inner) => innermost(inner, offset, &path),
                _ => None,
            }),
            _ => None,
        };
        inner.or_else(|| range.contains(&offset).then_some(Entry { path, range }))
    })
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "read only")]
    struct Rig {
        name: String,
        plate: Plate,
        inputs: Vec<Input>,
        mode: Mode,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "read only")]
    struct Plate {
        length_m: f64,
        holes: u32,
        #[serde(default)]
        is_glass: bool,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "read only")]
    struct Input {
        label: String,
        gain: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Mode {
        Bare,
        Loaded,
    }

    const GOOD: &str = "name = \"a\"\nmode = \"bare\"\n\n[plate]\nlength_m = 0.1\nholes = 2\n\n[[inputs]]\nlabel = \
                        \"x\"\ngain = 1.0\n";

    fn messages(text: &str) -> Vec<String> {
        let draft: Draft<Rig> = read(text, "rig.toml");
        let errors = draft.errors.iter().map(ToString::to_string);
        errors
            .map(|error| error.replace("rig.toml", ""))
            .map(|error| error.split("; known here").next().unwrap_or("").to_owned())
            .collect()
    }

    #[test]
    fn a_file_without_errors_is_its_value() {
        let draft: Draft<Rig> = read(GOOD, "rig.toml");
        let value = draft.value.as_ref().unwrap();
        assert_eq!(value.name, "a");
        assert!(matches!(value.mode, Mode::Bare));
        assert!(draft.errors.is_empty() && draft.determines("plate.holes"));
    }

    #[test]
    fn all_missing_keys_are_named_at_once_and_a_missing_table_by_itself() {
        let text = GOOD.replace("holes = 2\n", "").replace("gain = 1.0\n", "");
        assert_eq!(
            messages(&text),
            [
                ", table [inputs]: key `gain` is missing",
                ", table [plate]: key `holes` is missing",
            ]
        );
        assert_eq!(
            messages("[plate]\nlength_m = 0.1\n"),
            [
                ", table [plate]: key `holes` is missing",
                ": key `name` is missing",
                ": key `inputs` is missing",
                ": key `mode` is missing",
            ]
        );
        assert_eq!(messages("").len(), 4);
    }

    #[test]
    fn errors_of_every_kind_keep_their_lines_in_the_file() {
        let text = GOOD
            .replace("\"bare\"", "\"bear\"")
            .replace("length_m", "lenght_m")
            .replace("holes = 2", "holes = \"2\"")
            .replace("gain = 1.0", "gain = \"high\"\ncolour = 3");
        let messages = messages(&text);
        assert_eq!(
            messages,
            [
                ", line 2: unknown value `bear`, did you mean `bare`?; allowed: `bare`, `loaded`",
                ", line 5: unknown key `lenght_m`, did you mean `length_m`?",
                ", line 6, key `plate.holes`: \"2\" is text; write the number without quotes",
                ", line 10, key `inputs.gain`: the text \"high\" is not allowed; write a number",
                ", line 11: unknown key `colour`",
            ]
        );
    }

    #[test]
    fn an_unknown_table_is_one_error_and_the_others_follow() {
        let text = GOOD.replace("[plate]", "[plaet]");
        assert_eq!(
            messages(&text),
            [", line 4: unknown key `plaet`, did you mean `plate`?"]
        );
    }

    #[test]
    fn a_table_with_a_stand_in_is_not_determined_by_the_file() {
        let draft: Draft<Rig> = read(&GOOD.replace("holes = 2\n", ""), "rig.toml");
        assert!(draft.value.is_some());
        assert!(!draft.determines("plate.length_m") && draft.determines("inputs.0.gain"));
    }

    #[test]
    fn a_text_that_is_not_toml_has_one_error() {
        assert_eq!(messages(&GOOD.replace("holes = 2", "holes 2")).len(), 1);
    }
}
