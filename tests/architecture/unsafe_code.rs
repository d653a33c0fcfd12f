//! Where the compiler is asked to trust: in named modules only, each place with its reason.

use crate::sources::{crates, root, sources};

/// Modules that may, and what for.
const ALLOWED: [(&str, &str); 14] = [
    (
        "fluid-solver/src/wide.rs",
        "instructions that not every processor has",
    ),
    (
        "fluid-solver/src/linear/tile.rs",
        "blocks whose bounds were seen once",
    ),
    (
        "protocol/src/run/signals.rs",
        "signals and the end of a process",
    ),
    (
        "protocol/src/transport/descriptor.rs",
        "a listener's descriptor",
    ),
    ("engines/kit/c/src/calls.rs", "functions of an engine in C"),
    ("engines/kit/c/src/exchange.rs", "arrays handed to C"),
    ("engines/kit/c/src/fluid.rs", "functions of an engine in C"),
    ("engines/kit/c/src/handle.rs", "the handle that C holds"),
    ("engines/kit/c/src/mesh.rs", "arrays that C hands over"),
    (
        "engines/kit/c/src/particles.rs",
        "functions of an engine in C",
    ),
    ("engines/kit/python/src/buffer.rs", "arrays shown to Python"),
    (
        "engines/kit/python/src/driver.rs",
        "a thread that holds no interpreter",
    ),
    (
        "engines/kit/python/src/held.rs",
        "a buffer that Python may keep",
    ),
    (
        "tests/src/exchange.rs",
        "numbers as bytes, to compare with a socket",
    ),
];

/// A comment that gives the reason stands so many lines above, or nearer.
const REACH: usize = 8;

fn asks(line: &str) -> bool {
    let code = line.split("//").next().unwrap_or_default();
    let mut words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.any(|word| word == "unsafe")
}

/// A type of functions that C calls, or a name that it sees, is no place where memory is trusted.
fn declares(line: &str) -> bool {
    line.contains("#[unsafe(") || line.contains("unsafe extern \"C\" fn(")
}

#[test]
fn unsafe_code_is_in_named_modules_with_a_reason_each() {
    let mut folders = crates();
    folders.push(root().join("tests"));
    let (mut places, mut strangers, mut bare) = (0, Vec::new(), Vec::new());
    for source in folders.iter().flat_map(|folder| sources(folder)) {
        let path = source.path.display().to_string();
        let lines: Vec<&str> = source.text.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            if !asks(line) || declares(line) {
                continue;
            }
            places += 1;
            if !ALLOWED.iter().any(|(module, _)| *module == path) {
                strangers.push(format!("{path}:{}", number + 1));
            }
            let above = &lines[number.saturating_sub(REACH)..number];
            let reason = |line: &&str| line.contains("SAFETY:") || line.contains("# Safety");
            if !above.iter().any(reason) {
                bare.push(format!("{path}:{}", number + 1));
            }
        }
    }
    for (module, what) in ALLOWED {
        println!("{module}: {what}");
        assert!(root().join(module).exists(), "{module} is gone");
    }
    println!("{places} places");
    assert!(strangers.is_empty(), "unsafe elsewhere: {strangers:#?}");
    assert!(bare.is_empty(), "unsafe without a reason: {bare:#?}");
}
