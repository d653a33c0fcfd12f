//! What makes a mesh unusable is told with its number.

use crate::reads::{TEXT_22, try_parse};

/// The message of a text that is refused, printed, with all these parts in it.
fn says(text: &str, parts: &[&str]) {
    let message = try_parse(text).expect_err("refused").to_string();
    println!("{message}");
    for part in parts.iter().chain(&["square.msh"]) {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

fn changed(from: &str, to: &str) -> String {
    assert!(TEXT_22.contains(from), "{from:?}");
    TEXT_22.replace(from, to)
}

#[test]
fn syntax_is_told_with_its_line() {
    says(&changed("2.2 0 8", "3 0 8"), &["line 2", "format 3", "4.1"]);
    says("nothing", &["no $MeshFormat"]);
    says(
        &TEXT_22[TEXT_22.find("$Nodes").unwrap()..],
        &["no $MeshFormat"],
    );
    says(&changed("3 1 1 0", "3 1 x 0"), &["line 13", "\"x\""]);
    says(
        &changed("3 1 1 0", "3 nan 1 0"),
        &["line 13", "node 3", "not finite"],
    );
    says(
        &changed("3 1 1 0", "2 1 1 0"),
        &["line 13", "node 2", "twice"],
    );
    says(
        &changed("$Nodes\n4", "$Nodes\n5"),
        &["line 15", "$EndNodes"],
    );
    says(
        &changed("$Nodes\n4", "$Nodes\n3"),
        &["line 14", "$EndNodes", "\"4\""],
    );
    says(
        &changed("$Nodes\n4", "$Nodes\n400000000000"),
        &["announced", "bytes are left"],
    );
    says(
        &changed("5 2 2 0 9 1 2 3", "5 2 2 0 9 1 2 8"),
        &["element 5", "node 8"],
    );
    says(&changed("5 2 2 0", "5 77 2 0"), &["element type 77"]);
    says(
        TEXT_22.split("$EndElements").next().unwrap(),
        &["$EndElements"],
    );
    says(&changed("2.2 0 8", "2.2 1 8"), &["line 3", "number 1"]);
    for length in (0..TEXT_22.len()).step_by(7) {
        assert!(try_parse(&TEXT_22[..length]).is_err() || length + 14 > TEXT_22.len());
    }
}

#[test]
fn every_fault_of_a_mesh_is_told_with_the_number_of_its_element() {
    says(
        TEXT_22.split("$Elements").next().unwrap(),
        &["no triangles"],
    );
    says(&changed("4 0 1 0", "4 0.5 0.5 0"), &["element 6", "flat"]);
    says(&changed("3 1 1 0", "3 1 1 0.1"), &["node 3", "plane"]);
    says(
        &changed("4 1 2 2 4 4 1\n", "4 1 2 2 4 1 3\n"),
        &["curve 4", "rest of it", "inside"],
    );
    says(
        &changed("4 1 2 2 4 4 1\n", "4 15 2 2 4 4\n"),
        &["element 6", "[0.0, 1.0]", "no condition"],
    );
    says(
        &changed("6 2 2 0 9 1 3 4", "6 2 2 0 9 2 3 1"),
        &["elements 5 and 6", "same nodes"],
    );
    says(
        &changed("4 0 1 0", "4 2 0.5 0"),
        &["elements 5 and 6", "same side", "[1, 3]"],
    );
    let three = changed("$Elements\n6", "$Elements\n7").replace("$Nodes\n4", "$Nodes\n5\n5 2 0 0");
    let three = three.replace("$EndElements", "7 2 2 0 9 1 3 5\n$EndElements");
    says(&three, &["[5, 6, 7]", "at most 2"]);
    let twice =
        changed("$Nodes\n4", "$Nodes\n5\n5 1 1 0").replace("6 2 2 0 9 1 3 4", "6 2 2 0 9 1 5 4");
    says(&twice, &["nodes 3 and 5", "merge"]);
    says(
        &changed("5 2 2 0 9 1 2 3", "5 4 2 0 9 1 2 3 4"),
        &["element 5", "plane"],
    );
    let off = changed("$Nodes\n4", "$Nodes\n6\n5 2 0 0\n6 3 0 0");
    says(
        &off.replace("1 1 2 1 1 1 2", "1 1 2 1 1 5 6"),
        &["no condition", "element 5"],
    );
}

#[test]
fn a_node_that_hangs_is_told() {
    // The side from 2 to 3 of the square is one side below and two above.
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 2 0 0\n3 1 0 0\n4 1 1 0\n5 1 -1 0\n$EndNodes\n\
        $Elements\n7\n1 1 2 1 1 2 4\n2 1 2 1 1 4 1\n3 1 2 1 1 1 5\n4 1 2 1 1 5 2\n5 2 2 0 9 1 3 4\n6 2 2 0 9 3 2 4\n\
        7 2 2 0 9 1 5 2\n$EndElements\n";
    says(text, &["node 3 hangs", "element 7", "nodes 1 and 2"]);
}

#[test]
fn several_surfaces_are_told_with_what_lies_between() {
    let two = changed("6 2 2 0 9 1 3 4", "6 2 2 0 10 1 3 4");
    says(
        &two,
        &[
            "several surfaces",
            "\"9\"",
            "\"10\"",
            "surfaces = ",
            "does not have",
        ],
    );
}
