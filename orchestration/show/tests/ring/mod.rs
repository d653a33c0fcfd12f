//! A run in space from synthetic messages: a vortex ring that falls with grains in it.

use std::path::Path;

use protocol::field::Field;
use protocol::message::{Diagnostic, ToOrchestrator};
use protocol::monitor::Event;
use protocol::scene::Wall;
use run::disk::{Disk, PATIENCE};
use run::folder::document::{self, Ending};
use run::folder::run_folder::RunFolder;
use run::folder::writer::Writer;
use scene::Scene;
use show::picture::pictures;

type Point = [f64; 3];
type Fields = Vec<(Field, Vec<f64>)>;

/// A scene whose pictures are of space; what else it says is not looked at.
fn scene(name: &str, walls: Vec<Wall>) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/dry-collapse.toml");
    let mut scene = scene::load(&path, &[], 1).unwrap_or_else(|error| panic!("{error}"));
    scene.name = name.to_string();
    scene.coupler.gravity = vec![0.0, -9.81, 0.0];
    scene.coupler.particles.as_mut().expect("grains").walls = walls;
    scene.grains = Default::default();
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

/// A ring of grains that falls in a box.
pub struct Ring {
    /// Lower corner of the box \[m\].
    pub box_low: Point,
    /// Upper corner of the box \[m\].
    pub box_high: Point,
    /// Number of grains.
    pub count: usize,
    /// Their radius \[m\].
    pub radius: f64,
    /// Cells of the fluid along each axis.
    pub cells: [usize; 3],
    /// Is there one?
    pub fluid: bool,
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

    /// Its scene, the message that opens its run, and so many states after the first.
    pub fn run(&self, name: &str, last: usize) -> (Scene, Event, Vec<Event>) {
        let (walls, mut mesh) = match self.fluid {
            true => (Vec::new(), mesh(self.box_low, self.box_high, self.cells)),
            false => (walls(self.box_low, self.box_high), Vec::new()),
        };
        let states = (0..=last).map(|number| self.state(&mesh, number, last));
        let states = states.collect();
        mesh.push((Field::GrainRadius, vec![self.radius; self.count]));
        let message = ToOrchestrator::Started {
            dimension: 3,
            nodes: 0,
            simplices: 0,
            grains: 0,
            engines: Vec::new(),
        };
        let started = Event {
            message,
            fields: mesh,
        };
        (scene(name, walls), started, states)
    }

    /// The folder of its run, with steps and states but without pictures.
    pub fn write(&self, name: &str, folder: &Path, last: usize) {
        let (mut scene, started, states) = self.run(name, last);
        scene.output.frames = false;
        let writer = Writer::start(
            RunFolder::create(folder, &scene).expect("a folder"),
            pictures(&scene, folder),
            Disk::new(PATIENCE),
        );
        writer.take(started);
        for (number, state) in states.into_iter().enumerate() {
            let values = [
                ("step", number as f64),
                ("time", 0.4 * number as f64 / last as f64),
                ("fall_speed", 0.01 + 1e-3 * number as f64),
            ];
            let value = |(name, value): (&str, f64)| Diagnostic {
                name: name.into(),
                value,
            };
            writer.take(Event {
                message: ToOrchestrator::Step(values.map(value).to_vec()),
                fields: Vec::new(),
            });
            writer.take(state);
        }
        let (written, outcome) = writer.finish(|_| {}).expect("joined");
        outcome.unwrap_or_else(|error| panic!("{error}"));
        let ending = Ending {
            code: 0,
            why: None,
            wall: 1.5,
            cpu: Default::default(),
            memory_peak: Default::default(),
            phases: Default::default(),
        };
        let run = document::document(&scene, &written, Some(&ending));
        document::write(folder, &run).expect("written");
    }
}
