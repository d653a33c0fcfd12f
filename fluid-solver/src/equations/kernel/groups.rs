//! The equations of an assembly, ready for its groups.

use std::ops::Range;

use space::Vector;

use super::clear::ClearFluid;
use super::energy::{Energy, Rates, Solution};
use super::group::{Group, GroupMatrix, GroupRight};
use super::lanes::LANES;
use super::porous::Porous;
use super::records::Records;
use super::sums::Sums;
use crate::equations::coefficients::{Coefficients, ViscousForm};
use crate::equations::element::CARRIERS;
use crate::mesh::simplices::Mesh;
use crate::wide::{Task, Wide};

/// The equations of an assembly, ready for its groups.
pub struct Kernel<'a, const D: usize, const N: usize> {
    terms: &'a Coefficients<'a, D>,
    mesh: &'a Mesh<D, N>,
    records: Records<D>,
    wide: Wide,
}

impl<'a, const D: usize, const N: usize> Kernel<'a, D, N> {
    /// None where the equations have a term that is not here.
    pub fn new(terms: &'a Coefficients<'a, D>, mesh: &'a Mesh<D, N>) -> Option<Kernel<'a, D, N>> {
        let known = terms.viscous_form == ViscousForm::Symmetric
            && !terms.newton
            && terms.body_force.is_none()
            && terms.carriers.len() <= CARRIERS;
        known.then(|| Kernel {
            terms,
            mesh,
            records: Records::pack(terms),
            wide: Wide::here(),
        })
    }

    /// Blocks (left as they are unless wanted) and right-hand side of group `g`.
    pub fn compute(
        &self,
        g: usize,
        matrix_too: bool,
        matrix: &mut GroupMatrix<N>,
        right: &mut GroupRight<N>,
    ) {
        self.wide.run(Blocks {
            kernel: self,
            g,
            matrix: matrix_too.then_some(matrix),
            right,
        });
    }

    /// What the terms of the energy identity are in these groups, with this velocity,
    /// this pressure and this uniform ∇p beside it.
    pub fn energy(
        &self,
        groups: Range<usize>,
        velocity: &[Vector<D>],
        pressure: &[f64],
        driving: &Vector<D>,
    ) -> Energy {
        self.wide.run(EnergyOf {
            kernel: self,
            groups,
            velocity,
            pressure,
            driving,
        })
    }
}

/// Right-hand side of a group, and its blocks where they are wanted.
struct Blocks<'a, const D: usize, const N: usize> {
    kernel: &'a Kernel<'a, D, N>,
    g: usize,
    matrix: Option<&'a mut GroupMatrix<N>>,
    right: &'a mut GroupRight<N>,
}

impl<const D: usize, const N: usize> Task for Blocks<'_, D, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Kernel {
            terms,
            mesh,
            records,
            ..
        } = self.kernel;
        let group = Group::gather(mesh, self.g);
        if records.are_clear(&group.nodes) {
            let clear = ClearFluid::gather(terms, records, group);
            clear.right(terms, self.right);
            if let Some(matrix) = self.matrix {
                clear.matrix(terms, matrix);
            }
            return;
        }
        let porous = Porous::gather(terms, records, group);
        match self.matrix {
            Some(matrix) => {
                let sums = Sums::new::<true>(terms, &porous);
                sums.right(&porous, self.right);
                sums.matrix(terms, &porous, matrix);
            }
            None => Sums::new::<false>(terms, &porous).right(&porous, self.right),
        }
    }
}

/// The energy identity in some groups.
struct EnergyOf<'a, const D: usize, const N: usize> {
    kernel: &'a Kernel<'a, D, N>,
    groups: Range<usize>,
    velocity: &'a [Vector<D>],
    pressure: &'a [f64],
    driving: &'a Vector<D>,
}

impl<const D: usize, const N: usize> Task for EnergyOf<'_, D, N> {
    type Output = Energy;

    #[inline(always)]
    fn run(self) -> Energy {
        let Kernel {
            terms,
            mesh,
            records,
            ..
        } = self.kernel;
        let mut sum = Rates::NONE;
        for g in self.groups {
            let group = Group::gather(mesh, g);
            let filled = (mesh.simplices.len() - g * LANES).min(LANES);
            let solved = Solution::gather(&group, self.velocity, self.pressure, self.driving);
            let rates = match records.are_clear(&group.nodes) {
                true => ClearFluid::gather(terms, records, group).rates(terms, &solved),
                false => Rates::of(terms, &Porous::gather(terms, records, group), &solved),
            };
            sum.add(&rates, filled);
        }
        sum.energy()
    }
}

#[cfg(test)]
mod tests;
