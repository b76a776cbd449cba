use super::super::{read_frame, read_picture, write_frame};
use super::*;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, Layer as ExrLayer,
    LayerAttributes, Vec2, WritableImage,
};
use std::path::PathBuf;

const SIZE: (usize, usize) = (5, 4);

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("a.exr")
    }

    /// The path of the file with a layer's name behind it.
    fn named(&self, layer: &str) -> PathBuf {
        PathBuf::from(format!("{}:{layer}", self.path().display()))
    }

    /// A file whose parts have these names and channels; every pixel of a channel has the value given for it.
    fn parts(&self, parts: &[(&str, &[(&str, f32)])]) {
        let layers: Vec<_> = parts
            .iter()
            .map(|(name, channels)| part(name, channels))
            .collect();
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
        let image = Image::from_layers(attributes, layers);
        image.write().to_file(self.path()).unwrap();
    }
}

fn part(name: &str, channels: &[(&str, f32)]) -> ExrLayer<AnyChannels<FlatSamples>> {
    let pixels = SIZE.0 * SIZE.1;
    let list = channels
        .iter()
        .map(|(name, value)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; pixels])))
        .collect();
    let attributes = match name {
        "" => LayerAttributes::default(),
        _ => LayerAttributes::named(name),
    };
    ExrLayer::new(
        SIZE,
        attributes,
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(list),
    )
}

const RGB: &[(&str, f32)] = &[("R", 1.0), ("G", 2.0), ("B", 3.0)];

/// Channels `prefix.R`, `prefix.G`, `prefix.B` of three values from `first` on.
fn layer(prefix: &str, first: f32) -> Vec<(String, f32)> {
    let name = |c: &str| format!("{prefix}.{c}");
    vec![
        (name("R"), first),
        (name("G"), first + 1.0),
        (name("B"), first + 2.0),
    ]
}

fn borrowed(channels: &[(String, f32)]) -> Vec<(&str, f32)> {
    channels
        .iter()
        .map(|(name, v)| (name.as_str(), *v))
        .collect()
}

fn first_pixel(path: &Path) -> [f32; 4] {
    read_frame(path).unwrap().radiance[0]
}

#[test]
fn a_file_whose_only_layer_is_named_is_read() {
    let folder = Folder::new();
    for prefix in ["beauty", "ViewLayer.Combined", "a.b.c"] {
        let mut channels = layer(prefix, 1.0);
        channels.push((format!("{prefix}.A"), 0.5));
        folder.parts(&[("", &borrowed(&channels))]);
        let picture = read_picture(&folder.path()).unwrap();
        assert_eq!(picture.frame.radiance, [[1.0, 2.0, 3.0, 0.5]; 20]);
        assert_eq!(picture.frame.sun, [[1.0, 2.0, 3.0, 0.0]; 20]);
        assert_eq!(picture.notes, Vec::<String>::new());
        assert_eq!(first_pixel(&folder.named(prefix)), [1.0, 2.0, 3.0, 0.5]);
    }
}

#[test]
fn brightness_alone_is_grey_and_a_component_of_a_vector_is_not() {
    let folder = Folder::new();
    folder.parts(&[("", &[("Y", 0.25)])]);
    assert_eq!(first_pixel(&folder.path()), [0.25, 0.25, 0.25, 1.0]);
    folder.parts(&[("", &[("beauty.Y", 0.25), ("beauty.A", 0.5)])]);
    assert_eq!(first_pixel(&folder.path()), [0.25, 0.25, 0.25, 0.5]);
    folder.parts(&[("", &[("N.X", 1.0), ("N.Y", 0.25), ("N.Z", 1.0)])]);
    let message = read_picture(&folder.path()).unwrap_err().to_string();
    assert!(message.contains("it has N.X, N.Y, N.Z"), "{message}");
    let message = read_picture(&folder.named("N")).unwrap_err().to_string();
    assert!(message.contains("layer `N` is no picture"), "{message}");
}

#[test]
fn of_several_layers_the_plain_one_is_taken_and_said_and_a_name_takes_another() {
    let folder = Folder::new();
    let diffuse = layer("diffuse", 10.0);
    let mut channels = borrowed(&diffuse);
    channels.extend(RGB);
    channels.extend([("depth.Z", 9.0), ("A", 0.5)]);
    folder.parts(&[("", &channels)]);
    let picture = read_picture(&folder.path()).unwrap();
    assert_eq!(picture.frame.radiance[0], [1.0, 2.0, 3.0, 0.5]);
    let [note] = &picture.notes[..] else {
        panic!("{:?}", picture.notes);
    };
    for word in [
        "a.exr: of 3 layers the one without a name was taken",
        "another: diffuse",
    ] {
        assert!(note.contains(word), "{note}");
    }
    let picture = read_picture(&folder.named("diffuse")).unwrap();
    assert_eq!(picture.frame.radiance[0], [10.0, 11.0, 12.0, 1.0]);
    assert_eq!(picture.notes, Vec::<String>::new());
}

#[test]
fn the_only_picture_among_layers_is_taken_and_said() {
    let folder = Folder::new();
    let combined = layer("ViewLayer.Combined", 1.0);
    let mut channels = borrowed(&combined);
    channels.extend([
        ("ViewLayer.Depth.Z", 4.0),
        ("ViewLayer.Normal.X", 5.0),
        ("ViewLayer.Normal.Y", 6.0),
    ]);
    folder.parts(&[("", &channels)]);
    let picture = read_picture(&folder.path()).unwrap();
    assert_eq!(picture.frame.radiance[0], [1.0, 2.0, 3.0, 1.0]);
    let expected = "layer `ViewLayer.Combined` of 3 was taken, the only picture";
    assert!(picture.notes[0].contains(expected), "{:?}", picture.notes);
}

#[test]
fn three_layers_of_which_none_stands_out_are_an_error_that_lists_them() {
    let folder = Folder::new();
    let all = [
        layer("beauty", 1.0),
        layer("diffuse", 4.0),
        layer("glow", 7.0),
    ]
    .concat();
    folder.parts(&[("", &borrowed(&all))]);
    let message = read_picture(&folder.path()).unwrap_err().to_string();
    for word in ["3 pictures", "beauty, diffuse, glow", "a.exr:beauty"] {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert_eq!(first_pixel(&folder.named("glow"))[0], 7.0);
    let message = read_picture(&folder.named("gloom"))
        .unwrap_err()
        .to_string();
    for word in ["no layer `gloom`", "beauty, diffuse, glow"] {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

#[test]
fn parts_are_chosen_by_name_and_the_first_is_taken_by_default() {
    let folder = Folder::new();
    let right = [("R", 4.0), ("G", 5.0), ("B", 6.0)];
    folder.parts(&[("depth", &[("Z", 9.0)]), ("left", RGB), ("right", &right)]);
    let picture = read_picture(&folder.path()).unwrap();
    assert_eq!(picture.frame.radiance[0], [1.0, 2.0, 3.0, 1.0]);
    for word in ["layer `left` of 3 was taken", "another: right"] {
        assert!(picture.notes[0].contains(word), "{:?}", picture.notes);
    }
    assert_eq!(first_pixel(&folder.named("right"))[..3], [4.0, 5.0, 6.0]);
    assert_eq!(first_pixel(&folder.named("left"))[..3], [1.0, 2.0, 3.0]);
}

#[test]
fn layers_that_share_a_name_are_told_apart_by_their_part() {
    let folder = Folder::new();
    let (left, right) = (layer("beauty", 1.0), layer("beauty", 4.0));
    folder.parts(&[("left", &borrowed(&left)), ("right", &borrowed(&right))]);
    let message = read_picture(&folder.path()).unwrap_err().to_string();
    assert!(message.contains("left.beauty, right.beauty"), "{message}");
    let message = read_picture(&folder.named("beauty"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("the name of 2 layers"), "{message}");
    assert_eq!(first_pixel(&folder.named("right.beauty"))[0], 4.0);
}

#[test]
fn the_sunlight_of_our_own_pictures_is_no_layer_of_its_own() {
    let folder = Folder::new();
    let plane = |first: f32| (0..20).map(|i| [first, 2.0, 3.0, i as f32]).collect();
    let frame = Frame {
        width: 5,
        height: 4,
        radiance: plane(1.0),
        sun: plane(0.5),
    };
    write_frame(&folder.path(), &frame).unwrap();
    let picture = read_picture(&folder.path()).unwrap();
    assert_eq!((&picture.frame, picture.notes.len()), (&frame, 0));
    assert_eq!(first_pixel(&folder.named("sun")), [0.5, 2.0, 3.0, 1.0]);
}

/// A file of one part whose pixels are `(x, y, 1)` in the coordinates of the windows.
fn windowed(path: &Path, data: IntegerBounds, display: IntegerBounds, alpha: bool) {
    let pixels = |value: &dyn Fn(i32, i32) -> f32| {
        let (size, at) = (data.size, data.position);
        let rows = 0..size.y() as i32;
        let values = rows.flat_map(|y| {
            let row = (0..size.x() as i32).map(move |x| (x + at.x(), y + at.y()));
            row.collect::<Vec<_>>()
        });
        FlatSamples::F32(values.map(|(x, y)| value(x, y)).collect())
    };
    let mut list = vec![
        AnyChannel::new("R", pixels(&|x, _| x as f32)),
        AnyChannel::new("G", pixels(&|_, y| y as f32)),
        AnyChannel::new("B", pixels(&|_, _| 1.0)),
    ];
    if alpha {
        list.push(AnyChannel::new("A", pixels(&|_, _| 0.5)));
    }
    let attributes = LayerAttributes {
        layer_position: data.position,
        ..LayerAttributes::default()
    };
    let list = AnyChannels::sort(list.into_iter().collect());
    let layer = ExrLayer::new(data.size, attributes, Encoding::FAST_LOSSLESS, list);
    let image = Image::new(ImageAttributes::new(display), layer);
    image.write().to_file(path).unwrap();
}

fn window(x: i32, y: i32, width: usize, height: usize) -> IntegerBounds {
    IntegerBounds::new((x, y), (width, height))
}

/// Every pixel inside both windows has its own coordinates as its value, every other pixel is 0.
#[test]
fn a_picture_is_its_display_window_whatever_part_of_it_is_stored() {
    let folder = Folder::new();
    let display = window(2, -3, 32, 20);
    let cases = [
        (window(2, -3, 32, 20), None),
        (
            window(10, 0, 7, 5),
            Some("outside its data radiance and opacity are 0"),
        ),
        (window(-6, -9, 50, 40), Some("overscan was cut")),
        (
            window(-6, 5, 20, 40),
            Some("overscan was cut; outside its data"),
        ),
        (
            window(30, -9, 8, 8),
            Some("overscan was cut; outside its data"),
        ),
        (window(100, 100, 8, 8), Some("no stored pixel lies in it")),
        (window(-500, 0, 8, 8), Some("no stored pixel lies in it")),
    ];
    for ((data, note), alpha) in cases.into_iter().flat_map(|c| [(c, true), (c, false)]) {
        windowed(&folder.path(), data, display, alpha);
        let picture = read_picture(&folder.path()).unwrap();
        let frame = &picture.frame;
        assert_eq!((frame.width, frame.height), (32, 20));
        assert_eq!(picture.corner, [2, -3]);
        for (i, pixel) in frame.radiance.iter().enumerate() {
            let (x, y) = (i as i32 % 32 + 2, i as i32 / 32 - 3);
            let within = |v: i32, from: i32, n: usize| (from..from + n as i32).contains(&v);
            let stored = within(x, data.position.x(), data.size.x())
                && within(y, data.position.y(), data.size.y());
            let opacity = if alpha { 0.5 } else { 1.0 };
            let expected = match stored {
                true => [x as f32, y as f32, 1.0, opacity],
                false => [0.0; 4],
            };
            assert_eq!(*pixel, expected, "({x}, {y}) of {data:?}");
            assert_eq!(frame.sun[i], [expected[0], expected[1], expected[2], 0.0]);
        }
        match note {
            None => assert!(picture.notes.is_empty(), "{:?}", picture.notes),
            Some(words) => assert!(picture.notes[0].contains(words), "{:?}", picture.notes),
        }
    }
}

#[test]
fn a_small_file_that_announces_a_large_display_window_is_refused() {
    let folder = Folder::new();
    windowed(
        &folder.path(),
        window(0, 0, 4, 4),
        window(0, 0, 16384, 16384),
        false,
    );
    let message = read_picture(&folder.path()).unwrap_err().to_string();
    assert!(message.contains("announces 8589934592 bytes"), "{message}");
    windowed(
        &folder.path(),
        window(0, 0, 4, 4),
        window(0, 0, 65536, 65536),
        false,
    );
    let message = read_picture(&folder.path()).unwrap_err().to_string();
    assert!(message.contains("65536×65536 pixels"), "{message}");
}

#[test]
fn large_pictures_of_which_little_is_stored_are_read() {
    let folder = Folder::new();
    windowed(
        &folder.path(),
        window(9, 9, 4, 4),
        window(0, 0, 1920, 1080),
        false,
    );
    let frame = read_frame(&folder.path()).unwrap();
    let lit = frame.radiance.iter().filter(|p| p[3] > 0.0).count();
    assert_eq!((frame.width, frame.height, lit), (1920, 1080, 16));
}

#[test]
fn a_name_behind_a_missing_file_is_an_error_about_the_file() {
    let folder = Folder::new();
    let error = read_picture(&folder.named("beauty")).unwrap_err();
    assert!(matches!(error, Error::Io { path, .. } if path == folder.path()));
}

#[test]
fn tiles_and_levels_of_detail_come_out_in_their_places() {
    use exr::prelude::{Blocks, LineOrder, SpecificChannels};
    let folder = Folder::new();
    let channels =
        SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as u32, f16::ONE));
    let encoding = Encoding {
        blocks: Blocks::Tiles(Vec2(8, 8)),
        line_order: LineOrder::Unspecified,
        ..Encoding::FAST_LOSSLESS
    };
    let layer = ExrLayer::new((19, 13), LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer)
        .write()
        .to_file(folder.path())
        .unwrap();
    let frame = read_frame(&folder.path()).unwrap();
    for (i, pixel) in frame.radiance.iter().enumerate() {
        assert_eq!(*pixel, [(i % 19) as f32, (i / 19) as f32, 1.0, 1.0]);
    }
}
