//! The same code for processors with wide registers; nothing is fused, so it has the same bits.

use super::group::{GroupMatrix, GroupRight};
use super::groups::Groups;
use super::records::Records;
use crate::equations::coefficients::{Coefficients, ViscousForm};
use crate::equations::element::CARRIERS;
use crate::mesh::simplices::Mesh;

/// The equations of an assembly, ready for its groups.
pub struct Kernel<'a, const D: usize, const N: usize> {
    groups: Groups<'a, D, N>,
    /// Are there registers for four numbers?
    wide: bool,
}

impl<'a, const D: usize, const N: usize> Kernel<'a, D, N> {
    /// None where the equations have a term that is not here.
    pub fn new(terms: &'a Coefficients<'a, D>, mesh: &'a Mesh<D, N>) -> Option<Kernel<'a, D, N>> {
        let known = terms.viscous_form == ViscousForm::Symmetric
            && !terms.newton
            && terms.body_force.is_none()
            && terms.carriers.len() <= CARRIERS;
        known.then(|| Kernel {
            groups: Groups {
                terms,
                mesh,
                records: Records::pack(terms),
            },
            wide: is_wide(),
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
        match matrix_too {
            true => self.dispatch::<true>(g, matrix, right),
            false => self.dispatch::<false>(g, matrix, right),
        }
    }

    fn dispatch<const MATRIX: bool>(
        &self,
        g: usize,
        matrix: &mut GroupMatrix<N>,
        right: &mut GroupRight<N>,
    ) {
        #[cfg(target_arch = "x86_64")]
        if self.wide {
            // SAFETY: `wide` is true only where the processor has told that it knows AVX2.
            unsafe { compute_avx2::<D, N, MATRIX>(&self.groups, g, matrix, right) };
            return;
        }
        self.groups.compute::<MATRIX>(g, matrix, right);
    }
}

fn is_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn compute_avx2<const D: usize, const N: usize, const MATRIX: bool>(
    groups: &Groups<'_, D, N>,
    g: usize,
    matrix: &mut GroupMatrix<N>,
    right: &mut GroupRight<N>,
) {
    groups.compute::<MATRIX>(g, matrix, right);
}
