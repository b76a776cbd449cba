//! `occlab cache`.

use super::say;
use indicatif::{BinaryBytes, HumanDuration};
use occlab::Error;
use occlab::truth::TruthCache;
use occlab::truth::cache::{FOLDER_VARIABLE, LIMIT_VARIABLE, Removed, Usage};
use serde_json::json;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

#[derive(clap::Args)]
pub struct Cache {
    /// Remove every truth, but not one that another process is writing. Other files in the folder are left alone.
    #[arg(long)]
    clear: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Cache {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let Some(cache) = TruthCache::from_environment()? else {
            let problem = "there is no home folder to keep truths in";
            let remedy = "Set it to a folder; without one every batch renders its truths anew.";
            return Err(Error::input(FOLDER_VARIABLE, problem, remedy).into());
        };
        let removed = match self.clear {
            true => Some(cache.clear()?),
            false => None,
        };
        let usage = cache.usage()?;
        match self.json {
            true => say(serde_json::to_string_pretty(&as_json(
                &cache, &usage, removed,
            ))?)?,
            false => say(as_text(&cache, &usage, removed))?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn as_json(cache: &TruthCache, usage: &Usage, removed: Option<Removed>) -> serde_json::Value {
    let limit = cache.limit_bytes();
    let seconds = |time: SystemTime| time.duration_since(UNIX_EPOCH).ok().map(|t| t.as_secs());
    let mut shown = json!({
        "folder": cache.folder().to_string_lossy(),
        "entries": usage.entries,
        "bytes": usage.bytes,
        "oldest_use_unix_s": usage.oldest_use.and_then(seconds),
        "last_use_unix_s": usage.last_use.and_then(seconds),
        "limit_bytes": (limit < u64::MAX).then_some(limit),
    });
    if let Some(removed) = removed {
        shown["removed"] = json!({"entries": removed.entries, "bytes": removed.bytes});
    }
    shown
}

fn as_text(cache: &TruthCache, usage: &Usage, removed: Option<Removed>) -> String {
    let limit = match cache.limit_bytes() {
        u64::MAX => "no limit".to_owned(),
        limit => format!("limit {}", BinaryBytes(limit)),
    };
    // A time in the future, as another machine's clock writes it, is now.
    let ago = |time: SystemTime| HumanDuration(time.elapsed().unwrap_or_default());
    let mut lines = vec![format!("folder   {}", cache.folder().display())];
    if let Some(Removed { entries, bytes }) = removed {
        lines.push(format!("removed  {entries} truths, {}", BinaryBytes(bytes)));
    }
    lines.push(format!("truths   {}", usage.entries));
    lines.push(format!(
        "size     {}, {limit} ({LIMIT_VARIABLE})",
        BinaryBytes(usage.bytes)
    ));
    if let Some((last, oldest)) = usage.last_use.zip(usage.oldest_use) {
        let (last, oldest) = (ago(last), ago(oldest));
        lines.push(format!("used     last {last} ago, the oldest {oldest} ago"));
    }
    if usage.bytes > cache.limit_bytes() {
        lines.push("The limit is kept when the next truth is written.".to_owned());
    }
    lines.join("\n")
}
