//! Description of an error number: name, unit, definition, number format, origin.

use super::ErrorNumbers;

/// How a number is written for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Three significant digits.
    Number,
    /// A share, in per cent.
    Percent,
    /// A share with its sign, in per cent.
    SignedPercent,
    /// Every digit of a whole number.
    Integer,
    /// A whole number in thousands, millions or billions.
    Count,
    /// Bytes in binary units.
    Bytes,
}

impl Format {
    /// The unit of the written number, for a heading: shares are recorded as fractions and written in per cent.
    pub fn unit_written(self, recorded: &'static str) -> &'static str {
        match self {
            Self::Percent | Self::SignedPercent => "%",
            Self::Number | Self::Integer | Self::Count | Self::Bytes => recorded,
        }
    }
}

/// Which of two pictures is the better one by a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// The one with the smaller value.
    Lower,
    /// The one with the larger value.
    Higher,
    /// The one whose value is closer to 0.
    Zero,
}

/// Kinds of error numbers; lists show them in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// The whole error in one number.
    Size,
    /// Signs, extremes and places of the error, in linear light.
    Linear,
    /// The difference of the tone-mapped pictures.
    Perceptual,
    /// The error in motion.
    Motion,
    /// NaN and infinite values.
    Validity,
}

/// Renders that an error number needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The picture and its truth: computed by [`super::compare`].
    Pair,
    /// Also the picture with an uncompressed map.
    Floor,
    /// The frames of a movement and their truths.
    Track,
}

/// An error number, as a row of [`super::METRICS`].
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Name in the record's `error`, in studies, in the window and in the output of `occlab diff`.
    pub key: &'static str,
    /// Dotted name in the record: the column of `cells.csv`.
    pub path: &'static str,
    /// Heading on a page.
    pub label: &'static str,
    /// Unit of the recorded value; empty for a ratio.
    pub unit: &'static str,
    /// Definition.
    pub doc: &'static str,
    /// How pages write it.
    pub format: Format,
    /// Least and largest possible value.
    pub range: [f64; 2],
    /// Which of two pictures is the better one by it.
    pub better: Better,
    /// What kind of number it is.
    pub group: Group,
    /// What has to be rendered for it.
    pub origin: Origin,
    /// Value in a record; `None` where it is absent.
    pub get: fn(&ErrorNumbers) -> Option<f64>,
}

/// A member of a record that is one number, or none.
pub trait Recorded {
    /// The number, `None` where it is absent.
    fn recorded(&self) -> Option<f64>;
}

impl Recorded for f64 {
    fn recorded(&self) -> Option<f64> {
        Some(*self)
    }
}

impl Recorded for u32 {
    fn recorded(&self) -> Option<f64> {
        Some(f64::from(*self))
    }
}

impl Recorded for u64 {
    fn recorded(&self) -> Option<f64> {
        Some(*self as f64)
    }
}

impl Recorded for usize {
    fn recorded(&self) -> Option<f64> {
        Some(*self as f64)
    }
}

impl<T: Recorded> Recorded for Option<T> {
    fn recorded(&self) -> Option<f64> {
        self.as_ref()?.recorded()
    }
}

/// Makes [`ErrorNumbers`] and [`super::METRICS`] of the same rows, so that neither can have a number that the other lacks.
///
/// A row reads `key: type { doc, label, unit, format, range, better, group, from }`. `from` is `pair(f)` with a function of
/// [`super::pair::Pair`] that computes the number, or `floor` or `track` for a number that the batch fills in. The type is
/// `f64`, `u64` or an `Option` of one; a number that reports of earlier versions lack must be an `Option`. Rows stand in the
/// order of the record.
macro_rules! error_numbers {
    ($(
        $key:ident: $type:ty {
            doc: $doc:literal,
            label: $label:literal,
            unit: $unit:literal,
            format: $format:ident,
            range: $range:expr,
            better: $better:ident,
            group: $group:ident,
            from: $from:ident $(($measure:expr))?,
        }
    )+) => {
        /// Error numbers of a picture against its truth, by the rows of [`METRICS`]. Cloud pixels, ΔL and mean L: see
        /// [`super::compare`].
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct ErrorNumbers {
            $(
                #[doc = $doc]
                pub $key: $type,
            )+
        }

        impl ErrorNumbers {
            /// The numbers that follow from one picture and its truth; the others are absent.
            pub(super) fn of_pair(pair: &Pair<'_>) -> Self {
                Self {
                    $($key: error_numbers!(@value pair, $from $(($measure))?),)+
                }
            }
        }

        /// Every error number in the order of the record. It is the only list of them: record, schema, `cells.csv`, pages,
        /// window, studies and `occlab diff` follow it.
        pub const METRICS: &[Metric] = &[
            $(Metric {
                key: stringify!($key),
                path: concat!("error.", stringify!($key)),
                label: $label,
                unit: $unit,
                doc: $doc,
                format: Format::$format,
                range: $range,
                better: Better::$better,
                group: Group::$group,
                origin: error_numbers!(@origin $from),
                get: |numbers| numbers.$key.recorded(),
            },)+
        ];
    };
    (@value $pair:ident, pair($measure:expr)) => { measured($pair, $measure) };
    (@value $pair:ident, floor) => { None };
    (@value $pair:ident, track) => { None };
    (@origin pair) => { Origin::Pair };
    (@origin floor) => { Origin::Floor };
    (@origin track) => { Origin::Track };
}
pub(super) use error_numbers;
