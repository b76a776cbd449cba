//! `.npz` archives.

use super::*;
use rawzip::{CompressionMethod, ZipArchiveWriter};
use std::io::Write;

/// The `.npy` bytes of a 1 × 1 × n array.
fn array(values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[1, 1, values.len() as u64])
        .writer(&mut bytes);
    let mut writer = options.begin_nd().expect("header");
    writer.extend(values.iter().copied()).expect("values");
    writer.finish().expect("finish");
    bytes
}

/// An archive of these members.
fn npz(members: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (name, data) in members {
        let file = archive.new_file(name).compression_method(method);
        let (mut entry, config) = file.start().expect("member");
        let descriptor = if method == CompressionMethod::STORE {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(data).expect("data");
            writer.finish().expect("end of data").1
        } else {
            let level = flate2::Compression::best();
            let encoder = flate2::write::DeflateEncoder::new(&mut entry, level);
            let mut writer = config.wrap(encoder);
            writer.write_all(data).expect("data");
            let (encoder, descriptor) = writer.finish().expect("end of data");
            encoder.finish().expect("end of deflate");
            descriptor
        };
        entry.finish(descriptor).expect("end of member");
    }
    archive.finish().expect("directory");
    bytes
}

const METHODS: [CompressionMethod; 2] = [CompressionMethod::STORE, CompressionMethod::DEFLATE];

/// The path of the folder's file with an array's name behind it.
fn named(path: &std::path::Path, name: &str) -> PathBuf {
    PathBuf::from(format!("{}:{name}", path.display()))
}

#[test]
fn the_only_array_of_an_archive_is_read_as_if_it_were_a_file() {
    let folder = Folder::new();
    let values: Vec<f32> = (0..1000).map(|i| (i % 7) as f32).collect();
    let npy = array(&values);
    let alone = open(folder.raw(&npy), 1).expect("npy");
    for method in METHODS {
        let members: [(&str, &[u8]); 2] = [("density.npy", &npy), ("readme.txt", b"hello")];
        let path = folder.raw(&npz(&members, method));
        assert_eq!(open(path.clone(), 1).expect("npz"), alone, "{method}");
        // The folder's file is called `v.npy`; the ending of an archive is needed for a name behind the colon.
        let archive = path.with_extension("npz");
        std::fs::rename(&path, &archive).expect("rename");
        assert_eq!(open(named(&archive, "density"), 1).expect("named"), alone);
    }
}

#[test]
fn of_several_arrays_one_must_be_named() {
    let folder = Folder::new();
    let (a, b) = (array(&[1.0]), array(&[2.0]));
    let bytes = npz(&[("a.npy", &a), ("b.npy", &b)], CompressionMethod::STORE);
    let path = folder.raw(&bytes).with_extension("npz");
    std::fs::write(&path, &bytes).expect("write");
    let message = |path: PathBuf| open(path, 1).expect_err("refused").to_string();
    let text = message(path.clone());
    for word in ["v.npz: the archive holds 2 arrays: `a`, `b`", "v.npz:a."] {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
    let (a, b) = (named(&path, "a"), named(&path, "b"));
    let (a, b) = (open(a, 1).expect("a"), open(b, 1).expect("b"));
    assert_eq!((&a.values[..], &b.values[..]), (&[1.0][..], &[2.0][..]));
    assert_ne!(a.hash, b.hash, "arrays of one file are told apart");
    let text = message(named(&path, "c"));
    for word in ["no array `c`", "`a`, `b`"] {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

#[test]
fn archives_without_a_clear_array_are_refused() {
    let folder = Folder::new();
    let npy = array(&[1.0]);
    let store = CompressionMethod::STORE;
    refused(folder.raw(&npz(&[], store)), &["no array"]);
    refused(folder.raw(&npz(&[("a.txt", b"x")], store)), &["no array"]);
    let twice = npz(&[("a.npy", &npy), ("a.npy", &npy)], store);
    refused(folder.raw(&twice), &["2 arrays"]);
    let path = folder.raw(&twice).with_extension("npz");
    std::fs::write(&path, &twice).expect("write");
    let message = open(named(&path, "a"), 1).expect_err("twice").to_string();
    assert!(message.contains("two arrays `a`"), "{message}");
    let zstd = CompressionMethod::ZSTD;
    refused(
        folder.raw(&npz(&[("a.npy", &npy)], zstd)),
        &["array `a`", "ZSTD", "savez_compressed"],
    );
    std::fs::write(&path, &npy).expect("write");
    let message = open(named(&path, "a"), 1).expect_err("no zip").to_string();
    assert!(message.contains("no .npz archive"), "{message}");
    // Values inside the archive are checked as those of a file are.
    let bad = npz(&[("a.npy", &array(&[f32::NAN]))], store);
    refused(folder.raw(&bad), &["element [z=0][y=0][x=0]", "NaN"]);
    refused(
        folder.raw(&npz(&[("a.npy", b"x")], store)),
        &["ends inside the header"],
    );
}

#[test]
fn a_cut_or_changed_archive_is_an_error_that_says_so() {
    let folder = Folder::new();
    let values: Vec<f32> = (0..500).map(|i| (i * i % 97) as f32).collect();
    let npy = array(&values);
    for method in METHODS {
        let whole = npz(&[("a.npy", &npy)], method);
        for keep in [4, 60, whole.len() / 2, whole.len() - 30, whole.len() - 1] {
            refused(folder.raw(&whole[..keep]), &["truncated"]);
        }
        // After a changed byte of the data, its checksum or its inflated bytes differ.
        let mut changed = whole.clone();
        changed[whole.len() / 2] ^= 0x10;
        refused(folder.raw(&changed), &["data", "damaged"]);
    }
}

/// Puts `value` over the uncompressed size of the only member in the archive's directory.
fn with_announced_size(archive: &[u8], value: u32) -> Vec<u8> {
    let mut bytes = archive.to_vec();
    let at = bytes
        .windows(4)
        .rposition(|w| w == b"PK\x01\x02")
        .expect("directory")
        + 24;
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

#[test]
fn sizes_that_the_stored_bytes_cannot_hold_are_refused_before_memory_is_taken() {
    let folder = Folder::new();
    // The header of a volume of 8 GiB, compressed without its data.
    let header = {
        let path = folder.npy(&dict("<f4", "(2048, 2048, 512)"), &[]);
        std::fs::read(path).expect("read")
    };
    for method in METHODS {
        let archive = npz(&[("a.npy", &header)], method);
        refused(folder.raw(&archive), &["only 0", "truncated"]);
        for claim in [0xffff_fffe, 1 << 20] {
            let lying = with_announced_size(&archive, claim);
            refused(folder.raw(&lying), &["announces", "hold at most"]);
        }
    }
    // More data than announced, and less.
    let npy = array(&[1.0; 300]);
    let archive = npz(&[("a.npy", &npy)], CompressionMethod::DEFLATE);
    let less = with_announced_size(&archive, npy.len() as u32 - 4);
    refused(folder.raw(&less), &["truncated"]);
    let short = array(&[1.0; 299]);
    let archive = npz(&[("a.npy", &short)], CompressionMethod::DEFLATE);
    let more = with_announced_size(&archive, short.len() as u32 + 4);
    refused(folder.raw(&more), &["has 1200"]);
}
