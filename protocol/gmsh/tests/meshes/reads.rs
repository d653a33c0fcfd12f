//! Every form in which Gmsh writes a mesh gives the same mesh.

use std::path::{Path, PathBuf};

use gmsh::{File, Mesh, Options, survey};
use space::simplex::determinant;

pub type Plane = Mesh<2, 3>;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files")
        .join(name)
}

fn read(name: &str) -> Plane {
    read_with(name, &Options::default())
}

fn read_with(name: &str, options: &Options) -> Plane {
    let mesh = Mesh::read(&file(name), options).unwrap_or_else(|error| panic!("{error}"));
    println!(
        "{name}: {} simplices; {:?}",
        mesh.simplices.len(),
        mesh.notes
    );
    mesh
}

fn area(mesh: &Plane) -> f64 {
    let corners = mesh.simplices.iter().map(|t| t.map(|n| mesh.position[n]));
    corners.map(|corners| 0.5 * determinant(&corners)).sum()
}

/// Name and length of each border.
fn borders(mesh: &Plane) -> Vec<(String, f64)> {
    let length = |&[a, b]: &[usize; 2]| (mesh.position[a] - mesh.position[b]).norm();
    let borders = mesh.borders.iter();
    borders
        .map(|border| {
            (
                border.labels.join("+"),
                border.facets.iter().map(length).sum(),
            )
        })
        .collect()
}

#[test]
fn both_formats_in_text_and_in_bytes_give_the_same_mesh() {
    let one = read("channel-4.1-ascii.msh");
    let names: Vec<String> = borders(&one).into_iter().map(|border| border.0).collect();
    assert_eq!(names, ["inlet", "outlet", "the disk", "walls"]);
    for name in [
        "channel-4.1-binary.msh",
        "channel-2.2-ascii.msh",
        "channel-2.2-binary.msh",
    ] {
        let other = read(name);
        assert_eq!(one.simplices, other.simplices);
        let pairs = one.position.iter().zip(&other.position);
        let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(apart < 1e-15, "{name}: {apart:e}");
        let facets = |mesh: &Plane| -> Vec<_> {
            mesh.borders
                .iter()
                .map(|b| (b.labels.clone(), b.facets.clone()))
                .collect()
        };
        assert_eq!(facets(&one), facets(&other));
    }
}

/// Bytes of a binary file of format 4.1 in the other order.
#[test]
fn bytes_in_the_other_order_are_turned() {
    let mut bytes = b"$MeshFormat\n4.1 1 8\n".to_vec();
    let int = |values: &[i32]| -> Vec<u8> {
        let turned = values.iter().map(|value| value.swap_bytes().to_ne_bytes());
        turned.flatten().collect()
    };
    let size = |values: &[u64]| -> Vec<u8> {
        let turned = values.iter().map(|value| value.swap_bytes().to_ne_bytes());
        turned.flatten().collect()
    };
    bytes.extend(int(&[1]));
    bytes.extend(b"\n$EndMeshFormat\n$Nodes\n");
    bytes.extend([size(&[1, 3, 1, 3]), int(&[2, 1, 0]), size(&[3, 1, 2, 3])].concat());
    for x in [0.0_f64, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(size(&[x.to_bits()]));
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n");
    bytes.extend([size(&[2, 4, 1, 4]), int(&[1, 8, 1])].concat());
    bytes.extend(size(&[3, 1, 1, 2, 2, 2, 3, 3, 3, 1]));
    bytes.extend([int(&[2, 1, 2]), size(&[1, 4, 1, 2, 3])].concat());
    bytes.extend(b"\n$EndElements\n");
    let file = File::parse(Path::new("swapped.msh"), &bytes).unwrap_or_else(|e| panic!("{e}"));
    let mesh: Plane = Mesh::of(&file, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((mesh.simplices, mesh.borders.len()), (vec![[0, 1, 2]], 1));
}

#[test]
fn partitions_leave_no_trace() {
    let whole = read("channel-4.1-ascii.msh");
    for name in ["channel-partitioned.msh", "channel-partitioned-2.2.msh"] {
        let parts = read(name);
        assert_eq!(parts.simplices.len(), whole.simplices.len());
        assert!((area(&parts) - area(&whole)).abs() < 1e-14);
        for (one, other) in borders(&parts).iter().zip(borders(&whole)) {
            assert_eq!(one.0, other.0);
            assert!((one.1 - other.1).abs() < 1e-12);
        }
    }
}

#[test]
fn quadrilaterals_are_cut_curved_and_turned_elements_are_taken_by_their_corners() {
    for name in ["quads.msh", "quads-second-order.msh"] {
        let mesh = read(name);
        assert_eq!(mesh.simplices.len(), 24);
        assert!((area(&mesh) - 12.0).abs() < 1e-14);
        assert_eq!(mesh.position.len(), 20);
        let expected = [("12".to_owned(), 10.0), ("floor".to_owned(), 4.0)];
        assert_eq!(borders(&mesh), expected);
        assert!(mesh.notes.iter().any(|note| note.contains("clockwise")));
    }
    let (straight, curved) = (
        read("channel-4.1-ascii.msh"),
        read("channel-second-order.msh"),
    );
    assert_eq!(straight.simplices.len(), curved.simplices.len());
    assert!(curved.notes.iter().any(|note| note.contains("curved")));
}

#[test]
fn a_cell_that_is_not_convex_is_cut_inside() {
    let text = TEXT_22
        .replace("4 0 1 0", "4 0.2 0.2 0")
        .replace("5 2 2 0 9 1 2 3\n6 2 2 0 9 1 3 4", "5 3 2 0 9 1 2 3 4")
        .replace("$Elements\n6", "$Elements\n5");
    let mesh = parse(&text);
    assert_eq!(mesh.simplices.len(), 2);
    assert!(
        mesh.simplices
            .iter()
            .all(|nodes| nodes.contains(&1) && nodes.contains(&3))
    );
}

#[test]
fn groups_without_a_name_and_curves_without_a_group_have_their_number() {
    let bare = read("bare.msh");
    let names: Vec<String> = borders(&bare).into_iter().map(|border| border.0).collect();
    assert_eq!(names, ["1", "2", "3", "4"]);
}

#[test]
fn a_curve_in_two_groups_tells_both_and_takes_the_one_with_a_condition() {
    for name in ["channel-overlap.msh", "channel-overlap-2.2.msh"] {
        let mesh = read(name);
        let names: Vec<String> = borders(&mesh).into_iter().map(|border| border.0).collect();
        assert_eq!(
            names,
            ["inlet+left", "left+walls", "outlet", "the disk", "walls"]
        );
        let both = &mesh.borders[0];
        assert_eq!(both.name(|_| true), "inlet");
        assert_eq!(both.name(|name| name == "left"), "left");
        assert_eq!(both.name(|_| false), "inlet");
        assert_eq!(both.entities.len(), 1);
    }
}

#[test]
fn surfaces_that_the_scene_names_are_filled() {
    let with = |surfaces: &[&str]| Options {
        surfaces: surfaces.iter().map(|name| name.to_string()).collect(),
        ..Options::default()
    };
    for name in ["two.msh", "two-2.2.msh"] {
        let both = read_with(name, &with(&["water", "oil"]));
        assert!((area(&both) - 2.0).abs() < 1e-14);
        assert_eq!(borders(&both)[0].0, "walls");
    }
    let error = Plane::read(&file("two.msh"), &with(&["water"])).expect_err("an open side");
    println!("{error}");
    let error = Plane::read(&file("two.msh"), &with(&["milk"])).expect_err("no such surface");
    println!("{error}");
    assert!(error.to_string().contains("\"milk\"") && error.to_string().contains("\"oil\""));
}

#[test]
fn units_are_scaled() {
    let options = Options {
        scale: 1e-3,
        ..Options::default()
    };
    let mesh = read_with("quads.msh", &options);
    assert!((area(&mesh) - 12e-6).abs() < 1e-18);
}

pub const TEXT_22: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"floor\"\n\
    1 2 \"rest of it\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
    $Elements\n6\n1 1 2 1 1 1 2\n2 1 2 2 2 2 3\n3 1 2 2 3 3 4\n4 1 2 2 4 4 1\n5 2 2 0 9 1 2 3\n\
    6 2 2 0 9 1 3 4\n$EndElements\n";

pub fn parse(text: &str) -> Plane {
    try_parse(text).unwrap_or_else(|error| panic!("{error}"))
}

pub fn try_parse(text: &str) -> Result<Plane, gmsh::Error> {
    let file = File::parse(Path::new("square.msh"), text.as_bytes())?;
    Mesh::of(&file, &Options::default())
}

#[test]
fn line_ends_and_heights_of_the_real_world_are_read() {
    let plain = parse(TEXT_22);
    assert_eq!(plain.borders[1].labels, ["rest of it"]);
    assert_eq!(parse(&TEXT_22.replace('\n', "\r\n")), plain);
    assert_eq!(parse(&TEXT_22.replace("3 1 1 0", "3 1 1 -1e-17")), plain);
    let unused = TEXT_22.replace("$Nodes\n4\n", "$Nodes\n5\n17 9 9 0\n");
    assert_eq!(parse(&unused).simplices, plain.simplices);
    let clockwise = TEXT_22.replace("5 2 2 0 9 1 2 3", "5 2 2 0 9 1 3 2");
    assert_eq!(parse(&clockwise).simplices, plain.simplices);
    let other = "$Comments\nanything $here\n$EndComments\n".to_owned() + TEXT_22;
    assert_eq!(parse(&other), plain);
}

#[test]
fn a_survey_tells_groups_sizes_and_qualities() {
    let channel = File::read(&file("channel-2.2-binary.msh")).unwrap();
    let groups = survey::groups::<2>(&channel);
    let fluid = &groups[0];
    assert_eq!((fluid.dimension, fluid.labels[0].as_str()), (2, "fluid"));
    let mesh = read("channel-2.2-binary.msh");
    assert!((fluid.size - area(&mesh)).abs() < 1e-12);
    let quality = survey::quality(&mesh);
    println!("{quality:?}");
    assert!(quality.least > 0.5 && quality.mean > quality.least && quality.mean < 1.0);
    assert!(quality.aspect > 1.0 && quality.aspect < 5.0);
    let square = survey::quality(&parse(TEXT_22));
    assert!((square.aspect - 2.0).abs() < 1e-14);
}

/// Volume of the tetrahedra, and the area of each border.
fn in_space(name: &str) -> (Mesh<3, 4>, f64, Vec<(String, f64)>) {
    let mesh = Mesh::<3, 4>::read(&file(name), &Options::default());
    let mesh = mesh.unwrap_or_else(|error| panic!("{error}"));
    println!(
        "{name}: {} simplices; {:?}",
        mesh.simplices.len(),
        mesh.notes
    );
    let corners = mesh.simplices.iter().map(|t| t.map(|n| mesh.position[n]));
    let volumes: Vec<f64> = corners.map(|corners| determinant(&corners) / 6.0).collect();
    assert!(volumes.iter().all(|volume| *volume > 0.0));
    let area = |nodes: &[usize; 3]| {
        let [a, b, c] = nodes.map(|node| mesh.position[node]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    let borders = mesh.borders.iter().map(|border| {
        let size = border.facets.iter().map(area).sum();
        (border.labels.join("+"), size)
    });
    let borders = borders.collect();
    let volume = volumes.iter().sum();
    (mesh, volume, borders)
}

#[test]
fn a_box_of_any_cells_is_a_box_of_tetrahedra_with_its_sides() {
    let of_cells = [
        ("box-tetrahedra.msh", 1),
        ("box-tetrahedra-2.2.msh", 1),
        ("box-second-order.msh", 1),
        ("box-prisms.msh", 3),
        ("box-hexahedra.msh", 6),
    ];
    for (name, parts) in of_cells {
        let (mesh, volume, borders) = in_space(name);
        assert!((volume - 6.0).abs() < 1e-12, "{name}: {volume}");
        assert_eq!(borders.len(), 6, "{borders:?}");
        for (side, size) in &borders {
            let expected = match side.as_str() {
                "floor" | "lid" => 2.0,
                "side at 0 1" | "side at 1 1" => 6.0,
                _ => 3.0,
            };
            assert!((size - expected).abs() < 1e-12, "{name} {side}: {size}");
        }
        if parts == 1 {
            continue;
        }
        // All parts of a cell are there, and its faces are cut alike from both sides: else it would not be read.
        let mut elements = mesh.element.clone();
        elements.dedup();
        assert_eq!(mesh.simplices.len(), parts * elements.len(), "{name}");
        let survey = survey::groups::<3>(&File::read(&file(name)).expect("a file"));
        let filled = survey.iter().find(|group| group.dimension == 3);
        let size = filled.expect("a volume").size;
        assert!((size - 6.0).abs() < 1e-12, "{name}: {size}");
    }
}
