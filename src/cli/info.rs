//! `occlab methods`, `occlab adapters`, `occlab schema`.

use super::say;
use occlab::Error;
use occlab::gpu::{Gpu, list_adapters};
use occlab::occlusion::{MethodInfo, REGISTRY};
use occlab::param::{ParamKind, ParamSpec};
use serde_json::{Value, json};
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Json {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
pub struct Methods {
    #[command(flatten)]
    json: Json,
    /// Print one table in Markdown, without parameters: that of README.md.
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
}

pub fn methods(options: &Methods) -> anyhow::Result<ExitCode> {
    let all = REGISTRY.iter().map(|m| m.info());
    if options.json.json {
        let all: Vec<_> = all.map(method_json).collect();
        say(serde_json::to_string_pretty(&all)?)?;
    } else if options.markdown {
        say("| id | what a light look-up does | values a texel | what to expect to fail |")?;
        say("|---|---|---|---|")?;
        for i in all {
            let (id, summary) = (i.id, i.summary);
            say(format!(
                "| `{id}` | {summary} | {} | {} |",
                i.texel, i.expect
            ))?;
        }
    } else {
        for info in all {
            say(method_text(info))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// A method for people: what it is, its parameters, and apart from them what only reproduces a source.
fn method_text(info: &MethodInfo) -> String {
    let mut text = format!("{}: {}\n    {}\n", info.id, info.title, info.citation);
    text += &format!("    Expect: {}\n", info.expect);
    for spec in info.specs().filter(|spec| spec.is_everyday()) {
        text += &parameter_text(spec);
    }
    let printed = |spec: &'static ParamSpec| spec.as_printed.iter().map(move |p| (spec, p));
    for (i, (spec, printed)) in info.specs().flat_map(printed).enumerate() {
        if i == 0 {
            text += "    Only to reproduce what a source prints:\n";
        }
        let (name, default, option) = (spec.name, spec.default_value(), printed.option);
        let (doc, applies) = (printed.doc, applies_text(spec));
        text += &format!("        {name} = {option} (not {default}): {doc}.{applies}\n");
    }
    text
}

fn parameter_text(spec: &ParamSpec) -> String {
    let unit = match spec.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let range = match spec.kind {
        ParamKind::Choice { .. } => spec.everyday_options().collect::<Vec<_>>().join(" | "),
        _ => spec.range_text(),
    };
    let (name, default) = (spec.name, spec.default_value());
    let applies = applies_text(spec);
    format!(
        "    {name} = {default}{unit}    [{range}]\n        {}{applies}\n",
        spec.doc
    )
}

fn applies_text(spec: &ParamSpec) -> String {
    match spec.applies.words() {
        Some(condition) => format!(" Applies where {condition}."),
        None => String::new(),
    }
}

fn method_json(info: &MethodInfo) -> Value {
    let params: Vec<_> = info
        .specs()
        .map(|s| {
            let printed = s.as_printed.iter();
            let printed: Vec<_> = printed.map(|p| json!({"option": p.option, "doc": p.doc})).collect();
            json!({"name": s.name, "unit": s.unit, "range": s.range_text(), "default": s.default_value(), "doc": s.doc, "applies_where": s.applies.words(), "as_printed": printed})
        })
        .collect();
    json!({
        "id": info.id,
        "title": info.title,
        "summary": info.summary,
        "values_a_texel": info.texel,
        "expect": info.expect,
        "citation": info.citation,
        "params": params,
    })
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
    let schema = occlab::config::schema(&occlab::reconstruct::Registry);
    say(serde_json::to_string_pretty(&schema)?)?;
    Ok(ExitCode::SUCCESS)
}
