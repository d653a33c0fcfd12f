//! The source files of the product, parsed.

use std::path::{Path, PathBuf};

/// One source file.
pub struct Source {
    /// Path from the root of the workspace.
    pub path: PathBuf,
    /// What it says.
    pub text: String,
}

/// The root of the workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests lies in the workspace")
}

/// Folders of crates that make up the product: what a run needs, the command, kits and engines.
pub fn crates() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for top in [
        "protocol",
        "fluid-solver",
        "particle-solver",
        "coupler",
        "orchestration",
        "engines",
    ] {
        collect(&root().join(top), &mut found, &|path| {
            path.file_name().is_some_and(|name| name == "Cargo.toml")
        });
    }
    let mut folders: Vec<PathBuf> = found
        .iter()
        .filter_map(|manifest| manifest.parent().map(Path::to_path_buf))
        .collect();
    folders.sort();
    folders
}

/// Every source file below the `src` of a crate.
pub fn sources(folder: &Path) -> Vec<Source> {
    let mut found = Vec::new();
    collect(&folder.join("src"), &mut found, &|path| {
        path.extension().is_some_and(|extension| extension == "rs")
    });
    found.sort();
    found
        .into_iter()
        .map(|path| Source {
            text: std::fs::read_to_string(&path).expect("a source file"),
            path: path
                .strip_prefix(root())
                .expect("below the root")
                .to_path_buf(),
        })
        .collect()
}

/// Files below a folder that are wanted; builds and environments are no sources.
fn collect(folder: &Path, found: &mut Vec<PathBuf>, wanted: &dyn Fn(&Path) -> bool) {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && !name.starts_with('.') && name != "target" {
            collect(&path, found, wanted);
        } else if path.is_file() && wanted(&path) {
            found.push(path);
        }
    }
}

/// Is this item there for tests only?
pub fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let list = match &attribute.meta {
            syn::Meta::List(list) => list.tokens.to_string(),
            _ => String::new(),
        };
        attribute.path().is_ident("test") || (attribute.path().is_ident("cfg") && list == "test")
    })
}
