//! The numbers of a cell that are not errors against its truth: one row each.

use super::{CellNumber, Getter, PagePlace, Repeats};
use crate::metrics::{Format, Recorded};

/// Rows of [`CellNumber`] by the members of [`Measured`](crate::batch::record::Measured) that hold the value, so that
/// name and getter agree. `part?.member` is a member of a part that a record may lack; `or` is the value where it does.
macro_rules! rows {
    ($(
        $first:ident $(. $next:ident)* $(? . $leaf:ident)? {
            label: $label:literal, unit: $unit:literal, format: $format:ident, shown: $shown:ident,
            $(or: $absent:literal,)? $(study: $study:literal,)? $(repeats: $repeats:ident,)?
            doc: $doc:literal
        }
    )+) => {
        pub(super) const ROWS: &[CellNumber] = &[
            $(CellNumber {
                path: concat!(stringify!($first), $(".", stringify!($next),)* $(".", stringify!($leaf))?),
                label: $label,
                unit: $unit,
                format: Format::$format,
                shown: PagePlace::$shown,
                doc: $doc,
                study: rows!(@option $($study)?),
                repeats: rows!(@option $($repeats)?),
                negative: false,
                get: Getter::Cell(|measured| {
                    let value = rows!(@value measured.$first$(.$next)* $(, $leaf)?);
                    $(let value = value.or(Some($absent));)?
                    value
                }),
            },)+
        ];
    };
    (@option) => { None };
    (@option $value:expr) => { Some($value) };
    (@value $place:expr, $leaf:ident) => { $place.as_ref().and_then(|part| part.$leaf.recorded()) };
    (@value $place:expr) => { $place.recorded() };
}

/// The total time, or the wall time where no cell of the report has one.
const TOTAL: Repeats = Repeats {
    rounds: |measured| &measured.rounds_total_ms,
    stats: |measured, clock| clock.cost(&measured.time_ms),
};

const MAP_PASS: Repeats = Repeats {
    rounds: |measured| &measured.rounds_generate_ms,
    stats: |measured, _| measured.time_ms.generate,
};

rows! {
    time_ms.total?.median {
        label: "Total", unit: "ms", format: Number, shown: Cells, study: "total_ms", repeats: TOTAL,
        doc: "median over the rounds of the device time of one picture, all passes together; a round's time is the median of \
            frames that were handed over together; absent without timestamps, and where these are invalid"
    }
    time_ms.total?.min {
        label: "min", unit: "ms", format: Number, shown: Cells,
        doc: "smallest of the rounds' total times; single frames scatter more"
    }
    time_ms.total?.p95 {
        label: "p95", unit: "ms", format: Number, shown: Cells,
        doc: "95th percentile (nearest rank) of the rounds' total times; single frames scatter more"
    }
    time_ms.total?.cv {
        label: "CV", unit: "", format: Percent, shown: Cells,
        doc: "standard deviation over mean of the rounds' total times; single frames scatter more"
    }
    time_ms.total?.n {
        label: "n", unit: "", format: Integer, shown: Cells,
        doc: "number of rounds that have a total time"
    }
    time_ms.generate?.median {
        label: "Map pass", unit: "ms", format: Number, shown: Cells, study: "generate_ms", repeats: MAP_PASS,
        doc: "median over the rounds of the device time of the map pass; absent without a map and without timestamps"
    }
    time_ms.march?.median {
        label: "March", unit: "ms", format: Number, shown: Cells,
        doc: "median over the rounds of the device time of the view march; absent without timestamps"
    }
    time_ms.reconstruct?.median {
        label: "Reconstruct", unit: "ms", format: Number, shown: Cells,
        doc: "median over the rounds of the device time of the pass that adds what was not marched; absent where every pixel is"
    }
    time_ms.wall?.median {
        label: "Wall", unit: "ms", format: Number, shown: Cells,
        doc: "submission to completion of the frames of a round seen from the CPU, divided by their number, median over the \
            rounds; it stands for the total where no cell has one"
    }
    time_ms.wall?.n {
        label: "Wall n", unit: "", format: Integer, shown: Cells,
        doc: "number of rounds that have a wall time"
    }
    memory.map_bytes {
        label: "Map", unit: "bytes", format: Bytes, shown: Cells, study: "map_bytes",
        doc: "the map's textures as allocated; 0 for methods without a map"
    }
    reconstruction?.history_bytes {
        label: "History", unit: "bytes", format: Bytes, shown: Cells, or: 0.0,
        doc: "the pictures that a reconstruction remembers; 0 where every pixel is marched"
    }
    memory.payload_bytes {
        label: "Payload", unit: "bytes", format: Bytes, shown: Cells, study: "payload_bytes",
        doc: "values × bytes a value × texels: what the encoding needs before formats round it up"
    }
    memory.allocator_bytes {
        label: "Allocator", unit: "bytes", format: Bytes, shown: Cells,
        doc: "growth that the graphics allocator reports; absent where it does not"
    }
    samples.view {
        label: "View samples", unit: "", format: Count, shown: Cells,
        doc: "density samples by view rays, counted in an untimed run"
    }
    samples.light {
        label: "Light samples", unit: "", format: Count, shown: Cells,
        doc: "density samples by light rays, counted in an untimed run"
    }
    samples.map {
        label: "Map samples", unit: "", format: Count, shown: Cells,
        doc: "density samples by the map pass, counted in an untimed run"
    }
    fallback_fraction {
        label: "Fallback", unit: "", format: Percent, shown: Cells,
        doc: "share of light look-ups outside the map that were marched instead"
    }
    cloud_pixel_fraction {
        label: "cloud pixels", unit: "", format: Number, shown: Nowhere, study: "cloud_pixel_fraction",
        doc: "share of pixels whose opacity in the truth exceeds 0.01"
    }
    look_ups {
        label: "Look-ups", unit: "", format: Count, shown: Nowhere,
        doc: "light look-ups in a map, counted in an untimed run; 0 without a map"
    }
    block {
        label: "Block", unit: "", format: Integer, shown: Clock,
        doc: "index of the first cell of the block that this one was timed in"
    }
    frames_in_flight {
        label: "Frames in flight", unit: "", format: Integer, shown: Clock,
        doc: "frames that were handed over without waiting in each round, at least"
    }
    decomposition?.model_rel_rmse {
        label: "Model", unit: "", format: Number, shown: Decomposition,
        doc: "RMS of the method in f64 with ample steps and texels, minus the f64 truth, over the truth's RMS"
    }
    decomposition?.sampling_rel_rmse {
        label: "Sampling", unit: "", format: Number, shown: Decomposition,
        doc: "RMS of the method in f64 at the cell's steps and texels, minus the same with ample ones, over the truth's RMS"
    }
    decomposition?.precision_rel_rmse {
        label: "Precision", unit: "", format: Number, shown: Decomposition,
        doc: "RMS of the cell's picture minus the f64 one at the same settings, over the truth's RMS"
    }
    decomposition?.storage_rel_rmse {
        label: "of it storage", unit: "", format: Number, shown: Decomposition,
        doc: "what rounding of stored map values does alone, all else in f64: RMS over the truth's RMS"
    }
    decomposition?.truth_rel_rmse {
        label: "Truths", unit: "", format: Number, shown: Decomposition,
        doc: "RMS of the f64 truth minus the truth that the cell was compared with, over the truth's RMS"
    }
    decomposition?.ample_steps {
        label: "Ample steps", unit: "", format: Number, shown: Decomposition,
        doc: "steps that count as ample; absent for a method without steps"
    }
    decomposition?.ample_resolution {
        label: "Ample texels", unit: "", format: Number, shown: Decomposition,
        doc: "texels along an edge that count as ample; absent without a map"
    }
    reconstruction?.full_rel_rmse {
        label: "Error at rest", unit: "", format: Number, shown: Reconstruction,
        doc: "relative RMSE against the full render by the same method, of a camera at rest, once its picture changes no more"
    }
    time_ms.generate?.min {
        label: "Map pass, min", unit: "ms", format: Number, shown: Nowhere, doc: "smallest of the rounds' map pass times"
    }
    time_ms.generate?.p95 {
        label: "Map pass, p95", unit: "ms", format: Number, shown: Nowhere, doc: "95th percentile of the rounds' map pass times"
    }
    time_ms.generate?.cv {
        label: "Map pass, CV", unit: "", format: Percent, shown: Nowhere, doc: "standard deviation over mean of the map pass times"
    }
    time_ms.generate?.n {
        label: "Map pass, n", unit: "", format: Integer, shown: Nowhere, doc: "number of rounds that have a map pass time"
    }
    time_ms.march?.min {
        label: "March, min", unit: "ms", format: Number, shown: Nowhere, doc: "smallest of the rounds' march times"
    }
    time_ms.march?.p95 {
        label: "March, p95", unit: "ms", format: Number, shown: Nowhere, doc: "95th percentile of the rounds' march times"
    }
    time_ms.march?.cv {
        label: "March, CV", unit: "", format: Percent, shown: Nowhere, doc: "standard deviation over mean of the march times"
    }
    time_ms.march?.n {
        label: "March, n", unit: "", format: Integer, shown: Nowhere, doc: "number of rounds that have a march time"
    }
    time_ms.reconstruct?.min {
        label: "Reconstruct, min", unit: "ms", format: Number, shown: Nowhere, doc: "smallest of the rounds' reconstruction times"
    }
    time_ms.reconstruct?.p95 {
        label: "Reconstruct, p95", unit: "ms", format: Number, shown: Nowhere,
        doc: "95th percentile of the rounds' reconstruction times"
    }
    time_ms.reconstruct?.cv {
        label: "Reconstruct, CV", unit: "", format: Percent, shown: Nowhere,
        doc: "standard deviation over mean of the reconstruction times"
    }
    time_ms.reconstruct?.n {
        label: "Reconstruct, n", unit: "", format: Integer, shown: Nowhere,
        doc: "number of rounds that have a reconstruction time"
    }
    time_ms.wall?.min {
        label: "Wall, min", unit: "ms", format: Number, shown: Nowhere, doc: "smallest of the rounds' wall times"
    }
    time_ms.wall?.p95 {
        label: "Wall, p95", unit: "ms", format: Number, shown: Nowhere, doc: "95th percentile of the rounds' wall times"
    }
    time_ms.wall?.cv {
        label: "Wall, CV", unit: "", format: Percent, shown: Nowhere, doc: "standard deviation over mean of the wall times"
    }
}
