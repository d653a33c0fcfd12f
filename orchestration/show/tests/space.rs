//! Runs in space from synthetic messages: a vortex ring that falls with the grains in it.

use std::path::{Path, PathBuf};

use protocol::field::Field;
use protocol::message::ToOrchestrator;
use protocol::monitor::Event;
use protocol::scene::Wall;
use run::disk::{Disk, PATIENCE};
use scene::Scene;
use show::picture::pictures;

type Point = [f64; 3];
type Fields = Vec<(Field, Vec<f64>)>;

/// A scene whose pictures are of space; what else it says is not looked at.
fn scene(name: &str, grains: usize, walls: Vec<Wall>) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/dry-collapse.toml");
    let mut scene = scene::load(&path, &[], 1).unwrap_or_else(|error| panic!("{error}"));
    scene.name = name.to_string();
    scene.coupler.gravity = vec![0.0, -9.81, 0.0];
    scene.coupler.particles.as_mut().expect("grains").walls = walls;
    scene.grains.fixed = vec![false; grains];
    scene.output.frames = true;
    scene
}

/// A box of cells, each cut into six tetrahedra, as a fluid engine describes it.
fn mesh(low: Point, high: Point, count: [usize; 3]) -> Fields {
    let mut position = Vec::new();
    for k in 0..=count[2] {
        for j in 0..=count[1] {
            for i in 0..=count[0] {
                let share = [i, j, k].map(|index| index as f64);
                let at = |d: usize| low[d] + (high[d] - low[d]) * share[d] / count[d] as f64;
                position.extend([at(0), at(1), at(2)]);
            }
        }
    }
    let node = |at: [usize; 3]| (at[2] * (count[1] + 1) + at[1]) * (count[0] + 1) + at[0];
    let mut nodes = Vec::new();
    for cell in 0..count.iter().product() {
        let start = [
            cell % count[0],
            cell / count[0] % count[1],
            cell / count[0] / count[1],
        ];
        for way in [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [1, 0, 2],
            [0, 2, 1],
            [2, 1, 0],
        ] {
            let mut corner = start;
            nodes.push(node(corner));
            for axis in way {
                corner[axis] += 1;
                nodes.push(node(corner));
            }
        }
    }
    let places = nodes
        .iter()
        .flat_map(|&node| position[3 * node..3 * node + 3].to_vec());
    let places = places.collect();
    let nodes = nodes.iter().map(|&node| node as f64).collect();
    vec![
        (Field::NodePosition, position),
        (Field::SimplexNodes, nodes),
        (Field::SimplexPosition, places),
    ]
}

/// The sides of a box but its lid, two triangles each.
fn walls(low: Point, high: Point) -> Vec<Wall> {
    let corner = |place: usize| -> Vec<f64> {
        let side = |axis: usize| [low, high][place >> axis & 1][axis];
        vec![side(0), side(1), side(2)]
    };
    let sides = [
        [0, 1, 5, 4],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let wall = |half: [usize; 3]| Wall {
        corners: half.map(corner).to_vec(),
        velocity: None,
    };
    halves.map(wall).collect()
}

/// Numbers between 0 and 1 that look random.
fn scattered(index: usize) -> Point {
    [1_u64, 2, 3].map(|stream| {
        let mut word = (index as u64).wrapping_mul(3).wrapping_add(stream);
        for _ in 0..2 {
            word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        }
        (word >> 11) as f64 / (1_u64 << 53) as f64
    })
}

/// Grains of a torus about the y axis, major and minor radius given \[m\].
fn torus(count: usize, middle: Point, major: f64, minor: f64) -> Vec<Point> {
    let place = |index: usize| {
        let [a, b, c] = scattered(index + 1);
        let (around, about) = (a * std::f64::consts::TAU, b * std::f64::consts::TAU);
        let out = major + minor * c.sqrt() * about.cos();
        [
            middle[0] + out * around.cos(),
            middle[1] + minor * c.sqrt() * about.sin(),
            middle[2] + out * around.sin(),
        ]
    };
    (0..count).map(place).collect()
}

/// Velocity of a falling vortex ring about a middle \[m/s\].
fn ring(at: &[f64], middle: Point, radius: f64, speed: f64) -> Point {
    let away = [at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]].map(|x| x / radius);
    let square = away.iter().map(|x| x * x).sum::<f64>();
    let decay = speed * (-0.5 * square).exp();
    let out = away[0] * away[0] + away[2] * away[2];
    [
        decay * away[0] * away[1],
        -decay * (1.0 - out),
        decay * away[2] * away[1],
    ]
}

/// A falling ring in a tall box: how it is made and what it has come to.
struct Ring {
    box_low: Point,
    box_high: Point,
    count: usize,
    radius: f64,
    cells: [usize; 3],
    fluid: bool,
}

impl Ring {
    fn state(&self, mesh: &Fields, number: usize, last: usize) -> Event {
        let share = number as f64 / last as f64;
        let width = self.box_high[0] - self.box_low[0];
        let height = self.box_high[1] - self.box_low[1];
        let middle = [0.0, self.box_high[1] - (0.2 + 0.6 * share) * height, 0.0];
        let (major, minor) = (
            width * (0.09 + 0.09 * share),
            width * (0.075 - 0.04 * share),
        );
        let position = torus(self.count, middle, major, minor);
        let speed = 0.05 * (0.2 + share);
        let moving = position
            .iter()
            .flat_map(|at| ring(at, middle, major, speed));
        let mut fields = vec![(Field::GrainVelocity, moving.collect())];
        if self.fluid {
            let nodes = mesh[0].1.chunks_exact(3);
            let velocity = nodes.flat_map(|at| ring(at, middle, major, speed));
            fields.push((Field::InterstitialVelocity, velocity.collect()));
        }
        fields.push((
            Field::GrainPosition,
            position.into_iter().flatten().collect(),
        ));
        let names = fields.iter().map(|(field, _)| *field).collect();
        let message = ToOrchestrator::Snapshot {
            step: number as u64,
            time: 0.4 * share,
            fields: names,
            grains: 0,
        };
        Event { message, fields }
    }

    /// Pictures of so many states, and the wall time of one \[s\].
    fn draw(&self, name: &str, folder: &Path, last: usize) -> f64 {
        let walls = match self.fluid {
            true => Vec::new(),
            false => walls(self.box_low, self.box_high),
        };
        let scene = scene(name, self.count, walls);
        let mut mesh = match self.fluid {
            true => mesh(self.box_low, self.box_high, self.cells),
            false => Vec::new(),
        };
        let states: Vec<Event> = (0..=last)
            .map(|number| self.state(&mesh, number, last))
            .collect();
        mesh.push((Field::GrainRadius, vec![self.radius; self.count]));
        let message = ToOrchestrator::Started {
            dimension: 3,
            nodes: 0,
            simplices: 0,
            grains: 0,
            engines: Vec::new(),
        };
        std::fs::create_dir_all(folder.join("frames")).expect("a folder");
        let (mut drawing, disk) = (pictures(&scene, folder), Disk::new(PATIENCE));
        let started = Event {
            message,
            fields: mesh,
        };
        drawing.take(&started, &disk).expect("taken");
        let begun = std::time::Instant::now();
        for state in &states {
            drawing.take(state, &disk).expect("drawn");
        }
        let wall = begun.elapsed().as_secs_f64() / states.len() as f64;
        drawing.finish(&disk).expect("finished");
        wall
    }
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
        let wall = ring.draw(name, &path, 1);
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
        ring.draw("ring", folder.path(), 1);
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
    let wall = ring.draw("many", &path, 3);
    println!("{} grains, {wall:.3} s a frame", ring.count);
    assert!(wall < 1.0);
}
