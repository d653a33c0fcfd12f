//! How often a number of dimensions is spelled out where the code is meant for any.

use crate::sources::{root, sources};

/// Arrays of two or three numbers, as the plane and space have them.
fn spellings(text: &str) -> usize {
    ["f64", "usize", "u32", "i32", "Option<f64>"]
        .iter()
        .flat_map(|element| [2, 3].map(|count| format!("[{element}; {count}]")))
        .map(|spelling| text.matches(&spelling).count())
        .sum()
}

#[test]
fn solvers_and_coupler_hardly_spell_out_a_dimension() {
    let mut total = 0;
    for folder in ["fluid-solver", "particle-solver", "coupler"] {
        for source in sources(&root().join(folder)) {
            let count = spellings(&source.text);
            if count > 0 {
                println!("{count:4} {}", source.path.display());
            }
            total += count;
        }
    }
    println!("{total} together");
    assert!(total <= 25, "{total}");
}
