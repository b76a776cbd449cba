//! `occlab methods`, `occlab adapters`, `occlab schema`.

use super::say;
use occlab::Error;
use occlab::gpu::{Gpu, list_adapters};
use occlab::occlusion::REGISTRY;
use serde_json::{Value, json};
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Json {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn methods(options: &Json) -> anyhow::Result<ExitCode> {
    if options.json {
        let all: Vec<_> = REGISTRY.iter().map(|m| method_json(m.info())).collect();
        say(serde_json::to_string_pretty(&all)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    for method in REGISTRY {
        let info = method.info();
        say(format!(
            "{}: {}\n    {}",
            info.id, info.title, info.citation
        ))?;
        for spec in info.specs() {
            let unit = if spec.unit.is_empty() {
                String::new()
            } else {
                format!(" {}", spec.unit)
            };
            say(format!(
                "    {} = {}{unit}    [{}]\n        {}{}",
                spec.name,
                spec.default_value(),
                spec.range_text(),
                spec.doc,
                match spec.applies.words() {
                    Some(condition) => format!(" Applies where {condition}."),
                    None => String::new(),
                }
            ))?;
        }
        say("")?;
    }
    Ok(ExitCode::SUCCESS)
}

fn method_json(info: &occlab::occlusion::MethodInfo) -> Value {
    let params: Vec<_> = info
        .specs()
        .map(|s| json!({"name": s.name, "unit": s.unit, "range": s.range_text(), "default": s.default_value(), "doc": s.doc, "applies_where": s.applies.words()}))
        .collect();
    json!({"id": info.id, "title": info.title, "citation": info.citation, "params": params})
}

pub fn adapters(options: &Json) -> anyhow::Result<ExitCode> {
    let all = list_adapters();
    if options.json {
        say(serde_json::to_string_pretty(&all)?)?;
    } else if all.is_empty() {
        // Opening one produces the message that names the package to install.
        return Gpu::new(None)
            .map(|_| ExitCode::SUCCESS)
            .map_err(Error::into);
    }
    if !options.json {
        for a in &all {
            say(format!(
                "{}\n    {} {}, {}, timestamps {}, f32 filtering {}, maps up to {}²",
                a.name,
                a.backend,
                a.device_type,
                a.driver,
                a.timestamps,
                a.float32_filterable,
                a.max_texture_2d
            ))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

pub fn schema() -> anyhow::Result<ExitCode> {
    let schema = occlab::config::schema(&occlab::occlusion::Registry);
    say(serde_json::to_string_pretty(&schema)?)?;
    Ok(ExitCode::SUCCESS)
}
