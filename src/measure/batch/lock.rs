//! One run at a time in a folder: `batch.lock` names the process that writes there.
//!
//! Two runs in one folder would measure every cell twice, each spoiling the other's times. The lock is a file that is
//! created exclusively and appears with its whole content, by a rename or hard link that fails where the name exists.
//! Local and network file systems guarantee that; they do not guarantee advisory locks (`flock`), so none is used.
//!
//! A run that was killed leaves its file behind. Whether its process still runs is asked of the operating system, and
//! only where the answer is certain: on the same boot of the same machine, in the same process namespace, by process id
//! and start time (ids are used again). The lock of an ended process, and one from before a reboot of this machine, is
//! taken over without a message.
//!
//! The process of another machine cannot be asked. A heartbeat would be unreliable: a suspended laptop, a paused
//! container, the attribute cache of a network file system and clocks that differ all look like an ended process, and a
//! wrong guess spoils the times of both runs. So such a lock is refused with a message that says who holds it, since
//! when, and which file to remove if that run is over.

use crate::error::{Error, Result};
use crate::frame::atomic::{create_atomic, write_atomic};
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const LOCK: &str = "batch.lock";
/// File held while the lock of an ended process is replaced, so that only one run does it.
const TAKEOVER: &str = "batch.lock.takeover";
/// Attempts to read a lock that changes hands; with the pause between them two seconds in all.
const LOOKS: u32 = 40;
const PAUSE: Duration = Duration::from_millis(50);
/// The process namespace of a Linux machine itself, outside any container.
const OUTERMOST: &str = "pid:[4026531836]";

/// A folder that no other run may write to; free again when this is dropped.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    token: String,
}

/// The process that writes to a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct LockHolder {
    host: String,
    process: u32,
    since_utc: String,
    /// Tells this lock from every other one.
    token: String,
    /// Start of the process in clock ticks since boot; `None` where the system does not say.
    started: Option<u64>,
    system: Option<System>,
}

/// Where the process id is unique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct System {
    boot: String,
    process_namespace: String,
    /// Hash of the machine's id; `None` where it has none.
    machine: Option<String>,
}

/// State of a lock's process.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Standing {
    Running,
    Ended,
    Unknown,
}

impl Lock {
    /// Takes `folder` and creates it where it is absent; an error names the holder where another run has it.
    pub fn take(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
        take(folder, LockHolder::this_process())
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if matches!(read(&self.path), Ok(Some(holder)) if holder.token == self.token) {
            // May fail: the next run takes the file over, once this process has ended.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn take(folder: &Path, me: LockHolder) -> Result<Lock> {
    let path = folder.join(LOCK);
    let held = |me: LockHolder| Lock {
        path: folder.join(LOCK),
        token: me.token,
    };
    for _ in 0..LOOKS {
        if create(&path, &me)? {
            return Ok(held(me));
        }
        match read(&path)? {
            None => {} // released since
            // A file server that answered late had created the file before the request was repeated.
            Some(holder) if holder.token == me.token => return Ok(held(me)),
            Some(holder) => match holder.standing(&me) {
                Standing::Ended if take_over(folder, &path, &holder, &me)? => return Ok(held(me)),
                Standing::Ended => std::thread::sleep(PAUSE),
                standing => return Err(busy(folder, &path, &holder, standing)),
            },
        }
    }
    let path = folder.join(TAKEOVER);
    let remedy = format!("If no run uses the folder, remove this file and {LOCK}.");
    let problem = "another run is taking the folder over, and does not come to an end";
    Err(Error::input(path.display().to_string(), problem, remedy))
}

/// Replaces the lock of a dead process; `false` when another run was faster.
fn take_over(folder: &Path, path: &Path, dead: &LockHolder, me: &LockHolder) -> Result<bool> {
    let guard = folder.join(TAKEOVER);
    if !create(&guard, me)? {
        return Ok(false);
    }
    let replaced = match read(path) {
        Ok(Some(holder)) if holder == *dead => {
            write_atomic(path, |file| write(path, file, me)).map(|()| true)
        }
        other => other.map(|_| false),
    };
    std::fs::remove_file(&guard).map_err(Error::writing(&guard))?;
    replaced
}

fn create(path: &Path, holder: &LockHolder) -> Result<bool> {
    create_atomic(path, |file| write(path, file, holder))
}

fn write(path: &Path, file: &mut impl Write, holder: &LockHolder) -> Result<()> {
    let text = serde_json::to_vec_pretty(holder).map_err(|e| Error::writing(path)(e.into()))?;
    file.write_all(&text).map_err(Error::writing(path))
}

/// The holder that a lock names; `None` when there is no lock.
fn read(path: &Path) -> Result<Option<LockHolder>> {
    let unreadable = |problem: String| {
        let problem =
            format!("it should name the run that uses this folder, but cannot be read: {problem}");
        let remedy = "If no run uses the folder, remove this file.";
        Error::input(path.display().to_string(), problem, remedy)
    };
    match std::fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(unreadable(error.to_string())),
        Ok(bytes) => serde_json::from_slice(&bytes)
            .map(Some)
            .map_err(|e| unreadable(e.to_string())),
    }
}

fn busy(folder: &Path, path: &Path, holder: &LockHolder, standing: Standing) -> Error {
    let (process, host, since) = (holder.process, &holder.host, &holder.since_utc);
    let who = format!(
        "another run has been using this folder since {since}: process {process} on host `{host}`"
    );
    let wait = "Wait for it, or name another folder with --out";
    let (problem, remedy) = match standing {
        Standing::Running => (who, format!("{wait}.")),
        _ => (
            format!("{who}, which cannot be asked from here whether it still runs"),
            format!("{wait}; if that run is over, remove {}.", path.display()),
        ),
    };
    Error::input(folder.display().to_string(), problem, remedy)
}

impl LockHolder {
    fn this_process() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let process = std::process::id();
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let host = host_name();
        Self {
            token: format!("{host}-{process}-{:x}-{count}", now.as_nanos()),
            host,
            process,
            since_utc: utc(now.as_secs()),
            started: match start(process) {
                Process::Running(ticks) => Some(ticks),
                _ => None,
            },
            system: System::this(),
        }
    }

    fn standing(&self, me: &Self) -> Standing {
        let (Some(theirs), Some(mine)) = (&self.system, &me.system) else {
            return Standing::Unknown;
        };
        if self.host != me.host {
            return Standing::Unknown;
        }
        if (&theirs.boot, &theirs.process_namespace) == (&mine.boot, &mine.process_namespace) {
            return match start(self.process) {
                Process::Running(ticks) if self.started.is_none_or(|known| known == ticks) => {
                    Standing::Running
                }
                Process::Running(_) | Process::Ended => Standing::Ended,
                Process::Hidden => Standing::Unknown,
            };
        }
        let outermost = |system: &System| system.process_namespace == OUTERMOST;
        let same_machine = theirs.machine.is_some() && theirs.machine == mine.machine;
        match same_machine && theirs.boot != mine.boot && outermost(theirs) && outermost(mine) {
            true => Standing::Ended,
            false => Standing::Unknown,
        }
    }
}

impl System {
    /// `None` where the operating system has no `/proc`: then no lock of another process can be judged.
    fn this() -> Option<Self> {
        let line = |path: &str| {
            let text = std::fs::read_to_string(path).ok()?;
            Some(text.trim().to_owned()).filter(|line| !line.is_empty())
        };
        let namespace = std::fs::read_link("/proc/self/ns/pid").ok()?;
        // The id itself must not leave this machine.
        let hashed = |id: String| {
            blake3::derive_key("occlab batch.lock machine", id.as_bytes())
                .iter()
                .take(8)
                .map(|byte| format!("{byte:02x}"))
                .collect()
        };
        Some(Self {
            boot: line("/proc/sys/kernel/random/boot_id")?,
            process_namespace: namespace.to_string_lossy().into_owned(),
            machine: line("/etc/machine-id").map(hashed),
        })
    }
}

enum Process {
    /// Started at this many clock ticks since boot.
    Running(u64),
    Ended,
    /// This system does not show when a process started.
    Hidden,
}

fn start(process: u32) -> Process {
    match std::fs::read_to_string(format!("/proc/{process}/stat")) {
        Ok(stat) => match start_of(&stat) {
            Some(found) => found,
            None => Process::Hidden,
        },
        // A system may hide the processes of other users; then it hides the first process, too.
        Err(error) if error.kind() == ErrorKind::NotFound => {
            match std::fs::read_to_string("/proc/1/stat") {
                Ok(_) => Process::Ended,
                Err(_) => Process::Hidden,
            }
        }
        Err(_) => Process::Hidden,
    }
}

/// `proc_pid_stat(5)`: after the name, which may hold anything, the state, and 19 fields later the start.
fn start_of(stat: &str) -> Option<Process> {
    let mut fields = stat.get(stat.rfind(')')? + 1..)?.split_ascii_whitespace();
    let state = fields.next()?;
    if ["Z", "X", "x"].contains(&state) {
        return Some(Process::Ended); // only its parent has not noticed
    }
    fields.nth(18)?.parse().ok().map(Process::Running)
}

fn host_name() -> String {
    let file = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let named = |name: &str| std::env::var(name).ok();
    file.or_else(|| named("HOSTNAME"))
        .or_else(|| named("COMPUTERNAME"))
        .map(|name| name.trim().to_owned())
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| "unknown".to_owned())
}

/// Seconds since 1970 as a date that people read (H. Hinnant, "chrono-compatible low-level date algorithms").
fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153; // from March
    let (of_month, month) = (day - (153 * month + 2) / 5 + 1, (month + 2) % 12 + 1);
    let year = year + era * 400 + u64::from(month <= 2);
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!(
        "{year}-{month:02}-{of_month:02} {hour:02}:{minute:02}:{:02} UTC",
        second % 60
    )
}

#[cfg(test)]
mod tests;
