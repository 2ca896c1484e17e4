//! File made from a schema alone, with all of its keys.

use serde_json::{Map, Value, json};
use toml::Table;

/// Returns a file with every key of the schema called `name`.
pub fn complete(name: &str) -> Table {
    let schema = help::schemas::schema(name).unwrap();
    let value = sample(&schema, &schema);
    Table::try_from(value).unwrap()
}

fn resolve<'a>(root: &'a Value, node: &'a Value) -> &'a Value {
    match node["$ref"].as_str() {
        Some(target) => resolve(root, root.pointer(&target[1..]).unwrap()),
        None => node,
    }
}

fn sample(root: &Value, node: &Value) -> Value {
    let node = resolve(root, node);
    if let Some(value) = node.get("const") {
        return value.clone();
    }
    for keyword in ["enum", "oneOf", "anyOf"] {
        if let Some(value) = node[keyword].as_array().and_then(|values| values.last()) {
            return match keyword {
                "enum" => value.clone(),
                // If a word or a pattern is allowed, the word.
                _ if value.get("pattern").is_some() => sample(root, &node[keyword][0]),
                _ => sample(root, value),
            };
        }
    }
    match node["type"].as_str().unwrap() {
        "object" => {
            let properties = node["properties"].as_object().unwrap();
            let filled = properties
                .iter()
                .map(|(key, schema)| (key.clone(), sample(root, schema)));
            Value::Object(filled.collect::<Map<_, _>>())
        }
        "array" => {
            let count = node["minItems"].as_u64().unwrap_or(1) as usize;
            Value::Array(vec![sample(root, &node["items"]); count])
        }
        "integer" => node["minimum"].clone(),
        "number" => node.get("minimum").cloned().unwrap_or(json!(1.5)),
        "boolean" => json!(true),
        "string" if node["format"] == "date-time" => json!("2026-01-01T00:00:00Z"),
        "string" if node.get("pattern").is_some() => json!("0".repeat(64)),
        "string" => json!("x"),
        kind => panic!("{kind}"),
    }
}

/// Returns the keys that the schema allows in the table with the unknown key `0`.
pub fn keys_beside_unknown(schema: &Value, table: &Table) -> Vec<String> {
    let instance = serde_json::to_value(table).unwrap();
    find(schema, schema, &instance).unwrap()
}

fn find(root: &Value, node: &Value, instance: &Value) -> Option<Vec<String>> {
    let node = resolve(root, node);
    match instance {
        Value::Object(table) => {
            let properties = node["properties"].as_object()?;
            if table.contains_key("0") {
                return Some(properties.keys().cloned().collect());
            }
            table
                .iter()
                .find_map(|(key, value)| find(root, properties.get(key)?, value))
        }
        Value::Array(entries) => find(root, node.get("items")?, entries.first()?),
        _ => None,
    }
}
