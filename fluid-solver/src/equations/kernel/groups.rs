//! A group, computed the one way or the other.

use super::clear::ClearFluid;
use super::group::{Group, GroupMatrix, GroupRight};
use super::porous::Porous;
use super::records::Records;
use super::sums::Sums;
use crate::equations::coefficients::Coefficients;
use crate::mesh::simplices::Mesh;

/// The equations of an assembly, ready for its groups.
pub struct Groups<'a, const D: usize, const N: usize> {
    /// What the equations are told.
    pub terms: &'a Coefficients<'a, D>,
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Its nodes.
    pub records: Records<D>,
}

impl<const D: usize, const N: usize> Groups<'_, D, N> {
    /// Blocks (left as they are unless wanted) and right-hand side of group `g`.
    #[inline(always)]
    pub fn compute<const MATRIX: bool>(
        &self,
        g: usize,
        matrix: &mut GroupMatrix<N>,
        right: &mut GroupRight<N>,
    ) {
        let group = Group::gather(self.mesh, g);
        if self.records.are_clear(&group.nodes) {
            let clear = ClearFluid::gather(self.terms, &self.records, group);
            clear.right(self.terms, right);
            if MATRIX {
                clear.matrix(self.terms, matrix);
            }
        } else {
            let porous = Porous::gather(self.terms, &self.records, group);
            let sums = Sums::new::<MATRIX>(self.terms, &porous);
            sums.right(&porous, right);
            if MATRIX {
                sums.matrix(self.terms, &porous, matrix);
            }
        }
    }
}
