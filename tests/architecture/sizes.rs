//! How long functions and files are: product code, without its tests.

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::sources::{crates, is_test, sources};

/// Lines of each function with its name.
#[derive(Default)]
struct Functions(Vec<(usize, String)>);

impl Functions {
    fn add(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let lines = block.span().end().line - signature.span().start().line + 1;
        self.0.push((lines, signature.ident.to_string()));
    }
}

impl<'ast> Visit<'ast> for Functions {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_test(&item.attrs) {
            self.add(&item.sig, &item.block);
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.add(&item.sig, block);
        }
    }
}

fn share(sorted: &[usize], share: f64) -> usize {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[test]
fn functions_and_files_are_short() {
    let (mut functions, mut files) = (Vec::new(), Vec::new());
    for source in crates().iter().flat_map(|folder| sources(folder)) {
        let path = source.path.display().to_string();
        files.push((source.text.lines().count(), path.clone()));
        let mut found = Functions::default();
        found.visit_file(&syn::parse_file(&source.text).expect("Rust"));
        functions.extend(
            found
                .0
                .into_iter()
                .map(|(lines, name)| (lines, format!("{path} {name}"))),
        );
    }
    functions.sort();
    files.sort();
    let lines = |all: &[(usize, String)]| all.iter().map(|(lines, _)| *lines).collect::<Vec<_>>();
    let (f, s) = (lines(&functions), lines(&files));
    println!("| | number | median | 9 of 10 | largest |");
    println!(
        "| functions | {} | {} | {} | {} |",
        f.len(),
        share(&f, 0.5),
        share(&f, 0.9),
        share(&f, 1.0)
    );
    println!(
        "| files | {} | {} | {} | {} |",
        s.len(),
        share(&s, 0.5),
        share(&s, 0.9),
        share(&s, 1.0)
    );
    for (lines, name) in functions
        .iter()
        .rev()
        .take(12)
        .chain(files.iter().rev().take(12))
    {
        println!("{lines:5} {name}");
    }
    assert!(share(&f, 0.5) <= 10 && share(&f, 0.9) <= 35 && share(&f, 1.0) <= 80);
    assert!(share(&s, 0.5) <= 200 && share(&s, 1.0) <= 450);
}
