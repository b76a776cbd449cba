//! A chart as data: what it shows, its axes, its series or rows. Every chart of the program is one [`Chart`], whoever
//! makes it (a batch report, a study, the stability sweep, the probe), and [`Chart::svg`] is the one way to draw it.

use super::super::style::{Marker, Style};
use super::axis::AxisSpec;
use super::plot::Key;

/// One chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Scene and sun, or whatever it is a chart of: a line below the title.
    pub of: String,
    /// What is drawn.
    pub data: Data,
    /// Where the numbers come from, at the foot; empty: nothing.
    pub source: String,
    /// How to read it, at the foot; empty: nothing.
    pub note: String,
}

/// What a chart draws.
#[derive(Clone, Debug)]
pub enum Data {
    /// Two axes.
    Plane(Plane),
    /// One axis and a row for each thing.
    Rows(Rows),
}

/// A chart with two axes.
#[derive(Clone, Debug)]
pub struct Plane {
    /// The horizontal axis.
    pub x: AxisSpec,
    /// The vertical axis.
    pub y: AxisSpec,
    /// What is drawn, in the order of the legend.
    pub series: Vec<PointSeries>,
    /// Values of y with a line across.
    pub levels: Vec<f64>,
    /// Values of x with a line from top to bottom, and what the legend says of each.
    pub places: Vec<(f64, String)>,
}

/// Points that look alike.
#[derive(Clone, Debug)]
pub struct PointSeries {
    /// Words of the legend; empty: not in it. Series with the same words share an entry.
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
    /// A solid line of many points: a filled marker at the point of this index, and then after every so many points.
    Sparse(usize, usize),
    /// A line without markers, so many px wide.
    Bare(Dash, u32),
    /// Filled markers alone.
    Points,
    /// Hollow markers alone.
    Hollow,
    /// Hollow markers on a thin dotted line: published, not measured.
    Published,
    /// A frontier: at each x the smallest y that can be had for it, as a staircase. True: with a ring around each point.
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
    /// Vertical value. One that is not finite breaks the line and is marked under the upper edge.
    pub y: f64,
    /// Smallest and largest plausible x.
    pub x_range: Option<[f64; 2]>,
    /// Smallest and largest plausible y.
    pub y_range: Option<[f64; 2]>,
    /// Words beside it, where there is room.
    pub label: String,
}

impl Point {
    /// A point without a spread.
    pub fn at(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }
}

/// Lengths of a line that are drawn and skipped in turn, px; none: a solid line.
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

/// What tells the lines of one method apart, by their rank among them.
pub fn dash(rank: usize) -> Dash {
    DASHES[rank % DASHES.len()]
}

/// A chart with one axis and a row for each thing.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The horizontal axis.
    pub axis: AxisSpec,
    /// What marks mean.
    pub keys: Vec<(Key, String)>,
    /// Rows from top to bottom.
    pub rows: Vec<ChartRow>,
}

/// What is known of one thing.
#[derive(Clone, Debug)]
pub struct ChartRow {
    /// Words at the left.
    pub label: String,
    /// Colour and marker.
    pub style: Style,
    /// Bars, one below the other.
    pub bars: Vec<Bar>,
}

/// One bar of a row.
#[derive(Clone, Debug)]
pub struct Bar {
    /// What it is, where a row has several; else empty.
    pub name: &'static str,
    /// How it is drawn.
    pub shape: Shape,
    /// The number in words.
    pub text: String,
}

/// How a bar is drawn.
#[derive(Clone, Debug)]
pub enum Shape {
    /// From 0: parts by their right ends and opacities, then smallest and largest plausible value of the whole.
    Parts(Vec<(f64, f64)>, Option<[f64; 2]>),
    /// A hollow marker, and a filled one at the other end of a line.
    Pair(f64, f64),
}

impl Shape {
    /// Every value of the axis that it reaches.
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

/// The style of what belongs to no method.
pub const GREY: Style = Style {
    rgb: (0x55, 0x55, 0x55),
    marker: Marker::Circle,
};
