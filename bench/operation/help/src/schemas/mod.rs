//! JSON Schemas (2020-12) of the TOML files that people edit: an editor completes their keys, explains them and marks
//! values that the bench would refuse.
//!
//! Keys, types, defaults and descriptions come from the types that the files are read into. Ranges are obtained from the
//! reader itself, by values that it must refuse, so that each is stated only once.
//!
//! ```
//! let schema: serde_json::Value = help::schemas::schema("bench").unwrap();
//! let length = schema.pointer("/$defs/Plate/properties/length_m").unwrap();
//! assert_eq!((&length["minimum"], &length["maximum"]), (&0.01.into(), &1.0.into()));
//! ```

mod for_toml;
mod places;
mod ranges;
mod readers;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::{Value, json};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;

/// Names of the schemas, the file that each describes, and the purpose of the file.
pub const SCHEMAS: [(&str, &str, &str); 5] = [
    (
        "bench",
        "bench.toml",
        "the bench: sound card, plate, sensors, limits",
    ),
    (
        "calibration",
        "calibration.toml",
        "what calibrations measured; written by the program alone",
    ),
    (
        "protocol",
        "PROTOCOL.toml",
        "a protocol of participants' sessions, for run",
    ),
    (
        "scenario",
        "SCENARIO.toml",
        "a simulated bench and its participant, for --mock",
    ),
    (
        "recording",
        "recording.toml",
        "what a recording is of, and how its samples become volts and metres",
    ),
];

/// Returns the names of the schemas.
#[must_use]
pub fn names() -> [&'static str; SCHEMAS.len()] {
    SCHEMAS.map(|(name, ..)| name)
}

/// Returns a line for each schema: its name, its file, and the purpose of the file.
#[must_use]
pub fn list() -> String {
    let line = |(name, file, description): &(&str, &str, &str)| {
        format!("{name:<12} {file:<17} {description}\n")
    };
    SCHEMAS.iter().map(line).collect()
}

/// Returns the schema called `name`; `None` for any other name.
#[must_use]
pub fn schema(name: &str) -> Option<Value> {
    let mut schema = match name {
        "bench" => ranges::with_ranges(schema_for::<config::Config>(), &readers::bench()),
        "calibration" => with_hash(schema_for::<config::CalibrationFile>()),
        "protocol" => {
            ranges::with_ranges(schema_for::<protocols::Protocol>(), &readers::protocol())
        }
        "scenario" => ranges::with_ranges(
            schema_for::<mock_world::scenario::Scenario>(),
            &readers::scenario(),
        ),
        "recording" => schema_for::<recording::manifest::Manifest>(),
        _ => return None,
    };
    let file = SCHEMAS.iter().find(|(known, ..)| *known == name)?.1;
    schema["title"] = json!(file);
    Some(schema)
}

/// Returns the text of the schema called `name`; `None` for any other name.
#[must_use]
pub fn schema_text(name: &str) -> Option<String> {
    schema(name).map(|schema| format!("{schema:#}\n"))
}

fn schema_for<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_deserialize();
    let mut schema: Schema = settings.into_generator().into_root_schema_for::<T>();
    for_toml::adapt(&mut schema);
    schema.to_value()
}

/// Adds the first line of a calibration, which is read before the rest.
fn with_hash(mut schema: Value) -> Value {
    schema["properties"]["sha256"] = json!({
        "description": "Hash over the rest of the file, by which an edited one is noticed; the first line.",
        "type": "string",
        "pattern": "^[0-9a-f]{64}$"
    });
    if let Some(Value::Array(required)) = schema.get_mut("required") {
        required.push(json!("sha256"));
    }
    schema
}
