//! Which locks are respected, taken over or refused; at most one run has a folder.

use super::*;
use crate::damage::{cases, changed, changes, damaged, edits};
use proptest::prelude::*;

/// Writes a lock of this process, changed by `edit`.
fn leave(folder: &Path, edit: impl FnOnce(&mut LockHolder)) -> PathBuf {
    let mut holder = LockHolder::this_process();
    edit(&mut holder);
    let path = folder.join(LOCK);
    std::fs::write(&path, serde_json::to_vec(&holder).expect("text")).expect("written");
    path
}

fn refusal(folder: &Path) -> String {
    let error = Lock::take(folder).expect_err("refused").to_string();
    assert!(!error.chars().any(char::is_control), "{error}");
    error
}

#[test]
fn a_held_folder_is_refused_by_name_and_free_when_the_lock_is_dropped() {
    let folder = tempfile::tempdir().expect("folder");
    let inside = folder.path().join("report");
    let lock = Lock::take(&inside).expect("free");
    let error = refusal(&inside);
    let process = std::process::id().to_string();
    for word in [process.as_str(), "UTC", "another run", "--out"] {
        assert!(error.contains(word), "{word}: {error}");
    }
    drop(lock);
    assert_eq!(std::fs::read_dir(&inside).expect("folder").count(), 0);
    drop(Lock::take(&inside).expect("free again"));
}

#[cfg(target_os = "linux")]
#[test]
fn the_lock_of_a_dead_process_and_of_a_reused_id_is_taken_over() {
    let mut child = std::process::Command::new("true").spawn().expect("process");
    let dead = child.id();
    child.wait().expect("ended");
    let edits: [&dyn Fn(&mut LockHolder); 3] = [
        &|holder| holder.process = dead,
        &|holder| holder.started = holder.started.map(|ticks| ticks + 1),
        &|holder| {
            let system = holder.system.as_mut().expect("system");
            system.boot = "before the reboot".to_owned();
            system.process_namespace = OUTERMOST.to_owned();
        },
    ];
    let here = System::this().expect("system");
    let reboot_shows = here.machine.is_some() && here.process_namespace == OUTERMOST;
    for edit in &edits[..if reboot_shows { 3 } else { 2 }] {
        let folder = tempfile::tempdir().expect("folder");
        let path = leave(folder.path(), edit);
        let lock = Lock::take(folder.path()).expect("taken over");
        let holder = read(&path).expect("lock").expect("lock");
        assert_eq!(holder.token, lock.token);
        assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_process_that_has_ended_but_whose_parent_has_not_noticed_is_dead() {
    let mut child = std::process::Command::new("true").spawn().expect("process");
    let folder = tempfile::tempdir().expect("folder");
    let started = match start(child.id()) {
        Process::Running(ticks) => Some(ticks),
        _ => None,
    };
    leave(folder.path(), |holder| {
        (holder.process, holder.started) = (child.id(), started);
    });
    let deadline = std::time::Instant::now() + Duration::from_secs(20);
    while Lock::take(folder.path()).is_err() {
        assert!(std::time::Instant::now() < deadline, "never taken over");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait().expect("ended");
}

#[test]
fn the_lock_of_another_host_or_container_is_refused_with_the_file_to_remove() {
    let edits: [&dyn Fn(&mut LockHolder); 3] = [
        &|holder| holder.host = "renderfarm-07".to_owned(),
        &|holder| holder.system = None,
        &|holder| {
            if let Some(system) = &mut holder.system {
                system.process_namespace = "pid:[1]".to_owned();
            }
        },
    ];
    for edit in edits {
        let folder = tempfile::tempdir().expect("folder");
        let path = leave(folder.path(), |holder| {
            holder.process = u32::MAX;
            edit(holder);
        });
        if read(&path).expect("lock").expect("lock").system.is_none() && cfg!(not(unix)) {
            continue;
        }
        let error = refusal(folder.path());
        let file = path.display().to_string();
        for word in ["cannot be asked", "remove", file.as_str()] {
            assert!(error.contains(word), "{word}: {error}");
        }
        assert!(path.exists(), "a lock that is refused is kept");
        std::fs::remove_file(&path).expect("as the message says");
        drop(Lock::take(folder.path()).expect("free"));
    }
}

#[test]
fn what_is_no_lock_is_refused_and_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join(LOCK);
    for text in ["", "{", "{\"host\": 3}", "\u{0}\u{1b}[2J"] {
        std::fs::write(&path, text).expect("written");
        let error = refusal(folder.path());
        assert!(
            error.contains(LOCK) && error.contains("remove this file"),
            "{error}"
        );
        assert_eq!(std::fs::read_to_string(&path).expect("kept"), text);
    }
    std::fs::remove_file(&path).expect("removed");
    std::fs::create_dir(&path).expect("folder");
    assert!(refusal(folder.path()).contains(LOCK));
}

#[test]
fn only_one_of_many_takes_over() {
    let folder = tempfile::tempdir().expect("folder");
    for round in 0..20 {
        leave(folder.path(), |holder| {
            holder.started = holder.started.map(|ticks| ticks + 1);
            holder.token = format!("dead {round}");
        });
        let barrier = std::sync::Barrier::new(8);
        let taken: Vec<Option<Lock>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8)
                .map(|_| {
                    scope.spawn(|| {
                        barrier.wait();
                        Lock::take(folder.path()).ok()
                    })
                })
                .collect();
            let joined = threads.into_iter().map(|t| t.join().expect("thread"));
            joined.collect()
        });
        let count = taken.iter().flatten().count();
        assert_eq!(count, if cfg!(target_os = "linux") { 1 } else { 0 });
    }
}

#[test]
fn a_lock_that_was_removed_and_taken_by_another_is_not_released() {
    let folder = tempfile::tempdir().expect("folder");
    let first = Lock::take(folder.path()).expect("free");
    std::fs::remove_file(folder.path().join(LOCK)).expect("removed by hand");
    let second = Lock::take(folder.path()).expect("free");
    drop(first);
    assert!(folder.path().join(LOCK).exists());
    drop(second);
    assert!(!folder.path().join(LOCK).exists());
}

#[test]
fn a_takeover_that_was_killed_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    leave(folder.path(), |holder| {
        holder.started = holder.started.map(|ticks| ticks + 1);
    });
    if LockHolder::this_process().system.is_none() {
        return assert!(refusal(folder.path()).contains(LOCK));
    }
    std::fs::write(folder.path().join(TAKEOVER), "").expect("written");
    let error = refusal(folder.path());
    assert!(
        error.contains(TAKEOVER) && error.contains("remove"),
        "{error}"
    );
}

#[test]
fn dates_are_those_of_the_calendar() {
    for (seconds, date) in [
        (0, "1970-01-01 00:00:00 UTC"),
        (951_782_399, "2000-02-28 23:59:59 UTC"),
        (951_782_400, "2000-02-29 00:00:00 UTC"),
        (1_709_251_200, "2024-03-01 00:00:00 UTC"),
        (4_102_444_799, "2099-12-31 23:59:59 UTC"),
    ] {
        assert_eq!(utc(seconds), date);
    }
}

#[test]
fn the_start_of_a_process_is_found_behind_any_name() {
    let stat = |name: &str, state: &str| {
        let fields: Vec<String> = (4..22).map(|field| field.to_string()).collect();
        format!("17 ({name}) {state} {} 4711 99\n", fields.join(" "))
    };
    for name in ["occlab", "a) Z (b", "", "two words"] {
        let found = start_of(&stat(name, "S"));
        assert!(matches!(found, Some(Process::Running(4711))), "{name}");
    }
    assert!(matches!(
        start_of(&stat("occlab", "Z")),
        Some(Process::Ended)
    ));
    assert!(start_of("17 (occlab").is_none() && start_of("17 (occlab) S 1 2").is_none());
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_damaged_lock_is_taken_over_or_refused_by_name(edits in edits(), changes in changes(), whole in any::<bool>()) {
        let folder = tempfile::tempdir().expect("folder");
        let path = leave(folder.path(), |_| {});
        let bytes = std::fs::read(&path).expect("lock");
        let bytes = match whole {
            true => changed(serde_json::from_slice(&bytes).expect("lock"), &changes).to_string().into_bytes(),
            false => damaged(&bytes, &edits, usize::MAX),
        };
        std::fs::write(&path, bytes).expect("written");
        if let Err(error) = Lock::take(folder.path()) {
            let text = error.to_string();
            let named = text.contains(&folder.path().display().to_string());
            prop_assert!(named && !text.chars().any(char::is_control), "{text}");
        }
    }
}
