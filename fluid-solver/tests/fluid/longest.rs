//! Meshes that are bisected from a mesh, each simplex across its longest edge: conforming, as fine as asked, of the
//! angles of the root, with its boundaries.

use std::collections::BTreeMap;
use std::path::Path;

use fluid_solver::mesh::{
    Bisection, LongestEdge, Mesh, Place, Rectangle, Root, Sizes, Spot, Zone, file,
};
use space::{Dim, Dimension, Vector, simplex, vector};

use crate::bisection::{require_found, sum};
use crate::support::Random;

const SIMPLICES_MAX: usize = 2_000_000;

/// Every side of a simplex belongs to two, or is a facet of a boundary.
fn require_conforming<const D: usize, const N: usize>(mesh: &Mesh<D, N>)
where
    Dim<D>: Dimension<D>,
{
    let mut sides: BTreeMap<[usize; D], usize> = BTreeMap::new();
    for nodes in &mesh.simplices {
        for k in 0..N {
            let mut side = simplex::facet_corners::<D>(k).map(|corner| nodes[corner]);
            side.sort_unstable();
            *sides.entry(side).or_default() += 1;
        }
    }
    for facet in &mesh.facets {
        let mut side = facet.node;
        side.sort_unstable();
        assert_eq!(sides.remove(&side), Some(1));
    }
    assert!(sides.values().all(|&count| count == 2));
}

/// Sizes of the facets of each boundary.
fn boundaries<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> BTreeMap<String, f64> {
    let mut sizes = BTreeMap::new();
    for facet in &mesh.facets {
        let name = mesh.boundary_names[facet.boundary].clone();
        *sizes.entry(name).or_default() += facet.size;
    }
    sizes
}

/// Smallest angle of a triangle; of a tetrahedron its volume over that of the cube of its longest edge.
fn shape<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> f64
where
    Dim<D>: Dimension<D>,
{
    let mut least = f64::INFINITY;
    let mut longest = 0.0_f64;
    for a in 0..N {
        for b in (0..N).filter(|&b| b != a) {
            longest = longest.max((corners[a] - corners[b]).norm());
            for c in (b + 1..N).filter(|&c| c != a) {
                let (p, q) = (corners[b] - corners[a], corners[c] - corners[a]);
                least = least.min((p.dot(&q) / (p.norm() * q.norm())).acos());
            }
        }
    }
    match D {
        2 => least,
        _ => simplex::determinant(corners) / longest.powi(3),
    }
}

/// Random size functions on a mesh; returns the worst shape over that of the root.
fn any_size_function<const D: usize, const N: usize>(
    name: &str,
    mesh: &Mesh<D, N>,
    count: usize,
    finest: f64,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let mut random = Random(11);
    let root = LongestEdge::new(mesh).unwrap();
    let size = |corners: &[Vector<D>; N]| simplex::cube_edge::<D>(simplex::determinant(corners));
    let coarsest = mesh.corners.iter().map(size).fold(0.0, f64::max);
    let mut worst = f64::INFINITY;
    let (mut largest, mut defect, mut before) = (0, 0.0_f64, None);
    for _ in 0..count {
        let zones = (0..1 + (4.0 * random.unit()) as usize).map(|_| {
            let corners = mesh.corners[(random.unit() * mesh.corners.len() as f64) as usize];
            let place = Place::Ball {
                centre: corners[0],
                radius: coarsest * random.unit(),
            };
            let size = coarsest * finest.powf(random.unit());
            Zone { place, size }
        });
        let zones: Vec<Zone<D>> = zones.collect();
        let sizes = Sizes::new(zones.clone(), 0.4, coarsest, [None; D]);
        let (bisection, refined) = Bisection::<_, D, N>::new(&root, &sizes, SIMPLICES_MAX).unwrap();
        require_conforming(&refined);
        let volume = sum(&mesh.nodal_mass);
        defect = defect.max((sum(&refined.nodal_mass) / volume - 1.0).abs());
        for (name, whole) in boundaries(mesh) {
            let parts = boundaries(&refined)[&name];
            assert!(
                (parts / whole - 1.0).abs() < 1e-12,
                "{name}: {parts} of {whole}"
            );
        }
        for corners in &refined.corners {
            let least = corners
                .iter()
                .map(|x| sizes.at(x))
                .fold(f64::INFINITY, f64::min);
            assert!(size(corners) <= least * (1.0 + 1e-8));
            worst = worst.min(shape(corners));
        }
        largest = largest.max(refined.node_count());
        let turned: Vec<_> = zones.iter().rev().copied().collect();
        let again = Sizes::new(turned, 0.4, coarsest, [None; D]);
        let (_, again) = Bisection::<_, D, N>::new(&root, &again, SIMPLICES_MAX).unwrap();
        assert!(again.position == refined.position && again.simplices == refined.simplices);
        if let Some((bisection, mesh)) = &before {
            let bisection: &Bisection<_, D, N> = bisection;
            let spots: Vec<Spot<N>> = bisection.spots_of(&bisection_of(&root, &sizes));
            require_found(&spots, mesh, &refined, |a, b| a - b);
        }
        before = Some((bisection, refined));
    }
    let root_shape = mesh.corners.iter().map(shape).fold(f64::INFINITY, f64::min);
    println!(
        "{name}: volume to {defect:.0e}, up to {largest} nodes, worst shape {worst:.4}, of the root {root_shape:.4}"
    );
    assert!(defect < 1e-12);
    worst / root_shape
}

fn bisection_of<const D: usize, const N: usize>(
    root: &LongestEdge<D, N>,
    sizes: &Sizes<D>,
) -> Bisection<LongestEdge<D, N>, D, N>
where
    Dim<D>: Dimension<D>,
{
    Bisection::new(root, sizes, SIMPLICES_MAX).unwrap().0
}

#[test]
fn any_size_function_on_a_mesh_of_triangles_keeps_half_its_smallest_angle() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/meshes/cylinder-coarse.msh");
    let cylinder = file::read::<2, 3>(&path, &gmsh::Options::default(), |_| true).unwrap();
    assert!(any_size_function("cylinder", &cylinder, 40, 1.0 / 32.0) >= 0.5);
    // all edges of a kind as long as each other: which is halved is decided by their middles
    let square = Rectangle::new([-1.0, 0.0], [1.0, 1.0], [6, 3])
        .mesh()
        .unwrap();
    assert!(any_size_function("square", &square, 100, 1.0 / 64.0) >= 0.5);
}

#[test]
fn any_size_function_on_a_mesh_of_tetrahedra_is_conforming() {
    let box_of_cells = Root {
        lower: Vector::<3>::zeros(),
        upper: vector::from_fn(|d| 1.0 + 0.3 * d as f64),
        cells: [3, 3, 3],
        periodic: [false; 3],
    };
    let sizes = Sizes::new(vec![], 0.4, 1.0, [None; 3]);
    let (_, mut mesh) = Bisection::<_, 3, 4>::new(&box_of_cells, &sizes, SIMPLICES_MAX).unwrap();
    let mut random = Random(5);
    let inside = |x: &Vector<3>| (0..3).all(|d| x[d] > 0.01 && x[d] < box_of_cells.upper[d] - 0.01);
    for x in mesh.position.iter_mut().filter(|x| inside(x)) {
        *x += vector::from_fn(|_| random.between(-0.06, 0.06));
    }
    let named = mesh.facets.iter().map(|facet| (facet.node, facet.boundary));
    let named: Vec<_> = named.collect();
    let (position, simplices) = (mesh.position.clone(), mesh.simplices.clone());
    let names = mesh.boundary_names.clone();
    let mesh = Mesh::new(position, simplices, names, &named, |t| t).unwrap();
    let worst = any_size_function("tetrahedra", &mesh, 20, 1.0 / 8.0);
    println!("  {worst:.3} of the worst of the root");
    assert!(worst > 0.3);
}

#[test]
fn a_root_with_two_nodes_at_a_place_is_refused() {
    let position = [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, 1.0],
    ];
    let position = position.map(Vector::from).to_vec();
    let named = [[0, 1], [1, 2], [2, 0], [3, 5], [5, 4], [4, 3]].map(|nodes| (nodes, 0));
    let simplices = vec![[0, 1, 2], [3, 5, 4]];
    let mesh = Mesh::<2, 3>::new(position, simplices, vec!["all".to_owned()], &named, |t| t);
    let refused = LongestEdge::new(&mesh.unwrap()).map(drop).unwrap_err();
    println!("{refused}");
    assert!(
        refused
            .to_string()
            .contains("nodes 1 and 3, counted from 0, are both at 1e0 m, 0e0 m")
    );
}
