//! Calibration of coverage: the weather threshold at which a deck covers the wanted share of columns.

use super::device::{SHADER, defs, field_values};
use super::{Deck, Procedural};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Inputs, Kernel, Program, Resource, UniformValue, read_buffer};

/// Columns along one axis, and samples a column, for the calibration of coverage.
pub(super) const CALIBRATION_COLUMNS: u32 = 160;
pub(super) const CALIBRATION_STEPS: u32 = 96;
/// Optical depth at which a column's opacity is 0.5.
const HALF_OPAQUE_TAU: f32 = std::f32::consts::LN_2;

/// (threshold, measured share) by bisection: the share that `measure` finds grows with the threshold.
pub(super) fn search(
    index: usize,
    deck: &Deck,
    measure: impl Fn(f64) -> Result<f64>,
) -> Result<(f64, f64)> {
    if deck.coverage <= 0.0 {
        return Ok((0.0, measure(0.0)?));
    }
    let most = measure(1.0)?;
    if deck.coverage >= 1.0 || most <= deck.coverage {
        if (most - deck.coverage).abs() <= 0.03 {
            return Ok((1.0, most));
        }
        return Err(Error::input(
            format!("scene, at /density/procedural/decks/{index}/coverage"),
            format!(
                "coverage {} cannot be reached: at most {most:.2} of the columns of this deck become half opaque",
                deck.coverage
            ),
            "Make the deck thicker, its type higher, or the extinction larger.",
        ));
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if measure(middle)? < deck.coverage {
            low = middle
        } else {
            high = middle
        }
    }
    let threshold = 0.5 * (low + high);
    Ok((threshold, measure(threshold)?))
}

/// Measures columns on the device to find the weather threshold at which a deck covers the wanted share of them.
pub(super) struct Calibrator {
    kernel: Kernel,
    output: wgpu::Buffer,
}

impl Calibrator {
    pub fn new(gpu: &Gpu, field: &Procedural, container_shader: &str) -> Result<Self> {
        let program = Program {
            entry: "noise/columns.wgsl",
            roles: vec![("container", container_shader), ("density", SHADER)],
            defs: defs(field, 1),
        };
        let size = u64::from(CALIBRATION_COLUMNS).pow(2) * 4;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        Ok(Self {
            kernel: Kernel::new(gpu, &program)?,
            output: gpu.empty_buffer("columns", size, usage),
        })
    }

    /// (threshold, measured share) of a deck.
    pub fn threshold(
        &self,
        gpu: &Gpu,
        field: &Procedural,
        index: usize,
        deck: &Deck,
        scene_inputs: &Inputs,
        density_inputs: &Inputs,
    ) -> Result<(f64, f64)> {
        let measure = |threshold: f64| {
            self.covered(
                gpu,
                field,
                index,
                deck,
                threshold,
                scene_inputs,
                density_inputs,
            )
        };
        search(index, deck, measure)
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "a private closure body: the state of one measurement"
    )]
    fn covered(
        &self,
        gpu: &Gpu,
        field: &Procedural,
        index: usize,
        deck: &Deck,
        threshold: f64,
        scene_inputs: &Inputs,
        density_inputs: &Inputs,
    ) -> Result<f64> {
        let mut inputs = Inputs::default();
        inputs.uniform(
            "field",
            field_values(field, std::slice::from_ref(deck), &[threshold], index),
        );
        inputs.uniform(
            "columns",
            [
                ("tile_m", UniformValue::F32(field.weather_tile_m as f32)),
                ("base_m", UniformValue::F32(deck.base_m as f32)),
                ("top_m", UniformValue::F32(deck.top_m as f32)),
                ("count", UniformValue::U32(CALIBRATION_COLUMNS)),
                ("steps", UniformValue::U32(CALIBRATION_STEPS)),
            ],
        );
        inputs.resource("optical_depth", Resource::Buffer(self.output.clone()));
        let groups = self
            .kernel
            .bind(gpu, &[&inputs, scene_inputs, density_inputs])?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            self.kernel.dispatch(
                &mut pass,
                &groups,
                [CALIBRATION_COLUMNS, CALIBRATION_COLUMNS, 1],
            );
        }
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer(gpu, &self.output, u64::from(CALIBRATION_COLUMNS).pow(2) * 4)?;
        let columns: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(
            columns.iter().filter(|tau| **tau > HALF_OPAQUE_TAU).count() as f64
                / columns.len() as f64,
        )
    }
}
