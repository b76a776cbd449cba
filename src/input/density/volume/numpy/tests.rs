use super::*;
use npyz::WriterBuilder;
use std::path::PathBuf;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn raw(&self, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join("v.npy");
        std::fs::write(&path, bytes).expect("write");
        path
    }

    /// A version-1 file with this header dictionary and data.
    fn npy(&self, header: &str, data: &[u8]) -> PathBuf {
        let header = format!("{header}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        self.raw(&bytes)
    }

    /// A file as NumPy would write it.
    fn array<T: npyz::AutoSerialize + Copy>(&self, shape: &[u64], values: &[T]) -> PathBuf {
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new()
            .default_dtype()
            .shape(shape)
            .writer(&mut bytes);
        let mut writer = options.begin_nd().expect("header");
        writer.extend(values.iter().copied()).expect("values");
        writer.finish().expect("finish");
        self.raw(&bytes)
    }
}

fn dict(descr: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}")
}

fn open(path: PathBuf, up_axis: u8) -> Result<Grid> {
    load(&Volume { path, up_axis })
}

fn refused(path: PathBuf, words: &[&str]) {
    let message = open(path, 1).expect_err("must be refused").to_string();
    for word in words.iter().chain(&["v.npy"]) {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

#[test]
fn axes_follow_up_axis() {
    let folder = Folder::new();
    // Value = 100 a + 10 b + c for array index [a][b][c], shape 2 × 3 × 4.
    let values: Vec<f32> = (0..24)
        .map(|i| (100 * (i / 12) + 10 * (i / 4 % 3) + i % 4) as f32)
        .collect();
    let path = folder.array(&[2, 3, 4], &values);
    let at = |grid: &Grid, [x, y, z]: [u32; 3]| {
        grid.values[(x + grid.size[0] * (y + grid.size[1] * z)) as usize]
    };
    let up1 = open(path.clone(), 1).expect("up 1");
    assert_eq!((up1.size, &up1.values), ([4, 3, 2], &values));
    assert_eq!(at(&up1, [3, 2, 1]), 123.0);
    let up0 = open(path.clone(), 0).expect("up 0");
    assert_eq!((up0.size, at(&up0, [3, 1, 2])), ([4, 2, 3], 123.0));
    let up2 = open(path.clone(), 2).expect("up 2");
    assert_eq!(
        (up2.size, at(&up2, [2, 3, 1]), at(&up2, [0, 1, 0])),
        ([3, 4, 2], 123.0, 1.0)
    );
    assert!(open(path, 3).is_err());
}

#[test]
fn every_allowed_type_and_byte_order_reads_the_same() {
    let folder = Folder::new();
    let expected = [0.5_f32, 2.0];
    let half = |v: f32| npyz::half::f16::from_f32(v).to_bits();
    let bytes =
        |f: &dyn Fn(f32) -> Vec<u8>| expected.iter().flat_map(|v| f(*v)).collect::<Vec<u8>>();
    let cases: [(&str, Vec<u8>); 6] = [
        ("<f2", bytes(&|v| half(v).to_le_bytes().to_vec())),
        (">f2", bytes(&|v| half(v).to_be_bytes().to_vec())),
        ("<f4", bytes(&|v| v.to_le_bytes().to_vec())),
        (">f4", bytes(&|v| v.to_be_bytes().to_vec())),
        ("<f8", bytes(&|v| f64::from(v).to_le_bytes().to_vec())),
        (">f8", bytes(&|v| f64::from(v).to_be_bytes().to_vec())),
    ];
    for (descr, data) in cases {
        let grid = open(folder.npy(&dict(descr, "(1, 1, 2)"), &data), 1)
            .unwrap_or_else(|e| panic!("{descr}: {e}"));
        assert_eq!(
            (grid.size, grid.values.as_slice()),
            ([2, 1, 1], expected.as_slice()),
            "{descr}"
        );
    }
    let grid = open(folder.npy(&dict("|u1", "(2, 1, 1)"), &[0, 255]), 1).expect("u8");
    assert_eq!(grid.values, [0.0, 255.0]);
}

#[test]
fn integers_and_bool_are_the_numbers_they_store_in_either_byte_order() {
    let folder = Folder::new();
    let read = |descr: &str, data: &[u8]| {
        open(folder.npy(&dict(descr, "(1, 1, 2)"), data), 1)
            .unwrap_or_else(|e| panic!("{descr}: {e}"))
            .values
    };
    assert_eq!(read("|b1", &[0, 1]), [0.0, 1.0]);
    assert_eq!(read("|i1", &[3, 127]), [3.0, 127.0]);
    for signed in [true, false] {
        for size in [2, 4, 8] {
            let kind = if signed { 'i' } else { 'u' };
            let most = (u64::MAX >> (64 - 8 * size)) >> u32::from(signed);
            let little = |v: u64| v.to_le_bytes()[..size].to_vec();
            let big = |v: u64| v.to_be_bytes()[8 - size..].to_vec();
            let expected = [258.0, most as f32];
            let data = [little(258), little(most)].concat();
            assert_eq!(read(&format!("<{kind}{size}"), &data), expected);
            let data = [big(258), big(most)].concat();
            assert_eq!(read(&format!(">{kind}{size}"), &data), expected);
        }
    }
}

#[test]
fn negative_integers_and_damaged_bools_are_refused() {
    let folder = Folder::new();
    let negative = [1, 0, 0xfe, 0xff];
    refused(
        folder.npy(&dict("<i2", "(1, 1, 2)"), &negative),
        &["[z=0][y=0][x=1]", "density -2 is negative", "numpy.maximum"],
    );
    refused(
        folder.npy(&dict("|b1", "(1, 1, 2)"), &[1, 2]),
        &["invalid value for bool: 2", "damaged"],
    );
}

#[test]
fn an_index_is_the_same_voxel_in_fortran_order() {
    let folder = Folder::new();
    let shape = [2, 3, 4];
    let value = |[a, b, c]: [u32; 3]| f64::from(100 * a + 10 * b + c);
    let bytes = |order: [usize; 3]| {
        let mut data = Vec::new();
        let mut index = [0; 3];
        for i in 0..shape[order[0]] {
            for j in 0..shape[order[1]] {
                for k in 0..shape[order[2]] {
                    (index[order[0]], index[order[1]], index[order[2]]) = (i, j, k);
                    data.extend(value(index).to_be_bytes());
                }
            }
        }
        data
    };
    let header = |fortran: &str| {
        format!("{{'descr': '>f8', 'fortran_order': {fortran}, 'shape': (2, 3, 4), }}")
    };
    for up in 0..3 {
        let c = open(folder.npy(&header("False"), &bytes([0, 1, 2])), up).expect("C");
        let f = open(folder.npy(&header("True"), &bytes([2, 1, 0])), up).expect("Fortran");
        assert_eq!((c.size, &c.values), (f.size, &f.values), "up axis {up}");
        let swapped = open(folder.npy(&header("True"), &bytes([0, 1, 2])), up).expect("Fortran");
        assert_ne!(c.values, swapped.values, "the order must matter");
    }
    let mut data = [1.0_f64; 24];
    // The second value of a file in Fortran order is that of index [1][0][0].
    data[1] = -1.0;
    let data: Vec<u8> = data.iter().flat_map(|v| v.to_be_bytes()).collect();
    refused(
        folder.npy(&header("True"), &data),
        &["element [z=1][y=0][x=0]", "negative"],
    );
}

#[test]
fn denormals_and_negative_zero_survive_and_the_hash_is_that_of_the_file() {
    let folder = Folder::new();
    let path = folder.array(&[1, 1, 3], &[1e-42_f32, f32::from_bits(1), -0.0]);
    let grid = open(path.clone(), 1).expect("denormals");
    assert_eq!(grid.values[0].to_bits(), 1e-42_f32.to_bits());
    assert_eq!(grid.values[1].to_bits(), 1);
    assert_eq!(grid.hash, blake3::hash(&std::fs::read(path).expect("read")));
}

#[test]
fn bad_values_are_named_by_element() {
    let folder = Folder::new();
    let place = "element [z=1][y=0][x=2]";
    for (value, word) in [
        (-0.5_f32, "negative"),
        (f32::NAN, "NaN"),
        (f32::INFINITY, "too large"),
        (f32::NEG_INFINITY, "negative"),
    ] {
        let mut values = [1.0_f32; 12];
        values[8] = value;
        refused(folder.array(&[2, 2, 3], &values), &[place, word]);
    }
    refused(
        folder.array(&[1, 1, 1], &[1e300_f64]),
        &["[z=0][y=0][x=0]", "too large for f32"],
    );
    let path = folder.array(&[2, 2, 3], &[-1.0_f32; 12]);
    let message = open(path, 0).expect_err("negative").to_string();
    assert!(message.contains("[y=0][z=0][x=0]"), "{message}");
}

#[test]
fn wrong_layouts_are_refused_with_a_remedy() {
    let folder = Folder::new();
    for descr in ["<c8", "<f16", "|O", "|S4", "<U2", "<M8[ns]", "|V4"] {
        refused(
            folder.npy(&dict(descr, "(1, 1, 2)"), &[0; 64]),
            &["f16, f32, f64, integers of 8 to 64 bits and bool"],
        );
    }
    refused(
        folder.npy(
            "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 1, 1), }",
            &[0; 4],
        ),
        &["allowed are"],
    );
    refused(
        folder.npy(&dict("<f4", "(2, 2)"), &[0; 16]),
        &["2 axes", "three axes"],
    );
    refused(folder.npy(&dict("<f4", "()"), &[0; 4]), &["0 axes"]);
    refused(
        folder.npy(&dict("<f4", "(1, 1, 1, 1)"), &[0; 4]),
        &["4 axes"],
    );
    refused(
        folder.npy(&dict("<f4", "(2, 0, 2)"), &[]),
        &["axis 1 has 0 voxels"],
    );
    refused(
        folder.npy(&dict("<f4", "(2, -1, 2)"), &[]),
        &["axis 1 has -1 voxels"],
    );
}

#[test]
fn sizes_are_checked_before_allocation() {
    let folder = Folder::new();
    refused(
        folder.npy(&dict("<f4", "(2048, 2048, 512)"), &[0; 8]),
        &["announces 8589934592 bytes", "only 8", "truncated"],
    );
    refused(
        folder.npy(&dict("|u1", "(2048, 2048, 2048)"), &[0; 8]),
        &["8589934592 voxels"],
    );
    refused(
        folder.npy(&dict("|u1", "(1, 1, 2049)"), &[0; 8]),
        &["axis 2 has 2049"],
    );
    refused(
        folder.npy(
            &dict("<f4", "(4294967296, 4294967296, 4294967296)"),
            &[0; 8],
        ),
        &["axis 0"],
    );
    refused(
        folder.npy(&dict("<f4", "(99999999999999999999999, 1, 1)"), &[0; 8]),
        &["axis 0"],
    );
    refused(
        folder.npy(&dict("<f4", "(1, 1, 2)"), &[0; 7]),
        &["only 7", "truncated"],
    );
    refused(
        folder.npy(&dict("<f4", "(1, 1, 2)"), &[0; 9]),
        &["has 9", "one array"],
    );
}

#[test]
fn damaged_headers_are_refused() {
    let folder = Folder::new();
    refused(folder.raw(b""), &["ends inside the header"]);
    refused(folder.raw(b"P6 3 3 255 and so on"), &["not a .npy file"]);
    refused(
        folder.raw(b"\x93NUMPY\x01\x00\xff\x00{'descr'"),
        &["ends inside the header"],
    );
    refused(
        folder.raw(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{"),
        &["claims 4294967295 bytes"],
    );
    refused(
        folder.raw(b"\x93NUMPY\x09\x00\x02\x00\x00\x00{}"),
        &["header"],
    );
    refused(folder.npy(&"(".repeat(60_000), &[]), &["nested too deeply"]);
    refused(
        folder.npy("{'descr': '<f4', 'fortran_order': False, }", &[0; 4]),
        &["no shape"],
    );
    refused(
        folder.npy("{'descr': '<f4', 'shape': (1, 1, 1), }", &[0; 4]),
        &["fortran_order"],
    );
    refused(
        folder.npy("{'shape': (1, 1, 1) 'descr' }", &[0; 4]),
        &["header"],
    );
    let twice = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 1), 'shape': (4294967295, 1, 1), }";
    refused(folder.npy(twice, &[0; 4]), &["more than descr"]);
    assert!(matches!(
        open(folder.0.path().join("none.npy"), 1),
        Err(Error::Io { .. })
    ));
}

mod archives;
