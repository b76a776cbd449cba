//! Paths that name one item inside a file: `clouds.npz:density`, `frame.exr:beauty`.

use std::path::{Path, PathBuf};

/// A file, and the item inside it that the user chose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePart {
    /// The file.
    pub file: PathBuf,
    /// Name of the array or layer behind the colon; `None` when the path names the file alone.
    pub name: Option<String>,
}

impl FilePart {
    /// Splits `path` at a colon that follows `.extension` (in any case, given without the dot).
    ///
    /// Other colons belong to the path, such as that of a Windows drive; so do all colons where a file of exactly that
    /// name exists. Of several such colons, the first one that ends the name of an existing file is taken, else the
    /// first.
    pub fn of(path: &Path, extension: &str) -> Self {
        let whole = Self {
            file: path.to_owned(),
            name: None,
        };
        let Some(text) = path.to_str().filter(|_| !path.exists()) else {
            return whole;
        };
        let has_extension = |file: &str| {
            let found = Path::new(file).extension();
            found.is_some_and(|e| e.eq_ignore_ascii_case(extension))
        };
        let splits = || {
            let colons = text.match_indices(':').map(|(at, _)| at);
            colons.filter(|at| has_extension(&text[..*at]))
        };
        let is_file = |at: &usize| Path::new(&text[..*at]).is_file();
        splits()
            .find(is_file)
            .or_else(|| splits().next())
            .map_or(whole, |at| Self {
                file: PathBuf::from(&text[..at]),
                name: Some(text[at + 1..].to_owned()),
            })
    }

    /// Path of the same item in another file.
    pub fn path_in(&self, file: impl Into<PathBuf>) -> PathBuf {
        let mut path = file.into();
        if let Some(name) = &self.name {
            path.as_mut_os_string().push(":");
            path.as_mut_os_string().push(name);
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &str) -> (String, Option<String>) {
        let part = FilePart::of(Path::new(text), "npz");
        (part.file.display().to_string(), part.name)
    }

    #[test]
    fn the_same_item_of_another_file_keeps_its_name() {
        let part = |text: &str| FilePart::of(Path::new(text), "npz").path_in("b.npz");
        assert_eq!(part("a.npz:density"), Path::new("b.npz:density"));
        assert_eq!(part("a.npz"), Path::new("b.npz"));
    }

    #[test]
    fn a_name_follows_the_extension_and_other_colons_belong_to_the_path() {
        let cases = [
            ("a.npz", "a.npz", None),
            ("a.npz:density", "a.npz", Some("density")),
            ("a.NPZ:x", "a.NPZ", Some("x")),
            ("a.npz:", "a.npz", Some("")),
            ("a.npz:x:y", "a.npz", Some("x:y")),
            ("C:/clouds/a.npz", "C:/clouds/a.npz", None),
            ("C:\\clouds\\a.npz:x", "C:\\clouds\\a.npz", Some("x")),
            ("a:b/c.npz:d/e.f", "a:b/c.npz", Some("d/e.f")),
            ("a.npy:x", "a.npy:x", None),
            (":x", ":x", None),
        ];
        for (text, file, name) in cases {
            assert_eq!(split(text), (file.into(), name.map(str::to_owned)));
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_whose_own_name_has_the_colon_wins() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz:b.npz");
        let text = path.display().to_string();
        let named = |file: &str, name: &str| {
            let file = folder.path().join(file).display().to_string();
            (file, Some(name.to_owned()))
        };
        assert_eq!(split(&text), named("a.npz", "b.npz"));
        std::fs::write(&path, b"").unwrap();
        assert_eq!(split(&text), (text.clone(), None));
        assert_eq!(split(&format!("{text}:c")), named("a.npz:b.npz", "c"));
    }
}
