//! The layers of an OpenEXR file, and which of them is the picture.
//!
//! A layer is what the channels before the last dot of their names share (`beauty.R`, `ViewLayer.Combined.R`), within one
//! part of the file; channels without a dot are a layer without a name. Parts have names of their own.

use super::shown;
use crate::error::{Error, Result};
use crate::file_part::FilePart;
use exr::meta::header::Header;
use exr::prelude::Vec2;
use std::collections::BTreeMap;
use std::path::Path;

/// Most names that a message lists.
const MAX_NAMES: usize = 20;

/// Kind of a layer, by its channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LayerKind {
    /// `R`, `G` and `B`.
    Colour,
    /// `Y` alone: brightness.
    Grey,
    /// Depth, normals and whatever else is no picture.
    Other,
}

/// Channels of one part that share a prefix.
#[derive(Debug)]
pub(super) struct Layer {
    /// Index of the part.
    pub part: usize,
    part_name: Option<String>,
    /// Part of the channels' names before the last dot; empty where there is none.
    prefix: String,
    /// Index of each channel in the part, by the last component of its name.
    channels: BTreeMap<String, usize>,
    /// Channels of the sun-lit radiance that belongs to this picture; empty where there are none.
    sun: BTreeMap<String, usize>,
    /// Whether it is the sun-lit radiance of another layer: such a layer is read only when the user names it.
    is_sun: bool,
}

impl Layer {
    fn kind(&self) -> LayerKind {
        let has = |name: &str| self.channels.contains_key(name);
        if ["R", "G", "B"].into_iter().all(has) {
            LayerKind::Colour
        } else if has("Y") && !["X", "RY", "BY"].into_iter().any(has) {
            LayerKind::Grey
        } else {
            LayerKind::Other
        }
    }

    /// Channels of red, green and blue; of a grey picture all three are its brightness.
    pub fn colour(&self) -> [Option<usize>; 3] {
        let names = match self.kind() {
            LayerKind::Grey => ["Y"; 3],
            _ => ["R", "G", "B"],
        };
        names.map(|name| self.channels.get(name).copied())
    }

    /// Channel of the opacity.
    pub fn alpha(&self) -> Option<usize> {
        self.channels.get("A").copied()
    }

    /// Channels of the sun-lit radiance and of V, where the file has that radiance.
    pub fn sun(&self) -> Option<[Option<usize>; 4]> {
        let channels = ["R", "G", "B", "V"].map(|name| self.sun.get(name).copied());
        channels[..3]
            .iter()
            .all(Option::is_some)
            .then_some(channels)
    }

    /// Names by which a user may ask for it, the shortest first.
    fn names(&self) -> Vec<String> {
        match (self.prefix.as_str(), &self.part_name) {
            ("", None) => Vec::new(),
            ("", Some(part)) => vec![part.clone()],
            (prefix, None) => vec![prefix.to_owned()],
            (prefix, Some(part)) => vec![prefix.to_owned(), format!("{part}.{prefix}")],
        }
    }

    /// The shortest name that no other layer has.
    fn name(&self, layers: &[Self]) -> Option<String> {
        let shared = |name: &String| layers.iter().filter(|l| l.names().contains(name)).count() > 1;
        self.names().into_iter().find(|name| !shared(name))
    }

    fn is_picture(&self) -> bool {
        self.kind() != LayerKind::Other
    }
}

/// The layer to read: the one the user named, else the default one. Also a note for the user where the file has several
/// layers.
pub(super) fn choose(part: &FilePart, headers: &[Header]) -> Result<(Layer, Option<String>)> {
    let path = &part.file;
    let mut layers = list(headers);
    let (index, note) = match &part.name {
        Some(name) => (named(path, &layers, name)?, None),
        None => by_default(path, &layers, headers)?,
    };
    let layer = layers.swap_remove(index);
    let channels = &headers[layer.part].channels.list;
    if channels.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err(subsampled(path));
    }
    Ok((layer, note))
}

/// Every layer, in the order of the parts and of the names within them.
fn list(headers: &[Header]) -> Vec<Layer> {
    let mut layers = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let text =
            |text: &exr::prelude::Text| String::from_utf8_lossy(text.as_slice()).into_owned();
        let mut groups: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for (index, channel) in header.channels.list.iter().enumerate() {
            let name = text(&channel.name);
            let (prefix, last) = name.rsplit_once('.').unwrap_or(("", &name));
            let group = groups.entry(prefix.to_owned()).or_default();
            group.insert(last.to_owned(), index);
        }
        let part_name = header.own_attributes.layer_name.as_ref().map(text);
        let first = layers.len();
        layers.extend(groups.into_iter().map(|(prefix, channels)| Layer {
            part,
            part_name: part_name.clone(),
            prefix,
            channels,
            sun: BTreeMap::new(),
            is_sun: false,
        }));
        join_sun(&mut layers[first..]);
    }
    layers
}

/// Gives each picture of a part the layer of its sun-lit radiance: `sun` that of the layer without a name, `a.sun` that
/// of `a`.
fn join_sun(layers: &mut [Layer]) {
    let found: BTreeMap<String, usize> = layers
        .iter()
        .enumerate()
        .map(|(index, layer)| (layer.prefix.clone(), index))
        .collect();
    for index in 0..layers.len() {
        let prefix = &layers[index].prefix;
        let wanted = match prefix.as_str() {
            "" => "sun".to_owned(),
            _ => format!("{prefix}.sun"),
        };
        if let Some(sun) = found.get(&wanted).filter(|_| layers[index].is_picture()) {
            layers[*sun].is_sun = true;
            layers[index].sun = layers[*sun].channels.clone();
        }
    }
}

/// The picture that a user named.
fn named(path: &Path, layers: &[Layer], name: &str) -> Result<usize> {
    let wrong = |problem: String| {
        let remedy = format!("The pictures in it: {}.", names_of(layers, None));
        Err(Error::input(shown(path), problem, remedy))
    };
    let fits = |(_, layer): &(usize, &Layer)| layer.names().iter().any(|n| n == name);
    let found: Vec<_> = layers.iter().enumerate().filter(fits).collect();
    match found[..] {
        [(index, layer)] if layer.is_picture() => Ok(index),
        [(_, layer)] => {
            let channels: Vec<_> = layer.channels.keys().map(String::as_str).collect();
            wrong(format!(
                "layer `{name}` is no picture, which has R, G and B or Y alone; it has {}",
                channels.join(", ")
            ))
        }
        [] => wrong(format!("there is no layer `{name}`")),
        _ => wrong(format!("`{name}` is the name of {} layers", found.len())),
    }
}

/// The picture of a file of which no layer was named: the first without a prefix, else the only one.
fn by_default(
    path: &Path,
    layers: &[Layer],
    headers: &[Header],
) -> Result<(usize, Option<String>)> {
    let own: Vec<_> = (0..layers.len()).filter(|i| !layers[*i].is_sun).collect();
    let pictures: Vec<_> = own
        .iter()
        .copied()
        .filter(|i| layers[*i].is_picture())
        .collect();
    let plain = |kind: LayerKind| {
        let fits = |i: &usize| layers[*i].prefix.is_empty() && layers[*i].kind() == kind;
        pictures.iter().copied().find(fits)
    };
    let only = match pictures[..] {
        [] => return Err(no_picture(path, headers)),
        [index] => Some(index),
        _ => None,
    };
    let index = only
        .or_else(|| plain(LayerKind::Colour))
        .or_else(|| plain(LayerKind::Grey))
        .ok_or_else(|| none_named(path, layers, &pictures))?;
    if own.len() < 2 {
        return Ok((index, None));
    }
    let count = own.len();
    let taken = match layers[index].name(layers) {
        Some(name) => format!("layer `{name}` of {count} was taken"),
        None => format!("of {count} layers the one without a name was taken"),
    };
    let why = match only {
        Some(_) => "the only picture among them".to_owned(),
        None => format!(
            "the first whose channels have no prefix; {}:NAME takes another: {}",
            shown(path),
            names_of(layers, Some(index))
        ),
    };
    Ok((index, Some(format!("{}: {taken}, {why}", shown(path)))))
}

/// Names of the layers that hold pictures, except `without`; comma-separated.
fn names_of(layers: &[Layer], without: Option<usize>) -> String {
    let pictures = layers.iter().enumerate();
    let pictures = pictures.filter(|(i, layer)| layer.is_picture() && Some(*i) != without);
    let mut names: Vec<_> = pictures.filter_map(|(_, l)| l.name(layers)).collect();
    if names.len() > MAX_NAMES {
        let rest = names.len() - MAX_NAMES;
        names.truncate(MAX_NAMES);
        names.push(format!("and {rest} more"));
    }
    names.join(", ")
}

/// The error for several pictures of which none was named and none is the default.
fn none_named(path: &Path, layers: &[Layer], pictures: &[usize]) -> Error {
    let problem = format!(
        "it has {} pictures and none was named: {}",
        pictures.len(),
        names_of(layers, None)
    );
    let name = pictures.iter().find_map(|i| layers[*i].name(layers));
    let remedy = match name {
        Some(name) => format!("Name one, for example {}:{name}.", shown(path)),
        None => "Save it with a name for each.".to_owned(),
    };
    Error::input(shown(path), problem, remedy)
}

/// The error for a file without a picture.
fn no_picture(path: &Path, headers: &[Header]) -> Error {
    let channels = || headers.iter().flat_map(|h| &h.channels.list);
    if channels().any(|c| c.sampling != Vec2(1, 1)) {
        return subsampled(path);
    }
    let names: Vec<String> = channels().map(|c| c.name.to_string()).collect();
    let message = format!(
        "has no layer with channels R, G and B, or with Y alone; it has {}",
        names.join(", ")
    );
    let path = path.to_owned();
    Error::Image { path, message }
}

fn subsampled(path: &Path) -> Error {
    Error::Image {
        path: path.to_owned(),
        message: "has subsampled channels; save it with channels of full resolution".to_owned(),
    }
}
