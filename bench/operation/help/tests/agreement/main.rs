//! Tests that a schema accepts and refuses the same files as their reader.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod files;
mod sample;
mod validator;

use files::{accepts_structure, shipped_files, unknown_key};
use serde_json::Value;
use toml::Table;
use validator::Validator;

fn as_json(table: &Table) -> Value {
    serde_json::to_value(table).unwrap()
}

#[test]
fn every_schema_is_one_of_2020_12() {
    for name in help::schemas::names() {
        let schema = help::schemas::schema(name).unwrap();
        assert_eq!(
            schema["$schema"],
            "https://json-schema.org/draft/2020-12/schema"
        );
        drop(Validator::new(name));
        assert!(help::schemas::list().contains(name));
    }
    assert_eq!(help::schemas::schema("bnech"), None);
}

#[test]
fn every_file_that_comes_with_the_program_is_valid() {
    for name in help::schemas::names() {
        let mut validator = Validator::new(name);
        let files = shipped_files(name);
        assert!(!files.is_empty(), "{name}");
        for (file, table) in files {
            let errors = validator.errors(&as_json(&table));
            assert!(errors.is_empty(), "{file}: {errors:#?}");
            assert!(accepts_structure(name, &table), "{file}");
        }
    }
}

/// The first line tells an editor which schema to use.
#[test]
fn a_first_line_that_names_a_schema_is_read() {
    let text = format!("#:schema ./bench.schema.json\n{}", config::TEMPLATE);
    assert_eq!(
        config::Config::parse(&text, "bench.toml").unwrap(),
        config::Config::parse(config::TEMPLATE, "bench.toml").unwrap()
    );
}

/// Returns copies of a value, each with one change in one of its tables and lists.
fn variants(value: &toml::Value, change: &dyn Fn(&Table) -> Vec<Table>) -> Vec<toml::Value> {
    match value {
        toml::Value::Table(table) => {
            let own_variants = change(table).into_iter().map(toml::Value::Table);
            let child_variants = table.iter().flat_map(|(key, value)| {
                variants(value, change).into_iter().map(|value| {
                    let mut table = table.clone();
                    table.insert(key.clone(), value);
                    toml::Value::Table(table)
                })
            });
            own_variants.chain(child_variants).collect()
        }
        toml::Value::Array(entries) => match entries.first() {
            Some(first) => variants(first, change)
                .into_iter()
                .map(|value| {
                    let mut entries = entries.clone();
                    entries[0] = value;
                    toml::Value::Array(entries)
                })
                .collect(),
            None => Vec::new(),
        },
        _ => Vec::new(),
    }
}

/// Requires schema and reader to agree on every change of every file; returns the number of changes that both refused.
fn both_agree(change: &dyn Fn(&Table) -> Vec<Table>) -> usize {
    let mut refusals = 0;
    for name in help::schemas::names() {
        let mut validator = Validator::new(name);
        let mut samples = shipped_files(name);
        // A few files suffice: the one made from the schema has every key.
        samples.truncate(2);
        samples.push(("sample".to_owned(), sample::complete(name)));
        for (file, table) in samples {
            for variant in variants(&toml::Value::Table(table.clone()), change) {
                let toml::Value::Table(variant) = variant else {
                    unreachable!()
                };
                let schema_accepts = validator.errors(&as_json(&variant)).is_empty();
                let reader_accepts = accepts_structure(name, &variant);
                assert_eq!(schema_accepts, reader_accepts, "{name}, {file}:\n{variant}");
                refusals += usize::from(!schema_accepts);
            }
        }
    }
    refusals
}

fn with_entry(table: &Table, key: &str, value: impl Into<toml::Value>) -> Table {
    let mut table = table.clone();
    table.insert(key.to_owned(), value.into());
    table
}

#[test]
fn a_misspelt_key_is_refused() {
    let misspell = |table: &Table| {
        let misspelt_table = |(key, value): (&String, &toml::Value)| {
            let mut table = table.clone();
            table.remove(key);
            with_entry(&table, &format!("{key}x"), value.clone())
        };
        table.iter().map(misspelt_table).collect()
    };
    assert!(both_agree(&misspell) > 500);
}

#[test]
fn a_key_that_is_left_out_is_missed_or_not_by_both() {
    let leave_out = |table: &Table| {
        let without_key = |key: &String| {
            let mut table = table.clone();
            table.remove(key);
            table
        };
        table.keys().map(without_key).collect()
    };
    assert!(both_agree(&leave_out) > 100);
}

#[test]
fn a_wrong_type_and_an_unknown_word_are_refused() {
    let wrong_types = |table: &Table| {
        let wrong_values = |(key, value): (&String, &toml::Value)| match value {
            toml::Value::String(_) => vec![
                with_entry(table, key, "no such word"),
                with_entry(table, key, true),
                with_entry(table, key, vec!["fx"]),
            ],
            toml::Value::Integer(_) => vec![
                with_entry(table, key, "7"),
                with_entry(table, key, true),
                with_entry(table, key, -1e9),
            ],
            toml::Value::Float(_) => {
                vec![with_entry(table, key, "7.0"), with_entry(table, key, false)]
            }
            toml::Value::Boolean(_) => {
                vec![with_entry(table, key, "true"), with_entry(table, key, 1)]
            }
            toml::Value::Array(_) => vec![
                with_entry(table, key, 1.0),
                with_entry(table, key, Table::new()),
            ],
            _ => vec![with_entry(table, key, 1.0), with_entry(table, key, "table")],
        };
        table.iter().flat_map(wrong_values).collect()
    };
    assert!(both_agree(&wrong_types) > 500);
}

/// Schema and reader have the same keys.
#[test]
fn every_table_has_the_keys_of_its_reader() {
    let mut tables = 0;
    for name in help::schemas::names() {
        let schema = help::schemas::schema(name).unwrap();
        let sample = sample::complete(name);
        assert!(accepts_structure(name, &sample), "{name}:\n{sample}");
        let add_unknown = |table: &Table| vec![with_entry(table, "0", true)];
        for variant in variants(&toml::Value::Table(sample.clone()), &add_unknown) {
            let toml::Value::Table(variant) = variant else {
                unreachable!()
            };
            let mut reader_keys = unknown_key(name, &variant);
            let mut schema_keys = sample::keys_beside_unknown(&schema, &variant);
            // The sum of the file is taken off before it is read; that of a sweep is a key.
            for keys in [&mut schema_keys, &mut reader_keys] {
                keys.retain(|key| key != "sha256");
            }
            reader_keys.sort();
            schema_keys.sort();
            assert_eq!(reader_keys, schema_keys, "{name}:\n{variant}");
            tables += 1;
        }
    }
    assert!(tables > 70, "{tables}");
}
