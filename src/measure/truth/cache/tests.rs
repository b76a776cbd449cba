//! Which truths are kept, which are removed, and what a reader finds meanwhile.

use super::entry::{picture, sheet};
use super::*;
use crate::cost::Counting;
use crate::cost::Samples;
use crate::truth::{RenderedTruth, Truth, cached};
use std::sync::atomic::{AtomicBool, Ordering};

const IMAGE: ImageSize = ImageSize {
    width: 3,
    height: 2,
};
const COST: TruthCost = TruthCost {
    march_ms: Some(1.5),
    wall_ms: 2.5,
    samples: Some(Samples {
        view: 1,
        light: 2,
        map: 0,
    }),
};

/// A picture that differs for every number.
fn frame(number: u32) -> Frame {
    let plane = |k: f32| (0..6).map(|i| [number as f32 + k * i as f32; 4]).collect();
    Frame {
        width: IMAGE.width,
        height: IMAGE.height,
        radiance: plane(0.5),
        sun: plane(0.25),
    }
}

fn id(number: u32) -> String {
    format!("{number:016x}")
}

fn put(cache: &TruthCache, number: u32) {
    cache.put(&id(number), &frame(number), &COST).unwrap();
}

/// Puts the last use of a file `seconds` back.
fn age(path: &Path, seconds: u64) {
    let file = File::options().write(true).open(path).unwrap();
    let then = SystemTime::now() - Duration::from_secs(seconds);
    file.set_modified(then).unwrap();
}

/// A cache of truths 1 to `count`, the first used longest ago, and the bytes of one.
fn filled(folder: &Path, count: u32) -> u64 {
    let cache = TruthCache::new(folder, u64::MAX);
    for number in 1..=count {
        put(&cache, number);
        age(
            &sheet(folder, &id(number)),
            u64::from(1000 * (count + 1 - number)),
        );
    }
    cache.usage().unwrap().bytes / u64::from(count)
}

/// The numbers of the truths that can be read.
fn present(cache: &TruthCache) -> Vec<u32> {
    let readable = |number: &u32| {
        entry::read(cache.folder(), &id(*number), IMAGE)
            .unwrap()
            .is_some()
    };
    (1..=9).filter(readable).collect()
}

#[test]
fn the_truths_used_longest_ago_are_removed_and_a_use_is_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = filled(folder.path(), 4);
    let cache = TruthCache::new(folder.path(), 3 * bytes + bytes / 2);
    let found = cache.get(&id(1), IMAGE).unwrap();
    assert_eq!(found, Some((frame(1), COST)));
    put(&cache, 5);
    cache.trim(&id(5)).unwrap();
    assert_eq!(present(&cache), [1, 4, 5]);
    let usage = cache.usage().unwrap();
    assert_eq!(usage.entries, 3);
    assert!(usage.bytes <= cache.limit_bytes() && usage.bytes > 2 * bytes);
    assert!(usage.oldest_use < usage.last_use);
    // Within the limit nothing goes.
    cache.trim(&id(5)).unwrap();
    assert_eq!(present(&cache), [1, 4, 5]);
}

#[test]
fn a_truth_just_written_stays_even_where_it_alone_is_over_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    filled(folder.path(), 3);
    let cache = TruthCache::new(folder.path(), 1);
    put(&cache, 4);
    // Its clock may be behind that of who wrote the others.
    age(&sheet(folder.path(), &id(4)), 1_000_000);
    cache.trim(&id(4)).unwrap();
    assert_eq!(present(&cache), [4]);
    put(&cache, 5);
    cache.trim(&id(5)).unwrap();
    assert_eq!(present(&cache), [5]);
}

#[test]
fn files_of_others_and_truths_being_written_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    filled(folder.path(), 2);
    let path = |name: &str| folder.path().join(name);
    let others = [
        "notes.txt",
        "t.json",
        "0000000000000001.txt",
        "0000000000000001.exr.bak",
        "000000000000000A.exr",
        "00000000000000001.json",
        ".occlab-x",
    ];
    let unfinished = [id(6) + ".exr", ".occlab-new.part".to_owned()];
    let abandoned = [id(7) + ".exr", ".occlab-old.part".to_owned()];
    let written = others
        .map(str::to_owned)
        .into_iter()
        .chain(unfinished.clone());
    for name in written.chain(abandoned.clone()) {
        fs::write(path(&name), "content").unwrap();
    }
    fs::create_dir(path("0000000000000008.exr")).unwrap();
    for name in others
        .iter()
        .map(|name| path(name))
        .chain(abandoned.iter().map(|name| path(name)))
    {
        age(&name, 7200);
    }
    let cache = TruthCache::new(folder.path(), 0);
    let all = cache.usage().unwrap();
    assert_eq!(all.entries, 2);
    let removed = cache.clear().unwrap();
    assert_eq!(removed.entries, 2);
    let left = cache.usage().unwrap();
    assert_eq!((left.entries, left.bytes), (0, all.bytes - removed.bytes));
    assert_eq!(left.bytes, 14, "the two that are being written");
    assert!(others.iter().all(|name| path(name).is_file()));
    assert!(path("0000000000000008.exr").is_dir());
    assert!(unfinished.iter().all(|name| path(name).is_file()));
    assert!(!abandoned.iter().any(|name| path(name).exists()));
    cache.trim("").unwrap();
    assert!(unfinished.iter().all(|name| path(name).is_file()));
}

#[test]
fn who_reads_while_another_removes_finds_the_truth_or_none() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..4 {
        filled(folder.path(), 9);
        let cache = TruthCache::new(folder.path(), 0);
        let done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    while !done.load(Ordering::Relaxed) {
                        for number in 1..=9 {
                            let found = cache.get(&id(number), IMAGE).expect("a whole one or none");
                            assert!(found.is_none_or(|(found, _)| found == frame(number)));
                        }
                    }
                });
            }
            // Two processes over their limit at once.
            let trims = [0, 0].map(|_| scope.spawn(|| cache.trim("")));
            let trimmed = trims.map(|trim| trim.join().unwrap());
            done.store(true, Ordering::Relaxed);
            trimmed.into_iter().for_each(|outcome| outcome.unwrap());
        });
        assert_eq!(present(&cache), [0; 0]);
    }
}

/// The truth 1 from `cache`, rendered where it has none.
fn truth(cache: &TruthCache) -> Truth {
    cached(id(1), IMAGE, Some(cache), Counting::On, || {
        Ok(RenderedTruth {
            frame: frame(1),
            cost: COST,
            passes_s: 0.5,
        })
    })
    .unwrap()
}

#[test]
fn a_cache_that_cannot_be_written_costs_a_note_and_no_truth() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "in place of a folder").unwrap();
    let occupied = folder.path().join("occupied");
    fs::create_dir_all(sheet(&occupied, &id(1)).join("in place of a sheet")).unwrap();
    for folder in [file, occupied] {
        let found = truth(&TruthCache::new(&folder, u64::MAX));
        assert_eq!((found.frame, found.cached), (frame(1), false));
        let note = found.note.unwrap();
        assert!(
            note.contains("a truth is not kept for the next run"),
            "{note}"
        );
        assert!(note.contains(&folder.display().to_string()), "{note}");
    }
}

#[test]
fn a_file_that_cannot_be_removed_is_named_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let mut item = Item::new(&id(1), SystemTime::now());
    item.add(
        entry::TruthFile::Sheet,
        folder.path().to_owned(),
        1,
        SystemTime::now(),
    );
    let message = item.remove().unwrap_err().to_string();
    assert!(
        message.contains(&folder.path().display().to_string()),
        "{message}"
    );
    assert!(
        message.contains("cannot remove") && message.contains("OCCLAB_CACHE"),
        "{message}"
    );
}

#[cfg(unix)]
#[test]
fn a_truth_that_may_be_read_and_not_written_is_used() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let cache = TruthCache::new(folder.path(), u64::MAX);
    put(&cache, 1);
    let read_only =
        |path: &Path| fs::set_permissions(path, PermissionsExt::from_mode(0o444)).unwrap();
    read_only(&sheet(folder.path(), &id(1)));
    read_only(&picture(folder.path(), &id(1)));
    let found = truth(&cache);
    assert!(found.cached && found.note.is_none() && found.frame == frame(1));
}

#[test]
fn a_folder_that_is_not_there_is_empty() {
    let folder = tempfile::tempdir().unwrap();
    let cache = TruthCache::new(folder.path().join("none"), 0);
    assert_eq!(cache.usage().unwrap().entries, 0);
    assert_eq!(cache.clear().unwrap(), Removed::default());
    cache.trim("").unwrap();
}

#[test]
fn a_truth_of_other_sources_has_another_name() {
    let view = serde_json::json!({"scene": "slab", "image": IMAGE});
    let ours = truth_id(view.clone());
    assert!(ours.len() == 16 && ours == hashed(&view, truth_sources()));
    assert_ne!(ours, hashed(&view, "sources with another formula"));
    assert_ne!(
        ours,
        truth_id(serde_json::json!({"scene": "box", "image": IMAGE}))
    );
}
