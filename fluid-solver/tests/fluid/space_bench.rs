//! Systems in space to try solvers on: a cloud or a held bed in a box, on meshes with coarser ones under them.

use std::path::Path;

use fluid_solver::boundary::{Condition, Constraints};
use fluid_solver::cost::cpu_seconds;
use fluid_solver::equations::assembly::Assembly;
use fluid_solver::equations::{Carrier, Coefficients, ViscousForm, coarse};
use fluid_solver::linear::hierarchy::{Conditions, Hierarchy};
use fluid_solver::linear::iterative::{Iterative, Starts};
use fluid_solver::linear::{LinearSolver, Solution, System};
use fluid_solver::mesh::{Bisection, Forest, LongestEdge, Mesh, Place, Root, Sizes, Zone, nested};
use fluid_solver::solid::{Solid, SolidFields};
use fluid_solver::state::Flow;
use space::{Vector, hypot};

use crate::support::{Random, turned, write_system};

const SIMPLICES_MAX: usize = 4_000_000;
/// Radius of the cloud, viscosity and force of its weight are 1: ρ is the Galileo number.
const SOLID: f64 = 0.2;

/// What is in the ball, and how it flows.
#[derive(Clone, Copy)]
pub struct Case {
    pub galileo: f64,
    pub dt: f64,
    pub convects: bool,
    pub grains: Grains,
}

#[derive(Clone, Copy)]
pub enum Grains {
    /// Free, with this ratio of time step and response time.
    Free(f64),
    /// Held, with this drag, random by half of it.
    Held(f64),
}

/// A mesh with all that its systems are solved with.
pub struct Bench {
    mesh: Mesh<3, 4>,
    constraints: Constraints<3>,
    system: System<4>,
    iterative: Iterative<4>,
    centre: Vector<3>,
    pub levels: Vec<usize>,
}

/// CPU time of set-up and solve \[s\], and what was found.
pub struct Found {
    pub setup: f64,
    pub solve: f64,
    pub solution: Solution,
}

impl Bench {
    /// On cells of these sizes with conditions one a boundary.
    fn new<F>(root: &F, sizes: &Sizes<3>, conditions: Vec<Condition<3>>, centre: Vector<3>) -> Bench
    where
        F: Forest<3, 4> + Clone,
    {
        let (bisection, mesh) = Bisection::<_, 3, 4>::new(root, sizes, SIMPLICES_MAX).unwrap();
        let nodes = mesh.node_count();
        let coarser = nested::coarser(&bisection, sizes, nodes, SIMPLICES_MAX).unwrap();
        let held = |mesh: &Mesh<3, 4>| {
            Constraints::new(mesh, conditions.clone(), 1.0, &Vector::zeros()).unwrap()
        };
        let constraints = held(&mesh);
        let held: Vec<_> = coarser.iter().map(|level| held(&level.mesh)).collect();
        let below: Vec<_> = coarser
            .iter()
            .zip(&held)
            .map(|(level, constraints)| {
                let mesh = &level.mesh;
                (Conditions { mesh, constraints }, level.spots.as_slice())
            })
            .collect();
        let system = System::new(nodes, &mesh.simplices);
        let finest = Conditions {
            mesh: &mesh,
            constraints: &constraints,
        };
        let hierarchy = Hierarchy::new(&system.pattern, &finest, &below);
        let (fixed, floating) = (constraints.fixed.clone(), constraints.floating());
        let iterative = Iterative::new(hierarchy, fixed, floating);
        let levels = coarser.iter().map(|level| level.mesh.node_count());
        Bench {
            levels: std::iter::once(nodes).chain(levels).collect(),
            mesh,
            constraints,
            system,
            iterative,
            centre,
        }
    }

    /// Cells of 1/`finest` around a ball in a box of 16 x 16 x 32 without slip.
    pub fn graded(finest: f64, slope: f64, largest: f64) -> Bench {
        let root = brief();
        let middle = Vector::from([8.0, 8.0, 24.0]);
        let place = Place::Ball {
            centre: middle,
            radius: 1.5,
        };
        let size = 1.0 / finest;
        let sizes = Sizes::new(vec![Zone { place, size }], slope, largest, root.period());
        Bench::new(&root, &sizes, vec![Condition::NoSlip; 6], middle)
    }

    /// Cells of one size in a box of 5 x 5 x 10.
    pub fn uniform(cells: usize, periodic: [bool; 3], conditions: Vec<Condition<3>>) -> Bench {
        let root = Root {
            lower: Vector::zeros(),
            upper: Vector::from([5.0, 5.0, 10.0]),
            cells: [cells, cells, 2 * cells],
            periodic,
        };
        let sizes = Sizes::new(vec![], 0.0, f64::INFINITY, root.period());
        Bench::new(&root, &sizes, conditions, Vector::from([2.5, 2.5, 6.0]))
    }

    /// A box of 6 x 6 x 6 that is turned, refined from a mesh: slip walls follow no axis.
    pub fn turned() -> Bench {
        let root = Root {
            lower: Vector::repeat(-3.0),
            upper: Vector::repeat(3.0),
            cells: [4; 3],
            periodic: [false; 3],
        };
        let any = Sizes::new(vec![], 0.0, f64::INFINITY, root.period());
        let (_, straight) = Bisection::<_, 3, 4>::new(&root, &any, SIMPLICES_MAX).unwrap();
        let mesh = turned(&straight);
        let centre = Vector::zeros();
        let place = Place::Ball {
            centre,
            radius: 1.2,
        };
        let sizes = Sizes::new(vec![Zone { place, size: 0.3 }], 0.35, 1.5, [None; 3]);
        let root = LongestEdge::new(&mesh).unwrap();
        let mut conditions = vec![Condition::Slip; 6];
        conditions[3] = Condition::Open(2.0);
        Bench::new(&root, &sizes, conditions, centre)
    }

    /// Assemble the system of a case.
    fn assemble(&mut self, case: &Case) -> Vec<Vec<f64>> {
        let solid = self.solid(case);
        let flow = self.flow(&solid.matrix.porosity);
        let carriers = [Carrier {
            flow: &flow,
            convects: f64::from(u8::from(case.convects)),
            history: 1.0 / case.dt,
        }];
        let terms = Coefficients {
            density: case.galileo,
            dynamic_viscosity: 1.0,
            gravity: Vector::from([0.0, 0.0, -1.0 / (SOLID * case.galileo)]),
            viscous_form: ViscousForm::Symmetric,
            grad_div: 1.0,
            rate: 1.0 / case.dt,
            newton: false,
            body_force: None,
            time: 0.0,
            carriers: &carriers,
            solid: &solid,
        };
        let assembly = Assembly {
            terms: &terms,
            mesh: &self.mesh,
            constraints: &self.constraints,
            flux: &vec![0.0; self.mesh.node_count()],
        };
        assembly.fill(&mut self.system, true);
        coarse::missing(&terms, &self.mesh, self.iterative.hierarchy())
    }

    fn solid(&self, case: &Case) -> Solid<3> {
        let mut random = Random(5);
        let nodes = self.mesh.position.iter();
        let inside: Vec<(bool, f64)> = nodes
            .map(|x| (hypot(&(x - self.centre)) < 1.0, random.unit()))
            .collect();
        let each = |solid: &dyn Fn(f64) -> f64, clear: f64| -> Vec<f64> {
            let values = inside.iter();
            values
                .map(|&(inside, share)| if inside { solid(share) } else { clear })
                .collect()
        };
        let grain_density = 2.0 * case.galileo;
        let (drag, entrained, mobility) = match case.grains {
            Grains::Held(drag) => (each(&|share| drag * (0.5 + share), 0.0), 0.0, 0.0),
            Grains::Free(stiff) => {
                let follows = stiff / (1.0 + stiff);
                let drag = grain_density * SOLID / case.dt * follows;
                let mobility = SOLID * case.dt / (grain_density * (1.0 + stiff));
                (each(&|_| drag, 0.0), SOLID * follows, mobility)
            }
        };
        let porosity = each(&|share| 1.0 - SOLID * (0.75 + 0.5 * share), 1.0);
        let source: Vec<[f64; 3]> = each(&|_| -1.0, 0.0)
            .iter()
            .map(|&s| [0.0, 0.0, s])
            .collect();
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            drag_source: Some(source.as_flattened()),
            entrained_fraction: Some(&each(&|_| entrained, 0.0)),
            solid_mobility: Some(&each(&|_| mobility, 0.0)),
            ..SolidFields::default()
        };
        Solid::new(&fields, &self.mesh).unwrap()
    }

    /// About the flow around a falling ball.
    fn flow(&self, porosity: &[f64]) -> Flow<3> {
        let at = |(node, x): (usize, &Vector<3>)| {
            let x = x - self.centre;
            let distance = hypot(&x);
            if self.constraints.fixed[4 * node] {
                return Vector::zeros();
            }
            let fall = if distance < 1.0 {
                SPEED * (1.0 - 0.4 * distance * distance)
            } else {
                0.156 / distance
            };
            let across = if distance < 3.0 {
                0.05 * x[2] * x[0] / (1.0 + distance * distance)
            } else {
                0.0
            };
            Vector::from([across, 0.0, -fall])
        };
        Flow {
            superficial_velocity: self.mesh.position.iter().enumerate().map(at).collect(),
            porosity: porosity.to_vec(),
        }
    }

    fn given(&self) -> Vec<f64> {
        self.constraints.values(&self.mesh, 0.0)
    }

    /// Nothing to begin with but fluid at rest.
    fn rest(&self) -> Starts {
        let position = self.mesh.position.iter();
        let unknowns = position.map(|x| [0.0, 0.0, 0.0, -x[2] / SOLID]);
        let rest = unknowns.flatten().collect();
        Starts {
            last: self.given(),
            rest,
        }
    }

    pub fn solve(&mut self, case: &Case) -> Found {
        let missing = self.assemble(case);
        let begin = cpu_seconds();
        self.iterative.factorise(&self.system, &missing);
        let setup = cpu_seconds() - begin;
        let begin = cpu_seconds();
        let given = self.given();
        let starts = self.rest();
        let solution = self.iterative.solve(&self.system, &given, Some(&starts));
        let solution = solution.unwrap();
        let solve = cpu_seconds() - begin;
        Found {
            setup,
            solve,
            solution,
        }
    }

    /// The same by a direct factor of the system assembled last.
    pub fn directly(&self) -> Vec<f64> {
        let fixed = self.constraints.fixed.clone();
        let mut direct = LinearSolver::new(&self.system.pattern, fixed).unwrap();
        direct.factorise(&self.system);
        direct
            .solve(&self.system, &self.given(), None)
            .unwrap()
            .unknowns
    }

    /// Write the system assembled last, and its solution.
    pub fn write(&self, solution: &Solution, file: &Path) {
        let (fixed, given) = (&self.constraints.fixed, self.given());
        write_system(&self.system, fixed, &given, &solution.unknowns, file);
    }

    /// Memory of the preconditioner \[bytes a node\].
    pub fn bytes(&self) -> f64 {
        self.iterative.bytes() as f64 / self.mesh.node_count() as f64
    }
}

/// The root of a box of 16 x 16 x 32.
fn brief() -> Root<3> {
    Root {
        lower: Vector::zeros(),
        upper: Vector::from([16.0, 16.0, 32.0]),
        cells: [6, 6, 12],
        periodic: [false; 3],
    }
}

pub fn cloud(galileo: f64, dt: f64) -> Case {
    Case {
        galileo,
        dt,
        convects: false,
        grains: Grains::Free(1e5),
    }
}

/// Largest speed of the flow that a step begins with.
const SPEED: f64 = 0.26;

/// Largest difference of velocities and of pressures, relative to the largest of each; a velocity that hardly is one
/// counts as [`SPEED`].
pub fn apart(a: &[f64], b: &[f64]) -> [f64; 2] {
    let of = |pressure: bool| {
        let pairs = a.iter().zip(b).enumerate();
        let pairs = pairs.filter(|(k, _)| (k % 4 == 3) == pressure);
        let (mut apart, mut size) = (0.0_f64, if pressure { 0.0 } else { SPEED });
        for (_, (a, b)) in pairs {
            apart = apart.max((a - b).abs());
            size = size.max(b.abs());
        }
        apart / size
    };
    [of(false), of(true)]
}
