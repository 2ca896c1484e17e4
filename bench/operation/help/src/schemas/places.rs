//! Places of the numbers of a schema in a file.

use serde_json::Value;

/// Number in a file, and its schema.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    /// Keys from the file's root; `0` is a list's first table, and the key of a list of numbers stands for every entry.
    pub path: Vec<String>,
    /// JSON pointer to the number's schema.
    pub pointer: String,
    /// Whether the number is an entry of a list.
    pub in_list: bool,
}

/// Returns the places of all numbers.
pub(crate) fn numbers(schema: &Value) -> Vec<Place> {
    let mut places = Vec::new();
    walk(schema, String::new(), Vec::new(), false, &mut places);
    places
}

fn walk(root: &Value, pointer: String, path: Vec<String>, in_list: bool, places: &mut Vec<Place>) {
    let Some(node) = root.pointer(&pointer) else {
        return;
    };
    if let Some(target) = node.get("$ref").and_then(Value::as_str) {
        let target = target.trim_start_matches('#').to_owned();
        walk(root, target, path.clone(), in_list, places);
    }
    if let Some(Value::Object(properties)) = node.get("properties") {
        for key in properties.keys() {
            let child_path = [path.as_slice(), std::slice::from_ref(key)].concat();
            let pointer = format!("{pointer}/properties/{key}");
            walk(root, pointer, child_path, false, places);
        }
    }
    if let Some(items) = node.get("items") {
        let tables = items.get("$ref").is_some() || items.get("properties").is_some();
        let item_path = match tables {
            true => [path.as_slice(), &["0".to_owned()]].concat(),
            false => path.clone(),
        };
        // Lists of lists are skipped.
        if items.get("items").is_none() {
            walk(root, format!("{pointer}/items"), item_path, !tables, places);
        }
    }
    if let Some(Value::Array(alternatives)) = node.get("anyOf") {
        for index in 0..alternatives.len() {
            let pointer = format!("{pointer}/anyOf/{index}");
            walk(root, pointer, path.clone(), in_list, places);
        }
    }
    let kind = node.get("type").and_then(Value::as_str);
    if matches!(kind, Some("number" | "integer")) {
        places.push(Place {
            path,
            pointer,
            in_list,
        });
    }
}
