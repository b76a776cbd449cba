//! The oracle: scenes, methods and the truth in f64 on the CPU.
//!
//! The oracle is written from the equations and shares no code with the shaders. It shares with the CPU part of the
//! device path: the scene's geometry in f64, the placement of the map, the sky's coefficients and the bounds of empty
//! space. It serves tests (device against oracle), the split of an error into model, sampling and precision (see
//! [`Options`]), sweeps of single columns ([`Occlusion::along`]), and pictures where no adapter exists. The crate's
//! first page has an example.

mod counted_ray;
mod field;
mod layer;
mod light;
mod map;
mod march;
mod probe;

pub use crate::density::Filter;
pub use light::{Occlusion, Options};
pub use march::Pixel;

use crate::error::{Error, Result};
use crate::frame::{Frame, MAX_PIXELS};
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;
use crate::scene::{Ambient, ImageSize, Scene, Sky, SkyModel};
use field::OracleField;
use glam::DVec3;
use layer::{LayerRay, UNLIMITED_M};
use std::sync::Arc;

/// A scene prepared for one image size.
pub struct Oracle {
    scene: Scene,
    image: ImageSize,
    field: Arc<OracleField>,
    /// Unit vector toward the sun.
    sun: DVec3,
    /// Irradiance perpendicular to the beam, × sun_gain, RGB.
    irradiance: DVec3,
    /// The sky, and the radiance of the ground where a ray meets it.
    sky: Option<(SkyModel, DVec3)>,
    /// Ambient radiance at the layer's base and top, RGB.
    ambient: Option<(DVec3, DVec3)>,
}

/// The straight path of light through the layer, from the sun side to where it leaves or meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct LightColumn(LayerRay);

impl LightColumn {
    /// Metres inside the layer.
    pub fn length_m(&self) -> f64 {
        self.0.length_m()
    }

    /// The point `depth_m` metres inside.
    pub fn point(&self, depth_m: f64) -> DVec3 {
        self.0.point(depth_m)
    }
}

impl Oracle {
    /// Builds the density field of a valid `scene`; noise and calibration of procedural clouds take a few seconds.
    pub fn new(scene: &Scene, image: ImageSize) -> Result<Self> {
        Self::filtered(scene, image, Filter::Exact)
    }

    /// [`Oracle::new`] with noise textures filtered as `filter` says.
    pub fn filtered(scene: &Scene, image: ImageSize, filter: Filter) -> Result<Self> {
        Self::over(Arc::new(OracleField::new(scene, filter)?), scene, image)
    }

    /// An oracle for another scene or image size; the density field is kept where the scenes have the same.
    pub fn again(&self, scene: &Scene, image: ImageSize) -> Result<Self> {
        let same = self.scene.density == scene.density
            && self.scene.container == scene.container
            && self.scene.medium.extinction_per_m == scene.medium.extinction_per_m;
        if same {
            Self::over(self.field.clone(), scene, image)
        } else {
            Self::filtered(scene, image, self.field.filter())
        }
    }

    fn over(field: Arc<OracleField>, scene: &Scene, image: ImageSize) -> Result<Self> {
        let pixels = u64::from(image.width) * u64::from(image.height);
        if !(1..=MAX_PIXELS).contains(&pixels) {
            return Err(Error::input(
                "image",
                format!(
                    "{} × {} pixels, allowed are 1 to {MAX_PIXELS} in all",
                    image.width, image.height
                ),
                "Choose another size.",
            ));
        }
        let sun = scene.sun.direction();
        let sky = scene.sky.as_ref().map(
            |Sky::Preetham {
                 turbidity,
                 ground_albedo,
             }| SkyModel::new(*turbidity, sun, *ground_albedo),
        );
        let derived = || sky.as_ref().map_or([0.0; 3], SkyModel::sun_irradiance_klx);
        let irradiance = scene.sun.irradiance.unwrap_or_else(derived);
        let ambient = scene.ambient.as_ref().map(|ambient| match ambient {
            Ambient::Uniform { radiance } => (DVec3::from(*radiance), DVec3::from(*radiance)),
            Ambient::Sky { base, top } => {
                let mean = sky.as_ref().map_or([0.0; 3], SkyModel::mean_radiance);
                (DVec3::from(mean) * *base, DVec3::from(mean) * *top)
            }
        });
        Ok(Self {
            scene: scene.clone(),
            image,
            field,
            sun,
            irradiance: DVec3::from(irradiance) * scene.medium.sun_gain,
            sky: sky.map(|sky| {
                let ground = sky.ground_radiance().into();
                (sky, ground)
            }),
            ambient,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Picture size.
    pub fn image(&self) -> ImageSize {
        self.image
    }

    /// Prepares a method in this scene.
    pub fn prepare(&self, setup: &MethodSetup, options: Options) -> Result<Occlusion<'_>> {
        Occlusion::new(self, self, setup, options)
    }

    /// [`Self::prepare`] with the light map of another scene or camera: that of an earlier frame, where the map is filled
    /// over several.
    pub fn prepare_with_map_of<'a>(
        &'a self,
        earlier: &Oracle,
        setup: &MethodSetup,
        options: Options,
    ) -> Result<Occlusion<'a>> {
        Occlusion::new(self, earlier, setup, options)
    }

    /// Renders one picture.
    pub fn render(&self, setup: &MethodSetup, options: Options) -> Result<Frame> {
        Ok(self.prepare(setup, options)?.render(&mut unwatched)?.0)
    }

    /// Identifies imported data; empty for fields that the scene's JSON determines.
    pub fn content_hash(&self) -> String {
        self.field.content_hash()
    }

    /// How noise textures are filtered.
    pub fn filter(&self) -> Filter {
        self.field.filter()
    }

    /// The truth, at the scene's own light step.
    pub fn truth(&self) -> Result<MethodSetup> {
        MethodSetup::truth(&self.scene)
    }

    /// The light column through a point, metres.
    pub fn column_through(&self, p: DVec3) -> LightColumn {
        LightColumn(LayerRay::new(
            &self.scene.container,
            p,
            -self.sun,
            (-UNLIMITED_M, UNLIMITED_M),
        ))
    }

    /// Extinction at a point inside the container, m⁻¹.
    pub fn extinction_per_m(&self, p: DVec3) -> f64 {
        self.field.extinction_per_m(p)
    }

    /// Weather thresholds that give the decks of a procedural field their coverage; empty for other fields.
    pub fn thresholds(&self) -> &[f64] {
        self.field.thresholds()
    }
}
