//! Readers that enforce ranges, and files that they accept.

use config::{Config, ConfigError};
use mock_world::scenario::{Scenario, ScenarioError};
use protocols::{BrokenRule, Protocol, ProtocolError};
use strict_toml::OutOfRange;
use toml::{Table, Value};

/// Answer of a reader to a text.
#[derive(Debug, PartialEq)]
pub(crate) enum Answer {
    /// The text is accepted.
    Taken,
    /// A number is outside its range.
    OutOfRange(OutOfRange),
    /// The text violates another rule.
    Refused,
}

/// Reader, and files that it accepts, in which numbers are varied.
pub(crate) struct Reader {
    /// Files; parts that one file leaves unread, such as the table of a source that is not in use, are in another.
    pub documents: Vec<Table>,
    /// Reads a text.
    pub read: fn(&str) -> Answer,
}

/// Returns the reader of `bench.toml`, with a file for each force source and for a card with its own library.
pub(crate) fn bench() -> Reader {
    let template = table(&config::whole_template());
    let with_source = |source: &str| {
        let mut document = template.clone();
        if let Some(Value::Table(force)) = document.get_mut("force") {
            force.insert("source".to_owned(), Value::from(source));
        }
        document
    };
    let mut channels = with_source("channels");
    if let Some(gauges) = channels["force"]["channels"].as_table_mut() {
        gauges.remove("cal_file");
        gauges.extend(table(
            "inputs = [2, 3]\nnewtons_per_v = [[1.0, 0.0], [0.0, 1.0]]",
        ));
    }
    channels["audio"]["input_channels"] = Value::Integer(4);
    let mut card = with_source("serial");
    if let Some(audio) = card["audio"].as_table_mut() {
        // Three blocks are queued before the converter, so they must not be long.
        audio.remove("buffer_frames");
        audio.extend(table(
            "host = \"nidaqmx\"\noutput_device = \"Dev1\"\ninput_device = \"Dev1\"\nsample_format = \"f32\"\noutput_channels = 1\n\
             input_channels = 2\nrate_hz = 100000",
        ));
    }
    Reader {
        documents: vec![
            with_source("serial"),
            card,
            channels,
            with_source("netft"),
            with_source("field-box"),
        ],
        read: |text| match Config::parse(text, "bench.toml") {
            Ok(_) => Answer::Taken,
            Err(ConfigError::Value {
                range: Some(range), ..
            }) => Answer::OutOfRange(*range),
            Err(_) => Answer::Refused,
        },
    }
}

/// Returns the reader of protocols.
pub(crate) fn protocol() -> Reader {
    Reader {
        documents: protocols::BUILT_IN.map(|(_, text)| table(text)).to_vec(),
        read: |text| match Protocol::parse(text, "protocol.toml") {
            Ok(_) => Answer::Taken,
            // A value out of its range may break a further rule.
            Err(error) => match error.faults() {
                [ProtocolError::Rule(rule), ..] => match &rule.error {
                    BrokenRule::OutOfRange(range) => Answer::OutOfRange(range.clone()),
                    _ => Answer::Refused,
                },
                _ => Answer::Refused,
            },
        },
    }
}

/// Returns the reader of scenarios, with files for either kind of force sensor.
pub(crate) fn scenario() -> Reader {
    let document = |name: &str| {
        let scenario = mock_world::scenario::built_in(name).unwrap_or_default();
        Table::try_from(scenario).unwrap_or_default()
    };
    Reader {
        documents: ["nominal", "gauges"].map(document).to_vec(),
        read: |text| match Scenario::parse(text, "scenario.toml") {
            Ok(_) => Answer::Taken,
            Err(ScenarioError::OutOfRange { range, .. }) => Answer::OutOfRange(range),
            Err(_) => Answer::Refused,
        },
    }
}

fn table(text: &str) -> Table {
    text.parse().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_document_is_taken() {
        for reader in [bench(), protocol(), scenario()] {
            for document in &reader.documents {
                assert!(!document.is_empty());
                let text = document.to_string();
                assert_eq!((reader.read)(&text), Answer::Taken, "{text}");
            }
        }
    }

    /// Without a document here, the schema would lack the ranges of a source.
    #[test]
    fn every_source_of_forces_has_a_document() {
        let schema = crate::schemas::schema("bench").unwrap();
        let sources = schema.pointer("/$defs/Source/oneOf").unwrap();
        let source_name = |document: &Table| {
            document["force"]
                .get("source")
                .map_or("serial".to_owned(), |source| {
                    source.as_str().unwrap().to_owned()
                })
        };
        let sources_read: Vec<String> = bench().documents.iter().map(source_name).collect();
        for source in sources.as_array().unwrap() {
            let source = source["const"].as_str().unwrap();
            assert!(sources_read.iter().any(|known| known == source), "{source}");
        }
    }
}
