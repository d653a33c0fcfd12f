//! CPU time by phase, on all threads of the process.

use crate::numbers::{Numbers, named};

/// What was spent since the last commit \[s\]: all passes, and candidates that were thrown away.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Element matrices and the matrix made of them.
    pub assembly: f64,
    /// Numeric factors.
    pub factor: f64,
    /// Triangular solves and refinement.
    pub solve: f64,
    /// Numbers of a candidate: the energy identity, forces, Re.
    pub powers: f64,
    /// New meshes, and what is carried over to them; none where the mesh stays.
    pub mesh: Option<f64>,
}

impl Cost {
    /// As diagnostics.
    pub fn numbers(&self) -> Numbers {
        let mut numbers = named([
            ("seconds_assembly", self.assembly),
            ("seconds_factor", self.factor),
            ("seconds_solve", self.solve),
            ("seconds_powers", self.powers),
        ]);
        let mesh = self.mesh.map(|seconds| ("seconds_mesh", seconds));
        numbers.extend(named(mesh));
        numbers
    }

    /// Count from now on.
    pub fn forget(&mut self) {
        *self = Cost {
            mesh: self.mesh.map(|_| 0.0),
            ..Cost::default()
        };
    }
}

/// CPU time of this process so far \[s\].
pub fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
