//! Records → csv, charts, page.
