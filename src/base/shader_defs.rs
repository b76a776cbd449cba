//! Shader definitions as plain data: methods declare them, the shader composition reads them.

use std::collections::BTreeMap;

/// Shader definitions by name: `None` for `#ifdef NAME`, a number for `#{NAME}`.
pub type Defs = BTreeMap<String, Option<i32>>;
