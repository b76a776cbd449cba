//! Every shader composition that the renderer can request composes and validates; no adapter is needed.

extern crate occlab_render as occlab;

#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "shaders/uniforms.rs"]
mod uniforms;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use occlab::density::Density;
use occlab::gpu::{Program, Sources, compose, compose_point};
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::param::ParamKind;
use occlab::raymarch::map_defs;
use occlab::shader_defs::Defs;
use std::collections::HashSet;
use std::path::Path;

/// Container, density and definitions of a view, as `View` and `DeviceField` choose them.
#[derive(Clone)]
struct Composition {
    container: &'static str,
    density: String,
    defs: Defs,
}

const ENTRIES: [&str; 2] = ["generate.wgsl", "raymarch.wgsl"];

fn flags(names: &[&str]) -> Defs {
    names
        .iter()
        .map(|name| ((*name).to_owned(), None))
        .collect()
}

/// Containers × kinds of density × their structures.
fn fields() -> Vec<Composition> {
    let folder = tempfile::tempdir().unwrap();
    let mut all: Vec<Composition> = Vec::new();
    for (shader, container) in common::containers() {
        for kind in Density::KINDS {
            for example in (kind.examples)(&container, folder.path()).unwrap() {
                let field = example.field();
                all.push(Composition {
                    container: shader,
                    density: field.shader().into_owned(),
                    defs: field.defs(),
                });
            }
        }
    }
    // Examples of one structure compose to one shader.
    let mut seen = HashSet::new();
    all.retain(|around| {
        seen.insert((
            around.container,
            around.density.clone(),
            around.defs.clone(),
        ))
    });
    all
}

/// Definitions of a method as the renderer makes them; `wide` where the device stores no optional format.
fn method_defs(setup: &MethodSetup, wide: bool) -> Defs {
    let plan = setup.method.plan(&setup.params).unwrap();
    let mut defs = setup.defs(&plan);
    // Some options need a format that only some devices store.
    let made = map_defs(setup, &plan, !wide).or_else(|_| map_defs(setup, &plan, true));
    defs.extend(made.unwrap());
    defs
}

fn composed(entry: &str, setup: &MethodSetup, around: &Composition, extra: Defs) -> naga::Module {
    composed_point(entry, None, setup, around, extra)
}

fn composed_point(
    entry: &str,
    point: Option<&str>,
    setup: &MethodSetup,
    around: &Composition,
    extra: Defs,
) -> naga::Module {
    let mut defs = around.defs.clone();
    defs.extend(extra);
    let shader = setup.method.info().shader;
    let roles = vec![
        ("container", around.container),
        ("density", &*around.density),
        ("sky", "sky/preetham.wgsl"),
        ("occlusion", shader),
    ];
    let program = Program {
        entry,
        roles,
        defs: defs.clone(),
    };
    let module = compose_point(&Sources::embedded(), &program, point);
    let module = module.unwrap_or_else(|e| {
        panic!(
            "{entry} of {shader} in {}, {} with {defs:?}:\n{e}",
            around.container, around.density
        )
    });
    let valid = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
    valid.unwrap_or_else(|e| panic!("{entry} of {shader} with {defs:?}: {e:?}"));
    assert_eq!(module.entry_points.len(), 1);
    module
}

/// Composes the passes that the method has.
fn compose_all(setup: &MethodSetup, around: &Composition, extra: &Defs, wide: bool) {
    let mut defs = method_defs(setup, wide);
    defs.extend(extra.clone());
    for entry in ENTRIES {
        if entry == "raymarch.wgsl" || defs.contains_key("HAS_MAP") {
            composed(entry, setup, around, defs.clone());
        }
    }
    let plan = setup.method.plan(&setup.params).unwrap();
    let own = plan
        .map
        .iter()
        .flat_map(|map| map.before.iter().chain(&map.after));
    for pass in own {
        let shader = setup.method.info().shader;
        composed_point(shader, Some(pass.entry), setup, around, defs.clone());
    }
}

/// The method at its defaults, and with every option of every choice, one at a time.
fn variants(setup: &MethodSetup) -> Vec<(&'static str, &'static str, MethodSetup)> {
    let specs = setup.method.info().specs();
    let choices = specs.filter_map(|s| match s.kind {
        ParamKind::Choice { options, .. } => Some((s.name, options)),
        _ => None,
    });
    choices
        .flat_map(|(name, options)| {
            options
                .iter()
                .map(move |o| (name, *o, setup.clone().with(name, o).unwrap()))
        })
        .collect()
}

fn methods() -> impl Iterator<Item = MethodSetup> {
    REGISTRY
        .iter()
        .map(|m| MethodSetup::defaults(m.info().id).unwrap())
}

#[test]
fn every_method_composes_in_every_surrounding() {
    for setup in methods() {
        for around in fields() {
            compose_all(
                &setup,
                &around,
                &flags(&["SKY", "AMBIENT", "COUNT", "INTEGRATION_THESIS"]),
                true,
            );
        }
        compose_all(&setup, &fields().pop().unwrap(), &Defs::new(), false);
        for extra in [
            &["SKY"][..],
            &["AMBIENT"],
            &["COUNT"],
            &["SKY", "AMBIENT"],
            &["INTEGRATION_THESIS"],
            &["SUBSET"],
            &["SUBSET", "INVERSE_DEPTH", "COUNT", "SKY", "AMBIENT"],
        ] {
            compose_all(&setup, &fields()[0], &flags(extra), false);
        }
    }
}

#[test]
fn every_pass_of_a_reconstruction_composes() {
    for reconstruction in occlab::reconstruct::REGISTRY {
        for entry in reconstruction.info().shaders {
            let program = Program {
                entry,
                roles: Vec::new(),
                defs: Defs::new(),
            };
            compose(&Sources::embedded(), &program).unwrap();
        }
    }
}

#[test]
fn every_option_composes() {
    // The test below composes the same options in a shell of uniform density.
    let around = fields().pop().unwrap();
    for setup in methods() {
        for (_, _, variant) in variants(&setup) {
            compose_all(&variant, &around, &flags(&["COUNT"]), true);
        }
    }
}

/// The method with a whole number at either end, a step from it, and between, where the plan makes a definition of it.
fn structures(setup: &MethodSetup) -> Vec<MethodSetup> {
    let defs = |setup: &MethodSetup| setup.method.plan(&setup.params).unwrap().defs;
    let mut all = Vec::new();
    for spec in setup.method.info().specs() {
        let ParamKind::Int { min, max, .. } = spec.kind else {
            continue;
        };
        let numbers = [min, min + 1, (min + max) / 2, max];
        let set = numbers.map(|n| setup.clone().with(spec.name, &n.to_string()).unwrap());
        if set.iter().any(|other| defs(other) != defs(setup)) {
            all.extend(set);
        }
    }
    all
}

#[test]
fn every_structure_composes() {
    let around = fields().pop().unwrap();
    let mut composed = 0;
    for setup in methods() {
        for structure in structures(&setup) {
            for (_, _, variant) in variants(&structure) {
                compose_all(&variant, &around, &Defs::new(), false);
                composed += 1;
            }
        }
    }
    assert!(composed > 8, "only {composed} were composed");
}

/// Both passes as WGSL text.
fn text(setup: &MethodSetup, extra: &Defs) -> String {
    let around = &fields()[0];
    let mut defs = method_defs(setup, false);
    defs.extend(extra.clone());
    let entries = ENTRIES
        .iter()
        .filter(|e| **e == "raymarch.wgsl" || defs.contains_key("HAS_MAP"));
    entries
        .map(|entry| {
            let module = composed(entry, setup, around, defs.clone());
            let info = Validator::new(ValidationFlags::all(), Capabilities::all())
                .validate(&module)
                .unwrap();
            naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
                .unwrap()
        })
        .collect()
}

#[test]
fn every_option_is_read() {
    for setup in methods() {
        let id = setup.method.info().id;
        assert_eq!(
            text(&setup, &Defs::new()),
            text(&setup, &flags(&["NOBODY_READS_THIS"])),
            "{id}: the comparison itself is at fault"
        );
        let texts: Vec<_> = variants(&setup)
            .into_iter()
            .map(|(name, option, v)| {
                // How the rectangle is laid is the renderer's to read.
                let read = format!("{:?} {}", v.map_fit().ok(), text(&v, &Defs::new()));
                (name, option, read)
            })
            .collect();
        for (i, a) in texts.iter().enumerate() {
            for b in texts[..i].iter().filter(|b| b.0 == a.0) {
                assert!(
                    a.2 != b.2,
                    "{id}: {} = {} and {} are the same shader",
                    a.0,
                    a.1,
                    b.1
                );
            }
        }
    }
}

fn shader_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    entries
        .flat_map(|p| {
            if p.is_dir() {
                shader_files(&p)
            } else {
                vec![p]
            }
        })
        .collect()
}

#[test]
fn files_are_compiled_in_and_begin_with_their_purpose() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders"));
    let files = shader_files(root);
    assert!(files.len() > 20, "{} files", files.len());
    for file in files {
        let name = file
            .strip_prefix(root)
            .unwrap()
            .to_str()
            .unwrap()
            .replace('\\', "/");
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(Sources::embedded().text(&name).unwrap(), text, "{name}");
        let first = text.lines().next().unwrap();
        assert!(
            first.starts_with("// ") && first.len() > 10,
            "{name}: begins with {first}"
        );
        assert!(
            text.lines()
                .take_while(|l| l.starts_with("//"))
                .any(|l| l.contains("Cost"))
                || !name.starts_with("occlusion"),
            "{name}"
        );
    }
}
