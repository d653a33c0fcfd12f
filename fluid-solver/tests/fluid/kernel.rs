//! The quick assembly against the terms taken one by one, which a body force of zero asks for.

use fluid_solver::boundary::{Condition, Constraints};
use fluid_solver::cost::cpu_seconds;
use fluid_solver::diagnostics::solved::Solved;
use fluid_solver::equations::assembly::Assembly;
use fluid_solver::equations::{Carrier, Coefficients, ViscousForm};
use fluid_solver::linear::System;
use fluid_solver::mesh::{Mesh, Rectangle};
use fluid_solver::solid::{Solid, SolidFields};
use fluid_solver::state::Flow;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector};

use crate::space::{RandomSolid, kuhn_cells};
use crate::support::Random;

/// How flows take part: α/Δt, and the weight in a and in the history of each.
struct Scheme {
    name: &'static str,
    rate: f64,
    weights: &'static [(f64, f64)],
}

const SCHEMES: [Scheme; 5] = [
    Scheme {
        name: "backward Euler",
        rate: 2.0,
        weights: &[(1.0, 2.0)],
    },
    Scheme {
        name: "BDF2",
        rate: 3.0,
        weights: &[(2.0, 4.0), (-1.0, -1.0)],
    },
    Scheme {
        name: "creeping",
        rate: 2.0,
        weights: &[(0.0, 2.0)],
    },
    Scheme {
        name: "steady",
        rate: 0.0,
        weights: &[(1.0, 0.0)],
    },
    Scheme {
        name: "BDF2, iterated",
        rate: 3.0,
        weights: &[(0.0, 4.0), (0.0, -1.0), (1.0, 0.0)],
    },
];

/// A moving fluid in a solid.
struct Case<'a, const D: usize, const N: usize> {
    mesh: &'a Mesh<D, N>,
    solid: &'a Solid<D>,
    flows: &'a [Flow<D>],
}

impl<const D: usize, const N: usize> Case<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Use the system and what fills it, quickly or one by one.
    fn assembly<R>(
        &self,
        scheme: &Scheme,
        quick: bool,
        work: impl FnOnce(&Assembly<'_, D, N>, System<N>) -> R,
    ) -> R {
        let pairs = self.flows.iter().zip(scheme.weights);
        let carriers: Vec<Carrier<'_, D>> = pairs
            .map(|(flow, &(convects, history))| Carrier {
                flow,
                convects,
                history,
            })
            .collect();
        let gravity = from_fn(|d| [1.3, -9.81, 0.7][d]);
        let none = |_: Vector<D>, _: f64| Vector::zeros();
        let terms = Coefficients {
            density: 1200.0,
            dynamic_viscosity: 12.0,
            gravity,
            viscous_form: ViscousForm::Symmetric,
            grad_div: 1.0,
            rate: scheme.rate,
            newton: false,
            body_force: if quick { None } else { Some(&none) },
            time: 0.0,
            carriers: &carriers,
            solid: self.solid,
        };
        let conditions = vec![Condition::NoSlip; self.mesh.boundary_names.len()];
        let constraints = Constraints::new(self.mesh, conditions, 1200.0, &gravity).unwrap();
        let flux = vec![0.0; self.mesh.node_count()];
        let assembly = Assembly {
            terms: &terms,
            mesh: self.mesh,
            constraints: &constraints,
            flux: &flux,
        };
        let system = System::new(self.mesh.node_count(), &self.mesh.simplices);
        work(&assembly, system)
    }

    fn filled(&self, scheme: &Scheme, quick: bool) -> System<N> {
        self.assembly(scheme, quick, |assembly, mut system| {
            assembly.fill(&mut system, true);
            system
        })
    }

    /// Largest difference of a matrix entry from that of the slow way over the largest of its kind in its row, and
    /// of the right-hand side over the largest of its kind.
    fn differences(&self, scheme: &Scheme) -> [f64; 2] {
        let [quick, slow] = [true, false].map(|quick| self.filled(scheme, quick));
        let kind = |row: usize, column: usize| {
            let pressure = |k: usize| usize::from(k % N == D);
            2 * pressure(row) + pressure(column)
        };
        let mut largest = vec![[0.0f64; 4]; slow.right.len()];
        let pattern = &slow.pattern;
        pattern.for_each(&slow.matrix, |row, column, value| {
            let largest = &mut largest[row][kind(row, column)];
            *largest = largest.max(value.abs());
        });
        let mut apart = quick.matrix.clone();
        let slots = apart.as_flattened_mut().as_flattened_mut().iter_mut();
        let oracle = slow.matrix.as_flattened().as_flattened();
        slots.zip(oracle).for_each(|(slot, value)| *slot -= value);
        let mut matrix: f64 = 0.0;
        pattern.for_each(&apart, |row, column, value| {
            let largest = largest[row][kind(row, column)];
            matrix = matrix.max(value.abs() / largest);
        });
        let mut right = [[0.0f64; 2]; 2];
        for (row, (a, b)) in quick.right.iter().zip(&slow.right).enumerate() {
            let [apart, largest] = &mut right[usize::from(row % N == D)];
            *apart = apart.max((a - b).abs());
            *largest = largest.max(b.abs());
        }
        let right = right.map(|[apart, largest]| apart / largest);
        [matrix, right[0].max(right[1])]
    }
}

/// The terms of the energy identity in any solution, quickly or one by one, and the sum of their magnitudes.
fn powers<const D: usize, const N: usize>(
    assembly: &Assembly<'_, D, N>,
    count: usize,
) -> ([f64; 6], f64)
where
    Dim<D>: Dimension<D>,
{
    let mut random = Random(23);
    let unknowns: Vec<f64> = (0..N * count).map(|_| random.between(-0.1, 0.1)).collect();
    let velocity: Vec<Vector<D>> = unknowns
        .chunks_exact(N)
        .map(|x| from_fn(|d| x[d]))
        .collect();
    let pressure: Vec<f64> = unknowns.iter().skip(D).step_by(N).copied().collect();
    let flux = assembly
        .constraints
        .boundary_flux(assembly.mesh, 0.0)
        .unwrap();
    let solved = Solved {
        terms: assembly.terms,
        mesh: assembly.mesh,
        constraints: assembly.constraints,
        velocity: &velocity,
        pressure: &pressure,
        unknowns: &unknowns,
        reaction: &unknowns,
        flux: &flux,
        drive: None,
        driving: from_fn(|d| 0.1 * d as f64),
    };
    let powers = solved.powers();
    let terms = [
        powers.kinetic_energy,
        powers.inertia,
        powers.viscous,
        powers.gravity,
        powers.solid,
        powers.stabilisation,
    ];
    (terms, powers.scale())
}

fn flows<const D: usize>(porosity: &[f64], clear: bool, seed: u64) -> Vec<Flow<D>> {
    let mut random = Random(seed);
    let flow = |_| Flow {
        superficial_velocity: (porosity.iter())
            .map(|_| from_fn(|_| random.between(-0.1, 0.1)))
            .collect(),
        porosity: (porosity.iter())
            .map(|phi| {
                if clear {
                    1.0
                } else {
                    (phi * random.between(0.9, 1.1)).min(1.0)
                }
            })
            .collect(),
    };
    (0..3).map(flow).collect()
}

/// Solids in which each of the forms of the equations is there.
fn solids<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<(&'static str, Solid<D>)>
where
    Dim<D>: Dimension<D>,
{
    let nodes = mesh.node_count();
    let free = RandomSolid::new::<D>(nodes, 1e4, 3);
    let mut held = RandomSolid::new::<D>(nodes, 1e8, 5);
    held.entrained.fill(0.0);
    held.mobility.fill(0.0);
    // Some follow a little: between held and free.
    let mut between = RandomSolid::new::<D>(nodes, 1e6, 7);
    for values in [&mut between.entrained, &mut between.mobility] {
        values.iter_mut().for_each(|value| *value *= 0.03);
    }
    between.mobility.fill(0.0);
    // Grains on one side only, groups of all kinds.
    let mut half = RandomSolid::new::<D>(nodes, 1e7, 9);
    let clear = mesh.position.iter().map(|x| x[0] > 0.4);
    for (node, _) in clear.enumerate().filter(|(_, clear)| *clear) {
        half.porosity[node] = 1.0;
        half.source[D * node..D * (node + 1)].fill(0.0);
        half.flux[D * node..D * (node + 1)].fill(0.0);
        let scalars = [
            &mut half.drag,
            &mut half.entrained,
            &mut half.mobility,
            &mut half.fixed,
        ];
        scalars.into_iter().for_each(|values| values[node] = 0.0);
    }
    let of = |name, fields: SolidFields<'_>| (name, Solid::new(&fields, mesh).unwrap());
    vec![
        of("clear fluid", SolidFields::default()),
        of("free grains", free.fields()),
        of("held grains", held.fields()),
        of("between", between.fields()),
        of("grains in one half", half.fields()),
    ]
}

#[test]
fn groups_of_simplices_give_the_terms_taken_one_by_one() {
    fn check<const D: usize, const N: usize>(cells: usize)
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = kuhn_cells::<D, N>(cells, 3);
        println!(
            "{D} dimensions, {} simplices      matrix   right side",
            mesh.simplices.len()
        );
        for (name, solid) in solids(&mesh) {
            let flows = flows(&solid.matrix.porosity, name == "clear fluid", 17);
            for scheme in &SCHEMES {
                let case = Case {
                    mesh: &mesh,
                    solid: &solid,
                    flows: &flows,
                };
                let [matrix, right] = case.differences(scheme);
                println!("{name:<19} {:<15} {matrix:.1e}  {right:.1e}", scheme.name);
                assert!(matrix < 1e-12 && right < 1e-12);
            }
        }
    }
    // The last group is not full.
    check::<2, 3>(5);
    check::<3, 4>(3);
}

#[test]
fn the_energy_identity_has_the_same_terms_in_groups() {
    fn check<const D: usize, const N: usize>(cells: usize)
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = kuhn_cells::<D, N>(cells, 3);
        for (name, solid) in solids(&mesh) {
            let flows = flows(&solid.matrix.porosity, name == "clear fluid", 17);
            let mut worst: f64 = 0.0;
            for scheme in &SCHEMES {
                let case = Case {
                    mesh: &mesh,
                    solid: &solid,
                    flows: &flows,
                };
                let [(quick, scale), (slow, _)] = [true, false].map(|quick| {
                    case.assembly(scheme, quick, |assembly, _| {
                        powers(assembly, mesh.node_count())
                    })
                });
                for (quick, slow) in quick.iter().zip(&slow) {
                    worst = worst.max((quick - slow).abs() / scale);
                }
            }
            println!("{D} dimensions, {name:<19} {worst:.1e} of the sum of magnitudes");
            assert!(worst < 1e-13);
        }
    }
    check::<2, 3>(5);
    check::<3, 4>(3);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = kuhn_cells::<3, 4>(9, 3);
    let (_, solid) = solids(&mesh).pop().unwrap();
    let flows = flows(&solid.matrix.porosity, false, 17);
    let case = Case {
        mesh: &mesh,
        solid: &solid,
        flows: &flows,
    };
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| case.filled(&SCHEMES[1], true))
    });
    assert!(one.matrix == three.matrix && one.right == three.right);
}

/// Nanoseconds of CPU a simplex of both ways, with and without the matrix: the least of some, taken in turn.
fn time<const D: usize, const N: usize>(name: &str, mesh: &Mesh<D, N>, solid: &Solid<D>)
where
    Dim<D>: Dimension<D>,
{
    let flows = flows(&solid.matrix.porosity, name.ends_with("clear fluid"), 17);
    let case = Case {
        mesh,
        solid,
        flows: &flows[..1],
    };
    let mut least = [[f64::INFINITY; 3]; 2];
    case.assembly(&SCHEMES[0], false, |slow, mut system| {
        case.assembly(&SCHEMES[0], true, |quick, _| {
            for _ in 0..9 {
                for (assembly, least) in [slow, quick].iter().zip(&mut least) {
                    for (work, least) in least.iter_mut().enumerate() {
                        let begin = cpu_seconds();
                        match work {
                            2 => drop(powers(assembly, mesh.node_count())),
                            _ => assembly.fill(&mut system, work == 1),
                        }
                        *least = least.min(cpu_seconds() - begin);
                    }
                }
            }
        });
    });
    let count = mesh.simplices.len();
    let [slow, quick] = least.map(|row| row.map(|seconds| seconds * 1e9 / count as f64));
    println!(
        "{name}, {} nodes, {count} simplices, ns a simplex:",
        mesh.node_count()
    );
    for (what, k) in [
        ("matrix and right side", 1),
        ("right side", 0),
        ("energy identity", 2),
    ] {
        let factor = slow[k] / quick[k];
        println!(
            "  {what:<21} {:7.1} -> {:6.1}   {factor:5.1} x",
            slow[k], quick[k]
        );
    }
}

#[test]
#[ignore = "a measurement"]
fn how_much_quicker() {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    pool.install(|| {
        let rectangle = Rectangle::new([0.0; 2], [1.0; 2], [80, 240]);
        let plane = rectangle.mesh().unwrap();
        let space = kuhn_cells::<3, 4>(16, 3);
        for (name, solid) in solids(&plane).into_iter().take(3) {
            time(&format!("plane, {name}"), &plane, &solid);
        }
        for (name, solid) in solids(&space).into_iter().take(3) {
            time(&format!("space, {name}"), &space, &solid);
        }
    });
}
