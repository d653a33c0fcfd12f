//! One sphere in fluid at rest, through the coupler's formulas in space.

use coupler::coupled::response::Model;
use coupler::drag::{Fluid, Shape, coefficient};
use coupler::immersion::Immersion;
use coupler::state::{Candidate, Contact, Flow, Grains};
use coupler::transfer::Transfer;
use protocol::scene::{DragLaw, Geometry};
use space::{Vector, hypot};

use crate::mesh::cube;

#[test]
fn one_sphere_falls_with_the_slip_at_which_drag_carries_its_weight() {
    let (density, heavy, radius) = (1000.0, 2500.0, 5e-4);
    let fluid = Fluid {
        density,
        dynamic_viscosity: 1e-3,
    };
    let gravity = Vector::from([3.0, -8.0, 4.0]);
    let shape = Shape::new(Geometry::Sphere { depth: 1.0 }, radius, 1.0);
    let mesh = cube::<3, 4>(3, 0.3, false);
    let immersion = Immersion {
        transfer: Transfer::new(&mesh, 1.0),
        fluid,
        gravity,
        law: DragLaw::Dallavalle,
        shapes: vec![shape],
        exits: Default::default(),
    };
    let mut grains = Grains {
        position: vec![Vector::from([0.4, 0.5, 0.6])],
        velocity: vec![Vector::zeros()],
        mean_velocity: vec![Vector::zeros()],
        contact: vec![Contact::Free],
        spin: Vec::new(),
        contact_force: vec![Vector::zeros()],
        carried_force: vec![Vector::zeros()],
        mass: vec![heavy * shape.volume],
        volume: vec![shape.volume],
        radius: vec![radius],
        fixed: vec![false],
        id: vec![0],
    };
    let nodes = mesh.node_position.len();
    let flow = Flow {
        velocity: vec![Vector::zeros(); nodes],
        pressure_gradient: vec![gravity * density; nodes],
    };
    let clear = vec![1.0; nodes];
    let placement = immersion.place(&grains, 0.0).expect("inside");
    for dt in [1e-3, 1e-1, 1e2] {
        grains.velocity = vec![Vector::zeros()];
        for _ in 0..2000 {
            let drag = immersion.drag(&grains, &flow, &placement, &clear, Some(dt));
            let model = Model::free(&grains, drag, &gravity, dt, 1);
            let force = immersion.force(&grains, &flow, &placement, &model.drag);
            let velocity = model.velocity(&force);
            grains.accept(Candidate {
                position: grains.position.clone(),
                velocity: velocity.clone(),
                mean_velocity: velocity,
                contact: vec![Contact::Free],
                spin: Vec::new(),
                sub_steps: 1,
            });
        }
        let slip = hypot(&grains.velocity[0]);
        let carried = slip * coefficient(DragLaw::Dallavalle, &fluid, 1.0, slip, &shape);
        let weight = (heavy - density) * shape.volume * hypot(&gravity);
        let along = hypot(&(grains.velocity[0] / slip - gravity / hypot(&gravity)));
        println!(
            "| {dt} | {slip:.6e} | {:.1e} | {along:.1e} |",
            carried / weight - 1.0
        );
        assert!((carried / weight - 1.0).abs() < 1e-10);
        assert!(along < 1e-12);
    }
}
