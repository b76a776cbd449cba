//! `occlab probe`.

use super::print_path;
use super::render::name_and_value;
use super::scene::SceneOptions;
use occlab::Error;
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::oracle::{LightColumn, Oracle};
use occlab::probe::Probe as Curves;
use occlab::scene::MapFit;
use std::collections::HashSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

/// Texels of the map whose rectangle --column refers to: the default of every method with a map.
const RESOLUTION: u32 = 512;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("where").required(true))]
pub struct ProbeArgs {
    #[command(flatten)]
    scene: SceneOptions,
    /// Column and row of a pixel, from 0 at the top left: its light column passes where half of the ray's light is
    /// scattered.
    #[arg(long, value_name = "X,Y", group = "where", value_parser = pair::<u32>)]
    pixel: Option<[u32; 2]>,
    /// Place in the rectangle of the light map, 0…1 each.
    #[arg(long, value_name = "U,V", group = "where", value_parser = pair::<f64>)]
    column: Option<[f64; 2]>,
    /// Method to draw; may be repeated. Without it, every method.
    #[arg(long = "method", short, value_name = "ID")]
    methods: Vec<String>,
    /// Parameter of those of the methods that have it, e.g. `steps=200`; may be repeated.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Chart; the numbers go beside it as .csv.
    #[arg(long, short, value_name = "FILE.svg", default_value = "probe.svg")]
    out: PathBuf,
}

/// Two values with a comma between them.
fn pair<T: FromStr>(text: &str) -> Result<[T; 2], String> {
    let values = text
        .split_once(',')
        .map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match values {
        Some((Ok(a), Ok(b))) => Ok([a, b]),
        _ => Err("write two numbers with a comma between them, e.g. 80,45".to_owned()),
    }
}

impl ProbeArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let extension = self.out.extension().and_then(|e| e.to_str());
        if extension != Some("svg") {
            return Err(Error::input(
                "--out",
                format!("`{}` does not end in .svg", self.out.display()),
                "Name a file with this ending.",
            )
            .into());
        }
        let (scene, image) = (self.scene.load()?, self.scene.image()?);
        self.check(image.width, image.height)?;
        let setups = self.setups()?;
        let oracle = Oracle::new(&scene, image)?;
        let (column, seen_m, place) = self.find(&oracle)?;
        let curves = match self.methods.is_empty() && self.set.is_empty() {
            true => Curves::new(&oracle, &column)?,
            false => Curves::of(&oracle, &column, &setups)?,
        };
        let elevation_deg = scene.sun.elevation_deg;
        let place = [place].into_iter().chain(self.set.iter().cloned());
        let place = place.collect::<Vec<_>>().join(" · ");
        let of = format!("{} · sun {elevation_deg}° · {place}", scene.name);
        occlab::report::write_probe(&self.out, &curves, &of, seen_m)?;
        print_path(&self.out.with_extension("csv"))?;
        print_path(&self.out)?;
        Ok(ExitCode::SUCCESS)
    }

    /// The methods with their settings.
    fn setups(&self) -> occlab::Result<Vec<MethodSetup>> {
        let registered = REGISTRY.iter().map(|m| m.info());
        let others = registered.filter(|info| !info.is_truth());
        let all = others.map(|info| info.id.to_owned()).collect();
        let mut ids: Vec<String> = match self.methods.is_empty() {
            true => all,
            false => self.methods.clone(),
        };
        let mut seen = HashSet::new();
        ids.retain(|id| seen.insert(id.clone()));
        let setups = ids.iter().map(|id| MethodSetup::defaults(id));
        let mut setups: Vec<_> = setups.collect::<occlab::Result<_>>()?;
        for pair in &self.set {
            let (name, value) = name_and_value(pair)?;
            let mut having = setups
                .iter_mut()
                .filter(|setup| setup.params.get(name).is_some())
                .peekable();
            if having.peek().is_none() {
                let problem = format!("none of the methods has a parameter `{name}`");
                let remedy = "`occlab methods` lists the parameters of each.";
                return Err(Error::input(format!("--set {pair}"), problem, remedy));
            }
            for setup in having {
                *setup = setup.clone().with(name, value)?;
            }
        }
        Ok(setups)
    }

    /// Refuses positions that no scene can have, before the scene's clouds are made.
    fn check(&self, width: u32, height: u32) -> occlab::Result<()> {
        if let Some([x, y]) = self.pixel
            && (x >= width || y >= height)
        {
            return Err(Error::input(
                "--pixel",
                format!("{x},{y} is outside the picture of {width}×{height} pixels"),
                "Count from 0 at the top left, or set --width and --height.",
            ));
        }
        match self.column {
            Some([u, v]) if ![u, v].iter().all(|c| (0.0..=1.0).contains(c)) => Err(Error::input(
                "--column",
                format!("{u},{v} is outside the map"),
                "Give two numbers from 0 to 1.",
            )),
            _ => Ok(()),
        }
    }

    /// The column, the depth of the pixel's point on it, and both in words.
    fn find(&self, oracle: &Oracle) -> occlab::Result<(LightColumn, Option<f64>, String)> {
        if let Some([x, y]) = self.pixel {
            let Some(point) = oracle.pixel_point(x, y) else {
                return Err(Error::input(
                    "--pixel",
                    format!("there is no cloud on the ray of pixel {x},{y}"),
                    "Choose a pixel that shows cloud; `occlab render` makes the picture.",
                ));
            };
            let seen_m = oracle.light_depth_m(point);
            let column = oracle.column_through(point);
            return Ok((column, Some(seen_m), format!("pixel {x},{y}")));
        }
        let [u, v] = self.column.unwrap_or_default();
        match oracle.map_column([u, v], RESOLUTION, MapFit::Square) {
            Some(column) => Ok((column, None, format!("map column {u},{v}"))),
            None => Err(Error::input(
                "--column",
                format!("the light at {u},{v} of the map meets nothing of the layer"),
                "Choose a place nearer to 0.5,0.5.",
            )),
        }
    }
}
