//! No circle of files: what a file names with `use` never names it in turn, however many files lie between.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

use crate::sources::{crates, is_test, root, sources};

/// Module paths of a crate (`["linear", "pivoting"]`) and the files they stand in.
type Modules = BTreeMap<Vec<String>, PathBuf>;

/// The module that a file of a crate is, from its path below `src`.
fn module_of(path: &Path) -> Vec<String> {
    let mut parts: Vec<String> = path
        .with_extension("")
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if parts
        .last()
        .is_some_and(|last| last == "mod" || last == "lib")
    {
        parts.pop();
    }
    parts
}

/// Paths that a file names: `crate::…`, `super::…`, `self::…`, and children named without `self`.
struct Named<'a> {
    modules: &'a Modules,
    here: Vec<String>,
    found: BTreeSet<Vec<String>>,
}

impl Named<'_> {
    fn resolve(&mut self, path: &[String]) {
        let child = [self.here.clone(), path[..1].to_vec()].concat();
        let mut absolute = match path[0].as_str() {
            "crate" => Vec::new(),
            "self" => self.here.clone(),
            "super" => self.here[..self.here.len().saturating_sub(1)].to_vec(),
            _ if self.modules.contains_key(&child) => child,
            // Another crate.
            _ => return,
        };
        for part in &path[1..] {
            if part == "super" {
                absolute.pop();
            } else {
                absolute.push(part.clone());
            }
        }
        self.found.insert(absolute);
    }

    fn tree(&mut self, prefix: &[String], tree: &syn::UseTree) {
        let with = |name: String| [prefix.to_vec(), vec![name]].concat();
        match tree {
            syn::UseTree::Path(path) => self.tree(&with(path.ident.to_string()), &path.tree),
            syn::UseTree::Name(name) => self.resolve(&with(name.ident.to_string())),
            syn::UseTree::Rename(name) => self.resolve(&with(name.ident.to_string())),
            syn::UseTree::Glob(_) => self.resolve(prefix),
            syn::UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.tree(prefix, tree));
            }
        }
    }
}

impl<'ast> Visit<'ast> for Named<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_test(&item.attrs) {
            self.tree(&[], &item.tree);
        }
    }
}

/// The file that a path leads to: that of the longest module it begins with, at last the root.
fn file_of<'a>(modules: &'a Modules, path: &[String]) -> Option<&'a PathBuf> {
    (0..=path.len())
        .rev()
        .find_map(|length| modules.get(&path[..length]))
}

/// File → files it names, within one crate.
fn edges(folder: &Path) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let source = folder
        .strip_prefix(root())
        .expect("below the root")
        .join("src");
    let files = sources(folder);
    let own = |path: &Path| module_of(path.strip_prefix(&source).expect("of the crate"));
    let modules: Modules = files
        .iter()
        .map(|file| (own(&file.path), file.path.clone()))
        .collect();
    let mut edges = BTreeMap::new();
    for file in &files {
        let mut named = Named {
            modules: &modules,
            here: own(&file.path),
            found: BTreeSet::new(),
        };
        named.visit_file(&syn::parse_file(&file.text).expect("Rust"));
        let targets: BTreeSet<PathBuf> = named
            .found
            .iter()
            .filter_map(|path| file_of(&modules, path))
            .filter(|target| **target != file.path)
            .cloned()
            .collect();
        edges.insert(file.path.clone(), targets);
    }
    edges
}

/// A circle through the files, if there is one.
fn circle(edges: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> Option<Vec<PathBuf>> {
    fn walk(
        at: &PathBuf,
        edges: &BTreeMap<PathBuf, BTreeSet<PathBuf>>,
        trail: &mut Vec<PathBuf>,
        done: &mut BTreeSet<PathBuf>,
    ) -> bool {
        if let Some(from) = trail.iter().position(|file| file == at) {
            trail.drain(..from);
            return true;
        }
        if done.contains(at) {
            return false;
        }
        trail.push(at.clone());
        if edges
            .get(at)
            .into_iter()
            .flatten()
            .any(|next| walk(next, edges, trail, done))
        {
            return true;
        }
        trail.pop();
        done.insert(at.clone());
        false
    }
    let (mut trail, mut done) = (Vec::new(), BTreeSet::new());
    edges
        .keys()
        .any(|file| walk(file, edges, &mut trail, &mut done))
        .then_some(trail)
}

#[test]
fn no_file_is_part_of_a_circle() {
    let mut found = Vec::new();
    for folder in crates() {
        let edges = edges(&folder);
        let count: usize = edges.values().map(BTreeSet::len).sum();
        println!("{}: {} files, {count} names", folder.display(), edges.len());
        found.extend(circle(&edges));
    }
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_circle_is_seen() {
    let file = |name: &str| PathBuf::from(name);
    let to = |names: &[&str]| names.iter().map(|name| file(name)).collect::<BTreeSet<_>>();
    let mut edges = BTreeMap::from([
        (file("a"), to(&["b", "c"])),
        (file("b"), to(&["c"])),
        (file("c"), to(&[])),
    ]);
    assert_eq!(circle(&edges), None);
    edges.insert(file("c"), to(&["b"]));
    assert_eq!(circle(&edges), Some(vec![file("b"), file("c")]));
}
