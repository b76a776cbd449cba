//! Shader composition: WGSL files with `#import`, `#ifdef` and `#{NAME}`, resolved by naga_oil.
//!
//! Modules are named by their file (`map` is `shared/map.wgsl`). A program is an entry file plus roles that say which
//! file plays a role (`container`, `density`, `occlusion`), so that every pipeline is specialised and holds no code of
//! a feature its scene or method does not use.

use crate::error::{Error, REPORT, Result};
use crate::shader_defs::Defs;
use include_dir::{Dir, include_dir};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderDefValue,
    get_preprocessor_data,
};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// What to compose.
#[derive(Clone, Debug)]
pub struct Program<'a> {
    /// File with the entry point, path below `shaders/`.
    pub entry: &'a str,
    /// Role → file that plays it: `("occlusion", "occlusion/esm.wgsl")`.
    pub roles: Vec<(&'a str, &'a str)>,
    /// Definitions.
    pub defs: Defs,
}

/// The folder `shaders`, compiled in.
static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../shaders");

/// Path and text of every shader in a folder and below.
fn files(folder: &'static Dir<'static>) -> Vec<(&'static str, &'static str)> {
    let own = folder
        .files()
        .filter_map(|file| Some((file.path().to_str()?, file.contents_utf8()?)))
        .filter(|(path, _)| path.ends_with(".wgsl"));
    own.chain(folder.dirs().flat_map(files)).collect()
}

/// The text of every shader file, by its path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources {
    /// The program's own, below `shaders/`.
    own: BTreeMap<&'static str, Cow<'static, str>>,
    /// Added files by path: used only where a role or an entry names them, so that their names may equal those of
    /// shared modules.
    added: BTreeMap<String, String>,
}

impl Sources {
    /// The files as compiled in.
    pub fn embedded() -> Self {
        let all = files(&FILES).into_iter();
        Self {
            own: all.map(|(path, text)| (path, text.into())).collect(),
            added: BTreeMap::new(),
        }
    }

    /// Adds the text of a file that is not the program's own, or replaces what was added under this path. A program takes
    /// it where a role or its entry names the path.
    pub fn add(&mut self, path: impl Into<String>, text: impl Into<String>) -> Result<()> {
        let path = path.into();
        if self.own.contains_key(path.as_str()) {
            let problem = "this is the path of one of the program's own shaders";
            return Err(Error::input(path, problem, "Choose another path."));
        }
        self.added.insert(path, text.into());
        Ok(())
    }

    /// These sources with the text of one more file; a file that exists under `path` is kept.
    pub fn with(&self, path: &'static str, text: &'static str) -> Self {
        let mut all = self.clone();
        if !all.own.contains_key(path) {
            all.added.entry(path.to_owned()).or_insert(text.to_owned());
        }
        all
    }

    /// The program's own files read from a folder of the same layout, for reloading in a development build.
    pub fn read(folder: &Path) -> Result<Self> {
        let read = |path: &'static str| {
            let file = folder.join(path);
            let text = std::fs::read_to_string(&file).map_err(Error::reading(&file))?;
            Ok((path, text.into()))
        };
        let own = Self::embedded().own.into_keys().map(read);
        Ok(Self {
            own: own.collect::<Result<_>>()?,
            added: BTreeMap::new(),
        })
    }

    /// The text of one file.
    pub fn text(&self, path: &str) -> Result<&str> {
        let own = self.own.get(path).map(AsRef::as_ref);
        own.or_else(|| self.added.get(path).map(String::as_str))
            .ok_or_else(|| Error::Shader {
                file: path.to_owned(),
                message: "no such shader file is compiled in".into(),
            })
    }

    /// `error`, with a request to report it as a defect where these are the program's own, unchanged shaders.
    pub fn blame(&self, error: Error) -> Error {
        match error {
            Error::Shader { file, message } if *self == Self::embedded() => Error::Shader {
                file,
                message: format!("{}\n{REPORT}", message.trim_end()),
            },
            other => other,
        }
    }

    /// Hash of every path and text: a picture cached under another hash is stale.
    pub fn hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        let own = self.own.iter().map(|(path, text)| (*path, text.as_ref()));
        let added = self.added.iter();
        let added = added.map(|(path, text)| (path.as_str(), text.as_str()));
        for (path, text) in own.chain(added) {
            hasher
                .update(path.as_bytes())
                .update(&(text.len() as u64).to_le_bytes())
                .update(text.as_bytes());
        }
        hasher.finalize()
    }
}

/// Resolves imports and definitions, validates, and drops what the entry point does not use.
pub fn compose(sources: &Sources, program: &Program) -> Result<naga::Module> {
    compose_point(sources, program, None)
}

/// [`compose`] for `point`, one of several entry points of the file.
pub fn compose_point(
    sources: &Sources,
    program: &Program,
    point: Option<&str>,
) -> Result<naga::Module> {
    // Allowed here whether or not the device has them: support is checked for each texture format.
    let optional = naga::valid::Capabilities::STORAGE_TEXTURE_16BIT_NORM_FORMATS;
    let capabilities = naga::valid::Capabilities::default() | optional;
    let mut loader = Loader {
        composer: Composer::default().with_capabilities(capabilities),
        sources,
        program,
    };
    let source = sources.text(program.entry)?;
    loader.add_imports(source)?;
    let defs = shader_defs(&program.defs);
    let made = loader.composer.make_naga_module(NagaModuleDescriptor {
        source,
        file_path: program.entry,
        shader_defs: defs,
        ..Default::default()
    });
    let mut module = made.map_err(|e| loader.error(program.entry, &e))?;
    if let Some(point) = point {
        module.entry_points.retain(|entry| entry.name == point);
    }
    if module.entry_points.is_empty() {
        let message = match point {
            Some(point) => format!("has no entry point `{point}`"),
            None => "has no entry point".to_owned(),
        };
        let file = format!("shaders/{}", program.entry);
        return Err(Error::Shader { file, message });
    }
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    Ok(module)
}

fn shader_defs(defs: &Defs) -> HashMap<String, ShaderDefValue> {
    defs.iter()
        .map(|(k, v)| {
            (
                k.clone(),
                v.map_or(ShaderDefValue::Bool(true), ShaderDefValue::Int),
            )
        })
        .collect()
}

/// Adds imported files depth first, so that each is known before its importer.
struct Loader<'a> {
    composer: Composer,
    sources: &'a Sources,
    program: &'a Program<'a>,
}

impl Loader<'_> {
    fn add_imports(&mut self, source: &str) -> Result<()> {
        let (_, imports, _) = get_preprocessor_data(source);
        for import in imports {
            let name = import
                .import
                .split("::")
                .next()
                .unwrap_or_default()
                .to_owned();
            self.add(&name)?;
        }
        Ok(())
    }

    fn add(&mut self, name: &str) -> Result<()> {
        if self.composer.contains_module(name) {
            return Ok(());
        }
        let Some(path) = self.path_of(name) else {
            // An import behind an `#ifdef` that is off: naga_oil reports it if it is needed after all.
            return Ok(());
        };
        let source = self.sources.text(&path)?;
        self.add_imports(source)?;
        let added = self
            .composer
            .add_composable_module(ComposableModuleDescriptor {
                source,
                file_path: &path,
                as_name: Some(name.to_owned()),
                ..Default::default()
            });
        match added {
            Ok(_) => Ok(()),
            Err(e) => Err(self.error(&path, &e)),
        }
    }

    /// A role's file, or the shared file of that name.
    fn path_of(&self, name: &str) -> Option<String> {
        let role = self
            .program
            .roles
            .iter()
            .find(|(role, _)| *role == name)
            .map(|(_, path)| (*path).to_owned());
        role.or_else(|| {
            let file = format!("{name}.wgsl");
            let mut paths = self.sources.own.keys();
            paths
                .find(|path| path.rsplit('/').next() == Some(&file))
                .map(|path| (*path).to_owned())
        })
    }

    fn error(&self, path: &str, error: &ComposerError) -> Error {
        Error::Shader {
            file: format!("shaders/{path}"),
            message: error.emit_to_string(&self.composer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_the_programs_own_shaders_is_said_to_be_a_defect_and_one_of_others_is_not() {
        let error = |sources: &Sources| {
            let message = "x is not defined\n".to_owned();
            let file = "shaders/generate.wgsl".to_owned();
            sources.blame(Error::Shader { file, message }).to_string()
        };
        let mut sources = Sources::embedded();
        let own = error(&sources);
        assert!(own.contains("x is not defined\nThis is a defect of occlab"));
        sources.own.insert("generate.wgsl", "fn x() {}".into());
        assert_eq!(
            error(&sources),
            "shader shaders/generate.wgsl: x is not defined\n"
        );
        let other = sources.blame(Error::input("p", "q", "R."));
        assert!(matches!(other, Error::Input { .. }));
    }

    #[test]
    fn a_file_of_others_plays_the_role_that_names_it_and_no_other() {
        let mut sources = Sources::embedded();
        let before = sources.hash();
        let text = "fn density(p: vec3f) -> f32 { return p.y; }\n\
                    fn empty_distance(p: vec3f) -> f32 { return -1.0; }\n";
        // Has the name of the shared module that every march imports.
        let path = String::from("home/medium.wgsl");
        sources.add(&path, text).unwrap();
        assert_eq!(sources.text(&path).unwrap(), text);
        assert_ne!(sources.hash(), before);
        let program = |density| Program {
            entry: "raymarch.wgsl",
            roles: vec![
                ("container", "container/box.wgsl"),
                ("density", density),
                ("occlusion", "occlusion/none.wgsl"),
            ],
            defs: Defs::new(),
        };
        let composed = |sources: &Sources, density| {
            let module = compose(sources, &program(density)).unwrap();
            format!("{module:?}")
        };
        assert_ne!(
            composed(&sources, &path),
            composed(&sources, "density/uniform.wgsl")
        );
        assert!(compose(&Sources::embedded(), &program(&path)).is_err());
        let own = sources.add("density/uniform.wgsl", text).unwrap_err();
        assert!(own.to_string().contains("the program's own shaders"));
        sources.add(&path, "not a shader").unwrap();
        assert!(compose(&sources, &program(&path)).is_err());
    }
}
