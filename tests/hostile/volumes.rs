//! Damaged `.npy` and `.npz` volumes.

use super::damage::{cases, damaged, edits};
use super::is_one_paragraph;
use super::numpy::{STORED, data_in_order, dict, kept, npy, npz, value_at};
use occlab::density::volume::{MAX_AXIS, load};
use occlab::scene::Volume;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use std::path::PathBuf;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join("v.npy");
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// Bytes that a byte of deflate expands to at most (<https://zlib.net/zlib_tech.html>).
const MOST_EXPANSION: usize = 1032;

/// Either a grid that the file's bytes account for, or a paragraph.
fn holds(bytes: &[u8], up_axis: u8) {
    let folder = Folder::new();
    let path = folder.write(bytes);
    match load(&Volume {
        path: path.clone(),
        up_axis,
    }) {
        Ok(grid) => {
            assert!(up_axis <= 2 && grid.size.iter().all(|n| (1..=MAX_AXIS).contains(n)));
            let voxels: usize = grid.size.iter().map(|n| *n as usize).product();
            assert_eq!(grid.values.len(), voxels);
            assert!(grid.values.iter().all(|v| v.is_finite() && *v >= 0.0));
            if bytes.starts_with(b"PK") {
                assert!(voxels <= MOST_EXPANSION * bytes.len());
            } else {
                assert!(voxels <= bytes.len());
                assert_eq!(grid.hash, blake3::hash(bytes));
            }
        }
        Err(error) => assert!(is_one_paragraph(&error.to_string(), &path), "{error}"),
    }
}

/// Header dictionaries, valid and invalid.
fn headers() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        4 => (0_u64..5).prop_map(|n| n.to_string()),
        1 => any::<u64>().prop_map(|n| n.to_string()),
        1 => select(vec![
            "9223372036854775808", "18446744073709551615", "99999999999999999999999999", "-1", "4294967296", "2048",
            "2049", "1e3", "0x10", "1_0", "2L", "True", "None", "", "'1'", "1.0", "1j", "(1, 2)", "++1", "1+1",
        ]).prop_map(str::to_owned),
    ];
    let shape = vec(number, 0..6).prop_map(|axes| format!("({})", axes.join(", ")));
    let descr = select(vec![
        "'<f4'",
        "'>f4'",
        "'=f4'",
        "'|f4'",
        "'f4'",
        "'<f2'",
        "'<f8'",
        "'<f16'",
        "'|u1'",
        "'<u1'",
        "'<u2'",
        "'<i4'",
        "'|b1'",
        "'<c8'",
        "'|O'",
        "'|S9223372036854775807'",
        "'<U4611686018427387904'",
        "'|V99999999999999999999'",
        "'<M8[ns]'",
        "'<f999999999'",
        "''",
        "'shape'",
        "'x'",
        "None",
        "4",
        "[('a', '<f4')]",
        "[('a', '<f4', (2, 2))]",
        "[('\\'shape\\' (1, 1, 1)', '<f4')]",
        "[(\"'shape' (1, 1, 1)\", '<f4')]",
        "('<f4', (9999999999, 9999999999))",
        "b'<f4'",
        "\"<f4\"",
        "'''<f4'''",
        "'\\x3cf4'",
    ]);
    let fortran = select(vec![
        "False",
        "True",
        "0",
        "None",
        "'False'",
        "false",
        "(",
        "{",
        "{'shape': (1, 1, 1)}",
    ]);
    let keys = select(vec![
        ["'descr'", "'fortran_order'", "'shape'"],
        ["\"descr\"", "\"fortran_order\"", "\"shape\""],
        ["'descr'", "'shape'", "'shape'"],
        ["'descr'", "'fortran_order'", "'\\x73hape'"],
        ["'descr'", "'fortran_order'", "'''shape'''"],
        ["'descr'", "'fortran_order'", "b'shape'"],
    ]);
    let tail = select(vec![
        "}",
        ", }",
        "}\n",
        ", }            \n",
        "",
        "}}",
        ", 'x': 1}",
        "}\0",
        "} garbage",
    ]);
    let order = select(vec![[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 2, 1]]);
    (keys, descr, fortran, shape, order, tail).prop_map(
        |(keys, descr, fortran, shape, order, tail)| {
            let values = [descr, fortran, &shape];
            let members = order.map(|i| format!("{}: {}", keys[i], values[i]));
            format!("{{{}{tail}", members.join(", "))
        },
    )
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_bytes(bytes in vec(any::<u8>(), 0..300), magic in any::<bool>(), up in 0_u8..4) {
        let start: &[u8] = if magic { b"\x93NUMPY\x01\x00" } else { b"" };
        holds(&[start, &bytes].concat(), up);
    }

    #[test]
    fn headers_between_right_and_wrong(
        header in headers(), version in 0_u8..5, data in vec(any::<u8>(), 0..260), zero in any::<bool>(),
    ) {
        let data = if zero { vec![0; data.len()] } else { data };
        holds(&npy(version, &header, &data), 1);
    }

    #[test]
    fn damaged_files(stored in select(&STORED[..]), edits in edits(), header_only in any::<bool>()) {
        let data: Vec<u8> = (0..24).flat_map(|i| stored.1(f64::from(i))).collect();
        let file = npy(1, &dict(stored.0, "False", "(2, 3, 4)"), &data);
        let within = if header_only { file.len() - data.len() } else { usize::MAX };
        holds(&damaged(&file, &edits, within), 1);
    }

    #[test]
    fn truncated_and_padded_files(stored in select(&STORED[..]), cut in 0_usize..200, extra in 0_usize..20) {
        let data: Vec<u8> = (0..6).flat_map(|i| stored.1(f64::from(i))).collect();
        let mut file = npy(2, &dict(stored.0, "False", "(1, 2, 3)"), &data);
        let whole = file.len();
        file.truncate(cut.min(whole));
        file.extend(vec![0; extra]);
        if file.len() == whole && cut >= whole {
            return Ok(());
        }
        holds(&file, 1);
    }

    #[test]
    fn shapes_of_any_size(shape in prop::array::uniform3(prop_oneof![0_u64..4, any::<u64>(), 2000_u64..2100]), data in 0_usize..64) {
        let text = format!("({}, {}, {})", shape[0], shape[1], shape[2]);
        holds(&npy(1, &dict("'|u1'", "False", &text), &vec![0; data]), 1);
    }

    #[test]
    fn damaged_archives(
        stored in select(&STORED[..]), edits in edits(), deflate in any::<bool>(), two in any::<bool>(), from in 0_usize..3,
    ) {
        let data = data_in_order(&stored, [2, 3, 4], [0, 1, 2], 7);
        let array = npy(1, &dict(stored.0, "False", "(2, 3, 4)"), &data);
        let arrays: &[(&str, &[u8])] = &[("a.npy", &array), ("b.npy", &array)];
        let file = npz(&arrays[..1 + usize::from(two)], deflate);
        // All of it, the first header, or the directory at the end.
        let start = if from == 2 { file.len() - 100 } else { 0 };
        let within = if from == 1 { 60 } else { usize::MAX };
        let bytes = [&file[..start], &damaged(&file[start..], &edits, within)].concat();
        holds(&bytes, 1);
    }

    #[test]
    fn truncated_archives_never_come_back(stored in select(&STORED[..]), deflate in any::<bool>(), cut in any::<prop::sample::Index>()) {
        let data = data_in_order(&stored, [2, 3, 4], [0, 1, 2], 7);
        let array = npy(1, &dict(stored.0, "False", "(2, 3, 4)"), &data);
        let mut file = npz(&[("a.npy", &array)], deflate);
        file.truncate(cut.index(file.len()));
        let folder = Folder::new();
        let path = folder.write(&file);
        let message = load(&Volume { path: path.clone(), up_axis: 1 }).unwrap_err().to_string();
        prop_assert!(is_one_paragraph(&message, &path), "{}", message);
    }

    /// What NumPy writes comes back: each value at its place, in every type, byte order, axis order and kind of file.
    #[test]
    fn good_files_come_back(
        stored in select(&STORED[..]), shape in prop::array::uniform3(1_u32..6), seed in any::<u32>(), up in 0_u8..3,
        version in 1_u8..4, fortran in any::<bool>(), archive in select(vec![None, Some(false), Some(true)]),
    ) {
        let order = if fortran { [2, 1, 0] } else { [0, 1, 2] };
        let data = data_in_order(&stored, shape, order, seed);
        let text = format!("({}, {}, {})", shape[0], shape[1], shape[2]);
        let fortran = if fortran { "True" } else { "False" };
        let mut bytes = npy(version, &dict(stored.0, fortran, &text), &data);
        if let Some(deflate) = archive {
            bytes = npz(&[("density.npy", &bytes)], deflate);
        }
        let folder = Folder::new();
        let path = folder.write(&bytes);
        let grid = load(&Volume { path, up_axis: up }).unwrap();
        // Of the axes that do not point up the earlier is world z, the later world x.
        let [z_axis, x_axis] = [[1, 2], [0, 2], [0, 1]][usize::from(up)];
        prop_assert_eq!(grid.size, [shape[x_axis], shape[usize::from(up)], shape[z_axis]]);
        let [nx, ny, nz] = grid.size;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let mut index = [0; 3];
                    index[x_axis] = x;
                    index[usize::from(up)] = y;
                    index[z_axis] = z;
                    let value = grid.values[(x + nx * (y + ny * z)) as usize];
                    prop_assert_eq!(value, kept(&stored, value_at(index, seed)));
                }
            }
        }
    }
}

#[test]
fn a_second_shape_hidden_in_a_string_is_refused() {
    // The parser multiplies these axes without a check: a build with overflow checks panicked.
    let shape = "(4294967296, 4294967296, 4294967296)";
    for descr in [
        "[(\"'shape' (1, 1, 1)\", '<f4')]",
        "[('\\'shape\\' (1, 1, 1)', '<f4')]",
    ] {
        holds(&npy(1, &dict(descr, "False", shape), &[0; 4]), 1);
    }
    let folder = Folder::new();
    let path = folder.write(&npy(
        1,
        &dict("[(\"'shape' (1, 1, 1)\", '<f4')]", "False", shape),
        &[0; 4],
    ));
    let message = load(&Volume { path, up_axis: 1 }).unwrap_err().to_string();
    assert!(message.contains("unusual way"), "{message}");
}

#[test]
fn an_archive_of_two_arrays_is_refused_until_one_is_named() {
    let folder = Folder::new();
    let array = |value: u8| npy(1, &dict("'|u1'", "False", "(1, 1, 1)"), &[value]);
    let bytes = npz(&[("a.npy", &array(1)), ("b.npy", &array(2))], true);
    holds(&bytes, 1);
    let path = folder.0.path().join("v.npz");
    std::fs::write(&path, &bytes).unwrap();
    let read = |path: PathBuf| load(&Volume { path, up_axis: 1 });
    let message = read(path.clone()).unwrap_err().to_string();
    assert!(message.contains("`a`, `b`"), "{message}");
    let named = |name: &str| PathBuf::from(format!("{}:{name}", path.display()));
    assert_eq!(read(named("a")).unwrap().values, [1.0]);
    assert_eq!(read(named("b")).unwrap().values, [2.0]);
}

#[test]
fn a_small_archive_that_expands_to_more_than_it_announces_is_refused() {
    // 64 MiB of zeros in 64 KiB: what is read of it is what the header asks for, and that must be all.
    let header = dict("'|u1'", "False", "(1, 1, 1)");
    let bomb = npy(1, &header, &vec![0; 64 << 20]);
    let folder = Folder::new();
    let path = folder.write(&npz(&[("a.npy", &bomb)], true));
    let message = load(&Volume { path, up_axis: 1 }).unwrap_err().to_string();
    assert!(message.contains("has 67108864"), "{message}");
}
