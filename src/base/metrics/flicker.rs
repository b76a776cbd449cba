//! Flicker over a sequence of frames, and the error over all of them.

use super::{delta_rgb, mean_sun};
use crate::error::{Error, Result};
use crate::frame::Frame;

/// √mean (Δₜ − Δₜ₋₁)² / mean L over consecutive frames, gathered frame by frame; ≥ 0, dimensionless.
///
/// Δ is the signed error of each RGB channel of a frame against *its own* truth ([`delta_rgb`]), mean L the mean over
/// the truths of [`mean_sun`]. A constant error does not flicker. A pixel counts in a pair of frames where both truths
/// show the cloud, so that sky does not dilute the number.
#[derive(Clone, Debug, Default)]
pub struct Flicker {
    /// Δ of the last frame; NaN = no cloud.
    before: Option<Vec<f32>>,
    /// Σ(Δₜ − Δₜ₋₁)².
    squared: f64,
    /// Terms of that sum.
    changes: u64,
    /// Sum of mean L.
    light: f64,
    frames: u32,
    /// ΣΔ² of all frames.
    squared_error: f64,
    /// ΣL² of the truths of all frames, over the same channels.
    squared_reference: f64,
}

impl Flicker {
    /// Adds the next frame and its truth.
    pub fn add(&mut self, truth: &Frame, test: &Frame) -> Result<()> {
        let mean = mean_sun(truth)?;
        let delta = delta_rgb(truth, test)?;
        let channels = truth.sun.iter().flat_map(|[r, g, b, _]| [r, g, b]);
        for (delta, value) in delta.iter().zip(channels).filter(|(d, _)| !d.is_nan()) {
            self.squared_error += f64::from(*delta).powi(2);
            self.squared_reference += f64::from(*value).powi(2);
        }
        self.add_delta(delta, mean)
    }

    fn add_delta(&mut self, delta: Vec<f32>, mean: f64) -> Result<()> {
        let before = self.before.as_deref().unwrap_or(&delta);
        if before.len() != delta.len() {
            return refuse("the frames differ in size");
        }
        if self.before.is_some() {
            for (old, new) in before.iter().zip(&delta) {
                let change = f64::from(*new) - f64::from(*old);
                if change.is_finite() {
                    self.squared += change * change;
                    self.changes += 1;
                }
            }
        }
        self.before = Some(delta);
        self.light += mean;
        self.frames += 1;
        Ok(())
    }

    /// The flicker, ≥ 0; an [`Error::Input`] when no pixel shows the cloud in two consecutive frames.
    pub fn value(&self) -> Result<f64> {
        if self.changes == 0 {
            return refuse("no pixel shows the cloud in two consecutive frames");
        }
        let mean = self.light / f64::from(self.frames);
        Ok((self.squared / self.changes as f64).sqrt() / mean)
    }

    /// √(ΣΔ² / ΣL²) over all frames: `rel_rmse` of the sequence; an [`Error::Input`] when no pixel shows sun-lit cloud.
    pub fn rel_rmse(&self) -> Result<f64> {
        match self.squared_reference > 0.0 {
            true => Ok((self.squared_error / self.squared_reference).sqrt()),
            false => refuse("no pixel shows sun-lit cloud"),
        }
    }
}

fn refuse<T>(problem: &str) -> Result<T> {
    let remedy = "Point the camera at a sun-lit cloud that stays in the picture.";
    Err(Error::input("flicker", problem, remedy))
}

#[cfg(test)]
mod tests {
    use super::super::compare;
    use super::super::testing::{cloud, uniform};
    use super::*;

    fn of(deltas: &[Vec<f32>], mean: f64) -> Result<f64> {
        let mut flicker = Flicker::default();
        for delta in deltas {
            flicker.add_delta(delta.clone(), mean)?;
        }
        flicker.value()
    }

    #[test]
    fn a_static_error_has_none_and_an_alternating_one_the_analytic_value() {
        assert_eq!(of(&vec![vec![0.3; 12]; 16], 0.5).unwrap(), 0.0);
        let sign = |t: u32| if t.is_multiple_of(2) { 0.25 } else { -0.25 };
        let alternating: Vec<_> = (0..16).map(|t| vec![sign(t); 12]).collect();
        assert_eq!(of(&alternating, 0.5).unwrap(), 1.0);
        // One change of 1 in two steps of two values: √(1/4) / 2.
        let once = [vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 0.0]];
        assert_eq!(of(&once, 2.0).unwrap(), 0.25);
    }

    #[test]
    fn each_frame_is_measured_against_its_own_truth() {
        let (mut follows, mut stays) = (Flicker::default(), Flicker::default());
        for t in 0..16_u32 {
            let level = if t.is_multiple_of(2) { 0.25 } else { 0.75 };
            let truth = uniform(4, 4, level);
            follows.add(&truth, &uniform(4, 4, level + 0.125)).unwrap();
            stays.add(&truth, &uniform(4, 4, 0.5)).unwrap();
        }
        assert_eq!(
            follows.value().unwrap(),
            0.0,
            "a changing scene is no flicker"
        );
        assert_eq!(stays.value().unwrap(), 1.0, "an error of ±0.25 over 0.5 is");
    }

    #[test]
    fn the_error_of_a_sequence_is_that_of_its_frames() {
        let (truth, test) = (cloud(4, 4), uniform(4, 4, 0.3));
        let one = compare(&truth, &test).unwrap().error.rel_rmse;
        let mut flicker = Flicker::default();
        for _ in 0..3 {
            flicker.add(&truth, &test).unwrap();
        }
        assert!((flicker.rel_rmse().unwrap() - one).abs() < 1e-6);
        flicker.add(&truth, &truth).unwrap();
        let diluted = one * (0.75_f64).sqrt();
        assert!((flicker.rel_rmse().unwrap() - diluted).abs() < 1e-6);
        assert!(Flicker::default().rel_rmse().is_err());
    }

    #[test]
    fn absent_values_do_not_dilute() {
        let frames = [vec![0.0, f32::NAN], vec![1.0, 5.0], vec![2.0, f32::NAN]];
        assert_eq!(of(&frames, 1.0).unwrap(), 1.0);
    }

    #[test]
    fn flicker_without_a_meaning_is_an_error() {
        let frame = vec![0.0; 4];
        for deltas in [
            vec![],
            vec![frame.clone()],
            vec![frame.clone(), vec![0.0; 3]],
            vec![vec![f32::NAN; 4]; 3],
        ] {
            assert!(matches!(of(&deltas, 1.0), Err(Error::Input { .. })));
        }
        let (dark, lit) = (uniform(4, 4, 0.0), cloud(4, 4));
        assert!(Flicker::default().add(&dark, &lit).is_err());
    }
}
