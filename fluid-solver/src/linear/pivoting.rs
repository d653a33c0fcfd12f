//! The safe factor: sparse LU with row exchanges anywhere (faer, COLAMD), several times slower
//! than the multifrontal one and used only where that is not accurate enough.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par};

use super::pattern::Pattern;
use crate::error::FluidError;

/// Factor of a matrix with partial pivoting.
pub struct PivotingLu {
    structure: SymbolicSparseColMat<usize>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    memory: MemBuffer,
}

impl PivotingLu {
    /// Analyse a pattern.
    pub fn new<const N: usize>(pattern: &Pattern<N>) -> Result<PivotingLu, FluidError> {
        let broken = |error| FluidError::Factorisation(format!("analysis: {error:?}"));
        let (pointers, rows) = pattern.columns();
        let n = pattern.unknowns();
        let structure = SymbolicSparseColMat::new_checked(n, n, pointers, None, rows);
        let symbolic =
            factorize_symbolic_lu(structure.as_ref(), Default::default()).map_err(broken)?;
        let factor = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        let memory = MemBuffer::try_new(factor.or(solve))
            .map_err(|_| FluidError::Factorisation("out of memory".into()))?;
        Ok(PivotingLu {
            structure,
            symbolic,
            numeric: NumericLu::new(),
            memory,
        })
    }

    /// Factorise the matrix with these entries.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), FluidError> {
        let matrix = SparseColMatRef::new(self.structure.as_ref(), values);
        let stack = MemStack::new(&mut self.memory);
        self.symbolic
            .factorize_numeric_lu(
                &mut self.numeric,
                matrix,
                Par::Seq,
                stack,
                Default::default(),
            )
            .map(|_| ())
            .map_err(|error| FluidError::Factorisation(format!("{error:?}")))
    }

    /// x ← (LU)⁻¹ x
    pub fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        let stack = MemStack::new(&mut self.memory);
        let column = MatMut::from_column_major_slice_mut(x, n, 1);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            column,
            Par::Seq,
            stack,
        );
    }
}
