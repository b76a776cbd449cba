//! Line and column of a JSON pointer (RFC 6901) in a JSON text, and the strictness that `serde_json` lacks: no
//! duplicate keys, no number beyond f64.

use jsonc_parser::ast::{Object, Value};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use std::collections::HashSet;

/// Line and column, both from 1, columns in characters.
pub(super) type LineCol = (usize, usize);

/// Which half of `"key": value` an error concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MemberPart {
    /// The name: unknown, misspelt, forbidden.
    Key,
    /// The value.
    Value,
}

/// RFC 8259: no comments, trailing commas, hexadecimal. NaN passes here and is named by [`check_value`].
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: true,
    allow_extended_string_escapes: false,
};

/// Syntax, duplicate keys and number range; the error is a position and the problem in words.
pub(super) fn check(text: &str) -> Result<(), (LineCol, String)> {
    let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT).map_err(|e| {
        (
            line_col(text, e.range().start),
            lower_first(&e.kind().to_string()),
        )
    })?;
    let root = parsed
        .value
        .ok_or_else(|| ((1, 1), "the file is empty".to_owned()))?;
    check_value(&root).map_err(|(offset, problem)| (line_col(text, offset), problem))
}

/// The place of `pointer`, or of the deepest ancestor that exists.
pub(super) fn position(text: &str, pointer: &str, part: MemberPart) -> LineCol {
    let ast = parse_to_ast(text, &CollectOptions::default(), &STRICT)
        .ok()
        .and_then(|parsed| parsed.value);
    ast.map_or((1, 1), |root| {
        line_col(text, offset_of(&root, pointer, part))
    })
}

/// Line and column of a byte offset.
pub(super) fn line_col(text: &str, offset: usize) -> LineCol {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

/// The unescaped steps of a JSON pointer.
pub(super) fn steps(pointer: &str) -> impl Iterator<Item = String> {
    pointer
        .split('/')
        .skip(1)
        .map(|step| step.replace("~1", "/").replace("~0", "~"))
}

/// One step of a JSON pointer, escaped, with its slash.
pub(super) fn step(name: &str) -> String {
    format!("/{}", name.replace('~', "~0").replace('/', "~1"))
}

fn offset_of(root: &Value<'_>, pointer: &str, part: MemberPart) -> usize {
    let (mut node, mut offset) = (root, root.start());
    for name in steps(pointer) {
        let next = match node {
            Value::Object(object) => object.get(&name).map(|p| {
                (
                    &p.value,
                    if part == MemberPart::Key {
                        p.range.start
                    } else {
                        p.value.start()
                    },
                )
            }),
            Value::Array(array) => name
                .parse::<usize>()
                .ok()
                .and_then(|i| array.elements.get(i))
                .map(|v| (v, v.start())),
            _ => None,
        };
        let Some((value, start)) = next else {
            return node.start();
        };
        (node, offset) = (value, start);
    }
    offset
}

fn check_value(value: &Value<'_>) -> Result<(), (usize, String)> {
    match value {
        Value::Object(object) => check_object(object),
        Value::Array(array) => array.elements.iter().try_for_each(check_value),
        Value::NumberLit(n) if !n.value.parse::<f64>().is_ok_and(f64::is_finite) => Err((
            n.range.start,
            format!("{} is not a finite double-precision number", n.value),
        )),
        _ => Ok(()),
    }
}

fn check_object(object: &Object<'_>) -> Result<(), (usize, String)> {
    let mut seen = HashSet::new();
    for property in &object.properties {
        let name = property.name.as_str();
        if !seen.insert(name) {
            return Err((
                property.range.start,
                format!("the key `{name}` appears twice in the same object"),
            ));
        }
        check_value(&property.value)?;
    }
    Ok(())
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars
        .next()
        .map_or(String::new(), |c| c.to_lowercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "{\n  \"é\": {\"a/b\": [1, 22, {\"~\": 3}]},\n  \"z\": null\n}";

    #[test]
    fn pointers_lead_to_line_and_column() {
        assert_eq!(position(TEXT, "", MemberPart::Value), (1, 1));
        assert_eq!(position(TEXT, "/é/a~1b/1", MemberPart::Value), (2, 20));
        assert_eq!(position(TEXT, "/é/a~1b/2/~0", MemberPart::Value), (2, 30));
        assert_eq!(position(TEXT, "/é/a~1b", MemberPart::Key), (2, 9));
        assert_eq!(position(TEXT, "/z", MemberPart::Value), (3, 8));
    }

    #[test]
    fn a_missing_member_is_placed_at_its_deepest_ancestor() {
        assert_eq!(position(TEXT, "/é/missing/x", MemberPart::Value), (2, 8));
        assert_eq!(position(TEXT, "/é/a~1b/9", MemberPart::Value), (2, 16));
    }

    #[test]
    fn loose_json_is_refused_with_its_place() {
        for (text, place, word) in [
            ("{\"a\": NaN}", (1, 7), "NaN"),
            ("{\"a\": [1,\n -1e999]}", (2, 2), "-1e999"),
            ("{\"a\": 1,\n \"a\": 2}", (2, 2), "twice"),
            ("{\"a\": 1,}", (1, 8), "comma"),
            ("{\"a\": 1} // note", (1, 10), "omment"),
            ("", (1, 1), "empty"),
        ] {
            let (at, problem) = check(text).expect_err(text);
            assert_eq!(at, place, "{text}: {problem}");
            assert!(problem.contains(word), "{problem}");
        }
        assert_eq!(check(TEXT), Ok(()));
    }
}
