//! Changes of a scene: numbers, words, keys and tables, one to three at a time.

use toml::{Table, Value};

use super::random::Draw;

/// Words that mean something somewhere in a scene.
const WORDS: [&str; 16] = [
    "steady",
    "bdf2",
    "free",
    "zero",
    "auto",
    "explicit",
    "semi-implicit",
    "staggered",
    "periodic",
    "slip",
    "open",
    "wall",
    "sunflower",
    "none",
    "",
    "..",
];
/// Bounds of iterations: lower ones end a run earlier, with the same words.
const BOUNDS: [(&str, i64); 4] = [
    ("contact.sweeps_max", 500),
    ("contact.sub_steps_max", 20),
    ("coupling.scheme.iterated.passes_max", 8),
    ("fluid.nonlinear.newton.iterations_max", 8),
];

/// Programs of engines that are built with the workspace.
pub const PROGRAMS: [&str; 3] = ["frozen-particles", "prescribed-fluid", "rapier-particles"];

/// Where a value stands: keys and numbers of entries.
type Place = Vec<String>;

/// A scene changed in one to three places, parts of others among them.
pub fn changed(tree: &Value, others: &[&Value], draw: &mut Draw) -> Value {
    let mut tree = tree.clone();
    for _ in 0..draw.among(&[1, 1, 1, 2, 3]) {
        match draw.below(5) {
            0 => graft(&mut tree, draw.among(others), draw),
            _ => change(&mut tree, draw),
        }
    }
    for (key, most) in BOUNDS {
        bound(&mut tree, key, most);
    }
    tame(&mut tree);
    tree
}

/// No word is a program, whatever this machine has under its name.
fn tame(tree: &mut Value) {
    for seat in ["fluid", "particles"] {
        let place = ["engines", seat, "command", "0"].map(str::to_string);
        if let Some(Value::String(program)) = at(tree, &place)
            && !PROGRAMS.contains(&program.as_str())
        {
            *program = "no-such-engine".to_string();
        }
    }
}

/// Every place below a value.
fn places(value: &Value, above: &Place, found: &mut Vec<Place>) {
    let mut visit = |key: String, value: &Value| {
        let place = [&above[..], &[key]].concat();
        places(value, &place, found);
        found.push(place);
    };
    match value {
        Value::Table(table) => table
            .iter()
            .for_each(|(key, value)| visit(key.clone(), value)),
        Value::Array(list) => {
            let entries = list.iter().enumerate();
            entries.for_each(|(index, value)| visit(index.to_string(), value));
        }
        _ => {}
    }
}

fn some_place(tree: &Value, draw: &mut Draw) -> Option<Place> {
    let mut found = Vec::new();
    places(tree, &Vec::new(), &mut found);
    (!found.is_empty()).then(|| found.swap_remove(draw.below(found.len())))
}

fn at<'a>(tree: &'a mut Value, place: &[String]) -> Option<&'a mut Value> {
    place.iter().try_fold(tree, |node, key| match node {
        Value::Table(table) => table.get_mut(key),
        Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })
}

/// Put a part of another scene where it stands there.
fn graft(tree: &mut Value, other: &Value, draw: &mut Draw) {
    let Some(place) = some_place(other, draw) else {
        return;
    };
    let mut other = other.clone();
    let (Some(value), Some((last, above))) = (at(&mut other, &place), place.split_last()) else {
        return;
    };
    match at(tree, above) {
        Some(Value::Table(table)) => _ = table.insert(last.clone(), value.clone()),
        Some(Value::Array(list)) => list.push(value.clone()),
        _ => {}
    }
}

/// Change one value, or take it away.
fn change(tree: &mut Value, draw: &mut Draw) {
    let (Some(place), Some(elsewhere)) = (some_place(tree, draw), some_place(tree, draw)) else {
        return;
    };
    let other = at(tree, &elsewhere).map(|value| value.clone());
    if draw.once_in(8) {
        return remove(tree, &place);
    }
    let (Some(value), Some(other)) = (at(tree, &place), other) else {
        return;
    };
    match (draw.once_in(12), &mut *value) {
        (true, _) => *value = other,
        (_, Value::Float(number)) => *number = another(*number, draw),
        (_, Value::Integer(number)) => *value = another_integer(*number, draw),
        (_, Value::Boolean(flag)) => *flag = !*flag,
        (_, Value::String(word)) => *word = draw.among(&WORDS).to_string(),
        (_, Value::Array(list)) => rearrange(list, draw),
        (_, Value::Table(table)) => drop_key(table, draw),
        _ => {}
    }
}

fn remove(tree: &mut Value, place: &Place) {
    let Some((last, above)) = place.split_last() else {
        return;
    };
    match at(tree, above) {
        Some(Value::Table(table)) => _ = table.remove(last),
        Some(Value::Array(list)) => {
            if let Ok(index) = last.parse::<usize>() {
                list.remove(index);
            }
        }
        _ => {}
    }
}

fn another(number: f64, draw: &mut Draw) -> f64 {
    match draw.below(10) {
        0..5 => number * draw.scale(1e-3, 1e3),
        5 => -number,
        6 => 0.0,
        7 => number * (1.0 + 1e-12),
        8 => number + draw.among(&[1e-3, 1.0]),
        _ => draw.among(&[1e300, -1e300, 1e-300, f64::NAN, f64::INFINITY]),
    }
}

fn another_integer(number: i64, draw: &mut Draw) -> Value {
    Value::Integer(match draw.below(8) {
        0..3 => (number as f64 * draw.scale(0.3, 2.0)) as i64,
        3 => number + 1,
        4 => -number,
        5 => draw.among(&[0, 1, 2]),
        6 => draw.among(&[i64::MAX, i64::MIN, 4_294_967_296]),
        _ => return Value::Float(number as f64),
    })
}

fn rearrange(list: &mut Vec<Value>, draw: &mut Draw) {
    match draw.below(4) {
        0 => list.reverse(),
        1 => list.extend(list.last().cloned()),
        2 => list.clear(),
        _ => _ = list.pop(),
    }
}

fn drop_key(table: &mut Table, draw: &mut Draw) {
    let keys: Vec<String> = table.keys().cloned().collect();
    if !keys.is_empty() {
        table.remove(&keys[draw.below(keys.len())]);
    }
}

/// Lower a bound that is there, and write it down where its table is.
fn bound(tree: &mut Value, key: &str, most: i64) {
    let place: Place = key.split('.').map(str::to_string).collect();
    let (last, above) = place.split_last().expect("a key");
    if let Some(Value::Table(table)) = at(tree, above) {
        let entry = table.entry(last.clone()).or_insert(Value::Integer(most));
        if let Value::Integer(number) = entry {
            *number = (*number).min(most);
        }
    }
}
