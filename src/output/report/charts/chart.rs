//! Description of a chart: title, axes, series or rows. Every chart of the program (of a batch report, a study, the
//! stability sweep, the probe) is a [`Chart`], drawn by [`Chart::svg`].

use super::super::style::{Marker, Style};
use super::axis::AxisSpec;
use super::plot::Key;

/// One chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title of the chart.
    pub title: String,
    /// Subtitle: scene and sun, or another subject.
    pub of: String,
    /// Axes and data.
    pub data: Data,
    /// Source of the numbers, drawn at the foot; may be empty.
    pub source: String,
    /// Note on how to read the chart, drawn at the foot; may be empty.
    pub note: String,
}

/// Axes and data of a chart.
#[derive(Clone, Debug)]
pub enum Data {
    /// Two axes.
    Plane(Plane),
    /// One axis and labelled rows of bars.
    Rows(Rows),
}

/// A chart with two axes.
#[derive(Clone, Debug)]
pub struct Plane {
    /// The horizontal axis.
    pub x: AxisSpec,
    /// The vertical axis.
    pub y: AxisSpec,
    /// Series, in the order of the legend.
    pub series: Vec<PointSeries>,
    /// Values of y with a horizontal line.
    pub levels: Vec<f64>,
    /// Values of x with a vertical line, and the legend entry of each.
    pub places: Vec<(f64, String)>,
}

/// A series of points in one style.
#[derive(Clone, Debug)]
pub struct PointSeries {
    /// Legend entry; empty: none. Series with the same label share an entry.
    pub label: String,
    /// Colour and marker.
    pub style: Style,
    /// How the points are drawn.
    pub look: Look,
    /// The points, in the order of the line.
    pub points: Vec<Point>,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// A line with a filled marker at every point.
    Line(Dash),
    /// A solid line of many points with filled markers: index of the first marked point, and points per marker.
    Sparse(usize, usize),
    /// A line without markers, with its width in px.
    Bare(Dash, u32),
    /// Filled markers without a line.
    Points,
    /// Hollow markers without a line.
    Hollow,
    /// Hollow markers on a thin dotted line, for published values.
    Published,
    /// A Pareto frontier as a staircase: at each x the smallest y of all points up to it. True: with rings on points.
    Frontier(bool),
    /// Filled columns from the foot of the plot, each over its range of x.
    Columns,
    /// A strip under the upper edge of the plot, over each point's range of x.
    Strip,
}

/// A point of a series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Horizontal value.
    pub x: f64,
    /// Vertical value. A value that is not finite interrupts the line and is marked under the upper edge.
    pub y: f64,
    /// Smallest and largest plausible x.
    pub x_range: Option<[f64; 2]>,
    /// Smallest and largest plausible y.
    pub y_range: Option<[f64; 2]>,
    /// Label beside the point, drawn where there is room.
    pub label: String,
}

impl Point {
    /// A point without ranges and label.
    pub fn at(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }
}

/// Dash pattern: lengths drawn and skipped in turn, px; empty: a solid line.
pub type Dash = &'static [f64];

/// A solid line.
pub const SOLID: Dash = DASHES[0];
/// Dashes.
pub const DASHED: Dash = DASHES[1];
/// Dots.
pub const DOTTED: Dash = DASHES[2];

const DASHES: [Dash; 5] = [
    &[],
    &[7.0, 4.0],
    &[2.0, 3.0],
    &[10.0, 3.0, 2.0, 3.0],
    &[14.0, 5.0],
];

/// Dash pattern of the line with this rank among those of one method.
pub fn dash(rank: usize) -> Dash {
    DASHES[rank % DASHES.len()]
}

/// A chart with one axis and labelled rows of bars.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The horizontal axis.
    pub axis: AxisSpec,
    /// Entries of the legend.
    pub keys: Vec<(Key, String)>,
    /// Rows from top to bottom.
    pub rows: Vec<ChartRow>,
}

/// One row: a label with its bars.
#[derive(Clone, Debug)]
pub struct ChartRow {
    /// Label at the left.
    pub label: String,
    /// Colour and marker.
    pub style: Style,
    /// Bars, one below the other.
    pub bars: Vec<Bar>,
}

/// One bar of a row.
#[derive(Clone, Debug)]
pub struct Bar {
    /// Name of the bar, where a row has several; else empty.
    pub name: &'static str,
    /// How it is drawn.
    pub shape: Shape,
    /// Text of the number at the bar's end.
    pub text: String,
}

/// How a bar is drawn.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Stacked parts from 0, each with its right end and opacity, then the lower and upper end of the total's range.
    Parts(Vec<(f64, f64)>, Option<[f64; 2]>),
    /// A hollow marker and a filled one, joined by a line.
    Pair(f64, f64),
}

impl Shape {
    /// All values that the axis must include.
    pub(super) fn values(&self) -> Vec<f64> {
        match self {
            Self::Parts(parts, range) => {
                let ends = parts.iter().map(|(end, _)| *end);
                ends.chain(range.iter().flatten().copied()).collect()
            }
            Self::Pair(from, to) => vec![*from, *to],
        }
    }
}

/// Style of series and rows that belong to no method.
pub const GREY: Style = Style {
    rgb: (0x55, 0x55, 0x55),
    marker: Marker::Circle,
};
