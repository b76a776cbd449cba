//! Draws a [`Chart`] as SVG: title, legend, data and foot, on a sheet of the height that they need.

use super::canvas::{measured, sheet};
use super::chart::{Chart, Data};
use super::plot::{BELOW, Key, foot, legend, title};
use super::{plane, rows};
use crate::error::Result;

impl Chart {
    /// The chart as SVG; `None` without anything to draw.
    pub fn svg(&self) -> Result<Option<String>> {
        let (keys, data_height) = match &self.data {
            Data::Plane(data) if data.has_points() => (plane::keys(data), plane::HEIGHT),
            Data::Rows(data) if !data.rows.is_empty() => (data.keys.clone(), rows::height(data)),
            _ => return Ok(None),
        };
        // A long legend makes the sheet higher, not the plot smaller.
        let height = measured(|canvas| {
            let top = self.head(canvas, &keys)?;
            Ok(top + data_height + BELOW)
        })?;
        let svg = sheet(height, |canvas| {
            let top = self.head(canvas, &keys)?;
            match &self.data {
                Data::Plane(data) => plane::draw(canvas, data, top, height)?,
                Data::Rows(data) => rows::draw(canvas, data, top, height)?,
            }
            foot(canvas, &self.source, height, &self.note)
        })?;
        Ok(Some(svg))
    }

    /// Draws title and legend; returns the row where the data start, px.
    fn head(&self, canvas: &super::canvas::Canvas<'_>, keys: &[(Key, String)]) -> Result<i32> {
        let top = title(canvas, &self.title, &self.of)?;
        if keys.is_empty() {
            return Ok(top);
        }
        legend(canvas, top, keys)
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::{AxisSpec, Scale};
    use super::super::chart::{DASHED, GREY, Look, Plane, Point, PointSeries};
    use super::*;

    fn chart(series: Vec<PointSeries>) -> Chart {
        Chart {
            title: "What".to_owned(),
            of: "of what".to_owned(),
            data: Data::Plane(Plane {
                x: AxisSpec::new("x", Scale::Log),
                y: AxisSpec::new("y", Scale::Linear),
                series,
                levels: Vec::new(),
                places: Vec::new(),
            }),
            source: "a source".to_owned(),
            note: String::new(),
        }
    }

    fn series(label: &str, y: &[f64]) -> PointSeries {
        let points = y.iter().enumerate();
        PointSeries {
            label: label.to_owned(),
            style: GREY,
            look: Look::Line(DASHED),
            points: points.map(|(i, y)| Point::at(1.0 + i as f64, *y)).collect(),
        }
    }

    fn height(svg: &str) -> u32 {
        let rest = svg.split("height=\"").nth(1).expect("height");
        let digits = rest.split('"').next().expect("digits");
        digits.parse().expect("a number")
    }

    #[test]
    fn a_chart_without_points_is_not_drawn() {
        assert_eq!(chart(Vec::new()).svg().expect("chart"), None);
        assert_eq!(chart(vec![series("a", &[])]).svg().expect("chart"), None);
    }

    #[test]
    fn a_long_legend_makes_the_sheet_higher() {
        let drawn = |n: usize| {
            let label = |i: usize| format!("a method with a setting of many words, number {i}");
            let series = (0..n).map(|i| series(&label(i), &[1.0, 2.0])).collect();
            chart(series).svg().expect("chart").expect("points")
        };
        assert!(height(&drawn(12)) > height(&drawn(2)));
        let same = chart(vec![series("a", &[1.0]), series("a", &[2.0])]);
        let svg = same.svg().expect("chart").expect("points");
        assert_eq!(svg.matches("\na\n").count(), 1, "one entry a label");
    }

    #[test]
    fn what_is_not_finite_breaks_the_line_and_is_named() {
        let lines = |y: &[f64]| {
            let svg = chart(vec![series("a", y)]).svg();
            svg.expect("chart").expect("points")
        };
        assert!(lines(&[1.0, f64::NAN, 2.0]).contains("not finite"));
        assert!(!lines(&[1.0, 1.5, 2.0]).contains("not finite"));
    }
}
