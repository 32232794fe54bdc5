//! Compares JSON that a command printed with the JSON Schema of that command.

use std::path::Path;

use serde_json::Value;

/// Checks what the command `name` printed.
pub(crate) fn assert_described(name: &str, printed: &Value) {
    assert_all_described(name, std::slice::from_ref(printed));
}

/// Checks all lines that the command `name` printed.
pub(crate) fn assert_all_described(name: &str, printed: &[Value]) {
    let folders = ["schema", "../protocol/inspect/schema"];
    let paths =
        folders.map(|folder| Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(format!("{name}.json")));
    let path = paths.iter().find(|path| path.exists()).unwrap_or_else(|| panic!("{name} has no JSON Schema"));
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    for line in printed {
        let problems: Vec<_> = validator.iter_errors(line).map(|error| error.to_string()).collect();
        assert!(problems.is_empty(), "{line}\nis not as {} says: {problems:#?}", path.display());
    }
}
