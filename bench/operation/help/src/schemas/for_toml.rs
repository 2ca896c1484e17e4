//! Adaptation of a schema generated from serde's types to TOML and editors.

use schemars::Schema;
use schemars::transform::transform_subschemas;
use serde_json::{Map, Value, json};

/// Adapts a schema and its subschemas: TOML has no null and no integer over 2⁶³ − 1, and descriptions are read in an
/// editor, not in rustdoc.
pub(crate) fn adapt(schema: &mut Schema) {
    transform_subschemas(&mut adapt, schema);
    let Some(object) = schema.as_object_mut() else {
        return;
    };
    if let Some(Value::String(text)) = object.get_mut("description") {
        *text = in_plain_text(text);
    }
    without_null(object);
    add_bounds(object);
}

/// Removes code examples, and line breaks within a paragraph.
fn in_plain_text(text: &str) -> String {
    let prose: Vec<&str> = text.split("```").step_by(2).map(str::trim).collect();
    let prose = prose.join("\n\n");
    let paragraphs = prose
        .trim()
        .split("\n\n")
        .map(|paragraph| paragraph.replace('\n', " "));
    paragraphs.collect::<Vec<_>>().join("\n\n")
}

/// Removes null: an optional key is omitted.
fn without_null(object: &mut Map<String, Value>) {
    match object.get_mut("default") {
        Some(Value::Null) => drop(object.remove("default")),
        Some(Value::Object(table)) => keep_values(table),
        _ => {}
    }
    if let Some(Value::Array(types)) = object.get_mut("type") {
        types.retain(|kind| kind != "null");
        if let [kind] = types.as_slice() {
            let kind = kind.clone();
            object.insert("type".to_owned(), kind);
        }
    }
    if let Some(Value::Array(alternatives)) = object.get_mut("anyOf") {
        alternatives.retain(|alternative| alternative.get("type") != Some(&json!("null")));
        if let [Value::Object(schema)] = alternatives.as_slice() {
            let schema = schema.clone();
            object.remove("anyOf");
            for (key, value) in schema {
                object.entry(key).or_insert(value);
            }
        }
    }
}

fn keep_values(table: &mut Map<String, Value>) {
    table.retain(|_, value| !value.is_null());
    let tables = table.values_mut().filter_map(Value::as_object_mut);
    tables.for_each(keep_values);
}

/// Replaces formats that JSON Schema does not know with their bounds.
fn add_bounds(object: &mut Map<String, Value>) {
    let maximum = match object.get("format").and_then(Value::as_str) {
        Some("uint8") => i64::from(u8::MAX),
        Some("uint16") => i64::from(u16::MAX),
        Some("uint32") => i64::from(u32::MAX),
        Some("uint64" | "uint") => i64::MAX,
        Some("float" | "double") => {
            object.remove("format");
            return;
        }
        _ => return,
    };
    object.remove("format");
    object.entry("minimum").or_insert(json!(0));
    object.entry("maximum").or_insert(json!(maximum));
}

#[cfg(test)]
mod tests {
    use super::*;
    use schemars::json_schema;

    #[test]
    fn null_goes_and_bounds_come() {
        let mut schema = json_schema!({
            "properties": {
                "frames": { "type": ["integer", "null"], "format": "uint32", "default": null },
                "end": { "anyOf": [{ "$ref": "#/$defs/End" }, { "type": "null" }], "description": "How it ended." }
            }
        });
        adapt(&mut schema);
        let expected = json!({
            "properties": {
                "frames": { "type": "integer", "minimum": 0, "maximum": 4_294_967_295_u32 },
                "end": { "$ref": "#/$defs/End", "description": "How it ended." }
            }
        });
        assert_eq!(schema.to_value(), expected);
    }

    #[test]
    fn a_description_is_plain_text() {
        let text = "Content of the file.\n\n```\nlet manifest = 1;\n```";
        assert_eq!(in_plain_text(text), "Content of the file.");
        assert_eq!(
            in_plain_text("One\nline.\n\nAnother."),
            "One line.\n\nAnother."
        );
    }
}
