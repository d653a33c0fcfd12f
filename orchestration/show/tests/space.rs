//! Runs in space: their pictures, and their page as far as no browser is needed.

mod ring;

use std::path::{Path, PathBuf};

use ring::Ring;
use run::disk::{Disk, PATIENCE};
use show::{page, picture::pictures};

/// Pictures of so many states after the first, and the wall time of one \[s\].
fn draw(ring: &Ring, name: &str, folder: &Path, last: usize) -> f64 {
    let (scene, started, states) = ring.run(name, last);
    std::fs::create_dir_all(folder.join("frames")).expect("a folder");
    let (mut drawing, disk) = (pictures(&scene, folder), Disk::new(PATIENCE));
    drawing.take(&started, &disk).expect("taken");
    let begun = std::time::Instant::now();
    for state in &states {
        drawing.take(state, &disk).expect("drawn");
    }
    let wall = begun.elapsed().as_secs_f64() / states.len() as f64;
    drawing.finish(&disk).expect("finished");
    wall
}

/// Kept when SILLAGE_PICTURES names a folder, to be looked at.
fn place(name: &str) -> (Option<tempfile::TempDir>, PathBuf) {
    match std::env::var_os("SILLAGE_PICTURES") {
        Some(folder) => (None, PathBuf::from(folder).join(name)),
        None => {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join(name);
            (Some(folder), path)
        }
    }
}

/// Width and pixels of a picture.
fn pixels(path: &Path) -> (usize, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut bytes).expect("pixels");
    let width = reader.info().width as usize;
    (
        width,
        bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(),
    )
}

/// Orange: more red than blue by far, as grains over a fluid are in light and shade.
fn is_grain(pixel: &[u8; 3]) -> bool {
    i32::from(pixel[0]) - i32::from(pixel[2]) > 60
}

#[test]
fn a_ring_of_grains_is_drawn_with_the_fluid_and_without() {
    println!("| scene | grains | wall time of a frame [s] | orange pixels |");
    for (name, fluid, box_high) in [
        ("falling-ring", true, [20e-3, 40e-3, 20e-3]),
        ("tall-box", true, [20e-3, 100e-3, 20e-3]),
        ("dry-ring", false, [20e-3, 40e-3, 20e-3]),
    ] {
        let ring = Ring {
            box_low: box_high.map(|x| -x),
            box_high,
            count: 5000,
            radius: 0.25e-3,
            cells: [24, if name == "tall-box" { 100 } else { 48 }, 24],
            fluid,
        };
        let (_kept, path) = place(name);
        let wall = draw(&ring, name, &path, 1);
        let (width, picture) = pixels(&path.join("frames/0001.png"));
        let orange = picture.iter().filter(|pixel| is_grain(pixel)).count();
        println!(
            "| {name} | {} | {wall:.3} | {orange} of {} × {} |",
            ring.count,
            width,
            picture.len() / width
        );
        assert!(path.join("overview.png").exists());
        if fluid {
            assert!(orange > 2000);
        }
    }
}

#[test]
fn the_same_states_give_the_same_pictures() {
    let ring = Ring {
        box_low: [-10e-3; 3],
        box_high: [10e-3; 3],
        count: 500,
        radius: 0.4e-3,
        cells: [6; 3],
        fluid: true,
    };
    let folders = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    for folder in &folders {
        draw(&ring, "ring", folder.path(), 1);
    }
    for file in ["frames/0001.png", "overview.png"] {
        let [a, b] = folders
            .each_ref()
            .map(|folder| std::fs::read(folder.path().join(file)).expect("a file"));
        assert!(a == b, "{file} differs");
    }
}

#[test]
#[ignore = "depends on what else the machine does"]
fn twenty_thousand_spheres_take_well_under_a_second() {
    let ring = Ring {
        box_low: [-20e-3, -40e-3, -20e-3],
        box_high: [20e-3, 40e-3, 20e-3],
        count: 20_000,
        radius: 0.15e-3,
        cells: [32, 64, 32],
        fluid: true,
    };
    let (_kept, path) = place("many");
    let wall = draw(&ring, "many", &path, 3);
    println!("{} grains, {wall:.3} s a frame", ring.count);
    assert!(wall < 1.0);
}

#[test]
fn the_page_of_a_run_in_space_has_a_plane_of_the_fluid_and_all_that_it_needs() {
    for fluid in [true, false] {
        let ring = Ring {
            box_low: [-10e-3, -20e-3, -10e-3],
            box_high: [10e-3, 20e-3, 10e-3],
            count: 300,
            radius: 0.4e-3,
            cells: [6, 12, 6],
            fluid,
        };
        let (_kept, path) = place(if fluid { "page-fluid" } else { "page-dry" });
        ring.write("falling-ring", &path, 4);
        let written = page::write(&path, None, 100).expect("a page");
        let page = std::fs::read_to_string(&written.file).expect("a page");
        println!(
            "fluid {fluid}: {} states, {} bytes",
            written.states,
            page.len()
        );
        assert_eq!(written.states, 5);
        let data = page.split_once("id=\"data\">").expect("data").1;
        let data = data.split_once("</script>").expect("data").0;
        let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
        assert_eq!(data["dimension"], 3);
        assert_eq!(
            data["stage"]["window"][1],
            serde_json::json!([10e-3, 20e-3, 10e-3])
        );
        let fields = data["frames"][0]["fields"].as_object().expect("fields");
        let names: Vec<&str> = fields.keys().map(String::as_str).collect();
        match fluid {
            true => assert_eq!(names, ["speed", "vorticity"]),
            false => assert!(names.is_empty() && data["stage"]["mesh"].is_null()),
        }
    }
}
