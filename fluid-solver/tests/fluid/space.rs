//! The same equations in the plane and in space: what must hold on any simplices, on random ones.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::{Candidate, Request};
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::mesh::Mesh;
use fluid_solver::solid::SolidFields;
use fluid_solver::state::{Flow, State};
use fluid_solver::step::FluidSolver;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector, dot, flat};
use std::sync::Arc;

use crate::support::Random;

const CELLS: usize = 4;

/// [`kuhn_cells`] of a few cells.
fn kuhn<const D: usize, const N: usize>(seed: u64) -> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    kuhn_cells(CELLS, seed)
}

/// A unit square or cube of cells, each cut into D! simplices along its diagonal (Kuhn), the nodes
/// inside moved at random; its boundary is one and called "walls".
pub fn kuhn_cells<const D: usize, const N: usize>(cells: usize, seed: u64) -> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    let lines = cells + 1;
    let number = |at: &[usize; D]| at.iter().rev().fold(0, |sum, k| lines * sum + k);
    let place =
        |node: usize| -> [usize; D] { std::array::from_fn(|d| node / lines.pow(d as u32) % lines) };
    let mut random = Random(seed);
    let nodes = 0..lines.pow(D as u32);
    let position = nodes.map(|node| {
        let at = place(node);
        let inside = at.iter().all(|k| (1..cells).contains(k));
        let reach = if inside { 0.25 } else { 0.0 };
        from_fn(|d| (at[d] as f64 + random.between(-reach, reach)) / cells as f64)
    });
    let position: Vec<Vector<D>> = position.collect();
    let mut simplices: Vec<[usize; N]> = Vec::new();
    for cell in (0..cells.pow(D as u32))
        .map(|c| -> [usize; D] { std::array::from_fn(|d| c / cells.pow(d as u32) % cells) })
    {
        for order in orders::<D>() {
            let mut at = cell;
            let mut corners = [number(&at); N];
            for (k, &axis) in order.iter().enumerate() {
                at[axis] += 1;
                corners[k + 1] = number(&at);
            }
            if space::simplex::determinant(&corners.map(|n| position[n])) < 0.0 {
                corners.swap(D - 1, D);
            }
            simplices.push(corners);
        }
    }
    let mut walls = Vec::new();
    for nodes in &simplices {
        for k in 0..N {
            let facet = space::simplex::facet_corners::<D>(k).map(|corner| nodes[corner]);
            let on = |d: usize, end: usize| facet.iter().all(|&n| place(n)[d] == end);
            if (0..D).any(|d| on(d, 0) || on(d, cells)) {
                walls.push((facet, 0));
            }
        }
    }
    Mesh::new(position, simplices, vec!["walls".into()], &walls, |t| t).unwrap()
}

/// All orders of the axes.
fn orders<const D: usize>() -> Vec<[usize; D]> {
    let codes = 0..D.pow(D as u32);
    let order = |code: usize| -> [usize; D] { std::array::from_fn(|d| code / D.pow(d as u32) % D) };
    let all_different = |order: &[usize; D]| (0..D).all(|axis| order.contains(&axis));
    codes.map(order).filter(all_different).collect()
}

/// The nodes of the boundary.
fn is_wall<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<bool> {
    let mut wall = vec![false; mesh.node_count()];
    for facet in &mesh.facets {
        facet.node.iter().for_each(|&node| wall[node] = true);
    }
    wall
}

fn largest<const D: usize>(velocity: &[Vector<D>], exact: impl Fn(usize) -> Vector<D>) -> f64 {
    let apart = velocity
        .iter()
        .enumerate()
        .map(|(n, v)| (v - exact(n)).amax());
    apart.fold(0.0, f64::max)
}

/// A vector with other components along each axis.
fn oblique<const D: usize>(values: [f64; 3]) -> Vector<D> {
    from_fn(|d| values[d])
}

#[test]
fn meshes_fill_the_cube_with_normals_outward() {
    fn check<const D: usize, const N: usize>()
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = kuhn::<D, N>(3);
        let volume: f64 = mesh.nodal_mass.iter().sum();
        let surface: f64 = mesh.facets.iter().map(|facet| facet.size).sum();
        println!("{D} dimensions: volume {volume}, surface {surface}");
        assert!((volume - 1.0).abs() < 1e-13 && (surface - 2.0 * D as f64).abs() < 1e-12);
        for facet in &mesh.facets {
            let centre = mesh.position[facet.node[0]] - Vector::repeat(0.5);
            assert!((dot(&facet.normal, &centre) - 0.5).abs() < 1e-13);
            assert!((space::norm(&facet.normal) - 1.0).abs() < 1e-15);
        }
    }
    check::<2, 3>();
    check::<3, 4>();
}

/// Steady flow without convection whose velocity is linear, given on the walls: u = U + A x.
fn linear_flow<const D: usize, const N: usize>(
    velocity: impl Fn(&Vector<D>) -> Vector<D> + Copy + Send + Sync + 'static,
    gravity: Vector<D>,
) -> (FluidSolver<D, N>, Candidate<D>)
where
    Dim<D>: Dimension<D>,
{
    let given = Condition::Function(Arc::new(move |x: Vector<D>, _| velocity(&x)));
    let mut config = FluidConfig::new(2.0, 0.3).with("all", given);
    config.gravity = gravity;
    config.convection = false;
    config.time_scheme = TimeScheme::Steady;
    let mut solver = FluidSolver::new(config, kuhn(5)).unwrap();
    let request = Request::first(1, 1.0);
    let candidate = solver
        .advance(&request, &SolidFields::default())
        .unwrap()
        .clone();
    (solver, candidate)
}

#[test]
fn a_linear_velocity_and_a_constant_pressure_gradient_are_reproduced() {
    fn check<const D: usize, const N: usize>()
    where
        Dim<D>: Dimension<D>,
    {
        // Without divergence, and neither symmetric nor antisymmetric.
        let linear = |x: &Vector<D>| -> Vector<D> {
            from_fn(|d| 0.3 + x[(d + 1) % D] - 0.4 * x[(d + D - 1) % D] * f64::from(D > 2))
        };
        let gravity = oblique([1.3, -9.81, 0.7]);
        let (solver, candidate) = linear_flow::<D, N>(linear, gravity);
        let position = &solver.mesh().position;
        let v = largest(&candidate.interstitial_velocity, |n| linear(&position[n]));
        let g = largest(&candidate.pressure_gradient, |_| 2.0 * gravity);
        println!("{D} dimensions: largest errors v {v:.1e} m/s, grad p {g:.1e} Pa/m");
        assert!(v < 1e-11 && g < 1e-9);
    }
    check::<2, 3>();
    check::<3, 4>();
}

#[test]
fn rigid_motion_costs_nothing() {
    fn check<const D: usize, const N: usize>()
    where
        Dim<D>: Dimension<D>,
    {
        // U + ω × x, all axes turning.
        let rigid = |x: &Vector<D>| -> Vector<D> {
            from_fn(|d| 0.2 + (0..D).map(|f| (f as f64 - d as f64) * x[f]).sum::<f64>())
        };
        let (solver, candidate) = linear_flow::<D, N>(rigid, Vector::zeros());
        let position = &solver.mesh().position;
        let v = largest(&candidate.interstitial_velocity, |n| rigid(&position[n]));
        let viscous = candidate.powers.viscous;
        println!("{D} dimensions: largest error {v:.1e} m/s, viscous power {viscous:.1e} W");
        // What is left of |∇v|² + ∇v:∇vᵀ.
        assert!(v < 1e-11 && viscous.abs() < 1e-14);
        assert!(largest(&candidate.forces, |_| Vector::zeros()) < 1e-11);
    }
    check::<2, 3>();
    check::<3, 4>();
}

/// Nodal fields of a random solid.
pub struct RandomSolid {
    pub porosity: Vec<f64>,
    pub drag: Vec<f64>,
    pub source: Vec<f64>,
    pub entrained: Vec<f64>,
    pub flux: Vec<f64>,
    pub mobility: Vec<f64>,
    pub fixed: Vec<f64>,
}

impl RandomSolid {
    pub fn new<const D: usize>(nodes: usize, drag: f64, seed: u64) -> RandomSolid {
        let mut random = Random(seed);
        let mut many = |count: usize, low: f64, high: f64| -> Vec<f64> {
            (0..count).map(|_| random.between(low, high)).collect()
        };
        let porosity = many(nodes, 0.3, 1.0);
        let share = many(nodes, 0.0, 1.0);
        let drags = many(nodes, 0.0, drag);
        let fixed = share.iter().zip(&drags).map(|(f, b)| f * b).collect();
        let pairs = porosity.iter().zip(&share);
        RandomSolid {
            entrained: pairs
                .map(|(porosity, share)| (1.0 - porosity) * share)
                .collect(),
            porosity,
            drag: drags,
            source: many(D * nodes, -drag, drag),
            flux: many(D * nodes, -1e-2, 1e-2),
            mobility: many(nodes, 0.0, 1e-4),
            fixed,
        }
    }

    pub fn fields(&self) -> SolidFields<'_> {
        SolidFields {
            porosity: Some(&self.porosity),
            drag: Some(&self.drag),
            drag_source: Some(&self.source),
            entrained_fraction: Some(&self.entrained),
            solid_flux: Some(&self.flux),
            solid_mobility: Some(&self.mobility),
            fixed_drag: Some(&self.fixed),
        }
    }
}

#[test]
fn fluid_rests_under_oblique_gravity_whatever_the_porosity() {
    fn check<const D: usize, const N: usize>(drag: f64)
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = kuhn::<D, N>(7);
        let solid = RandomSolid::new::<D>(mesh.node_count(), drag, 11);
        let gravity: Vector<D> = oblique([1.3, -9.81, 0.7]);
        let mut config = FluidConfig::new(1000.0, 0.12).with("all", Condition::NoSlip);
        config.gravity = gravity;
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let fields = SolidFields {
            porosity: Some(&solid.porosity),
            drag: Some(&solid.drag),
            ..SolidFields::default()
        };
        for step in 1..=3 {
            solver
                .advance(&Request::first(step, 1e-3), &fields)
                .unwrap();
            solver.commit().unwrap();
        }
        let state = solver.state();
        let v = largest(&state.now.interstitial_velocity(), |_| Vector::zeros());
        let exact = |n: usize| 1000.0 * dot(&gravity, &solver.mesh().position[n]);
        let reference = exact(0) - state.pressure[0];
        let apart = |n: usize| (state.pressure[n] - exact(n) + reference).abs() / 9810.0;
        let p = (0..state.pressure.len()).map(apart).fold(0.0, f64::max);
        println!("{D} dimensions, beta {drag:.0e}: largest v {v:.1e}, p {p:.1e} of rho g H");
        assert!(v < 1e-10 && p < 1e-10);
    }
    for drag in [0.0, 1e3, 1e8] {
        check::<2, 3>(drag);
        check::<3, 4>(drag);
    }
}

#[test]
fn grains_and_fluid_translate_together() {
    fn check<const D: usize, const N: usize>()
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = kuhn::<D, N>(13);
        let uniform: Vector<D> = oblique([1.0, 0.5, -0.7]);
        let mut solid = RandomSolid::new::<D>(mesh.node_count(), 1e3, 17);
        // Grains inside alone: across the walls goes what the fluid carries.
        for (node, wall) in is_wall(&mesh).into_iter().enumerate() {
            if wall {
                (solid.porosity[node], solid.entrained[node]) = (1.0, 0.0);
            }
        }
        let nodes = 0..mesh.node_count();
        let moving = |of_node: &dyn Fn(usize) -> f64| -> Vec<Vector<D>> {
            nodes.clone().map(|n| of_node(n) * uniform).collect()
        };
        let source = moving(&|n| solid.drag[n]);
        let flux = moving(&|n| 1.0 - solid.porosity[n] - solid.entrained[n]);
        (solid.source, solid.flux) = (flat::numbers(&source).into(), flat::numbers(&flux).into());
        let velocity = moving(&|n| solid.porosity[n]);
        let given = Condition::Uniform(uniform);
        let config = FluidConfig::new(1.0, 1e-2).with("all", given);
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        solver.set_state(State {
            time: 0.0,
            fresh: false,
            now: Flow {
                superficial_velocity: velocity,
                porosity: solid.porosity.clone(),
            },
            before: None,
            pressure: vec![0.0; solid.porosity.len()],
            convected: false,
            mesh_change: None,
        });
        let candidate = solver
            .advance(&Request::first(1, 0.05), &solid.fields())
            .unwrap();
        let v = largest(&candidate.interstitial_velocity, |_| uniform);
        println!("{D} dimensions: largest |v - U| {v:.1e} m/s");
        assert!(v < 1e-10);
    }
    check::<2, 3>();
    check::<3, 4>();
}

#[test]
fn action_is_reaction_and_energy_is_accounted_for() {
    fn check<const D: usize, const N: usize>()
    where
        Dim<D>: Dimension<D>,
    {
        let (density, dt) = (1000.0, 0.01);
        let mesh = kuhn::<D, N>(19);
        let solid = RandomSolid::new::<D>(mesh.node_count(), 1e4, 23);
        let gravity: Vector<D> = oblique([0.5, -9.81, 1.1]);
        let mut config = FluidConfig::new(density, 0.1).with("all", Condition::NoSlip);
        config.gravity = gravity;
        // Grad-div pushes where porosities change, as far as continuity is not fulfilled.
        config.grad_div = 0.0;
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let first = solver
            .advance(&Request::first(1, dt), &solid.fields())
            .unwrap()
            .clone();
        let mesh = solver.mesh();
        let source: &[Vector<D>] = flat::vectors(&solid.source).unwrap();
        // What grains and walls take is what gravity gives and inertia leaves, node by node.
        let (mut expected, mut size) = (Vector::zeros(), 0.0);
        for n in 0..mesh.node_count() {
            let (v, slope) = (first.interstitial_velocity[n], first.pressure_gradient[n]);
            let porosity = solid.porosity[n];
            let buoyancy = (1.0 - porosity - solid.entrained[n]) * slope;
            let drag = source[n] - solid.drag[n] * v;
            let weight = density * porosity * (gravity - v / dt);
            expected += mesh.nodal_mass[n] * (buoyancy + drag + weight);
            size += mesh.nodal_mass[n] * (buoyancy.amax() + drag.amax() + weight.amax());
        }
        let force: Vector<D> = first.forces.iter().sum();
        let apart = (force - expected).amax() / size;
        println!("{D} dimensions: force {apart:.1e} of its terms");
        assert!(apart < 1e-12);
        for step in 1..=3 {
            let powers = solver
                .advance(&Request::first(step, dt), &solid.fields())
                .unwrap()
                .powers;
            let defect = powers.defect().abs() / powers.scale();
            println!("  step {step}: energy defect {defect:.1e} of its terms");
            assert!(defect < 1e-11 && powers.viscous > 0.0);
            solver.commit().unwrap();
        }
    }
    check::<2, 3>();
    check::<3, 4>();
}
