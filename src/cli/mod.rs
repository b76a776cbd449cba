//! Command line: what each command takes, and how results and errors are shown.

mod batch;
mod cache;
mod diff;
mod info;
mod init;
mod probe;
mod progress;
mod render;
mod scene;
mod stability;
mod study;
#[cfg(feature = "ui")]
mod view;

use clap::{Parser, Subcommand};
use occlab::Error;
use occlab::backend::{Backend, Choice};
use std::io::Write;
use std::process::ExitCode;

/// Measures how clouds shadow themselves.
///
/// One GPU ray marcher, many light-occlusion methods, each timed and compared with a 1000-step truth.
/// Start with `occlab batch quick`, then open the index.html it names.
///
/// Scenes, experiments and studies are files or names. A name is looked for in this order: the file NAME, the file
/// NAME.json, NAME.json in `configs` beside you (scenes in `configs/scenes`, studies in `configs/studies`), the file of
/// that name that is built in. `occlab init` writes the built-in files out to be edited.
#[derive(Parser)]
#[command(version = occlab::provenance::version(), max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Open the window: switch methods, compare, probe. The same as `occlab` without a command.
    #[cfg(feature = "ui")]
    View(view::ViewArgs),
    /// Measure a matrix of scenes and methods, write a report; run it again to go on after an interruption.
    Batch(batch::BatchArgs),
    /// Rebuild csv, charts and page of a report folder from its records.
    Report(batch::Rebuild),
    /// Render one picture of a scene with one method.
    Render(render::RenderArgs),
    /// Draw T(d) of every method against the truth along one light column: chart and CSV. Needs no adapter.
    Probe(probe::ProbeArgs),
    /// Compare two pictures (EXR or PNG): every error number, and a signed difference picture.
    Diff(diff::Diff),
    /// Run every method at extremes of the number formats, on the oracle and on the device.
    Stability(stability::StabilityArgs),
    /// Reproduce a published comparison: its experiments, figures and claims; without a name the studies are listed.
    Study(study::StudyArgs),
    /// Show the folder in which batches keep truths, or empty it.
    ///
    /// Batches and studies keep each truth, so that it is rendered once: in the user's cache folder, or where OCCLAB_CACHE
    /// says. When the folder holds more than OCCLAB_CACHE_LIMIT (bytes, or e.g. 500MiB; `none` for no limit; default: 4GiB),
    /// the truths used longest ago are removed. The one just written stays, even where it alone is over the limit.
    Cache(cache::Cache),
    /// List the light-occlusion methods and their parameters.
    Methods(info::Methods),
    /// List the adapters of this machine.
    Adapters(info::Json),
    /// Write the built-in experiments, scenes and studies to DIR/configs, to be edited. Overwrites nothing.
    Init(init::Init),
    /// Print the JSON Schema of experiments, scenes, studies and stability sweeps.
    Schema,
}

/// Options of commands that render.
#[derive(clap::Args)]
struct DeviceArgs {
    /// Part of the adapter's name; default: the fastest kind. `occlab adapters` lists them.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// What renders: a device, or the f64 oracle on the CPU; auto takes the oracle where there is no adapter.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendName,
    /// No progress on stderr.
    #[arg(long, short)]
    quiet: bool,
}

/// [`Choice`] on the command line.
#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum BackendName {
    #[default]
    Auto,
    Gpu,
    Cpu,
}

impl DeviceArgs {
    /// Opens the requested backend. One line on stderr says which one renders, even when quiet where it is the oracle
    /// without having been asked for.
    fn open(&self) -> occlab::Result<Backend> {
        let choice = match self.backend {
            BackendName::Auto => Choice::Auto,
            BackendName::Gpu => Choice::Gpu,
            BackendName::Cpu => Choice::Cpu,
        };
        if let (Choice::Cpu, Some(adapter)) = (choice, &self.adapter) {
            let place = format!("--backend cpu --adapter {adapter}");
            let problem = "the f64 oracle runs on the CPU and uses no adapter";
            return Err(Error::input(place, problem, "Give one of the two."));
        }
        let backend = Backend::open(choice, self.adapter.as_deref())?;
        let environment = backend.environment();
        if !backend.is_oracle() {
            if !self.quiet {
                let (name, kind) = (environment.adapter, environment.device_type);
                eprintln!("adapter: {name} ({kind})");
            }
        } else if choice == Choice::Auto {
            eprintln!(
                "no adapter: the {} renders instead, {}; `--backend gpu` says what to install",
                environment.adapter, environment.driver
            );
        } else if !self.quiet {
            eprintln!("backend: {}, {}", environment.adapter, environment.driver);
        }
        Ok(backend)
    }
}

/// Runs a command. Exit codes: 0 done, 1 done but some cells failed, 2 an error.
pub fn run(cli: Cli) -> ExitCode {
    let Some(command) = cli.command else {
        return finish(without_command());
    };
    finish(match command {
        #[cfg(feature = "ui")]
        Command::View(c) => c.run(),
        Command::Batch(c) => c.run(),
        Command::Report(c) => c.run(),
        Command::Render(c) => c.run(),
        Command::Probe(c) => c.run(),
        Command::Diff(c) => c.run(),
        Command::Stability(c) => c.run(),
        Command::Study(c) => c.run(),
        Command::Cache(c) => c.run(),
        Command::Methods(c) => info::methods(&c),
        Command::Adapters(c) => info::adapters(&c),
        Command::Init(c) => c.run(),
        Command::Schema => info::schema(),
    })
}

/// The window; the help in a build without one.
#[cfg(feature = "ui")]
fn without_command() -> anyhow::Result<ExitCode> {
    view::ViewArgs::default().run()
}

#[cfg(not(feature = "ui"))]
fn without_command() -> anyhow::Result<ExitCode> {
    use clap::CommandFactory;
    Cli::command().print_help()?;
    Ok(ExitCode::from(2))
}

fn finish(outcome: anyhow::Result<ExitCode>) -> ExitCode {
    match outcome {
        Ok(code) => code,
        Err(error) if reader_left(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}"); // one paragraph: a cause stands in its text
            ExitCode::from(2)
        }
    }
}

/// One line, or a paragraph, of results on stdout.
fn say(text: impl std::fmt::Display) -> std::io::Result<()> {
    writeln!(std::io::stdout().lock(), "{text}")
}

/// Whether the reader of stdout has closed it, as in `occlab methods | head`: no error.
fn reader_left(error: &anyhow::Error) -> bool {
    let broken = |e: &std::io::Error| e.kind() == std::io::ErrorKind::BrokenPipe;
    error.downcast_ref().is_some_and(broken)
}

/// The path of a report, last line of every command that writes one.
fn print_path(path: &std::path::Path) -> std::io::Result<()> {
    say(path.display())
}
